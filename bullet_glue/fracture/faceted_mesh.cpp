// Welding and volume of meshes.
#include "fracture/faceted_mesh.h"

#include "fracture/scratch.h"

void qcWeldPoints(std::vector<qcClipPoint>* points, std::vector<uint32_t>* newIndices, qcClipScratch* scratch)
{
    scratch->positions.Clear(points->size());
    newIndices->resize(points->size());
    uint32_t count = 0;
    for (size_t i = 0; i < points->size(); i++)
    {
        uint32_t newIndex = scratch->positions.FindOrAdd((*points)[i], count);
        (*newIndices)[i] = newIndex;
        if (newIndex == count)
            (*points)[count++] = (*points)[i];
    }
    points->resize(count);
}

void qcFacetedMesh_Weld(qcFacetedMesh* mesh, qcClipScratch* scratch)
{
    std::vector<uint32_t>& newIndices = scratch->newIndices;
    qcWeldPoints(&mesh->points, &newIndices, scratch);
    size_t kept = 0;
    for (const qcClipTriangle& triangle : mesh->triangles)
    {
        uint32_t a = newIndices[triangle.corner[0]], b = newIndices[triangle.corner[1]],
                 c = newIndices[triangle.corner[2]];
        mesh->triangles[kept] = {{a, b, c}, triangle.face};
        kept += a != b && b != c && c != a;
    }
    mesh->triangles.resize(kept);
}

double qcFacetedMesh_Measure(const qcFacetedMesh& mesh, qcClipPoint* first)
{
    double volume = 0;
    *first = {0, 0, 0};
    if (mesh.points.empty())
        return 0;
    // Tetrahedra from a point of the mesh: from a far point their volumes would cancel.
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
