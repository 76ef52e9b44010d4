// Links of nodes and their pair masks. A mask starts with all bits set; each shared vertex clears the pairs of
// triangles that have it, a word at a time; a node's masks are packed when they are done. Links all of whose pairs are
// neighbours, as in a large fan, share one mask.
#include "mesh/clusters.h"

#include "mesh/cluster_order.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_clustersOfNode = qc_nodeSize / qc_clusterSize
};

/// A vertex in a node: a bit for each of the node's triangles that has it.
typedef struct Share
{
    uint64_t triangles;
    uint32_t node;
} Share;

typedef struct Builder
{
    qcClusters* clusters;
    const uint32_t* indices;
    uint32_t vertexCount;
    uint32_t usedCount; ///< vertices of triangles
    qcArray corners;    ///< of qcCorners, by slot
    qcArray vertexOf;   ///< uint32_t, of each of them: its number in the body
    qcArray filled;     ///< uint64_t of each node: a bit for each slot with a triangle
    qcArray first;      ///< uint32_t of each vertex and one more: where its shares begin
    qcArray next;       ///< uint32_t of each vertex: its first share that is not visited yet
    qcArray shares;     ///< of Share, each vertex's ordered by node
    qcArray seen;  ///< uint32_t of each node: the last link to it, plus 1; then its mask among `words`, plus 1, or 0
    qcArray items; ///< of qcSortItem: node and other node, whether all their triangles are neighbours
    qcArray words; ///< uint64_t: the masks of the node that is visited, not packed
} Builder;

/// Called for two nodes, the same or in order, that share a vertex.
typedef qcStatus Visit(Builder* b, const Share* share, const Share* other);

static void Free(Builder* b)
{
    qcArray_Free(&b->corners);
    qcArray_Free(&b->vertexOf);
    qcArray_Free(&b->filled);
    qcArray_Free(&b->first);
    qcArray_Free(&b->next);
    qcArray_Free(&b->shares);
    qcArray_Free(&b->seen);
    qcArray_Free(&b->items);
    qcArray_Free(&b->words);
}

static bool HasTriangle(const Builder* b, size_t slot)
{
    return QC_AT(uint32_t, b->clusters->triangles, slot) != QC_NO_TRIANGLE;
}

uint32_t qcClusters_FindLink(const qcClusters* clusters, uint32_t node, uint32_t other)
{
    const qcLeafLink* links = clusters->links.data;
    const uint32_t* first = clusters->firstLink.data;
    for (uint32_t i = first[node]; i < first[node + 1]; i++)
        if (links[i].other == other)
            return i;
    return QC_NO_LINK;
}

qcStatus qcClusters_NumberVertices(const qcClusters* c, const uint32_t* indices, uint32_t vertexCount, qcArray* corners,
                                   qcArray* vertexOf)
{
    qcArray numbers = {0};
    vertexOf->count = 0;
    QC_TRY(qcArray_Resize(corners, c->triangles.count, sizeof(qcCorners), "vertices of nodes"));
    QC_TRY(qcArray_Reserve(vertexOf, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&numbers, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    if (vertexCount != 0)
        memset(numbers.data, 0xff, vertexCount * sizeof(uint32_t));
    for (size_t i = 0; i < c->triangles.count; i++)
    {
        uint32_t t = QC_AT(uint32_t, c->triangles, i);
        for (int k = 0; k < 3 && t != QC_NO_TRIANGLE; k++)
        {
            uint32_t vertex = indices[3 * (size_t)t + k], *number = &QC_AT(uint32_t, numbers, vertex);
            if (*number == UINT32_MAX)
            {
                *number = (uint32_t)vertexOf->count;
                QC_AT(uint32_t, *vertexOf, vertexOf->count++) = vertex;
            }
            QC_AT(qcCorners, *corners, i).vertex[k] = *number;
        }
    }
    qcArray_Free(&numbers);
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3 && QC_AT(uint32_t, c->triangles, i) == QC_NO_TRIANGLE; k++)
            QC_AT(qcCorners, *corners, i).vertex[k] = (uint32_t)vertexOf->count;
    return qc_statusOk;
}

/// Lists the shares of each vertex, node by node, so that they are ordered.
static qcStatus FindShares(Builder* b)
{
    const qcClusters* c = b->clusters;
    size_t bytes = ((size_t)b->usedCount + 1) * sizeof(uint32_t);
    QC_TRY(qcArray_Resize(&b->filled, c->nodeCount, sizeof(uint64_t), "nodes of triangles"));
    QC_TRY(qcArray_Resize(&b->seen, c->nodeCount, sizeof(uint32_t), "nodes of triangles"));
    QC_TRY(qcArray_Resize(&b->first, (size_t)b->usedCount + 1, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&b->next, (size_t)b->usedCount + 1, sizeof(uint32_t), "vertices of nodes"));
    uint32_t *first = b->first.data, *next = b->next.data;
    memset(first, 0, bytes);
    memset(next, 0, bytes); // in this loop: the last node that has the vertex, plus 1
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3 && HasTriangle(b, i); k++)
        {
            uint32_t v = QC_AT(qcCorners, b->corners, i).vertex[k], stamp = (uint32_t)(i / qc_nodeSize) + 1;
            first[v] += next[v] != stamp;
            next[v] = stamp;
        }
    uint32_t total = 0;
    for (uint32_t v = 0; v <= b->usedCount; v++)
    {
        uint32_t count = first[v];
        first[v] = next[v] = total;
        total += count;
    }
    QC_TRY(qcArray_Resize(&b->shares, total, sizeof(Share), "vertices of nodes"));
    for (size_t i = 0; i < c->triangles.count; i++)
    {
        uint32_t node = (uint32_t)(i / qc_nodeSize);
        uint64_t bit = UINT64_C(1) << i % qc_nodeSize, *filled = &QC_AT(uint64_t, b->filled, node);
        *filled = (i % qc_nodeSize != 0 ? *filled : 0) | (HasTriangle(b, i) ? bit : 0);
        for (int k = 0; k < 3 && HasTriangle(b, i); k++)
        {
            uint32_t v = QC_AT(qcCorners, b->corners, i).vertex[k];
            if (next[v] == first[v] || QC_AT(Share, b->shares, next[v] - 1).node != node)
                QC_AT(Share, b->shares, next[v]++) = (Share){0, node};
            QC_AT(Share, b->shares, next[v] - 1).triangles |= bit;
        }
    }
    return qc_statusOk;
}

/// Visits the node with itself and with later ones, once for each shared vertex. Nodes are visited in order: each visit
/// removes the node's shares from their vertices, so that each vertex of the node is processed once.
static qcStatus VisitNode(Builder* b, uint32_t node, Visit* visit)
{
    const Share* shares = b->shares.data;
    size_t slot = (size_t)node * qc_nodeSize;
    for (size_t end = slot + qc_nodeSize; slot < end; slot++)
        for (int k = 0; k < 3 && HasTriangle(b, slot); k++)
        {
            uint32_t v = QC_AT(qcCorners, b->corners, slot).vertex[k], own = QC_AT(uint32_t, b->next, v);
            uint32_t endOfShares = QC_AT(uint32_t, b->first, v + 1);
            if (own == endOfShares || shares[own].node != node)
                continue;
            QC_AT(uint32_t, b->next, v)++;
            for (uint32_t s = own; s < endOfShares; s++)
                QC_TRY(visit(b, &shares[own], &shares[s]));
        }
    return qc_statusOk;
}

static void RewindVisits(Builder* b)
{
    memcpy(b->next.data, b->first.data, b->first.count * sizeof(uint32_t));
}

static qcStatus AddLink(Builder* b, const Share* share, const Share* other)
{
    uint32_t* seen = &QC_AT(uint32_t, b->seen, other->node);
    uint64_t key = (uint64_t)share->node << 32 | other->node;
    if (*seen == 0 || QC_AT(qcSortItem, b->items, *seen - 1).key != key)
    {
        if (b->items.count == UINT32_MAX - 1)
            return qcFailMemory(SIZE_MAX, "more than 2^32 - 2 links of nodes");
        QC_TRY(qcArray_Resize(&b->items, b->items.count + 1, sizeof(qcSortItem), "links of nodes"));
        *seen = (uint32_t)b->items.count;
        QC_AT(qcSortItem, b->items, *seen - 1) = (qcSortItem){key, false};
    }
    if (share->triangles == QC_AT(uint64_t, b->filled, share->node) &&
        other->triangles == QC_AT(uint64_t, b->filled, other->node))
        QC_AT(qcSortItem, b->items, *seen - 1).value = true;
    return qc_statusOk;
}

/// Lists the links in order. Those all of whose pairs are neighbours already have their mask: the shared one.
static qcStatus FindLinks(Builder* b)
{
    qcClusters* c = b->clusters;
    RewindVisits(b);
    if (c->nodeCount != 0)
        memset(b->seen.data, 0, c->nodeCount * sizeof(uint32_t));
    for (uint32_t node = 0; node < c->nodeCount; node++)
        QC_TRY(VisitNode(b, node, AddLink));

    qcArray scratch = {0};
    qcStatus status = qcSort_Items(b->items.data, b->items.count, &scratch);
    qcArray_Free(&scratch);
    QC_TRY(status);

    QC_TRY(qcArray_Resize(&c->firstLink, (size_t)c->nodeCount + 1, sizeof(uint32_t), "links of nodes"));
    QC_TRY(qcArray_Resize(&c->links, b->items.count, sizeof(qcLeafLink), "links of nodes"));
    const qcSortItem* items = b->items.data;
    uint32_t node = 0;
    QC_AT(uint32_t, c->firstLink, 0) = 0;
    for (size_t i = 0; i < b->items.count; i++)
    {
        while (node < items[i].key >> 32)
            QC_AT(uint32_t, c->firstLink, ++node) = (uint32_t)i;
        QC_AT(qcLeafLink, c->links, i) = (qcLeafLink){(uint32_t)items[i].key, items[i].value ? 0 : UINT32_MAX};
    }
    while (node < c->nodeCount)
        QC_AT(uint32_t, c->firstLink, ++node) = (uint32_t)b->items.count;
    return qc_statusOk;
}

/// The pairs of a mask's word whose triangles both exist and, in one node, are in order.
static uint64_t PairsOfWord(uint32_t word, uint64_t filledA, uint64_t filledB, bool isSame)
{
    uint32_t i = word % qc_clustersOfNode, j = word / qc_clustersOfNode;
    uint64_t all = qcPairMask_Product(qcPairMask_OfCluster(filledA, i), qcPairMask_OfCluster(filledB, j));
    if (!isSame || i < j)
        return all;
    return i == j ? all & QC_PAIRS_IN_ORDER : 0;
}

static void FillMask(uint64_t* mask, uint64_t filledA, uint64_t filledB, bool isSame)
{
    for (uint32_t word = 0; word < qc_pairMaskWords; word++)
        mask[word] = PairsOfWord(word, filledA, filledB, isSame);
}

static uint64_t* WordsOf(const Builder* b, uint32_t number)
{
    return &QC_AT(uint64_t, b->words, (size_t)(number - 1) * qc_pairMaskWords);
}

static qcStatus ClearNeighbours(Builder* b, const Share* share, const Share* other)
{
    uint32_t number = QC_AT(uint32_t, b->seen, other->node);
    if (number == 0)
        return qc_statusOk;
    uint64_t* mask = WordsOf(b, number);
    for (int j = 0; j < qc_clustersOfNode; j++)
    {
        unsigned clusterB = qcPairMask_OfCluster(other->triangles, (uint32_t)j);
        for (int i = 0; i < qc_clustersOfNode && clusterB != 0; i++)
            mask[i + j * qc_clustersOfNode] &=
                ~qcPairMask_Product(qcPairMask_OfCluster(share->triangles, (uint32_t)i), clusterB);
    }
    return qc_statusOk;
}

/// Pairs of existing triangles of a link.
static uint64_t CountPairs(uint64_t filledA, uint64_t filledB, bool isSame)
{
    uint64_t n = (uint64_t)__builtin_popcountll(filledA), m = (uint64_t)__builtin_popcountll(filledB);
    return isSame ? n * (n - 1) / 2 : n * m;
}

/// Appends a mask; adds the number of its pairs to *pairs.
static qcStatus AddMask(qcClusters* c, const uint64_t words[qc_pairMaskWords], uint32_t* offset, uint64_t* pairs)
{
    size_t at = c->pairMasks.count;
    // One word more, which qcPairMask_Word may read.
    if (at > UINT32_MAX - qc_maxPairMaskSize - 1)
        return qcFailMemory(SIZE_MAX, "more than 2^32 words of pair masks");
    QC_TRY(qcArray_Reserve(&c->pairMasks, at + qc_maxPairMaskSize + 1, sizeof(uint64_t), "pairs of near nodes"));
    c->pairMasks.count += qcPairMask_Pack(words, &QC_AT(uint64_t, c->pairMasks, at));
    *offset = (uint32_t)at;
    for (uint32_t i = 0; i < qc_pairMaskWords; i++)
        *pairs += (uint64_t)__builtin_popcountll(words[i]);
    return qc_statusOk;
}

/// Makes the masks of a node's links, where these are not shared.
static qcStatus FillMasksOf(Builder* b, uint32_t node)
{
    qcClusters* c = b->clusters;
    const uint64_t* filled = b->filled.data;
    uint32_t first = QC_AT(uint32_t, c->firstLink, node), end = QC_AT(uint32_t, c->firstLink, node + 1), number = 0;
    QC_TRY(
        qcArray_Resize(&b->words, (size_t)(end - first) * qc_pairMaskWords, sizeof(uint64_t), "pairs of near nodes"));
    for (uint32_t l = first; l < end; l++)
    {
        qcLeafLink link = QC_AT(qcLeafLink, c->links, l);
        bool own = link.mask != 0;
        QC_AT(uint32_t, b->seen, link.other) = own ? ++number : 0;
        if (own)
            FillMask(WordsOf(b, number), filled[node], filled[link.other], link.other == node);
    }
    QC_TRY(VisitNode(b, node, ClearNeighbours));
    number = 0;
    for (uint32_t l = first; l < end; l++)
    {
        qcLeafLink* link = &QC_AT(qcLeafLink, c->links, l);
        uint64_t pairs = 0;
        if (link->mask != 0)
            QC_TRY(AddMask(c, WordsOf(b, ++number), &link->mask, &pairs));
        c->neighbourCount += CountPairs(filled[node], filled[link->other], link->other == node) - pairs;
    }
    return qc_statusOk;
}

static qcStatus FillMasks(Builder* b)
{
    qcClusters* c = b->clusters;
    // All zero: the shared mask.
    static const uint64_t zero[qc_pairMaskWords] = {0};
    uint32_t offset;
    uint64_t pairs = 0;
    QC_TRY(AddMask(c, zero, &offset, &pairs));
    RewindVisits(b);
    for (uint32_t node = 0; node < c->nodeCount; node++)
        QC_TRY(FillMasksOf(b, node));
    // There is room for it.
    QC_AT(uint64_t, c->pairMasks, c->pairMasks.count++) = 0;
    return qcArray_Trim(&c->pairMasks, sizeof(uint64_t), "pairs of near nodes");
}

static qcStatus Link(Builder* b)
{
    qcClusters* c = b->clusters;
    QC_TRY(qcClusters_NumberVertices(c, b->indices, b->vertexCount, &b->corners, &b->vertexOf));
    b->usedCount = (uint32_t)b->vertexOf.count;
    QC_TRY(FindShares(b));
    QC_TRY(FindLinks(b));
    return FillMasks(b);
}

qcStatus qcClusters_Arrange(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                            const double* positions, uint32_t vertexCount, uint32_t threads)
{
    *clusters = (qcClusters){0};
    qcStatus status =
        qcClusterOrder_Make(&clusters->triangles, indices, triangleCount, positions, vertexCount, threads);
    if (status != qc_statusOk)
        qcClusters_Free(clusters);
    clusters->nodeCount = (uint32_t)(clusters->triangles.count / qc_nodeSize);
    return status;
}

void qcClusters_Unlink(qcClusters* clusters)
{
    qcArray_Free(&clusters->firstLink);
    qcArray_Free(&clusters->links);
    qcArray_Free(&clusters->pairMasks);
    clusters->neighbourCount = 0;
}

qcStatus qcClusters_Link(qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount)
{
    Builder builder = {.clusters = clusters, .indices = indices, .vertexCount = vertexCount};
    qcStatus status = Link(&builder);
    Free(&builder);
    if (status != qc_statusOk)
        qcClusters_Unlink(clusters);
    return status;
}

qcStatus qcClusters_Build(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                          const double* positions, uint32_t vertexCount, uint32_t threads)
{
    QC_TRY(qcClusters_Arrange(clusters, indices, triangleCount, positions, vertexCount, threads));
    qcStatus status = qcClusters_Link(clusters, indices, vertexCount);
    if (status != qc_statusOk)
        qcClusters_Free(clusters);
    return status;
}

static uint64_t FilledSlots(const uint32_t* triangles)
{
    uint64_t filled = 0;
    for (uint32_t i = 0; i < qc_nodeSize; i++)
        filled |= (uint64_t)(triangles[i] != QC_NO_TRIANGLE) << i;
    return filled;
}

/// The pairs that the mask lacks though both triangles exist and are in order.
qcSlotPair* qcClusters_FindNeighbours(const qcClusters* clusters, uint32_t node, uint32_t link, qcSlotPair* pairs)
{
    qcLeafLink to = QC_AT(qcLeafLink, clusters->links, link);
    const uint32_t *triangles = clusters->triangles.data, a = node * qc_nodeSize, b = to.other * qc_nodeSize;
    const uint64_t* mask = qcClusters_PairMask(clusters, link);
    uint64_t filledA = FilledSlots(triangles + a), filledB = FilledSlots(triangles + b), none = mask[1];
    for (uint64_t words = mask[0] | none; words != 0; words &= words - 1)
    {
        uint32_t word = (uint32_t)__builtin_ctzll(words), i = word % qc_clustersOfNode, j = word / qc_clustersOfNode;
        uint64_t left = PairsOfWord(word, filledA, filledB, node == to.other);
        if ((none >> word & 1u) == 0)
            left &= ~qcPairMask_Word(mask, word);
        for (; left != 0; left &= left - 1)
        {
            uint32_t bit = (uint32_t)__builtin_ctzll(left);
            *pairs++ = (qcSlotPair){a + i * qc_clusterSize + bit % qc_clusterSize,
                                    b + j * qc_clusterSize + bit / qc_clusterSize};
        }
    }
    return pairs;
}

void qcClusters_Free(qcClusters* clusters)
{
    qcArray_Free(&clusters->triangles);
    clusters->nodeCount = 0;
    qcClusters_Unlink(clusters);
}
