// A device: one thread, one GL context that is current there for good, and jobs that are handed over.
// The calling thread's context is thus never touched. (Saving, switching and restoring it could not keep that
// promise: glvnd refuses eglMakeCurrent while GLX is current on the same thread.)
#define _POSIX_C_SOURCE 200809L
#include "gl/device.h"

#include "float_mode.h"
#include "gl/context.h"
#include "memory.h"
#include "status.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum
{
    qc_messageSize = 512,
    // glGetError can go on for ever once a context is lost.
    qc_maxGlErrors = 64,
    // Drivers compile shaders here; some C libraries give threads only 128 KiB.
    qc_stackSize = 8 << 20,
    // Numbers of threads that one process uses with one device.
    qc_keptCosts = 8
};

typedef struct KeptCosts
{
    uint32_t threads; ///< 0: none
    qcPlanCosts costs;
} KeptCosts;

typedef enum TurnState
{
    turn_idle,
    turn_posted, ///< the thread has a job to do
    turn_done,   ///< the caller has a result to fetch
    turn_quit
} TurnState;

struct qcDevice
{
    qcDeviceKind kind;
    qcContext context;
    struct qcGlTable gl;
    struct qcGlPrograms programs;
    char renderer[128], version[128];
    uint32_t maxResolution;
    bool software;
    bool lost; ///< of the thread

    pid_t process; ///< where the thread is: a child process has a copy of the device without it
    pthread_t thread;
    pthread_mutex_t callers; ///< held by the one caller that is being served
    KeptCosts costs[qc_keptCosts];
    pthread_mutex_t costsMutex; ///< guards them
    pthread_mutex_t mutex;      ///< guards the rest
    pthread_cond_t changed;
    TurnState turn;
    qcDeviceJob* job;
    void* jobContext;
    const char* purpose;
    qcStatus status;
    char message[qc_messageSize]; ///< messages are kept per thread: this one crosses over
};

static const struct
{
    const char* name;
    qcOpenContext* open;
    qcCloseContext* close;
} s_kinds[] = {
    [qc_deviceAuto] = {"auto", NULL, NULL},
    [qc_deviceEgl] = {"egl", qcOpenEglContext, qcCloseEglContext},
    [qc_deviceOsmesa] = {"osmesa", qcOpenOsmesaContext, qcCloseOsmesaContext},
    [qc_deviceSurfaceless] = {"surfaceless", qcOpenSurfacelessContext, qcCloseEglContext},
    [qc_deviceNone] = {"none", NULL, NULL},
};

/// The process that has opened GL contexts, or tried to; 0: none. Drivers keep threads and locks as long as they are
/// loaded: in a child process they wait for threads that aren't there.
static _Atomic pid_t s_glProcess;

static bool IsInOtherProcess(const qcDevice* device)
{
    return device->process != getpid();
}

bool qcIsSoftwareRenderer(const char* renderer)
{
    static const char* const names[] = {"llvmpipe", "softpipe", "swrast", "Software Rasterizer", "SwiftShader"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i)
    {
        if (strstr(renderer, names[i]) != NULL)
            return true;
    }
    return false;
}

static const char* GlErrorName(GLenum error)
{
    switch (error)
    {
        case GL_INVALID_ENUM: return "GL_INVALID_ENUM";
        case GL_INVALID_VALUE: return "GL_INVALID_VALUE";
        case GL_INVALID_OPERATION: return "GL_INVALID_OPERATION";
        case GL_INVALID_FRAMEBUFFER_OPERATION: return "GL_INVALID_FRAMEBUFFER_OPERATION";
        case GL_OUT_OF_MEMORY: return "GL_OUT_OF_MEMORY";
        case GL_CONTEXT_LOST: return "GL_CONTEXT_LOST";
        default: return "a GL error";
    }
}

static qcStatus DescribeContext(qcDevice* device)
{
    const struct qcGlTable* gl = &device->gl;
    const char* renderer = (const char*)gl->GetString(GL_RENDERER);
    const char* version = (const char*)gl->GetString(GL_VERSION);
    if (renderer == NULL || version == NULL)
        return qcFail(qc_statusDevice, "the GL context does not say its renderer");
    snprintf(device->renderer, sizeof device->renderer, "%s", renderer);
    snprintf(device->version, sizeof device->version, "%s", version);
    device->software = qcIsSoftwareRenderer(renderer);

    GLint renderbufferSize = 0, viewport[2] = {0, 0};
    gl->GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbufferSize);
    gl->GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    GLint smallest = viewport[0] < viewport[1] ? viewport[0] : viewport[1];
    if (smallest > renderbufferSize)
        smallest = renderbufferSize;
    device->maxResolution = smallest > 0 ? (uint32_t)smallest : 0;
    return qc_statusOk;
}

static qcStatus OpenContext(qcDevice* device)
{
    QC_TRY(s_kinds[device->kind].open(&device->context));
    device->gl.programs = &device->programs;
    qcStatus status = qcGlTable_Load(&device->gl, device->context.getFunction);
    if (status == qc_statusOk)
        status = DescribeContext(device);
    if (status != qc_statusOk)
        s_kinds[device->kind].close(&device->context);
    return status;
}

static qcStatus RunJob(qcDevice* device)
{
    const struct qcGlTable* gl = &device->gl;
    if (device->lost)
        return qcFail(qc_statusDevice, "%s: the GL context was lost", device->purpose);
    qcStatus status = device->job(gl, device->jobContext);
    qcGlTable_ResetState(gl);

    GLenum first = gl->GetError();
    GLenum next = first;
    for (int i = 0; next != GL_NO_ERROR && i < qc_maxGlErrors; ++i)
        next = gl->GetError();
    device->lost =
        first == GL_CONTEXT_LOST || (gl->GetGraphicsResetStatus != NULL && gl->GetGraphicsResetStatus() != GL_NO_ERROR);
    // What the job says of itself is nearer to the cause.
    if (status != qc_statusOk)
        return status;
    if (device->lost)
        return qcFail(qc_statusDevice, "%s: the GL context was lost", device->purpose);
    if (first != GL_NO_ERROR)
        return qcFail(qc_statusDevice, "%s: %s (0x%x)", device->purpose, GlErrorName(first), first);
    return qc_statusOk;
}

// The device's mutex is held.
static void Answer(qcDevice* device, qcStatus status)
{
    device->status = status;
    if (status != qc_statusOk)
        snprintf(device->message, sizeof device->message, "%s", qcLastMessage());
    device->turn = turn_done;
    pthread_cond_broadcast(&device->changed);
}

static void* ServeCallers(void* argument)
{
    qcDevice* device = argument;
    // A thread begins in the mode of the one that started it.
    (void)qcFloatMode_Begin();
    qcStatus opened = OpenContext(device);
    pthread_mutex_lock(&device->mutex);
    Answer(device, opened);
    while (opened == qc_statusOk)
    {
        while (device->turn != turn_posted && device->turn != turn_quit)
            pthread_cond_wait(&device->changed, &device->mutex);
        if (device->turn == turn_quit)
            break;
        pthread_mutex_unlock(&device->mutex);
        qcStatus status = RunJob(device);
        pthread_mutex_lock(&device->mutex);
        Answer(device, status);
    }
    pthread_mutex_unlock(&device->mutex);
    if (opened == qc_statusOk)
        s_kinds[device->kind].close(&device->context);
    return NULL;
}

// The device's mutex is held.
static qcStatus WaitForAnswer(qcDevice* device)
{
    while (device->turn != turn_done)
        pthread_cond_wait(&device->changed, &device->mutex);
    device->turn = turn_idle;
    return device->status;
}

/// False, and a message: GL was opened before this process was forked.
static bool TakeGl(qcDevice* device)
{
    pid_t first = 0;
    if (atomic_compare_exchange_strong(&s_glProcess, &first, device->process) || first == device->process)
        return true;
    snprintf(device->message, sizeof device->message,
             "process %ld has opened GL before fork(); GL's threads are not in this process, %ld", (long)first,
             (long)device->process);
    return false;
}

static bool StartThread(qcDevice* device)
{
    pthread_attr_t attributes;
    if (pthread_attr_init(&attributes) != 0)
        return false;
    pthread_attr_setstacksize(&attributes, qc_stackSize);
    // The host's signal handlers stay on the host's threads.
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    bool started = pthread_create(&device->thread, &attributes, ServeCallers, device) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    pthread_attr_destroy(&attributes);
    return started;
}

/// Opens the device as one kind; on failure the device's message says why, and another kind may be tried.
static qcStatus OpenKind(qcDevice* device, qcDeviceKind kind)
{
    device->kind = kind;
    if (kind == qc_deviceNone)
        return qc_statusOk;
    device->turn = turn_idle;
    if (!TakeGl(device))
        return qc_statusDevice;
    if (!StartThread(device))
    {
        snprintf(device->message, sizeof device->message, "no thread can be started");
        return qc_statusDevice;
    }
    pthread_mutex_lock(&device->mutex);
    qcStatus status = WaitForAnswer(device);
    pthread_mutex_unlock(&device->mutex);
    if (status != qc_statusOk)
        pthread_join(device->thread, NULL);
    return status;
}

static void FreeDevice(qcDevice* device)
{
    pthread_cond_destroy(&device->changed);
    pthread_mutex_destroy(&device->mutex);
    pthread_mutex_destroy(&device->costsMutex);
    pthread_mutex_destroy(&device->callers);
    qcFree(device, sizeof *device);
}

qcStatus qcDevice_Create(const qcDeviceDef* def, qcDevice** result)
{
    if (def == NULL || result == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_Create: %s is null", def == NULL ? "def" : "device");
    if (def->structSize != sizeof(qcDeviceDef))
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->structSize is %u, not %zu", def->structSize,
                      sizeof(qcDeviceDef));
    if ((unsigned)def->kind > qc_deviceNone)
        return qcFail(qc_statusBadInput, "qcDevice_Create: def->kind is %d", (int)def->kind);

    qcDevice* device = qcAllocateZeroed(sizeof *device);
    if (device == NULL)
        return qcFailMemory(sizeof *device, "a device");
    device->process = getpid();
    pthread_mutex_init(&device->callers, NULL);
    pthread_mutex_init(&device->mutex, NULL);
    pthread_mutex_init(&device->costsMutex, NULL);
    pthread_cond_init(&device->changed, NULL);

    qcDeviceKind kind = def->kind == qc_deviceAuto ? qc_deviceEgl : def->kind;
    qcStatus status = OpenKind(device, kind);
    while (status != qc_statusOk && def->kind == qc_deviceAuto)
    {
        qcLog("device %s skipped: %s", s_kinds[kind].name, device->message);
        kind = (qcDeviceKind)(kind + 1);
        status = OpenKind(device, kind);
    }
    if (status != qc_statusOk)
    {
        qcFail(status, "device %s: %s", s_kinds[kind].name, device->message);
        FreeDevice(device);
        return status;
    }
    *result = device;
    return qc_statusOk;
}

void qcDevice_Destroy(qcDevice* device)
{
    if (device == NULL)
        return;
    if (device->kind != qc_deviceNone && IsInOtherProcess(device))
    {
        // Another thread of the parent may have held the locks: they can't be destroyed here. The context is the
        // parent's.
        qcFree(device, sizeof *device);
        return;
    }
    if (device->kind != qc_deviceNone)
    {
        pthread_mutex_lock(&device->mutex);
        device->turn = turn_quit;
        pthread_cond_broadcast(&device->changed);
        pthread_mutex_unlock(&device->mutex);
        pthread_join(device->thread, NULL);
    }
    FreeDevice(device);
}

qcStatus qcDevice_GetInfo(const qcDevice* device, qcDeviceInfo* info)
{
    if (device == NULL || info == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_GetInfo: %s is null", device == NULL ? "device" : "info");
    *info = (qcDeviceInfo){.kind = device->kind,
                           .name = s_kinds[device->kind].name,
                           .renderer = device->renderer,
                           .version = device->version,
                           .maxResolution = device->maxResolution,
                           .software = device->software,
                           .compute = device->gl.DispatchCompute != NULL};
    return qc_statusOk;
}

qcStatus qcDevice_Run(qcDevice* device, qcDeviceJob* job, void* context, const char* purpose)
{
    if (device->kind == qc_deviceNone)
        return qcFail(qc_statusDevice, "%s: the device none has no GL", purpose);
    if (IsInOtherProcess(device))
        return qcFail(qc_statusDevice, "%s: the device %s belongs to process %ld, and fork() leaves it there", purpose,
                      s_kinds[device->kind].name, (long)device->process);
    // A job that runs a job would wait for itself.
    assert(!pthread_equal(pthread_self(), device->thread));

    pthread_mutex_lock(&device->callers);
    pthread_mutex_lock(&device->mutex);
    device->job = job;
    device->jobContext = context;
    device->purpose = purpose;
    device->turn = turn_posted;
    pthread_cond_broadcast(&device->changed);
    qcStatus status = WaitForAnswer(device);
    if (status != qc_statusOk)
        qcFail(status, "%s", device->message);
    pthread_mutex_unlock(&device->mutex);
    pthread_mutex_unlock(&device->callers);
    return status;
}

bool qcDevice_FindCosts(qcDevice* device, uint32_t threads, qcPlanCosts* costs)
{
    bool found = false;
    if (IsInOtherProcess(device))
    {
        *costs = (qcPlanCosts){.layersFixed = INFINITY, .layersPerTriangle = INFINITY};
        return true;
    }
    pthread_mutex_lock(&device->costsMutex);
    for (int i = 0; i < qc_keptCosts && !found; i++)
    {
        found = device->costs[i].threads == threads;
        if (found)
            *costs = device->costs[i].costs;
    }
    pthread_mutex_unlock(&device->costsMutex);
    return found;
}

void qcDevice_KeepCosts(qcDevice* device, uint32_t threads, const qcPlanCosts* costs)
{
    pthread_mutex_lock(&device->costsMutex);
    int place = 0;
    while (place < qc_keptCosts - 1 && device->costs[place].threads != 0 && device->costs[place].threads != threads)
        place++;
    device->costs[place] = (KeptCosts){threads, *costs};
    pthread_mutex_unlock(&device->costsMutex);
}
