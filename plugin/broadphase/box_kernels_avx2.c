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

static inline uint32_t CastLanes(const qcOctet* octet, const qcFloatCast* cast, float fraction, float entries[qc_lanes])
{
    __m256 enter = _mm256_setzero_ps(), leave = _mm256_set1_ps(fraction);
    for (int k = 0; k < 3; k++)
    {
        if (cast->inverse[k] == 0.0f)
            continue;
        __m256 inverse = _mm256_set1_ps(cast->inverse[k]);
        __m256 low = _mm256_sub_ps(_mm256_loadu_ps(octet->lower[k]), _mm256_set1_ps(cast->lowerOffset[k]));
        __m256 high = _mm256_sub_ps(_mm256_loadu_ps(octet->upper[k]), _mm256_set1_ps(cast->upperOffset[k]));
        bool forward = cast->inverse[k] > 0.0f;
        enter = _mm256_max_ps(_mm256_mul_ps(forward ? low : high, inverse), enter);
        leave = _mm256_min_ps(_mm256_mul_ps(forward ? high : low, inverse), leave);
    }
    _mm256_storeu_ps(entries, _mm256_mul_ps(enter, _mm256_set1_ps(1.0f - QC_FLOAT_CAST_TOLERANCE)));
    __m256 end = _mm256_add_ps(leave, _mm256_set1_ps(QC_FLOAT_CAST_TOLERANCE));
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(enter, end, _CMP_NGT_UQ));
}

#include "broadphase/box_kernels.inl.h"

const qcBoxKernels qcBoxKernels_avx2 = {Overlap, CastOctet, FindOverlaps};
