// Cuts closed meshes by planes and closes them again. A solid is bounded by faces, each of any number of edges; they
// are made triangles of when all cuts are done.
#ifndef QC_GLUE_FRACTURE_PLANE_CLIP_H
#define QC_GLUE_FRACTURE_PLANE_CLIP_H

#include "fracture/clip_mesh.h"

/// As seen from outside its left face passes it forwards, its right face backwards.
struct qcClipEdge
{
    uint32_t from, to;
    uint32_t left, right;
};

/// Closed, as each edge has two faces, if at each point each face begins as many edges as it ends.
struct qcClipSolid
{
    std::vector<qcClipPoint> points;
    std::vector<qcClipEdge> edges;
};

/// What is outside has normal . x > distance.
struct qcClipPlane
{
    qcClipPoint normal;
    double distance;
    uint32_t face; ///< that closes the cut
};

/// A solid of the triangles of a mesh, which loses those that lie back to back. Returns a triangle with an edge that is
/// passed more often one way than the other, or the number of triangles.
size_t qcClipSolid_Make(qcClipMesh* mesh, qcClipSolid* solid);

/// Takes away what is outside of the plane, and puts a face there. Where the plane cuts an edge, the point is the same
/// for the plane and for its mirror image (the same numbers with other signs), bit by bit. O(edges).
void qcClipSolid_Cut(qcClipSolid* solid, const qcClipPlane& plane, qcClipScratch* scratch);

/// Triangles of all faces, in the order of these: a closed mesh with no two points at one place, but for those where
/// rounding made edges of one face cross.
void qcClipSolid_Triangulate(qcClipSolid* solid, qcClipMesh* mesh, qcClipScratch* scratch);

#endif
