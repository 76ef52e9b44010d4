// Kernels for x86-64 with AVX2 and FMA.
#include "kernels/simd_x86.h"

#include <string.h>

enum
{
    QC_LANES = 8
};

typedef int32_t LaneMask __attribute__((vector_size(32)));

static inline LaneMask AllLanes(void)
{
    return ~(LaneMask){0};
}

static inline LaneMask IsAbove(__m256 a, __m256 b)
{
    return a > b;
}

static inline uint32_t LaneBits(LaneMask lanes)
{
    return (uint32_t)_mm256_movemask_ps((__m256)lanes);
}

static inline __m256 MinFloats(__m256 a, __m256 b)
{
    return _mm256_min_ps(a, b);
}

static inline __m256 SquareRoot(__m256 a)
{
    return _mm256_sqrt_ps(a);
}

static inline __m256 MaxFloats(__m256 a, __m256 b)
{
    return _mm256_max_ps(a, b);
}

/// The ends of eight boxes by axis.
typedef struct Ends
{
    __m256i axis[3];
} Ends;

static inline Ends EndsOf(const qcBox8* boxes)
{
    Ends ends;
    for (int axis = 0; axis < 3; axis++)
        ends.axis[axis] = _mm256_loadu_si256((const __m256i*)boxes->ends[axis]);
    return ends;
}

static inline Ends UnitedEndsOf(const qcBox8* const boxes[2])
{
    Ends ends = EndsOf(boxes[0]), other = EndsOf(boxes[1]);
    for (int axis = 0; axis < 3; axis++)
        ends.axis[axis] = _mm256_min_epi16(ends.axis[axis], other.axis[axis]);
    return ends;
}

/// Bit i + 8 j: box i of a overlaps box j of b. Two boxes of b at a time, against all boxes of a.
static inline uint64_t FindEndsOverlaps(const Ends* a, const Ends* b)
{
    __m256i ends[3], limits[3];
    for (int axis = 0; axis < 3; axis++)
    {
        ends[axis] = a->axis[axis];
        // Lower ends of a are compared with upper ends of b, and vice versa.
        __m256i other = b->axis[axis];
        limits[axis] = _mm256_xor_si256(_mm256_permute4x64_epi64(other, 0x4e), _mm256_set1_epi8(-1));
    }
    uint64_t disjoint = 0;
    for (int j = 0; j < qc_boxLanes; j += 2)
    {
        __m256i row[2];
        for (int k = 0; k < 2; k++)
        {
            __m256i pick = _mm256_set1_epi16((short)(0x0100 + 0x0202 * (j + k)));
            row[k] = _mm256_cmpgt_epi16(ends[0], _mm256_shuffle_epi8(limits[0], pick));
            for (int axis = 1; axis < 3; axis++)
                row[k] =
                    _mm256_or_si256(row[k], _mm256_cmpgt_epi16(ends[axis], _mm256_shuffle_epi8(limits[axis], pick)));
        }
        __m256i both = _mm256_packs_epi16(row[0], row[1]);
        __m128i either = _mm_or_si128(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
        disjoint |= (uint64_t)(uint32_t)_mm_movemask_epi8(either) << 8 * j;
    }
    return ~disjoint;
}

static inline uint64_t FindBoxOverlaps(const qcBox8* a, const qcBox8* b)
{
    Ends endsA = EndsOf(a), endsB = EndsOf(b);
    return FindEndsOverlaps(&endsA, &endsB);
}

/// The boxes around both ends.
static inline uint64_t FindUnitedOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    Ends endsA = UnitedEndsOf(a), endsB = UnitedEndsOf(b);
    return FindEndsOverlaps(&endsA, &endsB);
}

/// By four bits: the halves of the 64-bit lanes whose bits are set, in order.
static const uint8_t s_lanes[16][8] = {{0},
                                       {0, 1},
                                       {2, 3},
                                       {0, 1, 2, 3},
                                       {4, 5},
                                       {0, 1, 4, 5},
                                       {2, 3, 4, 5},
                                       {0, 1, 2, 3, 4, 5},
                                       {6, 7},
                                       {0, 1, 6, 7},
                                       {2, 3, 6, 7},
                                       {0, 1, 2, 3, 6, 7},
                                       {4, 5, 6, 7},
                                       {0, 1, 4, 5, 6, 7},
                                       {2, 3, 4, 5, 6, 7},
                                       {0, 1, 2, 3, 4, 5, 6, 7}};

static inline qcSlotPair* AddListed(uint32_t kept, const uint8_t listed[8], qcSlotPair first, qcSlotPair* pairs)
{
    const __m256i origin = _mm256_set1_epi64x((int64_t)((uint64_t)first.b << 32 | first.a));
    for (size_t half = 0; half < 2; half++)
    {
        uint32_t bits = kept >> 4 * half & 0xfu, four;
        memcpy(&four, listed + 4 * half, sizeof four);
        __m256i at = _mm256_cvtepu8_epi64(_mm_cvtsi32_si128((int)four));
        __m256i i = _mm256_and_si256(at, _mm256_set1_epi64x(7)), j = _mm256_slli_epi64(_mm256_srli_epi64(at, 3), 32);
        __m256i all = _mm256_add_epi64(origin, _mm256_or_si256(i, j));
        __m256i lanes = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)s_lanes[bits]));
        _mm256_storeu_si256((__m256i*)pairs, _mm256_permutevar8x32_epi32(all, lanes));
        pairs += __builtin_popcount(bits);
    }
    return pairs;
}

/// An axis separates a motion if it separates in the same order at both ends.
static inline uint64_t FindMotionBoxOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    __m256i ends[2][3], limits[2][3];
    for (int t = 0; t < 2; t++)
        for (int axis = 0; axis < 3; axis++)
        {
            ends[t][axis] = _mm256_loadu_si256((const __m256i*)a[t]->ends[axis]);
            __m256i other = _mm256_loadu_si256((const __m256i*)b[t]->ends[axis]);
            limits[t][axis] = _mm256_xor_si256(_mm256_permute4x64_epi64(other, 0x4e), _mm256_set1_epi8(-1));
        }
    uint64_t disjoint = 0;
    for (int j = 0; j < qc_boxLanes; j += 2)
    {
        __m256i row[2];
        for (int k = 0; k < 2; k++)
        {
            __m256i pick = _mm256_set1_epi16((short)(0x0100 + 0x0202 * (j + k)));
            row[k] = _mm256_setzero_si256();
            for (int axis = 0; axis < 3; axis++)
                row[k] = _mm256_or_si256(
                    row[k],
                    _mm256_and_si256(_mm256_cmpgt_epi16(ends[0][axis], _mm256_shuffle_epi8(limits[0][axis], pick)),
                                     _mm256_cmpgt_epi16(ends[1][axis], _mm256_shuffle_epi8(limits[1][axis], pick))));
        }
        __m256i both = _mm256_packs_epi16(row[0], row[1]);
        __m128i either = _mm_or_si128(_mm256_castsi256_si128(both), _mm256_extracti128_si256(both, 1));
        disjoint |= (uint64_t)(uint32_t)_mm_movemask_epi8(either) << 8 * j;
    }
    return ~disjoint;
}

#include "kernels/triangle_kernels.inl.h"

/// Four floats of lanes 0 to 3 and of lanes 4 to 7 side by side, then columns to vectors.
QC_INLINE Vectors LoadPoints(const qcPoint* points, const uint32_t vertex[QC_LANES])
{
    __m256 row[4];
    for (int i = 0; i < 4; i++)
        row[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(points[vertex[i]].x)),
                                      _mm_loadu_ps(points[vertex[4 + i]].x), 1);
    __m256 xy01 = _mm256_unpacklo_ps(row[0], row[1]), z01 = _mm256_unpackhi_ps(row[0], row[1]);
    __m256 xy23 = _mm256_unpacklo_ps(row[2], row[3]), z23 = _mm256_unpackhi_ps(row[2], row[3]);
    return (Vectors){_mm256_shuffle_ps(xy01, xy23, 0x44), _mm256_shuffle_ps(xy01, xy23, 0xee),
                     _mm256_shuffle_ps(z01, z23, 0x44)};
}

QC_INLINE uint32_t SignBits(Ints lanes)
{
    return (uint32_t)_mm256_movemask_ps((__m256)lanes);
}

/// One triangle of b at a time, against all of a.
static inline uint64_t FindCommonVertices(const qcClusterVertices* a, const qcClusterVertices* b)
{
    __m256i corner[3];
    uint64_t common = 0;
    for (int k = 0; k < 3; k++)
        corner[k] = _mm256_loadu_si256((const __m256i*)a->vertex[k]);
    for (int v = 0; v < qc_clusterSize; v++)
    {
        __m256i equal = _mm256_setzero_si256();
        for (int k = 0; k < 3; k++)
        {
            __m256i vertex = _mm256_set1_epi32((int)b->vertex[k][v]);
            for (int c = 0; c < 3; c++)
                equal = _mm256_or_si256(equal, _mm256_cmpeq_epi32(corner[c], vertex));
        }
        common |= (uint64_t)(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(equal)) << 8 * v;
    }
    return common;
}

const qcTriangleKernels qcTriangleKernels_avx2 = QC_KERNELS("avx2");
