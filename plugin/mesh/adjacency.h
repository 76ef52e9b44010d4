// Which triangles of a surface lie around each vertex, and which lies over each edge. By place (clusters.h).
#ifndef QC_MESH_ADJACENCY_H
#define QC_MESH_ADJACENCY_H

#include "mesh/clusters.h"

/// In place of a triangle's place: none.
#define QC_NO_SLOT UINT32_MAX

typedef struct qcAdjacency
{
    qcArray first, around; ///< uint32_t of each vertex and one more; places
    /// uint32_t, three a place: the one other triangle over the edge from corner c to the next, if it has that edge in
    /// the opposite direction; otherwise QC_NO_SLOT.
    qcArray across;
} qcAdjacency;

/// `corners` by place; vertices are below vertexCount where there is a triangle, and vertexCount where there is none.
/// O(triangles). On failure nothing is left.
qcStatus qcAdjacency_Build(qcAdjacency* adjacency, const qcCorners* corners, size_t placeCount, uint32_t vertexCount);
void qcAdjacency_Free(qcAdjacency* adjacency);

#endif
