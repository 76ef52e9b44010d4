// Compares triangles, and samples clusters: those of triangles that share no vertices have the same indices in all
// bodies of their number, and a foreign order would make boxes as large as the body.
#include "sweep/bvh/bvh_copy.h"

#include "base/aabb.h"

#include <string.h>

enum
{
    qc_sampledClusters = 64
};

// Extents along the axes differ by up to a factor of 1.7 between a triangle and the same one turned.
static const double s_maxSpread = 1.5;

uint64_t qcBvhCopy_KeyOf(const qcBody* body)
{
    const size_t count = 3 * (size_t)body->triangleCount, sampled[3] = {0, count / 2, count - 1};
    uint64_t key = (uint64_t)body->triangleCount << 32 | body->vertexCount;
    for (int i = 0; i < 3 && count != 0; i++)
    {
        key = (key ^ body->indices[sampled[i]]) * 0x9e3779b97f4a7c15u;
        key ^= key >> 32;
    }
    return key;
}

/// The box of one vertex or more.
static qcBounds BoxOf(const double (*vertices)[3], size_t count)
{
    qcBounds box;
    qcBounds_Clear(box.lower, box.upper);
    qcBounds_Include(vertices[0], count, box.lower, box.upper);
    return box;
}

static double ExtentOf(const qcBounds* box)
{
    double extent = 0.0;
    for (int axis = 0; axis < 3; axis++)
        extent += box->upper[axis] - box->lower[axis];
    return extent;
}

/// The sum of the extents of some clusters of the BVH, with the body's positions, relative to that of all of them. NaN
/// if all are at one place.
static double SpreadOf(const qcTriangleBvh* bvh, const qcBody* body)
{
    const double* positions = body->deforming ? body->world : body->local;
    const qcCorners* corners = bvh->corners.data;
    size_t clusters = bvh->corners.count / qc_clusterSize;
    size_t samples = clusters < qc_sampledClusters ? clusters : qc_sampledClusters, endCount = 0;
    double sum = 0.0, ends[2 * qc_sampledClusters][3];
    for (size_t i = 0; i < samples; i++)
    {
        const qcCorners* cluster = corners + i * clusters / samples * qc_clusterSize;
        double vertices[3 * qc_clusterSize][3];
        size_t count = 0;
        for (int k = 0; k < qc_clusterSize * 3; k++)
        {
            uint32_t vertex = cluster[k / 3].vertex[k % 3];
            if (vertex != bvh->vertexCount)
                memcpy(vertices[count++], positions + 3 * (size_t)QC_AT(uint32_t, bvh->vertexOf, vertex),
                       sizeof vertices[0]);
        }
        if (count == 0)
            continue;
        qcBounds box = BoxOf((const double(*)[3])vertices, count);
        sum += ExtentOf(&box);
        memcpy(ends[endCount++], box.lower, sizeof ends[0]);
        memcpy(ends[endCount++], box.upper, sizeof ends[0]);
    }
    qcBounds all = BoxOf((const double(*)[3])ends, endCount);
    return sum / ExtentOf(&all);
}

bool qcBvhCopy_Suits(const qcTriangleBvh* bvh, const qcBody* body, const qcBody* copy)
{
    size_t size = 3 * (size_t)body->triangleCount * sizeof *body->indices;
    return body->triangleCount == copy->triangleCount && body->vertexCount == copy->vertexCount &&
           memcmp(body->indices, copy->indices, size) == 0 && SpreadOf(bvh, copy) <= s_maxSpread * SpreadOf(bvh, body);
}
