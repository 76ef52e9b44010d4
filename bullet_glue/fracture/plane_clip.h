// Clips closed solids by planes. A solid is bounded by faces, polygons of any number of edges, which are triangulated
// after the last cut.
#ifndef QC_GLUE_FRACTURE_PLANE_CLIP_H
#define QC_GLUE_FRACTURE_PLANE_CLIP_H

#include "fracture/faceted_mesh.h"

#include <optional>
#include <utility>

/// An edge and its two faces: the half-edge from `from` to `to` belongs to the left one, its opposite to the right one.
struct qcClipEdge
{
    uint32_t from, to;
    uint32_t left, right;
};

/// Closed if at each point each face has as many half-edges that leave as enter.
struct qcClipSolid
{
    std::vector<qcClipPoint> points;
    std::vector<qcClipEdge> edges;
    bool mayTouchItself = false; ///< false: parts that share a point are connected across faces that share an edge
    bool hasRoundedCuts = false; ///< false: corners of cut faces are off the planes by rounding in double only
};

/// The triangles of a mesh, whose corners are rounded: all of a triangle lies in a plane that is no further away from
/// its corners than `rounding`.
struct qcRoundedFaces
{
    std::vector<std::array<qcClipPoint, 3>> corners; ///< by face
    double rounding = 0;
};

/// Outside: normal . x > distance.
struct qcClipPlane
{
    qcClipPoint normal;
    double distance;
    uint32_t face;                           ///< number of the cut face
    const qcRoundedFaces* rounded = nullptr; ///< those that may lie in the plane though rounded; null: none
};

/// Indices of triangles.
struct qcSolidDefects
{
    std::optional<size_t> open; ///< the first with an open edge: more half-edges in one direction than in the other
    std::optional<std::pair<size_t, size_t>> equal; ///< the first two with the same corners in the same order, not flat
};

/// Makes a solid of a mesh, from which it drops triangles back to back (fracture/mesh_solid.cpp).
qcSolidDefects qcClipSolid_Make(qcFacetedMesh* mesh, qcClipSolid* solid);

/// Makes a solid of the part of another one, or of its own, that is not outside the plane, and closes it with a cut
/// face. A plane and its mirror image (the same numbers with other signs) cut an edge at the same point, bit by bit.
/// O(edges).
void qcClipSolid_Clip(const qcClipSolid& from, const qcClipPlane& plane, qcClipScratch* scratch, qcClipSolid* to);

/// Triangulates all faces, in ascending order: a closed mesh. Its points have different positions, except those added
/// where rounding made edges of one face cross.
void qcClipSolid_Triangulate(qcClipSolid* solid, qcFacetedMesh* mesh, qcClipScratch* scratch);

#endif
