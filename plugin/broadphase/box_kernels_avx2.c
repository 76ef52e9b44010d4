// Box kernels for x86-64 with AVX2.
#include "broadphase/box_kernels.h"

#include <immintrin.h>

typedef struct Lanes
{
    __m256 lower[3], upper[3];
} Lanes;

static inline Lanes LoadLanes(const qcOctet* octet)
{
    Lanes lanes;
    for (int k = 0; k < 3; k++)
    {
        lanes.lower[k] = _mm256_loadu_ps(octet->lower[k]);
        lanes.upper[k] = _mm256_loadu_ps(octet->upper[k]);
    }
    return lanes;
}

static inline uint32_t OverlapLanes(const Lanes* lanes, const qcFloatBox* box)
{
    __m256 overlap = _mm256_cmp_ps(lanes->lower[0], _mm256_set1_ps(box->upper[0]), _CMP_LE_OQ);
    overlap = _mm256_and_ps(overlap, _mm256_cmp_ps(lanes->upper[0], _mm256_set1_ps(box->lower[0]), _CMP_GE_OQ));
    for (int k = 1; k < 3; k++)
    {
        overlap = _mm256_and_ps(overlap, _mm256_cmp_ps(lanes->lower[k], _mm256_set1_ps(box->upper[k]), _CMP_LE_OQ));
        overlap = _mm256_and_ps(overlap, _mm256_cmp_ps(lanes->upper[k], _mm256_set1_ps(box->lower[k]), _CMP_GE_OQ));
    }
    return (uint32_t)_mm256_movemask_ps(overlap);
}

#include "broadphase/box_kernels.inl.h"

const qcBoxKernels qcBoxKernels_avx2 = {Overlap, FindOverlaps};
