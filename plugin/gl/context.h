// A GL context on the calling thread: what device.c asks of a platform.
#ifndef QC_PLUGIN_GL_CONTEXT_H
#define QC_PLUGIN_GL_CONTEXT_H

#include "gl/table.h"

typedef struct qcContext
{
    qcGlGetFunction* getFunction;
    void* display; ///< EGLDisplay; null for OSMesa
    void* handle;  ///< EGLContext or OSMesaContext
} qcContext;

/// Opens a context, GL 4.5 core or else 3.3 core, and leaves it current on the calling thread.
/// qc_statusDevice: nothing is left open; the message says why.
typedef qcStatus qcOpenContext(qcContext* context);
/// Closes it on the thread that opened it.
typedef void qcCloseContext(qcContext* context);

/// A hardware GPU through EGL's device platform.
qcOpenContext qcOpenEglContext;
/// EGL's surfaceless platform.
qcOpenContext qcOpenSurfacelessContext;
qcCloseContext qcCloseEglContext;

qcOpenContext qcOpenOsmesaContext;
qcCloseContext qcCloseOsmesaContext;

/// Whether a GL_RENDERER draws on the CPU.
bool qcIsSoftwareRenderer(const char* renderer);

#endif
