// The compute kernels of `layers`: programs, their parameters and their dispatch. Sources: gl/layers/shaders.
#ifndef QC_GL_LAYERS_LAYERS_KERNELS_H
#define QC_GL_LAYERS_LAYERS_KERNELS_H

#include "gl/layers/layers_buffers.h"

/// In the order of the work. qc_kernelNodePairs and the next have a workgroup or an invocation per item of a list.
typedef enum qcLayersKernel
{
    qc_kernelVertices,
    qc_kernelImageBoxes, ///< for the image only
    qc_kernelImageNodes, ///< for the image only
    qc_kernelNodes,      ///< for pairs, and all that follow
    qc_kernelNodePairs,
    qc_kernelTrianglePairs,
    qc_kernelCount
} qcLayersKernel;

enum
{
    qc_groupsInRow = 1 << 15 ///< workgroups of a dispatch along x
};

/// The uniform block of all kernels, in the layout std140.
typedef struct qcLayersParameters
{
    uint32_t chunkCount, changedNodes, activeNodes, runNumber;
    /// Capacities of lists one less than there is room: an item that does not fit is written to the last place.
    uint32_t entryCapacity, nodePairCapacity, survivorCapacity, cellCount;
    uint32_t bodiesAt, nodesAt, chunksAt, floatsAt; ///< words of the step's data in the stream
    uint32_t cellShift[3], testNeighbours;
    float scale[3], pointError;
    float slack[4];
    uint32_t axes[3];
    float queryDistance;
    uint32_t groupsAt, unused[3]; ///< word of the clusters' boxes in qc_workNodeBoxes
    double origin[3], unit;
} qcLayersParameters;

typedef struct qcLayersKernels
{
    bool imageOnly;
    GLuint programs[qc_kernelCount];
    GLint foreign; ///< location in the program of qc_kernelVertices
} qcLayersKernels;

qcStatus qcLayersKernels_Create(const struct qcGlFunctions* gl, qcLayersKernels* kernels, const qcLayersBuffers* b);

/// Runs a kernel with that many workgroups; at least one, so that the last kernel marks its run.
void qcLayersKernels_Run(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, qcLayersKernel kernel,
                         uint64_t groups);
/// Runs a kernel whose workgroup counts lie in the bound GL_DISPATCH_INDIRECT_BUFFER at `offset`.
void qcLayersKernels_RunIndirect(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, qcLayersKernel kernel,
                                 size_t offset);
/// Runs qc_kernelVertices for chunks [first, end), whose floats lie in the buffer bound to storage block 3.
void qcLayersKernels_RunForeign(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, uint32_t first,
                                uint32_t end);

#endif
