// Triangles with numbered faces, as they come and as they go.
#ifndef QC_GLUE_FRACTURE_CLIP_MESH_H
#define QC_GLUE_FRACTURE_CLIP_MESH_H

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
    uint32_t face; ///< what it is a part of: triangles of one face lie in one plane
};

struct qcClipMesh
{
    std::vector<qcClipPoint> points;
    std::vector<qcClipTriangle> triangles;
};

/// fracture/scratch.h
struct qcClipScratch;

/// Points at the same position become one. Fills the place of each among those that are left.
void qcWeldPoints(std::vector<qcClipPoint>* points, std::vector<uint32_t>* places, qcClipScratch* scratch);

/// Vertices at the same position become one, and triangles that have one twice are dropped.
void qcClipMesh_Weld(qcClipMesh* mesh, qcClipScratch* scratch);

/// Volume, and the integral of positions over it.
double qcClipMesh_Measure(const qcClipMesh& mesh, qcClipPoint* first);

/// What is connected over vertices, one after another, each with the vertices it has.
std::vector<qcClipMesh> qcClipMesh_FindParts(const qcClipMesh& mesh, qcClipScratch* scratch);

#endif
