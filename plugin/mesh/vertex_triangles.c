// Counts each vertex's triangles, then fills the rows from their ends.
#include "mesh/vertex_triangles.h"

#include "base/status.h"

#include <stdbool.h>
#include <string.h>

/// True if no earlier corner of the triangle has the same vertex.
static bool IsFirst(const uint32_t* v, int corner)
{
    return (corner < 1 || v[corner] != v[0]) && (corner < 2 || v[2] != v[1]);
}

static qcStatus Build(qcVertexTriangles* around, const uint32_t* indices, size_t triangleCount, uint32_t vertexCount)
{
    QC_TRY(qcArray_Resize(&around->first, (size_t)vertexCount + 1, sizeof(uint32_t), "triangles of vertices"));
    uint32_t *first = around->first.data, end = 0;
    memset(first, 0, ((size_t)vertexCount + 1) * sizeof *first);
    for (size_t t = 0; t < triangleCount; t++)
    {
        const uint32_t* v = indices + 3 * t;
        for (int c = 0; c < 3 && v[0] != vertexCount; c++)
            first[v[c]] += IsFirst(v, c);
    }
    for (uint32_t v = 0; v < vertexCount; v++)
        first[v] = end += first[v];
    first[vertexCount] = end;
    QC_TRY(qcArray_Resize(&around->triangles, end, sizeof(uint32_t), "triangles of vertices"));
    uint32_t* triangles = around->triangles.data;
    for (size_t t = triangleCount; t-- > 0;)
    {
        const uint32_t* v = indices + 3 * t;
        for (int c = 0; c < 3 && v[0] != vertexCount; c++)
            if (IsFirst(v, c))
                triangles[--first[v[c]]] = (uint32_t)t;
    }
    return qc_statusOk;
}

qcStatus qcVertexTriangles_Build(qcVertexTriangles* around, const uint32_t* indices, size_t triangleCount,
                                 uint32_t vertexCount)
{
    *around = (qcVertexTriangles){.first = {0}};
    qcStatus status = Build(around, indices, triangleCount, vertexCount);
    if (status != qc_statusOk)
        qcVertexTriangles_Free(around);
    return status;
}

void qcVertexTriangles_Free(qcVertexTriangles* around)
{
    qcArray_Free(&around->first);
    qcArray_Free(&around->triangles);
}
