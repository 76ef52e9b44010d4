// Sums of hashes tell whether two lists hold the same pairs, in any order.
#ifndef QC_DEMOS_BENCH_PEERS_PAIR_HASH_H
#define QC_DEMOS_BENCH_PEERS_PAIR_HASH_H

#include <stdint.h>

/// A hash of a pair of triangles, the same in either order.
static inline uint64_t qcHashOfPair(uint32_t bodyA, uint32_t triangleA, uint32_t bodyB, uint32_t triangleB)
{
    uint64_t a = (uint64_t)bodyA << 32 | triangleA, b = (uint64_t)bodyB << 32 | triangleB;
    uint64_t z = (a < b ? a : b) * 0x9e3779b97f4a7c15u + (a < b ? b : a);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

#endif
