// Pairs of adjacent triangles (sharing a vertex) of one body, for contacts between their other features. Pairs without
// such contacts are left out where that is proven.
#ifndef QC_SWEEP_BVH_ADJACENT_PAIRS_H
#define QC_SWEEP_BVH_ADJACENT_PAIRS_H

#include "sweep/bvh/body_bvh.h"

/// Takes pairs of slots, in no order.
typedef void qcAdjacentPairsFunction(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker);

typedef struct qcAdjacentPairsJob
{
    const qcTriangleKernels* kernels;
    qcBodyBvh* body; ///< fitted with the margin
    uint32_t threads;
    qcAdjacentPairsFunction* function;
    void* context;
} qcAdjacentPairsJob;

/// Finds, each once, at least all pairs of adjacent triangles with two features (vertices, edges, faces) that have no
/// common vertex and are within the margin of the fit. O(triangles + pairs around vertices whose fan isn't separated).
qcStatus qcAdjacentPairs_Find(const qcAdjacentPairsJob* job);

#endif
