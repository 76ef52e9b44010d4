// Pairs of surfaces against rational arithmetic, each triangle with each: none within the margin is missing, and none
// comes twice.
#include "surface_pairs.h"

#include "failing_heap.h"
#include "oracle.h"
#include "pairs.h"
#include "suite.h"
#include "surfaces.h"

#include <math.h>
#include <stdio.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

//  ---- two surfaces --------------------------------------------------------------------------------

enum
{
    qc_mostThreads = 3
};

/// A soup, its body and the surface of that.
typedef struct Side
{
    qcSoup soup;
    qcBodies bodies;
    qcSurface surface;
} Side;

static Side MakeSide(qcSoup soup)
{
    Side side = {.soup = soup};
    CHECK_OK(qcSurface_Build(&side.surface, qcBodyAt(&side.bodies, qcAddToBodies(&side.bodies, &soup))));
    return side;
}

static void FreeSide(Side* side)
{
    qcSurface_Free(&side->surface);
    qcBodies_Free(&side->bodies);
    qcSoup_Free(&side->soup);
}

static void FitSide(Side* side, double margin, const qcSurfaceKernels* kernels, uint32_t threads)
{
    qcSurfaceScratch scratch = {0};
    bool fits;
    CHECK_OK(qcSurface_Fit(&side->surface, qcBodyAt(&side->bodies, 0), margin, kernels, threads, &scratch, &fits));
    ck_assert(fits);
    qcSurfaceScratch_Free(&scratch);
}

/// How often each two triangles were found: a byte for each, one more row for each triangle of the first.
typedef struct Found
{
    const Side *a, *b;
    uint8_t* times[qc_mostThreads]; ///< of each worker
    size_t calls, count;
    const uint8_t *reachedA, *reachedB;
} Found;

static bool Take(void* context, const qcPlacePair* pairs, size_t count, size_t sureCount, uint32_t worker)
{
    Found* found = context;
    CHECK_THAT(worker < qc_mostThreads && count != 0 && sureCount <= count, "worker %u, %zu pairs", worker, count);
    for (size_t i = 0; i < count; i++)
    {
        uint32_t t = QC_AT(uint32_t, found->a->surface.clusters.triangles, pairs[i].a),
                 u = QC_AT(uint32_t, found->b->surface.clusters.triangles, pairs[i].b);
        CHECK_THAT(t < found->a->soup.triangleCount && u < found->b->soup.triangleCount, "no such triangle");
        if (found->a == found->b && u < t)
        {
            uint32_t swapped = t;
            t = u;
            u = swapped;
        }
        uint8_t* times = &found->times[worker][(size_t)t * found->b->soup.triangleCount + u];
        *times = (uint8_t)(*times + (*times < 255));
    }
    return true;
}

static bool AreBoxesWithin(const double a[3][3], const double b[3][3], double margin)
{
    for (int axis = 0; axis < 3; axis++)
    {
        double lowA = fmin(a[0][axis], fmin(a[1][axis], a[2][axis])),
               highA = fmax(a[0][axis], fmax(a[1][axis], a[2][axis]));
        double lowB = fmin(b[0][axis], fmin(b[1][axis], b[2][axis])),
               highB = fmax(b[0][axis], fmax(b[1][axis], b[2][axis]));
        // Monotone: what this parts is apart.
        if (lowA > highB + margin || lowB > highA + margin)
            return false;
    }
    return true;
}

/// What rational arithmetic says of each two triangles, once it was asked.
typedef struct Oracle
{
    const Side *a, *b;
    double margin;
    uint8_t* within; ///< 0: not asked yet, 1: they are apart, 2: they are within the margin
    size_t boxes;    ///< of pairs that were asked about, those whose boxes are within the margin
} Oracle;

static Oracle MakeOracle(const Side* a, const Side* b, double margin)
{
    Oracle oracle = {a, b, margin, calloc((size_t)a->soup.triangleCount * b->soup.triangleCount, 1), 0};
    ck_assert_ptr_nonnull(oracle.within);
    return oracle;
}

static bool AreTrianglesWithin(Oracle* oracle, uint32_t t, uint32_t u)
{
    uint8_t* within = &oracle->within[(size_t)t * oracle->b->soup.triangleCount + u];
    if (*within != 0)
        return *within == 2;
    double p[3][3], q[3][3];
    qcSoup_GetTriangle(&oracle->a->soup, t, p);
    qcSoup_GetTriangle(&oracle->b->soup, u, q);
    *within = 1;
    if (!AreBoxesWithin((const double(*)[3])p, (const double(*)[3])q, oracle->margin))
        return false;
    oracle->boxes++;
    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])p, (const double(*)[3])q);
    *within = qcOracleDistance_Compare(distance, oracle->margin) <= 0 ? 2 : 1;
    qcOracleDistance_Destroy(distance);
    return *within == 2;
}

static void CheckReached(const Side* side, const uint8_t* reached, uint32_t triangle)
{
    const qcArray* places = &side->surface.clusters.triangles;
    for (size_t i = 0; i < places->count; i++)
        if (QC_AT(uint32_t, *places, i) == triangle)
            CHECK_THAT(reached[i / qc_nodeSize] == 1, "node %zu was not reached", i / qc_nodeSize);
}

/// Compares what the workers found; adds up what they did.
static void CheckFound(Found* found, Oracle* oracle, bool neighbours, const char* what)
{
    size_t n = found->a->soup.triangleCount, m = found->b->soup.triangleCount;
    for (uint32_t t = 0; t < n; t++)
        for (uint32_t u = 0; u < m; u++)
        {
            size_t at = t * m + u;
            int times = found->times[0][at] + found->times[1][at] + found->times[2][at];
            bool self = found->a == found->b, left = self && !neighbours && qcSoup_AreNeighbours(&found->a->soup, t, u);
            CHECK_THAT(times <= 1, "%s: %u and %u are found %d times", what, t, u, times);
            CHECK_THAT(times == 0 || (!left && (!self || t < u)), "%s: %u and %u are found", what, t, u);
            // Only what is missing is asked about.
            CHECK_THAT(times == 1 || left || (self && t >= u) || !AreTrianglesWithin(oracle, t, u),
                       "%s: %u and %u are not found", what, t, u);
            found->count += (size_t)times;
            if (times != 0 && at % 509 == 0)
            {
                CheckReached(found->a, found->reachedA, t);
                CheckReached(found->b, found->reachedB, u);
            }
        }
}

/// Finds the pairs with all kernels, on one thread and on three, without and with flat discs. Returns how many there
/// were, with the last.
static size_t CheckPairs(Side* a, Side* b, double margin, bool neighbours, Oracle* oracle, const char* what)
{
    size_t cells = (size_t)a->soup.triangleCount * b->soup.triangleCount, count = 0;
    bool flat = a == b && margin == 0.0 && !neighbours;
    FOR_EACH_KERNELS(k)
    for (int run = 0; run < (flat ? 4 : 2); run++)
    {
        uint32_t threads = run % 2 == 0 ? 1 : qc_mostThreads;
        FitSide(a, margin, k, threads);
        FitSide(b, margin, k, threads);
        Found found = {.a = a, .b = b};
        uint8_t* reached[2] = {calloc(a->surface.clusters.nodeCount, 1), calloc(b->surface.clusters.nodeCount, 1)};
        found.reachedA = reached[0];
        found.reachedB = a == b ? reached[0] : reached[1];
        for (int w = 0; w < qc_mostThreads; w++)
            ck_assert_ptr_nonnull(found.times[w] = calloc(cells, 1));
        qcSurfacePairs pairs = {0};
        qcSurfacePairsJob job = {.kernels = k,
                                 .a = &a->surface,
                                 .b = &b->surface,
                                 .bodyA = qcBodyAt(&a->bodies, 0),
                                 .bodyB = qcBodyAt(&b->bodies, 0),
                                 .margin = margin,
                                 .neighbours = neighbours,
                                 .flatDiscs = run > 1,
                                 .threads = threads,
                                 .reachedA = reached[0],
                                 .reachedB = a == b ? reached[0] : reached[1],
                                 .function = Take,
                                 .context = &found};
        if (job.flatDiscs)
            qcSurface_FindFlat(&a->surface, k, threads);
        CHECK_OK(qcSurfacePairs_Find(&pairs, &job));
        CheckFound(&found, oracle, neighbours, what);
        CHECK_THAT(run % 2 == 0 || count == found.count, "%s: %zu pairs on one thread, %zu on three", what, count,
                   found.count);
        count = found.count;
        qcSurfacePairs_Free(&pairs);
        for (int w = 0; w < qc_mostThreads; w++)
            free(found.times[w]);
        free(reached[0]);
        free(reached[1]);
        a->surface.fitted = b->surface.fitted = false; // for the next kernels
    }
    return count;
}

/// Returns how many pairs are found.
static size_t CheckBetween(qcSoup soupA, qcSoup soupB, double margin, const char* what)
{
    Side a = MakeSide(soupA), b = MakeSide(soupB);
    Oracle oracle = MakeOracle(&a, &b, margin);
    size_t count = CheckPairs(&a, &b, margin, false, &oracle, what);
    free(oracle.within);
    FreeSide(&a);
    FreeSide(&b);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    return count;
}

static void CheckWithin(qcSoup soup, double margin, const char* what)
{
    Side a = MakeSide(soup);
    Oracle oracle = MakeOracle(&a, &a, margin);
    for (int neighbours = 0; neighbours <= 1; neighbours++)
        CheckPairs(&a, &a, margin, neighbours != 0, &oracle, what);
    free(oracle.within);
    FreeSide(&a);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static const char* const s_kindNames[] = {"one",  "node and one", "random", "degenerate", "sphere", "cloth",
                                          "flat", "line",         "point",  "fan",        "twins"};

//  ---- tests: one surface --------------------------------------------------------------------------

/// Of the sort that has few pairs within, so that the oracle is asked about few.
static qcSoup MakeSmaller(qcSoupKind kind, uint64_t seed)
{
    qcSoup soup = qcMakeSoup(kind, seed);
    soup.triangleCount = kind == qc_soupFan && soup.triangleCount > 130 ? 130 : soup.triangleCount;
    return soup;
}

START_TEST(a_surface_has_each_pair_within_the_margin_once)
{
    const double margins[] = {0.0, 0.01};
    for (int kind = 0; kind < qc_soupKindCount; kind++)
        for (size_t i = 0; i < LENGTH(margins); i++)
            CheckWithin(MakeSmaller((qcSoupKind)kind, 3), margins[i], s_kindNames[kind]);
}
END_TEST

START_TEST(a_surface_far_away_or_of_any_scale_has_each_pair_within_the_margin_once)
{
    const double scales[] = {1e-300, 1e-6, 1e6, 1e280}, offsets[] = {1e6, 1e12, 1e15};
    for (int kind = qc_soupDegenerate; kind < qc_soupKindCount; kind += 2)
    {
        for (size_t i = 0; i < LENGTH(scales); i++)
        {
            qcSoup soup = MakeSmaller((qcSoupKind)kind, 4);
            qcSoup_Place(&soup, scales[i], 0.0, 0.0, 0.0);
            CheckWithin(soup, i % 2 == 0 ? 0.0 : 0.01 * scales[i], s_kindNames[kind]);
        }
        for (size_t i = 0; i < LENGTH(offsets); i++)
        {
            qcSoup soup = MakeSmaller((qcSoupKind)kind, 5);
            qcSoup_Place(&soup, 1.0, offsets[i], 0.0, -offsets[i]);
            CheckWithin(soup, 0.0, s_kindNames[kind]);
        }
    }
}
END_TEST

START_TEST(few_pairs_that_are_apart_are_found)
{
    Side a = MakeSide(qcSoup_MakeRandom(6, 400, 0.2)), b = MakeSide(qcSoup_MakeRandom(7, 400, 0.2));
    Side* sides[] = {&a, &b};
    for (int i = 0; i < 2; i++)
    {
        Oracle oracle = MakeOracle(&a, sides[i], 0.0);
        size_t count = CheckPairs(&a, sides[i], 0.0, true, &oracle, "random"), within = 0;
        for (uint32_t t = 0; t < a.soup.triangleCount; t++)
            for (uint32_t u = i == 0 ? t + 1 : 0; u < b.soup.triangleCount; u++)
                within += AreTrianglesWithin(&oracle, t, u);
        ck_assert_uint_gt(within, 200);
        ck_assert_uint_gt(oracle.boxes, 2 * within);
        ck_assert_uint_lt(count, within + within / 20);
        free(oracle.within);
    }
    FreeSide(&a);
    FreeSide(&b);
}
END_TEST

/// A strip that goes round twice and is closed: where its two turns cross, it faces one way as everywhere.
static qcSoup MakeCoil(uint32_t columns, uint32_t rows, double height)
{
    qcSoup soup = qcSoup_MakeRandom(1, 2 * columns * rows, 0.1);
    soup.vertexCount = columns * (rows + 1);
    for (uint32_t c = 0; c < columns; c++)
        for (uint32_t r = 0; r <= rows; r++)
        {
            double angle = 12.566370614359172 * c / columns, radius = 0.6 + 0.3 * r / rows;
            double* x = soup.positions + 3 * (size_t)(c * (rows + 1) + r);
            x[0] = radius * cos(angle);
            x[1] = radius * sin(angle);
            x[2] = height * sin(angle / 2.0);
            if (r == rows)
                continue;
            uint32_t low = c * (rows + 1) + r, next = (c + 1) % columns * (rows + 1) + r;
            const uint32_t corners[6] = {low, next, next + 1, low, next + 1, low + 1};
            memcpy(soup.indices + 6 * (size_t)(c * rows + r), corners, sizeof corners);
        }
    return soup;
}

START_TEST(a_surface_that_faces_one_way_has_the_pairs_where_it_crosses_itself)
{
    for (uint32_t columns = 16; columns <= 100; columns += 14)
        for (uint32_t rows = 1; rows <= 4; rows++)
            CheckWithin(MakeCoil(columns, rows, rows % 2 == 0 ? 0.2 : 1e-4), 0.0, "coil");
}
END_TEST

START_TEST(flat_discs_of_a_sheet_leave_nothing_to_ask)
{
    // Waves that don't come back: all that is found is known to be apart.
    Side a = MakeSide(qcSoup_MakeGrid(40));
    for (uint32_t v = 0; v < a.soup.vertexCount; v++)
        a.soup.positions[3 * v + 2] = 0.05 * sin(12.0 * a.soup.positions[3 * v] + 5.0 * a.soup.positions[3 * v + 1]);
    CHECK_OK(qcBodies_SetVertices(&a.bodies, 0, a.soup.positions, qc_positionF64, 0));
    FOR_EACH_KERNELS(k)
    {
        a.surface.fitted = false;
        FitSide(&a, 0.0, k, 1);
        qcSurface_FindFlat(&a.surface, k, 1);
        uint32_t flat = 0, nodes = a.surface.discs.nodeCount;
        for (uint32_t node = 0; node < nodes; node++)
            flat += qcSurface_IsFlat(&a.surface, qcDiscs_Large(&a.surface.discs, node)) ||
                    qcSurface_IsFlat(&a.surface, node);
        CHECK_THAT(flat > nodes * 9 / 10, "%s: %u of %u nodes are flat", k->name, flat, nodes);
    }
    FreeSide(&a);
}
END_TEST

//  ---- tests: two surfaces -------------------------------------------------------------------------

START_TEST(two_surfaces_have_each_pair_within_the_margin_once)
{
    size_t within = 0;
    for (int i = 0; i < qc_soupKindCount; i++)
        for (int j = i % 3; j < qc_soupKindCount; j += 3)
        {
            char what[64];
            snprintf(what, sizeof what, "%s and %s", s_kindNames[i], s_kindNames[j]);
            within += CheckBetween(MakeSmaller((qcSoupKind)i, 8), MakeSmaller((qcSoupKind)j, 9),
                                   (i + j) % 3 == 0 ? 0.01 : 0.0, what);
        }
    ck_assert_uint_gt(within, 5000);
}
END_TEST

static bool TakeNoMore(void* context, const qcPlacePair* pairs, size_t count, size_t sureCount, uint32_t worker)
{
    (void)pairs;
    (void)count;
    (void)sureCount;
    (void)worker;
    __atomic_fetch_add((size_t*)context, 1, __ATOMIC_RELAXED);
    return false;
}

/// More levels than any other body here has.
static qcSoup MakeLargeFan(void)
{
    qcSoup fan = qcSoup_MakeRandom(20, 5000, 0.5);
    for (uint32_t t = 0; t < fan.triangleCount; t++)
        fan.indices[3 * t] = 0;
    return fan;
}

START_TEST(a_large_fan_has_its_pairs_with_others_and_none_with_itself)
{
    ck_assert_uint_gt(CheckBetween(MakeLargeFan(), qcSoup_MakeRandom(21, 2, 0.5), 0.0, "fan and two"), 100);
    ck_assert_uint_gt(CheckBetween(qcSoup_MakeRandom(21, 2, 0.5), MakeLargeFan(), 0.0, "two and fan"), 100);

    Side a = MakeSide(MakeLargeFan());
    FitSide(&a, 0.0, qcSurfaceKernels_Get(), 1);
    size_t calls = 0;
    qcSurfacePairs pairs = {0};
    qcSurfacePairsJob job = {.kernels = qcSurfaceKernels_Get(),
                             .a = &a.surface,
                             .b = &a.surface,
                             .bodyA = qcBodyAt(&a.bodies, 0),
                             .bodyB = qcBodyAt(&a.bodies, 0),
                             .threads = 1,
                             .function = TakeNoMore,
                             .context = &calls};
    CHECK_OK(qcSurfacePairs_Find(&pairs, &job));
    ck_assert_uint_eq(calls, 0);
    qcSurfacePairs_Free(&pairs);
    FreeSide(&a);
}
END_TEST

/// So that one vertex comes to lie at `x`, all others scaled around it.
static qcSoup MakeAround(qcSoupKind kind, double scale, double x)
{
    qcSoup soup = qcMakeSoup(kind, 10);
    double centre[3];
    memcpy(centre, soup.positions + 3 * (size_t)soup.indices[soup.triangleCount / 2 * 3], sizeof centre);
    qcSoup_Translate(&soup, -centre[0], -centre[1], -centre[2]);
    qcSoup_Place(&soup, scale, x, x, x);
    return soup;
}

START_TEST(surfaces_of_any_two_scales_have_each_pair_within_the_margin_once)
{
    const double scales[] = {1.0, 1e-3, 1e-6, 1e-12, 1e-30, 1e-34, 5e-35, 2e-36, 1e-38, 1e-60, 1e-300, 1e3, 1e280};
    for (size_t i = 0; i < LENGTH(scales); i++)
        for (int kind = qc_soupNodeAndOne + (int)i % 2; kind <= qc_soupLine; kind += 3)
        {
            double least = fmin(scales[i], 1.0);
            size_t within =
                CheckBetween(MakeAround((qcSoupKind)kind, 1.0, 0.0), MakeAround(qc_soupSphere, scales[i], 0.0),
                             i % 2 == 0 ? 0.0 : 0.01 * least, s_kindNames[kind]);
            within += CheckBetween(MakeAround(qc_soupSphere, scales[i], 0.0), MakeAround((qcSoupKind)kind, 1.0, 0.0),
                                   0.0, s_kindNames[kind]);
            ck_assert_uint_gt(within, 0);
        }
}
END_TEST

START_TEST(a_small_surface_meets_any_part_of_one_that_floats_cannot_compare_it_with)
{
    // The large one's boxes lie anywhere around its middle, where numbers of its lattice are zero.
    qcRandom random = {11};
    for (int round = 0; round < 60; round++)
    {
        double scale = pow(10.0, qcRandom_Uniform(&random, -39.0, -32.0));
        qcSoup large = qcSoup_MakeRandom((uint64_t)round, 40, 0.3), small = qcSoup_MakeRandom(1, 5, 0.5);
        uint32_t t = qcRandom_Below(&random, large.triangleCount);
        // A point well inside one triangle comes to lie in the middle of the small one.
        double corners[3][3];
        qcSoup_GetTriangle(&large, t, corners);
        for (int axis = 0; axis < 3; axis++)
        {
            double centre = (corners[0][axis] + corners[1][axis] + corners[2][axis]) / 3.0;
            for (uint32_t v = 0; v < large.vertexCount; v++)
                large.positions[3 * v + (uint32_t)axis] -= centre;
        }
        qcSoup_Translate(&small, -0.5, -0.5, -0.5);
        qcSoup_Place(&small, scale, 0.0, 0.0, 0.0);
        if (round % 2 == 0)
            CheckBetween(small, large, 0.0, "small and large");
        else
            CheckBetween(large, small, 0.0, "large and small");
    }
}
END_TEST

START_TEST(surfaces_far_from_the_origin_have_each_pair_within_the_margin_once)
{
    const double offsets[] = {1e3, -1e9, 1e12, 1e15};
    for (size_t i = 0; i < LENGTH(offsets); i++)
        for (int kind = 0; kind < qc_soupKindCount; kind++)
        {
            qcSoup a = MakeSmaller((qcSoupKind)kind, 12), b = MakeSmaller(qc_soupSphere, 13);
            qcSoup_Place(&a, 1.0, offsets[i], -offsets[i], 0.0);
            qcSoup_Place(&b, 1.0, offsets[i] + 0.25, -offsets[i], 0.0);
            CheckBetween(a, b, i % 2 == 0 ? 0.0 : 0.01, s_kindNames[kind]);
        }
}
END_TEST

/// A pair on the border of the margin, no larger than `size`; returns what to scale it by.
static double MakeBorderPair(qcRandom* random, uint32_t i, double size, double margin, qcTrianglePair* pair)
{
    for (;;)
    {
        double distance = 0.0, largest;
        if (margin == 0.0)
            qcTrianglePair_Make(random, (qcPairKind)(qc_pairCoarseGrid + i % (qc_pairKindCount - qc_pairCoarseGrid)),
                                pair);
        else
            qcTrianglePair_MakeApart(random, 1 + (int)i % 3, 1 + (int)(i / 3) % 3, pair, &distance);
        largest = qcTrianglePair_GetLargest(pair);
        double scale = margin == 0.0 ? size / largest : margin / distance;
        if (largest > 1e-3 && largest < 1e3 && largest * scale <= size)
            return scale;
    }
}

/// Both sides of many small pairs, each in a cell of its own; the second has a triangle far off.
static void MakeCells(qcRandom* random, double size, double margin, qcSoup* a, qcSoup* b)
{
    enum
    {
        side = 6,
        cells = side * side * side
    };
    *a = qcSoup_MakeRandom(1, cells, 0.1);
    *b = qcSoup_MakeRandom(1, cells + 1, 0.1);
    for (uint32_t i = 0; i < cells; i++)
    {
        qcTrianglePair pair;
        double scale = MakeBorderPair(random, i, size, margin, &pair);
        const double centre[3] = {i % side, i / side % side, i / side / side};
        for (uint32_t c = 0; c < 3; c++)
            for (uint32_t axis = 0; axis < 3; axis++)
            {
                a->positions[9 * (size_t)i + 3 * c + axis] = pair.a[c][axis] * scale + centre[axis];
                b->positions[9 * (size_t)i + 3 * c + axis] = pair.b[c][axis] * scale + centre[axis];
            }
    }
    for (size_t k = 0; k < 9; k++)
        b->positions[9 * (size_t)cells + k] = qcRandom_Uniform(random, -200.0, -100.0);
}

START_TEST(pairs_on_the_border_are_found_between_two_frames)
{
    qcRandom random = {14};
    size_t within = 0;
    for (int round = 0; round < 40; round++)
    {
        qcSoup a, b;
        double size = ldexp(0.4, -(round % 16)), margin = round % 3 == 0 ? 0.0 : size / 64;
        MakeCells(&random, size, margin, &a, &b);
        within += round % 2 == 0 ? CheckBetween(a, b, margin, "cells") : CheckBetween(b, a, margin, "cells");
    }
    ck_assert_uint_gt(within, 2000);
}
END_TEST

START_TEST(nodes_that_lie_apart_are_not_reached)
{
    Side a = MakeSide(qcSoup_MakeSphere(3, 1.0)), b = MakeSide(qcSoup_MakeSphere(3, 1.0));
    qcSoup_Translate(&b.soup, 1.9, 0.0, 0.0);
    for (int step = 0; step < 2; step++)
    {
        qcSoup_Translate(&b.soup, 0.2 * step, 0.0, 0.0);
        CHECK_OK(qcBodies_SetVertices(&b.bodies, 0, b.soup.positions, qc_positionF64, 0));
        Oracle oracle = MakeOracle(&a, &b, 0.0);
        FitSide(&a, 0.0, qcSurfaceKernels_Get(), 1);
        FitSide(&b, 0.0, qcSurfaceKernels_Get(), 1);
        uint32_t nodes = a.surface.clusters.nodeCount, reachedNodes = 0;
        uint8_t reached[2][512] = {{0}};
        ck_assert_uint_le(nodes, 512);
        Found found = {.a = &a, .b = &b, .reachedA = reached[0], .reachedB = reached[1]};
        for (int w = 0; w < qc_mostThreads; w++)
            found.times[w] = calloc((size_t)a.soup.triangleCount * b.soup.triangleCount, 1);
        qcSurfacePairs pairs = {0};
        qcSurfacePairsJob job = {.kernels = qcSurfaceKernels_Get(),
                                 .a = &a.surface,
                                 .b = &b.surface,
                                 .bodyA = qcBodyAt(&a.bodies, 0),
                                 .bodyB = qcBodyAt(&b.bodies, 0),
                                 .threads = 1,
                                 .reachedA = reached[0],
                                 .reachedB = reached[1],
                                 .function = Take,
                                 .context = &found};
        CHECK_OK(qcSurfacePairs_Find(&pairs, &job));
        CheckFound(&found, &oracle, false, "spheres");
        for (uint32_t i = 0; i < nodes; i++)
            reachedNodes += reached[0][i];
        ck_assert_int_eq(found.count > 0, step == 0);
        ck_assert_int_eq(reachedNodes > 0, step == 0);
        ck_assert_uint_lt(reachedNodes, nodes / 4);
        for (int w = 0; w < qc_mostThreads; w++)
            free(found.times[w]);
        free(oracle.within);
        qcSurfacePairs_Free(&pairs);
    }
    FreeSide(&a);
    FreeSide(&b);
}
END_TEST

START_TEST(who_wants_no_more_gets_no_more)
{
    Side a = MakeSide(qcSoup_MakeRandom(2, 1500, 0.3));
    FitSide(&a, 0.0, qcSurfaceKernels_Get(), 1);
    size_t calls = 0;
    qcSurfacePairs pairs = {0};
    qcSurfacePairsJob job = {.kernels = qcSurfaceKernels_Get(),
                             .a = &a.surface,
                             .b = &a.surface,
                             .bodyA = qcBodyAt(&a.bodies, 0),
                             .bodyB = qcBodyAt(&a.bodies, 0),
                             .threads = 1,
                             .function = TakeNoMore,
                             .context = &calls};
    CHECK_OK(qcSurfacePairs_Find(&pairs, &job));
    ck_assert_uint_eq(calls, 1);
    qcSurfacePairs_Free(&pairs);
    FreeSide(&a);
}
END_TEST

START_TEST(a_failed_allocation_finds_nothing_and_leaves_nothing)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    Side a = MakeSide(qcSoup_MakeRandom(2, 1500, 0.05));
    FitSide(&a, 0.0, qcSurfaceKernels_Get(), 1);
    size_t live = heap.live, calls = 1, taken;
    for (size_t i = 0; i <= calls; i++)
    {
        heap = (qcFailingHeap){live, 0, i};
        taken = 0;
        qcSurfacePairs pairs = {0};
        qcSurfacePairsJob job = {.kernels = qcSurfaceKernels_Get(),
                                 .a = &a.surface,
                                 .b = &a.surface,
                                 .bodyA = qcBodyAt(&a.bodies, 0),
                                 .bodyB = qcBodyAt(&a.bodies, 0),
                                 .threads = 2,
                                 .function = TakeNoMore,
                                 .context = &taken};
        ck_assert_int_eq(qcSurfacePairs_Find(&pairs, &job), i == 0 ? qc_statusOk : qc_statusOutOfMemory);
        ck_assert_int_eq(taken > 0, i == 0);
        calls = i == 0 ? heap.calls : calls;
        qcSurfacePairs_Free(&pairs);
        ck_assert_uint_eq(heap.live, live);
    }
    ck_assert_uint_ge(calls, 3);
    FreeSide(&a);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("surface_pairs", a_surface_has_each_pair_within_the_margin_once,
             a_surface_far_away_or_of_any_scale_has_each_pair_within_the_margin_once,
             few_pairs_that_are_apart_are_found, a_surface_that_faces_one_way_has_the_pairs_where_it_crosses_itself,
             flat_discs_of_a_sheet_leave_nothing_to_ask, two_surfaces_have_each_pair_within_the_margin_once,
             a_large_fan_has_its_pairs_with_others_and_none_with_itself,
             surfaces_of_any_two_scales_have_each_pair_within_the_margin_once,
             a_small_surface_meets_any_part_of_one_that_floats_cannot_compare_it_with,
             surfaces_far_from_the_origin_have_each_pair_within_the_margin_once,
             pairs_on_the_border_are_found_between_two_frames, nodes_that_lie_apart_are_not_reached,
             who_wants_no_more_gets_no_more, a_failed_allocation_finds_nothing_and_leaves_nothing)
