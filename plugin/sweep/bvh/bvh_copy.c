// Compares triangles, and samples clusters: those of triangles that share no vertices have the same indices in all
// bodies of their number, and a foreign order would make boxes as large as the body.
#include "sweep/bvh/bvh_copy.h"

#include <math.h>
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

typedef struct Box
{
    double lower[3], upper[3];
} Box;

static const Box s_emptyBox = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

static void Include(Box* box, const double* lower, const double* upper)
{
    for (int axis = 0; axis < 3; axis++)
    {
        box->lower[axis] = fmin(box->lower[axis], lower[axis]);
        box->upper[axis] = fmax(box->upper[axis], upper[axis]);
    }
}

static double ExtentOf(const Box* box)
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
    size_t samples = clusters < qc_sampledClusters ? clusters : qc_sampledClusters;
    double sum = 0.0;
    Box all = s_emptyBox;
    for (size_t i = 0; i < samples; i++)
    {
        const qcCorners* cluster = corners + i * clusters / samples * qc_clusterSize;
        Box box = s_emptyBox;
        for (int k = 0; k < qc_clusterSize * 3; k++)
        {
            uint32_t vertex = cluster[k / 3].vertex[k % 3];
            if (vertex == bvh->vertexCount)
                continue;
            const double* p = positions + 3 * (size_t)QC_AT(uint32_t, bvh->vertexOf, vertex);
            Include(&box, p, p);
        }
        if (!(box.lower[0] <= box.upper[0]))
            continue;
        sum += ExtentOf(&box);
        Include(&all, box.lower, box.upper);
    }
    return sum / ExtentOf(&all);
}

bool qcBvhCopy_Suits(const qcTriangleBvh* bvh, const qcBody* body, const qcBody* copy)
{
    size_t size = 3 * (size_t)body->triangleCount * sizeof *body->indices;
    return body->triangleCount == copy->triangleCount && body->vertexCount == copy->vertexCount &&
           memcmp(body->indices, copy->indices, size) == 0 && SpreadOf(bvh, copy) <= s_maxSpread * SpreadOf(bvh, body);
}
