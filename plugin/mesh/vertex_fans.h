// The triangles around each vertex of a surface, and the vertices around it where these triangles are one closed fan:
// its star. Made once per topology.
#ifndef QC_MESH_VERTEX_FANS_H
#define QC_MESH_VERTEX_FANS_H

#include "mesh/clusters.h"

enum
{
    qc_fanLanes = 16,  ///< stars of a batch
    qc_minFanSize = 3, ///< triangles of a star, at least
    qc_maxFanSize = 12 ///< and at most: others are not looked at as stars
};

/// Stars with the same number of triangles, side by side.
typedef struct qcVertexFanBatch
{
    uint32_t valence;   ///< triangles of each
    uint32_t count;     ///< stars: qc_fanLanes, or fewer in the last batch of a valence
    size_t firstVertex; ///< in qcVertexFans::vertices
} qcVertexFanBatch;

typedef struct qcVertexFans
{
    bool made;
    qcArray firstPlace; ///< uint32_t, by vertex and one more: where the places around it begin
    qcArray places;     ///< uint32_t: places of the triangles that have a vertex, each once
    qcArray batches;    ///< of qcVertexFanBatch
    /// uint32_t, by batch: 1 + valence rows of qc_fanLanes; first the vertices in the middle, then those around it, in
    /// one direction. Where there are fewer stars the first one stands again.
    qcArray vertices;
} qcVertexFans;

/// `corners` by place, as many as the clusters have places; where there is no triangle, the vertex vertexCount.
/// O(triangles) for triangles around one vertex that are not many. On failure nothing is left.
qcStatus qcVertexFans_Make(qcVertexFans* stars, const qcCorners* corners, size_t placeCount, uint32_t vertexCount);
void qcVertexFans_Free(qcVertexFans* stars);

#endif
