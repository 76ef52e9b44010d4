// A device's programs. They live as long as the device: compiling a program takes longer than drawing with it.
#ifndef QC_GL_PROGRAMS_H
#define QC_GL_PROGRAMS_H

#include "gl/gl_functions.h"

enum
{
    // One for each kernel and each way of drawing that the library has.
    qc_maxPrograms = 32
};

struct qcGlPrograms
{
    /// For binaries that later starts take: see program_cache.h. Null or empty: none.
    const char* cacheFolder;
    /// Names the library that has opened the context: drivers of the same name and version refuse each other's
    /// binaries.
    const char* opener;
    uint32_t count;
    struct
    {
        const char* name;
        GLuint program;
    } items[qc_maxPrograms];
};

/// The program of this name (a literal), made at its first use: of a binary in the cache, or compiled. Attribute 0 is
/// `position`, attribute 1 `normal`.
qcStatus qcGlPrograms_Get(const struct qcGlFunctions* gl, const char* name, const char* vertexSource,
                          const char* fragmentSource, GLuint* program);

/// The compute program of this name (a literal), made at its first use likewise. The source is given in parts.
qcStatus qcGlPrograms_GetCompute(const struct qcGlFunctions* gl, const char* name, const char* const* sources,
                                 int sourceCount, GLuint* program);

#endif
