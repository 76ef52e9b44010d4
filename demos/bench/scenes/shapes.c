// Triangle soups made by rule for the benchmark: a folded cloth, a spun one, a wrung tube, sheets with dips,
// needles that cross.
// Random numbers: Steele, Lea, Flood: Fast splittable pseudorandom number generators, OOPSLA 2014 (splitmix64).
#include "bench/scenes/shapes.h"

#include <math.h>
#include <stdlib.h>

static const double s_pi = 3.14159265358979323846;

double qcBenchShapes_Random(uint64_t* state, double lower, double upper)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return lower + (upper - lower) * ((double)(z >> 11) * 0x1p-53);
}

static bool Allocate(qcMesh* mesh, uint32_t vertexCount, uint32_t triangleCount)
{
    *mesh = (qcMesh){.vertexCount = vertexCount, .triangleCount = triangleCount};
    mesh->positions = malloc((size_t)vertexCount * 3 * sizeof(float));
    mesh->indices = malloc((size_t)triangleCount * 3 * sizeof(uint32_t));
    if (mesh->positions != NULL && mesh->indices != NULL)
        return true;
    qcMesh_Free(mesh);
    return false;
}

static void PutVertex(qcMesh* mesh, uint32_t vertex, double x, double y, double z)
{
    float* p = (float*)mesh->positions + 3 * (size_t)vertex;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
}

/// A lattice of width * height cells; the diagonals alternate, as a cloth simulation's do. `closed`: a ring, whose rows
/// have `width` vertices, otherwise one more.
static bool AllocateLattice(qcMesh* mesh, uint32_t width, uint32_t height, bool closed)
{
    uint32_t row = closed ? width : width + 1;
    if (!Allocate(mesh, row * (height + 1), 2 * width * height))
        return false;
    uint32_t* t = mesh->indices;
    for (uint32_t j = 0; j < height; ++j)
    {
        for (uint32_t i = 0; i < width; ++i, t += 6)
        {
            uint32_t a = j * row + i, b = j * row + (i + 1) % row, c = a + row, d = b + row;
            uint32_t odd = (i + j) % 2;
            const uint32_t corners[6] = {a, b, odd ? c : d, odd ? d : a, odd ? c : d, odd ? b : c};
            for (int k = 0; k < 6; ++k)
                t[k] = corners[k];
        }
    }
    return true;
}

//  ---- the cloth -----------------------------------------------------------------------------------

typedef struct Fold
{
    int panels;
    double radius; ///< of the half circles that join the panels
    double length; ///< of a panel
} Fold;

/// The point at arc length s and height h of a band that is laid in panels upon each other: forth, round, back, round.
/// Heights count from the first panel and stay below the radius.
static void LayInPanels(const Fold* fold, double s, double h, double out[2])
{
    double period = fold->length + s_pi * fold->radius, middle = 0.5 * fold->length;
    int panel = (int)(s / period);
    panel = panel < fold->panels ? panel : fold->panels - 1;
    double along = s - panel * period, side = panel % 2 == 0 ? 1.0 : -1.0;
    double level = 2.0 * fold->radius * panel;
    if (along <= fold->length || panel == fold->panels - 1)
    {
        out[0] = side * (along - middle);
        out[1] = level + side * h;
        return;
    }
    // The band's upper side is the inner one in the first turn, the outer one in the next.
    double angle = (along - fold->length) / fold->radius, reach = fold->radius - side * h;
    out[0] = side * (middle + reach * sin(angle));
    out[1] = level + fold->radius - reach * cos(angle);
}

enum
{
    qc_waveCount = 24
};

/// A sum of waves over the sheet for each coordinate.
typedef struct Wrinkles
{
    double u[3][qc_waveCount], v[3][qc_waveCount], phase[3][qc_waveCount], height[qc_waveCount];
} Wrinkles;

static Wrinkles MakeWrinkles(uint64_t seed, double height)
{
    Wrinkles wrinkles;
    for (int i = 0; i < qc_waveCount; ++i)
    {
        // From 2 waves over the sheet to 24; short ones are lower, so that all are about as steep.
        double frequency = 2.0 * pow(12.0, (double)i / (qc_waveCount - 1));
        wrinkles.height[i] = height / frequency;
        for (int axis = 0; axis < 3; ++axis)
        {
            double direction = qcBenchShapes_Random(&seed, 0.0, 2.0 * s_pi);
            wrinkles.u[axis][i] = 2.0 * s_pi * frequency * cos(direction);
            wrinkles.v[axis][i] = 2.0 * s_pi * frequency * sin(direction);
            wrinkles.phase[axis][i] = qcBenchShapes_Random(&seed, 0.0, 2.0 * s_pi);
        }
    }
    return wrinkles;
}

static double SumWaves(const Wrinkles* wrinkles, int axis, double u, double v)
{
    double sum = 0.0;
    for (int i = 0; i < qc_waveCount; ++i)
        sum +=
            wrinkles->height[i] * sin(wrinkles->u[axis][i] * u + wrinkles->v[axis][i] * v + wrinkles->phase[axis][i]);
    return sum;
}

/// Rotates by generic angles: no face is parallel to a view or to an axis.
static void Turn(double p[3])
{
    static const double angles[3] = {0.5, 0.3, 0.8};
    for (int axis = 0; axis < 3; ++axis)
    {
        double* a = &p[(axis + 1) % 3];
        double* b = &p[(axis + 2) % 3];
        double c = cos(angles[axis]), s = sin(angles[axis]), x = c * *a - s * *b;
        *b = s * *a + c * *b;
        *a = x;
    }
}

bool qcBenchShapes_MakeCloth(uint32_t side, double wrinkles, qcMesh* mesh)
{
    // A sheet of about 1 by 1. 0.014: 4 panels are 0.084 high, and the second fold goes around that.
    static const Fold first = {4, 0.014, 0.2}, second = {3, 0.058, 0.21};
    double lengths[2] = {4 * first.length + 3 * s_pi * first.radius, 3 * second.length + 2 * s_pi * second.radius};
    Wrinkles waves = MakeWrinkles(2005, 0.0112 * wrinkles);
    if (!AllocateLattice(mesh, side, side, false))
        return false;
    for (uint32_t j = 0; j <= side; ++j)
    {
        for (uint32_t i = 0; i <= side; ++i)
        {
            double u = (double)i / side, v = (double)j / side, inner[2], outer[2];
            LayInPanels(&first, u * lengths[0], 0.0, inner);
            LayInPanels(&second, v * lengths[1], inner[1] - 3.0 * first.radius, outer);
            double p[3] = {inner[0], outer[0], outer[1]};
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += SumWaves(&waves, axis, u, v);
            Turn(p);
            PutVertex(mesh, j * (side + 1) + i, p[0], p[1], p[2]);
        }
    }
    return true;
}

//  ---- the cloth over a spinning ball -------------------------------------------------------------

/// Where the point at distance r and angle a from the middle of the sheet lies: on the ball down to its equator, then
/// on a cylinder below. What the sheet is too wide for its place lies in pleats, which wind around the axis.
static void DrapeAndSpin(double r, double a, double p[3])
{
    const double radius = 0.3, quarter = 0.5 * s_pi * radius;
    double depth = r > quarter ? r - quarter : 0.0, polar = (r < quarter ? r : quarter) / radius;
    double width = radius * sin(polar), excess = r > 0.0 ? 1.0 - width / r : 0.0;
    double spun = a + 5.0 * depth * depth;
    // 14 pleats lean over: above 1 they lie in three layers. Seven larger folds take them along.
    double angle = spun + 6.0 * excess / 14.0 * sin(14.0 * a) + 1.6 * excess / 7.0 * sin(7.0 * a + 1.0);
    double height = width + 0.03 * excess * cos(14.0 * a + 9.0 * r) + 0.02 * excess * cos(7.0 * a);
    p[0] = height * cos(angle);
    p[1] = height * sin(angle);
    p[2] = radius * cos(polar) - 0.8 * depth;
}

bool qcBenchShapes_MakeSpunCloth(uint32_t side, qcMesh* mesh)
{
    Wrinkles waves = MakeWrinkles(92, 0.2);
    if (!AllocateLattice(mesh, side, side, false))
        return false;
    for (uint32_t j = 0; j <= side; ++j)
    {
        for (uint32_t i = 0; i <= side; ++i)
        {
            double u = (double)i / side, v = (double)j / side, x = 2.0 * u - 1.0, y = 2.0 * v - 1.0, p[3];
            DrapeAndSpin(sqrt(x * x + y * y), atan2(y, x), p);
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += SumWaves(&waves, axis, u, v);
            Turn(p);
            PutVertex(mesh, j * (side + 1) + i, p[0], p[1], p[2]);
        }
    }
    return true;
}

//  ---- the wrung tube ------------------------------------------------------------------------------

bool qcBenchShapes_MakeWrungTube(uint32_t side, qcMesh* mesh)
{
    const uint32_t around = side, along = 4 * side;
    Wrinkles waves = MakeWrinkles(80, 0.001);
    if (!AllocateLattice(mesh, around, along, true))
        return false;
    for (uint32_t j = 0; j <= along; ++j)
    {
        for (uint32_t i = 0; i < around; ++i)
        {
            double u = (double)i / around, v = (double)j / along, wrung = s_pi * v - 0.5 * sin(2.0 * s_pi * v);
            // Eight flutes; thinner in the middle, where it is wrung most.
            double radius = (0.06 + 0.05 * sin(16.0 * s_pi * u)) * (1.0 - 0.5 * sin(s_pi * v));
            double angle = 2.0 * s_pi * u + 35.0 * wrung;
            double p[3] = {radius * cos(angle), radius * sin(angle), v - 0.5};
            for (int axis = 0; axis < 3; ++axis)
                p[axis] += SumWaves(&waves, axis, cos(2.0 * s_pi * u) / s_pi, v);
            Turn(p);
            PutVertex(mesh, j * around + i, p[0], p[1], p[2]);
        }
    }
    return true;
}

//  ---- the sheets ----------------------------------------------------------------------------------

enum
{
    qc_sheetSide = 36, // cells; two sheets are 5184 triangles, so that brute force is a matter of milliseconds
    qc_dipCount = 40
};

static double WaveHeight(double x, double y)
{
    return 0.05 * sin(5.0 * x + 2.0 * y) + 0.03 * sin(9.0 * y - 4.0 * x);
}

bool qcBenchShapes_MakeSheets(double gap, qcMesh sheets[2])
{
    sheets[0] = sheets[1] = (qcMesh){0};
    if (!AllocateLattice(&sheets[0], qc_sheetSide, qc_sheetSide, false) ||
        !AllocateLattice(&sheets[1], qc_sheetSide, qc_sheetSide, false))
    {
        qcMesh_Free(&sheets[0]);
        return false;
    }
    uint64_t seed = 36;
    double cell = 1.0 / qc_sheetSide;
    for (uint32_t j = 0; j <= qc_sheetSide; ++j)
    {
        for (uint32_t i = 0; i <= qc_sheetSide; ++i)
        {
            // Vertices one above the other: the triangles are parallel, however close the sheets are.
            uint32_t vertex = j * (qc_sheetSide + 1) + i;
            double x = cell * (i + qcBenchShapes_Random(&seed, -0.2, 0.2));
            double y = cell * (j + qcBenchShapes_Random(&seed, -0.2, 0.2)), z = WaveHeight(x, y);
            PutVertex(&sheets[0], vertex, x, y, z);
            PutVertex(&sheets[1], vertex, x, y, z + gap);
        }
    }
    for (int dip = 0; dip < qc_dipCount; ++dip)
    {
        uint32_t vertex = (uint32_t)qcBenchShapes_Random(&seed, 0.0, sheets[0].vertexCount);
        const float* p = (const float*)sheets[0].positions + 3 * (size_t)vertex;
        // Displaced a little along the sheet, since otherwise edges would cross edges exactly.
        double x = p[0] + cell * qcBenchShapes_Random(&seed, -0.2, 0.2);
        double y = p[1] + cell * qcBenchShapes_Random(&seed, -0.2, 0.2);
        double z = p[2] + WaveHeight(x, y) - WaveHeight(p[0], p[1]);
        PutVertex(&sheets[1], vertex, x, y, z - gap * qcBenchShapes_Random(&seed, 0.1, 1.0));
    }
    return true;
}

//  ---- the needles ---------------------------------------------------------------------------------

static void RandomDirection(uint64_t* seed, double d[3])
{
    // Archimedes: on the sphere each band of equal height has equal area.
    double z = qcBenchShapes_Random(seed, -1.0, 1.0), angle = qcBenchShapes_Random(seed, 0.0, 2.0 * s_pi);
    double r = sqrt(1.0 - z * z);
    d[0] = r * cos(angle);
    d[1] = r * sin(angle);
    d[2] = z;
}

static void AddScaled(double out[3], const double p[3], double scale, const double d[3])
{
    for (int i = 0; i < 3; ++i)
        out[i] = p[i] + scale * d[i];
}

/// A needle from its tip along a direction; its far side is `width` wide.
static void PutSliver(qcMesh* mesh, uint32_t triangle, uint64_t* seed, double corners[3][3], const double along[3],
                      double length, double width)
{
    double across[3], random[3];
    RandomDirection(seed, random);
    for (int i = 0; i < 3; ++i)
        across[i] = along[(i + 1) % 3] * random[(i + 2) % 3] - along[(i + 2) % 3] * random[(i + 1) % 3];
    double size = sqrt(across[0] * across[0] + across[1] * across[1] + across[2] * across[2]) + 1e-9;
    AddScaled(corners[1], corners[0], length, along);
    AddScaled(corners[2], corners[1], width / size, across);
    for (uint32_t i = 0; i < 3; ++i)
    {
        mesh->indices[3 * triangle + i] = 3 * triangle + i;
        PutVertex(mesh, 3 * triangle + i, corners[i][0], corners[i][1], corners[i][2]);
    }
}

bool qcBenchShapes_MakeSlivers(uint32_t count, qcMesh* mesh)
{
    const double length = 0.1;
    if (!Allocate(mesh, 3 * count, count))
        return false;
    uint64_t seed = 7;
    double corners[3][3] = {{0.0}}, along[3];
    for (uint32_t i = 0; i < count; ++i)
    {
        double width = length * pow(10.0, qcBenchShapes_Random(&seed, -3.0, -1.0));
        RandomDirection(&seed, along);
        if (i % 2 == 0)
        {
            for (int k = 0; k < 3; ++k)
                corners[0][k] = qcBenchShapes_Random(&seed, 0.0, 1.0);
        }
        else
        {
            // A point inside the previous needle, and the tip just beyond it.
            double b = qcBenchShapes_Random(&seed, 0.3, 0.6), c = qcBenchShapes_Random(&seed, 0.1, 0.3), p[3];
            for (int k = 0; k < 3; ++k)
                p[k] = (1.0 - b - c) * corners[0][k] + b * corners[1][k] + c * corners[2][k];
            AddScaled(corners[0], p, -length * pow(10.0, qcBenchShapes_Random(&seed, -4.0, -1.0)), along);
        }
        PutSliver(mesh, i, &seed, corners, along, length, width);
    }
    return true;
}

bool qcBenchShapes_MakeCoincident(uint32_t count, qcMesh* mesh)
{
    static const double corners[3][3] = {{0.1, 0.2, 0.3}, {1.1, 0.25, 0.35}, {0.3, 1.2, 0.7}};
    if (!Allocate(mesh, 3 * count, count))
        return false;
    for (uint32_t i = 0; i < 3 * count; ++i)
    {
        mesh->indices[i] = i;
        PutVertex(mesh, i, corners[i % 3][0], corners[i % 3][1], corners[i % 3][2]);
    }
    return true;
}
