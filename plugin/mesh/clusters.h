// The triangles of a body laid together: clusters of 8 near triangles, nodes of 8 near clusters; and for each two nodes
// that share a vertex, which pairs of their triangles are no neighbours. Depends on the indices alone for what it says,
// on positions only for what lies near: made once per topology.
#ifndef QC_MESH_CLUSTERS_H
#define QC_MESH_CLUSTERS_H

#include "base/memory.h"
#include "mesh/limits.h"

/// A word of a table: the pairs of these triangles of two clusters, a bit for each triangle.
static inline uint64_t qcClusters_Product(unsigned a, unsigned b)
{
    // Bit v of b to bit 8 v: seven bits by one multiplication, without carries; then a copy of a at each.
    uint64_t spread = ((b & 0x7fu) * UINT64_C(0x0002040810204081) & UINT64_C(0x0001010101010101)) | (uint64_t)(b >> 7)
                                                                                                        << 56;
    return spread * a;
}

/// Of the triangles of a node, those of one of its clusters.
static inline unsigned qcClusters_PlacesOf(uint64_t places, uint32_t cluster)
{
    return (unsigned)(places >> qc_clusterSize * cluster & 0xffu);
}

/// Of the pairs of a cluster with itself: bits u + 8 v with u < v.
#define QC_IN_ORDER UINT64_C(0x7f3f1f0f07030100)

/// Two places of triangles.
typedef struct qcSlotPair
{
    uint32_t a, b;
} qcSlotPair;

enum
{
    qc_maxExclusions = 4
};

/// Pairs of places of two nodes that need not be compared: those in both masks.
typedef struct qcPairExclusion
{
    uint64_t a, b;
} qcPairExclusion;

/// A node that shares a vertex with another, or is the same, and the pairs between them.
typedef struct qcLeafLink
{
    uint32_t other; ///< not below the node that has the link
    uint32_t table; ///< where it begins
} qcLeafLink;

/// Of a triangle.
typedef struct qcCorners
{
    uint32_t vertex[3];
} qcCorners;

typedef struct qcClusters
{
    uint32_t nodeCount;
    qcArray triangles; ///< uint32_t, qc_nodeSize a node: each triangle of the body once, or QC_NO_TRIANGLE
    qcArray firstLink; ///< uint32_t, nodeCount + 1: where a node's links begin
    qcArray links;     ///< of qcLeafLink: each node's ordered by `other`, itself first
    /// uint64_t: the tables of links, packed (qcClusters_Word), and one more. Of a table's 64 words, word i + 8 j is
    /// about cluster i of the node and cluster j of the other, its bit u + 8 v about triangle u of the one and v of the
    /// other: set where both exist, share no vertex index and, within one node, come in this order (i < j, or i == j
    /// and u < v).
    qcArray tables;
    uint64_t neighbourCount; ///< pairs of triangles that share a vertex index
} qcClusters;

/// Nodes and their triangles; no links yet. `positions`: three doubles a vertex. O(triangles log triangles). On failure
/// nothing is left.
qcStatus qcClusters_Lay(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                        uint32_t vertexCount, uint32_t threads);
/// Adds links, tables and the count of neighbours to clusters that have none. O(pairs of neighbours). On failure there
/// are none, as before.
qcStatus qcClusters_Link(qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount);
/// Takes them off again.
void qcClusters_Unlink(qcClusters* clusters);
/// Lays and links. On failure nothing is left.
qcStatus qcClusters_Build(qcClusters* clusters, const uint32_t* indices, uint32_t triangleCount,
                          const double* positions, uint32_t vertexCount, uint32_t threads);
#define QC_NO_LINK UINT32_MAX

/// The link of two nodes, the second not below the first, or QC_NO_LINK: they share no vertex.
uint32_t qcClusters_FindLink(const qcClusters* clusters, uint32_t node, uint32_t other);

enum
{
    qc_tableWords = 64,
    qc_maxTableSize = 2 + qc_tableWords
};

/// Most words of most tables have all bits set, or none: a packed table has a bit for each word that has some, one for
/// each that has none, then the former words in order. Returns its size.
size_t qcClusters_PackTable(const uint64_t words[qc_tableWords], uint64_t packed[qc_maxTableSize]);

/// A word that has any bits. One word more than the table has is read, but not used.
static inline uint64_t qcClusters_Word(const uint64_t* table, uint32_t word)
{
    uint64_t bit = UINT64_C(1) << word;
    uint64_t some = table[2 + __builtin_popcountll(table[0] & (bit - 1))];
    return (table[0] & bit) != 0 ? some : UINT64_MAX;
}

/// The table of a link, packed.
static inline const uint64_t* qcClusters_Table(const qcClusters* clusters, uint32_t link)
{
    return &QC_AT(uint64_t, clusters->tables, QC_AT(qcLeafLink, clusters->links, link).table);
}

/// As the table of a node with itself, had no two of its triangles a common vertex.
const uint64_t* qcClusters_OrderTable(void);

/// Names the vertices that triangles have in the order in which places have them: what is kept of near ones then lies
/// together. Fills `corners` (of qcCorners, by place; where there is no triangle, the number of names) and `vertexOf`
/// (uint32_t: the body's number of each name).
qcStatus qcClusters_NameVertices(const qcClusters* clusters, const uint32_t* indices, uint32_t vertexCount,
                                 qcArray* corners, qcArray* vertexOf);

/// Writes the pairs of triangles of a leaf node and the other leaf node of its link that share a vertex: in no order,
/// each once, into room for qc_nodeSize^2. Returns the new end.
qcSlotPair* qcClusters_FindNeighbours(const qcClusters* clusters, uint32_t node, uint32_t link, qcSlotPair* pairs);
void qcClusters_Free(qcClusters* clusters);

#endif
