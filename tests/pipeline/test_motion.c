// Pairs over a motion: the sweep against brute force, and both against rational arithmetic at sampled times.
#define _POSIX_C_SOURCE 200809L // setenv
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>

enum
{
    // Times k / 16: with coordinates of 24 bits, positions at these times are exact in double.
    qc_times = 16,
    qc_maxBodies = 4
};

/// A body at the start and at the end.
typedef struct Moving
{
    qcSoup start, end; ///< of a rigid body: in local coordinates, equal
    bool deforming, selfCollision;
    qcTransform from, to;
    qcBodyId id;
} Moving;

typedef struct MovingScene
{
    qcScene* scene;
    Moving bodies[qc_maxBodies];
    uint32_t count;
} MovingScene;

static qcSoup CopyOf(const qcSoup* soup)
{
    qcSoup copy = *soup;
    copy.positions = malloc(3 * sizeof(double) * soup->vertexCount);
    copy.indices = malloc(3 * sizeof(uint32_t) * soup->triangleCount);
    memcpy(copy.positions, soup->positions, 3 * sizeof(double) * soup->vertexCount);
    memcpy(copy.indices, soup->indices, 3 * sizeof(uint32_t) * soup->triangleCount);
    return copy;
}

static Moving* AddBody(MovingScene* s, qcSoup start, qcSoup end, bool deforming, bool selfCollision)
{
    Moving* body = &s->bodies[s->count++];
    *body = (Moving){start, end, deforming, selfCollision, qcIdentityTransform(), qcIdentityTransform(), {0, 0}};
    qcBodyDef def = qcBodyDefOf(&start);
    def.deforming = deforming;
    def.selfCollision = selfCollision;
    CHECK_OK(qcScene_AddBody(s->scene, &def, &body->id));
    return body;
}

static void FreeScene(MovingScene* s)
{
    for (uint32_t i = 0; i < s->count; i++)
    {
        qcSoup_Free(&s->bodies[i].start);
        qcSoup_Free(&s->bodies[i].end);
    }
    qcScene_Destroy(s->scene);
}

/// Puts all bodies at the start, marks it, and moves them to the end.
static void MoveBodies(const MovingScene* s)
{
    for (int t = 0; t < 2; t++)
    {
        for (uint32_t i = 0; i < s->count; i++)
        {
            const Moving* b = &s->bodies[i];
            if (b->deforming)
                CHECK_OK(
                    qcScene_SetVertices(s->scene, b->id, (t == 0 ? &b->start : &b->end)->positions, qc_positionF64, 0));
            else
                CHECK_OK(qcScene_SetTransform(s->scene, b->id, t == 0 ? &b->from : &b->to));
        }
        if (t == 0)
            CHECK_OK(qcScene_MarkStart(s->scene));
    }
}

static void GetCorners(const Moving* body, uint32_t triangle, double corners[2][3][3])
{
    for (int t = 0; t < 2; t++)
    {
        qcSoup_GetTriangle(t == 0 ? &body->start : &body->end, triangle, corners[t]);
        const qcTransform* transform = t == 0 ? &body->from : &body->to;
        for (int c = 0; c < 3 && !body->deforming; c++)
        {
            double p[3];
            memcpy(p, corners[t][c], sizeof p);
            for (int axis = 0; axis < 3; axis++)
            {
                const double* row = transform->linear + 3 * axis;
                corners[t][c][axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + transform->translation[axis];
            }
        }
    }
}

/// True if two triangles have a common point at one of the sampled times.
static bool Meet(const Moving* a, uint32_t triangleA, const Moving* b, uint32_t triangleB)
{
    double p[2][3][3], q[2][3][3];
    GetCorners(a, triangleA, p);
    GetCorners(b, triangleB, q);
    for (int k = 0; k <= qc_times; k++)
    {
        double at = k / (double)qc_times, x[3][3], y[3][3];
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
            {
                x[c][axis] = (1.0 - at) * p[0][c][axis] + at * p[1][c][axis];
                y[c][axis] = (1.0 - at) * q[0][c][axis] + at * q[1][c][axis];
            }
        if (qcRelateTriangles(x[0], y[0]) != qc_relationDisjoint)
            return true;
    }
    return false;
}

static bool Contains(const qcPairList* list, const qcPair* pair)
{
    return bsearch(pair, list->pairs, list->count, sizeof *pair, qcComparePairs) != NULL;
}

/// No pair that is left out meets. Returns the number of those tested.
static size_t CheckOthersStayApart(const MovingScene* s, const qcPairList* found)
{
    size_t tested = 0;
    for (uint32_t i = 0; i < s->count; i++)
        for (uint32_t k = s->bodies[i].selfCollision ? i : i + 1; k < s->count; k++)
            for (uint32_t t = 0; t < s->bodies[i].start.triangleCount; t++)
                for (uint32_t u = i == k ? t + 1 : 0; u < s->bodies[k].start.triangleCount; u++)
                {
                    const qcPair pair = {s->bodies[i].id.slot, t, s->bodies[k].id.slot, u, qc_relationDisjoint};
                    if ((i == k && qcSoup_AreNeighbours(&s->bodies[i].start, t, u)) || Contains(found, &pair))
                        continue;
                    tested++;
                    if (Meet(&s->bodies[i], t, &s->bodies[k], u))
                        ck_abort_msg("triangle %u of body %u meets triangle %u of body %u", t, i, u, k);
                }
    return tested;
}

/// The sweep, with one and with more threads, finds what brute force finds. Returns the number of pairs.
static size_t CheckMethods(const MovingScene* s, bool neighbours, bool samples)
{
    MoveBodies(s);
    qcDetectDef def = qcDefaultDetectDef();
    def.motion = true;
    def.neighbours = neighbours;
    def.method = qc_methodBrute;
    qcPairList expected = qcDetectPairs(s->scene, &def);
    if (samples && !neighbours)
        (void)CheckOthersStayApart(s, &expected);
    for (uint32_t threads = 1; threads <= 3; threads++)
    {
        def.method = threads == 3 ? qc_methodAuto : qc_methodSweep;
        def.threads = threads;
        qcPairList found = qcDetectPairs(s->scene, &def);
        qcCheckSamePairs(&expected, &found, "sweep");
        free(found.pairs);
    }
    size_t count = expected.count;
    free(expected.pairs);
    return count;
}

static void Jitter(qcRandom* random, double size, qcSoup* soup)
{
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        soup->positions[i] += qcRandom_Uniform(random, -size, size);
}

static qcTransform Turned(qcRandom* random, double shift)
{
    double a = qcRandom_Uniform(random, -2, 2), c = cos(a), s = sin(a);
    qcTransform t = {{c, -s, 0, s, c, 0, 0, 0, 1}, {0, 0, 0}};
    for (int axis = 0; axis < 3; axis++)
        t.translation[axis] = qcRandom_Uniform(random, -shift, shift);
    return t;
}

/// Each instruction set in turn; one that this CPU doesn't run is replaced by the best that it does.
static void UseKernels(int i)
{
    static const char* const names[] = {"avx512", "avx2", "plain"};
    setenv("QC_KERNELS", names[i % 3], 1);
}

//  ---- tests ---------------------------------------------------------------------------------------------

START_TEST(the_sweep_reports_what_brute_force_reports_for_soups)
{
    UseKernels(_i);
    qcRandom random = {(uint64_t)_i + 1};
    static const double sizes[] = {0.02, 0.1, 0.5, 3.0};
    MovingScene s = {.scene = qcMakeScene(NULL)};
    for (uint64_t body = 0; body < 3; body++)
    {
        qcSoup start = qcSoup_MakeDegenerate(17 * (uint64_t)_i + body, 90, 0.1, body == 2 ? 0.3 : 0.0);
        qcSoup end = CopyOf(&start);
        if (body != 1)
            Jitter(&random, sizes[_i % 4], &end);
        qcSoup_RoundToFloat(&start);
        qcSoup_RoundToFloat(&end);
        Moving* moving = AddBody(&s, start, end, body != 1, body != 2);
        moving->from = Turned(&random, 0.2);
        moving->to = Turned(&random, 0.5);
        if (moving->deforming)
            moving->from = moving->to = qcIdentityTransform();
    }
    ck_assert_uint_gt(CheckMethods(&s, false, true), 0);
    CheckMethods(&s, true, false);
    FreeScene(&s);
}
END_TEST

START_TEST(the_sweep_reports_what_brute_force_reports_for_rigid_bodies)
{
    UseKernels(_i);
    qcRandom random = {(uint64_t)_i + 100};
    MovingScene s = {.scene = qcMakeScene(NULL)};
    for (uint32_t body = 0; body < 3; body++)
    {
        qcSoup soup = qcSoup_MakeSphere(2, 0.4);
        qcSoup_RoundToFloat(&soup);
        Moving* moving = AddBody(&s, soup, CopyOf(&soup), false, body == 0 && _i % 2 == 0);
        moving->from = Turned(&random, 1.0);
        moving->to = Turned(&random, _i % 3 == 0 ? 50.0 : 1.5);
    }
    CheckMethods(&s, false, false);
    FreeScene(&s);
}
END_TEST

START_TEST(the_sweep_reports_what_brute_force_reports_for_cloth)
{
    UseKernels(_i);
    qcRandom random = {(uint64_t)_i + 200};
    MovingScene s = {.scene = qcMakeScene(NULL)};
    // Layers closer to each other than nodes are wide share nodes, and have no flat patches.
    bool isTight = _i % 3 == 2;
    qcSoup cloth = qcSoup_MakeFoldedCloth(3, 24, isTight ? 0.01 : 0.5, 0.002), end = CopyOf(&cloth);
    // Thrown, turned and bent; the layers press into each other in odd runs.
    double angle = 0.2 * (_i % 4), c = cos(angle), n = sin(angle);
    for (uint32_t v = 0; v < end.vertexCount; v++)
    {
        double* p = end.positions + 3 * (size_t)v;
        double x = p[0], z = p[2] * (_i % 2 == 0 ? 1.0 : 0.4) + 0.05 * sin(4.0 * x) * (_i % 3);
        p[0] = c * x - n * z + 10.0 * (_i % 5);
        p[2] = n * x + c * z;
    }
    Jitter(&random, 0.0005, &end);
    qcSoup_RoundToFloat(&cloth);
    qcSoup_RoundToFloat(&end);
    AddBody(&s, cloth, end, true, true);
    CheckMethods(&s, false, true);
    const qcResult* result;
    qcDetectDef def = qcDefaultDetectDef();
    def.motion = true;
    def.method = qc_methodSweep;
    qcPairList early = qcDetectPairs(s.scene, &def);
    qcLetBodiesLive(s.scene, def);
    CHECK_OK(qcScene_Detect(s.scene, &def, &result));
    // Flat patches are skipped in motion, too.
    ck_assert(isTight || result->profile.flatTriangles > (_i % 3 == 0 ? 100 : 0));
    ck_assert_uint_eq(result->pairCount, early.count);
    ck_assert(early.count == 0 || memcmp(result->pairs, early.pairs, early.count * sizeof(qcPair)) == 0);
    free(early.pairs);
    FreeScene(&s);
}
END_TEST

START_TEST(what_the_sweep_leaves_out_of_a_turning_cloth_never_meets)
{
    // It proves pairs of flat parts together, which brute force proves one by one.
    UseKernels(_i);
    qcRandom random = {(uint64_t)_i + 300};
    MovingScene s = {.scene = qcMakeScene(NULL)};
    qcSoup cloth = qcSoup_MakeGrid(16), end;
    double bend = 0.1 * (_i % 3);
    for (uint32_t v = 0; v < cloth.vertexCount; v++)
        cloth.positions[3 * (size_t)v + 2] = bend * sin(5.0 * cloth.positions[3 * (size_t)v]);
    Jitter(&random, 0.01, &cloth);
    end = CopyOf(&cloth);
    // The middle turns more than the rim in half of the cases.
    for (uint32_t v = 0; v < end.vertexCount; v++)
    {
        double* p = end.positions + 3 * (size_t)v;
        double x = p[0] - 0.5, y = p[1] - 0.5, angle = 0.25 * _i;
        angle *= _i % 2 == 0 ? 1.0 : 1.0 - fmin(1.0, 2.0 * sqrt(x * x + y * y));
        p[0] = cos(angle) * x - sin(angle) * y;
        p[1] = sin(angle) * x + cos(angle) * y;
    }
    Jitter(&random, 0.002, &end);
    qcSoup_RoundToFloat(&cloth);
    qcSoup_RoundToFloat(&end);
    AddBody(&s, cloth, end, true, true);
    MoveBodies(&s);
    qcDetectDef def = qcDefaultDetectDef();
    def.motion = true;
    def.method = qc_methodBrute;
    qcPairList all = qcDetectPairs(s.scene, &def);
    def.method = qc_methodSweep;
    qcPairList found = qcDetectPairs(s.scene, &def);
    for (size_t i = 0; i < found.count; i++)
        ck_assert(Contains(&all, &found.pairs[i]));
    ck_assert_uint_gt(CheckOthersStayApart(&s, &found), 1000);
    free(all.pairs);
    free(found.pairs);
    FreeScene(&s);
}
END_TEST

START_TEST(steps_of_a_cloth_report_the_same_as_a_new_scene)
{
    // The start's boxes are those of the last end, with and without a query within a margin in between.
    qcRandom random = {7};
    MovingScene s = {.scene = qcMakeScene(NULL)};
    qcSoup cloth = qcSoup_MakeFoldedCloth(5, 20, 0.01, 0.001);
    AddBody(&s, cloth, CopyOf(&cloth), true, true);
    for (int step = 0; step < 12; step++)
    {
        Moving* b = &s.bodies[0];
        // No detection has seen the start in some steps. Flat patches crumple in the last ones.
        if (step % 4 == 3)
        {
            Jitter(&random, 0.01, &b->end);
            CHECK_OK(qcScene_SetVertices(s.scene, b->id, b->end.positions, qc_positionF64, 0));
        }
        CHECK_OK(qcScene_MarkStart(s.scene));
        memcpy(b->start.positions, b->end.positions, 3 * sizeof(double) * b->end.vertexCount);
        // Few vertices in some steps: then only these are refitted.
        if (step % 3 == 2)
            b->end.positions[3 * 50 + 2] += 0.02;
        else
            Jitter(&random, step < 6 ? 0.004 : 0.03, &b->end);
        CHECK_OK(qcScene_SetVertices(s.scene, b->id, b->end.positions, qc_positionF64, 0));
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.contactMargin = 0.01;
        const qcResult* result;
        if (step % 2 == 1)
            CHECK_OK(qcScene_Detect(s.scene, &def, &result));
        def = qcDefaultDetectDef();
        def.method = qc_methodSweep;
        def.motion = true;
        qcPairList found = qcDetectPairs(s.scene, &def);
        MovingScene fresh = {.scene = qcMakeScene(NULL)};
        AddBody(&fresh, CopyOf(&b->start), CopyOf(&b->end), true, true);
        MoveBodies(&fresh);
        def.method = qc_methodBrute;
        qcPairList expected = qcDetectPairs(fresh.scene, &def);
        qcCheckSamePairs(&expected, &found, "a step");
        free(found.pairs);
        free(expected.pairs);
        FreeScene(&fresh);
    }
    FreeScene(&s);
}
END_TEST

START_TEST(a_pair_has_the_relation_and_the_distance_of_the_start)
{
    static const double below[] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, above[] = {0, 0, 1, 1, 0, 1, 0, 1, 1},
                        passed[] = {0, 0, -1, 1, 0, -1, 0, 1, -1};
    static const uint32_t indices[] = {0, 1, 2};
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef body = qcDefaultBodyDef();
    body.positionType = qc_positionF64;
    body.vertexCount = 3;
    body.indices = indices;
    body.triangleCount = 1;
    body.deforming = true;
    qcBodyId a, b;
    body.positions = above;
    CHECK_OK(qcScene_AddBody(scene, &body, &a));
    CHECK_OK(qcScene_MarkStart(scene));
    body.positions = below;
    CHECK_OK(qcScene_AddBody(scene, &body, &b)); // without motion: it was added after the mark
    qcDetectDef def = qcDefaultDetectDef();
    def.motion = true;
    def.proximities = true;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->pairCount, 0);
    CHECK_OK(qcScene_SetVertices(scene, a, passed, qc_positionF64, 0));
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->pairCount, 1);
    ck_assert_int_eq(result->pairs[0].relation, qc_relationDisjoint);
    ck_assert_double_eq_tol(result->proximities[0].distance, 1.0, 1e-12);
    ck_assert_double_eq_tol(result->proximities[0].normal[2], 1.0, 1e-12);
    // The next motion begins where this one ended.
    CHECK_OK(qcScene_MarkStart(scene));
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert_uint_eq(result->pairCount, 0);
    qcScene_Destroy(scene);
}
END_TEST

START_TEST(what_a_motion_lacks_is_refused)
{
    qcScene* scene = qcMakeScene(NULL);
    const qcResult* result = NULL;
    for (int i = 0; i < 6; i++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.motion = true;
        def.margin = i == 0 ? 0.1 : 0.0;
        def.contactMargin = i == 1 ? 0.1 : 0.0;
        def.segments = i == 2;
        def.manifolds = i == 3;
        def.method = i == 4 ? qc_methodQuick : i == 5 ? qc_methodCullide : qc_methodAuto;
        ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusBadInput);
        ck_assert_ptr_nonnull(strstr(qcLastMessage(), "motion"));
    }
    ck_assert_int_eq(qcScene_MarkStart(NULL), qc_statusBadInput);
    qcScene_Destroy(scene);
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("motion");
    tcase_add_loop_test(tests, the_sweep_reports_what_brute_force_reports_for_soups, 0, 12);
    tcase_add_loop_test(tests, the_sweep_reports_what_brute_force_reports_for_rigid_bodies, 0, 24);
    tcase_add_loop_test(tests, the_sweep_reports_what_brute_force_reports_for_cloth, 0, 20);
    tcase_add_loop_test(tests, what_the_sweep_leaves_out_of_a_turning_cloth_never_meets, 0, 9);
    tcase_add_test(tests, steps_of_a_cloth_report_the_same_as_a_new_scene);
    tcase_add_test(tests, a_pair_has_the_relation_and_the_distance_of_the_start);
    tcase_add_test(tests, what_a_motion_lacks_is_refused);
    return qcRunCase("motion", tests);
}
