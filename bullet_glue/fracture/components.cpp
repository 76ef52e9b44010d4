// Connected parts of a mesh. Around an edge that four or more triangles share, matter is between a triangle and the
// next one in the order of their angles: two wedges that meet in nothing but the edge are not connected.
#include "fracture/scratch.h"
#include "fracture/triangle_edges.h"

#include <cmath>
#include <iterator>

namespace
{
constexpr uint32_t s_none = UINT32_MAX;
constexpr double s_minAngle = 1e-6; ///< between triangles: below it, rounding may have put them in a wrong order

/// A triangle at an edge, by its angle around the edge, counterclockwise as seen from the edge's end with the higher
/// index.
struct Side
{
    double angle;
    bool isDownward; ///< what is inside is counterclockwise of it, otherwise clockwise
    uint32_t triangle;
};

/// The triangles of the half-edges from `first` to `last`, all of one edge, by angle. Empty: their order is uncertain.
std::vector<Side> SortAround(const qcFacetedMesh& mesh, uint32_t low, const qcTriangleEdge* first,
                             const qcTriangleEdge* last)
{
    const qcClipPoint& from = mesh.points[low];
    const qcClipPoint along = qcMinus(mesh.points[first->high], from);
    const double length2 = qcDotOf(along, along), length = std::sqrt(length2);
    qcClipPoint start = {0, 0, 0};
    std::vector<Side> sides;
    for (const qcTriangleEdge* edge = first; edge != last; edge++)
    {
        qcClipPoint across = qcMinus(mesh.points[qcThirdOf(mesh, *edge, low)], from);
        const double square = qcDotOf(across, across), part = qcDotOf(across, along) / length2;
        for (size_t i = 0; i < 3; i++)
            across[i] -= part * along[i];
        if (!(qcDotOf(across, across) > s_minAngle * s_minAngle * std::max(square, length2)))
            return {};
        if (edge == first)
            start = across;
        sides.push_back({std::atan2(qcDotOf(along, qcCrossOf(start, across)) / length, qcDotOf(start, across)),
                         edge->isDownward, edge->triangle});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.angle < b.angle; });
    const double turn = 2 * 3.14159265358979323846;
    for (size_t i = 0; i < sides.size(); i++)
    {
        const Side &side = sides[i], &next = sides[(i + 1) % sides.size()];
        const double angle = next.angle - side.angle + (i + 1 == sides.size() ? turn : 0);
        if (angle < s_minAngle || side.isDownward == next.isDownward)
            return {};
    }
    return sides;
}

/// Unites triangles that are connected across edges. Returns the number of sets.
size_t UniteAcrossEdges(const qcFacetedMesh& mesh, qcUnionFind* parts)
{
    std::vector<size_t> ends;
    const std::vector<qcTriangleEdge> edges = qcSortTriangleEdges(mesh, &ends);
    parts->Reset(mesh.triangles.size());
    for (size_t low = 0, first = 0; low < ends.size(); low++)
        for (size_t last; first < ends[low]; first = last)
        {
            for (last = first + 1; last < ends[low] && edges[last].high == edges[first].high;)
                last++;
            std::vector<Side> sides;
            if (last - first > 2)
                sides = SortAround(mesh, uint32_t(low), &edges[first], &edges[first] + (last - first));
            for (size_t i = 0; i < sides.size(); i++)
                if (sides[i].isDownward)
                    parts->Unite(sides[i].triangle, sides[(i + 1) % sides.size()].triangle);
            for (size_t i = first + 1; i < last && sides.empty(); i++)
                parts->Unite(edges[first].triangle, edges[i].triangle);
        }
    size_t sets = 0;
    for (uint32_t i = 0; i < mesh.triangles.size(); i++)
        sets += parts->Find(i) == i;
    return sets;
}

/// The meshes of the triangles of each set, each with its own vertices, in the order of their first triangles. `setOf`:
/// a number below that of triangles and points, for the index of a triangle.
template <typename Function>
std::vector<qcFacetedMesh> MeshesOf(const qcFacetedMesh& mesh, qcClipScratch* scratch, Function setOf)
{
    std::vector<qcFacetedMesh> meshes;
    std::vector<uint32_t>&meshOf = scratch->component, &newIndices = scratch->newIndices;
    meshOf.assign(std::max(mesh.triangles.size(), mesh.points.size()), s_none);
    for (uint32_t i = 0; i < mesh.triangles.size(); i++)
    {
        uint32_t& index = meshOf[setOf(i)];
        if (index == s_none)
        {
            index = uint32_t(meshes.size());
            meshes.emplace_back();
        }
        meshes[index].triangles.push_back(mesh.triangles[i]);
    }
    newIndices.assign(mesh.points.size(), 0);
    std::vector<uint32_t> points; // of one mesh; new indices that don't lead back are of an earlier one
    for (qcFacetedMesh& part : meshes)
    {
        points.clear();
        for (qcClipTriangle& triangle : part.triangles)
            for (uint32_t& corner : triangle.corner)
            {
                uint32_t& newIndex = newIndices[corner];
                if (newIndex >= points.size() || points[newIndex] != corner)
                {
                    newIndex = uint32_t(points.size());
                    points.push_back(corner);
                    part.points.push_back(mesh.points[corner]);
                }
                corner = newIndex;
            }
    }
    return meshes;
}

/// The components, connected over vertices.
std::vector<qcFacetedMesh> FindTouching(const qcFacetedMesh& mesh, qcClipScratch* scratch)
{
    qcUnionFind& components = scratch->components;
    components.Reset(mesh.points.size());
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (size_t c = 1; c < 3; c++)
            components.Unite(triangle.corner[c], triangle.corner[0]);
    return MeshesOf(mesh, scratch, [&](uint32_t i) { return components.Find(mesh.triangles[i].corner[0]); });
}

/// Replaces a component by its parts, connected across edges, if at least two of them hold more than `minVolume`.
void SplitWhereItTouches(qcFacetedMesh component, double minVolume, qcClipScratch* scratch,
                         std::vector<qcFacetedMesh>* components)
{
    qcUnionFind& sets = scratch->components;
    std::vector<qcFacetedMesh> parts;
    if (UniteAcrossEdges(component, &sets) > 1)
        parts = MeshesOf(component, scratch, [&](uint32_t i) { return sets.Find(i); });
    qcClipPoint first;
    const auto holds = [&](const qcFacetedMesh& part) { return qcFacetedMesh_Measure(part, &first) > minVolume; };
    if (std::count_if(parts.begin(), parts.end(), holds) > 1)
        std::move(parts.begin(), parts.end(), std::back_inserter(*components));
    else
        components->push_back(std::move(component));
}
} // namespace

std::vector<qcFacetedMesh> qcFacetedMesh_FindComponents(const qcFacetedMesh& mesh, bool mayTouchItself,
                                                        double minVolume, qcClipScratch* scratch)
{
    std::vector<qcFacetedMesh> touching = FindTouching(mesh, scratch);
    if (!mayTouchItself)
        return touching;
    std::vector<qcFacetedMesh> components;
    for (qcFacetedMesh& component : touching)
        SplitWhereItTouches(std::move(component), minVolume, scratch, &components);
    return components;
}

bool qcFacetedMesh_TouchesItself(const qcFacetedMesh& mesh)
{
    std::vector<size_t> ends;
    const std::vector<qcTriangleEdge> edges = qcSortTriangleEdges(mesh, &ends);
    // Corners of triangles that follow each other around a vertex: more than one set there is more than one fan.
    qcUnionFind fans;
    fans.Reset(3 * mesh.triangles.size());
    auto cornerAt = [&](const qcTriangleEdge& edge, uint32_t point)
    {
        const std::array<uint32_t, 3>& v = mesh.triangles[edge.triangle].corner;
        return 3 * edge.triangle + (v[0] == point ? 0 : v[1] == point ? 1 : 2);
    };
    for (uint32_t low = 0, first = 0; low < ends.size(); low++)
        for (; first < ends[low]; first += 2)
        {
            const qcTriangleEdge *edge = &edges[first], *other = edge + 1;
            if (first + 2 < ends[low] && edge[2].high == edge->high)
                return true;
            fans.Unite(cornerAt(*edge, low), cornerAt(*other, low));
            fans.Unite(cornerAt(*edge, edge->high), cornerAt(*other, edge->high));
        }
    std::vector<uint32_t> fanAt(mesh.points.size(), s_none);
    for (uint32_t i = 0; i < 3 * mesh.triangles.size(); i++)
    {
        uint32_t& fan = fanAt[mesh.triangles[i / 3].corner[i % 3]];
        if (fan != s_none && fan != fans.Find(i))
            return true;
        fan = fans.Find(i);
    }
    return false;
}
