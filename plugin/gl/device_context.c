// Opening, identity and limits of a device's context, and the end of the process.
#define _POSIX_C_SOURCE 200809L
#include "gl/device_context.h"

#include "base/status.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

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

const char* qcDeviceKind_Name(qcDeviceKind kind)
{
    return (unsigned)kind < sizeof s_kinds / sizeof s_kinds[0] ? s_kinds[kind].name : NULL;
}

static atomic_bool s_isExiting;
static pthread_once_t s_watchExit = PTHREAD_ONCE_INIT;

static void NoteExit(void)
{
    atomic_store(&s_isExiting, true);
}

static void WatchExit(void)
{
    (void)atexit(NoteExit);
}

bool qcDeviceContext_IsExiting(void)
{
    return atomic_load(&s_isExiting);
}

void qcDeviceContext_Close(qcDeviceContext* c)
{
    if (qcDeviceContext_IsExiting())
        return;
    qcSharedNames_DeleteAll(&c->shared);
    s_kinds[c->kind].close(&c->opened);
}

/// Opens a context and finds its identity. On failure none is open.
static qcStatus Open(qcDeviceContext* c, qcGpuIdentity* gpu)
{
    QC_TRY(s_kinds[c->kind].open(&c->choice, &c->opened));
    // After the driver has registered its handlers: they run after later ones.
    pthread_once(&s_watchExit, WatchExit);
    c->gl = (struct qcGlFunctions){.programs = &c->programs, .state = &c->state};
    c->state = (struct qcGlState){0};
    c->programs = (struct qcGlPrograms){.cacheFolder = c->cacheFolder, .opener = s_kinds[c->kind].name};
    qcStatus status = qcGlFunctions_Load(&c->gl, c->opened.getFunction);
    if (status == qc_statusOk && c->choice.shareContext != NULL)
        status = qcSharedNames_Watch(&c->shared, &c->gl);
    if (status == qc_statusOk)
        status = qcContext_Identify(&c->opened, gpu);
    if (status != qc_statusOk)
        qcDeviceContext_Close(c);
    return status;
}

static void ReadLimits(qcDeviceContext* c)
{
    const struct qcGlFunctions* gl = &c->gl;
    GLint renderbufferSize = 0, viewport[2] = {0, 0};
    gl->GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbufferSize);
    gl->GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
    GLint smallest = viewport[0] < viewport[1] ? viewport[0] : viewport[1];
    if (smallest > renderbufferSize)
        smallest = renderbufferSize;
    c->maxResolution = smallest > 0 ? (uint32_t)smallest : 0;
    c->compute = gl->DispatchCompute != NULL;
}

qcStatus qcDeviceContext_Open(qcDeviceContext* c)
{
    QC_TRY(Open(c, &c->gpu));
    ReadLimits(c);
    return qc_statusOk;
}

qcStatus qcDeviceContext_OpenAgain(qcDeviceContext* c)
{
    qcGpuIdentity gpu = {.software = false};
    QC_TRY(Open(c, &gpu));
    if (strcmp(gpu.renderer, c->gpu.renderer) == 0 && strcmp(gpu.version, c->gpu.version) == 0 &&
        strcmp(gpu.vendor, c->gpu.vendor) == 0 && memcmp(gpu.uuid, c->gpu.uuid, sizeof gpu.uuid) == 0)
        return qc_statusOk;
    qcDeviceContext_Close(c);
    return qcFail(qc_statusDevice, "in place of %s there is %s", c->gpu.renderer, gpu.renderer);
}
