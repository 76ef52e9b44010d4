// Shapes that touch in known places, other representations of them, and scenes of their manifolds.
#ifndef QC_TESTS_MANIFOLD_MANIFOLD_SCENES_H
#define QC_TESTS_MANIFOLD_MANIFOLD_SCENES_H

#include "support/scenes.h"

#include <math.h>

//  ---- shapes --------------------------------------------------------------------------------------

static inline qcSoup qcMakeEmptySoup(uint32_t vertexCount, uint32_t triangleCount)
{
    qcSoup soup = {malloc(3 * sizeof(double) * vertexCount), vertexCount, malloc(3 * sizeof(uint32_t) * triangleCount),
                   triangleCount};
    ck_assert(soup.positions != NULL && soup.indices != NULL);
    return soup;
}

static inline void qcScaleSoup(qcSoup* soup, double x, double y, double z)
{
    for (uint32_t v = 0; v < soup->vertexCount; v++)
    {
        soup->positions[3 * v] *= x;
        soup->positions[3 * v + 1] *= y;
        soup->positions[3 * v + 2] *= z;
    }
}

/// A grid of side * side squares over [x, x + width] x [y, y + width], z = 0.
static inline qcSoup qcMakeFloor(uint32_t side, double x, double y, double width)
{
    qcSoup floor = qcSoup_MakeGrid(side);
    qcScaleSoup(&floor, width, width, 1.0);
    qcSoup_Translate(&floor, x, y, 0.0);
    return floor;
}

/// A floor over the unit square, each vertex at a height of its own in [height, height + noise].
static inline qcSoup qcMakeRoughFloor(uint64_t seed, uint32_t side, double height, double noise)
{
    qcRandom random = {seed};
    qcSoup floor = qcMakeFloor(side, 0.0, 0.0, 1.0);
    for (uint32_t v = 0; v < floor.vertexCount; v++)
        floor.positions[3 * v + 2] = height + qcRandom_Uniform(&random, 0.0, noise);
    return floor;
}

/// The unit cube. Each face is a grid of its own, so vertices at its edges coincide in position only.
static inline qcSoup qcMakeBox(uint32_t side)
{
    qcSoup grid = qcSoup_MakeGrid(side);
    qcSoup box = qcMakeEmptySoup(6 * grid.vertexCount, 6 * grid.triangleCount);
    for (uint32_t face = 0; face < 6; face++)
    {
        uint32_t axis = face / 2;
        double* p = box.positions + 3 * (size_t)(face * grid.vertexCount);
        for (uint32_t v = 0; v < grid.vertexCount; v++, p += 3)
        {
            p[axis] = face % 2;
            p[(axis + 1) % 3] = grid.positions[3 * v];
            p[(axis + 2) % 3] = grid.positions[3 * v + 1];
        }
        for (uint32_t i = 0; i < 3 * grid.triangleCount; i++)
            box.indices[3 * (size_t)(face * grid.triangleCount) + i] = grid.indices[i] + face * grid.vertexCount;
    }
    qcSoup_Free(&grid);
    return box;
}

/// Around the z axis: `around` * `tube` vertices at the distance `radius` from the circle of radius 1.
static inline qcSoup qcMakeTorus(uint32_t around, uint32_t tube, double radius)
{
    const double turn = 2.0 * 3.14159265358979323846;
    qcSoup torus = qcMakeEmptySoup(around * tube, 2 * around * tube);
    uint32_t* index = torus.indices;
    for (uint32_t i = 0; i < around; i++)
        for (uint32_t j = 0; j < tube; j++)
        {
            double u = turn * i / around, v = turn * j / tube, *p = torus.positions + 3 * (size_t)(i * tube + j);
            p[0] = (1.0 + radius * cos(v)) * cos(u);
            p[1] = (1.0 + radius * cos(v)) * sin(u);
            p[2] = radius * sin(v);
            uint32_t next = (i + 1) % around, a = i * tube + j, b = next * tube + j;
            uint32_t c = next * tube + (j + 1) % tube, d = i * tube + (j + 1) % tube;
            const uint32_t square[6] = {a, b, c, a, c, d};
            memcpy(index, square, sizeof square);
            index += 6;
        }
    return torus;
}

/// Rotates about (1, 2, 2), with cosine 0.8: a symmetry of none of the shapes.
static inline void qcTurn(double p[3])
{
    const double c = 0.8, s = 0.6, k[3] = {1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0};
    double dot = k[0] * p[0] + k[1] * p[1] + k[2] * p[2], q[3];
    for (int i = 0; i < 3; i++)
        q[i] =
            c * p[i] + s * (k[(i + 1) % 3] * p[(i + 2) % 3] - k[(i + 2) % 3] * p[(i + 1) % 3]) + (1 - c) * dot * k[i];
    memcpy(p, q, sizeof q);
}

static inline void qcTurnSoup(qcSoup* soup)
{
    for (uint32_t v = 0; v < soup->vertexCount; v++)
        qcTurn(soup->positions + 3 * (size_t)v);
}

//  ---- other representations of a shape ------------------------------------------------------------

/// Turns about half of the triangles inside out.
static inline void qcFlipSome(qcSoup* soup, uint64_t seed)
{
    qcRandom random = {seed};
    for (uint32_t t = 0; t < soup->triangleCount; t++)
    {
        uint32_t* corner = soup->indices + 3 * (size_t)t;
        uint32_t second = corner[1];
        if (qcRandom_Below(&random, 2) == 0)
            continue;
        corner[1] = corner[2];
        corner[2] = second;
    }
}

/// Puts the triangles into another order.
static inline void qcShuffle(qcSoup* soup, uint64_t seed)
{
    qcRandom random = {seed};
    for (uint32_t t = soup->triangleCount; t > 1; t--)
    {
        uint32_t swap[3], other = qcRandom_Below(&random, t);
        memcpy(swap, soup->indices + 3 * (size_t)other, sizeof swap);
        memcpy(soup->indices + 3 * (size_t)other, soup->indices + 3 * (size_t)(t - 1), sizeof swap);
        memcpy(soup->indices + 3 * (size_t)(t - 1), swap, sizeof swap);
    }
}

/// Gives every triangle three vertices of its own.
static inline void qcUnshare(qcSoup* soup)
{
    qcSoup own = qcMakeEmptySoup(3 * soup->triangleCount, soup->triangleCount);
    for (uint32_t i = 0; i < 3 * soup->triangleCount; i++)
    {
        memcpy(own.positions + 3 * (size_t)i, soup->positions + 3 * (size_t)soup->indices[i], 3 * sizeof(double));
        own.indices[i] = i;
    }
    qcSoup_Free(soup);
    *soup = own;
}

//  ---- results -------------------------------------------------------------------------------------

typedef struct qcManifoldScene
{
    qcScene* scene;
    const qcSoup* soups[2]; ///< by slot; the second may be null
    double margin;
    const qcResult* result;
} qcManifoldScene;

typedef enum qcBodyKind
{
    qc_bodyRigid,
    qc_bodyDeforming,
    qc_bodyWithItself ///< deforming, and tested with itself
} qcBodyKind;

/// Adds the bodies in this order and detects by `sweep`, touching pairs too.
static inline qcManifoldScene qcFindManifolds(const qcSoup* first, const qcSoup* second, qcBodyKind kind, double margin,
                                              uint32_t threads)
{
    qcManifoldScene m = {qcMakeScene(NULL), {first, second}, margin, NULL};
    for (int i = 0; i < 2 && m.soups[i] != NULL; i++)
    {
        qcBodyDef def = qcBodyDefOf(m.soups[i]);
        qcBodyId id;
        def.deforming = kind != qc_bodyRigid;
        def.selfCollision = kind == qc_bodyWithItself;
        CHECK_OK(qcScene_AddBody(m.scene, &def, &id));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = margin;
    def.touching = def.manifolds = def.proximities = true;
    def.threads = threads;
    CHECK_OK(qcScene_Detect(m.scene, &def, &m.result));
    return m;
}

static inline void qcManifoldScene_Free(qcManifoldScene* m)
{
    qcScene_Destroy(m->scene);
}

static inline double qcDot3(const double* a, const double* b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double qcDistance3(const double* a, const double* b)
{
    double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    return sqrt(qcDot3(d, d));
}

/// The number of points with side A within `tolerance` of a place.
static inline size_t qcCountPointsAt(const qcResult* result, const double place[3], double tolerance)
{
    size_t count = 0;
    for (size_t i = 0; i < result->manifoldPointCount; i++)
        count += qcDistance3(result->manifoldPoints[i].pointA, place) <= tolerance;
    return count;
}

#endif
