// XXH64: Yann Collet, xxHash fast digest algorithm, version 0.1.1. Four lanes of eight bytes each; the rest in words,
// then bytes.
#include "quickcullide/hash.h"

#include <string.h>

static const uint64_t s_prime1 = 0x9e3779b185ebca87u, s_prime2 = 0xc2b2ae3d27d4eb4fu, s_prime3 = 0x165667b19e3779f9u,
                      s_prime4 = 0x85ebca77c2b2ae63u, s_prime5 = 0x27d4eb2f165667c5u;

static inline uint64_t RotateLeft(uint64_t x, int bits)
{
    return x << bits | x >> (64 - bits);
}

static inline uint64_t Read64(const unsigned char* at)
{
    uint64_t word;
    memcpy(&word, at, sizeof word);
    return word;
}

static inline uint32_t Read32(const unsigned char* at)
{
    uint32_t word;
    memcpy(&word, at, sizeof word);
    return word;
}

static inline uint64_t Round(uint64_t lane, uint64_t word)
{
    return RotateLeft(lane + word * s_prime2, 31) * s_prime1;
}

static inline uint64_t MergeLane(uint64_t hash, uint64_t lane)
{
    return (hash ^ Round(0, lane)) * s_prime1 + s_prime4;
}

/// The stripes of 32 bytes; *at moves behind them.
static uint64_t HashStripes(const unsigned char** at, size_t stripes, uint64_t seed)
{
    uint64_t a = seed + s_prime1 + s_prime2, b = seed + s_prime2, c = seed, d = seed - s_prime1;
    const unsigned char* p = *at;
    for (size_t i = 0; i < stripes; i++, p += 32)
    {
        a = Round(a, Read64(p));
        b = Round(b, Read64(p + 8));
        c = Round(c, Read64(p + 16));
        d = Round(d, Read64(p + 24));
    }
    *at = p;
    uint64_t hash = RotateLeft(a, 1) + RotateLeft(b, 7) + RotateLeft(c, 12) + RotateLeft(d, 18);
    return MergeLane(MergeLane(MergeLane(MergeLane(hash, a), b), c), d);
}

uint64_t qcXxh64(const void* data, size_t size, uint64_t seed)
{
    const unsigned char* at = data;
    uint64_t hash = (size >= 32 ? HashStripes(&at, size / 32, seed) : seed + s_prime5) + size;
    size_t left = size % 32;
    for (; left >= 8; left -= 8, at += 8)
        hash = RotateLeft(hash ^ Round(0, Read64(at)), 27) * s_prime1 + s_prime4;
    for (; left >= 4; left -= 4, at += 4)
        hash = RotateLeft(hash ^ Read32(at) * s_prime1, 23) * s_prime2 + s_prime3;
    for (; left > 0; left--, at++)
        hash = RotateLeft(hash ^ *at * s_prime5, 11) * s_prime1;
    hash = (hash ^ hash >> 33) * s_prime2;
    hash = (hash ^ hash >> 29) * s_prime3;
    return hash ^ hash >> 32;
}
