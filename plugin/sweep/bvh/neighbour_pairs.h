// Pairs of neighbours (triangles of one body that share a vertex), for contacts between their other features. Pairs
// without such contacts are left out where that is proven.
#ifndef QC_SWEEP_BVH_NEIGHBOUR_PAIRS_H
#define QC_SWEEP_BVH_NEIGHBOUR_PAIRS_H

#include "sweep/bvh/body_bvh.h"

/// Takes pairs of slots, in no order.
typedef void qcNeighbourPairsFunction(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker);

typedef struct qcNeighbourPairsJob
{
    const qcTriangleKernels* kernels;
    qcBodyBvh* body; ///< fitted with the margin
    uint32_t threads;
    qcNeighbourPairsFunction* function;
    void* context;
} qcNeighbourPairsJob;

/// Finds, each once, at least all pairs of neighbours with two features (vertices, edges, faces) that have no
/// common vertex and are within the margin of the fit. O(triangles + pairs around vertices whose fan isn't separated).
qcStatus qcNeighbourPairs_Find(const qcNeighbourPairsJob* job);

#endif
