// Pairs of triangles whose boxes overlap and which no tested axis separates: of one body with itself, or of two bodies.
#ifndef QC_SWEEP_BVH_BVH_PAIRS_H
#define QC_SWEEP_BVH_BVH_PAIRS_H

#include "kernels/pair_filter.h"
#include "sweep/bvh/body_bvh.h"

/// Thresholds for pairs within one BVH, from distances in the world: pairs at most `near` apart are near, pairs farther
/// apart than `query` are dropped.
qcDistanceThresholds qcTriangleBvh_Thresholds(const qcTriangleBvh* bvh, double query, double near);

/// Whether a job has these two bodies in this order. World coordinates come first: the local BVH is transformed
/// into them, and no transform is inverted. If both are local, or none, large triangles come first, in whose lattice
/// the boxes of both are tight; but not if that is too coarse for the small triangles of a local body.
bool qcBvhPairs_AreInOrder(const qcBodyBvh* a, const qcBody* bodyA, const qcBodyBvh* b, const qcBody* bodyB);

/// Receives pairs. False: the search may stop.
typedef bool qcBvhPairsFunction(void* context, const qcClassifiedPairs* found, uint32_t worker);

typedef struct qcBvhPairsJob
{
    const qcTriangleKernels* kernels;
    const qcBodyBvh *a, *b; ///< equal: pairs within the body, each once
    const qcBody *bodyA, *bodyB;
    double query;           ///< max distance of a pair
    double near;            ///< pairs at most this far apart are near
    bool includeNeighbours; ///< within one body: also pairs that share a vertex index
    bool skipFlatPatches;   ///< within one body: leave out pairs within patches that were proven flat
    /// Pairs that may meet between the start and the present: of BVHs fitted by qcTriangleBvh_FitMotion. The distances
    /// are 0, and all pairs are undecided.
    bool motion;
    /// Grows by the pairs of neighbours that are left out, of a body without adjacency. May be null.
    uint64_t* neighbourCount;
    /// By leaf node: set to 1 if it is compared with one of the other. May be null, except that of an outline.
    uint8_t *visitedA, *visitedB;
    qcBvhPairsFunction* function;
    void* context;
} qcBvhPairsJob;

/// Memory that is retained between steps.
typedef struct qcBvhPairs
{
    qcArray searches;  ///< of qcBvhSearch: one for each job
    qcArray nodePairs; ///< of qcNodePair, of all searches
    qcArray motions;   ///< of qcMotionBvh: two for each job, if one is a motion
    qcArray queues;    ///< of qcSlotPair, a part for each worker
    qcArray planes;    ///< of qcPlaneCache, one for each worker
} qcBvhPairs;

/// Begins all jobs: finds pairs of nodes and, where a BVH of the job is an outline, all pairs of leaf nodes, and marks
/// these as visited. The BVHs of a job are fitted with a margin of `query` or more, unless one is local.
qcStatus qcBvhPairs_Begin(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads);
/// Finds the pairs of triangles of the same jobs, in parallel. The visited leaf nodes of outlines are fitted.
void qcBvhPairs_Finish(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads);
/// Both, where no BVH is an outline.
qcStatus qcBvhPairs_Find(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads);
void qcBvhPairs_Free(qcBvhPairs* pairs);

#endif
