// Scenes that live: bodies of any size anywhere are added, moved, bent, switched and removed between detections of
// every kind, some of which run out of memory. `sweep` and `auto` report the pairs of brute force and no other.
// QC_TEST_SCENES: the number of scenes (raise CK_TIMEOUT_MULTIPLIER with it); QC_TEST_SEED: the seed of the first.
#include "support/scenes.h"
#include "support/suite.h"

#include <math.h>
#include <stdio.h>

enum
{
    qc_maxBodies = 5,
    qc_steps = 24,
    qc_minScenes = 20
};

typedef struct Body
{
    bool isUsed, deforming, isSingle; ///< isSingle: positions are floats
    qcBodyId id;
    qcSoup soup;
    double* before; ///< positions to which vertices come back
} Body;

typedef struct World
{
    qcRandom random;
    qcScene* scene;
    double size;      ///< of bodies
    double offset[3]; ///< of all of them
    double wide;      ///< the margin of the Verlet list
    bool isCalm;      ///< few vertices move: many partial refits
    Body bodies[qc_maxBodies];
} World;

//  ---- memory that fails -------------------------------------------------------------------------------

static size_t s_left = SIZE_MAX; ///< allocations until one fails

static void* Allocate(size_t size, void* context)
{
    (void)context;
    if (__atomic_fetch_sub(&s_left, 1, __ATOMIC_RELAXED) == 0)
        return NULL;
    return aligned_alloc(64, (size + 63) / 64 * 64);
}

static void Release(void* memory, size_t size, void* context)
{
    (void)size;
    (void)context;
    free(memory);
}

//  ---- random things -----------------------------------------------------------------------------------

static uint32_t Below(World* w, uint32_t bound)
{
    return qcRandom_Below(&w->random, bound);
}

static bool OneIn(World* w, uint32_t count)
{
    return Below(w, count) == 0;
}

/// A random number between two powers of two, uniform in the exponent.
static double Magnitude(World* w, int lower, int upper)
{
    return ldexp(qcRandom_Uniform(&w->random, 0.5, 1.0), (int)qcRandom_Integer(&w->random, lower, upper));
}

static double Round(const Body* body, double x)
{
    return body->isSingle ? (double)(float)x : x;
}

static qcSoup MakeSoup(World* w)
{
    uint64_t seed = qcRandom_Next(&w->random);
    uint32_t side = 2 + Below(w, OneIn(w, 6) ? 20 : 9);
    switch (Below(w, 6))
    {
        case 0: return qcSoup_MakeRandom(seed, 1 + Below(w, 200), Magnitude(w, -5, 0));
        case 1: return qcSoup_MakeDegenerate(seed, 1 + Below(w, 200), Magnitude(w, -5, 0), 0.3);
        case 2: return qcSoup_MakeGrid(side);
        case 3: return qcSoup_MakeSphere(Below(w, 3), 0.5);
        default: return qcSoup_MakeFoldedCloth(seed, side, Magnitude(w, -8, -3), Magnitude(w, -9, -4));
    }
}

/// Makes some triangles a single vertex or duplicates, or leaves vertices without a triangle.
static void Spoil(World* w, qcSoup* soup)
{
    for (uint32_t i = Below(w, 8); i > 0; i--)
    {
        uint32_t* index = soup->indices + 3 * (size_t)Below(w, soup->triangleCount);
        const uint32_t* other = soup->indices + 3 * (size_t)Below(w, soup->triangleCount);
        if (OneIn(w, 3))
            index[1] = index[2] = index[0];
        else if (OneIn(w, 2))
            memcpy(index, other, 3 * sizeof *index);
        else
            index[0] = other[Below(w, 3)];
    }
    // Coincident vertices.
    for (uint32_t i = Below(w, 4); i > 0; i--)
        memcpy(soup->positions + 3 * (size_t)Below(w, soup->vertexCount),
               soup->positions + 3 * (size_t)Below(w, soup->vertexCount), 3 * sizeof(double));
}

/// Rounds to a coarse lattice, so that triangles touch, are coplanar and coincide.
static void Snap(World* w, qcSoup* soup)
{
    double step = ldexp(1.0, -(int)(2 + Below(w, 4)));
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        soup->positions[i] = step * nearbyint(soup->positions[i] / step);
}

static void Place(World* w, Body* body)
{
    for (size_t i = 0; i < 3 * (size_t)body->soup.vertexCount; i++)
        body->soup.positions[i] = Round(body, w->offset[i % 3] + w->size * body->soup.positions[i]);
}

static void Keep(Body* body)
{
    memcpy(body->before, body->soup.positions, 3 * sizeof(double) * body->soup.vertexCount);
}

//  ---- changes of a scene ------------------------------------------------------------------------------

/// Positions in the body's type, with garbage between them.
static void* Pack(World* w, const Body* body, size_t* stride)
{
    size_t least = body->isSingle ? 3 * sizeof(float) : 3 * sizeof(double);
    *stride = least + (OneIn(w, 2) ? 4 * (size_t)Below(w, 5) : 0);
    char* data = malloc(*stride * body->soup.vertexCount);
    ck_assert_ptr_nonnull(data);
    memset(data, 0xff, *stride * body->soup.vertexCount);
    for (uint32_t v = 0; v < body->soup.vertexCount; v++)
    {
        const double* p = body->soup.positions + 3 * (size_t)v;
        float single[3] = {(float)p[0], (float)p[1], (float)p[2]};
        memcpy(data + *stride * v, body->isSingle ? (const void*)single : (const void*)p, least);
    }
    // No memory follows the last position, so that a memory checker finds reads beyond it.
    return realloc(data, *stride * (body->soup.vertexCount - 1) + least);
}

static void AddBody(World* w, Body* body)
{
    *body = (Body){.isUsed = true, .deforming = !OneIn(w, 4), .soup = MakeSoup(w)};
    body->isSingle = OneIn(w, 3) && w->size > 0x1p-60 && w->size < 0x1p60;
    if (OneIn(w, 2))
        Spoil(w, &body->soup);
    if (OneIn(w, 3))
        Snap(w, &body->soup);
    Place(w, body);
    body->before = malloc(3 * sizeof(double) * body->soup.vertexCount);
    ck_assert_ptr_nonnull(body->before);
    Keep(body);
    qcBodyDef def = qcBodyDefOf(&body->soup);
    def.positions = Pack(w, body, &def.positionStride);
    def.positionType = body->isSingle ? qc_positionF32 : qc_positionF64;
    def.deforming = body->deforming;
    def.selfCollision = !OneIn(w, 5);
    def.owner = Below(w, 3);
    def.margin = OneIn(w, 3) ? w->wide * Magnitude(w, -3, 1) : INFINITY;
    CHECK_OK(qcScene_AddBody(w->scene, &def, &body->id));
    free((void*)def.positions);
}

static void RemoveBody(World* w, Body* body)
{
    CHECK_OK(qcScene_RemoveBody(w->scene, body->id));
    qcSoup_Free(&body->soup);
    free(body->before);
    body->isUsed = false;
}

/// Moves some vertices from their present or previous positions; others return to previous ones.
static void Bend(World* w, Body* body)
{
    qcSoup* soup = &body->soup;
    uint32_t few = soup->vertexCount / (w->isCalm ? 32 : 8) + 1;
    uint32_t count = !w->isCalm && OneIn(w, 8) ? soup->vertexCount : 1 + Below(w, few);
    double most = w->isCalm || OneIn(w, 2) ? w->wide * Magnitude(w, -3, 1) : w->size * Magnitude(w, -12, 0);
    const double* from = OneIn(w, 2) ? body->before : soup->positions;
    for (uint32_t i = 0; i < count; i++)
    {
        size_t at = 3 * (size_t)Below(w, soup->vertexCount);
        bool back = OneIn(w, 4), onto = OneIn(w, 16);
        const double* target = soup->positions + 3 * (size_t)Below(w, soup->vertexCount);
        for (size_t axis = 0; axis < 3; axis++)
        {
            double x = back ? body->before[at + axis] : from[at + axis] + most * qcRandom_Uniform(&w->random, -1, 1);
            soup->positions[at + axis] = Round(body, onto ? target[axis] : x);
        }
        if (soup->positions[at] == 0.0)
            soup->positions[at] = OneIn(w, 2) ? 0.0 : -0.0;
    }
    size_t stride;
    void* data = Pack(w, body, &stride);
    CHECK_OK(qcScene_SetVertices(w->scene, body->id, data, body->isSingle ? qc_positionF32 : qc_positionF64, stride));
    free(data);
}

static void Turn(World* w, Body* body)
{
    qcTransform t = qcIdentityTransform();
    for (int i = 0; i < 9; i++)
        t.linear[i] += OneIn(w, 2) ? 0.0 : Magnitude(w, -8, 0) * qcRandom_Uniform(&w->random, -1, 1);
    if (OneIn(w, 10))
        memset(t.linear + 3 * (size_t)Below(w, 3), 0, 3 * sizeof(double));
    for (int axis = 0; axis < 3; axis++)
    {
        // Near its position.
        double moved = 0.0;
        for (int k = 0; k < 3; k++)
            moved += t.linear[3 * axis + k] * w->offset[k];
        t.translation[axis] = w->offset[axis] - moved + w->size * qcRandom_Uniform(&w->random, -0.5, 0.5);
    }
    CHECK_OK(qcScene_SetTransform(w->scene, body->id, &t));
}

static void Switch(World* w, Body* body)
{
    switch (Below(w, 4))
    {
        case 0: CHECK_OK(qcScene_SetActivity(w->scene, body->id, (qcActivity)(OneIn(w, 2) ? 0 : Below(w, 3)))); break;
        case 1: CHECK_OK(qcScene_SetSelfCollision(w->scene, body->id, !OneIn(w, 3))); break;
        case 2:
            CHECK_OK(qcScene_SetMargin(w->scene, body->id, OneIn(w, 3) ? INFINITY : w->wide * Magnitude(w, -3, 1)));
            break;
        default: CHECK_OK(qcScene_SetFilter(w->scene, body->id, 1u + Below(w, 3), 1u + Below(w, 3))); break;
    }
}

static void ChangeBody(World* w, Body* body)
{
    if (!body->isUsed)
    {
        if (OneIn(w, 4))
            AddBody(w, body);
        return;
    }
    if (OneIn(w, 40))
        RemoveBody(w, body);
    else if (OneIn(w, 12))
        Switch(w, body);
    else if (body->deforming && !OneIn(w, 4))
        Bend(w, body);
    else if (!body->deforming && OneIn(w, 2))
        Turn(w, body);
}

//  ---- requests ----------------------------------------------------------------------------------------

static qcDetectDef MakeDef(World* w)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = OneIn(w, 4) ? qc_methodAuto : qc_methodSweep;
    def.threads = 1 + Below(w, OneIn(w, 4) ? 7 : 2);
    def.touching = OneIn(w, 2);
    def.neighbours = OneIn(w, 12);
    uint32_t kind = Below(w, w->isCalm ? 6 : 8);
    // Contacts are of lengths whose squares are no less than normal.
    bool contacts = w->size > 0x1p-200 && w->size < 0x1p200;
    if (kind <= 1 && contacts)
        def.contactMargin = w->wide;
    else if (kind <= 2)
        def.margin = w->wide;
    else if (kind <= 5)
        def.margin = OneIn(w, 2) ? 0.0 : w->wide * qcRandom_Uniform(&w->random, 0.0, 1.0);
    else
    {
        def.margin = OneIn(w, 3) ? 0.0 : w->size * Magnitude(w, -20, 1);
        def.contactMargin = contacts && OneIn(w, 2) ? w->size * Magnitude(w, -12, -2) : 0.0;
    }
    return def;
}

/// A copy of a result.
typedef struct Result
{
    qcPairList pairs;
    qcContact* contacts;
    size_t contactCount;
    uint64_t followed;
} Result;

static Result Detect(World* w, const qcDetectDef* def)
{
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(w->scene, def, &result));
    Result answer = {.pairs = {malloc((result->pairCount + 1) * sizeof(qcPair)), result->pairCount},
                     .contacts = malloc((result->contactCount + 1) * sizeof(qcContact)),
                     .contactCount = result->contactCount,
                     .followed = result->profile.followedTriangles};
    ck_assert(answer.pairs.pairs != NULL && answer.contacts != NULL);
    if (result->pairCount != 0)
        memcpy(answer.pairs.pairs, result->pairs, result->pairCount * sizeof(qcPair));
    if (result->contactCount != 0)
        memcpy(answer.contacts, result->contacts, result->contactCount * sizeof(qcContact));
    return answer;
}

static void FreeAnswer(Result* answer)
{
    free(answer->pairs.pairs);
    free(answer->contacts);
}

/// Detections that run out of memory leave the scene as it was.
static void RunOutOfMemory(World* w, const qcDetectDef* def)
{
    const qcResult* result;
    __atomic_store_n(&s_left, Below(w, 30), __ATOMIC_RELAXED);
    qcStatus status = qcScene_Detect(w->scene, def, &result);
    __atomic_store_n(&s_left, SIZE_MAX, __ATOMIC_RELAXED);
    ck_assert(status == qc_statusOk || status == qc_statusOutOfMemory);
}

typedef struct Totals
{
    uint64_t detections, pairs, contacts, followed;
} Totals;

static void Check(World* w, const char* where, Totals* totals)
{
    qcDetectDef def = MakeDef(w);
    if (OneIn(w, 6))
        RunOutOfMemory(w, &def);
    Result found = Detect(w, &def);
    def.method = qc_methodBrute;
    Result expected = Detect(w, &def);
    char what[200];
    snprintf(what, sizeof what, "%s, size %g, at %g, margin %g, contacts %g, neighbours %d, threads %u, followed %u",
             where, w->size, w->offset[0] + w->offset[1] + w->offset[2], def.margin, def.contactMargin, def.neighbours,
             def.threads, (unsigned)found.followed);
    qcCheckSamePairs(&expected.pairs, &found.pairs, what);
    if (expected.contactCount != found.contactCount ||
        memcmp(expected.contacts, found.contacts, found.contactCount * sizeof(qcContact)) != 0)
        ck_abort_msg("%s: %zu contacts, expected %zu, or others", what, found.contactCount, expected.contactCount);
    totals->detections++;
    totals->pairs += found.pairs.count;
    totals->contacts += found.contactCount;
    totals->followed += found.followed;
    FreeAnswer(&found);
    FreeAnswer(&expected);
    // The Verlet list is filled in this step.
    for (int i = 0; i < qc_maxBodies; i++)
        if (w->bodies[i].isUsed && OneIn(w, 3))
            Keep(&w->bodies[i]);
}

static void RunScene(uint64_t seed, Totals* totals)
{
    World w = {.random = {seed}, .scene = qcMakeScene(NULL)};
    w.isCalm = OneIn(&w, 2);
    w.size = OneIn(&w, 3) ? Magnitude(&w, -990, 950) : Magnitude(&w, -20, 20);
    for (int axis = 0; axis < 3; axis++)
        w.offset[axis] = OneIn(&w, 2) ? 0.0 : w.size * Magnitude(&w, -3, OneIn(&w, 2) ? 4 : 50);
    w.wide = w.size * Magnitude(&w, -9, OneIn(&w, 4) ? 2 : -2);
    uint32_t count = 1 + Below(&w, 3);
    for (uint32_t i = 0; i < count; i++)
        AddBody(&w, &w.bodies[i]);
    for (int step = 0; step < qc_steps; step++)
    {
        char where[64];
        snprintf(where, sizeof where, "scene %llu, step %d", (unsigned long long)seed, step);
        Check(&w, where, totals);
        for (int i = 0; i < qc_maxBodies; i++)
            ChangeBody(&w, &w.bodies[i]);
    }
    for (int i = 0; i < qc_maxBodies; i++)
        if (w.bodies[i].isUsed)
            RemoveBody(&w, &w.bodies[i]);
    qcScene_Destroy(w.scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}

static uint64_t Environment(const char* name, uint64_t otherwise)
{
    const char* text = getenv(name);
    return text != NULL ? strtoull(text, NULL, 10) : otherwise;
}

START_TEST(after_any_sequence_of_changes_a_scene_has_the_pairs_of_brute_force)
{
    CHECK_OK(qcSetAllocator(Allocate, Release, NULL));
    uint64_t first = Environment("QC_TEST_SEED", 1), count = Environment("QC_TEST_SCENES", qc_minScenes);
    Totals totals = {0, 0, 0, 0};
    for (uint64_t seed = first; seed < first + count; seed++)
        RunScene(seed, &totals);
    if (count > qc_minScenes)
        printf("%llu detections, %llu pairs, %llu contacts, %llu triangles followed\n",
               (unsigned long long)totals.detections, (unsigned long long)totals.pairs,
               (unsigned long long)totals.contacts, (unsigned long long)totals.followed);
    ck_assert_uint_gt(totals.pairs, 100 * count);
    ck_assert_uint_gt(totals.contacts, 10 * count);
    ck_assert_uint_gt(totals.followed, 10 * count);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

QC_RUN_TESTS("random steps", after_any_sequence_of_changes_a_scene_has_the_pairs_of_brute_force)
