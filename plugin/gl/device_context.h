// A device's GL context: which library opens it, its functions, its programs, and the GPU behind it. All functions but
// qcDeviceKind_Name and qcDeviceContext_IsExiting run on the device's thread.
#ifndef QC_GL_DEVICE_CONTEXT_H
#define QC_GL_DEVICE_CONTEXT_H

#include "gl/cache_files.h"
#include "gl/context.h"
#include "gl/gl_functions.h"
#include "gl/programs.h"
#include "gl/shared_names.h"
#include "quickcullide/device.h"

typedef struct qcDeviceContext
{
    qcDeviceKind kind;
    qcGpuChoice choice;
    char cacheFolder[qc_maxCacheFolder]; ///< of the programs' binaries; empty: none
    qcContext opened;
    struct qcGlFunctions gl;
    struct qcGlPrograms programs;
    struct qcGlState state;
    qcSharedNames shared;
    qcGpuIdentity gpu;
    uint32_t maxResolution; ///< pixels along an edge of an image
    bool compute;           ///< compute shaders are there
} qcDeviceContext;

/// "egl"; null for values that qcDeviceKind doesn't define.
const char* qcDeviceKind_Name(qcDeviceKind kind);

/// Opens a context of the kind and the choice, and leaves it current. qc_statusDevice: nothing is left open.
qcStatus qcDeviceContext_Open(qcDeviceContext* c);
/// Opens a context in place of one that is closed. qc_statusDevice: nothing is left open; there may be another GPU,
/// which is refused, since the host may hold strings of qcDeviceInfo.
qcStatus qcDeviceContext_OpenAgain(qcDeviceContext* c);
/// Nothing while the process ends: drivers' own handlers have run, or are about to.
void qcDeviceContext_Close(qcDeviceContext* c);

/// Whether the process ends: functions of drivers may crash.
bool qcDeviceContext_IsExiting(void);

#endif
