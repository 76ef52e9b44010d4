// The filter of candidate pairs.
#include "kernels/pair_filter.h"

void qcClassifiedPairs_Filter(qcClassifiedPairs* found, const qcTriangleKernels* kernels,
                              const qcIndexedTriangles sides[2], const qcDistanceThresholds* thresholds)
{
    found->count = kernels->filter(&sides[0], &sides[1], thresholds, found->pairs, found->count);
    if (thresholds->query > 0.0f)
    {
        qcClassifiedCounts counts = kernels->classify(&sides[0], &sides[1], thresholds, found->pairs, found->count);
        found->nearCount = counts.nearCount;
        found->separateCount = counts.separateCount;
        found->count = counts.count;
    }
    size_t disjoint = found->nearCount + found->separateCount;
    found->intersectingCount =
        kernels->findIntersecting(&sides[0], &sides[1], thresholds, found->pairs + disjoint, found->count - disjoint);
}
