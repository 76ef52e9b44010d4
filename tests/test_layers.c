// The method `layers` over many steps of one scene: what the device keeps from step to step is what the scene is, its
// lists grow, only what has changed is uploaded, and where the device can't, the sweep answers.
#define _POSIX_C_SOURCE 200809L
#include "devices.h"
#include "scenes.h"
#include "suite.h"

#include <pthread.h>
#include <stdio.h>

//  ---- answers ---------------------------------------------------------------------------------------------------

static qcPairList ListOf(const qcResult* result)
{
    return (qcPairList){(qcPair*)result->pairs, result->pairCount};
}

/// `layers` on this scene against another method on it; the result of `layers`.
static const qcResult* CheckAgainst(qcMethod method, qcScene* scene, const qcDetectDef* asked, const char* what)
{
    qcDetectDef def = *asked;
    def.method = method;
    qcPairList expected = qcDetectPairs(scene, &def);
    def.method = qc_methodLayers;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    ck_assert(!result->profile.reused);
    qcPairList found = ListOf(result);
    qcCheckSamePairs(&expected, &found, what);
    free(expected.pairs);
    return result;
}

static void CheckOnDevice(const qcResult* result)
{
    ck_assert_msg(result->profile.fallback == NULL, "%s", result->profile.fallback);
    ck_assert_int_eq(result->profile.method, qc_methodLayers);
}

/// As above, and the device has answered.
static const qcResult* CheckLayers(qcScene* scene, const qcDetectDef* def, const char* what)
{
    const qcResult* result = CheckAgainst(qc_methodSweep, scene, def, what);
    CheckOnDevice(result);
    return result;
}

static void SetVertices(qcScene* scene, qcBodyId id, const qcSoup* soup)
{
    CHECK_OK(qcScene_SetVertices(scene, id, soup->positions, qc_positionF64, 0));
}

static qcBodyId AddDeforming(qcScene* scene, const qcSoup* soup)
{
    qcBodyDef def = qcBodyDefOf(soup);
    def.deforming = true;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

//  ---- a world of random changes -----------------------------------------------------------------------------------

enum
{
    qc_mostThings = 12,
    qc_bruteTriangles = 300 ///< up to so many, brute force is asked, beyond it the sweep
};

typedef struct Thing
{
    bool deforming;
    qcSoup soup;      ///< at rest
    double* vertices; ///< now; of deforming ones
    qcTransform transform;
    qcBodyId id; ///< the same in all scenes
} Thing;

typedef struct World
{
    qcRandom random;
    qcScene* scenes[3]; ///< the first has no device; all have the same bodies
    int sceneCount;
    uint32_t sceneTriangles, bodyTriangles; ///< at most
    double offset[3];                       ///< about where things are
    Thing things[qc_mostThings];
    uint32_t count;
    char log[400]; ///< what the step has done
} World;

typedef struct Tally
{
    uint64_t steps, runs, pairs, contacts, fallbacks, reruns;
    uint64_t kept; ///< runs that uploaded less than half of all vertices
} Tally;

static void Log(World* world, const char* what, uint32_t slot)
{
    size_t length = strlen(world->log);
    snprintf(world->log + length, sizeof world->log - length, " %s(%u)", what, slot);
}

static double Among(World* world, const double* values, uint32_t count)
{
    return values[qcRandom_Below(&world->random, count)];
}

static uint32_t CountTriangles(const World* world)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < world->count; i++)
        count += world->things[i].soup.triangleCount;
    return count;
}

/// Distances to which something goes now and then: far out only what few others would crowd one pixel for.
static double Distance(World* world)
{
    static const double s_distances[] = {0.3, 0.3, 0.3, 1, 1, 30, 1e4, 1e9, 1e150, 1e300};
    return Among(world, s_distances, CountTriangles(world) > qc_bruteTriangles ? 6 : 10);
}

static qcSoup MakeSoup(World* world)
{
    static const double s_sizes[] = {0.02, 0.1, 0.3};
    qcRandom* random = &world->random;
    uint32_t count = 1 + qcRandom_Below(random, world->bodyTriangles), side = 1;
    while (2 * (side + 1) * (side + 1) <= count)
        side++;
    double size = count > 200 ? 0.05 : Among(world, s_sizes, 3);
    switch (qcRandom_Below(random, 5))
    {
        case 0: return qcSoup_MakeRandom(qcRandom_Next(random), count, size);
        case 1: return qcSoup_MakeDegenerate(qcRandom_Next(random), count, size, 0.4);
        case 2: return qcSoup_MakeSphere(count >= 320 ? 2 : count >= 80, 0.4);
        case 3: return qcSoup_MakeGrid(side);
        default: return qcSoup_MakeFoldedCloth(qcRandom_Next(random), side, 0.02, 0.02);
    }
}

/// By a rational angle about one axis, scaled, and now and then flattened.
static void Turn(World* world, qcTransform* transform)
{
    static const double s_scales[] = {1, 1, 1, 0.1, 2.5};
    qcRandom* random = &world->random;
    double t = qcRandom_Uniform(random, -2, 2), c = (1 - t * t) / (1 + t * t), s = 2 * t / (1 + t * t);
    double scale = Among(world, s_scales, 5);
    uint32_t axis = qcRandom_Below(random, 3), u = (axis + 1) % 3, v = (axis + 2) % 3;
    memset(transform->linear, 0, sizeof transform->linear);
    transform->linear[4 * axis] = qcRandom_Below(random, 8) == 0 ? 0 : scale;
    transform->linear[4 * u] = transform->linear[4 * v] = scale * c;
    transform->linear[3 * u + v] = -scale * s;
    transform->linear[3 * v + u] = scale * s;
}

static void Place(World* world, double distance, double at[3])
{
    for (int axis = 0; axis < 3; axis++)
        at[axis] = world->offset[axis] + qcRandom_Uniform(&world->random, -distance, distance);
}

static void SendThing(World* world, const Thing* thing)
{
    for (int i = 0; i < world->sceneCount; i++)
        if (thing->deforming)
            CHECK_OK(qcScene_SetVertices(world->scenes[i], thing->id, thing->vertices, qc_positionF64, 0));
        else
            CHECK_OK(qcScene_SetTransform(world->scenes[i], thing->id, &thing->transform));
}

static void AddThing(World* world)
{
    qcRandom* random = &world->random;
    qcSoup soup = MakeSoup(world);
    if (world->count == qc_mostThings || CountTriangles(world) + soup.triangleCount > world->sceneTriangles)
    {
        qcSoup_Free(&soup);
        return;
    }
    Thing* thing = &world->things[world->count++];
    *thing = (Thing){.deforming = qcRandom_Below(random, 2) == 0, .soup = soup, .transform = qcIdentityTransform()};
    Place(world, 0.5, thing->transform.translation);
    thing->vertices = malloc(3 * soup.vertexCount * sizeof(double));
    for (uint32_t i = 0; i < 3 * soup.vertexCount; i++)
        thing->vertices[i] = soup.positions[i] + thing->transform.translation[i % 3];
    qcBodyDef def = qcBodyDefOf(&soup);
    def.deforming = thing->deforming;
    def.positions = thing->deforming ? thing->vertices : soup.positions;
    def.transform = thing->transform;
    def.selfCollision = qcRandom_Below(random, 4) != 0;
    def.group = 1u << qcRandom_Below(random, 3);
    def.mask = qcRandom_Below(random, 3) == 0 ? 5u : UINT32_MAX;
    for (int i = 0; i < world->sceneCount; i++)
    {
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(world->scenes[i], &def, &id));
        ck_assert(i == 0 || (id.slot == thing->id.slot && id.generation == thing->id.generation));
        thing->id = id;
    }
    Log(world, thing->deforming ? "add deforming" : "add rigid", thing->id.slot);
}

static void RemoveThing(World* world, uint32_t number)
{
    Thing* thing = &world->things[number];
    Log(world, "remove", thing->id.slot);
    for (int i = 0; i < world->sceneCount; i++)
        CHECK_OK(qcScene_RemoveBody(world->scenes[i], thing->id));
    qcSoup_Free(&thing->soup);
    free(thing->vertices);
    *thing = world->things[--world->count];
}

static void MoveRigid(World* world, Thing* thing)
{
    static const double s_steps[] = {1e-12, 1e-7, 0.01, 0.01};
    uint32_t kind = qcRandom_Below(&world->random, 4);
    double distance = kind < 2 ? Among(world, s_steps, 4) : kind == 2 ? 0 : Distance(world);
    if (kind >= 2)
        Turn(world, &thing->transform);
    if (kind < 2)
        for (int axis = 0; axis < 3; axis++)
            thing->transform.translation[axis] += qcRandom_Uniform(&world->random, -distance, distance);
    else if (kind == 3)
        Place(world, distance, thing->transform.translation);
    Log(world, kind < 2 ? "shift" : kind == 2 ? "turn" : "put", thing->id.slot);
}

static void MoveVertices(World* world, Thing* thing)
{
    static const double s_scales[] = {1, 1, 1, 0, 1e-4, 0.1, 3}, s_steps[] = {1e-12, 1e-4, 0.03, 0.03};
    qcRandom* random = &world->random;
    uint32_t kind = qcRandom_Below(random, 4), only = qcRandom_Below(random, thing->soup.vertexCount);
    double scale = Among(world, s_scales, 7), step = Among(world, s_steps, 4), at[3];
    Place(world, kind == 0 ? Distance(world) : 0.3, at);
    for (uint32_t v = 0; v < thing->soup.vertexCount; v++)
        for (int axis = 0; axis < 3; axis++)
        {
            double* x = &thing->vertices[3 * v + (uint32_t)axis];
            if (kind < 2)
                *x = thing->soup.positions[3 * v + (uint32_t)axis] * scale + at[axis];
            else if (kind == 2 || v == only)
                *x += qcRandom_Uniform(random, -step, step);
        }
    Log(world, kind < 2 ? "deform" : kind == 2 ? "jitter" : "one vertex", thing->id.slot);
}

/// Everything elsewhere: far from the origin single precision can't transform rigid bodies.
static void MoveAll(World* world)
{
    static const double s_distances[] = {0, 10, 1e6, 1e12};
    double distance = Among(world, s_distances, 4);
    for (int axis = 0; axis < 3; axis++)
    {
        double by = distance - world->offset[axis];
        world->offset[axis] = distance;
        for (uint32_t i = 0; i < world->count; i++)
        {
            world->things[i].transform.translation[axis] += by;
            for (uint32_t v = 0; v < world->things[i].soup.vertexCount; v++)
                world->things[i].vertices[3 * v + (uint32_t)axis] += by;
        }
    }
    for (uint32_t i = 0; i < world->count; i++)
        SendThing(world, &world->things[i]);
    Log(world, "all", 0);
}

static void SetRules(World* world, const Thing* thing)
{
    qcRandom* random = &world->random;
    uint32_t kind = qcRandom_Below(random, 4), value = qcRandom_Below(random, 3);
    for (int i = 0; i < world->sceneCount; i++)
        if (kind < 2)
            CHECK_OK(qcScene_SetActivity(world->scenes[i], thing->id, (qcActivity)value));
        else if (kind == 2)
            CHECK_OK(qcScene_SetFilter(world->scenes[i], thing->id, 1u << value, value == 0 ? 6u : UINT32_MAX));
        else
            CHECK_OK(qcScene_SetSelfCollision(world->scenes[i], thing->id, value != 0));
    Log(world, kind < 2 ? "activity" : kind == 2 ? "filter" : "self", thing->id.slot);
}

static void Change(World* world)
{
    uint32_t kind = qcRandom_Below(&world->random, 32), number = qcRandom_Below(&world->random, world->count + 1);
    if (kind == 0)
        MoveAll(world);
    else if (kind < 5 || number == world->count)
        AddThing(world);
    else if (kind < 8)
        RemoveThing(world, number);
    else if (kind < 12)
        SetRules(world, &world->things[number]);
    else
    {
        Thing* thing = &world->things[number];
        if (thing->deforming)
            MoveVertices(world, thing);
        else
            MoveRigid(world, thing);
        SendThing(world, thing);
    }
}

/// A question, often that of the step before, so that the frame can stay.
static void ChooseQuestion(World* world, qcDetectDef* def)
{
    static const double s_margins[] = {0, 0, 0, 1e-6, 0.003, 0.05}, s_contacts[] = {0, 0, 0, 0.02};
    qcRandom* random = &world->random;
    def->touching = qcRandom_Below(random, 2) == 0;
    def->neighbours = qcRandom_Below(random, 4) == 0;
    def->threads = 1 + qcRandom_Below(random, 2);
    if (qcRandom_Below(random, 2) == 0)
        return;
    def->margin = Among(world, s_margins, 6);
    def->contactMargin = Among(world, s_contacts, 4);
    def->layerColumns = (const uint32_t[]){0, 0, 0, 1, 2, 7, 32}[qcRandom_Below(random, 7)];
    def->layerDepthAxis = "\0\0\0xyz"[qcRandom_Below(random, 6)];
}

static size_t CountVertices(const World* world)
{
    size_t count = 0;
    for (uint32_t i = 0; i < world->count; i++)
        count += world->things[i].soup.vertexCount;
    return count;
}

static void AskAll(World* world, qcDetectDef def, const char* what, Tally* tally)
{
    const qcResult *expected, *found;
    def.method = CountTriangles(world) <= qc_bruteTriangles ? qc_methodBrute : qc_methodSweep;
    CHECK_OK(qcScene_Detect(world->scenes[0], &def, &expected));
    qcPairList pairs = ListOf(expected);
    tally->pairs += expected->pairCount;
    tally->contacts += expected->contactCount;
    for (int i = 1; i < world->sceneCount; i++)
    {
        if (qcRandom_Below(&world->random, 4) == 0)
        {
            qcDetectDef other = def;
            other.method = qcRandom_Below(&world->random, 2) == 0 ? qc_methodSweep : qc_methodAuto;
            CHECK_OK(qcScene_Detect(world->scenes[i], &other, &found));
            qcPairList list = ListOf(found);
            qcCheckSamePairs(&pairs, &list, what);
        }
        def.method = qc_methodLayers;
        CHECK_OK(qcScene_Detect(world->scenes[i], &def, &found));
        qcPairList list = ListOf(found);
        qcCheckSamePairs(&pairs, &list, what);
        ck_assert_msg(found->contactCount == expected->contactCount &&
                          (found->contactCount == 0 ||
                           memcmp(found->contacts, expected->contacts, found->contactCount * sizeof(qcContact)) == 0),
                      "%s: other contacts", what);
        if (found->profile.reused)
            continue;
        tally->runs++;
        tally->fallbacks += found->profile.fallback != NULL;
        tally->reruns += found->profile.reruns;
        tally->kept += found->profile.partsOnDevice != 0 && found->profile.fallback == NULL &&
                       found->profile.uploadedBytes < 8 * CountVertices(world);
    }
}

static void RunWorld(uint64_t seed, uint32_t bodyTriangles, int steps, qcDevice* const devices[2], Tally* tally)
{
    World world = {.random = {seed}, .bodyTriangles = bodyTriangles, .sceneTriangles = 5 * bodyTriangles};
    world.scenes[world.sceneCount++] = qcMakeScene(NULL);
    for (int i = 0; i < 2; i++)
        if (devices[i] != NULL)
            world.scenes[world.sceneCount++] = qcMakeScene(devices[i]);
    qcDetectDef def = qcDefaultDetectDef();
    for (int step = 0; step < steps; step++)
    {
        world.log[0] = 0;
        for (uint32_t changes = step == 0 ? 4 : qcRandom_Below(&world.random, 4); changes > 0; changes--)
            Change(&world);
        ChooseQuestion(&world, &def);
        char what[600];
        snprintf(what, sizeof what, "seed %llu, step %d:%s; margin %g, contacts %g, columns %u, axis %d%s",
                 (unsigned long long)seed, step, world.log, def.margin, def.contactMargin, def.layerColumns,
                 def.layerDepthAxis, def.neighbours ? ", neighbours" : "");
        AskAll(&world, def, what, tally);
        tally->steps++;
    }
    while (world.count != 0)
        RemoveThing(&world, 0);
    for (int i = 0; i < world.sceneCount; i++)
        qcScene_Destroy(world.scenes[i]);
}

START_TEST(any_sequence_of_changes_gives_the_pairs_of_a_scene_without_a_device)
{
    // Few triangles: all is tried, often. More: several nodes to a body, lists that grow.
    static const struct
    {
        uint32_t bodyTriangles;
        int worlds, steps;
    } s_sizes[] = {{12, 10, 100}, {150, 6, 60}, {800, 3, 40}};
    qcDevice* devices[2] = {qcOpenOrSkip(qc_deviceOsmesa), qcOpenOrSkip(qc_deviceSurfaceless)};
    bool any = devices[0] != NULL || devices[1] != NULL;
    for (int i = 0; i < 3; i++)
    {
        Tally tally = {0};
        for (int k = 0; k < s_sizes[i].worlds; k++)
            RunWorld((uint64_t)(1000 * i + k + 1), s_sizes[i].bodyTriangles, s_sizes[i].steps, devices, &tally);
        printf("%u triangles a body: %llu steps, %llu pairs, %llu contacts; %llu runs of layers, %llu fell back, "
               "%llu kept most, %llu reruns\n",
               s_sizes[i].bodyTriangles, (unsigned long long)tally.steps, (unsigned long long)tally.pairs,
               (unsigned long long)tally.contacts, (unsigned long long)tally.runs, (unsigned long long)tally.fallbacks,
               (unsigned long long)tally.kept, (unsigned long long)tally.reruns);
        ck_assert_uint_gt(tally.pairs, 10 * tally.steps);
        ck_assert_uint_gt(tally.contacts, tally.steps);
        ck_assert_uint_le(20 * tally.fallbacks, tally.runs);
        ck_assert(!any || 5 * tally.kept > tally.runs);
    }
    qcDevice_Destroy(devices[0]);
    qcDevice_Destroy(devices[1]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- lists that grow, uploads ------------------------------------------------------------------------------------

START_TEST(a_scene_that_collapses_runs_again_once_and_then_no_more)
{
    enum
    {
        qc_count = 1200
    };
    // The same centres: apart, and larger than the distances of most.
    qcSoup apart = qcSoup_MakeRandom(5, qc_count, 0.005), crowded = qcSoup_MakeRandom(5, qc_count, 0.25);
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcBodyId id = AddDeforming(scene, &apart);
        qcDetectDef def = qcDefaultDetectDef();
        uint64_t few = CheckLayers(scene, &def, "apart")->pairCount;
        SetVertices(scene, id, &crowded);
        const qcResult* result = CheckLayers(scene, &def, "collapsed");
        ck_assert_uint_gt(result->pairCount, 20 * few + qc_count);
        ck_assert_uint_gt(result->profile.reruns, 0);
        for (int round = 0; round < 3; round++)
        {
            SetVertices(scene, id, &crowded);
            ck_assert_uint_eq(CheckLayers(scene, &def, "collapsed again")->profile.reruns, 0);
            SetVertices(scene, id, &apart);
            result = CheckLayers(scene, &def, "apart again");
            ck_assert_uint_eq(result->profile.reruns, 0);
            ck_assert_uint_eq(result->pairCount, few);
        }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&apart);
    qcSoup_Free(&crowded);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Balls in a row, each in the next, every other one deforming.
typedef struct Row
{
    qcScene* scene;
    qcSoup ball;
    qcBodyId ids[8];
    double vertexBytes; ///< of one of them, on the device
    double tableBytes;  ///< at most: of all bodies, and of all numbers of nodes
} Row;

static void MoveBall(const Row* row, uint32_t number, double by)
{
    if (number % 2 == 0)
    {
        qcSoup moved = qcSoup_MakeSphere(3, 0.5);
        qcSoup_Translate(&moved, 0.7 * number, by, 0);
        SetVertices(row->scene, row->ids[number], &moved);
        qcSoup_Free(&moved);
        return;
    }
    qcTransform transform = qcIdentityTransform();
    transform.translation[0] = 0.7 * number;
    transform.translation[1] = by;
    CHECK_OK(qcScene_SetTransform(row->scene, row->ids[number], &transform));
}

static Row MakeRow(qcDevice* device)
{
    Row row = {.scene = qcMakeScene(device), .ball = qcSoup_MakeSphere(3, 0.5)};
    for (uint32_t i = 0; i < 8; i++)
    {
        qcBodyDef def = qcBodyDefOf(&row.ball);
        def.deforming = i % 2 == 0;
        CHECK_OK(qcScene_AddBody(row.scene, &def, &row.ids[i]));
        MoveBall(&row, i, 0);
    }
    row.vertexBytes = 16.0 * row.ball.vertexCount;
    // 80 bytes a body, 4 a node of 64 triangles, which is at least a quarter full.
    row.tableBytes = 8 * 80.0 + 8 * (4.0 / 16) * row.ball.triangleCount;
    return row;
}

static double CheckUpload(const Row* row, const char* what)
{
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = CheckLayers(row->scene, &def, what);
    ck_assert_uint_gt(result->pairCount, 100);
    return (double)result->profile.uploadedBytes;
}

START_TEST(only_what_has_changed_is_uploaded)
{
    QC_FOR_EACH_DEVICE(device)
    {
        Row row = MakeRow(device);
        ck_assert_double_lt(row.tableBytes, 0.5 * row.vertexBytes); // or it would say little
        ck_assert_double_gt(CheckUpload(&row, "the first step"), 8 * row.vertexBytes);
        ck_assert_double_le(CheckUpload(&row, "nothing moved"), row.tableBytes - 8 * 80.0);
        MoveBall(&row, 3, 0.01);
        ck_assert_double_le(CheckUpload(&row, "a rigid body moved"), row.tableBytes);
        for (uint32_t i = 1; i < 8; i += 2)
            MoveBall(&row, i, -0.01);
        ck_assert_double_le(CheckUpload(&row, "all rigid bodies moved"), row.tableBytes);
        MoveBall(&row, 4, 0.01);
        double bytes = CheckUpload(&row, "a deforming body moved");
        ck_assert_double_ge(bytes, row.vertexBytes);
        ck_assert_double_le(bytes, row.vertexBytes + row.tableBytes);
        CHECK_OK(qcScene_SetFilter(row.scene, row.ids[2], 2, 5));
        CHECK_OK(qcScene_SetActivity(row.scene, row.ids[6], qc_activitySleeping));
        ck_assert_double_le(CheckUpload(&row, "rules changed"), row.tableBytes);
        CHECK_OK(qcScene_RemoveBody(row.scene, row.ids[5]));
        ck_assert_double_le(CheckUpload(&row, "a body went"), row.tableBytes);
        // Far enough for another frame: vertices in the frame anew, topology not.
        MoveBall(&row, 7, 100);
        bytes = CheckUpload(&row, "another frame");
        ck_assert_double_ge(bytes, 4 * row.vertexBytes);
        ck_assert_double_le(bytes, 4 * row.vertexBytes + row.tableBytes);
        qcScene_Destroy(row.scene);
        qcSoup_Free(&row.ball);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- what the device can't ----------------------------------------------------------------------------------------

static void CheckFallback(const qcResult* result, const char* reason)
{
    ck_assert_int_eq(result->profile.method, qc_methodSweep);
    ck_assert_ptr_nonnull(result->profile.fallback);
    ck_assert_msg(strstr(result->profile.fallback, reason) != NULL &&
                      strstr(result->profile.fallback, "sweep answered on the CPU") != NULL,
                  "'%s' does not say '%s'", result->profile.fallback, reason);
    ck_assert_uint_gt(result->pairCount, 10);
}

START_TEST(without_compute_shaders_the_sweep_answers_and_says_so)
{
    qcDevice* none = qcOpenOrSkip(qc_deviceNone);
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.2);
    for (int i = 0; i < 2; i++)
    {
        qcScene* scene = qcMakeScene(i == 0 ? NULL : none);
        qcAddSoup(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "no device"), "no compute shaders");
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcDevice_Destroy(none);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(what_does_not_fit_the_frame_or_the_loops_is_swept_and_the_next_step_is_on_the_device_again)
{
    qcSoup soup = qcSoup_MakeRandom(3, 200, 0.2), huge = qcSoup_MakeRandom(3, 200, 0.2);
    for (uint32_t i = 0; i < 3 * huge.vertexCount; i++)
        huge.positions[i] *= 0x1p962;
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcBodyId id = AddDeforming(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        CheckLayers(scene, &def, "the first step");
        SetVertices(scene, id, &huge);
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "huge"), "too large for a frame");
        SetVertices(scene, id, &soup);
        CheckLayers(scene, &def, "after a huge scene");
        def.margin = 1e8;
        CheckFallback(CheckAgainst(qc_methodBrute, scene, &def, "wide margin"), "too large for a frame");
        def.margin = 0;
        CheckLayers(scene, &def, "after a wide margin");
        // The larger triangles alone cover more pixels than software renderers let loops run.
        def.layerColumns = 1024;
        const qcResult* result = CheckAgainst(qc_methodBrute, scene, &def, "many pixels");
        if (result->profile.method != qc_methodLayers)
            CheckFallback(result, "more than the device's loops do");
        else
            printf("many pixels: the device's loops run on\n");
        def.layerColumns = 0;
        CheckLayers(scene, &def, "after many pixels");
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&soup);
    qcSoup_Free(&huge);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- almost nothing ----------------------------------------------------------------------------------------------

static void CheckSmall(qcScene* scene, const char* what)
{
    for (int options = 0; options < 8; options++)
    {
        qcDetectDef def = qcDefaultDetectDef();
        def.touching = (options & 1) != 0;
        def.neighbours = (options & 2) != 0;
        def.margin = (options & 4) != 0 ? 0.25 : 0;
        ck_assert_ptr_null(CheckAgainst(qc_methodBrute, scene, &def, what)->profile.fallback);
    }
}

START_TEST(scenes_of_nothing_of_points_and_of_degenerate_triangles_are_answered)
{
    qcSoup degenerate = qcSoup_MakeDegenerate(8, 200, 0.3, 1), point = qcSoup_MakeRandom(8, 150, 0.3),
           same = qcSoup_MakeRandom(8, 150, 0.3);
    for (uint32_t i = 0; i < 3 * point.vertexCount; i++)
        point.positions[i] = 0.1 * (1 + i % 3);
    for (uint32_t i = 9; i < 3 * same.vertexCount; i++)
        same.positions[i] = same.positions[i - 9];
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        CheckSmall(scene, "no body");
        qcSoup part = point;
        part.triangleCount = 0;
        qcBodyId id = qcAddSoup(scene, &part);
        CheckSmall(scene, "a body without triangles");
        CHECK_OK(qcScene_RemoveBody(scene, id));
        part = same;
        part.triangleCount = 1;
        qcAddSoup(scene, &part);
        CheckSmall(scene, "one triangle");
        qcAddSoup(scene, &part);
        CheckSmall(scene, "one triangle twice");
        const qcSoup* soups[] = {&degenerate, &point, &same};
        for (int i = 0; i < 3; i++)
        {
            qcScene* other = qcMakeScene(device);
            id = AddDeforming(other, soups[i]);
            CheckSmall(other, "all alike");
            qcDetectDef def = qcDefaultDetectDef();
            def.touching = true;
            ck_assert_uint_gt(CheckLayers(other, &def, "all alike")->pairCount, 10);
            qcAddSoup(other, soups[(i + 1) % 3]);
            CheckSmall(other, "all alike, twice");
            qcScene_Destroy(other);
        }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&degenerate);
    qcSoup_Free(&point);
    qcSoup_Free(&same);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

//  ---- sharing a device ---------------------------------------------------------------------------------------------

/// A scene of its own that changes and grows, on a device that others use too.
typedef struct User
{
    qcScene* scene;
    qcBodyId cloth;
    uint64_t seed;
    uint32_t side;
    int wrong, pairs;
} User;

static bool AreSame(const qcPairList* a, const qcPairList* b)
{
    bool same = a->count == b->count;
    for (size_t i = 0; same && i < a->count; i++)
        same = qcComparePairs(&a->pairs[i], &b->pairs[i]) == 0 && a->pairs[i].relation == b->pairs[i].relation;
    return same;
}

/// Counts what is wrong: an assertion belongs to the main thread.
static void TakeStep(User* user, int step)
{
    qcSoup soup = qcSoup_MakeFoldedCloth(user->seed + (uint64_t)step, user->side, 0.02, 0.03);
    if (step == 0)
        user->cloth = AddDeforming(user->scene, &soup);
    else
        SetVertices(user->scene, user->cloth, &soup);
    if (step % 3 == 2)
        qcAddSoup(user->scene, &soup);
    qcSoup_Free(&soup);
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.threads = 1;
    qcPairList expected = qcDetectPairs(user->scene, &def);
    def.method = qc_methodLayers;
    const qcResult* result = NULL;
    qcStatus status = qcScene_Detect(user->scene, &def, &result);
    qcPairList found = status == qc_statusOk ? ListOf(result) : (qcPairList){0};
    user->wrong += status != qc_statusOk || result->profile.fallback != NULL || !AreSame(&expected, &found);
    user->pairs += (int)expected.count;
    free(expected.pairs);
}

static void* TakeSteps(void* user)
{
    for (int step = 0; step < 9; step++)
        TakeStep(user, step);
    return NULL;
}

START_TEST(two_scenes_share_a_device_in_turn_and_on_two_threads)
{
    QC_FOR_EACH_DEVICE(device)
    for (int threaded = 0; threaded < 2; threaded++)
    {
        User users[2] = {{.seed = 10, .side = 20}, {.seed = 60, .side = 9}};
        pthread_t threads[2];
        for (int i = 0; i < 2; i++)
            users[i].scene = qcMakeScene(device);
        for (int step = 0; step < 9 && !threaded; step++)
            for (int i = 0; i < 2; i++)
                TakeStep(&users[i], step);
        for (int i = 0; i < 2 && threaded; i++)
            ck_assert_int_eq(pthread_create(&threads[i], NULL, TakeSteps, &users[i]), 0);
        for (int i = 0; i < 2; i++)
        {
            if (threaded)
                ck_assert_int_eq(pthread_join(threads[i], NULL), 0);
            ck_assert_int_eq(users[i].wrong, 0);
            ck_assert_int_gt(users[i].pairs, 100);
            qcScene_Destroy(users[i].scene);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(the_pairs_do_not_depend_on_device_columns_or_depth_axis)
{
    qcSoup cloth = qcSoup_MakeFoldedCloth(9, 56, 0.004, 0.004);
    QC_FOR_EACH_DEVICE(device)
    {
        qcScene* scene = qcMakeScene(device);
        qcAddSoup(scene, &cloth);
        qcDetectDef def = qcDefaultDetectDef();
        for (uint32_t columns = 0; columns <= 64; columns = 4 * columns + (columns == 0))
            for (int axis = 0; axis < 4; axis++)
            {
                def.layerColumns = columns;
                def.layerDepthAxis = "\0xyz"[axis];
                char what[80];
                snprintf(what, sizeof what, "%u columns, axis %d", columns, axis);
                const qcResult* result = CheckLayers(scene, &def, what);
                ck_assert_uint_gt(result->pairCount, 1000);
                ck_assert(columns == 0 || result->profile.columns == columns);
            }
        qcScene_Destroy(scene);
    }
    qcSoup_Free(&cloth);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("layers", any_sequence_of_changes_gives_the_pairs_of_a_scene_without_a_device,
             a_scene_that_collapses_runs_again_once_and_then_no_more, only_what_has_changed_is_uploaded,
             without_compute_shaders_the_sweep_answers_and_says_so,
             what_does_not_fit_the_frame_or_the_loops_is_swept_and_the_next_step_is_on_the_device_again,
             scenes_of_nothing_of_points_and_of_degenerate_triangles_are_answered,
             two_scenes_share_a_device_in_turn_and_on_two_threads,
             the_pairs_do_not_depend_on_device_columns_or_depth_axis)
