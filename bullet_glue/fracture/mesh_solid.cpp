// The solid that a closed mesh bounds: its edges, each with the triangles on both sides.
#include "fracture/plane_clip.h"

#include "fracture/triangle_edges.h"

#include <algorithm>
#include <cmath>

namespace
{
/// Drops pairs of triangles back to back, which hold no volume. True if there were any.
bool DropBackToBack(const std::vector<qcTriangleEdge>& triangleEdges, const std::vector<size_t>& ends,
                    qcFacetedMesh* mesh)
{
    std::vector<bool> isDropped;
    auto isFree = [&](const qcTriangleEdge& edge) { return isDropped.empty() || !isDropped[edge.triangle]; };
    size_t first = 0;
    for (uint32_t low = 0; low < ends.size(); low++)
        for (; first < ends[low]; first++)
            for (size_t i = first + 1; i < ends[low] && triangleEdges[i].high == triangleEdges[first].high; i++)
            {
                const qcTriangleEdge &a = triangleEdges[first], &b = triangleEdges[i];
                if (a.isDownward == b.isDownward || qcThirdOf(*mesh, a, low) != qcThirdOf(*mesh, b, low) ||
                    !isFree(a) || !isFree(b))
                    continue;
                isDropped.resize(mesh->triangles.size());
                isDropped[a.triangle] = isDropped[b.triangle] = true;
            }
    size_t kept = 0;
    for (size_t i = 0; i < isDropped.size(); i++)
    {
        mesh->triangles[kept] = mesh->triangles[i];
        kept += !isDropped[i];
    }
    if (!isDropped.empty())
        mesh->triangles.resize(kept);
    return !isDropped.empty();
}

/// True if a triangle has no area, but for the rounding of its corners. Pieces have such triangles where cuts cross
/// flat sides.
bool IsFlat(const qcFacetedMesh& mesh, const qcClipTriangle& triangle)
{
    constexpr double minHeight = 1e-5; // by the longest side
    qcClipPoint sides[3];
    double longest2 = 0;
    for (size_t c = 0; c < 3; c++)
    {
        sides[c] = qcMinus(mesh.points[triangle.corner[(c + 1) % 3]], mesh.points[triangle.corner[c]]);
        longest2 = std::max(longest2, qcDotOf(sides[c], sides[c]));
    }
    const qcClipPoint cross = qcCrossOf(sides[0], sides[1]);
    return std::sqrt(qcDotOf(cross, cross)) < minHeight * longest2;
}

/// The first two triangles with the same corners in the same order; flat ones may be given twice.
std::optional<std::pair<size_t, size_t>> FindEqualTriangles(const std::vector<qcTriangleEdge>& triangleEdges,
                                                            const std::vector<size_t>& ends, const qcFacetedMesh& mesh)
{
    std::optional<std::pair<size_t, size_t>> equal;
    size_t first = 0;
    for (uint32_t low = 0; low < ends.size(); low++)
        for (; first < ends[low]; first++)
            for (size_t i = first + 1; i < ends[low] && triangleEdges[i].high == triangleEdges[first].high; i++)
            {
                const qcTriangleEdge &a = triangleEdges[first], &b = triangleEdges[i];
                if (a.isDownward != b.isDownward || qcThirdOf(mesh, a, low) != qcThirdOf(mesh, b, low) ||
                    IsFlat(mesh, mesh.triangles[a.triangle]))
                    continue;
                const std::pair<size_t, size_t> found = {a.triangle, b.triangle};
                equal = equal ? std::min(*equal, found) : found;
            }
    return equal;
}
} // namespace

qcSolidDefects qcClipSolid_Make(qcFacetedMesh* mesh, qcClipSolid* solid)
{
    std::vector<size_t> ends;
    std::vector<qcTriangleEdge> triangleEdges = qcSortTriangleEdges(*mesh, &ends);
    if (DropBackToBack(triangleEdges, ends, mesh))
        triangleEdges = qcSortTriangleEdges(*mesh, &ends);
    solid->points = mesh->points;
    solid->edges.clear();
    qcSolidDefects defects;
    defects.equal = FindEqualTriangles(triangleEdges, ends, *mesh);
    for (size_t low = 0, first = 0; low < ends.size(); low++)
        while (first < ends[low])
        {
            uint32_t high = triangleEdges[first].high;
            size_t middle = first, last = first;
            for (; last < ends[low] && triangleEdges[last].high == high; last++)
                middle += !triangleEdges[last].isDownward;
            if (middle - first != last - middle)
                for (size_t i = first; i < last; i++)
                    defects.open = std::min(defects.open.value_or(SIZE_MAX), size_t(triangleEdges[i].triangle));
            for (size_t i = 0; i < std::min(middle - first, last - middle); i++)
                solid->edges.push_back({uint32_t(low), high, mesh->triangles[triangleEdges[first + i].triangle].face,
                                        mesh->triangles[triangleEdges[middle + i].triangle].face});
            first = last;
        }
    return defects;
}
