// Positions given as floats, kept as floats between steps of a device and between sweeps: no request reads older ones.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>

enum
{
    qc_steps = 60,
    qc_bodies = 2
};

/// Two cloths in two scenes: floats, mostly on a device, and the same positions in double without one.
typedef struct Worlds
{
    qcScene *floats, *doubles;
    qcBodyId ids[2][qc_bodies];
    qcSoup soups[qc_bodies];
    qcMethod reference; ///< by which the latter finds its pairs
    qcRandom random;
} Worlds;

/// The second cloth lies `shift` beside the first.
static Worlds MakeWorlds(qcDevice* device, uint64_t seed, uint32_t side, double noise, double shift)
{
    Worlds w = {.floats = qcMakeScene(device),
                .doubles = qcMakeScene(NULL),
                .reference = device != NULL ? qc_methodSweep : qc_methodBrute,
                .random = {seed}};
    for (int i = 0; i < qc_bodies; i++)
    {
        w.soups[i] = qcSoup_MakeFoldedCloth(seed + (uint64_t)i, side, 0.02, noise);
        qcSoup_Translate(&w.soups[i], shift * i, 0.1 * i, 0.03 * i);
        qcSoup_RoundToFloat(&w.soups[i]);
        qcBodyDef def = qcBodyDefOf(&w.soups[i]);
        def.deforming = true;
        CHECK_OK(qcScene_AddBody(w.floats, &def, &w.ids[0][i]));
        CHECK_OK(qcScene_AddBody(w.doubles, &def, &w.ids[1][i]));
    }
    return w;
}

static void EndWorlds(Worlds* w)
{
    qcScene_Destroy(w->floats);
    qcScene_Destroy(w->doubles);
    for (int i = 0; i < qc_bodies; i++)
        qcSoup_Free(&w->soups[i]);
}

/// The soup's positions as floats, `width` of them for each vertex. The caller frees them.
static float* FloatsOf(const qcSoup* soup, size_t width)
{
    float* floats = malloc((size_t)soup->vertexCount * width * sizeof(float));
    for (size_t v = 0; v < soup->vertexCount; v++)
        for (size_t k = 0; k < width; k++)
            floats[width * v + k] = k < 3 ? (float)soup->positions[3 * v + k] : NAN;
    return floats;
}

/// New positions of a body in both scenes; before them, now and then, positions that are refused.
static void MoveBody(Worlds* w, int body)
{
    qcSoup* soup = &w->soups[body];
    // Now and then few vertices move, which a Verlet list follows.
    size_t count = 3 * (size_t)soup->vertexCount;
    count = qcRandom_Below(&w->random, 3) == 0 ? count / 20 : count;
    for (size_t i = 0; i < count; i++)
        soup->positions[i] += qcRandom_Uniform(&w->random, -0.002, 0.002);
    qcSoup_RoundToFloat(soup);
    size_t width = 3 + qcRandom_Below(&w->random, 3);
    float* floats = FloatsOf(soup, width);
    if (qcRandom_Below(&w->random, 4) == 0)
    {
        static const float bads[] = {NAN, INFINITY, -INFINITY};
        const uint32_t vertex = qcRandom_Below(&w->random, soup->vertexCount);
        size_t bad = width * vertex + qcRandom_Below(&w->random, 3);
        float good = floats[bad];
        char expected[64];
        floats[bad] = bads[qcRandom_Below(&w->random, 3)];
        ck_assert_int_eq(qcScene_SetVertices(w->floats, w->ids[0][body], floats, qc_positionF32, width * sizeof(float)),
                         qc_statusBadInput);
        snprintf(expected, sizeof expected, "vertex %u of body %u is not finite", vertex, w->ids[0][body].slot);
        ck_assert_str_eq(qcLastMessage(), expected);
        floats[bad] = good;
    }
    if (qcRandom_Below(&w->random, 5) == 0)
        CHECK_OK(qcScene_SetVertices(w->floats, w->ids[0][body], soup->positions, qc_positionF64, 0));
    else
        CHECK_OK(qcScene_SetVertices(w->floats, w->ids[0][body], floats, qc_positionF32, width * sizeof(float)));
    CHECK_OK(qcScene_SetVertices(w->doubles, w->ids[1][body], soup->positions, qc_positionF64, 0));
    free(floats);
}

/// Mostly `layers` alone; requests that read other positions between.
static qcDetectDef ChooseRequest(qcRandom* random)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodLayers;
    def.threads = 1 + qcRandom_Below(random, 2);
    switch (qcRandom_Below(random, 9))
    {
        case 0: def.method = qc_methodSweep; break;
        case 1: def.contactMargin = 0.004; break;
        case 2: def.manifolds = def.proximities = true; break;
        case 3: def.motion = true; break;
        case 4: def.segments = def.touching = true; break;
        case 5: def.margin = 0.003; break;
        default: break;
    }
    return def;
}

/// Mostly the sweep, of bodies with self-collision and without; other requests between.
static qcDetectDef ChooseSweep(Worlds* w)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qcRandom_Below(&w->random, 10) == 0 ? qc_methodBrute : qc_methodSweep;
    def.threads = 1 + qcRandom_Below(&w->random, 2);
    switch (qcRandom_Below(&w->random, 9))
    {
        case 0: def.contactMargin = 0.004; break;
        case 1: def.manifolds = def.proximities = true; break;
        case 2:
        case 3: def.motion = true; break;
        case 4: def.margin = 0.006; break;
        case 5: def.margin = 0.002; break;
        default: break;
    }
    qcScene* scenes[] = {w->floats, w->doubles};
    for (int body = 0; body < qc_bodies; body++)
    {
        bool changes = qcRandom_Below(&w->random, 4) == 0, self = qcRandom_Below(&w->random, 3) == 0;
        bool sleeps = qcRandom_Below(&w->random, 4) == 0;
        for (int i = 0; i < 2 && changes; i++)
        {
            CHECK_OK(qcScene_SetSelfCollision(scenes[i], w->ids[i][body], self));
            CHECK_OK(qcScene_SetActivity(scenes[i], w->ids[i][body], sleeps ? qc_activitySleeping : qc_activityMoving));
        }
    }
    return def;
}

static size_t CompareResults(const Worlds* w, qcDetectDef def, int step)
{
    const qcResult *found, *expected;
    CHECK_OK(qcScene_Detect(w->floats, &def, &found));
    def.method = w->reference;
    CHECK_OK(qcScene_Detect(w->doubles, &def, &expected));
    qcResultHash a = qcResult_Hash(found), b = qcResult_Hash(expected);
    ck_assert_msg(memcmp(&a, &b, sizeof a) == 0, "step %d: %zu pairs, expected %zu", step, found->pairCount,
                  expected->pairCount);
    return found->pairCount;
}

static qcDetectDef ChooseNext(Worlds* w, qcDevice* device)
{
    return device != NULL ? ChooseRequest(&w->random) : ChooseSweep(w);
}

/// Returns the number of pairs found.
static size_t CheckSteps(qcDevice* device, uint64_t seed, uint32_t side, double noise, double shift, int steps)
{
    Worlds w = MakeWorlds(device, seed, side, noise, shift);
    size_t pairs = 0;
    for (int step = 0; step < steps; step++)
    {
        if (qcRandom_Below(&w.random, 8) == 0)
        {
            CHECK_OK(qcScene_MarkStart(w.floats));
            CHECK_OK(qcScene_MarkStart(w.doubles));
        }
        for (int body = 0; body < qc_bodies; body++)
            if (qcRandom_Below(&w.random, 5) != 0)
                MoveBody(&w, body);
        pairs += CompareResults(&w, ChooseNext(&w, device), step);
        // Another request without new positions.
        if (qcRandom_Below(&w.random, 3) == 0)
            pairs += CompareResults(&w, ChooseNext(&w, device), step);
    }
    EndWorlds(&w);
    return pairs;
}

START_TEST(floats_give_the_pairs_of_doubles_whatever_is_requested_of_them)
{
    for (qcDeviceWalk walk = {0}; qcDeviceWalk_Next(&walk);)
        ck_assert_uint_gt(CheckSteps(walk.device, 7, 24, 0.012, 0.0, qc_steps), qc_steps);
}
END_TEST

START_TEST(few_candidates_in_floats_give_the_pairs_of_doubles)
{
    for (qcDeviceWalk walk = {0}; qcDeviceWalk_Next(&walk);)
        ck_assert_uint_gt(CheckSteps(walk.device, 5, 48, 0.002, 0.0, 12), 0);
}
END_TEST

START_TEST(many_candidates_in_floats_give_the_pairs_of_doubles)
{
    for (qcDeviceWalk walk = {0}; qcDeviceWalk_Next(&walk);)
        ck_assert_uint_gt(CheckSteps(walk.device, 11, 24, 0.04, 0.0, qc_steps), qc_steps);
}
END_TEST

START_TEST(floats_of_the_sweep_give_the_pairs_of_brute_force_whatever_is_requested_of_them)
{
    // Side by side few leaf nodes meet, on top of each other most of them.
    for (uint64_t seed = 0; seed < 6; seed++)
        ck_assert_uint_gt(CheckSteps(NULL, seed, 16, 0.012, seed % 3 == 0 ? 0.0 : 0.9, 2 * qc_steps), qc_steps);
}
END_TEST

static void SetActivity(const Worlds* w, qcActivity activity)
{
    for (int body = 0; body < qc_bodies; body++)
    {
        CHECK_OK(qcScene_SetActivity(w->floats, w->ids[0][body], activity));
        CHECK_OK(qcScene_SetActivity(w->doubles, w->ids[1][body], activity));
    }
}

/// Few vertices of a body move far, in floats.
static void MoveFew(Worlds* w, int body)
{
    qcSoup* soup = &w->soups[body];
    for (size_t i = 0; i < 30; i++)
        soup->positions[3 * qcRandom_Below(&w->random, soup->vertexCount) + 1] +=
            qcRandom_Uniform(&w->random, 0.0, 0.1);
    qcSoup_RoundToFloat(soup);
    float* floats = FloatsOf(soup, 3);
    CHECK_OK(qcScene_SetVertices(w->floats, w->ids[0][body], floats, qc_positionF32, 0));
    CHECK_OK(qcScene_SetVertices(w->doubles, w->ids[1][body], soup->positions, qc_positionF64, 0));
    free(floats);
}

START_TEST(a_verlet_list_does_not_follow_floats)
{
    Worlds w = MakeWorlds(NULL, 3, 24, 0.012, 0.0);
    qcDetectDef wide = qcDefaultDetectDef(), plain = wide;
    wide.method = plain.method = qc_methodSweep;
    wide.margin = 0.006;
    for (int round = 0; round < 8; round++)
    {
        MoveFew(&w, 0);
        // A list is filled; the bodies sleep, so that their next floats are kept; then they could follow the list.
        CompareResults(&w, wide, round);
        SetActivity(&w, qc_activitySleeping);
        CompareResults(&w, wide, round);
        SetActivity(&w, qc_activityMoving);
        MoveFew(&w, 0);
        CompareResults(&w, plain, round);
    }
    EndWorlds(&w);
}
END_TEST

enum
{
    qc_smallSteps = 6
};

/// A scene of small bodies with these triangles, of which the last moves across the first in some steps.
static void CheckSmall(int bodyCount, int trianglesOfEach)
{
    const uint32_t indices[] = {0, 1, 2, 3, 4, 5};
    const float first[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, apart[9] = {9, 9, -1, 9, 9, 1, 9, 8, 0};
    const float across[9] = {0.2f, 0.2f, -1, 0.2f, 0.2f, 1, 0.2f, 0.1f, 0};
    float positions[18];
    memcpy(positions, first, sizeof first);
    memcpy(positions + 9, apart, sizeof apart);
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId id = {0};
    for (int i = 0; i < bodyCount; i++)
    {
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = positions + (bodyCount == 2 ? 9 * i : 0);
        def.vertexCount = 3 * (uint32_t)trianglesOfEach;
        def.indices = indices;
        def.triangleCount = (uint32_t)trianglesOfEach;
        def.deforming = true;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    const qcResult* result;
    for (int step = 0; step < qc_smallSteps; step++)
    {
        bool meets = step == 3 || step == 5;
        memcpy(positions + 9, meets ? across : apart, sizeof apart);
        CHECK_OK(qcScene_SetVertices(scene, id, positions + (bodyCount == 2 ? 9 : 0), qc_positionF32, 0));
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, meets);
        // Without self-collision it has no pairs, and its floats are kept.
        CHECK_OK(qcScene_SetSelfCollision(scene, id, step % 2 == 0));
    }
    qcScene_Destroy(scene);
}

START_TEST(floats_of_bodies_without_a_bvh_give_their_pairs)
{
    CheckSmall(2, 1);
    CheckSmall(1, 2);
}
END_TEST

QC_RUN_TESTS("float positions", floats_give_the_pairs_of_doubles_whatever_is_requested_of_them,
             few_candidates_in_floats_give_the_pairs_of_doubles, many_candidates_in_floats_give_the_pairs_of_doubles,
             floats_of_the_sweep_give_the_pairs_of_brute_force_whatever_is_requested_of_them,
             a_verlet_list_does_not_follow_floats, floats_of_bodies_without_a_bvh_give_their_pairs)
