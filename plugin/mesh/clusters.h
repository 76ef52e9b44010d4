// The cluster order of a body's triangles: clusters of 8 close triangles, leaf nodes of 8 close clusters; and for each
// two nodes that share a vertex, which pairs of their triangles share none. A triangle's position in this order is its
// slot. Made once per topology; positions only decide what lies close.
#ifndef QC_MESH_CLUSTERS_H
#define QC_MESH_CLUSTERS_H

#include "base/memory.h"
#include "mesh/cluster_order.h"
#include "mesh/pair_mask.h"

#include <stdbool.h>

/// Slots of two triangles.
typedef struct qcSlotPair
{
    uint32_t a, b;
} qcSlotPair;

/// The adjacency of a leaf node with another one that shares a vertex, or with itself.
typedef struct qcLeafLink
{
    uint32_t other; ///< not below the node that has the link
    uint32_t mask;  ///< where its pair mask begins in qcClusters::pairMasks
} qcLeafLink;

/// The vertices of a triangle.
typedef struct qcCorners
{
    uint32_t vertex[3];
} qcCorners;

/// The vertices of a cluster's triangles by corner. A slot without a triangle has three times a number that no other
/// slot has.
typedef struct qcClusterVertices
{
    uint32_t vertex[3][qc_clusterSize];
} qcClusterVertices;

typedef struct qcClusters
{
    uint32_t nodeCount;
    bool hasHub;       ///< a vertex has so many triangles that pair masks are to be shared: qcClusters_Link is needed
    bool isLimited;    ///< triangles outside qcOrderOptions::region are left out; there may be no links
    qcArray triangles; ///< uint32_t by slot, qc_nodeSize a node: each triangle of the body once, or QC_NO_TRIANGLE
    qcArray firstLink; ///< uint32_t, nodeCount + 1: where a node's links begin
    qcArray links;     ///< of qcLeafLink: each node's ordered by `other`, itself first
    /// uint64_t: the packed pair masks of links, and one word more. A bit is set where both triangles exist, share no
    /// vertex index and, within one node, come in this order (cluster i < j, or i == j and triangle u < v).
    qcArray pairMasks;
    uint64_t neighbourCount; ///< pairs of triangles that share a vertex index
} qcClusters;

/// Puts the triangles into nodes; no links yet. `indices`: three a triangle; `positions`: three doubles a vertex.
/// O(triangles log triangles). On failure nothing is left.
qcStatus qcClusters_Arrange(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                            const double* positions, uint32_t vertexCount, const qcOrderOptions* options);
/// Takes over the nodes of clusters of the same triangles, which are not limited; no links yet. On failure nothing is
/// left.
qcStatus qcClusters_CopyOrder(qcClusters* clusters, const qcClusters* other);
/// Adds the triangles that limited clusters lack; slots of the others stay. options.region is around the mesh, and need
/// not be that of before. On failure nothing is left.
qcStatus qcClusters_Complete(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                             const double* positions, uint32_t vertexCount, const qcOrderOptions* options);
/// Adds links, pair masks and neighbourCount to clusters without links. O(pairs of neighbours). On failure there are
/// none.
qcStatus qcClusters_Link(qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount);
/// Removes the links.
void qcClusters_Unlink(qcClusters* clusters);
/// Arranges and links. On failure nothing is left.
qcStatus qcClusters_Build(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                          const double* positions, uint32_t vertexCount, uint32_t threads);
void qcClusters_Free(qcClusters* clusters);

#define QC_NO_LINK UINT32_MAX

/// The link of two nodes, the second not below the first. QC_NO_LINK: they share no vertex.
uint32_t qcClusters_FindLink(const qcClusters* clusters, uint32_t node, uint32_t other);

/// The packed pair mask of a link.
static inline const uint64_t* qcClusters_PairMask(const qcClusters* clusters, uint32_t link)
{
    return &QC_AT(uint64_t, clusters->pairMasks, QC_AT(qcLeafLink, clusters->links, link).mask);
}

/// Renumbers the vertices that triangles use in the order in which slots use them, so that data of close vertices lies
/// together. Fills `corners` (of qcCorners, by slot; the count of such vertices where there is no triangle) and
/// `vertexOf` (uint32_t: the body's number of each). The numbers don't depend on `threads`.
qcStatus qcClusters_NumberVertices(const qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount,
                                   uint32_t threads, qcArray* corners, qcArray* vertexOf);

/// Fills `vertices` (of qcClusterVertices, by cluster) from corners by slot; `vertexCount` stands in slots without a
/// triangle.
qcStatus qcClusters_ListVertices(const qcClusters* clusters, const qcCorners* corners, uint32_t vertexCount,
                                 uint32_t threads, qcArray* vertices);

/// Writes the pairs of neighbours between a node and the other of its link, each once, in no order; there is room for
/// qc_nodeSize^2. Returns the new end.
qcSlotPair* qcClusters_FindNeighbours(const qcClusters* clusters, uint32_t node, uint32_t link, qcSlotPair* pairs);

#endif
