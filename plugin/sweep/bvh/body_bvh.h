// The sweep's data of a body between steps: its BVH and, for pairs of the body with itself, vertex fans, flat patches
// and the reference of its Verlet list.
#ifndef QC_SWEEP_BVH_BODY_BVH_H
#define QC_SWEEP_BVH_BODY_BVH_H

#include "mesh/vertex_fans.h"
#include "sweep/bvh/patch_state.h"
#include "sweep/bvh/verlet_reference.h"

typedef struct qcBodyBvh
{
    qcTriangleBvh bvh;
    bool hasAdjacency; ///< the clusters are linked and the patches built, for self pairs without neighbours
    qcPatchState patches;
    qcVertexFans fans;   ///< made when first needed
    qcArray isSeparated; ///< uint8_t by vertex: its fan had no self-contact within the margin (neighbour_pairs.h)
    qcVerletReference verlet;
} qcBodyBvh;

/// For a body with triangles; with adjacency if the body has self-collision. O(triangles log triangles). On failure
/// nothing is left.
qcStatus qcBodyBvh_Build(qcBodyBvh* bodyBvh, const qcBody* body, uint32_t threads);

/// Builds the adjacency if there is none. The body is the one that the BVH was built for. O(pairs of neighbours).
qcStatus qcBodyBvh_BuildAdjacency(qcBodyBvh* bodyBvh, const qcBody* body, uint32_t threads);

/// Makes the fans if there are none. O(triangles).
qcStatus qcBodyBvh_MakeFans(qcBodyBvh* bodyBvh);

/// Stores the body's positions as the reference of its Verlet list, which holds its pairs within `margin`; makes the
/// fans if there are none. The BVH is fitted to these positions. O(vertices).
qcStatus qcBodyBvh_SetVerletReference(qcBodyBvh* bodyBvh, const qcBody* body, double margin);

void qcBodyBvh_Free(qcBodyBvh* bodyBvh);

#endif
