// Numbers of vertices, links and neighbours of clusters.
#include "mesh/clusters.h"

#include "mesh/cluster_order.h"
#include "mesh/linking.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Triangles whose indices are on their way from memory.
    qc_prefetched = 16
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

qcStatus qcClusters_NumberVertices(const qcClusters* c, const uint32_t* indices, uint32_t vertexCount, qcArray* corners,
                                   qcArray* vertexOf)
{
    qcArray numbers = {0};
    vertexOf->count = 0;
    QC_TRY(qcArray_Resize(corners, c->triangles.count, sizeof(qcCorners), "vertices of nodes"));
    QC_TRY(qcArray_Reserve(vertexOf, (size_t)vertexCount + 1, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&numbers, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    if (vertexCount != 0)
        memset(numbers.data, 0xff, vertexCount * sizeof(uint32_t));
    const uint32_t* triangles = c->triangles.data;
    uint32_t *number = numbers.data, *used = vertexOf->data, count = 0;
    for (size_t i = 0; i < c->triangles.count; i++)
    {
        size_t later = i + qc_prefetched < c->triangles.count ? i + qc_prefetched : i;
        __builtin_prefetch(indices + 3 * (size_t)(triangles[later] != QC_NO_TRIANGLE ? triangles[later] : 0));
        const uint32_t* v = indices + 3 * (size_t)triangles[i];
        for (int k = 0; k < 3 && triangles[i] != QC_NO_TRIANGLE; k++)
        {
            // Without branches: a new vertex comes as if by chance.
            bool isNew = number[v[k]] == UINT32_MAX;
            used[count] = v[k];
            number[v[k]] = isNew ? count : number[v[k]];
            count += isNew;
            QC_AT(qcCorners, *corners, i).vertex[k] = number[v[k]];
        }
    }
    vertexOf->count = count;
    qcArray_Free(&numbers);
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3 && QC_AT(uint32_t, c->triangles, i) == QC_NO_TRIANGLE; k++)
            QC_AT(qcCorners, *corners, i).vertex[k] = (uint32_t)vertexOf->count;
    return qc_statusOk;
}

qcStatus qcClusters_ListVertices(const qcClusters* c, const qcCorners* corners, uint32_t vertexCount, qcArray* vertices)
{
    QC_TRY(qcArray_Resize(vertices, c->triangles.count / qc_clusterSize, sizeof(qcClusterVertices),
                          "vertices of clusters"));
    qcClusterVertices* clusters = vertices->data;
    for (size_t i = 0; i < c->triangles.count; i++)
        for (int k = 0; k < 3; k++)
        {
            uint32_t vertex = corners[i].vertex[k];
            clusters[i / qc_clusterSize].vertex[k][i % qc_clusterSize] =
                vertex != vertexCount ? vertex : vertexCount + (uint32_t)i;
        }
    return qc_statusOk;
}

qcStatus qcClusters_Arrange(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                            const double* positions, uint32_t vertexCount, uint32_t threads)
{
    *clusters = (qcClusters){0};
    qcStatus status = qcClusterOrder_Make(&clusters->triangles, indices, triangleCount, positions, vertexCount, threads,
                                          &clusters->hasHub);
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
    qcStatus status = qcClusters_NumberVertices(clusters, indices, vertexCount, &corners, &vertexOf);
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
