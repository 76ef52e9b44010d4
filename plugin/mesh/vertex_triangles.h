// The triangles around each vertex, as compressed sparse rows.
#ifndef QC_MESH_VERTEX_TRIANGLES_H
#define QC_MESH_VERTEX_TRIANGLES_H

#include "base/memory.h"

typedef struct qcVertexTriangles
{
    qcArray first;     ///< uint32_t by vertex, and one more: where its row begins in `triangles`
    qcArray triangles; ///< uint32_t: each row ascending, a triangle once even if two of its corners are the same vertex
} qcVertexTriangles;

/// `indices`: three vertices a triangle, all below vertexCount; a triangle whose first corner is vertexCount is left
/// out. Triangles are numbered by their position in `indices`: those of the body, or slots. O(triangles + vertices). On
/// failure nothing is left.
qcStatus qcVertexTriangles_Build(qcVertexTriangles* around, const uint32_t* indices, size_t triangleCount,
                                 uint32_t vertexCount);
void qcVertexTriangles_Free(qcVertexTriangles* around);

/// Triangles around a vertex.
static inline uint32_t qcVertexTriangles_Count(const qcVertexTriangles* around, uint32_t vertex)
{
    const uint32_t* first = &QC_AT(uint32_t, around->first, vertex);
    return first[1] - first[0];
}

#endif
