// The filter of candidate pairs: runs the kernels of one instruction set over a batch of pairs.
#ifndef QC_KERNELS_PAIR_FILTER_H
#define QC_KERNELS_PAIR_FILTER_H

#include "kernels/triangle_kernels.h"

enum
{
    // A worker filters its queue when it holds this many pairs: 16 KiB.
    qc_queueFull = 2048
};

/// Candidate pairs, classified ones first: near, separate, intersecting, then undecided. `a` is a slot of the first
/// body, `b` of the second.
typedef struct qcClassifiedPairs
{
    qcSlotPair* pairs;
    size_t near;        ///< proven no further apart than the bound's `margin`
    size_t apart;       ///< proven apart by more than that
    size_t penetrating; ///< proven to intersect
    size_t count;       ///< in all
} qcClassifiedPairs;

/// Removes pairs that the kernels prove further apart than the query distance, and classifies the rest. Any order of
/// pairs is accepted.
void qcClassifiedPairs_Filter(qcClassifiedPairs* found, const qcTriangleKernels* kernels, const qcFilterSide sides[2],
                              const qcDistanceThresholds* bound);

#endif
