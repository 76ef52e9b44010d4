// Copies of a model, piled up so that each overlaps its neighbours.
// Uniform rotations: Shoemake: Uniform random rotations, Graphics Gems III, 1992.
#include "bench/scenes/piles.h"

#include "bench/scenes/shapes.h"
#include "common/mesh_io/bounds.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double s_pi = 3.14159265358979323846;

// Bodies of extent 1: at a spacing below 1 they overlap.
static const double s_spacing = 0.8;

bool qcBenchPile_Copy(const qcMesh* model, qcMesh* copy)
{
    size_t indexSize = (size_t)model->triangleCount * 3 * sizeof(uint32_t);
    float* out = malloc((size_t)model->vertexCount * 3 * sizeof(float));
    *copy = (qcMesh){.positions = out, .vertexCount = model->vertexCount, .triangleCount = model->triangleCount};
    copy->indices = malloc(indexSize);
    if (copy->positions == NULL || copy->indices == NULL)
    {
        qcMesh_Free(copy);
        return false;
    }
    memcpy(copy->indices, model->indices, indexSize);
    for (size_t vertex = 0; vertex < model->vertexCount; ++vertex, out += 3)
    {
        double p[3];
        qcMesh_GetVertex(model, vertex, p);
        for (int i = 0; i < 3; ++i)
            out[i] = (float)p[i];
    }
    return true;
}

bool qcBenchPile_Normalize(const qcMesh* model, qcMesh* body, qcMessage* message)
{
    double lower[3], upper[3], extent = qcMesh_FindBox(model, 1, lower, upper);
    *body = (qcMesh){0};
    if (!(extent > 0.0))
        return qcMessage_Fail(message, "all vertices of the model are one point");
    if (!qcBenchPile_Copy(model, body))
        return qcMessage_Fail(message, "out of memory");
    float* out = body->positions;
    for (size_t vertex = 0; vertex < model->vertexCount; ++vertex, out += 3)
    {
        double p[3];
        qcMesh_GetVertex(model, vertex, p);
        for (int i = 0; i < 3; ++i)
            out[i] = (float)((p[i] - 0.5 * (lower[i] + upper[i])) / extent);
    }
    return true;
}

/// A rotation, all equally likely.
static void Turn(uint64_t* seed, double m[9])
{
    double share = qcBenchShapes_Random(seed, 0.0, 1.0), first = qcBenchShapes_Random(seed, 0.0, 2.0 * s_pi);
    double second = qcBenchShapes_Random(seed, 0.0, 2.0 * s_pi), r = sqrt(1.0 - share), s = sqrt(share);
    double x = r * sin(first), y = r * cos(first), z = s * sin(second), w = s * cos(second);
    const double rows[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                            2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                            2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    memcpy(m, rows, sizeof rows);
}

void qcBenchPile_Place(uint32_t count, qcTransform* places)
{
    uint64_t seed = 8;
    uint32_t side = 1;
    while (side * side * side < count)
        ++side;
    for (uint32_t i = 0; i < count; ++i)
    {
        Turn(&seed, places[i].linear);
        places[i].translation[0] = s_spacing * (i % side);
        places[i].translation[1] = s_spacing * (i / side % side);
        places[i].translation[2] = s_spacing * (i / side / side);
    }
}

void qcBenchPile_Put(const qcMesh* body, const qcTransform* place, float* positions)
{
    for (size_t vertex = 0; vertex < body->vertexCount; ++vertex, positions += 3)
    {
        double p[3];
        qcMesh_GetVertex(body, vertex, p);
        for (int axis = 0; axis < 3; ++axis)
        {
            const double* row = place->linear + 3 * axis;
            positions[axis] = (float)(row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + place->translation[axis]);
        }
    }
}
