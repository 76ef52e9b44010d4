// Kernels for x86-64 with AVX-512 F, BW and VL, and BMI2.
#include "kernels/simd_x86.h"

enum
{
    QC_LANES = 16
};

typedef __mmask16 LaneMask;

static inline LaneMask AllLanes(void)
{
    return 0xffff;
}

static inline LaneMask IsAbove(__m512 a, __m512 b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_GT_OQ);
}

static inline uint32_t LaneBits(LaneMask lanes)
{
    return lanes;
}

static inline __m512 MinFloats(__m512 a, __m512 b)
{
    return _mm512_min_ps(a, b);
}

static inline __m512 SquareRoot(__m512 a)
{
    return _mm512_sqrt_ps(a);
}

static inline __m512 MaxFloats(__m512 a, __m512 b)
{
    return _mm512_max_ps(a, b);
}

static inline qcSlotPair* AddListed(uint32_t kept, const uint8_t listed[8], qcSlotPair first, qcSlotPair* pairs)
{
    __m512i at = _mm512_cvtepu8_epi64(_mm_loadl_epi64((const __m128i*)listed));
    __m512i i = _mm512_and_si512(at, _mm512_set1_epi64(7)), j = _mm512_slli_epi64(_mm512_srli_epi64(at, 3), 32);
    __m512i all =
        _mm512_add_epi64(_mm512_set1_epi64((int64_t)((uint64_t)first.b << 32 | first.a)), _mm512_or_si512(i, j));
    _mm512_storeu_si512(pairs, _mm512_maskz_compress_epi64((__mmask8)kept, all));
    return pairs + __builtin_popcount(kept);
}

/// Bit i + 8 j: box i of a overlaps box j of b. Four boxes of b at a time, against all boxes of a. Upper ends are
/// stored as complements -1 - upper, so that lower <= upper is the sign of a sum; saturation keeps it. Comparisons to
/// masks would share a port with the shuffles.
static inline uint64_t FindBoxOverlaps(const qcBox8* a, const qcBox8* b)
{
    __m512i lower[3], upper[3], otherLower[3], otherUpper[3];
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i*)a->ends[axis]));
        upper[axis] = _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i*)(a->ends[axis] + qc_boxLanes)));
        otherLower[axis] = _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i*)b->ends[axis]));
        otherUpper[axis] = _mm512_broadcast_i32x4(_mm_loadu_si128((const __m128i*)(b->ends[axis] + qc_boxLanes)));
    }
    __m512i pick = _mm512_set_epi64(0x0706070607060706, 0x0706070607060706, 0x0504050405040504, 0x0504050405040504,
                                    0x0302030203020302, 0x0302030203020302, 0x0100010001000100, 0x0100010001000100);
    uint64_t overlaps = 0;
    for (int half = 0; half < 2; half++)
    {
        __m512i both = _mm512_set1_epi16(-1);
        for (int axis = 0; axis < 3; axis++)
        {
            __m512i first = _mm512_adds_epi16(lower[axis], _mm512_shuffle_epi8(otherUpper[axis], pick)),
                    second = _mm512_adds_epi16(upper[axis], _mm512_shuffle_epi8(otherLower[axis], pick));
            both = _mm512_and_si512(both, _mm512_and_si512(first, second));
        }
        overlaps |= (uint64_t)_mm512_movepi16_mask(both) << 32 * half;
        pick = _mm512_add_epi8(pick, _mm512_set1_epi8(8));
    }
    return overlaps;
}

/// The boxes around both ends.
static inline uint64_t FindUnitedOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    const qcBox8* const* sides[2] = {a, b};
    qcBox8 united[2];
    for (int side = 0; side < 2; side++)
        for (int axis = 0; axis < 3; axis++)
            _mm256_storeu_si256((__m256i*)united[side].ends[axis],
                                _mm256_min_epi16(_mm256_loadu_si256((const __m256i*)sides[side][0]->ends[axis]),
                                                 _mm256_loadu_si256((const __m256i*)sides[side][1]->ends[axis])));
    return FindBoxOverlaps(&united[0], &united[1]);
}

/// An axis separates a motion if it separates in the same order at both ends.
static inline uint64_t FindMotionBoxOverlaps(const qcBox8* const a[2], const qcBox8* const b[2])
{
    __m512i ends[2][3], limits[2][3];
    for (int t = 0; t < 2; t++)
        for (int axis = 0; axis < 3; axis++)
        {
            ends[t][axis] = _mm512_broadcast_i64x4(_mm256_loadu_si256((const __m256i*)a[t]->ends[axis]));
            __m256i other = _mm256_loadu_si256((const __m256i*)b[t]->ends[axis]);
            limits[t][axis] =
                _mm512_broadcast_i64x4(_mm256_xor_si256(_mm256_permute4x64_epi64(other, 0x4e), _mm256_set1_epi8(-1)));
        }
    uint64_t overlaps = 0;
    for (int j = 0; j < qc_boxLanes; j += 2)
    {
        __m512i pick = _mm512_inserti64x4(_mm512_set1_epi16((short)(0x0100 + 0x0202 * j)),
                                          _mm256_set1_epi16((short)(0x0100 + 0x0202 * (j + 1))), 1);
        __mmask32 both = ~(__mmask32)0;
        for (int axis = 0; axis < 3; axis++)
            both &= _mm512_cmple_epi16_mask(ends[0][axis], _mm512_shuffle_epi8(limits[0][axis], pick)) |
                    _mm512_cmple_epi16_mask(ends[1][axis], _mm512_shuffle_epi8(limits[1][axis], pick));
        uint32_t rows = both & both >> 8 & 0x00ff00ffu;
        overlaps |= (uint64_t)((rows | rows >> 8) & 0xffffu) << 8 * j;
    }
    return overlaps;
}

#include "kernels/triangle_kernels.inl.h"

/// The four floats of every fourth lane side by side, then columns to vectors.
QC_INLINE Vectors LoadPoints(const qcPoint* points, const uint32_t vertex[QC_LANES])
{
    __m512 row[4];
    for (int i = 0; i < 4; i++)
    {
        row[i] = _mm512_castps128_ps512(_mm_loadu_ps(points[vertex[i]].x));
        row[i] = _mm512_insertf32x4(row[i], _mm_loadu_ps(points[vertex[4 + i]].x), 1);
        row[i] = _mm512_insertf32x4(row[i], _mm_loadu_ps(points[vertex[8 + i]].x), 2);
        row[i] = _mm512_insertf32x4(row[i], _mm_loadu_ps(points[vertex[12 + i]].x), 3);
    }
    __m512 xy01 = _mm512_unpacklo_ps(row[0], row[1]), z01 = _mm512_unpackhi_ps(row[0], row[1]);
    __m512 xy23 = _mm512_unpacklo_ps(row[2], row[3]), z23 = _mm512_unpackhi_ps(row[2], row[3]);
    return (Vectors){_mm512_shuffle_ps(xy01, xy23, 0x44), _mm512_shuffle_ps(xy01, xy23, 0xee),
                     _mm512_shuffle_ps(z01, z23, 0x44)};
}

QC_INLINE uint32_t SignBits(Ints lanes)
{
    return _mm512_cmplt_epi32_mask((__m512i)lanes, _mm512_setzero_si512());
}

/// The lower halves of a row, four times.
static inline __m512i LowHalves(__m256i row)
{
    return _mm512_broadcast_i32x4(_mm256_cvtepi32_epi16(row));
}

/// FindCommonVertices where all vertices have the same upper half: four triangles of b at a time, against all of a.
static inline uint64_t FindCommonHalves(const __m256i a[3], const __m256i b[3])
{
    __m512i corner[3], other[3];
    __m512i pick = _mm512_set_epi64(0x0706070607060706, 0x0706070607060706, 0x0504050405040504, 0x0504050405040504,
                                    0x0302030203020302, 0x0302030203020302, 0x0100010001000100, 0x0100010001000100);
    uint64_t common = 0;
    for (int k = 0; k < 3; k++)
    {
        corner[k] = LowHalves(a[k]);
        other[k] = LowHalves(b[k]);
    }
    for (int half = 0; half < 2; half++)
    {
        // Equal vertices have a difference of zero, below all others.
        __m512i min = _mm512_set1_epi32(-1);
        for (int k = 0; k < 3; k++)
        {
            __m512i vertex = _mm512_shuffle_epi8(other[k], pick);
            for (int c = 0; c < 3; c++)
                min = _mm512_min_epu16(min, _mm512_xor_si512(corner[c], vertex));
        }
        common |= (uint64_t)_mm512_testn_epi16_mask(min, min) << 32 * half;
        pick = _mm512_add_epi8(pick, _mm512_set1_epi8(8));
    }
    return common;
}

/// Two triangles of b at a time, or four, against all of a.
static inline uint64_t FindCommonVertices(const qcClusterVertices* a, const qcClusterVertices* b)
{
    __m256i rowsA[3], rowsB[3], first = _mm256_set1_epi32((int)a->vertex[0][0]), differing = _mm256_setzero_si256();
    for (int k = 0; k < 3; k++)
    {
        rowsA[k] = _mm256_loadu_si256((const __m256i*)a->vertex[k]);
        rowsB[k] = _mm256_loadu_si256((const __m256i*)b->vertex[k]);
        differing = _mm256_or_si256(
            differing, _mm256_or_si256(_mm256_xor_si256(rowsA[k], first), _mm256_xor_si256(rowsB[k], first)));
    }
    // Vertices are numbered along the clusters, so that those of close clusters mostly have one.
    if (_mm256_testz_si256(differing, _mm256_set1_epi32((int)0xffff0000u)))
        return FindCommonHalves(rowsA, rowsB);
    __m512i corner[3], other[3], pick = _mm512_inserti64x4(_mm512_setzero_si512(), _mm256_set1_epi32(1), 1);
    uint64_t common = 0;
    for (int k = 0; k < 3; k++)
    {
        corner[k] = _mm512_broadcast_i64x4(rowsA[k]);
        other[k] = _mm512_broadcast_i64x4(rowsB[k]);
    }
    for (int v = 0; v < qc_clusterSize; v += 2)
    {
        __m512i min = _mm512_set1_epi32(-1);
        for (int k = 0; k < 3; k++)
        {
            __m512i vertex = _mm512_permutexvar_epi32(pick, other[k]);
            for (int c = 0; c < 3; c++)
                min = _mm512_min_epu32(min, _mm512_xor_si512(corner[c], vertex));
        }
        common |= (uint64_t)_mm512_testn_epi32_mask(min, min) << 8 * v;
        pick = _mm512_add_epi32(pick, _mm512_set1_epi32(2));
    }
    return common;
}

const qcTriangleKernels qcTriangleKernels_avx512 = QC_KERNELS("avx512");
