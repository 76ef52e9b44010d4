// The solid that a closed mesh bounds: its edges, each with the triangles on both sides.
#include "fracture/plane_clip.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace
{
/// A half-edge of a triangle, listed at its point with the lower index.
struct TriangleEdge
{
    uint32_t high;
    bool isDownward; ///< it leads to the point with the lower index
    uint32_t triangle;

    bool operator<(const TriangleEdge& other) const
    {
        return std::tie(high, isDownward, triangle) < std::tie(other.high, other.isDownward, other.triangle);
    }
};

/// Half-edges by their lower points, sorted; `ends` receives the end of those of each point.
std::vector<TriangleEdge> SortTriangleEdges(const qcFacetedMesh& mesh, std::vector<size_t>* ends)
{
    std::vector<TriangleEdge> triangleEdges(3 * mesh.triangles.size());
    ends->assign(mesh.points.size() + 1, 0);
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (size_t c = 0; c < 3; c++)
            (*ends)[std::min(triangle.corner[c], triangle.corner[(c + 1) % 3]) + 1]++;
    for (size_t i = 1; i < ends->size(); i++)
        (*ends)[i] += (*ends)[i - 1];
    for (size_t i = 0; i < mesh.triangles.size(); i++)
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t from = mesh.triangles[i].corner[c], to = mesh.triangles[i].corner[(c + 1) % 3];
            triangleEdges[(*ends)[std::min(from, to)]++] = {std::max(from, to), from > to, uint32_t(i)};
        }
    ends->pop_back();
    size_t first = 0;
    for (size_t end : *ends)
    {
        std::sort(triangleEdges.begin() + std::ptrdiff_t(first), triangleEdges.begin() + std::ptrdiff_t(end));
        first = end;
    }
    return triangleEdges;
}

uint32_t ThirdOf(const qcFacetedMesh& mesh, const TriangleEdge& edge, uint32_t low)
{
    const std::array<uint32_t, 3>& v = mesh.triangles[edge.triangle].corner;
    return v[0] + v[1] + v[2] - low - edge.high;
}

/// Drops pairs of triangles back to back, which hold no volume. True if there were any.
bool DropBackToBack(const std::vector<TriangleEdge>& triangleEdges, const std::vector<size_t>& ends,
                    qcFacetedMesh* mesh)
{
    std::vector<bool> isDropped;
    auto isFree = [&](const TriangleEdge& edge) { return isDropped.empty() || !isDropped[edge.triangle]; };
    size_t first = 0;
    for (uint32_t low = 0; low < ends.size(); low++)
        for (; first < ends[low]; first++)
            for (size_t i = first + 1; i < ends[low] && triangleEdges[i].high == triangleEdges[first].high; i++)
            {
                const TriangleEdge &a = triangleEdges[first], &b = triangleEdges[i];
                if (a.isDownward == b.isDownward || ThirdOf(*mesh, a, low) != ThirdOf(*mesh, b, low) || !isFree(a) ||
                    !isFree(b))
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
std::optional<std::pair<size_t, size_t>> FindEqualTriangles(const std::vector<TriangleEdge>& triangleEdges,
                                                            const std::vector<size_t>& ends, const qcFacetedMesh& mesh)
{
    std::optional<std::pair<size_t, size_t>> equal;
    size_t first = 0;
    for (uint32_t low = 0; low < ends.size(); low++)
        for (; first < ends[low]; first++)
            for (size_t i = first + 1; i < ends[low] && triangleEdges[i].high == triangleEdges[first].high; i++)
            {
                const TriangleEdge &a = triangleEdges[first], &b = triangleEdges[i];
                if (a.isDownward != b.isDownward || ThirdOf(mesh, a, low) != ThirdOf(mesh, b, low) ||
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
    std::vector<TriangleEdge> triangleEdges = SortTriangleEdges(*mesh, &ends);
    if (DropBackToBack(triangleEdges, ends, mesh))
        triangleEdges = SortTriangleEdges(*mesh, &ends);
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
