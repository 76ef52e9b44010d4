// Random changes of a scene, step after step: bodies are added, removed, moved a little or far, put to sleep; requests
// change, other methods run in between. After each step `layers` on each device has the pairs of a scene without one.
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <stdio.h>

//  ---- a world of things -------------------------------------------------------------------------------------------

enum
{
    qc_maxThings = 12,
    qc_crowd = 60,          ///< max. triangles that may all intersect
    qc_bruteTriangles = 300 ///< max. triangles for brute force as the oracle; beyond it the sweep is
};

typedef struct Thing
{
    bool deforming;
    qcSoup soup;      ///< rest positions
    double* vertices; ///< present positions of deforming bodies
    qcTransform transform;
    qcBodyId id; ///< the same in all scenes
} Thing;

typedef struct World
{
    qcRandom random;
    qcScene* scenes[1 + qc_testDeviceCount]; ///< the first has no device; all have the same bodies
    int sceneCount;
    uint32_t sceneTriangles, bodyTriangles; ///< at most
    double offset[3];                       ///< approximate centre of the scene
    Thing things[qc_maxThings];
    uint32_t count;
    char log[400]; ///< list of the step's changes
} World;

typedef struct Tally
{
    uint64_t steps, runs, pairs, contacts, reruns;
    uint64_t large, fallbacks; ///< fallbacks because the scene was too large for a frame, and other fallbacks
    uint64_t kept;             ///< runs that uploaded less than half of all vertices, beside the table of bodies
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

/// Distance by which a body moves. Only few move far, since otherwise all others would share one pixel.
static double Distance(World* world)
{
    static const double s_distances[] = {0.3, 0.3, 0.3, 1, 1, 30}, s_far[] = {1e3, 1e4, 1e9, 1e150, 1e300};
    bool far = CountTriangles(world) <= qc_crowd && qcRandom_Below(&world->random, 10) == 0;
    return far ? Among(world, s_far, 5) : Among(world, s_distances, 6);
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

/// Turns by a rational angle about one axis, scales, and sometimes flattens.
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
    if (world->count == qc_maxThings || CountTriangles(world) + soup.triangleCount > world->sceneTriangles)
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
    static const double s_scales[] = {1, 1, 1, 0.3, 3, 0, 1e-4}, s_steps[] = {1e-12, 1e-4, 0.03, 0.03};
    qcRandom* random = &world->random;
    uint32_t kind = qcRandom_Below(random, 4), only = qcRandom_Below(random, thing->soup.vertexCount);
    double scale = Among(world, s_scales, CountTriangles(world) > qc_crowd ? 5 : 7), step = Among(world, s_steps, 4),
           at[3];
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

/// Moves the whole scene: far from the origin single precision can't transform rigid bodies.
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

//  ---- questions ---------------------------------------------------------------------------------------------------

/// Chooses a question, often that of the previous step, so that the frame can stay.
static void ChooseQuestion(World* world, qcDetectDef* def)
{
    static const double s_margins[] = {0, 0, 0, 1e-6, 0.003, 0.02, 0.5, 4}, s_contacts[] = {0, 0, 0, 0.005};
    qcRandom* random = &world->random;
    def->touching = qcRandom_Below(random, 2) == 0;
    def->neighbours = qcRandom_Below(random, 4) == 0;
    def->threads = 1 + qcRandom_Below(random, 2);
    if (qcRandom_Below(random, 2) == 0)
        return;
    def->margin = Among(world, s_margins, CountTriangles(world) > qc_crowd ? 6 : 8);
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
    qcPairList pairs = qcListOf(expected);
    tally->pairs += expected->pairCount;
    tally->contacts += expected->contactCount;
    for (int i = 1; i < world->sceneCount; i++)
    {
        if (qcRandom_Below(&world->random, 4) == 0)
        {
            qcDetectDef other = def;
            other.method = qcRandom_Below(&world->random, 2) == 0 ? qc_methodSweep : qc_methodAuto;
            CHECK_OK(qcScene_Detect(world->scenes[i], &other, &found));
            qcPairList list = qcListOf(found);
            qcCheckSamePairs(&pairs, &list, what);
        }
        def.method = qc_methodLayers;
        CHECK_OK(qcScene_Detect(world->scenes[i], &def, &found));
        qcPairList list = qcListOf(found);
        qcCheckSamePairs(&pairs, &list, what);
        ck_assert_msg(found->contactCount == expected->contactCount &&
                          (found->contactCount == 0 ||
                           memcmp(found->contacts, expected->contacts, found->contactCount * sizeof(qcContact)) == 0),
                      "%s: other contacts", what);
        if (found->profile.reused)
            continue;
        tally->runs++;
        bool large = found->profile.fallback != NULL && strstr(found->profile.fallback, "too large") != NULL;
        tally->large += large;
        tally->fallbacks += found->profile.fallback != NULL && !large;
        tally->reruns += found->profile.reruns;
        tally->kept += found->profile.partsOnDevice != 0 && found->profile.fallback == NULL &&
                       found->profile.uploadedBytes < 8 * CountVertices(world) + 96 * world->count;
    }
}

static void RunWorld(uint64_t seed, uint32_t bodyTriangles, int steps, qcDevice* const devices[qc_testDeviceCount],
                     Tally* tally)
{
    World world = {.random = {seed}, .bodyTriangles = bodyTriangles, .sceneTriangles = 5 * bodyTriangles};
    world.scenes[world.sceneCount++] = qcMakeScene(NULL);
    for (int i = 0; i < qc_testDeviceCount; i++)
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

START_TEST(after_any_sequence_of_changes_layers_finds_the_pairs_of_a_scene_without_a_device)
{
    // Few triangles: all options, often. More triangles: several nodes to a body, lists that grow.
    static const struct
    {
        uint32_t bodyTriangles;
        int worlds, steps;
    } s_sizes[] = {{12, 8, 60}, {150, 4, 40}, {800, 3, 25}};
    qcDevice* devices[qc_testDeviceCount];
    bool any = qcOpenTestDevices(devices) > 0;
    for (int i = 0; i < 3; i++)
    {
        Tally tally = {0};
        for (int k = 0; k < s_sizes[i].worlds; k++)
            RunWorld((uint64_t)(1000 * i + k + 1), s_sizes[i].bodyTriangles, s_sizes[i].steps, devices, &tally);
        printf("%u triangles a body: %llu steps, %llu pairs, %llu contacts; %llu runs of layers, %llu too large, "
               "%llu fell back, %llu kept most, %llu reruns\n",
               s_sizes[i].bodyTriangles, (unsigned long long)tally.steps, (unsigned long long)tally.pairs,
               (unsigned long long)tally.contacts, (unsigned long long)tally.runs, (unsigned long long)tally.large,
               (unsigned long long)tally.fallbacks, (unsigned long long)tally.kept, (unsigned long long)tally.reruns);
        ck_assert_uint_gt(tally.pairs, 10 * tally.steps);
        ck_assert_uint_gt(tally.contacts, tally.steps);
        ck_assert_uint_le(10 * tally.large, tally.runs);
        ck_assert_uint_le(100 * tally.fallbacks, tally.runs);
        ck_assert(!any || 5 * tally.kept > tally.runs);
    }
    qcCloseTestDevices(devices);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("layers, steps", after_any_sequence_of_changes_layers_finds_the_pairs_of_a_scene_without_a_device)
