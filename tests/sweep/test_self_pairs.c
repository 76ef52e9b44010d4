// Pairs of triangles of one body: each within the margin once, classified right; flat patches lose none.
#include "sweep/bvh_pairs_model.h"

#include "support/failing_heap.h"
#include "support/suite.h"

#define LENGTH(array) (sizeof(array) / sizeof(array)[0])

START_TEST(each_pair_within_the_margin_is_found_once)
{
    const double margins[] = {0.0, 0.01};
    for (int kind = 0; kind < qc_soupKindCount; kind++)
        for (size_t i = 0; i < LENGTH(margins); i++)
            qcCheckWithin(qcMakeSmallSoup((qcSoupKind)kind, 3), margins[i], qcSoupKindNames[kind]);
}
END_TEST

START_TEST(each_pair_is_found_once_far_away_and_at_any_scale)
{
    const double scales[] = {1e-300, 1e-6, 1e6, 1e280}, offsets[] = {1e6, 1e12, 1e15};
    for (int kind = qc_soupDegenerate; kind < qc_soupKindCount; kind += 2)
    {
        for (size_t i = 0; i < LENGTH(scales); i++)
        {
            qcSoup soup = qcMakeSmallSoup((qcSoupKind)kind, 4);
            qcSoup_Place(&soup, scales[i], 0.0, 0.0, 0.0);
            qcCheckWithin(soup, i % 2 == 0 ? 0.0 : 0.01 * scales[i], qcSoupKindNames[kind]);
        }
        for (size_t i = 0; i < LENGTH(offsets); i++)
        {
            qcSoup soup = qcMakeSmallSoup((qcSoupKind)kind, 5);
            qcSoup_Place(&soup, 1.0, offsets[i], 0.0, -offsets[i]);
            qcCheckWithin(soup, 0.0, qcSoupKindNames[kind]);
        }
    }
}
END_TEST

START_TEST(few_separate_pairs_are_found)
{
    qcSide a = qcSide_Make(qcSoup_MakeRandom(6, 400, 0.2)), b = qcSide_Make(qcSoup_MakeRandom(7, 400, 0.2));
    qcSide* sides[] = {&a, &b};
    for (int i = 0; i < 2; i++)
    {
        qcPairOracle oracle = qcPairOracle_Make(&a, sides[i], 0.0);
        size_t count = qcCheckPairs(&a, sides[i], 0.0, true, &oracle, "random"), within = 0;
        for (uint32_t t = 0; t < a.soup.triangleCount; t++)
            for (uint32_t u = i == 0 ? t + 1 : 0; u < b.soup.triangleCount; u++)
                within += qcPairOracle_AreWithin(&oracle, t, u);
        ck_assert_uint_gt(within, 200);
        ck_assert_uint_gt(oracle.boxes, 2 * within);
        ck_assert_uint_lt(count, within + within / 20);
        qcPairOracle_Free(&oracle);
    }
    qcSide_Free(&a);
    qcSide_Free(&b);
}
END_TEST

/// A closed strip of two turns that faces one way everywhere, also where the turns cross.
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

START_TEST(a_strip_that_faces_one_way_has_the_pairs_where_it_crosses_itself)
{
    for (uint32_t columns = 16; columns <= 100; columns += 14)
        for (uint32_t rows = 1; rows <= 4; rows++)
        {
            // Margins up to where hardly any patch is flat.
            double margin = columns % 4 == 0 ? 0.0 : 0.4 / columns / (1 << columns / 2 % 4);
            qcCheckWithin(MakeCoil(columns, rows, rows % 2 == 0 ? 0.2 : 1e-4), margin, "coil");
        }
}
END_TEST

START_TEST(nearly_all_patches_of_a_smooth_sheet_are_flat)
{
    // Waves without self-contact: all pairs are proven separate.
    qcSide a = qcSide_Make(qcSoup_MakeGrid(40));
    for (uint32_t v = 0; v < a.soup.vertexCount; v++)
        a.soup.positions[3 * v + 2] = 0.05 * sin(12.0 * a.soup.positions[3 * v] + 5.0 * a.soup.positions[3 * v + 1]);
    CHECK_OK(qcBodies_SetVertices(&a.bodies, 0, a.soup.positions, qc_positionF64, 0));
    // Edges have length 1 / 40.
    for (double margin = 0.0; margin <= 0.25 / 40; margin += 0.125 / 40)
        FOR_EACH_KERNELS(k)
        {
            a.bvh.bvh.fit.fitted = false;
            qcSide_Fit(&a, margin, k, 1);
            qcPatchState_Test(&a.bvh.patches, &a.bvh.bvh, k, 1);
            uint32_t flat = 0, nodes = a.bvh.patches.patches.nodeCount;
            for (uint32_t node = 0; node < nodes; node++)
                flat +=
                    qcPatchFlags_IsFlat(&a.bvh.patches.present, qcFlatPatches_Large(&a.bvh.patches.patches, node)) ||
                    qcPatchFlags_IsFlat(&a.bvh.patches.present, node);
            CHECK_THAT(flat > nodes * 9 / 10, "%s, margin %g: %u of %u nodes are flat", k->name, margin, flat, nodes);
        }
    qcSide_Free(&a);
}
END_TEST

START_TEST(most_pairs_are_classified_and_all_of_these_right)
{
    // Three intersecting layers of cloth, and random triangles without neighbours.
    qcSide a = qcSide_Make(qcMakeSoup(qc_soupCloth, 30)), b = qcSide_Make(qcSoup_MakeRandom(31, 400, 0.2));
    qcSide* sides[] = {&a, &b};
    for (int i = 0; i < 4; i++)
    {
        qcSide* side = sides[i % 2];
        double margin = i < 2 ? 0.02 : 0.0;
        qcPairOracle oracle = qcPairOracle_Make(side, side, margin);
        qcCheckPairs(side, side, margin, false, &oracle, i % 2 == 0 ? "cloth" : "random");
        size_t expected[qc_relationNear + 1] = {0}, times = 0;
        for (uint32_t t = 0; t < side->soup.triangleCount; t++)
            for (uint32_t u = t + 1; u < side->soup.triangleCount; u++)
                if (!qcSoup_AreNeighbours(&side->soup, t, u) && qcPairOracle_AreWithin(&oracle, t, u))
                    expected[qcPairOracle_Relate(&oracle, t, u)]++;
        // By all kernels, on one thread and on three, without flat patches and with them.
        FOR_EACH_KERNELS(k)
        times += 4;
        size_t disjoint = oracle.classes[qc_relationNear] + oracle.classes[qc_relationDisjoint];
        CHECK_THAT(disjoint >= expected[qc_relationDisjoint] * times * 9 / 10, "%zu of %zu are classified disjoint",
                   disjoint, expected[qc_relationDisjoint] * times);
        CHECK_THAT(oracle.classes[qc_relationPenetrating] >= expected[qc_relationPenetrating] * times * 8 / 10,
                   "%zu of %zu penetrate", oracle.classes[qc_relationPenetrating],
                   expected[qc_relationPenetrating] * times);
        ck_assert_int_eq(oracle.classes[qc_relationNear] > disjoint / 10, margin > 0.0);
        ck_assert_int_eq(oracle.classes[qc_relationDisjoint] > disjoint / 10, margin > 0.0);
        ck_assert_uint_gt(expected[qc_relationPenetrating], 100);
        ck_assert_int_eq(expected[qc_relationDisjoint] > 100, margin > 0.0);
        qcPairOracle_Free(&oracle);
    }
    qcSide_Free(&a);
    qcSide_Free(&b);
}
END_TEST

static size_t s_collectCalls;

static qcSlotPair* CountCollectPairs(const qcBvhBoxes* a, uint32_t nodeA, const qcBvhBoxes* b, uint32_t nodeB,
                                     const uint64_t* pairMasks, const qcPairExclusion* exclusions, int exclusionCount,
                                     const qcPlaneTest* planes, qcSlotPair* pairs)
{
    s_collectCalls++;
    return qcTriangleKernels_Get()->collectPairs(a, nodeA, b, nodeB, pairMasks, exclusions, exclusionCount, planes,
                                                 pairs);
}

START_TEST(a_search_stops_when_its_function_returns_false)
{
    qcSide a = qcSide_Make(qcSoup_MakeRandom(2, 1500, 0.3));
    qcSide_Fit(&a, 0.0, qcTriangleKernels_Get(), 1);
    size_t calls = 0;
    qcBvhPairs pairs = {0};
    qcBvhPairsJob job = qcMakeSelfJob(&a, &calls);
    qcTriangleKernels kernels = *job.kernels;
    kernels.collectPairs = CountCollectPairs;
    job.kernels = &kernels;
    s_collectCalls = 0;
    CHECK_OK(qcBvhPairs_Find(&pairs, &job, 1, 1));
    ck_assert_uint_eq(calls, 1);
    ck_assert_uint_le(s_collectCalls, 64);
    qcBvhPairs_Free(&pairs);
    qcSide_Free(&a);
}
END_TEST

START_TEST(a_failed_allocation_finds_nothing_and_leaves_nothing)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSide a = qcSide_Make(qcSoup_MakeRandom(2, 1500, 0.05));
    qcSide_Fit(&a, 0.0, qcTriangleKernels_Get(), 1);
    size_t live = heap.live, calls = 1, taken;
    for (size_t i = 0; i <= calls; i++)
    {
        heap = (qcFailingHeap){live, 0, i};
        taken = 0;
        qcBvhPairs pairs = {0};
        qcBvhPairsJob job = qcMakeSelfJob(&a, &taken);
        ck_assert_int_eq(qcBvhPairs_Find(&pairs, &job, 1, 2), i == 0 ? qc_statusOk : qc_statusOutOfMemory);
        ck_assert_int_eq(taken > 0, i == 0);
        calls = i == 0 ? heap.calls : calls;
        qcBvhPairs_Free(&pairs);
        ck_assert_uint_eq(heap.live, live);
    }
    ck_assert_uint_ge(calls, 3);
    qcSide_Free(&a);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("self_pairs", each_pair_within_the_margin_is_found_once, each_pair_is_found_once_far_away_and_at_any_scale,
             few_separate_pairs_are_found, a_strip_that_faces_one_way_has_the_pairs_where_it_crosses_itself,
             nearly_all_patches_of_a_smooth_sheet_are_flat, most_pairs_are_classified_and_all_of_these_right,
             a_search_stops_when_its_function_returns_false, a_failed_allocation_finds_nothing_and_leaves_nothing)
