// Vectors of coordinates: GCC 12 makes scalar instructions of loops over arrays of this size.
#ifndef QC_GLUE_COMMON_LANES_H
#define QC_GLUE_COMMON_LANES_H

#include <LinearMath/btScalar.h>

#include <cstddef>
#include <cstdint>
#include <cstring>

#ifdef __SSE2__
#include <emmintrin.h>
#endif

typedef btScalar qcLanes __attribute__((vector_size(16)));
constexpr size_t qcLaneCount = sizeof(qcLanes) / sizeof(btScalar);

inline qcLanes qcLoadLanes(const btScalar* at)
{
    qcLanes lanes;
    std::memcpy(&lanes, at, sizeof lanes);
    return lanes;
}

/// True if a comparison of lanes holds in one of them.
template <typename Comparison> bool qcIsAny(const Comparison& comparison)
{
    static_assert(sizeof(Comparison) == sizeof(qcLanes), "a comparison of lanes");
    uint64_t words[sizeof(qcLanes) / sizeof(uint64_t)], any = 0;
    std::memcpy(words, &comparison, sizeof words);
    for (uint64_t word : words)
        any |= word;
    return any != 0;
}

/// A bit for each lane in which a comparison holds, the first one lowest.
template <typename Comparison> unsigned qcBitsOf(const Comparison& comparison)
{
    static_assert(sizeof(Comparison) == sizeof(qcLanes), "a comparison of lanes");
#ifdef __SSE2__
    if (sizeof(btScalar) == sizeof(float))
        return unsigned(_mm_movemask_ps(__m128(comparison)));
    return unsigned(_mm_movemask_pd(__m128d(comparison)));
#else
    unsigned bits = 0;
    for (size_t i = 0; i < qcLaneCount; i++)
        bits |= unsigned(comparison[i] != 0) << i;
    return bits;
#endif
}

#endif
