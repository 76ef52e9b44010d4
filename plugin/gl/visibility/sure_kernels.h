// Sure results found by compute shaders: what sure_results.c does on the processor, for GPUs.
#ifndef QC_GL_VISIBILITY_SURE_KERNELS_H
#define QC_GL_VISIBILITY_SURE_KERNELS_H

#include "gl/gl_functions.h"
#include "gl/visibility/sure_results.h"

enum
{
    qc_sureKernelCount = 4,
    qc_sureBufferCount = 6
};

/// GL objects, and memory retained between passes. All zero at first.
typedef struct qcSureKernels
{
    GLuint programs[qc_sureKernelCount];
    GLuint buffers[qc_sureBufferCount];
    size_t bytes[qc_sureBufferCount]; ///< of each buffer
    size_t maxBytes;                  ///< of a buffer for shaders
    uint32_t runNumber;               ///< of the last pass
    qcArray parts;                    ///< of the pass
    qcArray found;                    ///< uint32_t: three counters, then of each part of the pass the qcSureFound
} qcSureKernels;

bool qcSureKernels_AreSupported(const struct qcGlFunctions* gl);
qcStatus qcSureKernels_Create(const struct qcGlFunctions* gl, qcSureKernels* kernels);
void qcSureKernels_Delete(const struct qcGlFunctions* gl, const qcSureKernels* kernels);
void qcSureKernels_Free(qcSureKernels* kernels);

/// Finds what is sure of a pass and waits for it. `corners`: a buffer with nine floats a triangle. `found`: of each
/// triangle of each step that takes part, see qcSureResults_Take; null: there is no room for that many.
qcStatus qcSureKernels_Find(const struct qcGlFunctions* gl, qcSureKernels* kernels, const qcSureView* view,
                            GLuint corners, const qcVisibilityStep* steps, uint32_t stepCount, const uint32_t** found);

#endif
