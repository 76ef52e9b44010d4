// The first triangle of a vertex owns it; an edge belongs to the first triangle in the order of sorted edges.
#include "scene/feature_owners.h"

#include "base/radix_sort.h"
#include "base/status.h"

/// Marks the first corner of each vertex, and fills the edges: both vertices, lower first, and the index of the corner
/// where the edge starts.
static void MarkCorners(const qcBody* body, uint8_t* seen, qcOwnedFeatures* owned, qcSortItem* edges)
{
    for (size_t i = 0; i < 3 * (size_t)body->triangleCount; i++)
    {
        uint32_t a = body->indices[i], b = body->indices[i % 3 == 2 ? i - 2 : i + 1];
        edges[i] = (qcSortItem){a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a, i};
        if (!seen[a])
            owned[i / 3] |= (qcOwnedFeatures)(1u << i % 3);
        seen[a] = 1;
    }
}

/// Marks the first of each run of equal edges. An edge from a vertex to itself is none.
static void MarkEdges(const qcSortItem* edges, size_t count, qcOwnedFeatures* owned)
{
    for (size_t i = 0; i < count; i++)
    {
        bool first = i == 0 || edges[i].key != edges[i - 1].key;
        bool isEdge = (uint32_t)edges[i].key != (uint32_t)(edges[i].key >> 32);
        if (first && isEdge)
            owned[edges[i].value / 3] |= (qcOwnedFeatures)(8u << edges[i].value % 3);
    }
}

static qcStatus Mark(const qcBody* body, uint8_t* seen, qcOwnedFeatures* owned)
{
    size_t count = 3 * (size_t)body->triangleCount;
    qcArray edges = {0}, scratch = {0};
    qcStatus status = qcArray_Resize(&edges, count, sizeof(qcSortItem), "edges");
    if (status == qc_statusOk)
    {
        MarkCorners(body, seen, owned, edges.data);
        status = qcSort_Items(edges.data, count, &scratch);
    }
    if (status == qc_statusOk)
        MarkEdges(edges.data, count, owned);
    qcArray_Free(&edges);
    qcArray_Free(&scratch);
    return status;
}

qcStatus qcBody_FindFeatureOwners(qcBody* body)
{
    if (body->owned != NULL || body->triangleCount == 0)
        return qc_statusOk;
    qcOwnedFeatures* owned = qcAllocateZeroed(body->triangleCount * sizeof(qcOwnedFeatures));
    uint8_t* seen = qcAllocateZeroed(body->vertexCount);
    qcStatus status = owned == NULL || seen == NULL ? qcFailMemory(body->triangleCount, "owners of features")
                                                    : Mark(body, seen, owned);
    if (status == qc_statusOk)
        body->owned = owned;
    else
        qcFree(owned, body->triangleCount * sizeof(qcOwnedFeatures));
    qcFree(seen, body->vertexCount);
    return status;
}
