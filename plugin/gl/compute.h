// Dispatches of compute shaders, and how much of a buffer they reach.
#ifndef QC_GL_COMPUTE_H
#define QC_GL_COMPUTE_H

#include "gl/gl_functions.h"

enum
{
    qc_groupsInRow = 1 << 15 ///< workgroups of a dispatch along x
};

/// Starts at least `groups` workgroups: whole rows, if there are several. Returns how many.
static inline uint32_t qcGl_Dispatch(const struct qcGlFunctions* gl, uint64_t groups)
{
    uint64_t rows = (groups + qc_groupsInRow - 1) / qc_groupsInRow;
    uint64_t inRow = groups < qc_groupsInRow ? groups : qc_groupsInRow;
    if (groups > 0)
        qcGl_Counted(gl)->DispatchCompute((GLuint)inRow, (GLuint)rows, 1);
    return (uint32_t)(inRow * rows);
}

/// Bytes of a buffer that a kernel reaches. 64 bits: the limits of some GPUs are 2^31 and more.
static inline uint64_t qcGl_MaxStorageBytes(const struct qcGlFunctions* gl)
{
    GLint64 bytes = 0;
    gl->GetInteger64v(GL_MAX_SHADER_STORAGE_BLOCK_SIZE, &bytes);
    return bytes > 0 ? (uint64_t)bytes : 0;
}

#endif
