// Sixteen 16-bit integers side by side, for the orders of AVX2 and AVX-512. Comparisons of the latter's wider vectors
// go through masks, which takes longer.
#ifndef QC_MESH_SIXTEEN_SHORTS_H
#define QC_MESH_SIXTEEN_SHORTS_H

#include <immintrin.h>
#include <stdint.h>

enum
{
    qc_shorts = 16
};

typedef int16_t Shorts __attribute__((vector_size(32)));

static inline Shorts LoadShorts(const void* from)
{
    return (Shorts)_mm256_loadu_si256(from);
}

static inline Shorts MinShorts(Shorts a, Shorts b)
{
    return (Shorts)_mm256_min_epi16((__m256i)a, (__m256i)b);
}

static inline Shorts MaxShorts(Shorts a, Shorts b)
{
    return (Shorts)_mm256_max_epi16((__m256i)a, (__m256i)b);
}

#endif
