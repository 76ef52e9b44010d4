// Binaries of programs in files, so that a later start need not compile them. A binary is used only where the driver
// and the whole source are those it was made of. No failure of the disk, of a file or of the driver is reported: the
// program is then compiled from its source.
#ifndef QC_GL_PROGRAM_CACHE_H
#define QC_GL_PROGRAM_CACHE_H

#include "base/memory.h"
#include "gl/gl_functions.h"

/// A shader's source, in parts.
typedef struct qcShaderSource
{
    GLenum stage;
    const char* const* parts;
    int partCount;
} qcShaderSource;

/// All that a binary depends on, as one text.
typedef struct qcProgramKey
{
    const char* folder; ///< null: there is no cache, or the driver has no binaries
    qcArray text;       ///< of bytes
} qcProgramKey;

/// Free the key in any case. qc_statusDevice: GL has an error from an earlier call.
qcStatus qcProgramKey_Make(const struct qcGlFunctions* gl, const char* name, const qcShaderSource* sources,
                           int sourceCount, qcProgramKey* key);
void qcProgramKey_Free(qcProgramKey* key);

/// The linked program of a key from its binary; 0: there is none, or it is refused.
GLuint qcProgramCache_Load(const struct qcGlFunctions* gl, const qcProgramKey* key);
/// Before a program is linked whose binary will be stored.
void qcProgramCache_Announce(const struct qcGlFunctions* gl, const qcProgramKey* key, GLuint program);
/// Stores the binary of a linked program.
void qcProgramCache_Store(const struct qcGlFunctions* gl, const qcProgramKey* key, GLuint program);

#endif
