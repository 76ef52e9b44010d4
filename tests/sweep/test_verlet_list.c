// After few vertices have moved, pairs come from the Verlet list: they equal those of brute force.
#include "support/long_form.h"
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"

enum
{
    qc_rounds = 40
};

/// Cloths of 800 triangles for brute force, or of 2048.
static uint32_t GetSide(void)
{
    return qcIsLongForm() ? 32 : 20;
}

/// A cloth of the scene.
typedef struct Cloth
{
    qcSoup soup;
    qcBodyId id;
    double* first; ///< reference positions
} Cloth;

static Cloth AddCloth(qcScene* scene, uint64_t seed, double z, double away)
{
    Cloth cloth = {.soup = qcSoup_MakeFoldedCloth(seed, GetSide(), 0.01, 0.004)};
    qcSoup_Translate(&cloth.soup, away, away, z + away);
    qcBodyDef def = qcBodyDefOf(&cloth.soup);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, &cloth.id));
    cloth.first = malloc(3 * sizeof(double) * cloth.soup.vertexCount);
    ck_assert_ptr_nonnull(cloth.first);
    return cloth;
}

static void FreeCloth(Cloth* cloth)
{
    qcSoup_Free(&cloth->soup);
    free(cloth->first);
}

static void SetReference(Cloth* cloth)
{
    memcpy(cloth->first, cloth->soup.positions, 3 * sizeof(double) * cloth->soup.vertexCount);
}

/// Some vertices move, most of them a little; others move back.
static void MoveSome(Cloth* cloth, qcRandom* random, uint32_t count, double motion)
{
    for (uint32_t i = 0; i < count; i++)
    {
        size_t at = 3 * (size_t)qcRandom_Below(random, cloth->soup.vertexCount);
        bool back = qcRandom_Below(random, 4) == 0, far = qcRandom_Below(random, 8) == 0;
        for (int axis = 0; axis < 3; axis++)
            cloth->soup.positions[at + (size_t)axis] =
                cloth->first[at + (size_t)axis] +
                (back ? 0.0 : (far ? 8.0 : 1.0) * motion * qcRandom_Uniform(random, -1.0, 1.0));
    }
}

static void Move(qcScene* scene, Cloth* cloth, qcRandom* random, uint32_t count, double motion)
{
    MoveSome(cloth, random, count, motion);
    CHECK_OK(qcScene_SetVertices(scene, cloth->id, cloth->soup.positions, qc_positionF64, 0));
}

static qcProfile Detect(qcScene* scene, qcDetectDef def, qcMethod method, uint64_t* hash)
{
    const qcResult* result;
    def.method = method;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    *hash = 1;
    for (size_t i = 0; i < result->pairCount; i++)
    {
        const qcPair* p = &result->pairs[i];
        const uint32_t words[5] = {p->bodyA, p->triangleA, p->bodyB, p->triangleB, (uint32_t)p->relation};
        for (int k = 0; k < 5; k++)
            *hash = (*hash ^ words[k]) * UINT64_C(0x100000001b3);
    }
    return result->profile;
}

/// Compares with brute force; returns the number of pairs.
static uint64_t Check(qcScene* scene, qcDetectDef def, int round, qcProfile* profile)
{
    uint64_t hash, expected;
    *profile = Detect(scene, def, qc_methodSweep, &hash);
    qcProfile brute = Detect(scene, def, qc_methodBrute, &expected);
    CHECK_THAT(profile->pairs == brute.pairs && hash == expected,
               "round %d, margin %g: %u pairs, and by brute force %u", round, def.margin, (unsigned)profile->pairs,
               (unsigned)brute.pairs);
    return brute.pairs;
}

/// Fills the list with contacts within `listMargin`, then detects pairs within `margin` several times while vertices
/// move by about `motion`, at distance `away` from the origin.
static void CheckSceneAway(double away, uint64_t seed, int clothCount, double listMargin, double margin, double motion,
                           bool mustRefit)
{
    qcScene* scene = qcMakeScene(NULL);
    qcRandom random = {seed};
    Cloth cloths[2];
    for (int i = 0; i < clothCount; i++)
        cloths[i] = AddCloth(scene, seed + (uint64_t)i, 0.004 * i, away);
    qcDetectDef listDef = qcDefaultDetectDef(), def = qcDefaultDetectDef();
    listDef.contactMargin = listMargin;
    def.margin = margin;
    uint64_t pairs = 0, followed = 0, triangles = 0;
    for (int round = 0; round < qc_rounds; round++)
    {
        qcProfile profile;
        listDef.threads = def.threads = 1 + (uint32_t)round % 3;
        if (round % 5 == 0)
        {
            for (int i = 0; i < clothCount; i++)
                SetReference(&cloths[i]);
            (void)Check(scene, listDef, round, &profile);
            ck_assert_uint_eq(profile.followedTriangles, 0);
        }
        for (int i = 0; i < clothCount; i++)
            if (qcRandom_Below(&random, 4) != 0)
                Move(scene, &cloths[i], &random, 1 + qcRandom_Below(&random, cloths[i].soup.vertexCount / 18), motion);
        def.touching = round % 2 == 0;
        pairs += Check(scene, def, round, &profile);
        followed += profile.followedTriangles;
        triangles += (uint64_t)clothCount * cloths[0].soup.triangleCount;
    }
    ck_assert_uint_gt(pairs, 100);
    if (mustRefit)
        ck_assert_uint_gt(followed, triangles / 2);
    for (int i = 0; i < clothCount; i++)
        FreeCloth(&cloths[i]);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static void CheckScene(uint64_t seed, int clothCount, double listMargin, double margin, double motion, bool mustRefit)
{
    CheckSceneAway(0.0, seed, clothCount, listMargin, margin, motion, mustRefit);
}

START_TEST(small_motion_is_refitted_partially)
{
    for (uint64_t seed = 1; seed <= 4; seed++)
        CheckScene(seed, 1, 0.006, 0.0, 0.0015, true);
}
END_TEST

START_TEST(large_motion_loses_no_pair)
{
    for (uint64_t seed = 1; seed <= 4; seed++)
        CheckScene(seed, 1, 0.004, 0.0, 0.006, false);
}
END_TEST

START_TEST(a_list_serves_smaller_margins)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
        CheckScene(seed, 1, 0.008, 0.003, 0.0015, true);
}
END_TEST

START_TEST(partially_refitted_bodies_have_pairs_at_their_current_positions)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
    {
        CheckScene(seed, 2, 0.006, 0.0, 0.002, true);
        CheckScene(seed, 2, 0.008, 0.002, 0.004, false);
    }
}
END_TEST

START_TEST(no_pair_is_lost_far_from_the_origin_where_margins_are_rounded)
{
    // There the coordinates are multiples of 2^-9. The list's margin is not; two of the margins are.
    const double margin[] = {0.0, 0x1p-9, 0.003};
    for (uint64_t seed = 1; seed <= 3; seed++)
        CheckSceneAway(0x1.4p43, seed, 1, 0.0067, margin[seed - 1], 0.01, false);
}
END_TEST

/// A cloth with a Verlet list.
static qcScene* MakeWithList(Cloth* cloth)
{
    qcScene* scene = qcMakeScene(NULL);
    *cloth = AddCloth(scene, 3, 0.0, 0.0);
    SetReference(cloth);
    qcDetectDef def = qcDefaultDetectDef();
    def.contactMargin = 0.006;
    qcProfile profile;
    (void)Check(scene, def, 0, &profile);
    return scene;
}

static void EndWithList(qcScene* scene, Cloth* cloth)
{
    FreeCloth(cloth);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(a_body_is_fitted_anew_if_much_of_it_moved_or_left_its_box)
{
    for (int kind = 0; kind < 2; kind++)
    {
        Cloth cloth;
        qcScene* scene = MakeWithList(&cloth);
        qcDetectDef def = qcDefaultDetectDef();
        if (kind == 0)
            for (uint32_t v = 0; v < cloth.soup.vertexCount / 2; v++)
                cloth.soup.positions[3 * (size_t)v] += 1e-5;
        else
            cloth.soup.positions[3 * 77 + 1] += 5.0;
        CHECK_OK(qcScene_SetVertices(scene, cloth.id, cloth.soup.positions, qc_positionF64, 0));
        qcProfile profile;
        (void)Check(scene, def, kind, &profile);
        ck_assert_uint_eq(profile.followedTriangles, 0);
        ck_assert_uint_eq(profile.fittedTriangles, cloth.soup.triangleCount);
        EndWithList(scene, &cloth);
    }
}
END_TEST

START_TEST(a_step_that_needs_more_than_the_list_searches_anew)
{
    Cloth cloth;
    qcScene* scene = MakeWithList(&cloth);
    qcRandom random = {5};
    qcDetectDef wider = qcDefaultDetectDef(), contacts = qcDefaultDetectDef(), neighbours = qcDefaultDetectDef();
    wider.margin = 0.007;
    contacts.contactMargin = 0.003;
    neighbours.neighbours = true;
    const qcDetectDef defs[] = {wider, contacts, neighbours};
    for (int i = 0; i < 3; i++)
    {
        Move(scene, &cloth, &random, 5, 0.001);
        qcProfile profile;
        (void)Check(scene, defs[i], i, &profile);
        ck_assert_uint_eq(profile.followedTriangles, 0);
    }
    EndWithList(scene, &cloth);
}
END_TEST

START_TEST(a_list_ends_with_its_body)
{
    Cloth cloth, next;
    qcScene* scene = MakeWithList(&cloth);
    qcDetectDef def = qcDefaultDetectDef();
    qcProfile profile;
    CHECK_OK(qcScene_RemoveBody(scene, cloth.id));
    next = AddCloth(scene, 4, 0.0, 0.0);
    ck_assert_uint_eq(next.id.slot, cloth.id.slot);
    (void)Check(scene, def, 0, &profile);
    ck_assert_uint_eq(profile.followedTriangles, 0);
    FreeCloth(&next);
    EndWithList(scene, &cloth);
}
END_TEST

START_TEST(a_body_that_slept_while_the_list_was_filled_is_fitted)
{
    Cloth cloth;
    qcScene* scene = MakeWithList(&cloth);
    qcRandom random = {7};
    qcDetectDef listDef = qcDefaultDetectDef(), def = qcDefaultDetectDef();
    listDef.contactMargin = 0.006;
    qcProfile profile;
    CHECK_OK(qcScene_SetActivity(scene, cloth.id, qc_activitySleeping));
    Cloth other = AddCloth(scene, 9, 3.0, 0.0);
    (void)Check(scene, listDef, 0, &profile);
    CHECK_OK(qcScene_SetActivity(scene, cloth.id, qc_activityMoving));
    Move(scene, &cloth, &random, 20, 0.001);
    (void)Check(scene, def, 1, &profile);
    ck_assert_uint_eq(profile.followedTriangles, other.soup.triangleCount);
    ck_assert_uint_eq(profile.fittedTriangles, cloth.soup.triangleCount);
    FreeCloth(&other);
    EndWithList(scene, &cloth);
}
END_TEST

START_TEST(a_list_that_a_failure_has_cut_short_serves_no_step)
{
    static const uint64_t limits[] = {1, 100, 1000};
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++)
    {
        qcScene* scene = qcMakeScene(NULL);
        Cloth cloth = AddCloth(scene, 3, 0.0, 0.0);
        qcDetectDef wide = qcDefaultDetectDef(), def = qcDefaultDetectDef();
        wide.method = qc_methodSweep;
        wide.margin = 0.05;
        wide.maxPairs = limits[i];
        const qcResult* result;
        ck_assert_int_eq(qcScene_Detect(scene, &wide, &result), qc_statusTooManyPairs);
        qcProfile profile;
        ck_assert_uint_gt(Check(scene, def, 1, &profile), 10);
        FreeCloth(&cloth);
        qcScene_Destroy(scene);
    }
}
END_TEST

QC_RUN_TESTS("verlet_list", small_motion_is_refitted_partially, large_motion_loses_no_pair,
             a_list_serves_smaller_margins, partially_refitted_bodies_have_pairs_at_their_current_positions,
             no_pair_is_lost_far_from_the_origin_where_margins_are_rounded,
             a_body_is_fitted_anew_if_much_of_it_moved_or_left_its_box,
             a_step_that_needs_more_than_the_list_searches_anew, a_list_ends_with_its_body,
             a_body_that_slept_while_the_list_was_filled_is_fitted, a_list_that_a_failure_has_cut_short_serves_no_step)
