// The pairs of a mesh by CGAL: triangles that touch or penetrate and share no vertex, by box_self_intersection_d and
// the exact predicate do_intersect. A line each, sorted, as `qc-pairs --touching --out` writes them without the
// relation. Left out, because CGAL's triangles have area: those without, which standard error counts.
#include "common/mesh_io/mesh_file.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <utility>
#include <variant>
#include <vector>

namespace
{

typedef CGAL::Exact_predicates_inexact_constructions_kernel Kernel;
typedef std::variant<Kernel::Triangle_3, Kernel::Segment_3, Kernel::Point_3> Simplex;
typedef std::vector<Simplex> Simplices;
typedef CGAL::Box_intersection_d::Box_with_handle_d<double, 3, Simplices::const_iterator> Box;

Kernel::Point_3 PointOf(const qcMesh& mesh, uint32_t vertex)
{
    double x[3];
    for (int axis = 0; axis < 3; ++axis)
    {
        const size_t i = 3 * size_t(vertex) + size_t(axis);
        x[axis] = mesh.isDouble ? static_cast<const double*>(mesh.positions)[i]
                                : double(static_cast<const float*>(mesh.positions)[i]);
    }
    return {x[0], x[1], x[2]};
}

bool AreNeighbours(const qcMesh& mesh, size_t a, size_t b)
{
    const uint32_t* second = mesh.indices + 3 * b;
    return std::any_of(mesh.indices + 3 * a, mesh.indices + 3 * a + 3,
                       [second](uint32_t v) { return std::find(second, second + 3, v) != second + 3; });
}

/// The convex hull of three points. The ends of points on a line are their lexicographic extremes.
Simplex HullOf(const Kernel::Point_3& p, const Kernel::Point_3& q, const Kernel::Point_3& r)
{
    if (!CGAL::collinear(p, q, r))
        return Kernel::Triangle_3(p, q, r);
    const Kernel::Point_3 lower = std::min({p, q, r}), upper = std::max({p, q, r});
    if (lower == upper)
        return p;
    return Kernel::Segment_3(lower, upper);
}

bool Intersect(const Simplex& a, const Simplex& b)
{
    return std::visit([](const auto& x, const auto& y) { return CGAL::do_intersect(x, y); }, a, b);
}

void PrintPairs(const qcMesh& mesh)
{
    Simplices simplices;
    simplices.reserve(mesh.triangleCount);
    for (size_t i = 0; i < mesh.triangleCount; ++i)
    {
        const uint32_t* v = mesh.indices + 3 * i;
        simplices.push_back(HullOf(PointOf(mesh, v[0]), PointOf(mesh, v[1]), PointOf(mesh, v[2])));
    }
    std::vector<Box> boxes;
    size_t flat = 0;
    for (auto s = simplices.cbegin(); s != simplices.cend(); ++s)
    {
        boxes.emplace_back(std::visit([](const auto& x) { return x.bbox(); }, *s), s);
        flat += s->index() != 0;
    }
    if (flat != 0)
        std::fprintf(stderr, "%zu triangles without area\n", flat);
    std::vector<std::pair<size_t, size_t>> pairs;
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(),
                                  [&](const Box& a, const Box& b)
                                  {
                                      const size_t x = size_t(a.handle() - simplices.cbegin());
                                      const size_t y = size_t(b.handle() - simplices.cbegin());
                                      if (!AreNeighbours(mesh, x, y) && Intersect(*a.handle(), *b.handle()))
                                          pairs.emplace_back(std::minmax(x, y));
                                  });
    std::sort(pairs.begin(), pairs.end());
    for (const auto& pair : pairs)
        std::printf("0 %zu 0 %zu\n", pair.first, pair.second);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 2 || std::strcmp(argv[1], "--help") == 0)
    {
        std::printf("Usage: cgal_pairs MESH\nPrints the pairs of triangles of a PLY or OBJ that CGAL finds.\n");
        return argc == 2 ? 0 : 2;
    }
    qcMesh mesh;
    qcMessage message;
    if (!qcMesh_ReadFile(argv[1], qc_meshAsDeclared, &mesh, &message))
    {
        std::fprintf(stderr, "%s\n", message.text);
        return 1;
    }
    PrintPairs(mesh);
    qcMesh_Free(&mesh);
    return 0;
}
