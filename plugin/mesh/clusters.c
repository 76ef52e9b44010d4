// Nodes that share a vertex, and a table of 64 x 64 bits for each two: ones, then for each vertex zeros where both
// triangles have it, by words; packed when the node's tables are done. Node pairs all of whose triangles are
// neighbours, as in a fan, have one table together.
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

/// A vertex in a node: which of the node's places have it.
typedef struct Share
{
    uint64_t places;
    uint32_t node;
} Share;

typedef struct Builder
{
    qcClusters* clusters;
    const uint32_t* indices;
    uint32_t vertexCount;
    uint32_t usedCount; ///< vertices that triangles have
    qcArray corners;    ///< of qcCorners, by place
    qcArray vertexOf;   ///< uint32_t, of each vertex that is used
    qcArray filled;     ///< uint64_t of each node: places that have a triangle
    qcArray first;      ///< uint32_t of each vertex and one more: where its shares begin
    qcArray next;       ///< uint32_t of each vertex: its first share that no visit has come to
    qcArray shares;     ///< of Share, each vertex's ordered by node
    qcArray seen;  ///< uint32_t of each node: the last link to it, plus 1; then its table among `words`, plus 1, or 0
    qcArray items; ///< of qcSortItem: node and other node, whether all their triangles are neighbours
    qcArray words; ///< uint64_t: the tables of the node that is visited, not packed
} Builder;

/// Two nodes, the same or in order, that have a vertex at these places.
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

static bool HasTriangle(const Builder* b, size_t place)
{
    return QC_AT(uint32_t, b->clusters->triangles, place) != QC_NO_TRIANGLE;
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

size_t qcClusters_PackTable(const uint64_t words[qc_tableWords], uint64_t packed[qc_maxTableSize])
{
    uint64_t some = 0, none = 0;
    size_t size = 2;
    for (uint32_t word = 0; word < qc_tableWords; word++)
    {
        bool isNone = words[word] == 0, isSome = !isNone && words[word] != UINT64_MAX;
        none |= (uint64_t)isNone << word;
        some |= (uint64_t)isSome << word;
        if (isSome)
            packed[size++] = words[word];
    }
    packed[0] = some;
    packed[1] = none;
    return size;
}

const uint64_t* qcClusters_OrderTable(void)
{
    static const uint64_t diagonal = UINT64_C(0x8040201008040201), b = QC_IN_ORDER;
    // Words i + 8 j with i > j have none; after the last is what qcClusters_Word may read.
    static const uint64_t table[] = {diagonal, UINT64_C(0x0080c0e0f0f8fcfe), b, b, b, b, b, b, b, b, 0};
    return table;
}

qcStatus qcClusters_NameVertices(const qcClusters* c, const uint32_t* indices, uint32_t vertexCount, qcArray* corners,
                                 qcArray* vertexOf)
{
    qcArray names = {0};
    vertexOf->count = 0;
    QC_TRY(qcArray_Resize(corners, c->triangles.count, sizeof(qcCorners), "vertices of nodes"));
    QC_TRY(qcArray_Reserve(vertexOf, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&names, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    if (vertexCount != 0)
        memset(names.data, 0xff, vertexCount * sizeof(uint32_t));
    for (size_t i = 0; i < c->triangles.count; i++)
    {
        uint32_t t = QC_AT(uint32_t, c->triangles, i);
        for (int k = 0; k < 3 && t != QC_NO_TRIANGLE; k++)
        {
            uint32_t vertex = indices[3 * (size_t)t + k], *name = &QC_AT(uint32_t, names, vertex);
            if (*name == UINT32_MAX)
            {
                *name = (uint32_t)vertexOf->count;
                QC_AT(uint32_t, *vertexOf, vertexOf->count++) = vertex;
            }
            QC_AT(qcCorners, *corners, i).vertex[k] = *name;
        }
    }
    qcArray_Free(&names);
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3 && QC_AT(uint32_t, c->triangles, i) == QC_NO_TRIANGLE; k++)
            QC_AT(qcCorners, *corners, i).vertex[k] = (uint32_t)vertexOf->count;
    return qc_statusOk;
}

/// Gives each vertex its shares, node by node, so that they come ordered.
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
    memset(next, 0, bytes); // for now: the last node that had the vertex, plus 1
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
            QC_AT(Share, b->shares, next[v] - 1).places |= bit;
        }
    }
    return qc_statusOk;
}

/// Visits the node with itself and with later ones, once for each vertex that they have. For nodes in order: each visit
/// takes the node's shares off their vertices, so that a vertex met again at another triangle is known.
static qcStatus VisitNode(Builder* b, uint32_t node, Visit* visit)
{
    const Share* shares = b->shares.data;
    size_t place = (size_t)node * qc_nodeSize;
    for (size_t end = place + qc_nodeSize; place < end; place++)
        for (int k = 0; k < 3 && HasTriangle(b, place); k++)
        {
            uint32_t v = QC_AT(qcCorners, b->corners, place).vertex[k], own = QC_AT(uint32_t, b->next, v);
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
    if (share->places == QC_AT(uint64_t, b->filled, share->node) &&
        other->places == QC_AT(uint64_t, b->filled, other->node))
        QC_AT(qcSortItem, b->items, *seen - 1).value = true;
    return qc_statusOk;
}

/// Links in order. Those of nodes all of whose triangles are neighbours have what is to be their table's place.
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

/// The pairs that a word of a table is about: both triangles exist and, in one node, are in order.
static uint64_t PairsOfWord(uint32_t word, uint64_t filledA, uint64_t filledB, bool isSame)
{
    uint32_t i = word % qc_clustersOfNode, j = word / qc_clustersOfNode;
    uint64_t all = qcClusters_Product(qcClusters_PlacesOf(filledA, i), qcClusters_PlacesOf(filledB, j));
    if (!isSame || i < j)
        return all;
    return i == j ? all & QC_IN_ORDER : 0;
}

static void FillTable(uint64_t* table, uint64_t filledA, uint64_t filledB, bool isSame)
{
    for (uint32_t word = 0; word < qc_tableWords; word++)
        table[word] = PairsOfWord(word, filledA, filledB, isSame);
}

static uint64_t* WordsOf(const Builder* b, uint32_t number)
{
    return &QC_AT(uint64_t, b->words, (size_t)(number - 1) * qc_tableWords);
}

static qcStatus ClearNeighbours(Builder* b, const Share* share, const Share* other)
{
    uint32_t number = QC_AT(uint32_t, b->seen, other->node);
    if (number == 0)
        return qc_statusOk;
    uint64_t* table = WordsOf(b, number);
    for (int j = 0; j < qc_clustersOfNode; j++)
    {
        unsigned placesB = qcClusters_PlacesOf(other->places, (uint32_t)j);
        for (int i = 0; i < qc_clustersOfNode && placesB != 0; i++)
            table[i + j * qc_clustersOfNode] &=
                ~qcClusters_Product(qcClusters_PlacesOf(share->places, (uint32_t)i), placesB);
    }
    return qc_statusOk;
}

/// Pairs that a table could have.
static uint64_t CountPairs(uint64_t filledA, uint64_t filledB, bool isSame)
{
    uint64_t n = (uint64_t)__builtin_popcountll(filledA), m = (uint64_t)__builtin_popcountll(filledB);
    return isSame ? n * (n - 1) / 2 : n * m;
}

/// Adds a table; counts the pairs that it has.
static qcStatus AddTable(qcClusters* c, const uint64_t words[qc_tableWords], uint32_t* place, uint64_t* pairs)
{
    size_t at = c->tables.count;
    // One more is what qcClusters_Word may read.
    if (at > UINT32_MAX - qc_maxTableSize - 1)
        return qcFailMemory(SIZE_MAX, "more than 2^32 words of tables of nodes");
    QC_TRY(qcArray_Reserve(&c->tables, at + qc_maxTableSize + 1, sizeof(uint64_t), "pairs of near nodes"));
    c->tables.count += qcClusters_PackTable(words, &QC_AT(uint64_t, c->tables, at));
    *place = (uint32_t)at;
    for (uint32_t i = 0; i < qc_tableWords; i++)
        *pairs += (uint64_t)__builtin_popcountll(words[i]);
    return qc_statusOk;
}

/// Those of the node's links that have one of their own.
static qcStatus FillTablesOf(Builder* b, uint32_t node)
{
    qcClusters* c = b->clusters;
    const uint64_t* filled = b->filled.data;
    uint32_t first = QC_AT(uint32_t, c->firstLink, node), end = QC_AT(uint32_t, c->firstLink, node + 1), number = 0;
    QC_TRY(qcArray_Resize(&b->words, (size_t)(end - first) * qc_tableWords, sizeof(uint64_t), "pairs of near nodes"));
    for (uint32_t l = first; l < end; l++)
    {
        qcLeafLink link = QC_AT(qcLeafLink, c->links, l);
        bool own = link.table != 0;
        QC_AT(uint32_t, b->seen, link.other) = own ? ++number : 0;
        if (own)
            FillTable(WordsOf(b, number), filled[node], filled[link.other], link.other == node);
    }
    QC_TRY(VisitNode(b, node, ClearNeighbours));
    number = 0;
    for (uint32_t l = first; l < end; l++)
    {
        qcLeafLink* link = &QC_AT(qcLeafLink, c->links, l);
        uint64_t pairs = 0;
        if (link->table != 0)
            QC_TRY(AddTable(c, WordsOf(b, ++number), &link->table, &pairs));
        c->neighbourCount += CountPairs(filled[node], filled[link->other], link->other == node) - pairs;
    }
    return qc_statusOk;
}

static qcStatus FillTables(Builder* b)
{
    qcClusters* c = b->clusters;
    // All zero: for links that have none of their own, if there are any.
    static const uint64_t zero[qc_tableWords] = {0};
    uint32_t place;
    uint64_t pairs = 0;
    QC_TRY(AddTable(c, zero, &place, &pairs));
    RewindVisits(b);
    for (uint32_t node = 0; node < c->nodeCount; node++)
        QC_TRY(FillTablesOf(b, node));
    // There is room for it.
    QC_AT(uint64_t, c->tables, c->tables.count++) = 0;
    return qcArray_Trim(&c->tables, sizeof(uint64_t), "pairs of near nodes");
}

static qcStatus Link(Builder* b)
{
    qcClusters* c = b->clusters;
    QC_TRY(qcClusters_NameVertices(c, b->indices, b->vertexCount, &b->corners, &b->vertexOf));
    b->usedCount = (uint32_t)b->vertexOf.count;
    QC_TRY(FindShares(b));
    QC_TRY(FindLinks(b));
    return FillTables(b);
}

qcStatus qcClusters_Lay(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                        uint32_t vertexCount, uint32_t threads)
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
    qcArray_Free(&clusters->tables);
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
    QC_TRY(qcClusters_Lay(clusters, indices, triangleCount, positions, vertexCount, threads));
    qcStatus status = qcClusters_Link(clusters, indices, vertexCount);
    if (status != qc_statusOk)
        qcClusters_Free(clusters);
    return status;
}

static uint64_t FilledPlaces(const uint32_t* triangles)
{
    uint64_t filled = 0;
    for (uint32_t i = 0; i < qc_nodeSize; i++)
        filled |= (uint64_t)(triangles[i] != QC_NO_TRIANGLE) << i;
    return filled;
}

/// What the table leaves out though both triangles exist and come in order.
qcSlotPair* qcClusters_FindNeighbours(const qcClusters* clusters, uint32_t node, uint32_t link, qcSlotPair* pairs)
{
    qcLeafLink to = QC_AT(qcLeafLink, clusters->links, link);
    const uint32_t *triangles = clusters->triangles.data, a = node * qc_nodeSize, b = to.other * qc_nodeSize;
    const uint64_t* table = qcClusters_Table(clusters, link);
    uint64_t filledA = FilledPlaces(triangles + a), filledB = FilledPlaces(triangles + b), none = table[1];
    for (uint64_t words = table[0] | none; words != 0; words &= words - 1)
    {
        uint32_t word = (uint32_t)__builtin_ctzll(words), i = word % qc_clustersOfNode, j = word / qc_clustersOfNode;
        uint64_t left = PairsOfWord(word, filledA, filledB, node == to.other);
        if ((none >> word & 1u) == 0)
            left &= ~qcClusters_Word(table, word);
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
