// One pass over the slots. A vertex that was not seen before is the next own one.
#include "mesh/node_vertices.h"

#include "base/status.h"

/// Adds a node; there is room for it. `lastNode`: by vertex, 1 + the last node that has it, or 0.
static void AddNode(qcNodeVertices* vertices, const qcCorners* corners, uint32_t node, uint32_t vertexCount,
                    uint32_t* lastNode)
{
    uint32_t firstOwn = QC_AT(uint32_t, vertices->firstOwn, node), end = firstOwn;
    for (size_t slot = 0; slot < qc_nodeSize; slot++)
        for (int c = 0; c < 3; c++)
        {
            uint32_t vertex = corners[slot].vertex[c];
            if (vertex == vertexCount || lastNode[vertex] == node + 1)
                continue;
            lastNode[vertex] = node + 1;
            if (vertex < firstOwn)
                QC_AT(uint32_t, vertices->shared, vertices->shared.count++) = vertex;
            else
                end++;
        }
    QC_AT(uint32_t, vertices->firstOwn, node + 1) = end;
    QC_AT(uint32_t, vertices->firstShared, node + 1) = (uint32_t)vertices->shared.count;
}

static qcStatus List(qcNodeVertices* vertices, const qcCorners* corners, uint32_t nodeCount, uint32_t vertexCount,
                     qcArray* lastNode)
{
    QC_TRY(qcArray_GrowZeroed(lastNode, vertexCount, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&vertices->firstShared, (size_t)nodeCount + 1, sizeof(uint32_t), "vertices of nodes"));
    QC_TRY(qcArray_Resize(&vertices->firstOwn, (size_t)nodeCount + 1, sizeof(uint32_t), "vertices of nodes"));
    QC_AT(uint32_t, vertices->firstOwn, 0) = QC_AT(uint32_t, vertices->firstShared, 0) = 0;
    for (uint32_t node = 0; node < nodeCount; node++)
    {
        QC_TRY(qcArray_Reserve(&vertices->shared, vertices->shared.count + 3 * (size_t)qc_nodeSize, sizeof(uint32_t),
                               "vertices of nodes"));
        AddNode(vertices, corners + (size_t)node * qc_nodeSize, node, vertexCount, lastNode->data);
    }
    return qc_statusOk;
}

qcStatus qcNodeVertices_List(qcNodeVertices* vertices, const qcCorners* corners, uint32_t nodeCount,
                             uint32_t vertexCount)
{
    qcArray lastNode = {0};
    *vertices = (qcNodeVertices){0};
    qcStatus status = List(vertices, corners, nodeCount, vertexCount, &lastNode);
    qcArray_Free(&lastNode);
    if (status != qc_statusOk)
        qcNodeVertices_Free(vertices);
    return status;
}

void qcNodeVertices_Free(qcNodeVertices* vertices)
{
    qcArray_Free(&vertices->firstOwn);
    qcArray_Free(&vertices->firstShared);
    qcArray_Free(&vertices->shared);
}
