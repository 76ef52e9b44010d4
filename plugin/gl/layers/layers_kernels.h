// The compute kernels of `layers`: programs, their uniforms and their dispatch. Sources: gl/layers/shaders.
#ifndef QC_GL_LAYERS_LAYERS_KERNELS_H
#define QC_GL_LAYERS_LAYERS_KERNELS_H

#include "gl/layers/layers_buffers.h"

/// In the order of the work. From qc_kernelNodePairs on a kernel has one invocation per item of a list.
typedef enum qcLayersKernel
{
    qc_kernelVertices,
    qc_kernelBoxes,
    qc_kernelNodes,
    qc_kernelNodePairs,
    qc_kernelClusterPairs,
    qc_kernelTrianglePairs,
    qc_kernelFilter,
    qc_kernelCount
} qcLayersKernel;

enum
{
    qc_groupsInRow = 1 << 15 ///< workgroups of a dispatch along x
};

typedef struct qcLayersUniforms
{
    uint32_t chunkCount, nodeCount;
    /// One less than the capacity of each list: see WRITE_BITS in common.glsl.
    uint32_t entryCapacity, nodePairCapacity, clusterPairCapacity, trianglePairCapacity, survivorCapacity;
    uint32_t testNeighbours, runNumber;
    uint32_t cellShift[3];
    float scale[3], slack[4];
    float pointError, queryDistance;
} qcLayersUniforms;

enum
{
    qc_uniformCount = 14
};

typedef struct qcLayersKernels
{
    bool imageOnly; ///< kernels up to qc_kernelNodes, which make the image
    GLuint programs[qc_kernelCount];
    GLint uniforms[qc_kernelCount][qc_uniformCount]; ///< locations; below 0: the kernel has none
} qcLayersKernels;

qcStatus qcLayersKernels_Create(const struct qcGlFunctions* gl, qcLayersKernels* kernels);

/// Runs a kernel with one invocation per item, or more; at least one workgroup, so that the last kernel marks its run.
void qcLayersKernels_Run(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, const qcLayersBuffers* b,
                         qcLayersKernel kernel, const qcLayersUniforms* values, uint64_t items);
/// Runs a kernel whose workgroup counts lie in the bound GL_DISPATCH_INDIRECT_BUFFER at `offset`.
void qcLayersKernels_RunIndirect(const struct qcGlFunctions* gl, const qcLayersKernels* kernels,
                                 const qcLayersBuffers* b, qcLayersKernel kernel, const qcLayersUniforms* values,
                                 size_t offset);

#endif
