// Half-edges, sorted by counting at their lower points.
#include "fracture/triangle_edges.h"

std::vector<qcTriangleEdge> qcSortTriangleEdges(const qcFacetedMesh& mesh, std::vector<size_t>* ends)
{
    std::vector<qcTriangleEdge> triangleEdges(3 * mesh.triangles.size());
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
