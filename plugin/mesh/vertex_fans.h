// Vertex fans: for each vertex whose triangles form one closed fan, the ring of vertices around it. Fans of the same
// number of triangles lie side by side, a lane each, for the kernel that tests them
// (kernels/vertex_fan_test.inl.h). Made once per topology.
#ifndef QC_MESH_VERTEX_FANS_H
#define QC_MESH_VERTEX_FANS_H

#include "mesh/clusters.h"
#include "mesh/vertex_triangles.h"

enum
{
    qc_fanLanes = 16,  ///< fans of a batch
    qc_minFanSize = 3, ///< triangles of a fan
    qc_maxFanSize = 12 ///< triangles of a fan; larger ones are not listed
};

/// Fans with the same number of triangles, side by side.
typedef struct qcVertexFanBatch
{
    uint32_t valence;   ///< triangles of each
    uint32_t count;     ///< fans: qc_fanLanes, or fewer in the last batch of a valence
    size_t firstVertex; ///< in qcVertexFans::vertices
} qcVertexFanBatch;

typedef struct qcVertexFans
{
    bool made;
    qcVertexTriangles around; ///< slots of the triangles around each vertex, a fan or not
    qcArray batches;          ///< of qcVertexFanBatch
    /// uint32_t, by batch: 1 + valence rows of qc_fanLanes; first the vertices in the middle, then those around them,
    /// in one direction. Unused lanes repeat the first fan.
    qcArray vertices;
} qcVertexFans;

/// `corners` by slot, as many as the clusters have slots; the vertex vertexCount where there is no triangle.
/// O(triangles) if no vertex has very many. On failure nothing is left. Does nothing for fans that are made.
qcStatus qcVertexFans_Make(qcVertexFans* fans, const qcCorners* corners, size_t slotCount, uint32_t vertexCount);
void qcVertexFans_Free(qcVertexFans* fans);

#endif
