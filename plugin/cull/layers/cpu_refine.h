// CPU refinement: from the image to triangle pairs, where GL is software. It does on the CPU's vectors what the kernels
// of gl/layers from node_pairs on do on a GPU, by the same algorithm.
#ifndef QC_CULL_LAYERS_CPU_REFINE_H
#define QC_CULL_LAYERS_CPU_REFINE_H

#include "cull/layers/gpu_residency.h"
#include "kernels/pair_buffer.h"

/// Memory, retained between steps.
typedef struct qcCpuRefine
{
    const qcTriangleKernels* kernels; ///< chosen at first use
    qcArray queues;                   ///< of qcSlotPair, room for each worker
    qcArray buffers;                  ///< of qcPairBuffer
} qcCpuRefine;

typedef struct qcCpuRefineJob
{
    const qcGpuResidency* residency;
    const qcStepTriangles* triangles;
    const uint32_t* bodyOf; ///< by slot: body of the step
    const qcLayersImage* image;
    uint32_t cellsLog2[3];           ///< of the image
    float pointError, queryDistance; ///< in the frame
    float margin;                    ///< in the frame: pairs proven no further apart are near; below 0: none is
    bool testNeighbours;             ///< triangles of one body that share a vertex are candidates too
    bool listClassified;             ///< classified pairs are among the contact keys, too
    uint32_t threads;
} qcCpuRefineJob;

/// Adds keys of all triangle pairs within the query distance, in no order. `trianglePairs`: pairs with overlapping
/// boxes.
qcStatus qcCpuRefine_Run(const qcCpuRefineJob* job, qcCpuRefine* refine, const qcPairKeys* keys,
                         uint64_t* trianglePairs);
void qcCpuRefine_Free(qcCpuRefine* refine);

#endif
