// A search of one BVH, or of two, in progress (bvh_pairs.c, leaf_pairs.c).
#ifndef QC_SWEEP_BVH_BVH_SEARCH_H
#define QC_SWEEP_BVH_BVH_SEARCH_H

#include "sweep/bvh/bvh_pairs.h"

typedef struct qcBvhSearch
{
    const qcBvhPairsJob* job;
    const qcTriangleBvh *a, *b;
    uint32_t level;               ///< of its node pairs
    qcTransformedBvh transformed; ///< b in the lattice of a
    /// b is local: boxes are compared in its lattice too, above leaf nodes. In these that would take as long as it
    /// saves.
    bool isTurned;
    qcBoxTransform reverse; ///< from the lattice of a to that of b, if isTurned
    qcIndexedTriangles sides[2];
    qcDistanceThresholds thresholds;
    bool same;
    bool hasLarge;       ///< one of the BVHs has large triangles: each of its clusters goes down the other by itself
    int large;           ///< 0: a has, 1: b has
    bool filters;        ///< false: the thresholds are too inexact for the filter
    qcMotionBvh* motion; ///< of a and of b; null: no motion
} qcBvhSearch;

/// Two nodes of the present level of a search, or a cluster of large triangles and a node.
typedef struct qcNodePair
{
    uint32_t search; ///< its number
    uint32_t a, b;
} qcNodePair;

#endif
