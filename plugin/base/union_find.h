// Disjoint sets whose members are equal or opposite to each other: union-find (Galler, Fischer: An improved equivalence
// algorithm, 1964) with a sign at each edge. Sets without signs pass 0 for `opposite`.
#ifndef QC_BASE_UNION_FIND_H
#define QC_BASE_UNION_FIND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/// A node is twice its parent, plus 1 if it is opposite to it. Indices are below 2^31.
static inline void qcUnionFind_Init(uint32_t* nodes, size_t count)
{
    for (size_t i = 0; i < count; i++)
        nodes[i] = (uint32_t)i << 1;
}

/// Twice the root of i, plus 1 if i is opposite to it. Halves the path.
static inline uint32_t qcUnionFind_Find(uint32_t* nodes, uint32_t i)
{
    uint32_t opposite = 0;
    while (nodes[i] >> 1 != i)
    {
        uint32_t up = nodes[nodes[i] >> 1];
        nodes[i] = (up & ~1u) | ((nodes[i] ^ up) & 1u);
        opposite ^= nodes[i] & 1u;
        i = nodes[i] >> 1;
    }
    return i << 1 | opposite;
}

/// Unites the sets of i and j; the lower root becomes the root. False: they are in one set already, and `opposite` is
/// ignored.
static inline bool qcUnionFind_Unite(uint32_t* nodes, uint32_t i, uint32_t j, uint32_t opposite)
{
    uint32_t a = qcUnionFind_Find(nodes, i), b = qcUnionFind_Find(nodes, j);
    uint32_t relation = (a ^ b ^ opposite) & 1u;
    if (a >> 1 < b >> 1)
        nodes[b >> 1] = (a & ~1u) | relation;
    else if (b >> 1 < a >> 1)
        nodes[a >> 1] = (b & ~1u) | relation;
    return a >> 1 != b >> 1;
}

#endif
