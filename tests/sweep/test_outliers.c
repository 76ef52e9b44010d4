// Bodies with outliers: vertices that fly far away and come back, and huge triangles among small ones. The sweep finds
// what brute force finds, in work that grows with the triangles and not with their square.
#define _POSIX_C_SOURCE 200809L // setenv
#include "support/long_form.h"
#include "support/scenes.h"
#include "support/suite.h"
#include "support/transforms.h"
#include "sweep/sample_bodies.h"

#include <stdio.h>

enum
{
    qc_side = 16,  ///< of a cloth of 512 triangles
    qc_steps = 12, ///< in the first one the bodies are new
    qc_worlds = 6
};

typedef enum BodyKind
{
    qc_outlierCloth,  ///< collides with itself; positions in double
    qc_outlierFloats, ///< a cloth whose positions are floats
    qc_outlierGround, ///< small triangles, and huge ones; turned
    qc_outlierRigid,  ///< a cloth with a vertex far away; collides with itself
    qc_plainSphere,
    qc_bodyKinds
} BodyKind;

typedef struct TestBody
{
    qcBodyId id;
    qcSoup now;
    double* rest;
    float* floats;
} TestBody;

typedef struct World
{
    qcScene* scene;
    qcRandom random;
    double maxExponent; ///< of ten: outliers are up to so far away
    TestBody bodies[qc_bodyKinds];
    bool throwsPart;
    double part[3], away[3];
} World;

static double FarAway(World* w, double maxExponent)
{
    double distance = pow(10.0, qcRandom_Uniform(&w->random, 2.0, maxExponent));
    return qcRandom_Below(&w->random, 2) == 0 ? distance : -distance;
}

/// Along one axis, all axes by the same distance, or each by another.
static void ThrowVertex(World* w, double maxExponent, double x[3])
{
    uint32_t way = qcRandom_Below(&w->random, 5);
    double distance = FarAway(w, maxExponent);
    for (uint32_t axis = 0; axis < 3; axis++)
        if (way >= 3 || way == axis)
            x[axis] += way == 4 ? FarAway(w, maxExponent) : distance;
}

/// Its corners around the body: it may cut through all of it. Half of them are level.
static void BlowUp(World* w, double maxExponent, qcSoup* soup, uint32_t triangle)
{
    double size = fabs(FarAway(w, maxExponent)), height = qcRandom_Uniform(&w->random, 0.0, 1.0);
    uint32_t level = qcRandom_Below(&w->random, 6);
    for (size_t c = 0; c < 3; c++)
        for (uint32_t axis = 0; axis < 3; axis++)
            soup->positions[3 * (size_t)soup->indices[3 * triangle + c] + axis] =
                axis == level ? height : size * qcRandom_Uniform(&w->random, -1.0, 1.0);
}

static qcSoup MakeBody(World* w, BodyKind kind, uint64_t seed)
{
    if (kind == qc_plainSphere)
        return qcSoup_MakeSphere(2, 0.4);
    if (kind != qc_outlierGround)
        return qcSoup_MakeFoldedCloth(seed, qc_side, 0.02, 0.012);
    qcSoup soup = qcSoup_MakeRandom(seed, 500, 0.05);
    for (uint32_t i = 0; i < 4; i++)
        BlowUp(w, w->maxExponent, &soup, i * 100);
    return soup;
}

static void SendPositions(World* w, BodyKind kind)
{
    TestBody* b = &w->bodies[kind];
    if (kind != qc_outlierFloats)
    {
        CHECK_OK(qcScene_SetVertices(w->scene, b->id, b->now.positions, qc_positionF64, 0));
        return;
    }
    for (size_t i = 0; i < 3 * (size_t)b->now.vertexCount; i++)
        b->floats[i] = (float)b->now.positions[i];
    CHECK_OK(qcScene_SetVertices(w->scene, b->id, b->floats, qc_positionF32, 0));
}

static void AddTestBody(World* w, BodyKind kind, uint64_t seed)
{
    TestBody* b = &w->bodies[kind];
    b->now = MakeBody(w, kind, seed);
    if (kind == qc_outlierRigid)
        ThrowVertex(w, w->maxExponent, b->now.positions + 3 * (size_t)qcRandom_Below(&w->random, b->now.vertexCount));
    qcBodyDef def = qcBodyDefOf(&b->now);
    def.deforming = kind == qc_outlierCloth || kind == qc_outlierFloats;
    def.selfCollision = kind == qc_outlierCloth || kind == qc_outlierRigid;
    CHECK_OK(qcScene_AddBody(w->scene, &def, &b->id));
    size_t count = 3 * (size_t)b->now.vertexCount;
    b->rest = malloc(count * sizeof(double));
    b->floats = malloc(count * sizeof(float));
    ck_assert(b->rest != NULL && b->floats != NULL);
    memcpy(b->rest, b->now.positions, count * sizeof(double));
}

static void MakeWorld(World* w, uint64_t seed, double maxExponent)
{
    *w = (World){.scene = qcMakeScene(NULL), .random = {seed}, .maxExponent = maxExponent};
    for (int kind = 0; kind < qc_bodyKinds; kind++)
        AddTestBody(w, (BodyKind)kind, seed + (uint64_t)kind);
}

static void FreeWorld(World* w)
{
    qcScene_Destroy(w->scene);
    for (int kind = 0; kind < qc_bodyKinds; kind++)
    {
        qcSoup_Free(&w->bodies[kind].now);
        free(w->bodies[kind].rest);
        free(w->bodies[kind].floats);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

/// The vertices around a point fly away together.
static void ThrowPart(const double at[3], const double away[3], qcSoup* soup)
{
    for (size_t v = 0; v < soup->vertexCount; v++)
    {
        double* p = soup->positions + 3 * v;
        bool isNear = fabs(p[0] - at[0]) < 0.12 && fabs(p[1] - at[1]) < 0.12;
        for (int axis = 0; axis < 3 && isNear; axis++)
            p[axis] += away[axis];
    }
}

/// Some vertices fly away, others come back; a triangle grows. All cloths lose the same part.
static void ThrowSome(World* w, BodyKind kind)
{
    TestBody* b = &w->bodies[kind];
    double maxExponent = kind == qc_outlierFloats ? fmin(w->maxExponent, 37.0) : w->maxExponent;
    for (uint32_t v = 0; v < b->now.vertexCount; v++)
        if (qcRandom_Below(&w->random, 3) != 0)
            memcpy(b->now.positions + 3 * (size_t)v, b->rest + 3 * (size_t)v, 3 * sizeof(double));
    if (w->throwsPart)
        ThrowPart(w->part, w->away, &b->now);
    for (uint32_t i = qcRandom_Below(&w->random, 6); i > 0; i--)
        ThrowVertex(w, maxExponent, b->now.positions + 3 * (size_t)qcRandom_Below(&w->random, b->now.vertexCount));
    if (qcRandom_Below(&w->random, 3) == 0)
        BlowUp(w, maxExponent, &b->now, qcRandom_Below(&w->random, b->now.triangleCount));
}

/// Few vertices move little: a Verlet list follows them.
static void Shake(World* w, BodyKind kind)
{
    TestBody* b = &w->bodies[kind];
    for (uint32_t i = 0; i < b->now.vertexCount / 12; i++)
    {
        size_t at = 3 * (size_t)qcRandom_Below(&w->random, b->now.vertexCount);
        for (size_t axis = 0; axis < 3; axis++)
            b->now.positions[at + axis] += 0.004 * qcRandom_Uniform(&w->random, -1.0, 1.0);
    }
}

static void Turn(World* w, BodyKind kind)
{
    qcTransform t = qcIdentityTransform();
    qcMakeRotation(&w->random, t.linear);
    for (int axis = 0; axis < 3; axis++)
        t.translation[axis] = qcRandom_Uniform(&w->random, 0.0, 0.5);
    CHECK_OK(qcScene_SetTransform(w->scene, w->bodies[kind].id, &t));
}

static void Move(World* w, bool throws)
{
    w->throwsPart = qcRandom_Below(&w->random, 2) == 0;
    for (int axis = 0; axis < 3; axis++)
    {
        w->part[axis] = qcRandom_Uniform(&w->random, 0.0, 1.0);
        w->away[axis] = FarAway(w, fmin(w->maxExponent, 8.0));
    }
    for (int kind = 0; kind <= qc_outlierFloats; kind++)
    {
        (throws ? ThrowSome : Shake)(w, (BodyKind)kind);
        SendPositions(w, (BodyKind)kind);
    }
    for (int kind = qc_outlierGround; throws && kind < qc_bodyKinds; kind++)
        Turn(w, (BodyKind)kind);
}

typedef struct Found
{
    qcPairList pairs;
    qcContact* contacts;
    size_t contactCount;
    uint64_t followed;
} Found;

static Found Detect(const World* w, const qcDetectDef* def)
{
    const qcResult* result;
    CHECK_OK(qcScene_Detect(w->scene, def, &result));
    size_t pairBytes = result->pairCount * sizeof(qcPair), contactBytes = result->contactCount * sizeof(qcContact);
    Found found = {{malloc(pairBytes + 1), result->pairCount},
                   malloc(contactBytes + 1),
                   result->contactCount,
                   result->profile.followedTriangles};
    ck_assert(found.pairs.pairs != NULL && found.contacts != NULL);
    if (pairBytes != 0)
        memcpy(found.pairs.pairs, result->pairs, pairBytes);
    if (contactBytes != 0)
        memcpy(found.contacts, result->contacts, contactBytes);
    return found;
}

static void FreeFound(Found* found)
{
    free(found->pairs.pairs);
    free(found->contacts);
}

static void CheckContacts(const Found* expected, const Found* found, const char* what)
{
    CHECK_THAT(expected->contactCount == found->contactCount, "%s: %zu contacts, expected %zu", what,
               found->contactCount, expected->contactCount);
    for (size_t i = 0; i < found->contactCount; i++)
    {
        const qcContact *e = &expected->contacts[i], *f = &found->contacts[i];
        CHECK_THAT(e->bodyA == f->bodyA && e->bodyB == f->bodyB &&
                       memcmp(e->verticesA, f->verticesA, sizeof e->verticesA) == 0 &&
                       memcmp(e->verticesB, f->verticesB, sizeof e->verticesB) == 0,
                   "%s: contact %zu is another one", what, i);
    }
}

/// The sums of pairs, contacts and triangles that Verlet lists followed.
typedef struct Totals
{
    uint64_t pairs, contacts, followed;
} Totals;

static void Check(const World* w, qcDetectDef def, const char* what, Totals* totals)
{
    // Before brute force, which fits no BVH.
    def.method = qc_methodSweep;
    Found found = Detect(w, &def);
    def.method = qc_methodBrute;
    Found expected = Detect(w, &def);
    qcCheckSamePairs(&expected.pairs, &found.pairs, what);
    CheckContacts(&expected, &found, what);
    totals->pairs += expected.pairs.count;
    totals->contacts += expected.contactCount;
    totals->followed += found.followed;
    FreeFound(&found);
    FreeFound(&expected);
}

static void UseKernels(int i)
{
    static const char* const names[] = {"avx512", "avx2", "plain"};
    setenv("QC_KERNELS", names[i % 3], 1);
}

static double MaxExponentOf(int i)
{
    static const double exponents[] = {4.0, 8.0, 16.0, 36.0, 150.0, 300.0};
    return exponents[i % 6];
}

/// Steps in which vertices are thrown, and others that a Verlet list may follow.
static void PlayWorld(int i, Totals* totals)
{
    World w;
    MakeWorld(&w, (uint64_t)i + 1, MaxExponentOf(i));
    UseKernels(i + i / 6);
    for (int step = 0; step < qc_steps; step++)
    {
        char what[64];
        snprintf(what, sizeof what, "world %d, step %d", i, step);
        qcDetectDef def = qcDefaultDetectDef();
        def.threads = 1 + 2 * (uint32_t)(step % 2);
        def.touching = step % 3 == 0;
        def.margin = step % 4 == 0 ? 0.03 : step % 4 == 1 ? 0.005 : 0.0;
        def.contactMargin = step % 8 == 4 ? 0.01 : 0.0;
        Check(&w, def, what, totals);
        Move(&w, step % 4 == 3);
    }
    FreeWorld(&w);
}

START_TEST(bodies_with_outliers_have_the_pairs_and_contacts_of_brute_force)
{
    Totals totals = {0};
    for (int i = 0; i < (qcIsLongForm() ? 20 : 1) * qc_worlds; i++)
        PlayWorld(i, &totals);
    ck_assert_uint_gt(totals.pairs, 100000);
    ck_assert_uint_gt(totals.contacts, 1000);
    ck_assert_uint_gt(totals.followed, 1000);
}
END_TEST

START_TEST(bodies_with_outliers_have_the_pairs_of_brute_force_over_a_motion)
{
    Totals totals = {0};
    for (int i = 0; i < (qcIsLongForm() ? 20 : 1) * qc_worlds; i++)
    {
        World w;
        // Flat patches are left out by the sweep alone: the cloths are too crumpled for any.
        MakeWorld(&w, (uint64_t)i + 100, MaxExponentOf(i));
        UseKernels(i + i / 6);
        qcDetectDef def = qcDefaultDetectDef();
        for (int step = 0; step < qc_steps / 2; step++)
        {
            char what[64];
            snprintf(what, sizeof what, "motion of world %d, step %d", i, step);
            // A fit with a margin serves as the start of the next motion.
            def.motion = false;
            def.margin = step % 2 == 0 ? 0.01 : 0.0;
            def.threads = 1 + 2 * (uint32_t)(step % 2);
            Check(&w, def, what, &totals);
            CHECK_OK(qcScene_MarkStart(w.scene));
            Move(&w, step % 3 != 2);
            def.motion = true;
            def.margin = 0.0;
            Check(&w, def, what, &totals);
        }
        FreeWorld(&w);
    }
    ck_assert_uint_gt(totals.pairs, 100000);
}
END_TEST

START_TEST(rounding_in_the_world_moves_huge_triangles)
{
    // Far corners are off by a tenth of the sphere, and so is the triangle beside it.
    qcRandom random = {21};
    qcScene* scene = qcMakeScene(NULL);
    qcSoup soups[2] = {qcSoup_MakeRandom(22, 500, 0.05), qcSoup_MakeSphere(2, 0.4)};
    for (size_t c = 0; c < 3; c++)
    {
        double* p = soups[0].positions + 3 * (size_t)soups[0].indices[c];
        p[0] = c == 0 ? -1e15 : 7e14;
        p[1] = c == 1 ? -1e15 : 8e14;
        p[2] = 0.3;
    }
    qcBodyId ids[2];
    for (int body = 0; body < 2; body++)
    {
        qcBodyDef def = qcBodyDefOf(&soups[body]);
        def.selfCollision = false;
        CHECK_OK(qcScene_AddBody(scene, &def, &ids[body]));
    }
    size_t pairs = 0;
    for (int step = 0; step < 60; step++)
    {
        qcTransform t = qcIdentityTransform();
        qcMakeRotation(&random, t.linear);
        CHECK_OK(qcScene_SetTransform(scene, ids[0], &t));
        for (int axis = 0; axis < 3; axis++)
            t.translation[axis] = qcRandom_Uniform(&random, -0.5, 0.5);
        CHECK_OK(qcScene_SetTransform(scene, ids[1], &t));
        qcDetectDef def = qcDefaultDetectDef();
        def.method = qc_methodBrute;
        qcPairList expected = qcDetectPairs(scene, &def);
        def.method = qc_methodSweep;
        qcPairList found = qcDetectPairs(scene, &def);
        qcCheckSamePairs(&expected, &found, "huge triangle");
        pairs += expected.count;
        free(expected.pairs);
        free(found.pairs);
    }
    ck_assert_uint_gt(pairs, 1000);
    qcScene_Destroy(scene);
    for (int body = 0; body < 2; body++)
        qcSoup_Free(&soups[body]);
}
END_TEST

//  ---- flat patches --------------------------------------------------------------------------------------

static const qcResult* Sweep(qcScene* scene, bool motion)
{
    const qcResult* result;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.motion = motion;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    return result;
}

static uint64_t CountFlat(qcScene* scene, bool motion)
{
    const qcResult* result = Sweep(scene, motion);
    ck_assert_uint_eq(result->pairCount, 0);
    return result->profile.flatTriangles;
}

START_TEST(patches_with_outliers_are_not_taken_for_flat)
{
    // Errors of their points are larger than the test of patches allows for.
    for (int motion = 0; motion < 2; motion++)
    {
        qcSoup cloth = qcSoup_MakeGrid(48);
        uint32_t bounded = 0;
        qcScene* scene = qcMakeScene(NULL);
        qcBodyId id = qcAddDeformingSoup(scene, &cloth);
        qcLetBodiesLive(scene, qcDefaultDetectDef());
        CHECK_OK(qcScene_MarkStart(scene));
        ck_assert_uint_gt(CountFlat(scene, motion != 0), cloth.triangleCount / 10 * 9);
        for (size_t v = 0; v < cloth.vertexCount; v++)
            cloth.positions[3 * v] += cloth.positions[3 * v] > 0.8 ? 4000.0 : 0.0;
        for (uint32_t t = 0; t < cloth.triangleCount; t++)
        {
            double corners[3][3];
            qcSoup_GetTriangle(&cloth, t, corners);
            bounded += corners[0][0] < 1.0 && corners[1][0] < 1.0 && corners[2][0] < 1.0;
        }
        CHECK_OK(qcScene_SetVertices(scene, id, cloth.positions, qc_positionF64, 0));
        uint64_t flat = CountFlat(scene, motion != 0);
        ck_assert_uint_le(flat, bounded);
        ck_assert_uint_gt(flat, bounded / 2);
        qcScene_Destroy(scene);
        qcSoup_Free(&cloth);
    }
}
END_TEST

//  ---- work --------------------------------------------------------------------------------------------

enum
{
    qc_fineSide = 48 ///< of a grid of 4608 triangles
};

static qcSoup MakeHills(void)
{
    qcSoup soup = qcSoup_MakeGrid(qc_fineSide);
    for (uint32_t v = 0; v < soup.vertexCount; v++)
    {
        double* p = soup.positions + 3 * (size_t)v;
        p[2] = 0.05 * sin(9.0 * p[0]) * cos(7.0 * p[1]);
    }
    return soup;
}

static uint64_t CountCandidates(qcScene* scene, bool motion)
{
    return Sweep(scene, motion)->profile.candidates;
}

/// A vertex in the middle is far away from the first step on, or flies away after it.
static void CheckWorkOfFarVertex(double distance, bool deforming, bool isNew, bool motion)
{
    qcSoup cloth = MakeHills();
    double* middle = cloth.positions + 3 * (size_t)(cloth.vertexCount / 2);
    const double rest[3] = {middle[0], middle[1], middle[2]};
    if (isNew)
        middle[0] = middle[1] = middle[2] = distance;
    qcScene* scene = qcMakeScene(NULL);
    qcBodyDef def = qcBodyDefOf(&cloth);
    def.deforming = deforming;
    def.selfCollision = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    for (int step = 0; step < 6; step++)
    {
        CHECK_OK(qcScene_MarkStart(scene));
        for (int axis = 0; axis < 3 && deforming; axis++)
            middle[axis] = isNew || step % 3 != 0 ? distance : rest[axis];
        if (deforming)
            CHECK_OK(qcScene_SetVertices(scene, id, cloth.positions, qc_positionF64, 0));
        uint64_t candidates = CountCandidates(scene, motion);
        // A triangle around the far vertex meets boxes of most others; there are six, and their neighbours may grow.
        CHECK_THAT(candidates <= 8 * (uint64_t)cloth.triangleCount, "%u candidates at %g, step %d, %d %d %d",
                   (unsigned)candidates, distance, step, deforming, isNew, motion);
    }
    ck_assert_uint_lt(qcGetByteCount(), 16u << 20);
    qcScene_Destroy(scene);
    qcSoup_Free(&cloth);
}

START_TEST(a_far_vertex_adds_no_more_candidates_than_its_triangles_have)
{
    static const double distances[] = {-1e3, 1e3, -1e5, 1e5, -1e7, 1e7, 1e9, -1e12, 1e30, -1e150, 1e300, -1.7e308};
    for (size_t i = 0; i < sizeof distances / sizeof distances[0]; i++)
        for (int way = 0; way < 8; way++)
            CheckWorkOfFarVertex(distances[i], (way & 1) != 0, (way & 2) != 0, (way & 4) != 0);
}
END_TEST

/// Small triangles and two huge ones, which make a square of this half width.
static qcSoup MakeHillsOnGround(double width)
{
    qcSoup soup = MakeHills();
    uint32_t* ground = soup.indices + 3 * (size_t)(soup.triangleCount - 2);
    const uint32_t corners[] = {0, qc_fineSide, (qc_fineSide + 1) * qc_fineSide, soup.vertexCount - 1};
    // The triangles at the corners take other vertices.
    for (uint32_t k = 0; k < 3 * soup.triangleCount; k++)
        for (uint32_t i = 0; i < 4; i++)
            if (soup.indices[k] == corners[i])
                soup.indices[k] = qc_fineSide + 3;
    for (uint32_t i = 0; i < 4; i++)
    {
        double* p = soup.positions + 3 * (size_t)corners[i];
        p[0] = i % 2 == 0 ? -width : width;
        p[1] = i < 2 ? -width : width;
        p[2] = -0.5;
    }
    const uint32_t indices[] = {corners[0], corners[1], corners[2], corners[1], corners[3], corners[2]};
    memcpy(ground, indices, sizeof indices);
    return soup;
}

/// To this height above the hills.
static void Place(qcScene* scene, qcBodyId id, const qcSoup* soup, const qcTransform* ground, bool deforming, double up)
{
    qcTransform t = *ground;
    for (int axis = 0; axis < 3; axis++)
        t.translation[axis] = up * t.linear[3 * axis + 2];
    if (!deforming)
    {
        CHECK_OK(qcScene_SetTransform(scene, id, &t));
        return;
    }
    double* world = malloc(3 * sizeof(double) * soup->vertexCount);
    ck_assert_ptr_nonnull(world);
    for (size_t v = 0; v < soup->vertexCount; v++)
        for (size_t axis = 0; axis < 3; axis++)
        {
            const double *row = t.linear + 3 * axis, *p = soup->positions + 3 * v;
            world[3 * v + axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + t.translation[axis];
        }
    CHECK_OK(qcScene_SetVertices(scene, id, world, qc_positionF64, 0));
    free(world);
}

/// A body above hills.
static void CheckWorkAboveGround(double width, bool deforming, bool turned, bool motion)
{
    qcRandom random = {3};
    qcSoup soups[2] = {MakeHillsOnGround(width), MakeHills()};
    qcScene* scene = qcMakeScene(NULL);
    qcTransform ground = qcIdentityTransform();
    if (turned)
        qcMakeRotation(&random, ground.linear);
    qcBodyId ids[2];
    for (int body = 0; body < 2; body++)
    {
        qcBodyDef def = qcBodyDefOf(&soups[body]);
        def.selfCollision = false;
        def.deforming = body == 1 && deforming;
        CHECK_OK(qcScene_AddBody(scene, &def, &ids[body]));
    }
    CHECK_OK(qcScene_SetTransform(scene, ids[0], &ground));
    for (int step = 0; step < 4; step++)
    {
        Place(scene, ids[1], &soups[1], &ground, deforming, 0.05 + 0.001 * step);
        if (step > 0)
        {
            uint64_t candidates = CountCandidates(scene, motion);
            CHECK_THAT(candidates <= 4 * (uint64_t)soups[1].triangleCount, "%u candidates above %g, step %d, %d %d %d",
                       (unsigned)candidates, width, step, deforming, turned, motion);
        }
        CHECK_OK(qcScene_MarkStart(scene));
    }
    qcScene_Destroy(scene);
    for (int body = 0; body < 2; body++)
        qcSoup_Free(&soups[body]);
}

START_TEST(huge_triangles_among_small_ones_add_no_more_candidates_than_they_have)
{
    static const double widths[] = {1e3, 1e5, 1e6, 1e8, 1e10};
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; i++)
        for (int way = 0; way < 8; way++)
            CheckWorkAboveGround(widths[i], (way & 1) != 0, (way & 2) != 0, (way & 4) != 0);
}
END_TEST

START_TEST(two_halves_far_apart_have_no_more_candidates_than_boxes_that_overlap)
{
    // No lattice suits both halves: triangles of one of them share a level.
    qcSoup cloth = MakeHills();
    for (size_t v = 0; v < cloth.vertexCount; v++)
        cloth.positions[3 * v] += cloth.positions[3 * v] > 0.51 ? 1e7 : 0.0;
    qcScene* scene = qcMakeScene(NULL);
    (void)qcAddDeformingSoup(scene, &cloth);
    qcDetectDef def = qcDefaultDetectDef();
    for (int motion = 0; motion < 2; motion++)
    {
        const qcResult* result;
        def.motion = motion != 0;
        CHECK_OK(qcScene_MarkStart(scene));
        def.method = qc_methodBrute;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        uint64_t brute = result->profile.candidates;
        for (int step = 0; step < 3; step++)
            ck_assert_uint_le(CountCandidates(scene, def.motion), brute);
    }
    qcScene_Destroy(scene);
    qcSoup_Free(&cloth);
}
END_TEST

QC_RUN_TESTS("outliers", bodies_with_outliers_have_the_pairs_and_contacts_of_brute_force,
             bodies_with_outliers_have_the_pairs_of_brute_force_over_a_motion,
             rounding_in_the_world_moves_huge_triangles, patches_with_outliers_are_not_taken_for_flat,
             a_far_vertex_adds_no_more_candidates_than_its_triangles_have,
             huge_triangles_among_small_ones_add_no_more_candidates_than_they_have,
             two_halves_far_apart_have_no_more_candidates_than_boxes_that_overlap)
