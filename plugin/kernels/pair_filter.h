// The filter of candidate pairs: runs the kernels of one instruction set over a batch of pairs.
#ifndef QC_KERNELS_PAIR_FILTER_H
#define QC_KERNELS_PAIR_FILTER_H

#include "kernels/triangle_kernels.h"

enum
{
    // A worker filters its queue when it holds this many pairs: 4 KiB, so that their points are still in a near cache
    // (5 % of a step of the bench's tangle-92k against 2048).
    qc_queueFull = 512
};

/// Candidate pairs, classified ones first: near, separate, intersecting, then undecided. `a` is a slot of the first
/// body, `b` of the second.
typedef struct qcClassifiedPairs
{
    qcSlotPair* pairs;
    size_t nearCount;         ///< proven disjoint, at most qcDistanceThresholds::near apart
    size_t separateCount;     ///< proven disjoint, farther apart than qcDistanceThresholds::far
    size_t intersectingCount; ///< proven to intersect
    size_t count;             ///< in all
} qcClassifiedPairs;

/// Drops pairs that are proven farther apart than the query distance, and classifies the others. The pairs come in any
/// order. `planesTested`: those that the second triangle's plane separates are not among them.
void qcClassifiedPairs_Filter(qcClassifiedPairs* found, const qcTriangleKernels* kernels,
                              const qcIndexedTriangles sides[2], const qcDistanceThresholds* thresholds,
                              bool planesTested);

#endif
