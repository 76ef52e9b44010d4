// A random life of a scene: bodies are added, changed and removed between detections of every kind. A seed makes equal
// calls each time.
#ifndef QC_TESTS_RECORDING_RANDOM_HISTORY_H
#define QC_TESTS_RECORDING_RANDOM_HISTORY_H

#include "support/scenes.h"

enum
{
    qc_historyBodies = 6
};

typedef struct HistoryBody
{
    bool isUsed, deforming;
    qcBodyId id;
    qcSoup soup;
} HistoryBody;

typedef struct History
{
    qcRandom random;
    qcScene* scene;
    HistoryBody bodies[qc_historyBodies];
    uint32_t side;     ///< quads along a cloth: the size of the bodies
    size_t detections; ///< that succeeded
    uint64_t pairs;    ///< sum over the detections
} History;

static inline History History_Start(uint64_t seed, qcScene* scene, uint32_t side)
{
    return (History){.random = {seed}, .scene = scene, .side = side};
}

static inline void History_End(History* history)
{
    for (int i = 0; i < qc_historyBodies; i++)
        qcSoup_Free(&history->bodies[i].soup);
}

static inline bool History_OneIn(History* history, uint32_t count)
{
    return qcRandom_Below(&history->random, count) == 0;
}

static inline qcTransform History_Transform(History* history)
{
    qcTransform transform = qcIdentityTransform();
    for (int i = 0; i < 9; i++)
        transform.linear[i] += qcRandom_Uniform(&history->random, -0.1, 0.1);
    for (int i = 0; i < 3; i++)
        transform.translation[i] = qcRandom_Uniform(&history->random, -0.3, 0.3);
    return transform;
}

static inline void History_Add(History* history, HistoryBody* body)
{
    qcRandom* random = &history->random;
    qcSoup_Free(&body->soup);
    // Two shapes of cloth only: some bodies have equal indices.
    body->soup =
        History_OneIn(history, 3)
            ? qcSoup_MakeRandom(qcRandom_Next(random), 4 * history->side, 0.3)
            : qcSoup_MakeFoldedCloth(qcRandom_Next(random), history->side + qcRandom_Below(random, 2), 0.02, 0.03);
    qcBodyDef def = qcBodyDefOf(&body->soup);
    def.deforming = body->deforming = History_OneIn(history, 2);
    def.transform = History_Transform(history);
    def.activity = History_OneIn(history, 4) ? qc_activitySleeping : qc_activityMoving;
    def.selfCollision = !History_OneIn(history, 4);
    def.owner = qcRandom_Below(random, 3);
    def.group = 1u + qcRandom_Below(random, 2);
    def.margin = History_OneIn(history, 2) ? 0.01 : def.margin;
    CHECK_OK(qcScene_AddBody(history->scene, &def, &body->id));
    body->isUsed = true;
}

/// New positions as doubles, or as floats with a gap behind each.
static inline void History_Bend(History* history, HistoryBody* body)
{
    qcSoup* soup = &body->soup;
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        soup->positions[i] += qcRandom_Uniform(&history->random, -0.01, 0.01);
    if (History_OneIn(history, 2))
    {
        CHECK_OK(qcScene_SetVertices(history->scene, body->id, soup->positions, qc_positionF64, 0));
        return;
    }
    float* spaced = calloc(soup->vertexCount, 5 * sizeof *spaced);
    ck_assert_ptr_nonnull(spaced);
    for (size_t i = 0; i < 3 * (size_t)soup->vertexCount; i++)
        spaced[i / 3 * 5 + i % 3] = (float)soup->positions[i];
    CHECK_OK(qcScene_SetVertices(history->scene, body->id, spaced, qc_positionF32, 5 * sizeof *spaced));
    free(spaced);
}

static inline void History_Change(History* history, HistoryBody* body)
{
    qcScene* scene = history->scene;
    qcTransform transform = History_Transform(history);
    uint32_t number = qcRandom_Below(&history->random, 3);
    switch (qcRandom_Below(&history->random, 8))
    {
        case 0: CHECK_OK(qcScene_SetActivity(scene, body->id, (qcActivity)number)); break;
        case 1: CHECK_OK(qcScene_SetFilter(scene, body->id, number + 1, 0xff)); break;
        case 2: CHECK_OK(qcScene_SetSelfCollision(scene, body->id, number != 0)); break;
        case 3: CHECK_OK(qcScene_SetMargin(scene, body->id, 0.01 * number)); break;
        case 4:
            CHECK_OK(qcScene_RemoveBody(scene, body->id));
            body->isUsed = false;
            break;
        default:
            if (body->deforming)
                History_Bend(history, body);
            else
                CHECK_OK(qcScene_SetTransform(scene, body->id, &transform));
    }
}

/// A filter with an answer of its own for each pair.
static inline bool History_Filter(void* context, uint32_t slotA, uint32_t slotB)
{
    return ((slotA ^ slotB) + *(const uint32_t*)context) % 3 != 0;
}

static inline void History_Detect(History* history, uint32_t* salt)
{
    qcDetectDef def = qcDefaultDetectDef();
    uint32_t kind = qcRandom_Below(&history->random, 6);
    def.method = qc_methodSweep;
    def.threads = 1 + qcRandom_Below(&history->random, 2);
    def.touching = kind == 0;
    def.neighbours = kind == 1;
    def.segments = kind <= 1;
    def.margin = kind == 2 || kind == 3 ? 0.02 : 0.0;
    def.proximities = kind == 2;
    def.manifolds = kind == 3;
    def.spacing = kind == 3 ? 0.1 : 0.0;
    def.unoriented = kind == 3;
    def.contactMargin = kind == 4 ? 0.02 : 0.0;
    def.nearestContacts = kind == 4;
    def.motion = kind == 5;
    def.maxPairs = kind == 5 ? (uint64_t)1 << 40 : 0;
    *salt = qcRandom_Below(&history->random, 3);
    if (History_OneIn(history, 3))
    {
        def.pairFilter = History_Filter;
        def.pairFilterContext = salt;
    }
    const qcResult* result;
    CHECK_OK(qcScene_Detect(history->scene, &def, &result));
    history->pairs += result->pairCount;
    history->detections++;
}

/// A few changes, a detection, and now and then a mark and a call that is refused.
static inline void History_Step(History* history)
{
    uint32_t salt;
    for (uint32_t i = 1 + qcRandom_Below(&history->random, 4); i > 0; i--)
    {
        HistoryBody* body = &history->bodies[qcRandom_Below(&history->random, qc_historyBodies)];
        if (body->isUsed)
            History_Change(history, body);
        else
            History_Add(history, body);
    }
    if (History_OneIn(history, 3))
        CHECK_OK(qcScene_MarkStart(history->scene));
    ck_assert_int_eq(qcScene_RemoveBody(history->scene, (qcBodyId){99, 1}), qc_statusBadInput);
    History_Detect(history, &salt);
}

#endif
