// The order of few triangles for x86-64 with AVX-512 F, BW and VL.
#include "mesh/order_item.h"
#include "mesh/sixteen_shorts.h"

/// The lowest bits, 8 at most.
static inline __mmask8 FirstLanes(uint32_t count)
{
    return (__mmask8)_bzhi_u32(0xff, count < 8 ? count : 8);
}

static inline void ReadKeys(const Item* items, uint32_t count, int axis, int16_t* keys)
{
    const __m128i shift = _mm_cvtsi32_si128(16 * axis);
    for (uint32_t i = 0; i < count; i += 8)
    {
        __m512i some = _mm512_maskz_loadu_epi64(FirstLanes(count - i), items + i);
        _mm_storeu_si128((__m128i*)(keys + i), _mm512_cvtepi64_epi16(_mm512_srl_epi64(some, shift)));
    }
}

static inline uint32_t CountBelow(const int16_t* keys, uint32_t count, int value)
{
    const __m512i limit = _mm512_set1_epi16((int16_t)value);
    uint32_t below = 0;
    for (uint32_t i = 0; i < count; i += qc_countedKeys)
        below += (uint32_t)__builtin_popcount(_mm512_cmplt_epi16_mask(_mm512_loadu_si512(keys + i), limit));
    return below;
}

/// Items go to the same places as one at a time.
static inline void MoveItems(Item* items, const int16_t* keys, uint32_t count, int median, Item* back)
{
    const __m128i limit = _mm_set1_epi16((int16_t)median);
    const __m512i lanes = _mm512_set_epi64(7, 6, 5, 4, 3, 2, 1, 0);
    Item *front = items, *behind = back + 1;
    for (uint32_t i = 0; i < count; i += 8)
    {
        const __mmask8 used = FirstLanes(count - i);
        __m512i some = _mm512_maskz_loadu_epi64(used, items + i);
        __mmask8 lower = _mm_mask_cmplt_epi16_mask(used, _mm_loadu_si128((const __m128i*)(keys + i)), limit),
                 upper = (__mmask8)(used & ~lower);
        uint32_t lowerCount = (uint32_t)__builtin_popcount(lower), upperCount = (uint32_t)__builtin_popcount(upper);
        _mm512_mask_storeu_epi64(front, FirstLanes(lowerCount), _mm512_maskz_compress_epi64(lower, some));
        front += lowerCount;
        behind -= upperCount;
        __m512i reversed = _mm512_sub_epi64(_mm512_set1_epi64((int64_t)upperCount - 1), lanes);
        _mm512_mask_storeu_epi64(behind, FirstLanes(upperCount),
                                 _mm512_permutexvar_epi64(reversed, _mm512_maskz_compress_epi64(upper, some)));
    }
}

#include "mesh/small_order.inl.h"

const qcOrderKernels qcOrderKernels_avx512 = {MakeSmallOrder};
