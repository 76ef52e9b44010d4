// Pairs of triangles of one surface that share a vertex, for contacts between their other features: those that are not
// known to be without.
#ifndef QC_SWEEP_BVH_ADJACENT_PAIRS_H
#define QC_SWEEP_BVH_ADJACENT_PAIRS_H

#include "sweep/bvh/triangle_bvh.h"

/// Takes pairs of places, in no order.
typedef void qcAdjacentPairsFunction(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker);

typedef struct qcAdjacentPairsJob
{
    const qcTriangleKernels* kernels;
    qcTriangleBvh* surface; ///< fitted with the margin
    uint32_t threads;
    qcAdjacentPairsFunction* function;
    void* context;
} qcAdjacentPairsJob;

/// Finds, each once, at least all pairs with features (vertices, edges, triangles) that have no vertex in common and
/// are within the surface's margin of each other. O(triangles + pairs around vertices whose star is not quiet).
qcStatus qcAdjacentPairs_Find(const qcAdjacentPairsJob* job);

#endif
