// Vertices and bounding boxes of meshes.
#include "common/mesh_io/bounds.h"

#include <math.h>

void qcMesh_GetVertex(const qcMesh* mesh, size_t vertex, double p[3])
{
    for (size_t i = 0; i < 3; ++i)
        p[i] = mesh->isDouble ? ((const double*)mesh->positions)[3 * vertex + i]
                              : ((const float*)mesh->positions)[3 * vertex + i];
}

double qcMesh_FindBox(const qcMesh* meshes, uint32_t count, double lower[3], double upper[3])
{
    for (int i = 0; i < 3; ++i)
    {
        lower[i] = HUGE_VAL;
        upper[i] = -HUGE_VAL;
    }
    for (uint32_t mesh = 0; mesh < count; ++mesh)
    {
        for (size_t vertex = 0; vertex < meshes[mesh].vertexCount; ++vertex)
        {
            double p[3];
            qcMesh_GetVertex(&meshes[mesh], vertex, p);
            for (int i = 0; i < 3; ++i)
            {
                lower[i] = p[i] < lower[i] ? p[i] : lower[i];
                upper[i] = p[i] > upper[i] ? p[i] : upper[i];
            }
        }
    }
    double extent = 0.0;
    for (int i = 0; i < 3; ++i)
        extent = upper[i] - lower[i] > extent ? upper[i] - lower[i] : extent;
    return extent;
}
