// Meshes at both ends of a fracture.
#include "fracture/clip_mesh.h"

#include "fracture/scratch.h"

namespace
{
constexpr uint32_t s_none = UINT32_MAX;
}

void qcWeldPoints(std::vector<qcClipPoint>* points, std::vector<uint32_t>* places, qcClipScratch* scratch)
{
    scratch->positions.Clear(points->size());
    places->resize(points->size());
    uint32_t count = 0;
    for (size_t i = 0; i < points->size(); i++)
    {
        uint32_t place = scratch->positions.FindOrAdd((*points)[i], count);
        (*places)[i] = place;
        if (place == count)
            (*points)[count++] = (*points)[i];
    }
    points->resize(count);
}

void qcClipMesh_Weld(qcClipMesh* mesh, qcClipScratch* scratch)
{
    std::vector<uint32_t>& places = scratch->places;
    qcWeldPoints(&mesh->points, &places, scratch);
    size_t kept = 0;
    for (const qcClipTriangle& triangle : mesh->triangles)
    {
        uint32_t a = places[triangle.corner[0]], b = places[triangle.corner[1]], c = places[triangle.corner[2]];
        mesh->triangles[kept] = {{a, b, c}, triangle.face};
        kept += a != b && b != c && c != a;
    }
    mesh->triangles.resize(kept);
}

double qcClipMesh_Measure(const qcClipMesh& mesh, qcClipPoint* first)
{
    double volume = 0;
    *first = {0, 0, 0};
    if (mesh.points.empty())
        return 0;
    // Tetrahedra from a point of the mesh: from far away they would cancel.
    const qcClipPoint& from = mesh.points[0];
    for (const qcClipTriangle& triangle : mesh.triangles)
    {
        qcClipPoint e[3];
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < 3; i++)
                e[c][i] = mesh.points[triangle.corner[c]][i] - from[i];
        double six = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                     e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                     e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        volume += six / 6;
        for (size_t i = 0; i < 3; i++)
            (*first)[i] += six / 24 * (e[0][i] + e[1][i] + e[2][i]);
    }
    for (size_t i = 0; i < 3; i++)
        (*first)[i] += volume * from[i];
    return volume;
}

std::vector<qcClipMesh> qcClipMesh_FindParts(const qcClipMesh& mesh, qcClipScratch* scratch)
{
    qcUnionFind& islands = scratch->islands;
    islands.Reset(mesh.points.size());
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (size_t c = 1; c < 3; c++)
            islands.Unite(triangle.corner[c], triangle.corner[0]);
    std::vector<qcClipMesh> parts;
    std::vector<uint32_t>&partOf = scratch->parts, &places = scratch->places;
    partOf.assign(mesh.points.size(), s_none);
    places.assign(mesh.points.size(), s_none);
    for (qcClipTriangle triangle : mesh.triangles)
    {
        uint32_t& part = partOf[islands.Find(triangle.corner[0])];
        if (part == s_none)
        {
            part = uint32_t(parts.size());
            parts.emplace_back();
        }
        for (uint32_t& corner : triangle.corner)
        {
            uint32_t& place = places[corner];
            if (place == s_none)
            {
                place = uint32_t(parts[part].points.size());
                parts[part].points.push_back(mesh.points[corner]);
            }
            corner = place;
        }
        parts[part].triangles.push_back(triangle);
    }
    return parts;
}
