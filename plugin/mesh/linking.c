// A mask starts with all bits set; each shared vertex clears the pairs of triangles that have it, a word at a time; a
// node's masks are packed when they are done. Links all of whose pairs are neighbours, as in a large fan, share one
// mask.
#include "mesh/linking.h"

#include "base/radix_sort.h"
#include "base/status.h"

#include <string.h>

/// A vertex in a node: a bit for each of the node's triangles that has it.
typedef struct Share
{
    uint64_t triangles;
    uint32_t node;
} Share;

/// Called for two nodes, the same or in order, that share a vertex.
typedef qcStatus Visit(qcLinking* b, const Share* share, const Share* other);

static bool HasTriangle(const qcLinking* b, size_t slot)
{
    return QC_AT(uint32_t, b->clusters->triangles, slot) != QC_NO_TRIANGLE;
}

/// Lists the shares of each vertex, node by node, so that they are ordered.
static qcStatus FindShares(qcLinking* b)
{
    const qcClusters* c = b->clusters;
    size_t bytes = ((size_t)b->vertexCount + 1) * sizeof(uint32_t);
    QC_TRY(qcArray_Resize(&b->filled, c->nodeCount, sizeof(uint64_t), "nodes of triangles"));
    QC_TRY(qcArray_Resize(&b->seen, c->nodeCount, sizeof(uint32_t), "nodes of triangles"));
    QC_TRY(qcArray_Resize(&b->first, (size_t)b->vertexCount + 1, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&b->next, (size_t)b->vertexCount + 1, sizeof(uint32_t), "vertices of nodes"));
    uint32_t *first = b->first.data, *next = b->next.data;
    memset(first, 0, bytes);
    memset(next, 0, bytes); // in this loop: the last node that has the vertex, plus 1
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3 && HasTriangle(b, i); k++)
        {
            uint32_t v = b->corners[i].vertex[k], stamp = (uint32_t)(i / qc_nodeSize) + 1;
            first[v] += next[v] != stamp;
            next[v] = stamp;
        }
    uint32_t total = 0;
    for (uint32_t v = 0; v <= b->vertexCount; v++)
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
            uint32_t v = b->corners[i].vertex[k];
            if (next[v] == first[v] || QC_AT(Share, b->shares, next[v] - 1).node != node)
                QC_AT(Share, b->shares, next[v]++) = (Share){0, node};
            QC_AT(Share, b->shares, next[v] - 1).triangles |= bit;
        }
    }
    return qc_statusOk;
}

/// Visits the node with itself and with later ones, once for each shared vertex. Nodes are visited in order: each visit
/// removes the node's shares from their vertices, so that each vertex of the node is processed once.
static qcStatus VisitNode(qcLinking* b, uint32_t node, Visit* visit)
{
    const Share* shares = b->shares.data;
    size_t slot = (size_t)node * qc_nodeSize;
    for (size_t end = slot + qc_nodeSize; slot < end; slot++)
        for (int k = 0; k < 3 && HasTriangle(b, slot); k++)
        {
            uint32_t v = b->corners[slot].vertex[k], own = QC_AT(uint32_t, b->next, v);
            uint32_t endOfShares = QC_AT(uint32_t, b->first, v + 1);
            if (own == endOfShares || shares[own].node != node)
                continue;
            QC_AT(uint32_t, b->next, v)++;
            for (uint32_t s = own; s < endOfShares; s++)
                QC_TRY(visit(b, &shares[own], &shares[s]));
        }
    return qc_statusOk;
}

static void RewindVisits(qcLinking* b)
{
    memcpy(b->next.data, b->first.data, b->first.count * sizeof(uint32_t));
}

static qcStatus AddLink(qcLinking* b, const Share* share, const Share* other)
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
static qcStatus FindLinks(qcLinking* b)
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

static void FillMask(uint64_t* mask, uint64_t filledA, uint64_t filledB, bool isSame)
{
    for (uint32_t word = 0; word < qc_pairMaskWords; word++)
        mask[word] = qcPairMask_PairsOfWord(word, filledA, filledB, isSame);
}

static uint64_t* WordsOf(const qcLinking* b, uint32_t number)
{
    return &QC_AT(uint64_t, b->words, (size_t)(number - 1) * qc_pairMaskWords);
}

static qcStatus ClearNeighbours(qcLinking* b, const Share* share, const Share* other)
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
static qcStatus FillMasksOf(qcLinking* b, uint32_t node)
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

static qcStatus Finish(qcLinking* b)
{
    qcArray* masks = &b->clusters->pairMasks;
    // There is room for it.
    QC_AT(uint64_t, *masks, masks->count++) = 0;
    return qcArray_Trim(masks, sizeof(uint64_t), "pairs of near nodes");
}

qcStatus qcLinking_Begin(qcLinking* linking, qcClusters* clusters, const qcCorners* corners, uint32_t vertexCount)
{
    *linking = (qcLinking){.clusters = clusters, .corners = corners, .vertexCount = vertexCount};
    return FindShares(linking);
}

qcStatus qcLinking_FindLinks(qcLinking* linking, qcClusters* clusters)
{
    linking->clusters = clusters;
    QC_TRY(FindLinks(linking));
    // All zero: the shared mask.
    static const uint64_t zero[qc_pairMaskWords] = {0};
    uint32_t offset;
    uint64_t pairs = 0;
    QC_TRY(AddMask(clusters, zero, &offset, &pairs));
    RewindVisits(linking);
    return clusters->nodeCount != 0 ? qc_statusOk : Finish(linking);
}

qcStatus qcLinking_Continue(qcLinking* linking, qcClusters* clusters, uint32_t nodeCount)
{
    uint32_t left = clusters->nodeCount - linking->nextNode;
    linking->clusters = clusters;
    for (uint32_t end = linking->nextNode + (nodeCount < left ? nodeCount : left); linking->nextNode < end;)
        QC_TRY(FillMasksOf(linking, linking->nextNode++));
    return left != 0 && linking->nextNode == clusters->nodeCount ? Finish(linking) : qc_statusOk;
}

void qcLinking_Free(qcLinking* linking)
{
    qcArray* arrays[] = {&linking->filled, &linking->first, &linking->next, &linking->shares,
                         &linking->seen,   &linking->items, &linking->words};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
    *linking = (qcLinking){.nextNode = 0};
}
