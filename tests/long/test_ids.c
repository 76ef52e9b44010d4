// Ids that are used up: counters start shortly before their last value. The scene's results stay those of a new scene,
// and no id of a removed body names another one.
#include "long/changing_world.h"
#include "support/replay.h"
#include "support/suite.h"

#include "broadphase/box_set.h"
#include "pipeline/scene_state.h"

#include <stdio.h>

/// Free slots have `left` ids before they are used up.
static void StartHigh(qcScene* scene, uint32_t left)
{
    for (size_t i = 0; i < scene->bodies.slots.count; i++)
    {
        qcBody* body = &QC_AT(qcBody, scene->bodies.slots, i);
        if (!qcBody_IsUsed(body))
            body->generation = UINT32_MAX - 2 * left + 1;
    }
}

static qcBodyId AddTriangle(qcScene* scene)
{
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions;
    def.vertexCount = 3;
    def.indices = indices;
    def.triangleCount = 1;
    qcBodyId id;
    CHECK_OK(qcScene_AddBody(scene, &def, &id));
    return id;
}

START_TEST(a_slot_whose_ids_are_used_up_stays_empty)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId first = AddTriangle(scene), other = AddTriangle(scene), ids[3];
    CHECK_OK(qcScene_RemoveBody(scene, first));
    StartHigh(scene, 2);
    for (uint32_t i = 0; i < 3; i++)
    {
        ids[i] = AddTriangle(scene);
        ck_assert_uint_eq(ids[i].slot, i < 2 ? first.slot : other.slot + 1);
        CHECK_OK(qcScene_RemoveBody(scene, ids[i]));
    }
    ck_assert_uint_eq(ids[1].generation, UINT32_MAX);
    qcBodyId last = AddTriangle(scene);
    ck_assert_uint_eq(last.slot, other.slot + 1);
    for (uint32_t i = 0; i < 3; i++)
        ck_assert(!qcScene_IsValid(scene, ids[i]));
    ck_assert(!qcScene_IsValid(scene, first));
    ck_assert(!qcScene_IsValid(scene, (qcBodyId){first.slot, 0}));
    ck_assert(qcScene_IsValid(scene, other) && qcScene_IsValid(scene, last));
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 2);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(results_are_those_of_a_new_scene_while_slots_are_used_up)
{
    for (uint64_t seed = 1; seed <= 4; seed++)
    {
        qcWorld world;
        qcWorld_Create(&world, seed, NULL);
        size_t found = 0;
        for (int step = 0; step < 600; step++)
        {
            if (step == 100)
            {
                qcWorld_Clear(&world);
                StartHigh(world.scene, 2);
            }
            char where[64];
            snprintf(where, sizeof where, "seed %u, step %d", (unsigned)seed, step);
            qcWorld_Change(&world);
            qcDetectDef def = qcWorld_MakeDef(&world);
            found += qcWorld_Compare(&world, &def, where);
            qcWorld_CheckRemoved(&world);
        }
        uint32_t usedUp = 0;
        for (size_t i = 0; i < world.scene->bodies.slots.count; i++)
            usedUp += QC_AT(qcBody, world.scene->bodies.slots, i).generation == 0;
        ck_assert_uint_gt(usedUp, 0);
        ck_assert_uint_gt(found, 1000);
        qcWorld_Destroy(&world);
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
}
END_TEST

/// Uses up a slot before and during the recording.
static void RecordUsedUpSlots(const char* path)
{
    qcScene* scene = qcMakeScene(NULL);
    qcBodyId ids[4];
    for (int i = 0; i < 4; i++)
        ids[i] = AddTriangle(scene);
    CHECK_OK(qcScene_RemoveBody(scene, ids[0]));
    CHECK_OK(qcScene_RemoveBody(scene, ids[2]));
    StartHigh(scene, 1);
    CHECK_OK(qcScene_RemoveBody(scene, AddTriangle(scene)));
    qcBodyId second = AddTriangle(scene);
    CHECK_OK(qcScene_Record(scene, path));
    qcDetectDef def = qcDefaultDetectDef();
    def.touching = true;
    for (int i = 0; i < 3; i++)
    {
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &def, &result));
        ck_assert_uint_eq(result->pairCount, 3);
        CHECK_OK(qcScene_RemoveBody(scene, second));
        second = AddTriangle(scene);
    }
    ck_assert_uint_eq(second.slot, 4);
    qcScene_Destroy(scene);
}

START_TEST(a_recording_of_a_scene_with_used_up_slots_replays)
{
    const char* path = "test_ids.qcr";
    RecordUsedUpSlots(path);
    Replay replay = ReplayFile(path, NULL, qc_methodSweep, 1);
    ck_assert(replay.isComplete);
    ck_assert_uint_eq(replay.detections, 3);
    remove(path);
}
END_TEST

enum
{
    qc_boxCount = 60
};

static void MoveBox(qcRandom* random, double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = qcRandom_Uniform(random, 0.0, 4.0);
        upper[axis] = lower[axis] + qcRandom_Uniform(random, 0.0, 1.0);
    }
}

static size_t CountPairs(double lower[][3], double upper[][3])
{
    size_t count = 0;
    for (int a = 0; a < qc_boxCount; a++)
        for (int b = 0; b < a; b++)
        {
            bool overlap = true;
            for (int axis = 0; axis < 3; axis++)
                overlap = overlap && lower[a][axis] <= upper[b][axis] && lower[b][axis] <= upper[a][axis];
            count += overlap;
        }
    return count;
}

START_TEST(visit_marks_of_boxes_that_are_used_up_start_again)
{
    qcRandom random = {1};
    qcBoxes* boxes;
    CHECK_OK(qcBoxes_Create(&boxes));
    double lower[qc_boxCount][3], upper[qc_boxCount][3];
    uint32_t ids[qc_boxCount];
    for (int i = 0; i < qc_boxCount; i++)
    {
        MoveBox(&random, lower[i], upper[i]);
        CHECK_OK(qcBoxes_Add(boxes, lower[i], upper[i], NULL, &ids[i]));
    }
    size_t pairs = 0;
    uint32_t restarts = 0;
    for (int step = 0; step < 200; step++)
    {
        qcBoxChanges changes;
        uint32_t mark = boxes->lastMark = step % 10 == 5 ? UINT32_MAX - (uint32_t)step / 10 : boxes->lastMark;
        CHECK_OK(qcBoxes_FindChangedPairs(boxes, &changes));
        restarts += boxes->lastMark < mark;
        pairs += changes.beganCount - changes.endedCount;
        ck_assert_uint_eq(pairs, CountPairs(lower, upper));
        for (int i = 0; i < qc_boxCount; i++)
            if (qcRandom_Below(&random, 3) == 0)
            {
                MoveBox(&random, lower[i], upper[i]);
                CHECK_OK(qcBoxes_Move(boxes, ids[i], lower[i], upper[i]));
            }
    }
    ck_assert_uint_gt(restarts, 10);
    qcBoxes_Destroy(boxes);
}
END_TEST

QC_RUN_TESTS("ids", a_slot_whose_ids_are_used_up_stays_empty, results_are_those_of_a_new_scene_while_slots_are_used_up,
             a_recording_of_a_scene_with_used_up_slots_replays, visit_marks_of_boxes_that_are_used_up_start_again)
