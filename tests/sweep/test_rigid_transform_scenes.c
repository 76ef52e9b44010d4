// Scenes of rotated, sheared and flattened rigid bodies, near and far, with BVHs and with brute force.
#define _POSIX_C_SOURCE 200809L // setenv
#include "scene/bodies.h"
#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"
#include "support/transforms.h"

#include <math.h>
#include <stdio.h>

//  ---- both methods --------------------------------------------------------------------------------

typedef struct Totals
{
    size_t pairs, contacts;
} Totals;

static void CheckSameContacts(const qcContact* expected, const qcResult* result, const char* what)
{
    for (size_t i = 0; i < result->contactCount; i++)
    {
        const qcContact *e = &expected[i], *f = &result->contacts[i];
        CHECK_THAT(e->bodyA == f->bodyA && e->bodyB == f->bodyB && e->distance == f->distance &&
                       memcmp(e->verticesA, f->verticesA, sizeof e->verticesA) == 0 &&
                       memcmp(e->verticesB, f->verticesB, sizeof e->verticesB) == 0,
                   "%s: contact %zu is another", what, i);
    }
}

/// BVHs find the pairs and contacts of brute force.
static void CheckStep(qcScene* scene, qcDetectDef def, const char* what, Totals* totals)
{
    def.method = qc_methodBrute;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    size_t contactCount = result->contactCount;
    qcPairList expected = {malloc((result->pairCount + 1) * sizeof(qcPair)), result->pairCount};
    qcContact* contacts = malloc((contactCount + 1) * sizeof(qcContact));
    ck_assert(expected.pairs != NULL && contacts != NULL);
    if (expected.count != 0)
        memcpy(expected.pairs, result->pairs, expected.count * sizeof(qcPair));
    if (contactCount != 0)
        memcpy(contacts, result->contacts, contactCount * sizeof(qcContact));
    def.method = qc_methodSweep;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    qcPairList found = qcListOf(result);
    qcCheckSamePairs(&expected, &found, what);
    CHECK_THAT(result->contactCount == contactCount, "%s: %zu contacts, expected %zu", what, result->contactCount,
               contactCount);
    CheckSameContacts(contacts, result, what);
    totals->pairs += expected.count;
    totals->contacts += contactCount;
    free(expected.pairs);
    free(contacts);
}

//  ---- any world -----------------------------------------------------------------------------------

enum
{
    qc_bodiesInWorld = 7,
    qc_largeSide = 47 ///< of a cloth of 4418 triangles: it has no BVH in the first step
};

typedef struct World
{
    qcScene* scene;
    double size, away;                                       ///< of the world, and its distance from the origin
    double unit[qc_bodiesInWorld], centre[qc_bodiesInWorld]; ///< of local coordinates
    bool deforming[qc_bodiesInWorld];
    qcSoup soup[qc_bodiesInWorld];
    qcBodyId ids[qc_bodiesInWorld];
} World;

/// A transform that moves the body's centre to a random point of the world.
static qcTransform AnyTransform(qcRandom* random, const World* world, int body)
{
    qcTransform t = qcIdentityTransform();
    qcMakeAnyLinear(random, -1, 1, t.linear);
    // Sometimes one or two directions are flattened, exactly or nearly.
    if (qcRandom_Below(random, 8) == 0)
        qcMakeLinear(random, qcRandom_Below(random, 2) == 0 ? qc_shapePlate : qc_shapeNeedle,
                     qcRandom_Below(random, 2) == 0 ? 0.0 : exp2(-qcRandom_Uniform(random, 11.0, 60.0)), 1.0, t.linear);
    for (int i = 0; i < 9; i++)
        t.linear[i] *= world->size / world->unit[body];
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = t.linear + 3 * axis;
        t.translation[axis] = (world->away + qcRandom_Uniform(random, -0.8, 0.8)) * world->size -
                              (row[0] + row[1] + row[2]) * world->centre[body];
    }
    return t;
}

static void AddBody(qcRandom* random, World* world, int body, bool large)
{
    world->deforming[body] = !large && qcRandom_Below(random, 5) == 0;
    world->unit[body] = ldexp(world->size, (int)qcRandom_Integer(random, -2, 2) * 30);
    world->centre[body] = world->unit[body] * (qcRandom_Below(random, 3) == 0 ? 100.0 : 0.5);
    if (world->deforming[body])
    {
        world->unit[body] = world->size;
        world->centre[body] = (world->away + 0.2) * world->size;
    }
    qcSoup* soup = &world->soup[body];
    *soup = large ? qcSoup_MakeFoldedCloth(qcRandom_Next(random), qc_largeSide, 0.3, 0.01)
                  : qcMakeSoup((qcSoupKind)qcRandom_Below(random, qc_soupKindCount), qcRandom_Next(random));
    double to = world->centre[body] - 0.5 * world->unit[body];
    qcSoup_Place(soup, world->unit[body], to, to, to);
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = world->deforming[body];
    def.selfCollision = qcRandom_Below(random, 4) == 0;
    if (!def.deforming)
        def.transform = AnyTransform(random, world, body);
    CHECK_OK(qcScene_AddBody(world->scene, &def, &world->ids[body]));
}

static void ChangeWorld(qcRandom* random, World* world)
{
    for (int body = 0; body < qc_bodiesInWorld; body++)
    {
        qcTransform t = AnyTransform(random, world, body);
        qcBodyId id = world->ids[body];
        switch (qcRandom_Below(random, 8))
        {
            case 0: CHECK_OK(qcScene_SetSelfCollision(world->scene, id, qcRandom_Below(random, 3) == 0)); break;
            case 1: CHECK_OK(qcScene_SetActivity(world->scene, id, (qcActivity)qcRandom_Below(random, 3))); break;
            case 2: break;
            default:
                if (!world->deforming[body])
                    CHECK_OK(qcScene_SetTransform(world->scene, id, &t));
        }
    }
}

static void PlayWorld(uint64_t seed, bool large, double away, int exponent, Totals* totals)
{
    qcRandom random = {seed};
    World world = {.scene = qcMakeScene(NULL), .size = ldexp(1.0, exponent), .away = away};
    for (int body = 0; body < qc_bodiesInWorld; body++)
        AddBody(&random, &world, body, large && body == 3);
    const double margins[] = {0.0, 0.005, 0.0, 0.02, 1e-6};
    for (int step = 0; step < 5; step++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.margin = world.size * margins[step];
        def.contactMargin = step == 2 && !large ? 0.004 * world.size : 0.0;
        def.threads = 1 + (uint32_t)(seed + (uint64_t)step) % 2;
        char what[80];
        snprintf(what, sizeof what, "world %d, step %d, %g away, 2^%d", (int)seed, step, away, exponent);
        CheckStep(world.scene, def, what, totals);
        ChangeWorld(&random, &world);
    }
    qcScene_Destroy(world.scene);
    for (int body = 0; body < qc_bodiesInWorld; body++)
        qcSoup_Free(&world.soup[body]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

START_TEST(rigid_bodies_have_the_pairs_of_brute_force_anywhere)
{
    const double away[] = {0.0, 1e3, 1e9, 1e12};
    const int exponents[] = {0, -40, 60};
    Totals totals = {0};
    for (uint64_t seed = 0; seed < 12; seed++)
        PlayWorld(seed, seed % 5 == 0, away[seed % 4], exponents[seed / 4 % 3], &totals);
    ck_assert(totals.pairs > 10000 && totals.contacts > 1000);
}
END_TEST

//  ---- constructed touches -------------------------------------------------------------------------

static void GetWorld(const qcSoup* soup, const qcTransform* transform, uint32_t vertex, double world[3])
{
    qcBody body = {.local = soup->positions, .transform = *transform};
    qcBody_GetVertex(&body, vertex, world);
}

/// Moves the body so that its vertex coincides with a point exactly. False: no double does that.
static bool BringTo(const qcSoup* soup, uint32_t vertex, const double point[3], qcTransform* transform)
{
    double at[3];
    memset(transform->translation, 0, sizeof transform->translation);
    GetWorld(soup, transform, vertex, at);
    for (int axis = 0; axis < 3; axis++)
        transform->translation[axis] = point[axis] - at[axis];
    GetWorld(soup, transform, vertex, at);
    return memcmp(at, point, sizeof at) == 0;
}

static uint32_t LowestVertex(const qcSoup* soup, const qcTransform* transform)
{
    uint32_t lowest = 0;
    double least = INFINITY, at[3];
    for (uint32_t v = 0; v < soup->vertexCount; v++)
    {
        GetWorld(soup, transform, v, at);
        lowest = at[2] < least ? v : lowest;
        least = fmin(least, at[2]);
    }
    return lowest;
}

/// A body stands with one vertex on a triangle of a level floor, or on a vertex of any body.
static bool Stand(qcRandom* random, const qcSoup soups[2], bool onFace, double away, qcTransform transforms[2])
{
    for (int side = 0; side < 2; side++)
    {
        transforms[side] = qcIdentityTransform();
        qcMakeAnyLinear(random, -20, 20, transforms[side].linear);
        for (int axis = 0; axis < 3; axis++)
            transforms[side].translation[axis] = away * qcRandom_Uniform(random, -1.0, 1.0);
    }
    double* linear = transforms[1].linear;
    if (!onFace)
    {
        double point[3];
        GetWorld(&soups[1], &transforms[1], soups[1].indices[qcRandom_Below(random, 3 * soups[1].triangleCount)],
                 point);
        return BringTo(&soups[0], qcRandom_Below(random, soups[0].vertexCount), point, &transforms[0]);
    }
    linear[6] = linear[7] = 0.0;
    uint32_t vertex = LowestVertex(&soups[0], &transforms[0]);
    const uint32_t* index = soups[1].indices + 3 * (size_t)qcRandom_Below(random, soups[1].triangleCount);
    double corner[3][3], point[3];
    for (int c = 0; c < 3; c++)
        GetWorld(&soups[1], &transforms[1], index[c], corner[c]);
    for (int axis = 0; axis < 3; axis++)
        point[axis] = axis == 2 ? corner[0][2] : 0.5 * corner[0][axis] + 0.3 * corner[1][axis] + 0.2 * corner[2][axis];
    return BringTo(&soups[0], vertex, point, &transforms[0]);
}

START_TEST(a_vertex_that_stands_on_another_body_touches_it)
{
    qcRandom random = {5};
    size_t standing = 0;
    const char* kernels[] = {"plain", "avx2", "avx512"};
    for (int i = 0; i < 400; i++)
    {
        setenv("QC_KERNELS", kernels[i % 3], 1);
        bool onFace = i % 2 == 0;
        qcSoup soups[2] = {qcSoup_MakeRandom(qcRandom_Next(&random), 20, 0.3),
                           onFace ? qcSoup_MakeGrid(3) : qcMakeSoup((qcSoupKind)(i / 2 % qc_soupKindCount), 1)};
        double away = i % 3 == 0 ? 0.0 : pow(10.0, qcRandom_Integer(&random, 0, 12));
        qcTransform transforms[2];
        bool stands = Stand(&random, soups, onFace, away, transforms);
        qcScene* scene = qcMakeScene(NULL);
        for (int side = 0; side < 2; side++)
        {
            qcBodyDef def = qcBodyDefOf(&soups[side]);
            def.selfCollision = false;
            def.transform = transforms[side];
            qcBodyId id;
            CHECK_OK(qcScene_AddBody(scene, &def, &id));
        }
        Totals found = {0};
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        char what[40];
        snprintf(what, sizeof what, "number %d", i);
        CheckStep(scene, def, what, &found);
        CHECK_THAT(!stands || onFace || found.pairs != 0, "%s touches nothing", what);
        standing += stands && found.pairs != 0;
        qcScene_Destroy(scene);
        for (int side = 0; side < 2; side++)
            qcSoup_Free(&soups[side]);
    }
    unsetenv("QC_KERNELS");
    ck_assert_uint_gt(standing, 200);
}
END_TEST

START_TEST(faces_that_coincide_touch_and_those_at_the_margin_are_within_it)
{
    qcSoup soup = qcSoup_MakeGrid(5);
    for (int i = 0; i < 60; i++)
    {
        // Multiples of powers of two: positions are exact, also far away and after scaling.
        double gap = i % 3 == 0 ? 0.0 : ldexp(1.0, -(i % 7)), scale = ldexp(1.0, i % 5 * 20 - 40);
        qcScene* scene = qcMakeScene(NULL);
        qcBodyId ids[2];
        for (int side = 0; side < 2; side++)
        {
            qcBodyDef def = qcBodyDefOf(&soup);
            def.selfCollision = false;
            for (int axis = 0; axis < 3; axis++)
            {
                def.transform.linear[4 * axis] = side == 0 ? scale : -scale;
                def.transform.translation[axis] = scale * (0x1p30 * (i % 4) + (side == 0 ? 0.0 : 0.75));
            }
            def.transform.translation[2] = scale * (0x1p30 * (i % 4) + gap * side);
            CHECK_OK(qcScene_AddBody(scene, &def, &ids[side]));
        }
        Totals totals = {0}, less = {0};
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        def.margin = scale * gap;
        CheckStep(scene, def, "at the margin", &totals);
        ck_assert_uint_gt(totals.pairs, 50);
        def.margin = nextafter(scale * gap, 0.0);
        CheckStep(scene, def, "beyond the margin", &less);
        ck_assert_int_eq(less.pairs == 0, gap != 0.0);
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
}
END_TEST

START_TEST(a_plate_between_two_others_is_within_the_margin_of_one)
{
    // No box of the plate meets a box of the others, in whose lattice it lies: only the margin brings them together.
    qcSoup soups[2] = {qcSoup_MakeGrid(12), qcSoup_MakeSheets(2, 12, 1.0)};
    qcRandom random = {17};
    for (int i = 0; i < 12; i++)
    {
        const double gap = 0.2;
        double rotation[9];
        qcMakeRotation(&random, rotation);
        qcScene* scene = qcMakeScene(NULL);
        for (int side = 0; side < 2; side++)
        {
            int soup = i % 2 == 0 ? side : 1 - side;
            qcBodyDef def = qcBodyDefOf(&soups[soup]);
            def.selfCollision = false;
            memcpy(def.transform.linear, rotation, sizeof rotation);
            for (int axis = 0; axis < 3 && soup == 0; axis++)
                def.transform.translation[axis] = gap * rotation[3 * axis + 2];
            qcBodyId id;
            CHECK_OK(qcScene_AddBody(scene, &def, &id));
        }
        Totals within = {0}, beyond = {0};
        qcDetectDef def = qcDefaultDetectDef();
        def.margin = 1.01 * gap;
        CheckStep(scene, def, "within the margin", &within);
        ck_assert_uint_ge(within.pairs, soups[0].triangleCount);
        def.margin = 0.99 * gap;
        CheckStep(scene, def, "beyond the margin", &beyond);
        ck_assert_uint_eq(beyond.pairs, 0);
        qcScene_Destroy(scene);
    }
    for (int i = 0; i < 2; i++)
        qcSoup_Free(&soups[i]);
}
END_TEST

START_TEST(bodies_that_shrink_to_a_point_touch)
{
    // Products below the smallest double are 0: both bodies become one point.
    const double sizes[] = {1e-270, 1e-280, 1e-285}, scales[] = {1e-59, 1e-50, 1e-45};
    for (int i = 0; i < 3; i++)
    {
        qcScene* scene = qcMakeScene(NULL);
        qcSoup soup = qcSoup_MakeSphere(1, 1.0);
        for (int side = 0; side < 2; side++)
        {
            qcSoup placed = qcSoup_MakeSphere(1, 1.0);
            qcSoup_Place(&placed, sizes[i], 3.0 * side * sizes[i], 0.0, 0.0);
            qcBodyDef def = qcBodyDefOf(&placed);
            def.selfCollision = false;
            for (int axis = 0; axis < 3; axis++)
                def.transform.linear[4 * axis] = scales[i];
            qcBodyId id;
            CHECK_OK(qcScene_AddBody(scene, &def, &id));
            qcSoup_Free(&placed);
        }
        Totals totals = {0};
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = true;
        CheckStep(scene, def, "one point", &totals);
        ck_assert_uint_eq(totals.pairs, (size_t)soup.triangleCount * soup.triangleCount);
        qcScene_Destroy(scene);
        qcSoup_Free(&soup);
    }
}
END_TEST

QC_RUN_TESTS("rigid_transform_scenes", rigid_bodies_have_the_pairs_of_brute_force_anywhere,
             a_vertex_that_stands_on_another_body_touches_it,
             faces_that_coincide_touch_and_those_at_the_margin_are_within_it,
             a_plate_between_two_others_is_within_the_margin_of_one, bodies_that_shrink_to_a_point_touch)
