// Union-find (Galler, Fischer: An improved equivalence algorithm, 1964) whose links carry a sign: members of a set are
// equal or opposite to each other.
#ifndef QC_MANIFOLD_SIGNED_SETS_H
#define QC_MANIFOLD_SIGNED_SETS_H

#include <stdbool.h>
#include <stdint.h>

/// A node is twice its parent, plus 1 if it is opposite to it. Returns the root in this form.
static inline uint32_t qcSignedSets_Find(uint32_t* nodes, uint32_t i)
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

/// The lower root becomes the common one. False if the two are in one set already: their signs in it stay.
static inline bool qcSignedSets_Unite(uint32_t* nodes, uint32_t i, uint32_t j, uint32_t opposite)
{
    uint32_t a = qcSignedSets_Find(nodes, i), b = qcSignedSets_Find(nodes, j);
    uint32_t relation = (a ^ b ^ opposite) & 1u;
    if (a >> 1 < b >> 1)
        nodes[b >> 1] = (a & ~1u) | relation;
    else if (b >> 1 < a >> 1)
        nodes[a >> 1] = (b & ~1u) | relation;
    return a >> 1 != b >> 1;
}

#endif
