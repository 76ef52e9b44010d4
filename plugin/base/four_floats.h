// Four floats side by side, on any CPU.
#ifndef QC_BASE_FOUR_FLOATS_H
#define QC_BASE_FOUR_FLOATS_H

#include <stdint.h>
#include <string.h>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

typedef float qcFourFloats __attribute__((vector_size(16)));
typedef uint32_t qcFourWords __attribute__((vector_size(16)));

/// No alignment is needed.
static inline qcFourFloats qcFourFloats_Load(const void* from)
{
    qcFourFloats floats;
    memcpy(&floats, from, sizeof floats);
    return floats;
}

static inline void qcFourFloats_Store(qcFourFloats floats, void* to)
{
    memcpy(to, &floats, sizeof floats);
}

/// All bits of each place in which one of both is no number.
static inline qcFourWords qcFourFloats_AreUnordered(qcFourFloats a, qcFourFloats b)
{
#ifdef __SSE__
    return (qcFourWords)_mm_cmpunord_ps((__m128)a, (__m128)b);
#else
    return (qcFourWords)((a != a) | (b != b));
#endif
}

/// The second where one is no number.
static inline qcFourFloats qcFourFloats_Min(qcFourFloats a, qcFourFloats b)
{
#ifdef __SSE__
    return (qcFourFloats)_mm_min_ps((__m128)a, (__m128)b);
#else
    for (int i = 0; i < 4; i++)
        a[i] = a[i] < b[i] ? a[i] : b[i];
    return a;
#endif
}

static inline qcFourFloats qcFourFloats_Max(qcFourFloats a, qcFourFloats b)
{
#ifdef __SSE__
    return (qcFourFloats)_mm_max_ps((__m128)a, (__m128)b);
#else
    for (int i = 0; i < 4; i++)
        a[i] = a[i] > b[i] ? a[i] : b[i];
    return a;
#endif
}

#endif
