// What the kernels of every instruction set call flat doesn't meet itself, by rational arithmetic; and what bends
// little is called flat.
#include "oracle.h"
#include "suite.h"
#include "surfaces.h"

#include <math.h>

//  ---- patches -------------------------------------------------------------------------------------

static void Cross(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double Dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

enum
{
    qc_patchColumns = 24, ///< of squares, along the patch, at most
    qc_patchRows = 2,
    qc_patchVertices = (qc_patchColumns + 1) * (qc_patchRows + 1),
    qc_patchTriangles = 2 * qc_patchColumns * qc_patchRows
};

/// A strip of squares, its corners where they are meant to be and as floats.
typedef struct Patch
{
    double positions[qc_patchVertices][3];
    qcPoint points[qc_patchVertices];
    qcCorners corners[qc_patchTriangles];
    uint32_t columns, triangleCount, loopCount;
    uint32_t places[qc_patchTriangles], loop[2 * (qc_patchColumns + qc_patchRows)];
} Patch;

static uint32_t PatchVertex(uint32_t column, uint32_t row)
{
    return column * (qc_patchRows + 1) + row;
}

static void MakeTopology(Patch* patch)
{
    uint32_t triangle = 0, at = 0;
    for (uint32_t c = 0; c < patch->columns; c++)
        for (uint32_t r = 0; r < qc_patchRows; r++)
        {
            uint32_t corner[4] = {PatchVertex(c, r), PatchVertex(c + 1, r), PatchVertex(c + 1, r + 1),
                                  PatchVertex(c, r + 1)};
            patch->corners[triangle++] = (qcCorners){{corner[0], corner[1], corner[2]}};
            patch->corners[triangle++] = (qcCorners){{corner[0], corner[2], corner[3]}};
        }
    for (uint32_t i = 0; i < triangle; i++)
        patch->places[i] = i;
    for (uint32_t c = 0; c < patch->columns; c++)
        patch->loop[at++] = PatchVertex(c, 0);
    for (uint32_t r = 0; r < qc_patchRows; r++)
        patch->loop[at++] = PatchVertex(patch->columns, r);
    for (uint32_t c = patch->columns; c > 0; c--)
        patch->loop[at++] = PatchVertex(c, qc_patchRows);
    for (uint32_t r = qc_patchRows; r > 0; r--)
        patch->loop[at++] = PatchVertex(0, r);
    patch->triangleCount = triangle;
    patch->loopCount = at;
}

/// Part of a ring, or more than one round of it; `rise` is how far it climbs in a round, `noise` moves each vertex. At
/// one round and no rise the ends lie on each other. Turned so that it faces any way.
static void MakeRing(qcRandom* random, uint32_t columns, double rounds, double rise, double noise, Patch* patch)
{
    double axis[3], other[3], normal[3];
    do
    {
        for (int i = 0; i < 3; i++)
        {
            axis[i] = qcRandom_Uniform(random, -1, 1);
            other[i] = qcRandom_Uniform(random, -1, 1);
        }
        Cross(axis, other, normal);
    } while (Dot(normal, normal) < 0.1);
    Cross(normal, axis, other);
    double lengths[3] = {sqrt(Dot(axis, axis)), sqrt(Dot(other, other)), sqrt(Dot(normal, normal))};
    patch->columns = columns;
    MakeTopology(patch);
    for (uint32_t c = 0; c <= columns; c++)
        for (uint32_t r = 0; r <= qc_patchRows; r++)
        {
            double turn = rounds * c / columns, angle = 6.283185307179586 * (turn == 1.0 ? 0.0 : turn);
            double radius = 0.3 + 0.1 * r / qc_patchRows, height = rise * turn;
            uint32_t v = PatchVertex(c, r);
            for (int i = 0; i < 3; i++)
            {
                patch->positions[v][i] =
                    0.5 + radius * (cos(angle) * axis[i] / lengths[0] + sin(angle) * other[i] / lengths[1]) +
                    height * normal[i] / lengths[2] + qcRandom_Uniform(random, -noise, noise);
                patch->points[v].x[i] = (float)patch->positions[v][i];
            }
            patch->points[v].x[3] = 0.0f;
        }
}

static bool IsFlat(const qcSurfaceKernels* k, const Patch* patch)
{
    qcFlatDisc disc = {.corners = patch->corners,
                       .points = patch->points,
                       .places = patch->places,
                       .loop = patch->loop,
                       .placeCount = patch->triangleCount,
                       .loopCount = patch->loopCount,
                       .pointError = 0x1p-24f};
    return k->isFlat(&disc);
}

/// Do two triangles without a common vertex meet?
static bool MeetsItself(const Patch* patch)
{
    for (uint32_t t = 0; t < patch->triangleCount; t++)
        for (uint32_t u = t + 1; u < patch->triangleCount; u++)
        {
            double a[3][3], b[3][3];
            const uint32_t *p = patch->corners[t].vertex, *q = patch->corners[u].vertex;
            bool share = false, apart = false;
            for (int c = 0; c < 3; c++)
            {
                memcpy(a[c], patch->positions[p[c]], sizeof a[c]);
                memcpy(b[c], patch->positions[q[c]], sizeof b[c]);
                share = share || p[c] == q[0] || p[c] == q[1] || p[c] == q[2];
            }
            for (int i = 0; i < 3; i++)
                apart = apart || fmin(a[0][i], fmin(a[1][i], a[2][i])) > fmax(b[0][i], fmax(b[1][i], b[2][i])) ||
                        fmin(b[0][i], fmin(b[1][i], b[2][i])) > fmax(a[0][i], fmax(a[1][i], a[2][i]));
            if (!share && !apart &&
                qcOracle_Relate((const double(*)[3])a, (const double(*)[3])b) != qc_relationDisjoint)
                return true;
        }
    return false;
}

START_TEST(what_is_flat_does_not_meet_itself)
{
    qcRandom random = {17};
    int meeting = 0, flat = 0, apart = 0;
    for (int i = 0; i < 1200; i++)
    {
        // Ends on each other, a hair apart or overlapping; ramps that face one way everywhere; crumpled ones.
        double near = i % 3 == 0 ? 0.0 : ldexp(qcRandom_Uniform(&random, -1.0, 1.0), -(i / 4 % 28));
        double rounds = i % 2 == 0 ? 1.0 + near : qcRandom_Uniform(&random, 0.3, i % 8 < 4 ? 7.0 : 2.5);
        double rise = i % 4 == 0 || i % 8 == 3 ? 0.0 : i % 4 == 1 ? 0.05 : ldexp(1.0, -(i / 4 % 30));
        double noise = i % 5 == 0 ? ldexp(0.2, -(i / 5 % 30)) : i % 5 == 1 ? 0.03 : 0.0;
        Patch patch;
        MakeRing(&random, i % 3 == 1 ? 3 + (uint32_t)i / 3 % 8 : qc_patchColumns, rounds, rise, noise, &patch);
        bool meets = MeetsItself(&patch);
        meeting += meets;
        apart += !meets;
        FOR_EACH_KERNELS(k)
        {
            bool isFlat = IsFlat(k, &patch);
            CHECK_THAT(!isFlat || !meets, "%s: patch %d of %a rounds, rise %a, noise %a meets itself", k->name, i,
                       rounds, rise, noise);
            flat += kernelIndex == 0 && isFlat;
        }
    }
    ck_assert_int_gt(meeting, 50);
    ck_assert_int_gt(apart, 50);
    ck_assert_int_gt(flat, apart / 8);
}
END_TEST

START_TEST(what_bends_little_is_flat_and_what_folds_is_not)
{
    qcRandom random = {18};
    for (int i = 0; i < 40; i++)
    {
        Patch patch;
        MakeRing(&random, qc_patchColumns, 0.6, 0.05, 0.001, &patch);
        FOR_EACH_KERNELS(k)
        ck_assert(IsFlat(k, &patch));
        // One vertex over the edge across from it; or all in one point.
        uint32_t v = PatchVertex(5 + (uint32_t)i % 10, 0);
        patch.points[v] = patch.points[PatchVertex(3 + (uint32_t)i % 10, 1)];
        FOR_EACH_KERNELS(k)
        ck_assert(!IsFlat(k, &patch));
        for (int k = 0; k < qc_patchVertices; k++)
            patch.points[k] = patch.points[0];
        FOR_EACH_KERNELS(k)
        ck_assert(!IsFlat(k, &patch));
    }
}
END_TEST

QC_RUN_TESTS("surface_flat", what_is_flat_does_not_meet_itself, what_bends_little_is_flat_and_what_folds_is_not)
