// Seeded soups, closed meshes and cloth for the golden programs.
#include "house/golden/meshes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static qcMesh Mesh_Create(uint32_t vertexCount, uint32_t triangleCount)
{
    qcMesh mesh = {calloc(3 * vertexCount, sizeof(double)), calloc(3 * triangleCount, sizeof(uint32_t)), vertexCount,
                   triangleCount};
    if (mesh.positions == NULL || mesh.indices == NULL)
        abort();
    return mesh;
}

qcMesh qcMesh_MakeSoup(qcRandom* random, uint32_t triangleCount, double size, uint32_t lattice)
{
    qcMesh mesh = Mesh_Create(3 * triangleCount, triangleCount);
    double centre[3] = {0, 0, 0};
    for (uint32_t v = 0; v < mesh.vertexCount; v++)
    {
        mesh.indices[v] = v;
        for (int axis = 0; axis < 3; axis++)
        {
            if (v % 3 == 0)
                centre[axis] = qcRandom_Uniform(random, 0.0, 1.0);
            double x = centre[axis] + qcRandom_Uniform(random, -size, size);
            mesh.positions[3 * v + (uint32_t)axis] = lattice > 0 ? floor(x * lattice) / lattice : x;
        }
    }
    return mesh;
}

void qcMesh_MakeDegenerate(qcRandom* random, qcMesh* mesh)
{
    for (uint32_t t = 0; t < mesh->triangleCount; t++)
    {
        double(*corners)[3] = (double(*)[3])(mesh->positions + 9 * (size_t)t);
        switch (qcRandom_Below(random, 6))
        {
            case 0: mesh->indices[3 * t + 2] = mesh->indices[3 * t]; break;
            case 1: memcpy(corners[2], corners[1], sizeof corners[2]); break;
            case 2:
                memcpy(corners[1], corners[0], sizeof corners[1]);
                memcpy(corners[2], corners[0], sizeof corners[2]);
                break;
            case 3:
                for (int axis = 0; axis < 3; axis++)
                    corners[2][axis] = 0.5 * (corners[0][axis] + corners[1][axis]);
                break;
            default: break;
        }
    }
}

qcMesh qcMesh_MakeGrid(uint32_t columns, uint32_t rows, bool closedColumns, bool closedRows)
{
    uint32_t width = columns + !closedColumns, height = rows + !closedRows;
    qcMesh mesh = Mesh_Create(width * height, 2 * columns * rows);
    uint32_t* index = mesh.indices;
    for (uint32_t r = 0; r < rows; r++)
        for (uint32_t c = 0; c < columns; c++)
        {
            uint32_t a = r * width + c, b = r * width + (c + 1) % width;
            uint32_t d = (r + 1) % height * width + c, e = (r + 1) % height * width + (c + 1) % width;
            const uint32_t square[6] = {a, b, e, a, e, d};
            memcpy(index, square, sizeof square);
            index += 6;
        }
    return mesh;
}

void qcGetCirclePoint(double turn, double* c, double* s)
{
    double whole = floor(turn), t = turn - whole;
    double x = (1 - t * t) / (1 + t * t), y = 2 * t / (1 + t * t);
    switch ((int)whole % 4)
    {
        case 0: *c = x, *s = y; break;
        case 1: *c = -y, *s = x; break;
        case 2: *c = -x, *s = -y; break;
        default: *c = y, *s = -x; break;
    }
}

qcMesh qcMesh_MakeTorus(double radius, double tube, uint32_t around, uint32_t across)
{
    qcMesh mesh = qcMesh_MakeGrid(across, around, true, true);
    for (uint32_t v = 0; v < mesh.vertexCount; v++)
    {
        double cu, su, cv, sv;
        qcGetCirclePoint(4.0 * (v / across) / around, &cu, &su);
        qcGetCirclePoint(4.0 * (v % across) / across, &cv, &sv);
        double r = radius + tube * cv;
        double* x = mesh.positions + 3 * v;
        x[0] = r * cu, x[1] = r * su, x[2] = -tube * sv;
    }
    return mesh;
}

qcMesh qcMesh_MakeBox(double radius, uint32_t side, bool round)
{
    uint32_t faceVertices = (side + 1) * (side + 1), faceTriangles = 2 * side * side;
    qcMesh mesh = Mesh_Create(6 * faceVertices, 6 * faceTriangles), grid = qcMesh_MakeGrid(side, side, false, false);
    for (uint32_t face = 0; face < 6; face++)
    {
        double sign = face % 2 == 0 ? 1.0 : -1.0;
        for (uint32_t v = 0; v < faceVertices; v++)
        {
            // Neighbouring faces get the same bits along their common edge.
            double* x = mesh.positions + 3 * (face * faceVertices + v);
            double across = ((double)(2 * (v % (side + 1))) - side) / side;
            double up = ((double)(2 * (v / (side + 1))) - side) / side;
            double scale = radius / (round ? sqrt(1.0 + (across * across + up * up)) : 1.0);
            x[face / 2] = sign * scale;
            x[(face / 2 + 1) % 3] = across * scale;
            x[(face / 2 + 2) % 3] = sign * up * scale;
        }
        for (uint32_t i = 0; i < 3 * faceTriangles; i++)
            mesh.indices[3 * face * faceTriangles + i] = face * faceVertices + grid.indices[i];
    }
    qcMesh_Free(&grid);
    return mesh;
}

void qcMesh_Fold(qcMesh* mesh, uint32_t side, double gap, double noise, qcRandom* random)
{
    for (uint32_t v = 0; v < mesh->vertexCount; v++)
    {
        double along = 3.0 * (v % (side + 1)) / side, layer = fmin(floor(along), 2.0), t = along - layer;
        double smooth = t * t * (3 - 2 * t);
        double* x = mesh->positions + 3 * v;
        x[0] = layer == 1 ? 1 - smooth : smooth;
        x[1] = (double)(v / (side + 1)) / side;
        x[2] = along * gap + qcRandom_Uniform(random, -noise, noise);
    }
}

void qcMesh_Twist(qcMesh* mesh, uint32_t side, double turns, qcRandom* random)
{
    qcMesh_Fold(mesh, side, 0.02 - turns * 0x1p-10, 0.004, random);
    for (uint32_t v = 0; v < mesh->vertexCount; v++)
    {
        double c, s, *x = mesh->positions + 3 * v, across = x[0] - 0.5, high = x[2] * (1.0 - across * across);
        qcGetCirclePoint(turns * x[1], &c, &s);
        x[0] = c * across - s * high, x[1] *= 1.0 - turns / 64.0, x[2] = s * across + c * high;
    }
}

void qcMesh_Move(qcMesh* mesh, double scale, double x, double y, double z)
{
    const double by[3] = {x, y, z};
    for (uint32_t i = 0; i < 3 * mesh->vertexCount; i++)
        mesh->positions[i] = mesh->positions[i] * scale + by[i % 3];
}

void qcMesh_Shake(qcMesh* mesh, qcRandom* random, double noise, uint32_t every)
{
    for (uint32_t v = 0; v < mesh->vertexCount; v++)
        for (uint32_t i = 3 * v; i < 3 * v + 3 && v % every == 0; i++)
            mesh->positions[i] += qcRandom_Uniform(random, -noise, noise);
}

void qcMesh_Free(qcMesh* mesh)
{
    free(mesh->positions);
    free(mesh->indices);
}
