// The sweep's data of a body between steps: its BVH and, for pairs of the body with itself, vertex fans, flat patches
// and the reference of its Verlet list.
#ifndef QC_SWEEP_BVH_BODY_BVH_H
#define QC_SWEEP_BVH_BODY_BVH_H

#include "mesh/linking.h"
#include "mesh/vertex_fans.h"
#include "sweep/bvh/patch_state.h"
#include "sweep/bvh/verlet_reference.h"

typedef enum qcAdjacencyStage
{
    qc_adjacencyNodes, ///< of each vertex
    qc_adjacencyLinks,
    qc_adjacencyMasks,
    qc_adjacencyAround,
    qc_adjacencyAcross,
    qc_adjacencyPatches,
} qcAdjacencyStage;

/// What self pairs without neighbours need, made in parts, so that no step has to wait for all of it.
typedef struct qcAdjacencyBuild
{
    qcAdjacencyStage stage; ///< the next
    qcLinking linking;
    qcAdjacency adjacency;
    uint32_t nextNode; ///< across edges of the nodes before it all is found
} qcAdjacencyBuild;

typedef struct qcBodyBvh
{
    qcTriangleBvh bvh;
    bool hasAdjacency;          ///< the clusters are linked and the patches built, for self pairs without neighbours
    qcArray vertices;           ///< of qcClusterVertices, for self pairs until there is adjacency
    uint64_t neighbourCount;    ///< pairs of neighbours that the last search left out; counted until there is adjacency
    uint32_t searches;          ///< of self pairs
    qcAdjacencyBuild adjacency; ///< in the making
    qcPatchState patches;
    qcVertexFans fans;   ///< made when first needed
    qcArray isSeparated; ///< uint8_t by vertex: its fan had no self-contact within the margin (neighbour_pairs.h)
    qcVerletReference verlet;
} qcBodyBvh;

/// For a body with triangles; ready for self pairs if the body has self-collision. `region`: where other bodies may
/// come; null: anywhere, as for a body with self-collision. O(triangles log triangles). On failure nothing is left.
qcStatus qcBodyBvh_Build(qcBodyBvh* bodyBvh, const qcBody* body, const qcBvhRegion* region, uint32_t threads);

/// Like qcBodyBvh_Build without a region, by qcTriangleBvh_BuildLike.
qcStatus qcBodyBvh_BuildLike(qcBodyBvh* bodyBvh, const qcBody* body, const qcTriangleBvh* other, uint32_t threads);

/// Makes the BVH ready for self pairs: lists the vertices of clusters, or builds the adjacency where a vertex has so
/// many triangles that pair masks have to be shared. O(triangles).
qcStatus qcBodyBvh_PrepareSelf(qcBodyBvh* bodyBvh, uint32_t threads);

/// Whether self pairs can be found.
static inline bool qcBodyBvh_FindsSelfPairs(const qcBodyBvh* bodyBvh)
{
    return bodyBvh->hasAdjacency || bodyBvh->vertices.count != 0;
}

/// Builds the adjacency, if there is none. O(pairs of neighbours).
qcStatus qcBodyBvh_BuildAdjacency(qcBodyBvh* bodyBvh, uint32_t threads);

/// Builds the next part of the adjacency, if there is none: about as much work as a search, or all of a small body's.
qcStatus qcBodyBvh_ContinueAdjacency(qcBodyBvh* bodyBvh, uint32_t threads);

/// The work of qcBodyBvh_ContinueAdjacency: that of a search of so many leaf nodes.
uint32_t qcBodyBvh_AdjacencyWork(const qcBodyBvh* bodyBvh);

/// Makes the fans if there are none. O(triangles).
qcStatus qcBodyBvh_MakeFans(qcBodyBvh* bodyBvh);

/// Stores the body's positions as the reference of its Verlet list, which holds its pairs within `margin`; makes the
/// fans if there are none. The BVH is fitted to these positions. O(vertices).
qcStatus qcBodyBvh_SetVerletReference(qcBodyBvh* bodyBvh, const qcBody* body, double margin);

void qcBodyBvh_Free(qcBodyBvh* bodyBvh);

#endif
