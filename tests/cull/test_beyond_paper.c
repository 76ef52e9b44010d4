// quick and cullide with the switches beyond the paper: what each prunes, and that reliable culling finds
// the pairs of the sweep at any resolution, in any order, from both sides, along any views.
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

static void AddWithout(qcScene* scene, const qcSoup* soup, bool selfCollision)
{
    qcBodyDef def = qcBodyDefOf(soup);
    def.selfCollision = selfCollision;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
}

//  ---- order and side ------------------------------------------------------------------------------

enum
{
    qc_stackSize = 6
};

/// Flat sheets above each other along z, in order of the view or against it, moved a little so that each sticks out.
static void AddStack(qcScene* scene, bool nearestFirst)
{
    for (int i = 0; i < qc_stackSize; i++)
    {
        qcSoup sheet = qcSoup_MakeGrid(3);
        double z = 0.1 * (nearestFirst ? i : qc_stackSize - 1 - i);
        qcSoup_Translate(&sheet, 0.3 * z, 0.2 * z, z);
        AddWithout(scene, &sheet, false);
        qcSoup_Free(&sheet);
    }
}

/// Number of bodies in the PCS after one round.
static uint32_t CountLeft(qcScene* scene, qcMethod method, const char* views, bool backToFront, bool fromBack)
{
    qcDetectDef def = Request(method, views, 256, 1);
    def.backToFront = backToFront;
    def.secondPassFromBack = fromBack;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_int_eq(result->profile.method, method);
    return result->profile.objectPcs;
}

START_TEST(back_to_front_one_round_prunes_a_stack_in_any_order)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (int nearestFirst = 0; nearestFirst < 2; nearestFirst++)
        {
            qcScene* scene = qcMakeScene(device);
            AddStack(scene, nearestFirst == 1);
            // In the order of their numbers: the farthest is first by chance, or all but the nearest remain.
            ck_assert_uint_eq(CountLeft(scene, qc_methodQuick, "z", false, false), nearestFirst ? qc_stackSize - 1 : 0);
            ck_assert_uint_eq(CountLeft(scene, qc_methodQuick, "z", true, false), 0);
            // CULLIDE renders all in both passes: only the nearest is visible in both.
            ck_assert_uint_eq(CountLeft(scene, qc_methodCullide, "z", true, false), qc_stackSize - 1);
            qcScene_Destroy(scene);
        }
    }
}
END_TEST

START_TEST(a_second_pass_from_the_back_prunes_primitives_fully_behind)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddStack(scene, false);
        ck_assert_uint_eq(CountLeft(scene, qc_methodCullide, "z", false, true), 0);
        qcScene_Destroy(scene);
        scene = qcMakeScene(device);
        AddStack(scene, true);
        // Nearest first: apart from the ends of the stack, no sheet has another one in front of it among those before
        // it, nor behind it among those after it.
        ck_assert_uint_eq(CountLeft(scene, qc_methodCullide, "z", false, true), qc_stackSize);
        ck_assert_uint_eq(CountLeft(scene, qc_methodCullide, "z", true, true), 0);
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(each_view_has_its_own_order)
{
    static const int numbers[qc_stackSize] = {2, 0, 4, 1, 5, 3};
    QC_FOR_EACH_DEVICE(device)
    {
        for (int method = qc_methodCullide; method <= qc_methodQuick; method++)
        {
            // Sheets that rise along x: they hide each other along x too, where all are equally far on average.
            qcScene* scene = qcMakeScene(device);
            for (int i = 0; i < qc_stackSize; i++)
            {
                qcSoup sheet = qcSoup_MakeGrid(3);
                for (uint32_t v = 0; v < sheet.vertexCount; v++)
                    sheet.positions[3 * v + 2] = sheet.positions[3 * v] + 0.1 * numbers[i];
                AddWithout(scene, &sheet, false);
                qcSoup_Free(&sheet);
            }
            ck_assert_uint_gt(CountLeft(scene, (qcMethod)method, "x", true, true), 0);
            ck_assert_uint_eq(CountLeft(scene, (qcMethod)method, "xz", true, true), 0);
            qcScene_Destroy(scene);
        }
    }
}
END_TEST

//  ---- nothing is missed ---------------------------------------------------------------------------

typedef void AddBodies(qcScene* scene, uint64_t seed);

static void AddSoups(qcScene* scene, uint64_t seed)
{
    for (uint64_t body = 0; body < 3; body++)
    {
        qcSoup soup = qcSoup_MakeRandom(10 * seed + body, 120, 0.06 * (double)(seed % 4 + 1));
        AddWithout(scene, &soup, body == 0);
        qcSoup_Free(&soup);
    }
}

static void AddDegenerate(qcScene* scene, uint64_t seed)
{
    for (uint64_t body = 0; body < 3; body++)
    {
        qcSoup soup = qcSoup_MakeDegenerate(10 * seed + body, 150, 0.1, 0.6);
        AddWithout(scene, &soup, body == 0);
        qcSoup_Free(&soup);
    }
}

/// Waves that cross by a little, next to a self-intersecting mesh.
static void AddWaves(qcScene* scene, uint64_t seed)
{
    double depth = pow(10.0, -(double)(seed % 5) - 1.0);
    for (int body = 0; body < 3; body++)
    {
        qcSoup sheet = qcSoup_MakeGrid(body == 2 ? 9 : 12);
        for (uint32_t v = 0; v < sheet.vertexCount; v++)
        {
            double *p = sheet.positions + 3 * v, x = p[0], y = p[1];
            p[2] = 0.1 * sin(7.0 * x + 3.0 * y) + 0.3 * x + body * depth * (0.5 + sin(31.0 * x + 17.0 * y));
        }
        AddWithout(scene, &sheet, false);
        qcSoup_Free(&sheet);
    }
    qcSoup cloth = qcSoup_MakeFoldedCloth(seed, 10, 0.02, 0.02);
    qcAddSoup(scene, &cloth);
    qcSoup_Free(&cloth);
}

/// Tilted sheets a small gap apart: no pair intersects.
static void AddSheets(qcScene* scene, uint64_t seed)
{
    double gap = pow(10.0, -(double)(seed % 6) / 2.0 - 0.5);
    for (int body = 0; body < 4; body++)
    {
        qcSoup sheet = qcSoup_MakeGrid(9);
        for (uint32_t v = 0; v < sheet.vertexCount; v++)
            sheet.positions[3 * v + 2] =
                0.3 * sheet.positions[3 * v] - 0.7 * sheet.positions[3 * v + 1] + (body * 7 % 4) * gap;
        AddWithout(scene, &sheet, false);
        qcSoup_Free(&sheet);
    }
}

/// Small triangles: at 4096 pixels each covers a few. Every other one crosses one of the other body.
static void AddSparks(qcScene* scene, uint64_t seed)
{
    qcSoup soups[2] = {qcSoup_MakeRandom(2 * seed, 60, 4e-4), qcSoup_MakeRandom(2 * seed + 1, 60, 4e-4)};
    qcRandom random = {seed};
    for (uint32_t t = 0; t < 60; t++)
    {
        double place[3];
        for (int body = 0; body < 2; body++)
        {
            for (int axis = 0; axis < 3 && (body == 0 || t % 2 == 0); axis++)
                place[axis] = qcRandom_Uniform(&random, 0.0, 1.0);
            double corners[3][3];
            qcSoup_GetTriangle(&soups[body], t, corners);
            for (int i = 0; i < 9; i++)
                soups[body].positions[3 * soups[body].indices[3 * t + (uint32_t)i / 3] + (uint32_t)i % 3] +=
                    place[i % 3] - (corners[0][i % 3] + corners[1][i % 3] + corners[2][i % 3]) / 3.0;
        }
    }
    for (int body = 0; body < 2; body++)
    {
        AddWithout(scene, &soups[body], false);
        qcSoup_Free(&soups[body]);
    }
}

/// A heap of spheres. For some seeds, some are flattened and seen edge-on, far away or tiny.
static void AddHeap(qcScene* scene, uint64_t seed)
{
    static const double scales[] = {1.0, 1e-30, 1e30, 1e-300}, offsets[] = {0.0, 1e7, -3e6};
    double scale = scales[seed % 4], offset = seed % 4 == 0 ? offsets[seed / 4 % 3] : 0.0;
    qcRandom random = {seed};
    for (int body = 0; body < 14; body++)
    {
        qcSoup soup = qcSoup_MakeSphere(1, 0.16);
        int flat = body % 5;
        double place[3];
        for (int axis = 0; axis < 3; axis++)
            place[axis] = qcRandom_Uniform(&random, 0.0, 0.7);
        for (uint32_t i = 0; i < 3 * soup.vertexCount; i++)
        {
            double local = (int)(i % 3) == flat ? 0.0 : soup.positions[i];
            soup.positions[i] = scale * (local + place[i % 3]) + offset;
        }
        AddWithout(scene, &soup, body % 4 == 0);
        qcSoup_Free(&soup);
    }
}

static AddBodies* const s_scenes[] = {AddSoups, AddDegenerate, AddWaves, AddSheets, AddSparks, AddHeap};

enum
{
    qc_sceneCount = sizeof s_scenes / sizeof s_scenes[0]
};

typedef struct Tally
{
    size_t culled; ///< triangles that reliable culling removed from the PCS
    size_t pairs;  ///< all pairs, found by reliable culling
    size_t missed; ///< pairs missed by the same culling without `reliable`
} Tally;

/// Random switches, views and resolution: the pairs are those of the sweep.
static void CheckReliable(qcScene* scene, qcRandom* random, double margin, Tally* tally)
{
    static const char* const s_views[] = {"z", "x", "yz", "xyz", "zxy"};
    static const uint32_t s_resolutions[] = {1, 16, 100, 200, 350, 512};
    qcDetectDef def =
        Request(qcRandom_Below(random, 4) == 0 ? qc_methodCullide : qc_methodQuick, s_views[qcRandom_Below(random, 5)],
                s_resolutions[qcRandom_Below(random, 6)], qcRandom_Below(random, 3));
    def.backToFront = qcRandom_Below(random, 2) == 0;
    def.secondPassFromBack = qcRandom_Below(random, 2) == 0;
    def.touching = qcRandom_Below(random, 2) == 0;
    def.neighbours = qcRandom_Below(random, 4) == 0;
    def.margin = margin;
    qcDetectDef sweep = def;
    sweep.method = qc_methodSweep;
    qcPairList expected = qcDetectPairs(scene, &sweep);
    tally->pairs += expected.count;

    def.reliable = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_int_eq(result->profile.method, def.method);
    tally->culled += result->profile.triangles - result->profile.trianglePcs;
    qcPairList found = {(qcPair*)result->pairs, result->pairCount};
    char what[128];
    snprintf(what, sizeof what, "%s %s, %u pixels, %u rounds, order %d, side %d", qcMethod_Name(def.method), def.views,
             def.resolution, def.iterations, def.backToFront, def.secondPassFromBack);
    qcCheckSamePairs(&expected, &found, what);

    if (margin == 0.0)
    {
        def.reliable = false;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_le(result->pairCount, expected.count);
        tally->missed += expected.count - result->pairCount;
        for (size_t i = 0; i < result->pairCount; i++)
            ck_assert_ptr_nonnull(
                bsearch(&result->pairs[i], expected.pairs, expected.count, sizeof(qcPair), qcComparePairs));
    }
    free(expected.pairs);
}

START_TEST(reliable_culling_finds_all_pairs_of_the_sweep_and_no_other)
{
    QC_FOR_EACH_DEVICE(device)
    {
        Tally tally[qc_sceneCount] = {{0, 0, 0}};
        qcRandom random = {61};
        for (uint64_t seed = 0; seed < 24; seed++)
        {
            qcScene* scene = qcMakeScene(device);
            s_scenes[seed % qc_sceneCount](scene, seed);
            CheckReliable(scene, &random, 0.0, &tally[seed % qc_sceneCount]);
            qcScene_Destroy(scene);
        }
        // The scenes exercise reliable culling: triangles are culled, and sampled culling misses pairs.
        size_t culled = 0;
        for (int scene = 0; scene < qc_sceneCount; scene++)
        {
            culled += tally[scene].culled;
            ck_assert(s_scenes[scene] == AddSheets || (tally[scene].pairs > 50 && tally[scene].missed > 20));
        }
        ck_assert_uint_gt(culled, 2000);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(reliable_culling_finds_all_pairs_within_the_margin)
{
    QC_FOR_EACH_DEVICE(device)
    {
        Tally tally = {0, 0, 0};
        qcRandom random = {67};
        for (uint64_t seed = 0; seed < 12; seed++)
        {
            static const double s_scales[] = {1.0, 1e-30, 1e30, 1e-300};
            double scale = s_scenes[seed % qc_sceneCount] == AddHeap ? s_scales[seed % 4] : 1.0;
            qcScene* scene = qcMakeScene(device);
            s_scenes[seed % qc_sceneCount](scene, seed);
            CheckReliable(scene, &random, scale * pow(10.0, qcRandom_Uniform(&random, -6.0, -1.0)), &tally);
            qcScene_Destroy(scene);
        }
        ck_assert_uint_gt(tally.culled, 200);
        ck_assert_uint_gt(tally.pairs, 5000);
    }
}
END_TEST

START_TEST(reliable_culling_finds_pairs_between_the_samples_at_every_resolution)
{
    QC_FOR_EACH_DEVICE(device)
    {
        for (uint32_t resolution = 256; resolution <= 4096; resolution *= 4)
        {
            qcScene* scene = qcMakeScene(device);
            AddSparks(scene, 3);
            qcDetectDef def = Request(qc_methodSweep, "z", resolution, 1);
            qcPairList expected = qcDetectPairs(scene, &def);
            def.method = qc_methodQuick;
            qcPairList sampled = qcDetectPairs(scene, &def);
            ck_assert_uint_gt(expected.count, sampled.count + 10);
            free(sampled.pairs);
            def.reliable = true;
            qcPairList found = qcDetectPairs(scene, &def);
            qcCheckSamePairs(&expected, &found, "sparks");
            ck_assert_uint_gt(expected.count, 20);
            free(expected.pairs);
            free(found.pairs);
            qcScene_Destroy(scene);
        }
    }
}
END_TEST

START_TEST(reliable_culling_leaves_self_collision_to_the_sweep)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcSoup cloth = qcSoup_MakeFoldedCloth(5, 12, 0.02, 0.02);
        qcAddSoup(scene, &cloth);
        qcDetectDef def = Request(qc_methodQuick, "xyz", 256, 0);
        def.reliable = true;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->profile.trianglePcs, cloth.triangleCount);
        ck_assert_uint_eq(result->profile.passCount, 0);
        ck_assert_uint_gt(result->pairCount, 10);
        qcScene_Destroy(scene);
        qcSoup_Free(&cloth);
    }
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("beyond_paper", back_to_front_one_round_prunes_a_stack_in_any_order,
                        a_second_pass_from_the_back_prunes_primitives_fully_behind, each_view_has_its_own_order,
                        reliable_culling_finds_all_pairs_of_the_sweep_and_no_other,
                        reliable_culling_finds_all_pairs_within_the_margin,
                        reliable_culling_finds_pairs_between_the_samples_at_every_resolution,
                        reliable_culling_leaves_self_collision_to_the_sweep)
