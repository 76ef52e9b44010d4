// Triangles counted by vertex, then looked through around one end of each edge.
#include "mesh/adjacency.h"

#include "base/status.h"

#include <string.h>

enum
{
    // An edge between two vertices of more triangles is taken to have no other side.
    qc_mostAround = 64
};

static void FindAround(qcAdjacency* a, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    uint32_t *first = a->first.data, *around = a->around.data, end = 0;
    memset(first, 0, ((size_t)vertexCount + 1) * sizeof *first);
    for (size_t p = 0; p < placeCount; p++)
        for (int c = 0; c < 3 && corners[p].vertex[0] != vertexCount; c++)
            first[corners[p].vertex[c]]++;
    for (uint32_t v = 0; v < vertexCount; v++)
        first[v] = end += first[v];
    first[vertexCount] = end;
    for (size_t p = placeCount; p-- > 0;)
        for (int c = 0; c < 3 && corners[p].vertex[0] != vertexCount; c++)
            around[--first[corners[p].vertex[c]]] = (uint32_t)p;
}

/// The one other triangle that has the edge u v, if it has it as v u.
static uint32_t FindAcross(const qcAdjacency* a, const qcCorners* corners, uint32_t place, uint32_t u, uint32_t v)
{
    const uint32_t *first = a->first.data, *around = a->around.data;
    uint32_t at = first[v + 1] - first[v] < first[u + 1] - first[u] ? v : u, found = QC_NO_SLOT;
    if (u == v || first[at + 1] - first[at] > qc_mostAround)
        return QC_NO_SLOT;
    for (uint32_t i = first[at]; i < first[at + 1]; i++)
    {
        const uint32_t* w = corners[around[i]].vertex;
        bool has = (w[0] == u || w[1] == u || w[2] == u) && (w[0] == v || w[1] == v || w[2] == v);
        if (around[i] == place || !has)
            continue;
        bool opposite = (w[0] == v && w[1] == u) || (w[1] == v && w[2] == u) || (w[2] == v && w[0] == u);
        bool proper = w[0] != w[1] && w[1] != w[2] && w[2] != w[0];
        if (found != QC_NO_SLOT || !opposite || !proper)
            return QC_NO_SLOT;
        found = around[i];
    }
    return found;
}

static qcStatus Build(qcAdjacency* a, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    QC_TRY(qcArray_Resize(&a->first, (size_t)vertexCount + 1, sizeof(uint32_t), "triangles of vertices"));
    QC_TRY(qcArray_Resize(&a->around, 3 * placeCount, sizeof(uint32_t), "triangles of vertices"));
    QC_TRY(qcArray_Resize(&a->across, 3 * placeCount, sizeof(uint32_t), "triangles over edges"));
    FindAround(a, corners, placeCount, vertexCount);
    for (size_t p = 0; p < placeCount; p++)
    {
        const uint32_t* v = corners[p].vertex;
        bool proper = v[0] != vertexCount && v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
        for (int c = 0; c < 3; c++)
            QC_AT(uint32_t, a->across, 3 * p + c) =
                proper ? FindAcross(a, corners, (uint32_t)p, v[c], v[(c + 1) % 3]) : QC_NO_SLOT;
    }
    return qc_statusOk;
}

qcStatus qcAdjacency_Build(qcAdjacency* adjacency, const qcCorners* corners, size_t placeCount, uint32_t vertexCount)
{
    *adjacency = (qcAdjacency){.first = {0}};
    qcStatus status = Build(adjacency, corners, placeCount, vertexCount);
    if (status != qc_statusOk)
        qcAdjacency_Free(adjacency);
    return status;
}

void qcAdjacency_Free(qcAdjacency* adjacency)
{
    qcArray_Free(&adjacency->first);
    qcArray_Free(&adjacency->around);
    qcArray_Free(&adjacency->across);
}
