// The objects that a device makes in the share group of the host's context. A context takes its objects along only if
// it shares them with no other, so these are deleted when the device's context is closed. All functions run on the
// device's thread.
#ifndef QC_GL_SHARED_NAMES_H
#define QC_GL_SHARED_NAMES_H

#include "base/memory.h"
#include "gl/gl_functions.h"

typedef enum qcNameKind
{
    qc_nameBuffer,
    qc_nameTexture,
    qc_nameRenderbuffer,
    qc_nameProgram,
    qc_nameMemory, ///< GL_EXT_memory_object: after the buffers in it
    qc_nameKindCount
} qcNameKind;

typedef struct qcSharedNames
{
    qcArray names[qc_nameKindCount]; ///< GLuint: those that exist
    struct qcGlFunctions driver;     ///< without the counting
} qcSharedNames;

/// From here on the functions of the thread note which objects they make and delete. Where there is no memory for more
/// names an object stays in the share group. qc_statusOutOfMemory: the functions are as they were.
qcStatus qcSharedNames_Watch(qcSharedNames* names, struct qcGlFunctions* gl);

/// Deletes the objects that are left; the context is current. Nothing if there was no qcSharedNames_Watch.
void qcSharedNames_DeleteAll(qcSharedNames* names);

#endif
