// The common part of the kernels for AVX2 and AVX-512.
#ifndef QC_KERNELS_SIMD_X86_H
#define QC_KERNELS_SIMD_X86_H

#include "kernels/triangle_kernels.h"

#include <immintrin.h>

typedef __m128i Shorts;

static inline Shorts MinShorts(Shorts a, Shorts b)
{
    return _mm_min_epi16(a, b);
}

/// Bit i: box i overlaps the one of the row. Upper ends are stored as complements -1 - upper, so that lower <= upper is
/// the sign of a sum; saturation keeps it.
static inline uint32_t FindRowOverlaps(const qcBox8* boxes, const qcBoxRow* row)
{
    const __m256i one = _mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i*)row));
    __m256i both = _mm256_set1_epi8(-1);
    for (int axis = 0; axis < 3; axis++)
    {
        // Lower ends go with the upper end of the row, and vice versa.
        __m256i pick = _mm256_set_m128i(_mm_set1_epi16((short)(0x0100 + 0x0202 * axis)),
                                        _mm_set1_epi16((short)(0x0908 + 0x0202 * axis)));
        __m256i ends = _mm256_loadu_si256((const __m256i*)boxes->ends[axis]);
        both = _mm256_and_si256(both, _mm256_adds_epi16(ends, _mm256_shuffle_epi8(one, pick)));
    }
    __m128i overlaps = _mm_and_si128(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
    return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(overlaps, overlaps)) & 0xffu;
}

static inline void Transpose(const Shorts row[8], Shorts column[8])
{
    Shorts pairs[8], fours[8];
    for (int i = 0; i < 4; i++)
    {
        pairs[2 * i] = _mm_unpacklo_epi16(row[2 * i], row[2 * i + 1]);
        pairs[2 * i + 1] = _mm_unpackhi_epi16(row[2 * i], row[2 * i + 1]);
    }
    for (int half = 0; half < 2; half++)
        for (int i = 0; i < 2; i++)
        {
            fours[4 * half + 2 * i] = _mm_unpacklo_epi32(pairs[4 * half + i], pairs[4 * half + 2 + i]);
            fours[4 * half + 2 * i + 1] = _mm_unpackhi_epi32(pairs[4 * half + i], pairs[4 * half + 2 + i]);
        }
    for (int i = 0; i < 4; i++)
    {
        column[2 * i] = _mm_unpacklo_epi64(fours[i], fours[4 + i]);
        column[2 * i + 1] = _mm_unpackhi_epi64(fours[i], fours[4 + i]);
    }
}

/// Truncated, and moved to the range of shorts. With outliers, beyond the lattice it is the first level or the last.
static inline __m128i ToLevels(__m256d scaled, bool hasOutliers)
{
    if (hasOutliers)
        scaled = _mm256_min_pd(_mm256_max_pd(scaled, _mm256_setzero_pd()), _mm256_set1_pd(qc_lastLevel));
    return _mm_sub_epi32(_mm256_cvttpd_epi32(scaled), _mm_set1_epi32(32768));
}

typedef __m256d Position;

static inline __m256d LoadDoublePosition(const double* x)
{
    return _mm256_set_m128d(_mm_load_sd(x + 2), _mm_loadu_pd(x));
}

static inline __m256d LoadFloatPosition(const float* x)
{
    __m128 four = _mm_loadu_ps(x);
    return _mm256_cvtps_pd(_mm_insert_ps(four, four, 0x08)); // the last becomes 0
}

static inline __m256d MinPositions(__m256d a, __m256d b)
{
    return _mm256_min_pd(a, b);
}

static inline __m256d MaxPositions(__m256d a, __m256d b)
{
    return _mm256_max_pd(a, b);
}

static inline void StorePoint(const qcLatticeTransform* lattice, __m256d x, qcPoint* point)
{
    __m256d fromOrigin = _mm256_sub_pd(x, _mm256_loadu_pd(lattice->origin));
    _mm_storeu_ps(point->x, _mm256_cvtpd_ps(_mm256_mul_pd(fromOrigin, _mm256_loadu_pd(lattice->unit))));
}

/// The levels of two positions, the second one with the margin.
static inline void StoreRow(const qcLatticeTransform* lattice, __m256d first, __m256d last, bool hasMargin,
                            bool hasOutliers, qcBoxRow* row)
{
    __m256d origin = _mm256_loadu_pd(lattice->origin), scale = _mm256_loadu_pd(lattice->scale);
    if (hasMargin)
        last = _mm256_add_pd(last, _mm256_loadu_pd(lattice->margin));
    __m128i low = ToLevels(_mm256_mul_pd(_mm256_sub_pd(first, origin), scale), hasOutliers),
            high = ToLevels(_mm256_mul_pd(_mm256_sub_pd(last, origin), scale), hasOutliers);
    __m128i ends = _mm_packs_epi32(low, high);
    _mm_storeu_si128((__m128i*)row, _mm_xor_si128(ends, _mm_set_epi64x(-1, 0)));
}

//  ---- kernels/lattice_transform.inl.h -------------------------------------------------------------

typedef __m256 EightFloats;

static inline __m256 LoadEnds(const int16_t* ends)
{
    return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i*)ends)));
}

static inline void StoreEnds(__m256 lower, __m256 upper, const int16_t source[qc_boxLanes], int axis,
                             qcBox8* transformed)
{
    const __m256 first = _mm256_setzero_ps(), last = _mm256_set1_ps((float)qc_lastLevel);
    // NaN gives the second operand.
    lower = _mm256_min_ps(_mm256_max_ps(lower, first), last);
    upper = _mm256_max_ps(_mm256_min_ps(upper, last), first);
    const __m256i offset = _mm256_set1_epi32(32768);
    __m256i low = _mm256_sub_epi32(_mm256_cvttps_epi32(lower), offset),
            high = _mm256_sub_epi32(_mm256_set1_epi32(32767), _mm256_cvttps_epi32(upper));
    __m256i ends = _mm256_permute4x64_epi64(_mm256_packs_epi32(low, high), 0xd8);
    const __m256i none = _mm256_set1_epi16(qc_emptyEnd);
    __m256i own = _mm256_broadcastsi128_si256(_mm_loadu_si128((const __m128i*)source));
    ends = _mm256_blendv_epi8(ends, none, _mm256_cmpeq_epi16(own, none));
    _mm256_storeu_si256((__m256i*)transformed->ends[axis], ends);
}

//  ---- kernels/cluster_planes.inl.h ----------------------------------------------------------------

enum
{
    qc_planeLanes = 8
};

typedef __m256 PlaneFloats;
typedef int32_t PlaneInts __attribute__((vector_size(32)));

static inline __m256 PickLanes(const float lanes[8], PlaneInts at)
{
    return _mm256_permutevar8x32_ps(_mm256_loadu_ps(lanes), (__m256i)at);
}

static inline PlaneInts LoadNumbers(const uint8_t bytes[8])
{
    return (PlaneInts)_mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)bytes));
}

static inline void StoreShorts(__m256 whole, int16_t* shorts)
{
    __m256i ints = _mm256_cvttps_epi32(whole);
    _mm_storeu_si128((__m128i*)shorts,
                     _mm_packs_epi32(_mm256_castsi256_si128(ints), _mm256_extracti128_si256(ints, 1)));
}

static inline __m256 MinPlane(__m256 a, __m256 b)
{
    return _mm256_min_ps(a, b);
}

static inline __m256 MaxPlane(__m256 a, __m256 b)
{
    return _mm256_max_ps(a, b);
}

static inline uint32_t FindApart(const __m256 x[3], __m256 lower, __m256 upper)
{
    __m256 above = _mm256_cmp_ps(MinPlane(x[0], MinPlane(x[1], x[2])), upper, _CMP_GT_OQ);
    __m256 below = _mm256_cmp_ps(MaxPlane(x[0], MaxPlane(x[1], x[2])), lower, _CMP_LT_OQ);
    return (uint32_t)_mm256_movemask_ps(_mm256_or_ps(above, below));
}

/// The points of triangles i and 4 + i side by side, then columns to vectors.
static inline void LoadPlanePoints(const qcPoint* points, const qcCorners* corners, int c, __m256 out[4])
{
    __m256 row[4];
    for (int i = 0; i < 4; i++)
        row[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(points[corners[i].vertex[c]].x)),
                                      _mm_loadu_ps(points[corners[4 + i].vertex[c]].x), 1);
    __m256 xy01 = _mm256_unpacklo_ps(row[0], row[1]), z01 = _mm256_unpackhi_ps(row[0], row[1]);
    __m256 xy23 = _mm256_unpacklo_ps(row[2], row[3]), z23 = _mm256_unpackhi_ps(row[2], row[3]);
    out[0] = _mm256_shuffle_ps(xy01, xy23, 0x44);
    out[1] = _mm256_shuffle_ps(xy01, xy23, 0xee);
    out[2] = _mm256_shuffle_ps(z01, z23, 0x44);
    out[3] = _mm256_shuffle_ps(z01, z23, 0xee);
}

#endif
