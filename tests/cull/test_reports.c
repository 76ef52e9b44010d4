// What a step reports on request: the sets of the PCS, candidate pairs, and its stages to a profiler.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

/// A sheet that crosses a sphere and itself: it is folded like an accordion.
static void AddCrossingBodies(qcScene* scene)
{
    qcSoup sheet = qcSoup_MakeGrid(24), ball = qcSoup_MakeSphere(2, 0.3);
    for (uint32_t v = 0; v < sheet.vertexCount; v++)
    {
        double x = sheet.positions[3 * v];
        sheet.positions[3 * v + 2] = 0.2 * sin(9.0 * x) + 0.02 * cos(31.0 * sheet.positions[3 * v + 1]);
        sheet.positions[3 * v] = 0.3 * cos(9.0 * x) + 0.1 * x;
    }
    qcAddSoup(scene, &sheet);
    qcAddSoup(scene, &ball);
    qcSoup_Free(&sheet);
    qcSoup_Free(&ball);
}

static const qcResult* Detect(qcScene* scene, qcMethod method, bool reports)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.resolution = 512;
    def.sets = def.candidates = reports;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return result;
}

/// The set of a triangle at a level; BFV if it is not in the PCS.
static unsigned SetOf(const qcResult* result, uint32_t body, uint32_t triangle, bool self)
{
    for (size_t i = 0; i < result->pcsCount; i++)
        if (result->pcs[i].body == body && result->pcs[i].triangle == triangle)
            return self ? result->pcsSets[i].self : result->pcsSets[i].others;
    return qc_setBfv;
}

/// Checks that the sets have the sizes of the last pass of a level.
static void CheckSizes(const qcResult* result, qcCullLevel level, uint32_t body)
{
    const qcPassRecord* last = NULL;
    for (size_t i = 0; i < result->profile.passCount; i++)
        if (result->profile.passes[i].level == level &&
            (level != qc_levelSelf || result->profile.passes[i].body == body))
            last = &result->profile.passes[i];
    ck_assert_ptr_nonnull(last);
    uint32_t size[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < result->pcsCount; i++)
        if (level != qc_levelSelf || result->pcs[i].body == body)
            size[level == qc_levelSelf ? result->pcsSets[i].self : result->pcsSets[i].others]++;
    ck_assert_uint_eq(size[qc_setFfv], last->ffv);
    ck_assert_uint_eq(size[qc_setSfv], last->sfv);
    ck_assert_uint_eq(size[qc_setNfv], last->nfv);
    ck_assert_uint_gt(last->ffv + last->sfv, 0);
}

START_TEST(the_sets_are_disjoint_and_their_union_is_the_pcs)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddCrossingBodies(scene);
        const qcResult* result = Detect(scene, qc_methodQuick, true);
        ck_assert_ptr_nonnull(result->pcsSets);
        for (size_t i = 0; i < result->pcsCount; i++)
            if (result->pcsSets[i].others == qc_setBfv && result->pcsSets[i].self == qc_setBfv)
                ck_abort_msg("triangle %u of the PCS is in BFV", result->pcs[i].triangle);
        // One set a level each: the sizes are those of the last pass.
        CheckSizes(result, qc_levelTriangles, 0);
        CheckSizes(result, qc_levelSelf, 0);
        // CULLIDE empties FFV and SFV after each view.
        result = Detect(scene, qc_methodCullide, true);
        for (size_t i = 0; i < result->pcsCount; i++)
        {
            const qcTriangleSets* sets = &result->pcsSets[i];
            if ((sets->others != qc_setNfv && sets->others != qc_setBfv) ||
                (sets->self != qc_setNfv && sets->self != qc_setBfv))
                ck_abort_msg("triangle %u of the PCS of CULLIDE is in FFV or SFV", result->pcs[i].triangle);
        }
        qcScene_Destroy(scene);
    }
}
END_TEST

START_TEST(no_candidate_lies_within_one_collision_free_set)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddCrossingBodies(scene);
        const qcResult* result = Detect(scene, qc_methodQuick, true);
        ck_assert_uint_gt(result->candidateCount, 0);
        for (size_t i = 0; i < result->candidateCount; i++)
        {
            const qcCandidate* c = &result->candidates[i];
            bool self = c->bodyA == c->bodyB;
            unsigned a = SetOf(result, c->bodyA, c->triangleA, self), b = SetOf(result, c->bodyB, c->triangleB, self);
            if (a == qc_setBfv || b == qc_setBfv || (a == b && a != qc_setNfv))
                ck_abort_msg("candidate %zu: sets %u and %u", i, a, b);
        }
        qcScene_Destroy(scene);
    }
}
END_TEST

static int CompareCandidates(const qcCandidate* a, const qcCandidate* b)
{
    const uint32_t p[4] = {a->bodyA, a->triangleA, a->bodyB, a->triangleB};
    const uint32_t q[4] = {b->bodyA, b->triangleA, b->bodyB, b->triangleB};
    for (int i = 0; i < 4; i++)
        if (p[i] != q[i])
            return p[i] < q[i] ? -1 : 1;
    return 0;
}

static bool Contains(const qcResult* result, const qcPair* pair)
{
    const qcCandidate key = {pair->bodyA, pair->triangleA, pair->bodyB, pair->triangleB};
    size_t first = 0, end = result->candidateCount;
    while (first < end)
    {
        size_t middle = (first + end) / 2;
        if (CompareCandidates(&result->candidates[middle], &key) < 0)
            first = middle + 1;
        else
            end = middle;
    }
    return first < result->candidateCount && CompareCandidates(&result->candidates[first], &key) == 0;
}

START_TEST(candidates_are_sorted_and_contain_every_pair_and_the_pcs)
{
    static const qcMethod methods[] = {qc_methodBrute, qc_methodSweep, qc_methodLayers};
    QC_FOR_EACH_DEVICE(device)
    {
        for (size_t m = 0; m < sizeof methods / sizeof methods[0]; m++)
        {
            qcScene* scene = qcMakeScene(device);
            AddCrossingBodies(scene);
            const qcResult* result = Detect(scene, methods[m], true);
            ck_assert_ptr_null(result->pcsSets);
            ck_assert_uint_gt(result->pairCount, 0);
            ck_assert_uint_eq(result->candidateCount, result->profile.candidates);
            for (size_t i = 1; i < result->candidateCount; i++)
                if (CompareCandidates(&result->candidates[i - 1], &result->candidates[i]) >= 0)
                    ck_abort_msg("candidate %zu is not in order", i);
            for (size_t i = 0; i < result->pairCount; i++)
                ck_assert_msg(Contains(result, &result->pairs[i]), "pair %zu is no candidate", i);
            uint8_t* isIn[2] = {calloc(1 << 16, 1), calloc(1 << 16, 1)};
            size_t count = 0;
            for (size_t i = 0; i < result->candidateCount; i++)
                isIn[result->candidates[i].bodyA][result->candidates[i].triangleA] =
                    isIn[result->candidates[i].bodyB][result->candidates[i].triangleB] = 1;
            for (size_t i = 0; i < 1 << 16; i++)
                count += (size_t)(isIn[0][i] + isIn[1][i]);
            ck_assert_uint_eq(count, result->pcsCount);
            for (size_t i = 0; i < result->pcsCount; i++)
                if (isIn[result->pcs[i].body][result->pcs[i].triangle] == 0)
                    ck_abort_msg("triangle %u of the PCS has no candidate", result->pcs[i].triangle);
            free(isIn[0]);
            free(isIn[1]);
            qcScene_Destroy(scene);
        }
    }
}
END_TEST

START_TEST(candidates_for_contacts_are_candidates_without_neighbours)
{
    qcScene* scene = qcMakeScene(NULL);
    AddCrossingBodies(scene);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.contactMargin = 0.02;
    def.candidates = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    size_t between = 0;
    for (size_t i = 0; i < result->contactCount; i++)
        between += result->contacts[i].bodyA != result->contacts[i].bodyB;
    ck_assert_uint_gt(between, 0);
    ck_assert_uint_gt(result->candidateCount, result->profile.candidates);
    for (size_t i = 1; i < result->candidateCount; i++)
        if (CompareCandidates(&result->candidates[i - 1], &result->candidates[i]) >= 0)
            ck_abort_msg("candidate %zu is not in order", i);
    qcSoup sheet = qcSoup_MakeGrid(24);
    for (size_t i = 0; i < result->candidateCount; i++)
    {
        const qcCandidate* c = &result->candidates[i];
        for (int k = 0; c->bodyA == 0 && c->bodyB == 0 && k < 9; k++)
            if (sheet.indices[3 * c->triangleA + (uint32_t)k / 3] == sheet.indices[3 * c->triangleB + (uint32_t)k % 3])
                ck_abort_msg("candidate %zu: triangles %u and %u share a vertex", i, c->triangleA, c->triangleB);
    }
    qcSoup_Free(&sheet);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(what_is_not_requested_is_null_and_changes_nothing)
{
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        AddCrossingBodies(scene);
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodQuick;
        def.resolution = 512;
        qcPairList plain = qcDetectPairs(scene, &def);
        const qcResult* result = Detect(scene, qc_methodQuick, false);
        ck_assert(result->profile.reused);
        ck_assert(result->pcsSets == NULL && result->candidates == NULL && result->candidateCount == 0);
        size_t pcs = result->pcsCount;
        result = Detect(scene, qc_methodQuick, true);
        // Another request than the last one, though the same step.
        ck_assert(!result->profile.reused && result->candidateCount != 0);
        ck_assert_uint_eq(result->pcsCount, pcs);
        qcPairList reported = qcListOf(result);
        qcCheckSamePairs(&plain, &reported, "with reports");
        result = Detect(scene, qc_methodQuick, false);
        ck_assert(result->pcsSets == NULL && result->candidates == NULL && result->candidateCount == 0);
        free(plain.pairs);
        qcScene_Destroy(scene);
    }
}
END_TEST

static char s_stages[512];
static int s_open;

static void EnterStage(const char* name)
{
    ck_assert_int_eq(s_open++, 0);
    snprintf(s_stages + strlen(s_stages), sizeof s_stages - strlen(s_stages), "%s, ", name);
}

static void LeaveStage(void)
{
    s_open--;
}

START_TEST(a_profiler_receives_the_stages_in_order)
{
    static const char all[] = "qcScene cull bodies, qcScene sweep bodies, qcScene cull triangles, "
                              "qcScene sweep triangles, qcScene exact, qcScene manifolds, ";
    qcScene* scene = qcMakeScene(NULL);
    AddCrossingBodies(scene);
    qcDetectDef def = qcDefaultDetectDef();
    def.enterStage = EnterStage;
    const qcResult* result;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "enterStage"));
    def.leaveStage = LeaveStage;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_str_eq(s_stages, all);
    ck_assert_int_eq(s_open, 0);
    // A result that is reused has no stage.
    s_stages[0] = 0;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert(result->profile.reused);
    ck_assert_str_eq(s_stages, "");
    qcScene_Destroy(scene);
}
END_TEST

QC_RUN_TESTS_ON_DEVICES("reports", the_sets_are_disjoint_and_their_union_is_the_pcs,
                        no_candidate_lies_within_one_collision_free_set,
                        candidates_are_sorted_and_contain_every_pair_and_the_pcs,
                        candidates_for_contacts_are_candidates_without_neighbours,
                        what_is_not_requested_is_null_and_changes_nothing, a_profiler_receives_the_stages_in_order)
