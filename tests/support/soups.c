// Seeded triangle soups. Only operations that IEEE 754 rounds correctly, so that a seed gives the same bits everywhere.
// Random numbers: Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014 (splitmix64).
#include "support/soups.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

//  ---- random numbers ------------------------------------------------------------------------------

uint64_t qcRandom_Next(qcRandom* random)
{
    uint64_t z = random->state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

uint32_t qcRandom_Below(qcRandom* random, uint32_t bound)
{
    return (uint32_t)((qcRandom_Next(random) >> 32) * bound >> 32);
}

double qcRandom_Integer(qcRandom* random, int lower, int upper)
{
    return (double)lower + (double)qcRandom_Below(random, (uint32_t)(upper - lower + 1));
}

double qcRandom_Uniform(qcRandom* random, double lower, double upper)
{
    double unit = (double)(qcRandom_Next(random) >> 11) * 0x1p-53;
    double value = lower + unit * (upper - lower);
    return value < upper ? value : lower; // the sum may round up to `upper`
}

//  ---- soups ---------------------------------------------------------------------------------------

static void* Allocate(size_t count, size_t size)
{
    void* memory = malloc(count * size + 1);
    if (memory == NULL)
    {
        fputs("soups: out of memory\n", stderr);
        abort();
    }
    return memory;
}

static qcSoup Soup_Create(uint32_t vertexCount, uint32_t triangleCount)
{
    qcSoup soup;
    soup.positions = Allocate((size_t)vertexCount * 3, sizeof(double));
    soup.vertexCount = vertexCount;
    soup.indices = Allocate((size_t)triangleCount * 3, sizeof(uint32_t));
    soup.triangleCount = triangleCount;
    return soup;
}

void qcSoup_Free(qcSoup* soup)
{
    free(soup->positions);
    free(soup->indices);
    memset(soup, 0, sizeof *soup);
}

void qcSoup_GetTriangle(const qcSoup* soup, uint32_t triangle, double corners[3][3])
{
    for (size_t i = 0; i < 3; ++i)
        memcpy(corners[i], soup->positions + 3 * (size_t)soup->indices[3 * (size_t)triangle + i], sizeof corners[i]);
}

bool qcSoup_AreNeighbours(const qcSoup* soup, uint32_t triangleA, uint32_t triangleB)
{
    const uint32_t* a = soup->indices + 3 * (size_t)triangleA;
    const uint32_t* b = soup->indices + 3 * (size_t)triangleB;
    for (int i = 0; i < 9; ++i)
        if (a[i / 3] == b[i % 3])
            return true;
    return false;
}

void qcSoup_RoundToFloat(qcSoup* soup)
{
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; ++i)
        soup->positions[i] = (double)(float)soup->positions[i];
}

void qcSoup_Translate(qcSoup* soup, double x, double y, double z)
{
    for (size_t i = 0; i < soup->vertexCount; ++i)
    {
        soup->positions[3 * i] += x;
        soup->positions[3 * i + 1] += y;
        soup->positions[3 * i + 2] += z;
    }
}

void qcSoup_RotateTriangles(qcSoup* soup, uint32_t count)
{
    size_t moved = 3 * (size_t)count, kept = 3 * (size_t)(soup->triangleCount - count);
    uint32_t* first = malloc((moved + 1) * sizeof(uint32_t));
    if (first == NULL)
        abort();
    memcpy(first, soup->indices, moved * sizeof(uint32_t));
    memmove(soup->indices, soup->indices + moved, kept * sizeof(uint32_t));
    memcpy(soup->indices + kept, first, moved * sizeof(uint32_t));
    free(first);
}

static void FillRandom(qcSoup* soup, qcRandom* random, double size)
{
    for (uint32_t t = 0; t < soup->triangleCount; ++t)
    {
        double centre[3];
        for (int axis = 0; axis < 3; ++axis)
            centre[axis] = qcRandom_Uniform(random, 0, 1);
        for (size_t i = 3 * (size_t)t; i < 3 * (size_t)t + 3; ++i)
        {
            soup->indices[i] = (uint32_t)i;
            for (size_t axis = 0; axis < 3; ++axis)
                soup->positions[3 * i + axis] = centre[axis] + qcRandom_Uniform(random, -size, size);
        }
    }
}

qcSoup qcSoup_MakeRandom(uint64_t seed, uint32_t triangleCount, double size)
{
    qcRandom random = {seed};
    qcSoup soup = Soup_Create(3 * triangleCount, triangleCount);
    FillRandom(&soup, &random, size);
    return soup;
}

qcSoup qcSoup_MakeDegenerate(uint64_t seed, uint32_t triangleCount, double size, double share)
{
    qcRandom random = {seed};
    qcSoup soup = Soup_Create(3 * triangleCount, triangleCount);
    FillRandom(&soup, &random, size);
    for (uint32_t t = 0; t < triangleCount; ++t)
    {
        if (qcRandom_Uniform(&random, 0, 1) >= share)
            continue;
        uint32_t* index = soup.indices + 3 * (size_t)t;
        double(*corner)[3] = (double(*)[3])(soup.positions + 9 * (size_t)t);
        switch (qcRandom_Below(&random, 4))
        {
            case 0: index[2] = index[0]; break;
            case 1: memcpy(corner[2], corner[1], sizeof corner[2]); break;
            case 2:
                memcpy(corner[1], corner[0], sizeof corner[1]);
                memcpy(corner[2], corner[0], sizeof corner[2]);
                break;
            default: // a segment up to rounding
                for (int axis = 0; axis < 3; ++axis)
                    corner[2][axis] = 0.5 * (corner[0][axis] + corner[1][axis]);
                break;
        }
    }
    return soup;
}

// Vertices row by row from `firstVertex`, triangles from `firstTriangle`. The caller sets positions.
static void ConnectGrid(qcSoup* soup, uint32_t firstVertex, uint32_t firstTriangle, uint32_t side)
{
    uint32_t* index = soup->indices + 3 * (size_t)firstTriangle;
    for (uint32_t row = 0; row < side; ++row)
        for (uint32_t column = 0; column < side; ++column)
        {
            uint32_t corner = firstVertex + row * (side + 1) + column;
            const uint32_t square[6] = {corner, corner + 1,        corner + side + 2,
                                        corner, corner + side + 2, corner + side + 1};
            memcpy(index, square, sizeof square);
            index += 6;
        }
}

qcSoup qcSoup_MakeGrid(uint32_t side)
{
    return qcSoup_MakeSheets(1, side, 0);
}

qcSoup qcSoup_MakeSheets(uint32_t layerCount, uint32_t side, double gap)
{
    const uint32_t layerVertices = (side + 1) * (side + 1);
    qcSoup soup = Soup_Create(layerCount * layerVertices, layerCount * 2 * side * side);
    double* position = soup.positions;
    for (uint32_t layer = 0; layer < layerCount; ++layer)
    {
        ConnectGrid(&soup, layer * layerVertices, layer * 2 * side * side, side);
        for (uint32_t i = 0; i < layerVertices; ++i, position += 3)
        {
            position[0] = (double)(i % (side + 1)) / side;
            position[1] = (double)(i / (side + 1)) / side;
            position[2] = layer * gap;
        }
    }
    return soup;
}

qcSoup qcSoup_MakeFoldedCloth(uint64_t seed, uint32_t side, double gap, double noise)
{
    qcRandom random = {seed};
    qcSoup soup = Soup_Create((side + 1) * (side + 1), 2 * side * side);
    ConnectGrid(&soup, 0, 0, side);
    for (uint32_t i = 0; i < soup.vertexCount; ++i)
    {
        double along = 3.0 * (i % (side + 1)) / side;
        double layer = fmin(floor(along), 2);
        double t = along - layer;
        double smooth = t * t * (3 - 2 * t);
        double* position = soup.positions + 3 * (size_t)i;
        position[0] = layer == 1 ? 1 - smooth : smooth;
        position[1] = (double)(i / (side + 1)) / side;
        position[2] = along * gap + qcRandom_Uniform(&random, -noise, noise);
    }
    return soup;
}

//  ---- the sphere ----------------------------------------------------------------------------------

static void PushOntoSphere(double p[3], double radius)
{
    double scale = radius / sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    for (int axis = 0; axis < 3; ++axis)
        p[axis] *= scale;
}

static qcSoup MakeIcosahedron(double radius)
{
    static const double corners[12][3] = {{-1, 0, 1}, {1, 0, 1},   {-1, 0, -1}, {1, 0, -1}, {0, 1, 1},  {0, 1, -1},
                                          {0, -1, 1}, {0, -1, -1}, {1, 1, 0},   {-1, 1, 0}, {1, -1, 0}, {-1, -1, 0}};
    static const uint32_t faces[60] = {0, 1, 4, 0, 4, 9, 9,  4, 5, 4,  8, 5, 4,  1,  8,  8, 1, 10, 8,  10,
                                       3, 5, 8, 3, 5, 3, 2,  2, 3, 7,  7, 3, 10, 7,  10, 6, 7, 6,  11, 11,
                                       6, 0, 0, 6, 1, 6, 10, 1, 9, 11, 0, 9, 2,  11, 9,  5, 2, 7,  11, 2};
    const double golden = 0.5 * (1 + sqrt(5.0));
    qcSoup soup = Soup_Create(12, 20);
    memcpy(soup.indices, faces, sizeof faces);
    for (int i = 0; i < 12; ++i)
    {
        // Each corner is a cyclic permutation of (+-1, 0, +-golden).
        double* p = soup.positions + 3 * i;
        int longAxis = i < 4 ? 2 : i < 8 ? 1 : 0;
        for (int axis = 0; axis < 3; ++axis)
            p[axis] = corners[i][axis] * (axis == longAxis ? golden : 1);
        PushOntoSphere(p, radius);
    }
    return soup;
}

// The midpoint vertices of edges: a list for the lower vertex of each edge.
typedef struct Midpoints
{
    uint32_t* first;        // by vertex; 0: empty
    uint32_t *next, *other; // by midpoint
} Midpoints;

static uint32_t GetMidpoint(Midpoints* midpoints, qcSoup* fine, uint32_t oldCount, uint32_t a, uint32_t b,
                            double radius)
{
    uint32_t lower = a < b ? a : b;
    uint32_t upper = a < b ? b : a;
    for (uint32_t m = midpoints->first[lower]; m != 0; m = midpoints->next[m - oldCount])
        if (midpoints->other[m - oldCount] == upper)
            return m;
    uint32_t m = fine->vertexCount++;
    midpoints->next[m - oldCount] = midpoints->first[lower];
    midpoints->other[m - oldCount] = upper;
    midpoints->first[lower] = m;
    double* p = fine->positions + 3 * (size_t)m;
    for (size_t axis = 0; axis < 3; ++axis)
        p[axis] = fine->positions[3 * (size_t)a + axis] + fine->positions[3 * (size_t)b + axis];
    PushOntoSphere(p, radius);
    return m;
}

static qcSoup Subdivide(const qcSoup* coarse, double radius)
{
    const uint32_t edgeCount = coarse->triangleCount / 2 * 3;
    const uint32_t oldCount = coarse->vertexCount;
    qcSoup fine = Soup_Create(oldCount + edgeCount, 4 * coarse->triangleCount);
    fine.vertexCount = oldCount;
    memcpy(fine.positions, coarse->positions, 3 * (size_t)oldCount * sizeof(double));
    Midpoints midpoints = {Allocate(oldCount, sizeof(uint32_t)), Allocate(edgeCount, sizeof(uint32_t)),
                           Allocate(edgeCount, sizeof(uint32_t))};
    memset(midpoints.first, 0, oldCount * sizeof(uint32_t));
    for (uint32_t t = 0; t < coarse->triangleCount; ++t)
    {
        const uint32_t* v = coarse->indices + 3 * (size_t)t;
        uint32_t m[3];
        for (int i = 0; i < 3; ++i)
            m[i] = GetMidpoint(&midpoints, &fine, oldCount, v[i], v[(i + 1) % 3], radius);
        const uint32_t four[12] = {v[0], m[0], m[2], m[0], v[1], m[1], m[2], m[1], v[2], m[0], m[1], m[2]};
        memcpy(fine.indices + 12 * (size_t)t, four, sizeof four);
    }
    free(midpoints.first);
    free(midpoints.next);
    free(midpoints.other);
    return fine;
}

qcSoup qcSoup_MakeSphere(uint32_t level, double radius)
{
    qcSoup soup = MakeIcosahedron(radius);
    for (uint32_t i = 0; i < level; ++i)
    {
        qcSoup fine = Subdivide(&soup, radius);
        qcSoup_Free(&soup);
        soup = fine;
    }
    return soup;
}
