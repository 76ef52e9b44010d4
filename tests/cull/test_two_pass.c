// CULLIDE and Quick-CULLIDE on real GL: hand-made scenes whose sets are known, and the invariants of the paper on
// others. Each test runs on every software device that is there.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

static qcDetectDef Request(qcMethod method, const char* views, uint32_t resolution, uint32_t iterations)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.resolution = resolution;
    def.iterations = iterations;
    memset(def.views, 0, sizeof def.views);
    memcpy(def.views, views, strlen(views));
    return def;
}

/// A flat bar from p to q, `width` wide in the plane of x and y, two triangles, without self-collision.
static qcBodyId AddBar(qcScene* scene, double px, double py, double pz, double qx, double qy, double qz, double width)
{
    double length = hypot(qx - px, qy - py), nx = -(qy - py) / length * width / 2, ny = (qx - px) / length * width / 2;
    double positions[12] = {px + nx, py + ny, pz, px - nx, py - ny, pz, qx - nx, qy - ny, qz, qx + nx, qy + ny, qz};
    uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions;
    def.positionType = qc_positionF64;
    def.vertexCount = 4;
    def.indices = indices;
    def.triangleCount = 2;
    def.selfCollision = false;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

static const qcResult* Detect(qcScene* scene, const qcDetectDef* def)
{
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, def, &result));
    return result;
}

START_TEST(the_nearer_of_two_objects_is_pruned_in_the_first_view)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (int nearer = 0; nearer < 2; nearer++)
        {
            qcScene* scene = qcMakeScene(device);
            for (int body = 0; body < 2; body++)
            {
                double z = body == nearer ? 0.0 : 1.0;
                AddBar(scene, 0, 0, z, 1, 0, z, 0.5);
            }
            qcDetectDef def = Request(qc_methodQuick, "z", 64, 1);
            const qcResult* result = Detect(scene, &def);
            ck_assert_uint_eq(result->profile.passCount, 2);
            const qcPassRecord *first = &result->profile.passes[0], *second = &result->profile.passes[1];
            ck_assert_int_eq(first->level, qc_levelObjects);
            ck_assert_int_eq(first->axis, 'z');
            ck_assert_uint_eq(first->queries, 2);
            ck_assert_uint_eq(first->rendered, 2);
            // In order, the second object sees the first; in reverse, the first sees the second.
            ck_assert_uint_eq(first->ffv, nearer == 0 ? 1 : 2);
            ck_assert_uint_eq(first->nfv, nearer == 0 ? 1 : 0);
            // The farther one last: it hides nothing from the other. The farther one first: both were in FFV, which is
            // collision-free, so neither is rendered again and both are pruned.
            ck_assert_uint_eq(second->rendered, nearer == 0 ? 1 : 0);
            ck_assert_uint_eq(second->bfv, nearer == 0 ? 1 : 2);
            ck_assert_uint_eq(second->sfv, nearer == 0 ? 1 : 0);
            ck_assert_uint_eq(result->profile.objectPcs, nearer == 0 ? 1 : 0);
            // CULLIDE renders both again, and the farther one is hidden.
            def.method = qc_methodCullide;
            ck_assert_uint_eq(Detect(scene, &def)->profile.objectPcs, 1);
            // A second round has nothing left to hide the other.
            def.iterations = 0;
            ck_assert_uint_eq(Detect(scene, &def)->profile.objectPcs, 0);
            qcScene_Destroy(scene);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(objects_side_by_side_are_pruned_in_the_first_view)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        for (int body = 0; body < 5; body++)
            AddBar(scene, body, 0, body % 2, body + 0.8, 0, body % 3, 0.5);
        qcDetectDef def = Request(qc_methodCullide, "z", 256, 1);
        ck_assert_uint_eq(Detect(scene, &def)->profile.objectPcs, 0);
        qcScene_Destroy(scene);
    }
}
END_TEST

/// Three bars, each behind the next where they cross: no order of depth exists.
static void AddCycle(qcScene* scene)
{
    const double x[3] = {0.0, 1.0, 0.5}, y[3] = {0.0, 0.0, 0.866};
    for (int i = 0; i < 3; i++)
    {
        int j = (i + 1) % 3;
        double dx = 0.1 * (x[j] - x[i]), dy = 0.1 * (y[j] - y[i]);
        AddBar(scene, x[i] - dx, y[i] - dy, 0.0, x[j] + dx, y[j] + dy, 1.0, 0.08);
    }
}

START_TEST(quick_prunes_a_cycle_that_stops_cullide)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddCycle(scene);
        qcDetectDef def = Request(qc_methodCullide, "z", 512, 0);
        ck_assert_uint_eq(Detect(scene, &def)->profile.objectPcs, 3);

        def = Request(qc_methodQuick, "z", 512, 1);
        const qcResult* result = Detect(scene, &def);
        const qcPassRecord* after = &result->profile.passes[1];
        ck_assert_uint_eq(after->bfv, 1); // the first: only the second hides it, and both are in FFV
        ck_assert_uint_eq(after->ffv, 1); // the second: in front of the first, behind the third
        ck_assert_uint_eq(after->sfv, 1); // the third: nothing is rendered before it in the second pass

        def = Request(qc_methodQuick, "z", 512, 0);
        ck_assert_uint_eq(Detect(scene, &def)->profile.objectPcs, 0);
        qcScene_Destroy(scene);
    }
}
END_TEST

/// Two bars beside each other whose boxes overlap, and a third that crosses both.
static void AddComb(qcScene* scene)
{
    AddBar(scene, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.1);
    AddBar(scene, 0.3, 0.0, 0.0, 1.3, 1.0, 1.0, 0.1);
    AddBar(scene, 0.0, 0.5, 0.5, 1.3, 0.5, 0.5, 0.2);
}

START_TEST(a_pair_inside_one_collision_free_set_is_not_swept)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddComb(scene);
        qcDetectDef def = Request(qc_methodQuick, "z", 512, 0);
        const qcResult* result = Detect(scene, &def);
        ck_assert_uint_eq(result->profile.objectPcs, 3);
        ck_assert_uint_eq(result->profile.passes[1].ffv, 2);
        ck_assert_uint_eq(result->profile.passes[1].sfv, 1);
        ck_assert_uint_eq(result->profile.bodyPairs, 2);
        ck_assert_uint_eq(result->profile.skippedSetPairs, 1);
        for (size_t i = 0; i < result->pairCount; i++)
            ck_assert_uint_eq(result->pairs[i].bodyB, 2);
        ck_assert_uint_ge(result->pairCount, 2);
        def.method = qc_methodCullide;
        ck_assert_uint_eq(Detect(scene, &def)->profile.bodyPairs, 3);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(sets_save_queries_and_renders)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddComb(scene);
        qcDetectDef def = Request(qc_methodQuick, "z", 512, 2);
        const qcResult* result = Detect(scene, &def);
        const qcPassRecord* passes = result->profile.passes;
        ck_assert_uint_ge(result->profile.passCount, 4);
        // Second round: SFV is tested against FFV, then FFV against SFV.
        ck_assert_uint_eq(passes[2].queries, passes[1].sfv + passes[1].nfv);
        ck_assert_uint_eq(passes[2].rendered, passes[1].ffv + passes[1].nfv);
        ck_assert_uint_eq(passes[3].queries, passes[2].ffv + passes[2].nfv);
        ck_assert_uint_eq(passes[3].rendered, passes[2].sfv + passes[2].nfv);
        // Together with the sizes above: as many fewer of each as FFV and SFV have members (end of section 4.1).
        ck_assert_uint_eq(passes[2].queries + passes[3].queries + passes[2].rendered + passes[3].rendered, 2 * 3);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(crossing_objects_stay_and_their_pair_is_found)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (int method = qc_methodCullide; method <= qc_methodQuick; method++)
        {
            qcScene* scene = qcMakeScene(device);
            AddBar(scene, 0, 0, 0, 1, 0, 1, 0.3);
            AddBar(scene, 0, 0, 1, 1, 0.1, 0, 0.3);
            AddBar(scene, 0, 3, 0, 1, 3, 0, 0.3);
            // Along x or y a flat bar is seen edge-on: it has no fragments, and would be pruned.
            qcDetectDef def = Request((qcMethod)method, "z", 512, 0);
            const qcResult* result = Detect(scene, &def);
            ck_assert_uint_eq(result->profile.objectPcs, 2);
            ck_assert_uint_ge(result->pairCount, 1);
            ck_assert_uint_eq(result->pairs[0].bodyA, 0);
            ck_assert_uint_eq(result->pairs[0].bodyB, 1);
            qcScene_Destroy(scene);
        }
    }
}
END_TEST

START_TEST(neighbours_that_share_an_edge_are_fully_visible_for_self_collision)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcSoup grid = qcSoup_MakeGrid(6);
        for (uint32_t v = 0; v < grid.vertexCount; v++) // a ridge: same depths along shared edges, nothing in front
            grid.positions[3 * v + 2] = fabs(grid.positions[3 * v] - 0.5);
        qcScene* scene = qcMakeScene(device);
        qcAddSoup(scene, &grid);
        qcDetectDef def = Request(qc_methodQuick, "z", 256, 0);
        const qcResult* result = Detect(scene, &def);
        ck_assert_uint_eq(result->profile.trianglePcs, 0);
        ck_assert_uint_eq(result->pcsCount, 0);
        ck_assert_uint_eq(result->profile.selfBodies, 1);
        qcScene_Destroy(scene);
        qcSoup_Free(&grid);
    }
}
END_TEST

START_TEST(triangles_that_cross_within_one_object_are_found)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcSoup soup = qcSoup_MakeRandom(5, 60, 0.5);
        qcScene* scene = qcMakeScene(device);
        qcAddSoup(scene, &soup);
        qcDetectDef exact = qcDefaultDetectDef();
        qcPairList all = qcDetectPairs(scene, &exact);
        qcDetectDef def = Request(qc_methodQuick, "xyz", 1024, 0);
        qcPairList found = qcDetectPairs(scene, &def);
        // Large triangles cross over many pixels.
        ck_assert_uint_gt(all.count, 50);
        ck_assert_uint_gt(found.count, all.count * 9 / 10);
        free(all.pairs);
        free(found.pairs);
        qcScene_Destroy(scene);
        qcSoup_Free(&soup);
    }
}
END_TEST

static int CompareRefs(const void* x, const void* y)
{
    const qcTriangleRef *a = x, *b = y;
    if (a->body != b->body)
        return a->body < b->body ? -1 : 1;
    return a->triangle < b->triangle ? -1 : a->triangle > b->triangle;
}

/// Checks that quick's PCS is a subset of cullide's, and that both report only pairs of brute force.
static void CheckInvariants(qcScene* scene, const char* views, uint32_t resolution, uint32_t iterations)
{
    qcDetectDef brute = qcDefaultDetectDef();
    brute.method = qc_methodBrute;
    qcPairList real = qcDetectPairs(scene, &brute);

    qcDetectDef def = Request(qc_methodCullide, views, resolution, iterations);
    const qcResult* result = Detect(scene, &def);
    size_t cullideCount = result->pcsCount, cullideObjects = result->profile.objectPcs;
    qcTriangleRef* cullide = malloc((cullideCount + 1) * sizeof *cullide);
    if (cullideCount != 0)
        memcpy(cullide, result->pcs, cullideCount * sizeof *cullide);
    for (size_t i = 0; i < result->pairCount; i++)
        ck_assert_ptr_nonnull(bsearch(&result->pairs[i], real.pairs, real.count, sizeof(qcPair), qcComparePairs));

    def.method = qc_methodQuick;
    result = Detect(scene, &def);
    ck_assert_uint_le(result->profile.objectPcs, cullideObjects);
    for (size_t i = 0; i < result->pcsCount; i++)
        ck_assert_ptr_nonnull(bsearch(&result->pcs[i], cullide, cullideCount, sizeof *cullide, CompareRefs));
    for (size_t i = 0; i < result->pairCount; i++)
        ck_assert_ptr_nonnull(bsearch(&result->pairs[i], real.pairs, real.count, sizeof(qcPair), qcComparePairs));
    for (size_t i = 0; i < result->profile.passCount; i++)
    {
        const qcPassRecord* pass = &result->profile.passes[i];
        ck_assert_uint_eq(pass->pcs, pass->ffv + pass->sfv + pass->nfv);
        ck_assert(iterations == 0 || pass->iteration <= iterations);
        if (i > 0 && pass[-1].level == pass->level && pass[-1].body == pass->body)
            ck_assert_uint_le(pass->pcs, pass[-1].pcs);
    }
    free(cullide);
    free(real.pairs);
}

START_TEST(quick_keeps_a_subset_of_cullide_and_reports_only_real_pairs)
{
    const char* const views[] = {"x", "zy", "xyz", "zxy"};
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint64_t seed = 1; seed <= 4; seed++)
        {
            qcScene* scene = qcMakeScene(device);
            qcSoup soup = qcSoup_MakeRandom(seed, 150, 0.08 * (double)seed),
                   cloth = qcSoup_MakeFoldedCloth(seed, 14, 0.02, 0.02);
            qcSoup_Translate(&cloth, 0.0, 0.0, 0.5);
            qcAddSoup(scene, &soup);
            qcAddSoup(scene, &cloth);
            for (uint32_t iterations = 0; iterations < 3; iterations++)
                CheckInvariants(scene, views[(seed + iterations) % 4], iterations == 1 ? 100 : 512, iterations);
            qcScene_Destroy(scene);
            qcSoup_Free(&soup);
            qcSoup_Free(&cloth);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(many_objects_keep_the_invariants_at_both_levels)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcRandom random = {17};
        for (int body = 0; body < 15; body++)
        {
            qcSoup soup = qcSoup_MakeSphere(1, 0.12);
            qcSoup_Translate(&soup, qcRandom_Uniform(&random, 0, 0.7), qcRandom_Uniform(&random, 0, 0.7),
                             qcRandom_Uniform(&random, 0, 0.7));
            qcAddSoup(scene, &soup);
            qcSoup_Free(&soup);
        }
        CheckInvariants(scene, "xyz", 512, 0);
        CheckInvariants(scene, "zx", 256, 1);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(without_gl_the_sweep_runs_and_the_profile_names_it)
{
    qcDeviceDef deviceDef = qcDefaultDeviceDef();
    deviceDef.kind = qc_deviceNone;
    qcDevice* none = NULL;
    CHECK_OK(qcDevice_Create(&deviceDef, &none));
    qcDevice* const devices[] = {none, NULL};
    qcSoup soup = qcSoup_MakeRandom(5, 200, 0.3);
    for (int i = 0; i < 2; i++)
    {
        qcScene* scene = qcMakeScene(devices[i]);
        qcAddSoup(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        qcPairList expected = qcDetectPairs(scene, &def);
        def.method = qc_methodQuick;
        qcPairList found = qcDetectPairs(scene, &def);
        qcCheckSamePairs(&expected, &found, "quick without GL");
        const qcResult* result = Detect(scene, &def);
        ck_assert_int_eq(result->profile.method, qc_methodSweep);
        ck_assert_ptr_nonnull(strstr(result->profile.fallback, "no GL"));
        ck_assert_str_eq(result->profile.device, "none");
        free(expected.pairs);
        free(found.pairs);
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcDevice_Destroy(none);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(two_scenes_share_one_device)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene *first = qcMakeScene(device), *second = qcMakeScene(device);
        AddCycle(first);
        AddCycle(second);
        qcDetectDef def = Request(qc_methodQuick, "z", 128, 0);
        ck_assert_uint_eq(Detect(first, &def)->profile.objectPcs, 0);
        ck_assert_uint_eq(Detect(second, &def)->profile.objectPcs, 0);
        qcScene_Destroy(first);
        qcScene_Destroy(second);
    }
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("visibility culling", the_nearer_of_two_objects_is_pruned_in_the_first_view,
                        objects_side_by_side_are_pruned_in_the_first_view, quick_prunes_a_cycle_that_stops_cullide,
                        a_pair_inside_one_collision_free_set_is_not_swept, sets_save_queries_and_renders,
                        crossing_objects_stay_and_their_pair_is_found,
                        neighbours_that_share_an_edge_are_fully_visible_for_self_collision,
                        triangles_that_cross_within_one_object_are_found,
                        quick_keeps_a_subset_of_cullide_and_reports_only_real_pairs,
                        many_objects_keep_the_invariants_at_both_levels,
                        without_gl_the_sweep_runs_and_the_profile_names_it, two_scenes_share_one_device)
