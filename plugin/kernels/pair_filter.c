// The filter of candidate pairs.
#include "kernels/pair_filter.h"

void qcClassifiedPairs_Filter(qcClassifiedPairs* found, const qcTriangleKernels* kernels, const qcFilterSide sides[2],
                              const qcDistanceThresholds* bound)
{
    found->count = kernels->filter(&sides[0], &sides[1], bound, found->pairs, found->count);
    if (bound->reach > 0.0f)
    {
        qcApartCounts counts = kernels->part(&sides[0], &sides[1], bound, found->pairs, found->count);
        found->near = counts.near;
        found->apart = counts.apart;
        found->count = counts.count;
    }
    size_t known = found->near + found->apart;
    found->penetrating = kernels->findPiercing(&sides[0], &sides[1], bound, found->pairs + known, found->count - known);
}
