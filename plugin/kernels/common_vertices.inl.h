// The pair mask of two leaf nodes of one body, from the vertices of their triangles: for bodies whose masks are not
// stored. The source of an instruction set defines FindCommonVertices.
#ifndef QC_KERNELS_COMMON_VERTICES_INL_H
#define QC_KERNELS_COMMON_VERTICES_INL_H

#include "kernels/triangle_kernels.h"

/// Bit u + 8 v: triangle u of the first cluster and triangle v of the second have a common vertex.
static inline uint64_t FindCommonVertices(const qcClusterVertices* a, const qcClusterVertices* b);

static uint32_t FindPairMask(const qcClusterVertices* a, const qcClusterVertices* b, uint64_t clusters,
                             uint64_t packed[qc_maxPairMaskSize + 1])
{
    uint32_t neighbours = 0;
    size_t count = 2;
    packed[0] = packed[1] = 0;
    for (; clusters != 0; clusters &= clusters - 1)
    {
        uint32_t word = (uint32_t)__builtin_ctzll(clusters), i = word % qc_boxLanes, j = word / qc_boxLanes;
        uint64_t pairs = a == b && i >= j ? (i == j ? QC_PAIRS_IN_ORDER : 0) : UINT64_MAX;
        uint64_t common = pairs != 0 ? FindCommonVertices(&a[i], &b[j]) & pairs : 0;
        neighbours += (uint32_t)__builtin_popcountll(common);
        pairs &= ~common;
        if (pairs == UINT64_MAX)
            continue;
        packed[pairs != 0 ? 0 : 1] |= UINT64_C(1) << word;
        packed[count] = pairs;
        count += pairs != 0;
    }
    packed[count] = 0;
    return neighbours;
}

#endif
