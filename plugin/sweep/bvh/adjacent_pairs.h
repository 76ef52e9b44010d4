// Pairs of triangles of one surface that share a vertex, for contacts between their other features: those that are not
// known to be without.
#ifndef QC_SWEEP_BVH_ADJACENT_PAIRS_H
#define QC_SWEEP_BVH_ADJACENT_PAIRS_H

#include "sweep/bvh/triangle_bvh.h"

/// Takes pairs of places, in no order.
typedef void qcSurfaceNeighboursFunction(void* context, const qcPlacePair* pairs, size_t count, uint32_t worker);

typedef struct qcSurfaceNeighboursJob
{
    const qcSurfaceKernels* kernels;
    qcSurface* surface; ///< fitted with the margin
    uint32_t threads;
    qcSurfaceNeighboursFunction* function;
    void* context;
} qcSurfaceNeighboursJob;

/// Finds, each once, at least all pairs with features (vertices, edges, triangles) that have no vertex in common and
/// are within the surface's margin of each other. O(triangles + pairs around vertices whose star is not quiet).
qcStatus qcSurfaceNeighbours_Find(const qcSurfaceNeighboursJob* job);

#endif
