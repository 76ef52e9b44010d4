// The filter of candidate pairs.
#include "kernels/pair_filter.h"

void qcClassifiedPairs_Filter(qcClassifiedPairs* found, const qcTriangleKernels* kernels,
                              const qcIndexedTriangles sides[2], const qcDistanceThresholds* thresholds,
                              bool planesTested)
{
    const qcIndexedTriangles *a = &sides[0], *b = &sides[1];
    if (thresholds->query <= 0.0f)
    {
        if (!planesTested)
            found->count = kernels->filter(a, b, thresholds, found->pairs, found->count);
        qcRelatedCounts counts = kernels->relate(a, b, thresholds, found->pairs, found->count);
        found->intersectingCount = counts.intersectingCount;
        found->count = counts.count;
        return;
    }
    found->count = kernels->filter(a, b, thresholds, found->pairs, found->count);
    qcClassifiedCounts counts = kernels->classify(a, b, thresholds, found->pairs, found->count);
    size_t disjoint = counts.nearCount + counts.separateCount;
    found->nearCount = counts.nearCount;
    found->separateCount = counts.separateCount;
    found->count = counts.count;
    found->intersectingCount =
        kernels->findIntersecting(a, b, thresholds, found->pairs + disjoint, found->count - disjoint);
}
