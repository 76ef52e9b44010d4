// A device: one thread, one GL context that stays current there, and jobs that run there. The calling thread's context
// is never touched. (Saving, switching and restoring it is no alternative: glvnd refuses eglMakeCurrent while GLX is
// current on the same thread.)
#define _POSIX_C_SOURCE 200809L
#include "gl/device.h"

#include "base/clock.h"
#include "base/definition.h"
#include "base/float_mode.h"
#include "base/memory.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "base/thread_pool.h"
#include "gl/device_context.h"
#include "gl/device_def.h"
#include "gl/hand_over.h"
#include "gl/measured_costs.h"
#include "gl/reopening.h"

#include <assert.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum
{
    qc_messageSize = 512,
    // glGetError may never return GL_NO_ERROR once a context is lost.
    qc_maxGlErrors = 64,
    // Drivers compile shaders on this thread; some C libraries give threads only 128 KiB.
    qc_stackSize = 8 << 20
};

struct qcDevice
{
    qcDeviceContext context; ///< opened, used and closed by the thread
    pid_t process;           ///< the process of the thread: a child process has a copy of the device without it
    pthread_t thread;        ///< runs while the device is open
    pthread_mutex_t callers; ///< held by the caller whose job runs
    qcMeasuredCosts costs;
    qcHandOver handOver; ///< its mutex guards the fields below
    bool open, lost;
    uint32_t generation; ///< number of contexts opened
    qcReopening reopening;
    uint32_t holders; ///< the context is not closed while there are any
    qcDeviceJob* job;
    void* jobContext;
    const char* purpose;
    qcStatus status;
    char message[qc_messageSize]; ///< of the device's thread, for the caller's
};

/// The process that has opened GL contexts, or tried to; 0: none. Drivers keep threads and locks while they are loaded:
/// in a child process they would wait for threads that don't exist.
static _Atomic pid_t s_glProcess;

static bool IsInOtherProcess(const qcDevice* device)
{
    return device->process != getpid();
}

static qcStatus FailInOtherProcess(const qcDevice* device, const char* purpose)
{
    return qcFail(qc_statusDevice, "%s: the device %s belongs to process %ld, and fork() leaves it there", purpose,
                  qcDeviceKind_Name(device->context.kind), (long)device->process);
}

static qcStatus FailLost(const char* purpose)
{
    return qcFail(qc_statusDeviceLost, "%s: the GL context is lost", purpose);
}

/// Runs the posted job. `lost`: whether the context is lost afterwards.
static qcStatus RunJob(qcDevice* device, bool* lost)
{
    const struct qcGlFunctions* gl = &device->context.gl;
    gl->state->isAnswered = gl->state->hasNoErrors = false;
    qcStatus status = device->job(gl, device->jobContext);
    // A job that fails may have stopped anywhere.
    gl->state->keepBindings = gl->state->keepBindings && status == qc_statusOk;
    qcGlFunctions_ResetState(gl);

    // A driver with a thread of its own waits for that thread before it returns an error.
    bool checksErrors = !gl->state->hasNoErrors || status != qc_statusOk;
    GLenum first = checksErrors ? gl->GetError() : GL_NO_ERROR;
    GLenum next = first;
    for (int i = 0; next != GL_NO_ERROR && i < qc_maxGlErrors; ++i)
        next = gl->GetError();
    bool isAnswered = gl->state->isAnswered && status == qc_statusOk && first == GL_NO_ERROR;
    *lost = first == GL_CONTEXT_LOST ||
            (!isAnswered && gl->GetGraphicsResetStatus != NULL && gl->GetGraphicsResetStatus() != GL_NO_ERROR);
    // Before the job's status: results of a lost context are meaningless.
    if (*lost)
        return FailLost(device->purpose);
    // The job's status comes before GL's error: it is mostly closer to the cause.
    if (status != qc_statusOk && first != GL_NO_ERROR)
    {
        char message[qc_messageSize];
        snprintf(message, sizeof message, "%s", qcLastMessage());
        return qcFail(status, "%s; GL reports %s (0x%x)", message, qcGl_ErrorName(first), first);
    }
    if (status != qc_statusOk)
        return status;
    if (first != GL_NO_ERROR)
        return qcFail(qc_statusDevice, "%s: %s (0x%x)", device->purpose, qcGl_ErrorName(first), first);
    return qc_statusOk;
}

// The device's mutex is held.
static void PostResult(qcDevice* device, qcStatus status)
{
    device->status = status;
    if (status != qc_statusOk)
        snprintf(device->message, sizeof device->message, "%s", qcLastMessage());
    qcHandOver_Set(&device->handOver, qc_turnDone);
}

/// Opens a new context in place of the lost one. The device's mutex is held, but not meanwhile. `hasContext`: whether
/// one is open, in and out.
static void ReopenLost(qcDevice* device, bool* hasContext)
{
    qcHandOver_Unlock(&device->handOver);
    if (*hasContext)
        qcDeviceContext_Close(&device->context);
    qcStatus status = qcDeviceContext_OpenAgain(&device->context);
    if (status == qc_statusOk)
        qcLog("device %s: opened again after its context was lost", qcDeviceKind_Name(device->context.kind));
    else
        qcLog("device %s: not opened again: %s", qcDeviceKind_Name(device->context.kind), qcLastMessage());
    qcHandOver_Lock(&device->handOver);
    *hasContext = status == qc_statusOk;
    if (*hasContext)
    {
        // The device may be closing.
        device->lost = !device->open;
        ++device->generation;
        qcReopening_Succeed(&device->reopening, qcClock_Now());
    }
    else
        qcReopening_Fail(&device->reopening, qcClock_Now());
    if (qcHandOver_Turn(&device->handOver) == qc_turnReopen)
        qcHandOver_Set(&device->handOver, qc_turnIdle);
}

/// Runs the posted job. The device's mutex is held, but not meanwhile.
static void RunTurn(qcDevice* device)
{
    bool lost = false;
    qcHandOver_Unlock(&device->handOver);
    qcStatus status = RunJob(device, &lost);
    qcHandOver_Lock(&device->handOver);
    if (lost)
        qcReopening_Fail(&device->reopening, qcClock_Now());
    device->lost = lost;
    PostResult(device, status);
}

static void* ServeCallers(void* argument)
{
    qcDevice* device = argument;
    // A thread inherits the floating-point mode of its creator.
    (void)qcFloatMode_Begin();
    qcStatus opened = qcDeviceContext_Open(&device->context);
    bool hasContext = opened == qc_statusOk;
    qcHandOver_Lock(&device->handOver);
    if (hasContext)
    {
        device->reopening = qcReopening_Begin(device->reopening.firstPause, qcClock_Now());
        device->open = true;
        device->lost = false;
        ++device->generation;
    }
    PostResult(device, opened);
    while (opened == qc_statusOk)
    {
        qcTurn turn = qcHandOver_WaitForWork(&device->handOver);
        if (turn == qc_turnQuit)
            break;
        if (turn == qc_turnReopen)
            ReopenLost(device, &hasContext);
        else
            RunTurn(device);
    }
    qcHandOver_Unlock(&device->handOver);
    if (hasContext)
        qcDeviceContext_Close(&device->context);
    return NULL;
}

// The device's mutex is held.
static qcStatus WaitForResult(qcDevice* device)
{
    qcHandOver_WaitForResult(&device->handOver);
    return device->status;
}

/// Claims GL for this process. False, and a message: GL was opened before this process was forked.
static bool ClaimGl(qcDevice* device)
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
    // The host's signal handlers run on the host's threads.
    sigset_t all, previous;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &previous);
    bool started = pthread_create(&device->thread, &attributes, ServeCallers, device) == 0;
    pthread_sigmask(SIG_SETMASK, &previous, NULL);
    pthread_attr_destroy(&attributes);
    return started;
}

/// Whether the device's thread and its caller spin for each other: with a GPU, and cores left for the threads of loops.
/// The environment variable QC_DEVICE_WAIT (spin, sleep) decides otherwise.
static bool MaySpin(const qcDevice* device)
{
    const char* choice = getenv("QC_DEVICE_WAIT");
    if (choice != NULL && strcmp(choice, "spin") == 0)
        return true;
    if (choice != NULL && strcmp(choice, "sleep") == 0)
        return false;
    return !device->context.gpu.software && qcPool_CoreCount() > 2;
}

/// Opens the device as one kind. On failure the device's message gives the reason, and another kind may be tried.
static qcStatus OpenKind(qcDevice* device, qcDeviceKind kind)
{
    device->context.kind = kind;
    if (kind == qc_deviceNone)
        return qc_statusOk;
    qcHandOver_Begin(&device->handOver);
    if (!ClaimGl(device))
        return qc_statusDevice;
    if (!StartThread(device))
    {
        snprintf(device->message, sizeof device->message, "no thread can be started");
        return qc_statusDevice;
    }
    qcHandOver_Lock(&device->handOver);
    qcStatus status = WaitForResult(device);
    device->handOver.spins = status == qc_statusOk && MaySpin(device);
    qcHandOver_Unlock(&device->handOver);
    if (status != qc_statusOk)
        pthread_join(device->thread, NULL);
    return status;
}

static void CloseKind(qcDevice* device)
{
    qcHandOver_Lock(&device->handOver);
    bool open = device->open;
    device->open = false;
    device->lost = true;
    qcHandOver_Set(&device->handOver, qc_turnQuit);
    qcHandOver_Unlock(&device->handOver);
    if (open)
        pthread_join(device->thread, NULL);
}

static void FreeDevice(qcDevice* device)
{
    qcHandOver_Destroy(&device->handOver);
    qcMeasuredCosts_Destroy(&device->costs);
    pthread_mutex_destroy(&device->callers);
    qcFree(device, sizeof *device);
}

/// Whether the environment names one of Mesa's drivers. EGL uses both variables; OSMesa ignores the second and accepts
/// two values of the first.
static bool IsDriverNamed(void)
{
    const char* names[] = {getenv("GALLIUM_DRIVER"), getenv("MESA_LOADER_DRIVER_OVERRIDE")};
    return (names[0] != NULL && names[0][0] != 0) || (names[1] != NULL && names[1][0] != 0);
}

/// Opens the first kind that works; `none` always does.
static qcStatus OpenAuto(qcDevice* device)
{
    qcDeviceKind kinds[] = {qc_deviceEgl, qc_deviceOsmesa, qc_deviceSurfaceless, qc_deviceNone};
    if (IsDriverNamed())
    {
        kinds[1] = qc_deviceSurfaceless;
        kinds[2] = qc_deviceOsmesa;
    }
    int at = 0;
    qcStatus status = OpenKind(device, kinds[at]);
    while (status != qc_statusOk)
    {
        qcLog("device %s skipped: %s", qcDeviceKind_Name(kinds[at]), device->message);
        status = OpenKind(device, kinds[++at]);
    }
    return status;
}

qcStatus qcDevice_Create(const qcDeviceDef* given, qcDevice** result)
{
    if (given == NULL || result == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_Create: %s is null", given == NULL ? "def" : "device");
    qcDeviceDef def = qcDefaultDeviceDef();
    QC_TRY(qcDef_Take(given, QC_DEF_LAYOUT("qcDevice_Create", qcDeviceDef, kind), &def));
    QC_TRY(qcDeviceDef_Check(&def, qcDeviceKind_Name(def.kind)));
    qcDevice* device = qcAllocateZeroed(sizeof *device);
    if (device == NULL)
        return qcFailMemory(sizeof *device, "a device");
    device->process = getpid();
    pthread_mutex_init(&device->callers, NULL);
    qcMeasuredCosts_Init(&device->costs);
    qcHandOver_Init(&device->handOver);

    device->context.choice = qcDeviceDef_Choice(&def);
    qcCacheFiles_FindFolder(def.cacheFolder, device->context.cacheFolder);
    device->reopening.firstPause = qcDeviceDef_ReopenPause(&def);
    if (def.kind == qc_deviceAuto && def.shareContext != NULL)
        def.kind = def.shareDisplay != NULL ? qc_deviceEgl : qc_deviceOsmesa;
    qcStatus status = def.kind == qc_deviceAuto ? OpenAuto(device) : OpenKind(device, def.kind);
    if (status != qc_statusOk)
    {
        qcFail(status, "device %s: %s", qcDeviceKind_Name(device->context.kind), device->message);
        FreeDevice(device);
        return status;
    }
    *result = device;
    return qc_statusOk;
}

qcStatus qcDevice_Reopen(qcDevice* device)
{
    if (device == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_Reopen: device is null");
    if (device->context.kind == qc_deviceNone)
        return qc_statusOk;
    if (IsInOtherProcess(device))
        return FailInOtherProcess(device, "qcDevice_Reopen");
    pthread_mutex_lock(&device->callers);
    CloseKind(device);
    qcStatus status = OpenKind(device, device->context.kind);
    if (status != qc_statusOk)
        qcFail(status, "device %s: %s", qcDeviceKind_Name(device->context.kind), device->message);
    pthread_mutex_unlock(&device->callers);
    // Another GPU, or another driver, has other costs.
    qcMeasuredCosts_Clear(&device->costs);
    return status;
}

void qcDevice_Destroy(qcDevice* device)
{
    if (device == NULL)
        return;
    if (device->context.kind != qc_deviceNone && IsInOtherProcess(device))
    {
        // The locks can't be destroyed here: a thread of the parent may have held them. The context belongs to the
        // parent.
        qcFree(device, sizeof *device);
        return;
    }
    CloseKind(device);
    FreeDevice(device);
}

static bool IsLost(qcDevice* device)
{
    if (device->context.kind != qc_deviceNone && IsInOtherProcess(device))
        return true;
    qcHandOver_Lock(&device->handOver);
    bool lost = device->lost;
    qcHandOver_Unlock(&device->handOver);
    return lost;
}

qcStatus qcDevice_GetInfo(const qcDevice* device, qcDeviceInfo* info)
{
    if (device == NULL || info == NULL)
        return qcFail(qc_statusBadInput, "qcDevice_GetInfo: %s is null", device == NULL ? "device" : "info");
    *info = (qcDeviceInfo){.kind = device->context.kind,
                           .name = qcDeviceKind_Name(device->context.kind),
                           .renderer = device->context.gpu.renderer,
                           .version = device->context.gpu.version,
                           .vendor = device->context.gpu.vendor,
                           .maxResolution = device->context.maxResolution,
                           .software = device->context.gpu.software,
                           .compute = device->context.compute,
                           .lost = IsLost((qcDevice*)device)};
    memcpy(info->uuid, device->context.gpu.uuid, sizeof info->uuid);
    return qc_statusOk;
}

bool qcDevice_SharesContext(const qcDevice* device)
{
    return device->context.choice.shareContext != NULL;
}

uint32_t qcDevice_GetGeneration(qcDevice* device)
{
    if (IsInOtherProcess(device))
        return device->generation;
    qcHandOver_Lock(&device->handOver);
    uint32_t generation = device->generation;
    qcHandOver_Unlock(&device->handOver);
    return generation;
}

/// The mutex is held. Returns at once; the device's thread opens the new context.
static void ReopenIfDue(qcDevice* device)
{
    if (qcHandOver_Turn(&device->handOver) != qc_turnIdle || device->holders != 0 ||
        !qcReopening_IsDue(&device->reopening, qcClock_Now()))
        return;
    qcHandOver_Set(&device->handOver, qc_turnReopen);
}

/// The mutex is held. A lost device is opened again if it is time.
static bool IsLostNow(qcDevice* device)
{
    if (device->open && device->lost)
        ReopenIfDue(device);
    return !device->open || device->lost;
}

// Callers and mutex are held.
static qcStatus RunPosted(qcDevice* device, qcDeviceJob* job, void* context, const char* purpose)
{
    device->job = job;
    device->jobContext = context;
    device->purpose = purpose;
    // Threads that spin for the next loop would keep the device's thread, and software GL's, from their cores.
    qcParallel_Rest();
    qcHandOver_Set(&device->handOver, qc_turnPosted);
    qcStatus status = WaitForResult(device);
    if (status != qc_statusOk)
        qcFail(status, "%s", device->message);
    return status;
}

qcStatus qcDevice_Run(qcDevice* device, qcDeviceJob* job, void* context, const char* purpose)
{
    return qcDevice_RunIn(device, QC_ANY_GENERATION, job, context, purpose);
}

qcStatus qcDevice_RunIn(qcDevice* device, uint32_t generation, qcDeviceJob* job, void* context, const char* purpose)
{
    if (device->context.kind == qc_deviceNone)
        return qcFail(qc_statusDevice, "%s: the device none has no GL", purpose);
    if (IsInOtherProcess(device))
        return FailInOtherProcess(device, purpose);
    if (qcDeviceContext_IsExiting())
        return qcFail(qc_statusDeviceLost, "%s: the process ends", purpose);
    // A job must not run a job: it would wait for itself.
    assert(!device->open || !pthread_equal(pthread_self(), device->thread));

    pthread_mutex_lock(&device->callers);
    qcHandOver_Lock(&device->handOver);
    bool lost = IsLostNow(device);
    if (generation != QC_ANY_GENERATION && generation != device->generation)
        lost = true;
    qcStatus status = lost ? FailLost(purpose) : RunPosted(device, job, context, purpose);
    qcHandOver_Unlock(&device->handOver);
    pthread_mutex_unlock(&device->callers);
    return status;
}

qcStatus qcDevice_Hold(qcDevice* device, const char* purpose)
{
    // A device without a thread has nothing mapped: jobs fail there.
    if (device->context.kind == qc_deviceNone || IsInOtherProcess(device))
        return qc_statusOk;
    qcHandOver_Lock(&device->handOver);
    bool lost = IsLostNow(device);
    device->holders += !lost;
    if (!lost)
        qcHandOver_Alert(&device->handOver);
    qcHandOver_Unlock(&device->handOver);
    return lost ? FailLost(purpose) : qc_statusOk;
}

void qcDevice_Release(qcDevice* device)
{
    if (device->context.kind == qc_deviceNone || IsInOtherProcess(device))
        return;
    qcHandOver_Lock(&device->handOver);
    if (--device->holders == 0)
        qcHandOver_Calm(&device->handOver);
    qcHandOver_Unlock(&device->handOver);
}

bool qcDevice_FindCosts(qcDevice* device, uint32_t threads, qcPlanCosts* costs)
{
    if (!IsInOtherProcess(device))
        return qcMeasuredCosts_Find(&device->costs, threads, costs);
    *costs = (qcPlanCosts){.layersFixed = INFINITY, .layersPerTriangle = INFINITY};
    return true;
}

void qcDevice_KeepCosts(qcDevice* device, uint32_t threads, const qcPlanCosts* costs)
{
    qcMeasuredCosts_Keep(&device->costs, threads, costs);
}
