// The sweep finds the pairs of brute force, on every kind of soup, with every option and number of threads; brute force
// finds the pairs of the exact intersection test, one by one.
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

/// Compares sweep and brute force in all combinations of options; returns the number of pairs with touching ones.
static size_t CompareMethods(qcScene* scene, const char* what)
{
    size_t pairs = 0;
    for (int options = 0; options < 4; options++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = (options & 1) != 0;
        def.neighbours = (options & 2) != 0;
        def.method = qc_methodBrute;
        qcPairList expected = qcDetectPairs(scene, &def);
        pairs = options == 1 ? expected.count : pairs;
        for (uint32_t threads = 1; threads <= 4; threads++)
        {
            def.threads = threads;
            def.method = threads == 3 ? qc_methodAuto : qc_methodSweep;
            qcPairList found = qcDetectPairs(scene, &def);
            qcCheckSamePairs(&expected, &found, what);
            free(found.pairs);
        }
        free(expected.pairs);
    }
    return pairs;
}

static size_t CompareOn(qcSoup soup, const char* what)
{
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    size_t pairs = CompareMethods(scene, what);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    return pairs;
}

START_TEST(sweep_equals_brute_force_on_random_soups)
{
    size_t pairs = 0;
    for (uint64_t seed = 1; seed <= 12; seed++)
        pairs += CompareOn(qcSoup_MakeRandom(seed, 700, 0.02 * (double)seed), "random soup");
    ck_assert_uint_gt(pairs, 1000);
}
END_TEST

START_TEST(sweep_equals_brute_force_on_degenerate_soups)
{
    size_t pairs = 0;
    for (uint64_t seed = 1; seed <= 6; seed++)
        pairs += CompareOn(qcSoup_MakeDegenerate(seed, 600, 0.2, 0.5), "degenerate soup");
    ck_assert_uint_gt(pairs, 100);
}
END_TEST

START_TEST(sweep_equals_brute_force_on_folded_cloth)
{
    // Large enough for more than one thread to be used.
    ck_assert_uint_gt(CompareOn(qcSoup_MakeFoldedCloth(5, 56, 0.01, 0.02), "folded cloth"), 10);
}
END_TEST

START_TEST(sweep_equals_brute_force_on_a_flat_grid_and_on_sheets)
{
    CompareOn(qcSoup_MakeGrid(24), "flat grid");
    ck_assert_uint_eq(CompareOn(qcSoup_MakeSheets(4, 14, 1e-6), "sheets"), 0);
}
END_TEST

START_TEST(sweep_equals_brute_force_far_from_the_origin)
{
    // In single precision all vertices would coincide, but for the origin of the frame.
    qcSoup soup = qcSoup_MakeRandom(3, 800, 0.1);
    qcSoup_Translate(&soup, 1e7, -3e7, 2e9);
    ck_assert_uint_gt(CompareOn(soup, "far soup"), 100);
}
END_TEST

START_TEST(sweep_equals_brute_force_at_extreme_scales)
{
    const double scales[] = {1e-300, 1e-30, 1e30, 1e300, 1e307};
    for (int i = 0; i < 5; i++)
    {
        qcSoup soup = qcSoup_MakeRandom(7, 400, 0.1);
        for (uint32_t v = 0; v < 3 * soup.vertexCount; v++)
            soup.positions[v] *= scales[i];
        ck_assert_uint_gt(CompareOn(soup, "scaled soup"), 50);
    }
}
END_TEST

START_TEST(sweep_equals_brute_force_when_sizes_differ_wildly)
{
    qcSoup soup = qcSoup_MakeRandom(11, 500, 0.1);
    for (uint32_t v = 0; v < 9 * 20; v++)
        soup.positions[v] *= 1000.0; // the first twenty triangles
    ck_assert_uint_gt(CompareOn(soup, "mixed sizes"), 10);
}
END_TEST

START_TEST(sweep_equals_brute_force_among_bodies)
{
    qcScene* scene = qcMakeScene(NULL);
    qcRandom random = {99};
    for (uint32_t body = 0; body < 12; body++)
    {
        qcSoup soup = qcSoup_MakeSphere(2, 0.25);
        qcBodyDef def = qcBodyDefOf(&soup);
        for (int axis = 0; axis < 3; axis++)
            def.transform.translation[axis] = qcRandom_Uniform(&random, 0.0, 0.8);
        def.group = 1u << body % 3;
        def.mask = body % 4 == 0 ? 3u : 7u;
        def.activity = body % 5 == 0 ? qc_activityStatic : body % 5 == 1 ? qc_activitySleeping : qc_activityMoving;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
        qcSoup_Free(&soup);
    }
    ck_assert_uint_gt(CompareMethods(scene, "bodies"), 100);

    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_gt(result->profile.skippedStaticPairs, 0);
    ck_assert_uint_gt(result->profile.skippedFilteredPairs, 0);
    ck_assert_uint_gt(result->profile.skippedTriangles, 0);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(brute_force_reports_exactly_the_pairs_that_intersect)
{
    qcSoup soup = qcSoup_MakeDegenerate(21, 120, 0.4, 0.3);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodBrute;
    def.touching = true;
    qcPairList list = qcDetectPairs(scene, &def);
    size_t next = 0;
    for (uint32_t a = 0; a < soup.triangleCount; a++)
        for (uint32_t b = a + 1; b < soup.triangleCount; b++)
        {
            if (qcSoup_AreNeighbours(&soup, a, b))
                continue;
            double p[3][3], q[3][3];
            qcSoup_GetTriangle(&soup, a, p);
            qcSoup_GetTriangle(&soup, b, q);
            qcRelation relation = qcRelateTriangles(&p[0][0], &q[0][0]);
            if (relation == qc_relationDisjoint)
                continue;
            ck_assert_uint_lt(next, list.count);
            ck_assert_uint_eq(list.pairs[next].triangleA, a);
            ck_assert_uint_eq(list.pairs[next].triangleB, b);
            ck_assert_int_eq(list.pairs[next].relation, relation);
            next++;
        }
    ck_assert_uint_eq(next, list.count);
    ck_assert_uint_gt(next, 20);
    free(list.pairs);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(rotated_rigid_bodies_have_the_pairs_of_their_transformed_vertices)
{
    qcSoup soup = qcSoup_MakeSphere(2, 0.5), moved = qcSoup_MakeSphere(2, 0.5);
    qcTransform transform = {{0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6}, {0.7, 0.1, -0.2}};
    for (uint32_t v = 0; v < moved.vertexCount; v++)
    {
        const double* p = soup.positions + 3 * v;
        for (size_t axis = 0; axis < 3; axis++)
            moved.positions[3 * v + axis] = transform.linear[3 * axis] * p[0] + transform.linear[3 * axis + 1] * p[1] +
                                            transform.linear[3 * axis + 2] * p[2] + transform.translation[axis];
    }
    qcScene *rigid = qcMakeScene(NULL), *plain = qcMakeScene(NULL);
    qcAddSoup(rigid, &soup);
    qcBodyId id = qcAddSoup(rigid, &soup);
    CHECK_OK(qcScene_SetTransform(rigid, id, &transform));
    qcAddSoup(plain, &soup);
    qcAddSoup(plain, &moved);
    qcDetectDef def = qcDefaultDetectDef();
    def.touching = true;
    qcPairList a = qcDetectPairs(rigid, &def), b = qcDetectPairs(plain, &def);
    ck_assert_uint_gt(a.count, 20);
    qcCheckSamePairs(&b, &a, "rotated sphere");
    free(a.pairs);
    free(b.pairs);
    qcScene_Destroy(rigid);
    qcScene_Destroy(plain);
    qcSoup_Free(&soup);
    qcSoup_Free(&moved);
}
END_TEST

START_TEST(a_segment_is_given_for_each_penetrating_pair)
{
    qcSoup soup = qcSoup_MakeRandom(4, 500, 0.2);
    qcScene* scene = qcMakeScene(NULL);
    qcAddSoup(scene, &soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.segments = def.touching = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_gt(result->pairCount, 50);
    for (size_t i = 0; i < result->pairCount; i++)
    {
        // Both ends lie in the boxes of both triangles.
        double corners[2][3][3];
        qcSoup_GetTriangle(&soup, result->pairs[i].triangleA, corners[0]);
        qcSoup_GetTriangle(&soup, result->pairs[i].triangleB, corners[1]);
        for (int t = 0; t < 2; t++)
            for (int axis = 0; axis < 3; axis++)
            {
                double low = fmin(corners[t][0][axis], fmin(corners[t][1][axis], corners[t][2][axis])) - 1e-12;
                double high = fmax(corners[t][0][axis], fmax(corners[t][1][axis], corners[t][2][axis])) + 1e-12;
                ck_assert_double_ge(result->segments[i].p[axis], low);
                ck_assert_double_le(result->segments[i].p[axis], high);
                ck_assert_double_ge(result->segments[i].q[axis], low);
                ck_assert_double_le(result->segments[i].q[axis], high);
            }
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(each_method_finds_the_pairs_of_a_scene_that_grows_in_between)
{
    // Each method retains memory of its own sizes from step to step.
    qcScene* scene = qcMakeScene(NULL);
    for (int round = 0; round < 4; round++)
    {
        qcSoup soup = qcSoup_MakeRandom((uint64_t)round + 1, 100u << round, 0.15);
        qcAddSoup(scene, &soup);
        qcSoup_Free(&soup);
        CompareMethods(scene, "growing scene");
    }
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_vertex_without_a_triangle_changes_nothing)
{
    qcSoup soup = qcSoup_MakeRandom(6, 300, 0.2);
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcBodyDefOf(&soup);
    // The same, and the last triangle's corners unused.
    def.triangleCount--;
    memset(soup.positions + 9 * (size_t)(soup.triangleCount - 1), 0, 9 * sizeof(double));
    soup.positions[9 * (size_t)soup.triangleCount - 1] = 1e30;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    soup.positions[9 * (size_t)soup.triangleCount - 1] = 0.0;
    soup.triangleCount = 200;
    def = qcBodyDefOf(&soup);
    def.transform.translation[2] = 1e6;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    qcDetectDef detect = qcDefaultDetectDef();
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &detect, &result));
    ck_assert_uint_eq(result->profile.bodyPairs, 0);
    ck_assert_uint_gt(result->pairCount, 10);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(sweep_equals_brute_force_under_many_partners)
{
    // A grid with more bodies above it than the sweep tests one by one, and with fewer.
    for (int partners = 3; partners <= 12; partners += 9)
    {
        qcScene* scene = qcMakeScene(NULL);
        qcSoup grid = qcSoup_MakeGrid(20);
        qcAddSoup(scene, &grid);
        qcRandom random = {5};
        for (int i = 0; i < partners; i++)
        {
            qcSoup ball = qcSoup_MakeSphere(1, 0.08);
            qcSoup_Translate(&ball, qcRandom_Uniform(&random, 0, 1), qcRandom_Uniform(&random, 0, 1), 0.02);
            qcAddSoup(scene, &ball);
            qcSoup_Free(&ball);
        }
        ck_assert_uint_gt(CompareMethods(scene, "grid and balls"), 10);
        qcSoup_Free(&grid);
        qcScene_Destroy(scene);
    }
}
END_TEST

QC_RUN_TESTS("methods", sweep_equals_brute_force_on_random_soups, sweep_equals_brute_force_on_degenerate_soups,
             sweep_equals_brute_force_on_folded_cloth, sweep_equals_brute_force_on_a_flat_grid_and_on_sheets,
             sweep_equals_brute_force_far_from_the_origin, sweep_equals_brute_force_at_extreme_scales,
             sweep_equals_brute_force_when_sizes_differ_wildly, sweep_equals_brute_force_among_bodies,
             brute_force_reports_exactly_the_pairs_that_intersect,
             rotated_rigid_bodies_have_the_pairs_of_their_transformed_vertices,
             a_segment_is_given_for_each_penetrating_pair, each_method_finds_the_pairs_of_a_scene_that_grows_in_between,
             a_vertex_without_a_triangle_changes_nothing, sweep_equals_brute_force_under_many_partners)
