// Work that a scene doesn't need is skipped, and counted in the profile.
#include "support/oracle.h"
#include "support/scenes.h"
#include "support/soups.h"
#include "support/suite.h"

static const qcProfile* Detect(qcScene* scene, double margin)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.margin = margin;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return &result->profile;
}

static qcTransform At(double x, double y, double z)
{
    qcTransform t = qcIdentityTransform();
    t.translation[0] = x;
    t.translation[1] = y;
    t.translation[2] = z;
    return t;
}

/// Spheres that touch their neighbours, in a cube.
static qcBodyId AddSpheres(qcScene* scene, uint32_t count, qcActivity activity)
{
    qcSoup soup = qcSoup_MakeSphere(0, 0.7);
    qcBodyDef def = qcBodyDefOf(&soup);
    def.activity = activity;
    def.selfCollision = false;
    qcBodyId id = {0, 0};
    for (uint32_t i = 0; i < count; i++)
    {
        def.transform = At(i % 22, i / 22 % 22, i / 484);
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
    }
    qcSoup_Free(&soup);
    return id;
}

START_TEST(a_sleeping_world_of_10_000_bodies_has_no_refit_and_no_candidate)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId last = AddSpheres(scene, 10000, qc_activitySleeping);
    for (int step = 0; step < 3; step++)
    {
        qcTransform moved = At(21.0, 9.0, 20.0 + 0.01 * step);
        CHECK_OK(qcScene_SetTransform(scene, last, &moved));
        const qcProfile* profile = Detect(scene, 0.0);
        ck_assert_uint_eq(profile->fittedTriangles, 0);
        ck_assert_uint_eq(profile->candidates, 0);
        ck_assert_uint_eq(profile->uploadedBytes, 0);
        ck_assert_uint_gt(profile->skippedStaticPairs, 10000);
    }
    // Nothing has changed: the last result is reused.
    ck_assert(Detect(scene, 0.0)->reused);
    // One body wakes up: only its neighbours are tested.
    CHECK_OK(qcScene_SetActivity(scene, last, qc_activityMoving));
    const qcProfile* profile = Detect(scene, 0.0);
    ck_assert_uint_gt(profile->candidates, 0);
    ck_assert_uint_gt(profile->fittedTriangles, 0);
    ck_assert_uint_le(profile->fittedTriangles, 30 * 20);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(rigid_bodies_are_refitted_once_for_all_transforms)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeSphere(3, 0.6);
    qcBodyDef def = qcBodyDefOf(&soup);
    def.selfCollision = false;
    qcBodyId id[2];
    for (int i = 0; i < 2; i++)
    {
        def.transform = At(i, 0.0, 0.0);
        CHECK_OK(qcScene_AddBody(scene, &def, &id[i]));
    }
    ck_assert_uint_eq(Detect(scene, 0.0)->fittedTriangles, 2 * (uint64_t)soup.triangleCount);
    for (int step = 0; step < 4; step++)
    {
        qcTransform turned = {{0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6}, {1.0, 0.1 * step, 0.0}};
        CHECK_OK(qcScene_SetTransform(scene, id[1], &turned));
        const qcProfile* profile = Detect(scene, step % 2 == 0 ? 0.0 : 0.01);
        ck_assert_uint_eq(profile->fittedTriangles, 0);
        ck_assert_uint_gt(profile->pairs, 0);
        ck_assert_uint_gt(profile->skippedTriangles, 0);
    }
    qcSoup_Free(&soup);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(a_deforming_body_is_refitted_only_after_it_moved)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup cloth = qcSoup_MakeFoldedCloth(2, 24, 0.02, 0.03), sheet = qcSoup_MakeSphere(2, 0.1);
    qcBodyDef def = qcBodyDefOf(&cloth), other = qcBodyDefOf(&sheet);
    def.deforming = other.deforming = true;
    qcBodyId id, still;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    CHECK_OK(qcScene_AddBody(scene, &other, &still));
    ck_assert_uint_eq(Detect(scene, 0.0)->fittedTriangles, (uint64_t)cloth.triangleCount + sheet.triangleCount);
    CHECK_OK(qcScene_SetVertices(scene, id, cloth.positions, qc_positionF64, 0));
    ck_assert_uint_eq(Detect(scene, 0.0)->fittedTriangles, cloth.triangleCount);
    qcSoup_Free(&cloth);
    qcSoup_Free(&sheet);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(a_step_of_brute_force_reports_no_refits)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup cloth = qcSoup_MakeFoldedCloth(2, 24, 0.02, 0.03);
    qcAddSoup(scene, &cloth);
    // The sweep before it has some.
    ck_assert_uint_eq(Detect(scene, 0.0)->fittedTriangles, cloth.triangleCount);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodBrute;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->profile.fittedTriangles, 0);
    ck_assert_uint_eq(result->profile.followedTriangles, 0);
    qcSoup_Free(&cloth);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(flat_patches_are_skipped_unless_the_margin_is_as_wide_as_triangles)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup cloth = qcSoup_MakeFoldedCloth(2, 40, 0.2, 0.0);
    qcAddSoup(scene, &cloth);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    qcLetBodiesLive(scene, def);
    const qcProfile* profile = Detect(scene, 0.0);
    ck_assert_uint_gt(profile->flatTriangles, cloth.triangleCount / 4);
    ck_assert_uint_le(profile->flatTriangles, cloth.triangleCount);
    ck_assert_uint_eq(profile->exactFallbacks, 0);
    double edge = 1.0 / 40.0;
    ck_assert_uint_gt(Detect(scene, 0.25 * edge)->flatTriangles, cloth.triangleCount / 4);
    ck_assert_uint_eq(Detect(scene, edge)->flatTriangles, 0);
    qcSoup_Free(&cloth);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(pairs_proven_in_single_precision_need_no_exact_test)
{
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soup = qcSoup_MakeRandom(5, 300, 0.5);
    qcAddSoup(scene, &soup);
    const qcProfile* profile = Detect(scene, 0.0);
    ck_assert_uint_gt(profile->filterHits, profile->pairs * 8 / 10);
    ck_assert_uint_le(profile->filterHits, profile->pairs);
    qcSoup_Free(&soup);
    qcScene_Destroy(scene);
}
END_TEST

QC_RUN_TESTS("skips", a_sleeping_world_of_10_000_bodies_has_no_refit_and_no_candidate,
             rigid_bodies_are_refitted_once_for_all_transforms, a_deforming_body_is_refitted_only_after_it_moved,
             a_step_of_brute_force_reports_no_refits,
             flat_patches_are_skipped_unless_the_margin_is_as_wide_as_triangles,
             pairs_proven_in_single_precision_need_no_exact_test)
