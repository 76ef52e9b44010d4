// Pair masks: which pairs of triangles of two leaf nodes are to be tested, a bit a pair, packed.
//
// A mask has 64 words. Word i + 8 j is about cluster i of the first node and cluster j of the second; its bit u + 8 v
// is about triangle u of the one cluster and triangle v of the other.
#ifndef QC_MESH_PAIR_MASK_H
#define QC_MESH_PAIR_MASK_H

#include "mesh/limits.h"

#include <stdbool.h>
#include <stddef.h>

enum
{
    qc_clustersOfNode = qc_nodeSize / qc_clusterSize,
    qc_pairMaskWords = qc_clustersOfNode * qc_clustersOfNode,
    qc_maxPairMaskSize = 2 + qc_pairMaskWords ///< packed
};

/// Bits u + 8 v with u < v: the pairs of a cluster with itself.
#define QC_PAIRS_IN_ORDER UINT64_C(0x7f3f1f0f07030100)

/// A word of a mask: the pairs of these triangles of two clusters, a bit for each triangle.
static inline uint64_t qcPairMask_Product(unsigned a, unsigned b)
{
    // Bit v of b to bit 8 v: seven bits by one multiplication, without carries; then a copy of a at each.
    uint64_t spread = ((b & 0x7fu) * UINT64_C(0x0002040810204081) & UINT64_C(0x0001010101010101)) | (uint64_t)(b >> 7)
                                                                                                        << 56;
    return spread * a;
}

/// The bits of one cluster, from a bit for each triangle of its node.
static inline unsigned qcPairMask_OfCluster(uint64_t nodeBits, uint32_t cluster)
{
    return (unsigned)(nodeBits >> qc_clusterSize * cluster & 0xffu);
}

/// A word's pairs of existing triangles, each pair of one node once. `filledA`, `filledB`: a bit for each triangle that
/// exists in the nodes.
static inline uint64_t qcPairMask_PairsOfWord(uint32_t word, uint64_t filledA, uint64_t filledB, bool isSame)
{
    uint32_t i = word % qc_clustersOfNode, j = word / qc_clustersOfNode;
    uint64_t all = qcPairMask_Product(qcPairMask_OfCluster(filledA, i), qcPairMask_OfCluster(filledB, j));
    if (!isSame || i < j)
        return all;
    return i == j ? all & QC_PAIRS_IN_ORDER : 0;
}

/// The triangles of the first cluster that have a bit in a word: bit u.
static inline uint32_t qcPairMask_FirstOfWord(uint64_t word)
{
    word |= word >> 32;
    word |= word >> 16;
    word |= word >> 8;
    return (uint32_t)word & 0xffu;
}

enum
{
    qc_maxExclusions = 4
};

/// Pairs of two nodes that need no test: those of a triangle in `a` with one in `b`.
typedef struct qcPairExclusion
{
    uint64_t a, b; ///< a bit for each triangle of the node
} qcPairExclusion;

/// Packs a mask; returns its size in words. Most words of most masks have all bits set, or none: a packed mask has a
/// bit for each word that has some, a bit for each word that has none, then the former words in order.
size_t qcPairMask_Pack(const uint64_t words[qc_pairMaskWords], uint64_t packed[qc_maxPairMaskSize]);

/// A word of a packed mask that has any bits. Reads one word more than the mask has, without using it.
static inline uint64_t qcPairMask_Word(const uint64_t* packed, uint32_t word)
{
    uint64_t below = (UINT64_C(1) << word) - 1;
    // Without a branch: which words are packed follows no pattern.
    return packed[2 + __builtin_popcountll(packed[0] & below)] | ((packed[0] >> word & 1) - 1);
}

/// The packed mask of all pairs within one node, each once, as if no two of its triangles shared a vertex.
const uint64_t* qcPairMask_OfOneNode(void);

#endif
