// The half-edges of a triangle mesh, those of each edge side by side.
#ifndef QC_GLUE_FRACTURE_TRIANGLE_EDGES_H
#define QC_GLUE_FRACTURE_TRIANGLE_EDGES_H

#include "fracture/faceted_mesh.h"

#include <tuple>

/// A half-edge of a triangle, listed at its point with the lower index.
struct qcTriangleEdge
{
    uint32_t high;
    bool isDownward; ///< it leads to the point with the lower index
    uint32_t triangle;

    bool operator<(const qcTriangleEdge& other) const
    {
        return std::tie(high, isDownward, triangle) < std::tie(other.high, other.isDownward, other.triangle);
    }
};

/// Half-edges by their lower points, sorted; `ends` receives the end of those of each point.
std::vector<qcTriangleEdge> qcSortTriangleEdges(const qcFacetedMesh& mesh, std::vector<size_t>* ends);

/// The third point of the triangle of a half-edge that is listed at `low`.
inline uint32_t qcThirdOf(const qcFacetedMesh& mesh, const qcTriangleEdge& edge, uint32_t low)
{
    const std::array<uint32_t, 3>& v = mesh.triangles[edge.triangle].corner;
    return v[0] + v[1] + v[2] - low - edge.high;
}

#endif
