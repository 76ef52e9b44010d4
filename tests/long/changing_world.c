// The model of a changing scene.
#include "long/changing_world.h"

#include <stdio.h>

static uint32_t Below(qcWorld* world, uint32_t bound)
{
    return qcRandom_Below(&world->random, bound);
}

static bool OneIn(qcWorld* world, uint32_t count)
{
    return Below(world, count) == 0;
}

static double Uniform(qcWorld* world, double lower, double upper)
{
    return qcRandom_Uniform(&world->random, lower, upper);
}

//  ---- bodies --------------------------------------------------------------------------------------------

static qcSoup MakeSoup(qcWorld* world)
{
    uint64_t seed = qcRandom_Next(&world->random);
    switch (Below(world, 4))
    {
        case 0: return qcSoup_MakeRandom(seed, 1 + Below(world, 40), 0.3);
        case 1: return qcSoup_MakeDegenerate(seed, 1 + Below(world, 20), 0.3, 0.3);
        case 2: return qcSoup_MakeSphere(Below(world, 2), 0.4);
        default: return qcSoup_MakeFoldedCloth(seed, 3 + Below(world, 4), 0.05, 0.04);
    }
}

static qcTransform MakeTransform(qcWorld* world)
{
    qcTransform transform = qcIdentityTransform();
    for (int i = 0; i < 9; i++)
        transform.linear[i] += OneIn(world, 2) ? 0.0 : Uniform(world, -0.3, 0.3);
    for (int axis = 0; axis < 3; axis++)
        transform.translation[axis] = Uniform(world, -0.6, 0.6);
    return transform;
}

static void RoundAll(qcWorldBody* body)
{
    if (body->def.positionType == qc_positionF32)
        qcSoup_RoundToFloat(&body->soup);
}

/// The present positions in the body's type; free them.
static void* CopyPositions(const qcWorldBody* body, const double* positions)
{
    size_t count = 3 * (size_t)body->soup.vertexCount;
    double* copy = malloc(count * sizeof *copy);
    ck_assert_ptr_nonnull(copy);
    memcpy(copy, positions, count * sizeof *copy);
    if (body->def.positionType == qc_positionF32)
        for (size_t i = 0; i < count; i++)
            ((float*)copy)[i] = (float)positions[i];
    return copy;
}

static void AddTo(qcScene* scene, const qcWorldBody* body, const double* positions, const qcTransform* transform,
                  qcBodyId* id)
{
    qcBodyDef def = body->def;
    def.positions = CopyPositions(body, positions);
    def.transform = *transform;
    CHECK_OK(qcScene_AddBody(scene, &def, id));
    free((void*)def.positions);
}

static void Add(qcWorld* world, qcWorldBody* body)
{
    *body = (qcWorldBody){.isUsed = true, .soup = MakeSoup(world)};
    qcSoup_Translate(&body->soup, Uniform(world, -1.0, 1.0), Uniform(world, -1.0, 1.0), Uniform(world, -1.0, 1.0));
    body->def = qcBodyDefOf(&body->soup);
    body->def.positionType = OneIn(world, 3) ? qc_positionF32 : qc_positionF64;
    RoundAll(body);
    body->def.deforming = OneIn(world, 2);
    body->def.activity = (qcActivity)(OneIn(world, 3) ? Below(world, 3) : 0);
    body->def.owner = OneIn(world, 3) ? Below(world, 3) : 0;
    body->def.selfCollision = !OneIn(world, 4);
    body->def.margin = OneIn(world, 3) ? Uniform(world, 0.0, 0.05) : (double)INFINITY;
    if (!body->def.deforming)
        body->def.transform = MakeTransform(world);
    body->startPositions = malloc(3 * sizeof(double) * body->soup.vertexCount);
    ck_assert_ptr_nonnull(body->startPositions);
    AddTo(world->scene, body, body->soup.positions, &body->def.transform, &body->id);
}

static void Remove(qcWorld* world, qcWorldBody* body)
{
    CHECK_OK(qcScene_RemoveBody(world->scene, body->id));
    world->removed[world->removedCount++ % qc_worldBodiesEver] = body->id;
    qcSoup_Free(&body->soup);
    free(body->startPositions);
    body->isUsed = false;
}

//  ---- changes -------------------------------------------------------------------------------------------

static void SetVertices(qcScene* scene, qcBodyId id, const qcWorldBody* body)
{
    void* positions = CopyPositions(body, body->soup.positions);
    CHECK_OK(qcScene_SetVertices(scene, id, positions, body->def.positionType, 0));
    free(positions);
}

static void Bend(qcWorld* world, qcWorldBody* body)
{
    uint32_t all = body->soup.vertexCount, count = OneIn(world, 4) ? all : 1 + Below(world, all / 8 + 1);
    double most = OneIn(world, 3) ? 0.1 : 0.002;
    for (uint32_t i = 0; i < count; i++)
    {
        size_t vertex = count == all ? i : Below(world, all);
        for (size_t axis = 0; axis < 3; axis++)
        {
            double* x = &body->soup.positions[3 * vertex + axis];
            *x += Uniform(world, -most, most);
            // Kept near the others, however long the world lives.
            if (!(*x > -1.5 && *x < 2.5))
                *x = Uniform(world, 0.0, 1.0);
        }
    }
    RoundAll(body);
    SetVertices(world->scene, body->id, body);
}

static void Move(qcWorld* world, qcWorldBody* body)
{
    if (OneIn(world, 4))
        body->def.transform = MakeTransform(world);
    else
        for (int axis = 0; axis < 3; axis++)
            body->def.transform.translation[axis] += Uniform(world, -0.01, 0.01);
    CHECK_OK(qcScene_SetTransform(world->scene, body->id, &body->def.transform));
}

static void ChangeSettings(qcWorld* world, qcWorldBody* body)
{
    qcBodyDef* def = &body->def;
    switch (Below(world, 4))
    {
        case 0:
            def->activity = (qcActivity)(OneIn(world, 2) ? 0 : Below(world, 3));
            CHECK_OK(qcScene_SetActivity(world->scene, body->id, def->activity));
            break;
        case 1:
            def->group = 1 + Below(world, 3);
            def->mask = OneIn(world, 2) ? UINT32_MAX : 1 + Below(world, 3);
            CHECK_OK(qcScene_SetFilter(world->scene, body->id, def->group, def->mask));
            break;
        case 2:
            def->selfCollision = !def->selfCollision;
            CHECK_OK(qcScene_SetSelfCollision(world->scene, body->id, def->selfCollision));
            break;
        default:
            def->margin = OneIn(world, 2) ? (double)INFINITY : Uniform(world, 0.0, 0.05);
            CHECK_OK(qcScene_SetMargin(world->scene, body->id, def->margin));
    }
}

static void MarkStart(qcWorld* world)
{
    CHECK_OK(qcScene_MarkStart(world->scene));
    for (int i = 0; i < qc_worldBodies; i++)
    {
        qcWorldBody* body = &world->bodies[i];
        if (!body->isUsed)
            continue;
        body->isMarked = true;
        body->startTransform = body->def.transform;
        memcpy(body->startPositions, body->soup.positions, 3 * sizeof(double) * body->soup.vertexCount);
    }
}

static void ChangeBody(qcWorld* world, qcWorldBody* body)
{
    if (!body->isUsed)
    {
        if (OneIn(world, 3))
            Add(world, body);
    }
    else if (OneIn(world, 25))
        Remove(world, body);
    else if (OneIn(world, 10))
        ChangeSettings(world, body);
    else if (body->def.deforming)
        Bend(world, body);
    else
        Move(world, body);
}

void qcWorld_Change(qcWorld* world)
{
    if (OneIn(world, 20))
        MarkStart(world);
    // None, sometimes: the last result is reused.
    for (uint32_t count = Below(world, 4); count > 0; count--, world->changes++)
        ChangeBody(world, &world->bodies[Below(world, qc_worldBodies)]);
}

//  ---- the whole -----------------------------------------------------------------------------------------

void qcWorld_Create(qcWorld* world, uint64_t seed, qcDevice* device)
{
    *world = (qcWorld){.random = {seed}, .scene = qcMakeScene(device)};
}

void qcWorld_Clear(qcWorld* world)
{
    for (int i = 0; i < qc_worldBodies; i++)
        if (world->bodies[i].isUsed)
            Remove(world, &world->bodies[i]);
}

void qcWorld_Destroy(qcWorld* world)
{
    qcWorld_Clear(world);
    qcScene_Destroy(world->scene);
}

qcDetectDef qcWorld_MakeDef(qcWorld* world)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = OneIn(world, 50) ? qc_methodBrute : OneIn(world, 4) ? qc_methodAuto : qc_methodSweep;
    def.threads = 1;
    def.neighbours = OneIn(world, 12);
    switch (Below(world, 6))
    {
        case 0: def.motion = true; return def;
        case 1: def.segments = true; return def;
        case 2: def.contactMargin = 0.02; break;
        case 3: def.manifolds = true; break;
        default: def.touching = OneIn(world, 2);
    }
    def.margin = OneIn(world, 3) ? 0.0 : OneIn(world, 2) ? 0.02 : Uniform(world, 0.0, 0.04);
    def.proximities = OneIn(world, 6);
    return def;
}

/// The model's body in a slot; null: none.
static const qcWorldBody* BodyIn(const qcWorld* world, uint32_t slot)
{
    for (int i = 0; i < qc_worldBodies; i++)
        if (world->bodies[i].isUsed && world->bodies[i].id.slot == slot)
            return &world->bodies[i];
    return NULL;
}

// Slots are taken from the lowest on. Empty bodies therefore hold the slots of bodies that were added after the mark,
// and those of holes, until the scene is complete.
qcScene* qcWorld_Rebuild(const qcWorld* world)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId ids[4 * qc_worldBodies] = {{0, 0}};
    const qcBodyDef empty = qcDefaultBodyDef();
    uint32_t count = 0;
    for (int i = 0; i < qc_worldBodies; i++)
        if (world->bodies[i].isUsed && world->bodies[i].id.slot >= count)
            count = world->bodies[i].id.slot + 1;
    ck_assert_uint_le(count, sizeof ids / sizeof *ids);
    for (uint32_t slot = 0; slot < count; slot++)
    {
        const qcWorldBody* body = BodyIn(world, slot);
        if (body != NULL && body->isMarked)
            AddTo(scene, body, body->def.deforming ? body->startPositions : body->soup.positions, &body->startTransform,
                  &ids[slot]);
        else
            CHECK_OK(qcScene_AddBody(scene, &empty, &ids[slot]));
    }
    CHECK_OK(qcScene_MarkStart(scene));
    for (uint32_t slot = 0; slot < count; slot++)
    {
        const qcWorldBody* body = BodyIn(world, slot);
        if (body == NULL)
            continue;
        if (!body->isMarked)
        {
            CHECK_OK(qcScene_RemoveBody(scene, ids[slot]));
            AddTo(scene, body, body->soup.positions, &body->def.transform, &ids[slot]);
        }
        else if (body->def.deforming)
            SetVertices(scene, ids[slot], body);
        else
            CHECK_OK(qcScene_SetTransform(scene, ids[slot], &body->def.transform));
        ck_assert_uint_eq(ids[slot].slot, slot);
    }
    for (uint32_t slot = 0; slot < count; slot++)
        if (BodyIn(world, slot) == NULL)
            CHECK_OK(qcScene_RemoveBody(scene, ids[slot]));
    return scene;
}

size_t qcWorld_Compare(qcWorld* world, const qcDetectDef* def, const char* where)
{
    qcScene* fresh = qcWorld_Rebuild(world);
    const qcResult *expected, *found;
    CHECK_OK(qcScene_Detect(fresh, def, &expected));
    CHECK_OK(qcScene_Detect(world->scene, def, &found));
    char what[160];
    snprintf(what, sizeof what, "%s, %s, margin %g, contacts %g, manifolds %d, motion %d", where,
             qcMethod_Name(def->method), def->margin, def->contactMargin, def->manifolds, def->motion);
    qcPairList expectedPairs = qcListOf(expected), foundPairs = qcListOf(found);
    qcCheckSamePairs(&expectedPairs, &foundPairs, what);
    qcResultHash expectedHash = qcResult_Hash(expected), foundHash = qcResult_Hash(found);
    ck_assert_msg(
        memcmp(&expectedHash, &foundHash, sizeof foundHash) == 0,
        "%s: the pairs of a new scene, but not its result: %zu contacts, expected %zu; %zu points, expected %zu", what,
        found->contactCount, expected->contactCount, found->manifoldPointCount, expected->manifoldPointCount);
    size_t count = found->pairCount + found->contactCount;
    qcScene_Destroy(fresh);
    return count;
}

void qcWorld_CheckRemoved(const qcWorld* world)
{
    const qcTransform transform = qcIdentityTransform();
    uint64_t count = world->removedCount < qc_worldBodiesEver ? world->removedCount : qc_worldBodiesEver;
    for (uint64_t i = 0; i < count; i++)
        if (qcScene_IsValid(world->scene, world->removed[i]) ||
            qcScene_SetTransform(world->scene, world->removed[i], &transform) != qc_statusBadInput ||
            qcScene_RemoveBody(world->scene, world->removed[i]) != qc_statusBadInput)
            ck_abort_msg("the id of a removed body, slot %u, generation %u, is valid", world->removed[i].slot,
                         world->removed[i].generation);
}
