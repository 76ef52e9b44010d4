// Eight 16-bit integers side by side, on any CPU.
#ifndef QC_BASE_EIGHT_SHORTS_H
#define QC_BASE_EIGHT_SHORTS_H

#include <stdint.h>
#include <string.h>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef int16_t qcEightShorts __attribute__((vector_size(16)));

/// No alignment is needed.
static inline qcEightShorts qcEightShorts_Load(const void* from)
{
    qcEightShorts shorts;
    memcpy(&shorts, from, sizeof shorts);
    return shorts;
}

static inline qcEightShorts qcEightShorts_Min(qcEightShorts a, qcEightShorts b)
{
#ifdef __SSE2__
    return (qcEightShorts)_mm_min_epi16((__m128i)a, (__m128i)b);
#else
    return (a & (a < b)) | (b & (a >= b));
#endif
}

static inline qcEightShorts qcEightShorts_Max(qcEightShorts a, qcEightShorts b)
{
#ifdef __SSE2__
    return (qcEightShorts)_mm_max_epi16((__m128i)a, (__m128i)b);
#else
    return (a & (a > b)) | (b & (a <= b));
#endif
}

#endif
