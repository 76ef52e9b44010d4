// A GL context on the calling thread: the interface of device_context.c to EGL and OSMesa.
#ifndef QC_GL_CONTEXT_H
#define QC_GL_CONTEXT_H

#include "gl/gl_functions.h"

/// The requested GPU, or the context to share objects with: see qcDeviceDef.
typedef struct qcGpuChoice
{
    int32_t index; ///< -1: any
    char name[128];
    bool hasUuid;
    uint8_t uuid[16];
    void *shareDisplay, *shareContext; ///< null: none
} qcGpuChoice;

/// The renderer that the driver reports.
typedef struct qcGpuIdentity
{
    char renderer[128], version[128], vendor[128]; ///< GL_RENDERER, GL_VERSION, GL_VENDOR
    uint8_t uuid[16];                              ///< all 0: not reported
    bool software;
} qcGpuIdentity;

typedef struct qcContext
{
    qcGlGetFunction* getFunction;
    void* display; ///< EGLDisplay; null for OSMesa
    void* handle;  ///< EGLContext or OSMesaContext
} qcContext;

/// Opens a context, GL 4.5 core or else 3.3 core, and leaves it current on the calling thread.
/// qc_statusDevice: nothing is left open; the message names the reason. Only EGL's device platform chooses a GPU.
typedef qcStatus qcOpenContext(const qcGpuChoice* choice, qcContext* context);
/// Closes a context, on the thread that opened it.
typedef void qcCloseContext(qcContext* context);

/// A GPU through EGL's device platform.
qcOpenContext qcOpenEglContext;
/// EGL's surfaceless platform.
qcOpenContext qcOpenSurfacelessContext;
qcCloseContext qcCloseEglContext;

qcOpenContext qcOpenOsmesaContext;
qcCloseContext qcCloseOsmesaContext;

/// Reads the identity of the current context. qc_statusDevice: the driver reports no renderer.
qcStatus qcContext_Identify(const qcContext* context, qcGpuIdentity* identity);

#endif
