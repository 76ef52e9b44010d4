// The vertices of each leaf node's triangles, each once. Vertices are numbered in the order in which slots use them
// (qcClusters_NumberVertices), so that a node has a run of vertices that no lower node has, its own, and shares others
// with lower nodes.
#ifndef QC_MESH_NODE_VERTICES_H
#define QC_MESH_NODE_VERTICES_H

#include "mesh/clusters.h"

typedef struct qcNodeVertices
{
    qcArray firstOwn;    ///< uint32_t by node, and one more: its first own vertex
    qcArray firstShared; ///< uint32_t by node, and one more: where its row begins in `shared`
    qcArray shared;      ///< uint32_t: each row in no order
} qcNodeVertices;

/// `corners` by slot; vertexCount three times in a slot without a triangle. O(slots). On failure nothing is left.
qcStatus qcNodeVertices_List(qcNodeVertices* vertices, const qcCorners* corners, uint32_t nodeCount,
                             uint32_t vertexCount);

/// Whether the vertices are listed.
static inline bool qcNodeVertices_AreListed(const qcNodeVertices* vertices)
{
    return vertices->firstOwn.count != 0;
}

void qcNodeVertices_Free(qcNodeVertices* vertices);

#endif
