// Pairs of triangles whose boxes overlap and that no axis separates: of a surface with itself, or of two.
#ifndef QC_SWEEP_BVH_BVH_PAIRS_H
#define QC_SWEEP_BVH_BVH_PAIRS_H

#include "kernels/pair_filter.h"
#include "sweep/bvh/triangle_bvh.h"

/// The bound for pairs of a surface with itself: what is no further apart than `nearest` is near, what is by more than
/// `margin` is too far.
qcDistanceThresholds qcTriangleBvh_FindBound(const qcTriangleBvh* surface, double margin, double nearest);

/// Takes what has been found. False: no more is wanted.
typedef bool qcBvhPairsFunction(void* context, const qcClassifiedPairs* found, uint32_t worker);

typedef struct qcBvhPairsJob
{
    const qcTriangleKernels* kernels;
    const qcTriangleBvh *a, *b; ///< the same: pairs within it, each once
    const qcBody *bodyA, *bodyB;
    double margin;                ///< no more than both were fitted with
    double nearest;               ///< pairs that are apart by no more than this are near
    bool neighbours;              ///< of one surface: pairs that share a vertex index are found too
    bool flatDiscs;               ///< of one surface: what qcTriangleBvh_FindFlat found is made use of
    uint8_t *reachedA, *reachedB; ///< by node: set where it was compared with a node of the other. May be null
    qcBvhPairsFunction* function;
    void* context;
} qcBvhPairsJob;

/// Memory that is kept between steps.
typedef struct qcBvhPairs
{
    qcArray searches; ///< of Search: one for each job
    qcArray items;    ///< of Item: pairs of groups, of all searches
    qcArray queues;   ///< of qcSlotPair, room for each worker
} qcBvhPairs;

/// Does all jobs, side by side. The surfaces of each have been fitted, with the same margin, and that of the pairs is
/// no more.
qcStatus qcBvhPairs_Find(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads);
void qcBvhPairs_Free(qcBvhPairs* pairs);

#endif
