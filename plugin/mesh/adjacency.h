// The triangle across each edge of a mesh, and the triangles around each vertex. Made once per topology.
#ifndef QC_MESH_ADJACENCY_H
#define QC_MESH_ADJACENCY_H

#include "mesh/clusters.h"
#include "mesh/vertex_triangles.h"

/// Stands for no slot.
#define QC_NO_SLOT UINT32_MAX

typedef struct qcAdjacency
{
    qcVertexTriangles around;
    /// uint32_t, three a slot: the only other triangle with the edge from corner c to the next, if it has that edge in
    /// the opposite direction; otherwise QC_NO_SLOT.
    qcArray across;
} qcAdjacency;

/// Fills `around`; qcAdjacency_FindAcross does the rest. `corners` by slot; vertices are below vertexCount where there
/// is a triangle, and vertexCount where there is none. O(triangles). On failure nothing is left.
qcStatus qcAdjacency_Begin(qcAdjacency* adjacency, const qcCorners* corners, size_t slotCount, uint32_t vertexCount);
/// Fills `across` of the slots first .. end - 1. O(slots).
void qcAdjacency_FindAcross(qcAdjacency* adjacency, const qcCorners* corners, uint32_t vertexCount, size_t first,
                            size_t end, uint32_t threads);
/// Both, of all slots.
qcStatus qcAdjacency_Build(qcAdjacency* adjacency, const qcCorners* corners, size_t slotCount, uint32_t vertexCount);
void qcAdjacency_Free(qcAdjacency* adjacency);

#endif
