// Numbers of vertices, links and neighbours of clusters.
#include "mesh/clusters.h"

#include "mesh/linking.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Slots from a triangle to the one whose indices are fetched, and to the one whose vertices' numbers are (1 M
    // triangles: 13.8 ms without the latter, 8.8 with it).
    qc_indicesAhead = 32,
    qc_numbersAhead = 8,
    // Parts that are numbered side by side; a part of so many slots takes 50 microseconds.
    qc_maxParts = 8,
    qc_minPart = 4096,
    // Clusters whose vertices are listed in some microseconds.
    qc_listedClusters = 512,
    qc_minListed = 8
};

uint32_t qcClusters_FindLink(const qcClusters* clusters, uint32_t node, uint32_t other)
{
    const qcLeafLink* links = clusters->links.data;
    const uint32_t* first = clusters->firstLink.data;
    for (uint32_t i = first[node]; i < first[node + 1]; i++)
        if (links[i].other == other)
            return i;
    return QC_NO_LINK;
}

//  ---- numbers of vertices -------------------------------------------------------------------------

/// Slots that one thread numbers on its own, and the vertices that they use, in the order of first use.
typedef struct Part
{
    size_t first, end;
    uint32_t *numbers, *used; ///< by the body's vertex; by the part's number
    uint32_t usedCount;
} Part;

typedef struct Numbering
{
    const uint32_t *triangles, *indices;
    uint32_t vertexCount, usedCount;
    qcCorners* corners;
    Part parts[qc_maxParts];
    size_t partCount;
} Numbering;

/// The indices of the triangle some slots later, or of any one.
static const uint32_t* IndicesAhead(const Numbering* n, const Part* part, size_t slot, size_t ahead)
{
    size_t later = slot + ahead < part->end ? slot + ahead : slot;
    return n->indices + 3 * (size_t)(n->triangles[later] != QC_NO_TRIANGLE ? n->triangles[later] : 0);
}

static void NumberPart(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    Numbering* n = context;
    Part* part = &n->parts[i];
    uint32_t *numbers = part->numbers, *used = part->used, count = 0;
    if (n->vertexCount != 0)
        memset(numbers, 0xff, n->vertexCount * sizeof(uint32_t));
    for (size_t slot = part->first; slot < part->end; slot++)
    {
        __builtin_prefetch(IndicesAhead(n, part, slot, qc_indicesAhead));
        const uint32_t* soon = IndicesAhead(n, part, slot, qc_numbersAhead);
        for (int k = 0; k < 3; k++)
            __builtin_prefetch(&numbers[soon[k]], 1);
        if (n->triangles[slot] == QC_NO_TRIANGLE)
            continue;
        qcCorners corners;
        for (int k = 0; k < 3; k++)
        {
            // Without branches: a new vertex comes as if by chance.
            uint32_t vertex = n->indices[3 * (size_t)n->triangles[slot] + (size_t)k];
            uint32_t number = numbers[vertex], isNew = number == UINT32_MAX;
            number ^= (number ^ count) & (0 - isNew);
            used[count] = vertex;
            numbers[vertex] = number;
            count += isNew;
            corners.vertex[k] = number;
        }
        n->corners[slot] = corners;
    }
    part->usedCount = count;
}

/// Appends the vertices of later parts to those of the first one, and turns the list of each later part into the final
/// numbers: those that one pass over all slots would have given.
static void JoinParts(Numbering* n)
{
    uint32_t *number = n->parts[0].numbers, *used = n->parts[0].used, count = n->parts[0].usedCount;
    for (size_t p = 1; p < n->partCount; p++)
        for (uint32_t i = 0; i < n->parts[p].usedCount; i++)
        {
            uint32_t v = n->parts[p].used[i];
            bool isNew = number[v] == UINT32_MAX;
            used[count] = v;
            number[v] = isNew ? count : number[v];
            count += isNew;
            n->parts[p].used[i] = number[v];
        }
    n->usedCount = count;
}

/// Final numbers for the corners of a part.
static void RenumberPart(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Numbering* n = context;
    const Part* part = &n->parts[i];
    for (size_t slot = part->first; slot < part->end; slot++)
        for (int k = 0; k < 3; k++)
        {
            uint32_t* vertex = &n->corners[slot].vertex[k];
            if (n->triangles[slot] == QC_NO_TRIANGLE)
                *vertex = n->usedCount;
            else if (i != 0)
                *vertex = part->used[*vertex];
        }
}

/// Equal parts, at least qc_minPart slots each.
static void SplitSlots(Numbering* n, size_t slotCount, uint32_t threads)
{
    size_t max = threads < qc_maxParts ? threads : qc_maxParts, count = slotCount / qc_minPart;
    n->partCount = count < 1 ? 1 : count < max ? count : max;
    for (size_t i = 0; i < n->partCount; i++)
    {
        n->parts[i].first = i * slotCount / n->partCount;
        n->parts[i].end = (i + 1) * slotCount / n->partCount;
    }
}

/// Memory for all parts; the first one's list is the result.
static qcStatus ReserveParts(Numbering* n, qcArray* vertexOf, qcArray* scratch)
{
    size_t size = (size_t)n->vertexCount + 1;
    QC_TRY(qcArray_Reserve(vertexOf, size, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(scratch, (2 * n->partCount - 1) * size, sizeof(uint32_t), "vertices of nodes"));
    for (size_t i = 0; i < n->partCount; i++)
    {
        n->parts[i].numbers = &QC_AT(uint32_t, *scratch, 2 * i * size);
        n->parts[i].used = i == 0 ? vertexOf->data : &QC_AT(uint32_t, *scratch, (2 * i - 1) * size);
    }
    return qc_statusOk;
}

qcStatus qcClusters_NumberVertices(const qcClusters* c, const uint32_t* indices, uint32_t vertexCount, uint32_t threads,
                                   qcArray* corners, qcArray* vertexOf)
{
    qcArray scratch = {0};
    vertexOf->count = 0;
    QC_TRY(qcArray_Resize(corners, c->triangles.count, sizeof(qcCorners), "vertices of nodes"));
    Numbering n = {
        .triangles = c->triangles.data, .indices = indices, .vertexCount = vertexCount, .corners = corners->data};
    SplitSlots(&n, c->triangles.count, threads);
    qcStatus status = ReserveParts(&n, vertexOf, &scratch);
    if (status == qc_statusOk)
    {
        qcParallel_For(threads, n.partCount, 2, NumberPart, &n);
        JoinParts(&n);
        qcParallel_For(threads, n.partCount, 2, RenumberPart, &n);
        vertexOf->count = n.usedCount;
    }
    qcArray_Free(&scratch);
    return status;
}

typedef struct Listing
{
    const qcCorners* corners;
    uint32_t vertexCount;
    size_t clusterCount;
    qcClusterVertices* clusters;
} Listing;

static void ListBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Listing* l = context;
    size_t first = block * qc_listedClusters, left = l->clusterCount - first;
    size_t end = first + (left < qc_listedClusters ? left : qc_listedClusters);
    for (size_t i = first * qc_clusterSize; i < end * qc_clusterSize; i++)
        for (int k = 0; k < 3; k++)
        {
            uint32_t vertex = l->corners[i].vertex[k];
            l->clusters[i / qc_clusterSize].vertex[k][i % qc_clusterSize] =
                vertex != l->vertexCount ? vertex : l->vertexCount + (uint32_t)i;
        }
}

qcStatus qcClusters_ListVertices(const qcClusters* c, const qcCorners* corners, uint32_t vertexCount, uint32_t threads,
                                 qcArray* vertices)
{
    size_t clusterCount = c->triangles.count / qc_clusterSize;
    QC_TRY(qcArray_Resize(vertices, clusterCount, sizeof(qcClusterVertices), "vertices of clusters"));
    Listing listing = {corners, vertexCount, clusterCount, vertices->data};
    size_t blocks = (clusterCount + qc_listedClusters - 1) / qc_listedClusters;
    qcParallel_For(threads, blocks, qc_minListed, ListBlock, &listing);
    return qc_statusOk;
}

//  ---- arrangement and links -----------------------------------------------------------------------

qcStatus qcClusters_Arrange(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                            const double* positions, uint32_t vertexCount, const qcOrderOptions* options)
{
    qcOrderSummary summary = {.hasHub = false};
    *clusters = (qcClusters){0};
    qcStatus status =
        qcClusterOrder_Make(&clusters->triangles, indices, triangleCount, positions, vertexCount, options, &summary);
    if (status != qc_statusOk)
        qcClusters_Free(clusters);
    clusters->nodeCount = (uint32_t)(clusters->triangles.count / qc_nodeSize);
    clusters->hasHub = summary.hasHub;
    clusters->isLimited = summary.isLimited;
    return status;
}

qcStatus qcClusters_CopyOrder(qcClusters* clusters, const qcClusters* other)
{
    *clusters = (qcClusters){.nodeCount = other->nodeCount, .hasHub = other->hasHub};
    return qcArray_Append(&clusters->triangles, &other->triangles, sizeof(uint32_t), "nodes of triangles");
}

qcStatus qcClusters_Complete(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                             const double* positions, uint32_t vertexCount, const qcOrderOptions* options)
{
    qcStatus status =
        qcClusterOrder_Complete(&clusters->triangles, indices, triangleCount, positions, vertexCount, options);
    if (status != qc_statusOk)
        qcClusters_Free(clusters);
    clusters->nodeCount = (uint32_t)(clusters->triangles.count / qc_nodeSize);
    clusters->isLimited = false;
    return status;
}

void qcClusters_Unlink(qcClusters* clusters)
{
    qcArray_Free(&clusters->firstLink);
    qcArray_Free(&clusters->links);
    qcArray_Free(&clusters->pairMasks);
    clusters->neighbourCount = 0;
}

static qcStatus Link(qcLinking* linking, qcClusters* c, const qcCorners* corners, uint32_t vertexCount)
{
    QC_TRY(qcLinking_Begin(linking, c, corners, vertexCount));
    QC_TRY(qcLinking_FindLinks(linking, c));
    return qcLinking_Continue(linking, c, c->nodeCount);
}

qcStatus qcClusters_Link(qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount)
{
    qcLinking linking = {.nextNode = 0};
    qcArray corners = {0}, vertexOf = {0};
    qcStatus status = qcClusters_NumberVertices(clusters, indices, vertexCount, 1, &corners, &vertexOf);
    if (status == qc_statusOk)
        status = Link(&linking, clusters, corners.data, (uint32_t)vertexOf.count);
    qcLinking_Free(&linking);
    qcArray_Free(&corners);
    qcArray_Free(&vertexOf);
    if (status != qc_statusOk)
        qcClusters_Unlink(clusters);
    return status;
}

qcStatus qcClusters_Build(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                          const double* positions, uint32_t vertexCount, uint32_t threads)
{
    const qcOrderOptions options = {.threads = threads};
    QC_TRY(qcClusters_Arrange(clusters, indices, triangleCount, positions, vertexCount, &options));
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
        uint64_t left = qcPairMask_PairsOfWord(word, filledA, filledB, node == to.other);
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
