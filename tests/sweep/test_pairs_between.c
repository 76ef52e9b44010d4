// Pairs of triangles of two bodies, of any scales and anywhere: each within the margin once.
#include "sweep/bvh_pairs_model.h"

#include "support/pairs.h"
#include "support/suite.h"

#include <stdio.h>

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

START_TEST(each_pair_of_two_bodies_within_the_margin_is_found_once)
{
    size_t within = 0;
    for (int i = 0; i < qc_soupKindCount; i++)
        for (int j = i % 3; j < qc_soupKindCount; j += 3)
        {
            char what[64];
            snprintf(what, sizeof what, "%s and %s", qcSoupKindNames[i], qcSoupKindNames[j]);
            within += qcCheckBetween(qcMakeSmallSoup((qcSoupKind)i, 8), qcMakeSmallSoup((qcSoupKind)j, 9),
                                     (i + j) % 3 == 0 ? 0.01 : 0.0, what);
        }
    ck_assert_uint_gt(within, 5000);
}
END_TEST

/// More levels than any other body of this test.
static qcSoup MakeLargeFan(void)
{
    qcSoup fan = qcSoup_MakeRandom(20, 5000, 0.5);
    for (uint32_t t = 0; t < fan.triangleCount; t++)
        fan.indices[3 * t] = 0;
    return fan;
}

START_TEST(a_large_fan_has_pairs_with_others_and_none_with_itself)
{
    ck_assert_uint_gt(qcCheckBetween(MakeLargeFan(), qcSoup_MakeRandom(21, 2, 0.5), 0.0, "fan and two"), 100);
    ck_assert_uint_gt(qcCheckBetween(qcSoup_MakeRandom(21, 2, 0.5), MakeLargeFan(), 0.0, "two and fan"), 100);

    qcSide a = qcSide_Make(MakeLargeFan());
    qcSide_Fit(&a, 0.0, qcTriangleKernels_Get(), 1);
    size_t calls = 0;
    qcBvhPairs pairs = {0};
    qcBvhPairsJob job = qcMakeSelfJob(&a, &calls);
    CHECK_OK(qcBvhPairs_Find(&pairs, &job, 1, 1));
    ck_assert_uint_eq(calls, 0);
    qcBvhPairs_Free(&pairs);
    qcSide_Free(&a);
}
END_TEST

/// Scales a soup around one vertex, and moves that to (x, x, x).
static qcSoup MakeAround(qcSoupKind kind, double scale, double x)
{
    qcSoup soup = qcMakeSoup(kind, 10);
    double centre[3];
    memcpy(centre, soup.positions + 3 * (size_t)soup.indices[soup.triangleCount / 2 * 3], sizeof centre);
    qcSoup_Translate(&soup, -centre[0], -centre[1], -centre[2]);
    qcSoup_Place(&soup, scale, x, x, x);
    return soup;
}

START_TEST(each_pair_is_found_once_for_any_two_scales)
{
    const double scales[] = {1.0, 1e-3, 1e-6, 1e-12, 1e-30, 1e-34, 5e-35, 2e-36, 1e-38, 1e-60, 1e-300, 1e3, 1e280};
    for (size_t i = 0; i < LENGTH(scales); i++)
        for (int kind = qc_soupNodeAndOne + (int)i % 2; kind <= qc_soupLine; kind += 3)
        {
            double least = fmin(scales[i], 1.0);
            size_t within =
                qcCheckBetween(MakeAround((qcSoupKind)kind, 1.0, 0.0), MakeAround(qc_soupSphere, scales[i], 0.0),
                               i % 2 == 0 ? 0.0 : 0.01 * least, qcSoupKindNames[kind]);
            within += qcCheckBetween(MakeAround(qc_soupSphere, scales[i], 0.0), MakeAround((qcSoupKind)kind, 1.0, 0.0),
                                     0.0, qcSoupKindNames[kind]);
            ck_assert_uint_gt(within, 0);
        }
}
END_TEST

START_TEST(a_body_too_small_for_floats_is_found_in_any_part_of_a_large_one)
{
    // The boxes of the large body lie anywhere around its centre, where levels of its lattice are zero.
    qcRandom random = {11};
    for (int round = 0; round < 60; round++)
    {
        double scale = pow(10.0, qcRandom_Uniform(&random, -39.0, -32.0));
        qcSoup large = qcSoup_MakeRandom((uint64_t)round, 40, 0.3), small = qcSoup_MakeRandom(1, 5, 0.5);
        uint32_t t = qcRandom_Below(&random, large.triangleCount);
        // A point well inside one triangle moves to the centre of the small body.
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
            qcCheckBetween(small, large, 0.0, "small and large");
        else
            qcCheckBetween(large, small, 0.0, "large and small");
    }
}
END_TEST

START_TEST(each_pair_is_found_once_far_from_the_origin)
{
    const double offsets[] = {1e3, -1e9, 1e12, 1e15};
    for (size_t i = 0; i < LENGTH(offsets); i++)
        for (int kind = 0; kind < qc_soupKindCount; kind++)
        {
            qcSoup a = qcMakeSmallSoup((qcSoupKind)kind, 12), b = qcMakeSmallSoup(qc_soupSphere, 13);
            qcSoup_Place(&a, 1.0, offsets[i], -offsets[i], 0.0);
            qcSoup_Place(&b, 1.0, offsets[i] + 0.25, -offsets[i], 0.0);
            qcCheckBetween(a, b, i % 2 == 0 ? 0.0 : 0.01, qcSoupKindNames[kind]);
        }
}
END_TEST

/// A pair at the margin, at most `size` large after scaling by the returned factor.
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

/// Both sides of many small pairs, each in a cell of its own; the second side has one triangle far away.
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

START_TEST(pairs_at_the_margin_are_found_between_two_frames)
{
    qcRandom random = {14};
    size_t within = 0;
    for (int round = 0; round < 40; round++)
    {
        qcSoup a, b;
        double size = ldexp(0.4, -(round % 16)), margin = round % 3 == 0 ? 0.0 : size / 64;
        MakeCells(&random, size, margin, &a, &b);
        within += round % 2 == 0 ? qcCheckBetween(a, b, margin, "cells") : qcCheckBetween(b, a, margin, "cells");
    }
    ck_assert_uint_gt(within, 2000);
}
END_TEST

START_TEST(separate_nodes_are_not_visited)
{
    qcSide a = qcSide_Make(qcSoup_MakeSphere(3, 1.0)), b = qcSide_Make(qcSoup_MakeSphere(3, 1.0));
    qcSoup_Translate(&b.soup, 1.9, 0.0, 0.0);
    for (int step = 0; step < 2; step++)
    {
        qcSoup_Translate(&b.soup, 0.2 * step, 0.0, 0.0);
        CHECK_OK(qcBodies_SetVertices(&b.bodies, 0, b.soup.positions, qc_positionF64, 0));
        qcPairOracle oracle = qcPairOracle_Make(&a, &b, 0.0);
        qcSide_Fit(&a, 0.0, qcTriangleKernels_Get(), 1);
        qcSide_Fit(&b, 0.0, qcTriangleKernels_Get(), 1);
        uint32_t nodes = a.bvh.bvh.clusters.nodeCount, visitedNodes = 0;
        uint8_t visited[2][512] = {{0}};
        ck_assert_uint_le(nodes, 512);
        qcFoundPairs found;
        qcFoundPairs_Make(&found, &a, &b);
        found.visitedA = visited[0];
        found.visitedB = visited[1];
        qcBvhPairs pairs = {0};
        qcBvhPairsJob job = {.kernels = qcTriangleKernels_Get(),
                             .a = &a.bvh,
                             .b = &b.bvh,
                             .bodyA = qcBodyAt(&a.bodies, 0),
                             .bodyB = qcBodyAt(&b.bodies, 0),
                             .visitedA = visited[0],
                             .visitedB = visited[1],
                             .function = qcFoundPairs_Add,
                             .context = &found};
        CHECK_OK(qcBvhPairs_Find(&pairs, &job, 1, 1));
        qcFoundPairs_Check(&found, &oracle, false, "spheres");
        for (uint32_t i = 0; i < nodes; i++)
            visitedNodes += visited[0][i];
        ck_assert_int_eq(found.count > 0, step == 0);
        ck_assert_int_eq(visitedNodes > 0, step == 0);
        ck_assert_uint_lt(visitedNodes, nodes / 4);
        qcFoundPairs_Free(&found);
        qcPairOracle_Free(&oracle);
        qcBvhPairs_Free(&pairs);
    }
    qcSide_Free(&a);
    qcSide_Free(&b);
}
END_TEST

enum
{
    // Each body with itself and with all others: more searches than one block prepares.
    qc_crowd = 18,
    qc_crowdPairs = qc_crowd * (qc_crowd + 1) / 2
};

static void CheckCrowd(const qcSide* sides, qcPairOracle* oracles, double margin, uint32_t threads)
{
    qcFoundPairs found[qc_crowdPairs];
    qcBvhPairsJob jobs[qc_crowdPairs];
    static uint8_t visited[qc_crowd][64];
    size_t count = 0, pairCount = 0;
    for (int a = 0; a < qc_crowd; a++)
        for (int b = a; b < qc_crowd; b++, count++)
        {
            qcFoundPairs_Make(&found[count], &sides[a], &sides[b]);
            found[count].visitedA = visited[a];
            found[count].visitedB = visited[b];
            jobs[count] = (qcBvhPairsJob){.kernels = qcTriangleKernels_Get(),
                                          .a = &sides[a].bvh,
                                          .b = &sides[b].bvh,
                                          .bodyA = qcBodyAt(&sides[a].bodies, 0),
                                          .bodyB = qcBodyAt(&sides[b].bodies, 0),
                                          .query = margin,
                                          .near = margin,
                                          .visitedA = visited[a],
                                          .visitedB = visited[b],
                                          .function = qcFoundPairs_Add,
                                          .context = &found[count]};
        }
    qcBvhPairs pairs = {0};
    CHECK_OK(qcBvhPairs_Find(&pairs, jobs, count, threads));
    for (size_t i = 0; i < count; i++)
    {
        qcFoundPairs_Check(&found[i], &oracles[i], false, "crowd");
        pairCount += found[i].count;
        qcFoundPairs_Free(&found[i]);
    }
    ck_assert_uint_gt(pairCount, 1000);
    qcBvhPairs_Free(&pairs);
}

START_TEST(many_parallel_searches_find_their_own_pairs)
{
    qcSide sides[qc_crowd];
    for (uint32_t i = 0; i < qc_crowd; i++)
    {
        // One body has most of the triangles, some have a single leaf node.
        sides[i] = qcSide_Make(qcSoup_MakeRandom(30 + i, i == 5 ? 1500 : 10 + 13 * i, 0.1));
        qcSide_Fit(&sides[i], 0.01, qcTriangleKernels_Get(), 1);
        ck_assert_uint_le(sides[i].bvh.bvh.clusters.nodeCount, 64);
    }
    qcPairOracle oracles[qc_crowdPairs];
    size_t count = 0;
    for (int a = 0; a < qc_crowd; a++)
        for (int b = a; b < qc_crowd; b++)
            oracles[count++] = qcPairOracle_Make(&sides[a], &sides[b], 0.01);
    for (uint32_t threads = 1; threads <= 3; threads++)
        CheckCrowd(sides, oracles, 0.01, threads);
    for (size_t i = 0; i < count; i++)
        qcPairOracle_Free(&oracles[i]);
    for (uint32_t i = 0; i < qc_crowd; i++)
        qcSide_Free(&sides[i]);
}
END_TEST

QC_RUN_TESTS("pairs_between", each_pair_of_two_bodies_within_the_margin_is_found_once,
             a_large_fan_has_pairs_with_others_and_none_with_itself, each_pair_is_found_once_for_any_two_scales,
             a_body_too_small_for_floats_is_found_in_any_part_of_a_large_one,
             each_pair_is_found_once_far_from_the_origin, pairs_at_the_margin_are_found_between_two_frames,
             separate_nodes_are_not_visited, many_parallel_searches_find_their_own_pairs)
