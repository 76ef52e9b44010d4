// Scenes, step by step, with BVHs and with brute force: bodies are added and removed, move, sleep, wake and change
// their filters.
#define _POSIX_C_SOURCE 200809L // setenv
#include "support/failing_heap.h"
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"

#include <math.h>

enum
{
    qc_largeSide = 47, ///< of a cloth of 4418 triangles: too large for a BVH in the first step
    qc_bodiesInScene = 9
};

static uint64_t Mix(uint64_t hash, uint64_t value)
{
    return (hash ^ value) * UINT64_C(0x100000001b3);
}

static uint64_t HashOf(const qcResult* result)
{
    uint64_t hash = UINT64_C(0xcbf29ce484222325);
    for (size_t i = 0; i < result->pairCount; i++)
    {
        const qcPair* p = &result->pairs[i];
        hash = Mix(Mix(Mix(Mix(Mix(hash, p->bodyA), p->triangleA), p->bodyB), p->triangleB), p->relation);
    }
    for (size_t i = 0; i < result->contactCount; i++)
    {
        const qcContact* c = &result->contacts[i];
        hash = Mix(Mix(Mix(hash, c->bodyA), c->bodyB), c->verticesA[0]);
        hash = Mix(Mix(hash, c->verticesB[0]), (uint64_t)(c->distance * 0x1p60));
    }
    return hash;
}

static uint64_t Detect(qcScene* scene, qcDetectDef def, qcMethod method, uint32_t threads, qcProfile* profile)
{
    const qcResult* result;
    def.method = method;
    def.threads = threads;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    if (profile != NULL)
        *profile = result->profile;
    return HashOf(result);
}

static qcScene* MakeDeforming(const qcSoup* soup, qcBodyId* id)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
    return scene;
}

START_TEST(a_large_new_body_has_all_pairs_in_each_step_of_its_life)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(1, qc_largeSide, 0.15, 0.2);
    qcBodyId id;
    qcScene* scene = MakeDeforming(&soup, &id);
    uint64_t flat = 0, neighbours = 0;
    // Through all parts of the adjacency, and some steps more.
    for (int step = 0; step < 30; step++)
    {
        qcSoup next = qcSoup_MakeFoldedCloth(1 + (uint64_t)step % 5, qc_largeSide, 0.15, 0.2);
        CHECK_OK(qcScene_SetVertices(scene, id, next.positions, qc_positionF64, 0));
        qcSoup_Free(&next);
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.margin = step % 4 == 3 ? 0.002 : 0.0;
        qcProfile profile, expected;
        uint64_t hash = Detect(scene, def, qc_methodSweep, 1 + (uint32_t)step % 3, &profile);
        CHECK_THAT(hash == Detect(scene, def, qc_methodBrute, 2, &expected), "step %d: other pairs", step);
        ck_assert_uint_gt(expected.pairs, 10);
        ck_assert_uint_eq(profile.pairs, expected.pairs);
        // Boxes alone would leave ten times as many.
        ck_assert_uint_lt(profile.candidates, 2 * soup.triangleCount);
        ck_assert(step == 0 || profile.skippedNeighbours == neighbours);
        neighbours = profile.skippedNeighbours;
        flat = profile.flatTriangles;
        ck_assert(step != 0 || flat == 0);
    }
    ck_assert_uint_gt(flat, 0);
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(large_bodies_without_self_collision_have_a_bvh_at_once)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeFoldedCloth(1, qc_largeSide, 0.01, 0.01);
    for (int i = 0; i < 3; i++)
    {
        qcBodyDef bodyDef = qcBodyDefOf(&soup);
        bodyDef.selfCollision = false;
        bodyDef.transform.translation[2] = 0.003 * i;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &bodyDef, &id));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.touching = true;
    for (uint32_t threads = 2; threads > 0; threads--)
    {
        qcProfile profile;
        uint64_t hash = Detect(scene, def, qc_methodSweep, threads, &profile);
        ck_assert_uint_eq(profile.fittedTriangles, threads == 2 ? 3 * soup.triangleCount : 0);
        ck_assert_uint_gt(profile.pairs, 10);
        CHECK_THAT(hash == Detect(scene, def, qc_methodBrute, 2, NULL), "other pairs");
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_large_new_body_with_contacts_has_a_bvh_at_once)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(1, qc_largeSide, 0.01, 0.01);
    qcBodyId id;
    qcScene* scene = MakeDeforming(&soup, &id);
    qcDetectDef def = qcDefaultDetectDef();
    def.contactMargin = 0.004;
    qcProfile profile;
    uint64_t hash = Detect(scene, def, qc_methodSweep, 2, &profile);
    ck_assert_uint_eq(profile.fittedTriangles, soup.triangleCount);
    ck_assert_uint_gt(profile.contacts, 10);
    CHECK_THAT(hash == Detect(scene, def, qc_methodBrute, 2, NULL), "other pairs or contacts");
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// A random body near the origin.
static qcBodyId AddAny(qcScene* scene, qcRandom* random)
{
    qcSoup soup = qcMakeSoup((qcSoupKind)qcRandom_Below(random, qc_soupKindCount), qcRandom_Next(random));
    qcBodyDef def = qcBodyDefOf(&soup);
    for (int axis = 0; axis < 3; axis++)
        def.transform.translation[axis] = qcRandom_Uniform(random, -0.3, 0.3);
    def.activity = (qcActivity)qcRandom_Below(random, 3);
    def.group = 1u << qcRandom_Below(random, 3);
    def.mask = 1 + qcRandom_Below(random, 7);
    def.selfCollision = qcRandom_Below(random, 2) == 0;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    qcSoup_Free(&soup);
    return id;
}

/// One change: a body is replaced by another in its slot, or one moves, sleeps, wakes or changes its filter.
static void ChangeAny(qcScene* scene, qcRandom* random, qcBodyId ids[qc_bodiesInScene])
{
    qcBodyId* id = &ids[qcRandom_Below(random, qc_bodiesInScene)];
    qcTransform transform = qcIdentityTransform();
    for (int axis = 0; axis < 3; axis++)
        transform.translation[axis] = qcRandom_Uniform(random, -0.3, 0.3);
    switch (qcRandom_Below(random, 6))
    {
        case 0:
            CHECK_OK(qcScene_RemoveBody(scene, *id));
            *id = AddAny(scene, random);
            return;
        case 1: CHECK_OK(qcScene_SetActivity(scene, *id, (qcActivity)qcRandom_Below(random, 3))); return;
        case 2: CHECK_OK(qcScene_SetFilter(scene, *id, 1u << qcRandom_Below(random, 3), 7)); return;
        case 3: CHECK_OK(qcScene_SetSelfCollision(scene, *id, qcRandom_Below(random, 2) == 0)); return;
        default: CHECK_OK(qcScene_SetTransform(scene, *id, &transform)); return;
    }
}

/// Thirty steps of one scene; returns the hash of all results. `checked`: they are compared with brute force.
static uint64_t PlayScene(bool checked, uint32_t threads)
{
    qcScene* scene = qcMakeScene(NULL);
    qcRandom random = {77};
    qcBodyId ids[qc_bodiesInScene];
    for (int i = 0; i < qc_bodiesInScene; i++)
        ids[i] = AddAny(scene, &random);
    uint64_t hash = 0, pairs = 0, contacts = 0;
    for (int step = 0; step < 30; step++)
    {
        for (int change = 0; change < 1 + step % 3; change++)
            ChangeAny(scene, &random, ids);
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = step % 2 == 0;
        def.neighbours = step % 5 == 4;
        def.margin = step % 4 == 1 ? 0.01 : step % 4 == 2 ? 0.03 : 0.0;
        def.contactMargin = step % 6 == 3 ? 0.02 : 0.0;
        qcProfile profile;
        uint64_t result = Detect(scene, def, step % 2 == 0 ? qc_methodSweep : qc_methodAuto, threads, &profile);
        if (checked)
            CHECK_THAT(result == Detect(scene, def, qc_methodBrute, 1, NULL), "step %d: other pairs", step);
        hash = Mix(hash, result);
        pairs += profile.pairs;
        contacts += profile.contacts;
    }
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    ck_assert(pairs > 1000 && contacts > 100);
    return hash;
}

START_TEST(changing_scenes_have_the_pairs_of_brute_force_with_all_kernels)
{
    unsetenv("QC_KERNELS");
    uint64_t expected = PlayScene(true, 1);
    FOR_EACH_KERNELS(k)
    {
        setenv("QC_KERNELS", k->name, 1);
        for (uint32_t threads = 1; threads <= 3; threads += 2)
            CHECK_THAT(PlayScene(false, threads) == expected, "%s on %u threads: other pairs", k->name, threads);
    }
}
END_TEST

START_TEST(a_smooth_sheet_has_all_pairs_within_a_changing_margin)
{
    // Flat everywhere: no triangles intersect, but those next to neighbours are within the margin.
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeGrid(30);
    for (uint32_t v = 0; v < soup.vertexCount; v++)
        soup.positions[3 * v + 2] = 0.02 * sin(9.0 * soup.positions[3 * v]);
    qcBodyDef bodyDef = qcBodyDefOf(&soup);
    bodyDef.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &bodyDef, &id));
    for (int step = 0; step < 7; step++)
    {
        // In the last step it is rolled up tightly, through itself.
        for (uint32_t v = 0; v < soup.vertexCount && step == 6; v++)
        {
            double* x = soup.positions + 3 * (size_t)v;
            double angle = 40.0 * x[0], radius = 0.3 + 0.05 * x[1] * sin(20.0 * x[0]);
            x[0] = radius * cos(angle);
            x[2] = radius * sin(angle);
        }
        CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.margin = step == 1 ? 0.04 : step == 5 ? 0.036 : 0.0;
        def.contactMargin = step == 3 ? 0.03 : 0.0;
        qcProfile profile;
        uint64_t hash = Detect(scene, def, qc_methodSweep, 1 + (uint32_t)step % 2, &profile);
        CHECK_THAT(hash == Detect(scene, def, qc_methodBrute, 1, NULL), "step %d: other pairs", step);
        ck_assert_int_eq(profile.pairs > 20, step == 1 || step >= 5);
        ck_assert_int_eq(profile.contacts > 0, step == 3);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(a_body_too_large_for_a_lattice_has_its_pairs_too)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.2), large = qcSoup_MakeRandom(3, 200, 0.2);
    qcSoup_Place(&large, 1e300, 0.0, 0.0, 0.0);
    qcBodyDef bodyDef = qcBodyDefOf(&soup);
    bodyDef.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &bodyDef, &id));
    qcAddSoup(scene, &soup);
    for (int step = 0; step < 4; step++)
    {
        CHECK_OK(qcScene_SetVertices(scene, id, (step % 2 == 0 ? &large : &soup)->positions, qc_positionF64, 0));
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        CHECK_THAT(Detect(scene, def, qc_methodSweep, 1, NULL) == Detect(scene, def, qc_methodBrute, 1, NULL),
                   "step %d: other pairs", step);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    qcSoup_Free(&large);
}
END_TEST

START_TEST(layers_that_part_have_all_pairs_before_and_after_their_bvh_is_built_anew)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(1, qc_largeSide, 1e-4, 0.0);
    qcBodyId id;
    qcScene* scene = MakeDeforming(&soup, &id);
    for (int step = 0; step < 60; step++)
    {
        // The layers cross in places.
        qcSoup next = qcSoup_MakeFoldedCloth(1 + (uint64_t)step, qc_largeSide, step < 5 ? 1e-4 : 0.2, 0.15);
        CHECK_OK(qcScene_SetVertices(scene, id, next.positions, qc_positionF64, 0));
        qcSoup_Free(&next);
        qcDetectDef def = qcDefaultDetectDef();
        qcProfile profile;
        uint64_t hash = Detect(scene, def, qc_methodSweep, 1 + (uint32_t)step % 2, &profile);
        ck_assert_uint_gt(profile.fittedTriangles, 0);
        if (step % 6 == 5 || (step > 15 && step < 20))
            CHECK_THAT(hash == Detect(scene, def, qc_methodBrute, 2, NULL), "step %d: other pairs", step);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&soup);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Spheres of a few triangles with self-collision, side by side.
static qcScene* MakeManySmall(uint32_t count, qcBodyId* first)
{
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t i = 0; i < count; i++)
    {
        qcSoup soup = qcSoup_MakeSphere(0, 0.5);
        qcSoup_Translate(&soup, 2.0 * (i % 32), 0.0, 2.0 * (i / 32));
        qcBodyId id = qcAddSoup(scene, &soup);
        *first = i == 0 ? id : *first;
        qcSoup_Free(&soup);
    }
    return scene;
}

static void StepWithMovedBody(qcScene* scene, qcBodyId id, uint32_t step)
{
    qcTransform transform = qcIdentityTransform();
    transform.translation[0] = -0.01 * step;
    CHECK_OK(qcScene_SetTransform(scene, id, &transform));
    (void)Detect(scene, qcDefaultDetectDef(), qc_methodSweep, 1, NULL);
}

START_TEST(small_bodies_with_self_collision_take_little_memory)
{
    const uint32_t count = 400;
    qcBodyId first;
    qcScene* scene = MakeManySmall(count, &first);
    for (uint32_t step = 0; step < 30; step++)
        StepWithMovedBody(scene, first, step);
    ck_assert_uint_le(qcGetByteCount() / count, 16384);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(no_step_prepares_all_of_many_small_bodies_for_later_ones)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcBodyId first;
    qcScene* scene = MakeManySmall(1000, &first);
    size_t max = 0, all = 0;
    for (uint32_t step = 0; step < 60; step++)
    {
        heap.calls = 0;
        StepWithMovedBody(scene, first, step);
        // The first step builds all BVHs.
        max = step > 0 && heap.calls > max ? heap.calls : max;
        all += step > 0 ? heap.calls : 0;
        ck_assert(step < 50 || heap.calls < 10);
    }
    ck_assert_uint_gt(all, 1000);
    ck_assert_uint_lt(max, all / 4);
    qcScene_Destroy(scene);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("bvh_scenes", no_step_prepares_all_of_many_small_bodies_for_later_ones,
             small_bodies_with_self_collision_take_little_memory,
             layers_that_part_have_all_pairs_before_and_after_their_bvh_is_built_anew,
             a_large_new_body_has_all_pairs_in_each_step_of_its_life,
             large_bodies_without_self_collision_have_a_bvh_at_once, a_large_new_body_with_contacts_has_a_bvh_at_once,
             changing_scenes_have_the_pairs_of_brute_force_with_all_kernels,
             a_smooth_sheet_has_all_pairs_within_a_changing_margin, a_body_too_large_for_a_lattice_has_its_pairs_too)
