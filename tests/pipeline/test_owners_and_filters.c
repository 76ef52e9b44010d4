// No method reports pairs between bodies of one owner, nor makes candidates of them.
#include "support/devices.h"
#include "support/long_form.h"
#include "support/scenes.h"
#include "support/suite.h"

enum
{
    qc_bodyCount = 12
};

typedef enum Rule
{
    rule_none,
    rule_owners, ///< bodies 0, 3, 6, 9 have none, the others one of two
    rule_filters ///< groups and masks that leave out the same pairs, as does the step's own filter below
} Rule;

static uint32_t OwnerOf(uint32_t body)
{
    return body % 3 == 0 ? 0 : 70000u * (body % 3);
}

/// Spheres that all overlap, without self-collision.
static qcScene* MakeSpheres(qcDevice* device, Rule rule)
{
    qcScene* scene = qcMakeScene(device);
    qcRandom random = {7};
    for (uint32_t body = 0; body < qc_bodyCount; body++)
    {
        qcSoup soup = qcSoup_MakeSphere(1, 0.3);
        qcBodyDef def = qcBodyDefOf(&soup);
        for (int axis = 0; axis < 3; axis++)
            def.transform.translation[axis] = qcRandom_Uniform(&random, 0.0, 0.3);
        def.selfCollision = false;
        if (rule == rule_owners)
            def.owner = OwnerOf(body);
        else if (rule == rule_filters)
        {
            def.group = 1u << body % 3;
            def.mask = body % 3 == 0 ? 7u : 7u & ~def.group;
        }
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
        qcSoup_Free(&soup);
    }
    return scene;
}

/// The pairs of brute force without owners, but for those of one owner.
static qcPairList ExpectedPairs(void)
{
    qcScene* scene = MakeSpheres(NULL, rule_none);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodBrute;
    qcPairList list = qcDetectPairs(scene, &def);
    size_t all = list.count, kept = 0;
    for (size_t i = 0; i < all; i++)
    {
        uint32_t a = OwnerOf(list.pairs[i].bodyA), b = OwnerOf(list.pairs[i].bodyB);
        if (a == 0 || a != b)
            list.pairs[kept++] = list.pairs[i];
    }
    list.count = kept;
    ck_assert_uint_gt(kept, 500);
    ck_assert_uint_gt(all, kept + 200);
    qcScene_Destroy(scene);
    return list;
}

static qcDetectDef DefOf(qcMethod method)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.reliable = method == qc_methodCullide || method == qc_methodQuick;
    def.resolution = 256;
    return def;
}

static bool MayCollide(void* calls, uint32_t slotA, uint32_t slotB)
{
    __atomic_fetch_add((int*)calls, 1, __ATOMIC_RELAXED);
    return OwnerOf(slotA) == 0 || OwnerOf(slotA) != OwnerOf(slotB);
}

/// The filter of a step leaves out the same pairs, in the steps that have one.
static void CheckPairFilter(qcDevice* device, qcMethod method, const qcPairList* expected)
{
    qcScene* scene = MakeSpheres(device, rule_none);
    qcDetectDef def = DefOf(method);
    qcPairList all = qcDetectPairs(scene, &def);
    int calls = 0;
    def.pairFilter = MayCollide;
    def.pairFilterContext = &calls;
    qcPairList found = qcDetectPairs(scene, &def);
    qcCheckSamePairs(expected, &found, qcMethod_Name(method));
    ck_assert_int_ge(calls, 66);
    free(found.pairs);
    // A filter may decide differently in the next step.
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert(!result->profile.reused);
    ck_assert_uint_eq(result->profile.bodyPairs, 66 - 12);
    def.pairFilter = NULL;
    found = qcDetectPairs(scene, &def);
    qcCheckSamePairs(&all, &found, qcMethod_Name(method));
    free(found.pairs);
    free(all.pairs);
    qcScene_Destroy(scene);
}

static void CheckMethod(qcDevice* device, qcMethod method, const qcPairList* expected)
{
    qcDetectDef def = DefOf(method);
    qcScene *owners = MakeSpheres(device, rule_owners), *filters = MakeSpheres(device, rule_filters);
    qcPairList found = qcDetectPairs(owners, &def);
    qcCheckSamePairs(expected, &found, qcMethod_Name(method));
    const qcResult *mine, *other;
    CHECK_OK(qcScene_Detect(owners, &def, &mine));
    CHECK_OK(qcScene_Detect(filters, &def, &other));
    const qcProfile *p = &mine->profile, *q = &other->profile;
    ck_assert_int_eq(p->method, method == qc_methodAuto ? p->method : method);
    // Twice four bodies of one owner.
    ck_assert_uint_eq(p->skippedFilteredPairs, 12);
    ck_assert_uint_eq(p->skippedFilteredPairs, q->skippedFilteredPairs);
    ck_assert_uint_eq(p->bodyPairs, 66 - 12);
    ck_assert_uint_eq(p->bodyPairs, q->bodyPairs);
    ck_assert_uint_eq(p->candidates, q->candidates);
    ck_assert_uint_eq(p->listPairs, q->listPairs);
    free(found.pairs);
    qcScene_Destroy(owners);
    qcScene_Destroy(filters);
    CheckPairFilter(device, method, expected);
}

START_TEST(no_method_reports_pairs_between_bodies_of_one_owner)
{
    qcPairList expected = ExpectedPairs();
    CheckMethod(NULL, qc_methodBrute, &expected);
    CheckMethod(NULL, qc_methodSweep, &expected);
    CheckMethod(NULL, qc_methodAuto, &expected);
    QC_FOR_EACH_DEVICE(device)
    {
        // Where devices refine, these two do the same as where they don't.
        if (!qcDevicesRefine() || qcIsLongForm())
        {
            CheckMethod(device, qc_methodCullide, &expected);
            CheckMethod(device, qc_methodQuick, &expected);
        }
        CheckMethod(device, qc_methodLayers, &expected);
        CheckMethod(device, qc_methodAuto, &expected);
    }
    free(expected.pairs);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void CheckNothingIsMade(qcDevice* device, qcMethod method)
{
    qcScene* scene = qcMakeScene(device);
    qcSoup soup = qcSoup_MakeSphere(1, 0.3);
    for (int body = 0; body < 3; body++)
    {
        qcBodyDef def = qcBodyDefOf(&soup);
        def.transform.translation[0] = 0.1 * body;
        def.owner = UINT32_MAX;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
        CHECK_OK(qcScene_SetSelfCollision(scene, id, false));
    }
    qcSoup_Free(&soup);
    qcDetectDef def = DefOf(method);
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->pairCount, 0);
    ck_assert_uint_eq(result->profile.bodyPairs, 0);
    ck_assert_uint_eq(result->profile.candidates, 0);
    ck_assert_uint_eq(result->profile.listPairs, 0);
    ck_assert_uint_eq(result->profile.skippedFilteredPairs, 3);
    ck_assert_uint_eq(result->profile.skippedBodies, 3);
    qcScene_Destroy(scene);
}

START_TEST(bodies_of_one_owner_have_no_candidates)
{
    CheckNothingIsMade(NULL, qc_methodBrute);
    CheckNothingIsMade(NULL, qc_methodSweep);
    QC_FOR_EACH_DEVICE(device)
    {
        CheckNothingIsMade(device, qc_methodCullide);
        CheckNothingIsMade(device, qc_methodQuick);
        CheckNothingIsMade(device, qc_methodLayers);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_body_with_an_owner_has_self_collision)
{
    qcScene* scenes[2];
    for (uint32_t i = 0; i < 2; i++)
    {
        scenes[i] = qcMakeScene(NULL);
        qcSoup cloth = qcSoup_MakeFoldedCloth(5, 20, 0.01, 0.02);
        qcBodyDef def = qcBodyDefOf(&cloth);
        def.owner = i;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scenes[i], &def, &id));
        qcSoup_Free(&cloth);
    }
    qcDetectDef def = qcDefaultDetectDef();
    qcPairList expected = qcDetectPairs(scenes[0], &def), found = qcDetectPairs(scenes[1], &def);
    ck_assert_uint_gt(expected.count, 0);
    qcCheckSamePairs(&expected, &found, "folded cloth");
    for (int i = 0; i < 2; i++)
        qcScene_Destroy(scenes[i]);
    free(expected.pairs);
    free(found.pairs);
}
END_TEST

QC_RUN_TESTS("owners", no_method_reports_pairs_between_bodies_of_one_owner, bodies_of_one_owner_have_no_candidates,
             a_body_with_an_owner_has_self_collision)
