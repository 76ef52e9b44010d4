// The compute kernels of `layers`: programs, their parameters and their dispatch. Sources: gl/layers/shaders.
#ifndef QC_GL_LAYERS_LAYERS_KERNELS_H
#define QC_GL_LAYERS_LAYERS_KERNELS_H

#include "gl/layers/layers_buffers.h"

/// In the order of the work.
typedef enum qcLayersKernel
{
    qc_kernelVertices,
    qc_kernelImageBoxes, ///< for the image only
    qc_kernelImageNodes, ///< for the image only
    qc_kernelNodes,      ///< for pairs, and all that follow
    qc_kernelNodePairs,
    qc_kernelTrianglePairs,
    qc_kernelPairTests,
    qc_kernelOrder, ///< where there are buckets
    qc_kernelCount
} qcLayersKernel;

enum
{
    qc_nodeComparers = qc_tileNodes * qc_tileNodes, ///< invocations of a workgroup of qc_kernelNodePairs
    qc_pairInvocations = 256,                       ///< of a workgroup of qc_kernelTrianglePairs
    // Pairs of nodes that such a workgroup takes at a time: few in small scenes, so that it is done in few rounds.
    qc_minNodePairs = 4,
    qc_maxNodePairs = 16,
    qc_testsOfGroup = 64,     ///< pairs of triangles that a workgroup of qc_kernelPairTests tests at a time
    qc_bucketSize = 512,      ///< pairs of triangles that a workgroup of qc_kernelOrder orders
    qc_orderInvocations = 128 ///< of such a workgroup
};

/// The uniform block of all kernels, in the layout std140. A step's data begins with it.
typedef struct qcLayersParameters
{
    uint32_t chunkCount, changedNodes, activeNodes, runNumber;
    /// Capacities of lists one less than there is room: an item that does not fit is written to the last place.
    uint32_t entryCapacity, nodePairCapacity, survivorCapacity, listWords;
    uint32_t nodesAt, chunksAt, floatsAt; ///< words of the step's data
    uint32_t nodeBoxesAt;                 ///< element of qc_workBoxes: boxes of the active nodes; for pairs
    uint32_t cellShift[3], testNeighbours;
    float scale[3], pointError;
    float slack[4];
    uint32_t axes[3];
    float queryDistance;
    uint32_t groupsAt; ///< word of the clusters' boxes in qc_workNodeBoxes
    uint32_t partsOfTile, trianglePairCapacity, nodePairsOfGroup;
    double origin[3], unit;
    uint32_t bucketCount, bucketShift, bucketsAt; ///< 0 buckets: pairs stay in no order
    uint32_t unused;
} qcLayersParameters;

typedef struct qcLayersKernels
{
    bool imageOnly;
    GLuint programs[qc_kernelCount];
    GLint foreign; ///< location in the program of qc_kernelVertices
} qcLayersKernels;

qcStatus qcLayersKernels_Create(const struct qcGlFunctions* gl, qcLayersKernels* kernels);

/// Runs a kernel with that many workgroups; at least one, so that the last kernel marks its run. `isLast`: none follows
/// before the processor has waited for it.
void qcLayersKernels_Run(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, qcLayersKernel kernel,
                         uint64_t groups, bool isLast);
/// Runs qc_kernelVertices for chunks [first, end), whose floats lie in the buffer bound to qc_sourceBinding.
void qcLayersKernels_RunForeign(const struct qcGlFunctions* gl, const qcLayersKernels* kernels, uint32_t first,
                                uint32_t end);

#endif
