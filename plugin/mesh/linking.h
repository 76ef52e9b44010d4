// The links of clusters and their pair masks, made in parts, so that no step has to wait for all of them.
#ifndef QC_MESH_LINKING_H
#define QC_MESH_LINKING_H

#include "mesh/clusters.h"

/// Links in the making. All zero: none.
typedef struct qcLinking
{
    qcClusters* clusters; ///< of the current call
    const qcCorners* corners;
    uint32_t vertexCount;
    uint32_t nextNode; ///< masks of the nodes before it are made
    qcArray filled;    ///< uint64_t of each node: a bit for each slot with a triangle
    qcArray first;     ///< uint32_t of each vertex and one more: where its shares begin
    qcArray next;      ///< uint32_t of each vertex: its first share that is not visited yet
    qcArray shares;    ///< of Share, each vertex's ordered by node
    qcArray seen;  ///< uint32_t of each node: the last link to it, plus 1; then its mask among `words`, plus 1, or 0
    qcArray items; ///< of qcSortItem: node and other node, whether all their triangles are neighbours
    qcArray words; ///< uint64_t: the masks of the node that is visited, not packed
} qcLinking;

/// Begins with clusters without links: finds the nodes of each vertex. `corners` by slot, vertexCount where there is no
/// triangle; they stay until the end. O(triangles).
qcStatus qcLinking_Begin(qcLinking* linking, qcClusters* clusters, const qcCorners* corners, uint32_t vertexCount);

/// Then finds the links; pair masks follow. O(pairs of nodes that share a vertex).
qcStatus qcLinking_FindLinks(qcLinking* linking, qcClusters* clusters);

/// Makes the pair masks of the next `nodeCount` nodes, or of those that are left. O(pairs of neighbours).
qcStatus qcLinking_Continue(qcLinking* linking, qcClusters* clusters, uint32_t nodeCount);

/// Frees the memory of the making; the links stay.
void qcLinking_Free(qcLinking* linking);

#endif
