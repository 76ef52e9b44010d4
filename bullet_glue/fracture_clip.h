// Cuts closed meshes by planes and closes them again.
#ifndef QC_BULLET_GLUE_FRACTURE_CLIP_H
#define QC_BULLET_GLUE_FRACTURE_CLIP_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

using qcClipPoint = std::array<double, 3>;

inline double qcDotOf(const qcClipPoint& a, const qcClipPoint& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct qcClipTriangle
{
    std::array<uint32_t, 3> corner;
    uint32_t face; ///< what it is a part of: triangles of one face lie in one plane, and two faces meet in a line
};

struct qcClipMesh
{
    std::vector<qcClipPoint> points;
    std::vector<qcClipTriangle> triangles;
    size_t leastTriangles = SIZE_MAX; ///< that cuts have left since it was made simple
};

/// fracture_scratch.h
struct qcClipScratch;

/// What is outside has normal . x > distance.
struct qcClipPlane
{
    qcClipPoint normal;
    double distance;
    uint32_t face; ///< of the triangles that close the cut
};

/// Vertices at the same position become one, those that no triangle has are dropped, and triangles that have one twice.
void qcClipMesh_Weld(qcClipMesh* mesh, qcClipScratch* scratch);

/// A triangle with an edge that is passed more often one way than the other, or the number of triangles.
size_t qcClipMesh_FindOpenTriangle(const qcClipMesh& mesh, qcClipScratch* scratch);

/// Volume, and the integral of positions over it.
double qcClipMesh_Measure(const qcClipMesh& mesh, qcClipPoint* first);

/// Takes away what is outside of the plane, and puts a face there. No two points of the mesh are at one place, as after
/// qcClipMesh_Weld; none are then. Points where the plane cuts an edge are the same for
/// the plane and for its mirror image (the same numbers with other signs), bit by bit. Now and then the mesh is made
/// simple.
void qcClipMesh_Cut(qcClipMesh* mesh, const qcClipPlane& plane, qcClipScratch* scratch);

/// Cuts leave splinters: makes each face anew from its outline. A closed mesh stays closed.
void qcClipMesh_Simplify(qcClipMesh* mesh, qcClipScratch* scratch);

#endif
