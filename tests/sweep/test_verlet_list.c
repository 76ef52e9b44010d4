// After a few vertices have moved, pairs come from those that were within a margin before: the same as brute force has.
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"

enum
{
    qc_side = 32, ///< of cloths: 2048 triangles
    qc_rounds = 40
};

/// Cloths as the scene has them.
typedef struct Cloth
{
    qcSoup soup;
    qcBodyId id;
    double* first; ///< positions when its pairs were last kept
} Cloth;

static Cloth AddCloth(qcScene* scene, uint64_t seed, double z, double away)
{
    Cloth cloth = {.soup = qcSoup_MakeFoldedCloth(seed, qc_side, 0.01, 0.004)};
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

static void Keep(Cloth* cloth)
{
    memcpy(cloth->first, cloth->soup.positions, 3 * sizeof(double) * cloth->soup.vertexCount);
}

/// Some vertices go some way, most of them a small one; others go back.
static void MoveSome(Cloth* cloth, qcRandom* random, uint32_t count, double most)
{
    for (uint32_t i = 0; i < count; i++)
    {
        size_t at = 3 * (size_t)qcRandom_Below(random, cloth->soup.vertexCount);
        bool back = qcRandom_Below(random, 4) == 0, far = qcRandom_Below(random, 8) == 0;
        for (int axis = 0; axis < 3; axis++)
            cloth->soup.positions[at + (size_t)axis] =
                cloth->first[at + (size_t)axis] +
                (back ? 0.0 : (far ? 8.0 : 1.0) * most * qcRandom_Uniform(random, -1.0, 1.0));
    }
}

static void Move(qcScene* scene, Cloth* cloth, qcRandom* random, uint32_t count, double most)
{
    MoveSome(cloth, random, count, most);
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

/// As brute force has it; returns how many pairs there are.
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

/// Contacts in `kept`, then pairs within `asked` again and again while vertices move by about `most`, so far `away`
/// from the origin.
static void CheckSceneAway(double away, uint64_t seed, int clothCount, double kept, double asked, double most,
                           bool mustFollow)
{
    qcScene* scene = qcMakeScene(NULL);
    qcRandom random = {seed};
    Cloth cloths[2];
    for (int i = 0; i < clothCount; i++)
        cloths[i] = AddCloth(scene, seed + (uint64_t)i, 0.004 * i, away);
    qcDetectDef keeping = qcDefaultDetectDef(), asking = qcDefaultDetectDef();
    keeping.contactMargin = kept;
    asking.margin = asked;
    uint64_t pairs = 0, followed = 0, triangles = 0;
    for (int round = 0; round < qc_rounds; round++)
    {
        qcProfile profile;
        keeping.threads = asking.threads = 1 + (uint32_t)round % 3;
        if (round % 5 == 0)
        {
            for (int i = 0; i < clothCount; i++)
                Keep(&cloths[i]);
            (void)Check(scene, keeping, round, &profile);
            ck_assert_uint_eq(profile.followedTriangles, 0);
        }
        for (int i = 0; i < clothCount; i++)
            if (qcRandom_Below(&random, 4) != 0)
                Move(scene, &cloths[i], &random, 1 + qcRandom_Below(&random, 60), most);
        asking.touching = round % 2 == 0;
        pairs += Check(scene, asking, round, &profile);
        followed += profile.followedTriangles;
        triangles += (uint64_t)clothCount * cloths[0].soup.triangleCount;
    }
    ck_assert_uint_gt(pairs, 100);
    if (mustFollow)
        ck_assert_uint_gt(followed, triangles / 2);
    for (int i = 0; i < clothCount; i++)
        FreeCloth(&cloths[i]);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static void CheckScene(uint64_t seed, int clothCount, double kept, double asked, double most, bool mustFollow)
{
    CheckSceneAway(0.0, seed, clothCount, kept, asked, most, mustFollow);
}

START_TEST(what_moves_a_little_is_all_that_is_looked_at)
{
    for (uint64_t seed = 1; seed <= 4; seed++)
        CheckScene(seed, 1, 0.006, 0.0, 0.0015, true);
}
END_TEST

START_TEST(what_moves_far_is_looked_for_everywhere)
{
    for (uint64_t seed = 1; seed <= 4; seed++)
        CheckScene(seed, 1, 0.004, 0.0, 0.006, false);
}
END_TEST

START_TEST(a_smaller_margin_is_had_from_a_larger_one)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
        CheckScene(seed, 1, 0.008, 0.003, 0.0015, true);
}
END_TEST

START_TEST(bodies_that_follow_meet_others_where_they_are)
{
    for (uint64_t seed = 1; seed <= 3; seed++)
    {
        CheckScene(seed, 2, 0.006, 0.0, 0.002, true);
        CheckScene(seed, 2, 0.008, 0.002, 0.004, false);
    }
}
END_TEST

START_TEST(far_from_the_origin_margins_are_rounded_and_nothing_is_lost)
{
    // There the coordinates are multiples of 2^-9: margins are not, or those asked for are, to the last bit.
    const double asked[] = {0.0, 0x1p-9, 0.003};
    for (uint64_t seed = 1; seed <= 3; seed++)
        CheckSceneAway(0x1.4p43, seed, 1, 0.0067, asked[seed - 1], 0.01, false);
}
END_TEST

/// A cloth whose pairs within a margin are kept.
static qcScene* MakeKept(Cloth* cloth)
{
    qcScene* scene = qcMakeScene(NULL);
    *cloth = AddCloth(scene, 3, 0.0, 0.0);
    Keep(cloth);
    qcDetectDef def = qcDefaultDetectDef();
    def.contactMargin = 0.006;
    qcProfile profile;
    (void)Check(scene, def, 0, &profile);
    return scene;
}

static void EndKept(qcScene* scene, Cloth* cloth)
{
    FreeCloth(cloth);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(a_body_is_fitted_again_where_much_of_it_moved_or_left_its_box)
{
    for (int kind = 0; kind < 2; kind++)
    {
        Cloth cloth;
        qcScene* scene = MakeKept(&cloth);
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
        EndKept(scene, &cloth);
    }
}
END_TEST

START_TEST(what_asks_for_more_than_was_kept_is_searched_anew)
{
    Cloth cloth;
    qcScene* scene = MakeKept(&cloth);
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
    EndKept(scene, &cloth);
}
END_TEST

START_TEST(what_was_kept_ends_with_the_body)
{
    Cloth cloth, next;
    qcScene* scene = MakeKept(&cloth);
    qcDetectDef def = qcDefaultDetectDef();
    qcProfile profile;
    CHECK_OK(qcScene_RemoveBody(scene, cloth.id));
    next = AddCloth(scene, 4, 0.0, 0.0);
    ck_assert_uint_eq(next.id.slot, cloth.id.slot);
    (void)Check(scene, def, 0, &profile);
    ck_assert_uint_eq(profile.followedTriangles, 0);
    FreeCloth(&next);
    EndKept(scene, &cloth);
}
END_TEST

START_TEST(a_body_that_slept_while_others_were_kept_is_fitted)
{
    Cloth cloth;
    qcScene* scene = MakeKept(&cloth);
    qcRandom random = {7};
    qcDetectDef keeping = qcDefaultDetectDef(), asking = qcDefaultDetectDef();
    keeping.contactMargin = 0.006;
    qcProfile profile;
    CHECK_OK(qcScene_SetActivity(scene, cloth.id, qc_activitySleeping));
    Cloth other = AddCloth(scene, 9, 3.0, 0.0);
    (void)Check(scene, keeping, 0, &profile);
    CHECK_OK(qcScene_SetActivity(scene, cloth.id, qc_activityMoving));
    Move(scene, &cloth, &random, 20, 0.001);
    (void)Check(scene, asking, 1, &profile);
    ck_assert_uint_eq(profile.followedTriangles, other.soup.triangleCount);
    ck_assert_uint_eq(profile.fittedTriangles, cloth.soup.triangleCount);
    FreeCloth(&other);
    EndKept(scene, &cloth);
}
END_TEST

QC_RUN_TESTS("follow", what_moves_a_little_is_all_that_is_looked_at, what_moves_far_is_looked_for_everywhere,
             a_smaller_margin_is_had_from_a_larger_one, bodies_that_follow_meet_others_where_they_are,
             far_from_the_origin_margins_are_rounded_and_nothing_is_lost,
             a_body_is_fitted_again_where_much_of_it_moved_or_left_its_box,
             what_asks_for_more_than_was_kept_is_searched_anew, what_was_kept_ends_with_the_body,
             a_body_that_slept_while_others_were_kept_is_fitted)
