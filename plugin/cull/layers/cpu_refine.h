// Pairs of nodes from the device to pairs of triangles, by the processor's vectors: what the kernels of gl/layers.c
// after node_pairs do on a GPU, for devices that are the processor itself.
#ifndef QC_CULL_LAYERS_CPU_REFINE_H
#define QC_CULL_LAYERS_CPU_REFINE_H

#include "cull/layers/gpu_residency.h"
#include "kernels/pair_buffer.h"

/// Memory that is kept between steps.
typedef struct qcLayersRefine
{
    const qcTriangleKernels* kernels; ///< chosen at first use
    qcArray queues;                   ///< of qcSlotPair, room for each worker
    qcArray sinks;                    ///< of qcPairBuffer
} qcLayersRefine;

typedef struct qcLayersRefineJob
{
    const qcLayersBodies* bodies;
    const qcStepTriangles* triangles;
    const uint32_t* numberOf; ///< by slot: body of the step
    const qcLayersImage* image;
    uint32_t cellsLog2[3];   ///< of the image
    float pointError, reach; ///< in the frame
    float margin;            ///< in the frame, as in qcDistanceThresholds
    bool testNeighbours;     ///< triangles of one body that share a vertex are candidates too
    bool listKnown;          ///< pairs that surely penetrate are among the contact keys, too
    uint32_t threads;
} qcLayersRefineJob;

/// Adds keys of pairs of triangles that may be within reach, in no order; `trianglePairs`: how many boxes met.
qcStatus qcLayersRefine_Run(qcLayersRefine* refine, const qcLayersRefineJob* job, const qcPairKeys* keys,
                            uint64_t* trianglePairs);
void qcLayersRefine_Free(qcLayersRefine* refine);

#endif
