// Searches the triangles around one end of each edge.
#include "mesh/adjacency.h"

#include "base/status.h"

#include <stdbool.h>

enum
{
    // An edge both of whose vertices have more triangles is treated as a border.
    qc_maxAround = 64
};

/// The only other triangle with the edge u v, if it has the edge in the opposite direction; otherwise QC_NO_SLOT.
static uint32_t FindAcross(const qcAdjacency* a, const qcCorners* corners, uint32_t slot, uint32_t u, uint32_t v)
{
    const uint32_t *first = a->around.first.data, *around = a->around.triangles.data;
    uint32_t at = first[v + 1] - first[v] < first[u + 1] - first[u] ? v : u, found = QC_NO_SLOT;
    if (u == v || first[at + 1] - first[at] > qc_maxAround)
        return QC_NO_SLOT;
    for (uint32_t i = first[at]; i < first[at + 1]; i++)
    {
        const uint32_t* w = corners[around[i]].vertex;
        bool has = (w[0] == u || w[1] == u || w[2] == u) && (w[0] == v || w[1] == v || w[2] == v);
        if (around[i] == slot || !has)
            continue;
        bool opposite = (w[0] == v && w[1] == u) || (w[1] == v && w[2] == u) || (w[2] == v && w[0] == u);
        bool proper = w[0] != w[1] && w[1] != w[2] && w[2] != w[0];
        if (found != QC_NO_SLOT || !opposite || !proper)
            return QC_NO_SLOT;
        found = around[i];
    }
    return found;
}

static qcStatus Build(qcAdjacency* a, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    QC_TRY(qcVertexTriangles_Build(&a->around, (const uint32_t*)corners, slotCount, vertexCount));
    QC_TRY(qcArray_Resize(&a->across, 3 * slotCount, sizeof(uint32_t), "triangles over edges"));
    for (size_t slot = 0; slot < slotCount; slot++)
    {
        const uint32_t* v = corners[slot].vertex;
        bool proper = v[0] != vertexCount && v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        for (int c = 0; c < 3; c++)
            QC_AT(uint32_t, a->across, 3 * slot + c) =
                proper ? FindAcross(a, corners, (uint32_t)slot, v[c], v[(c + 1) % 3]) : QC_NO_SLOT;
    }
    return qc_statusOk;
}

qcStatus qcAdjacency_Build(qcAdjacency* adjacency, const qcCorners* corners, size_t slotCount, uint32_t vertexCount)
{
    *adjacency = (qcAdjacency){.across = {0}};
    qcStatus status = Build(adjacency, corners, slotCount, vertexCount);
    if (status != qc_statusOk)
        qcAdjacency_Free(adjacency);
    return status;
}

void qcAdjacency_Free(qcAdjacency* adjacency)
{
    qcVertexTriangles_Free(&adjacency->around);
    qcArray_Free(&adjacency->across);
}
