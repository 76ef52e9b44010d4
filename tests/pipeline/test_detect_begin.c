// A step in the background gives what qcScene_Detect gives; until its end the scene refuses all that would disturb it.
#define _DEFAULT_SOURCE // fork
#include "support/devices.h"
#include "support/failing_heap.h"
#include "support/replay.h"
#include "support/run_program.h"
#include "support/sanitizers.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <pthread.h>
#include <semaphore.h>
#include <stdio.h>
#include <sys/wait.h>
#include <unistd.h>

/// A deforming cloth and a rigid soup, in two scenes that have the same input.
typedef struct World
{
    qcScene* scene;
    qcBodyId cloth, rigid;
    qcSoup soup;
    uint64_t step;
} World;

static World MakeWorld(qcDevice* device, uint32_t side)
{
    World world = {.scene = qcMakeScene(device), .soup = qcSoup_MakeFoldedCloth(3, side, 0.02, 0.02)};
    qcBodyDef def = qcBodyDefOf(&world.soup);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(world.scene, &def, &world.cloth));
    qcSoup other = qcSoup_MakeRandom(5, 300, 0.1);
    world.rigid = qcAddSoup(world.scene, &other);
    qcSoup_Free(&other);
    return world;
}

static void EndWorld(World* world)
{
    qcScene_Destroy(world->scene);
    qcSoup_Free(&world->soup);
}

/// Changes the caller's positions; the same ones in each world's same step.
static void Shake(World* world)
{
    qcRandom random = {++world->step};
    for (size_t i = 0; i < 3 * (size_t)world->soup.vertexCount; i++)
        world->soup.positions[i] += qcRandom_Uniform(&random, -0.003, 0.003);
}

/// The input of a step.
static void Move(World* world)
{
    Shake(world);
    CHECK_OK(qcScene_SetVertices(world->scene, world->cloth, world->soup.positions, qc_positionF64, 0));
    qcTransform transform = qcIdentityTransform();
    transform.translation[0] = 0.01 * (double)world->step;
    CHECK_OK(qcScene_SetTransform(world->scene, world->rigid, &transform));
}

static qcDetectDef DefOf(qcMethod method, uint32_t threads)
{
    bool image = method == qc_methodCullide || method == qc_methodQuick;
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.threads = threads;
    def.touching = def.segments = def.proximities = def.manifolds = def.candidates = true;
    def.margin = image ? 0.0 : 0.004;
    def.contactMargin = image ? 0.0 : 0.004;
    def.resolution = 128;
    def.views[1] = 0;
    return def;
}

/// All methods that never miss a pair give the same pairs. Their candidates differ, and `auto` chooses by measured
/// time whether a device answers.
static void CheckEqual(const qcResult* expected, const qcResult* found, qcMethod method)
{
    qcResultHash a = qcResult_Hash(expected), b = qcResult_Hash(found);
    ck_assert_uint_gt(expected->pairCount, 0);
    ck_assert_msg(memcmp(&a, &b, sizeof a) == 0, "%s: %zu pairs, expected %zu", qcMethod_Name(method), found->pairCount,
                  expected->pairCount);
    if (method == qc_methodAuto &&
        (expected->profile.method == qc_methodLayers) != (found->profile.method == qc_methodLayers))
        return;
    ck_assert_int_eq(expected->profile.method, found->profile.method);
    ck_assert_uint_eq(expected->pcsCount, found->pcsCount);
    ck_assert(memcmp(expected->pcs, found->pcs, found->pcsCount * sizeof *found->pcs) == 0);
    ck_assert_uint_eq(expected->candidateCount, found->candidateCount);
}

static void CompareWays(qcDevice* device, qcMethod method, uint32_t threads)
{
    World direct = MakeWorld(device, 14), begun = MakeWorld(device, 14);
    qcDetectDef def = DefOf(method, threads);
    for (int step = 0; step < 4; step++)
    {
        const qcResult *expected, *found = NULL;
        Move(&direct);
        Move(&begun);
        CHECK_OK(qcScene_Detect(direct.scene, &def, &expected));
        qcDetectDef given = def;
        CHECK_OK(qcScene_DetectBegin(begun.scene, &given));
        // The input was copied.
        memset(&given, 0xff, sizeof given);
        size_t size = 3 * sizeof(double) * begun.soup.vertexCount;
        memset(begun.soup.positions, 0xff, size);
        if (step > 1)
            usleep(3000); // the thread begins before the end, and after it
        CHECK_OK(qcScene_DetectEnd(begun.scene, &found));
        CheckEqual(expected, found, method);
        memcpy(begun.soup.positions, direct.soup.positions, size);
    }
    EndWorld(&direct);
    EndWorld(&begun);
}

START_TEST(a_step_in_the_background_has_the_result_of_detect_by_every_method_and_number_of_threads)
{
    for (int method = qc_methodAuto; method <= qc_methodLayers; method++)
        for (uint32_t threads = 1; threads <= 3; threads++)
            CompareWays(NULL, (qcMethod)method, threads);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_step_in_the_background_has_the_result_of_detect_on_every_device)
{
    QC_FOR_EACH_DEVICE(device)
    for (int method = qc_methodAuto; method <= qc_methodLayers; method++)
        for (uint32_t threads = 1; threads <= 2; threads++)
            CompareWays(device, (qcMethod)method, threads);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Each step is ended in the next one, before the new input: one step of latency. Begun and direct steps of the same
/// input are compared.
static void CompareLate(qcDevice* device, qcMethod method, uint32_t threads)
{
    World direct = MakeWorld(device, 14), late = MakeWorld(device, 14);
    qcDetectDef def = DefOf(method, threads);
    const qcResult *expected = NULL, *found = NULL;
    for (int step = 0; step < 6; step++)
    {
        if (step != 0)
        {
            CHECK_OK(qcScene_DetectEnd(late.scene, &found));
            CheckEqual(expected, found, method);
        }
        Move(&late);
        CHECK_OK(qcScene_DetectBegin(late.scene, &def));
        Move(&direct);
        CHECK_OK(qcScene_Detect(direct.scene, &def, &expected));
    }
    CHECK_OK(qcScene_DetectEnd(late.scene, &found));
    CheckEqual(expected, found, method);
    EndWorld(&direct);
    EndWorld(&late);
}

START_TEST(a_step_ended_in_the_next_one_gives_the_result_of_the_previous_input)
{
    for (int method = qc_methodAuto; method <= qc_methodLayers; method++)
        CompareLate(NULL, (qcMethod)method, 2);
    QC_FOR_EACH_DEVICE(device)
    for (int method = qc_methodAuto; method <= qc_methodLayers; method++)
        CompareLate(device, (qcMethod)method, 2);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

enum
{
    qc_sceneCount = 4
};

static void EndTogether(qcDevice* device, qcMethod method)
{
    World begun[qc_sceneCount], direct = MakeWorld(device, 20);
    qcDetectDef def = DefOf(method, 0);
    const qcResult *expected, *found;
    CHECK_OK(qcScene_Detect(direct.scene, &def, &expected));
    for (int i = 0; i < qc_sceneCount; i++)
    {
        begun[i] = MakeWorld(device, 20);
        CHECK_OK(qcScene_DetectBegin(begun[i].scene, &def));
    }
    for (int i = qc_sceneCount - 1; i >= 0; i--)
    {
        CHECK_OK(qcScene_DetectEnd(begun[i].scene, &found));
        CheckEqual(expected, found, method);
        EndWorld(&begun[i]);
    }
    EndWorld(&direct);
}

START_TEST(steps_of_several_scenes_run_at_once_also_with_one_device)
{
    EndTogether(NULL, qc_methodSweep);
    QC_FOR_EACH_DEVICE(device)
    {
        EndTogether(device, qc_methodLayers);
        EndTogether(device, qc_methodAuto);
    }
}
END_TEST

//  ---- what a pending step allows ------------------------------------------------------------------------------------

/// Holds a step at its first call of the filter.
typedef struct Gate
{
    sem_t entered, open;
    bool isPassed;
} Gate;

static bool WaitAtGate(void* context, uint32_t a, uint32_t b)
{
    Gate* gate = context;
    (void)a;
    (void)b;
    if (gate->isPassed)
        return true;
    gate->isPassed = true;
    sem_post(&gate->entered);
    while (sem_wait(&gate->open) != 0)
        continue;
    return true;
}

static void MakeGate(Gate* gate, qcDetectDef* def)
{
    *gate = (Gate){.isPassed = false};
    sem_init(&gate->entered, 0, 0);
    sem_init(&gate->open, 0, 0);
    def->pairFilter = WaitAtGate;
    def->pairFilterContext = gate;
}

static void Refused(qcStatus status, const char* function)
{
    char expected[160];
    snprintf(expected, sizeof expected,
             "%s: the detection begun by qcScene_DetectBegin is pending; call qcScene_DetectEnd first", function);
    ck_assert_int_eq(status, qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), expected);
}

static void CheckRefusals(World* world, const qcDetectDef* def)
{
    qcScene* scene = world->scene;
    qcBodyDef body = qcBodyDefOf(&world->soup);
    const qcTransform transform = qcIdentityTransform();
    const qcResult* result = NULL;
    qcBodyId id;
    Refused(qcScene_AddBody(scene, &body, &id), "qcScene_AddBody");
    Refused(qcScene_RemoveBody(scene, world->rigid), "qcScene_RemoveBody");
    Refused(qcScene_SetTransform(scene, world->rigid, &transform), "qcScene_SetTransform");
    Refused(qcScene_SetVertices(scene, world->cloth, world->soup.positions, qc_positionF64, 0), "qcScene_SetVertices");
    Refused(qcScene_MarkStart(scene), "qcScene_MarkStart");
    Refused(qcScene_SetActivity(scene, world->rigid, qc_activityStatic), "qcScene_SetActivity");
    Refused(qcScene_SetFilter(scene, world->rigid, 0, 0), "qcScene_SetFilter");
    Refused(qcScene_SetSelfCollision(scene, world->cloth, false), "qcScene_SetSelfCollision");
    Refused(qcScene_SetMargin(scene, world->cloth, 0.0), "qcScene_SetMargin");
    Refused(qcScene_Record(scene, "pending.qcr"), "qcScene_Record");
    Refused(qcScene_Detect(scene, def, &result), "qcScene_Detect");
    Refused(qcScene_DetectBegin(scene, def), "qcScene_DetectBegin");
    ck_assert_int_eq(qcScene_DetectEnd(scene, NULL), qc_statusBadInput);
    ck_assert_ptr_null(result);
    ck_assert(qcScene_IsValid(scene, world->rigid));
    ck_assert_uint_eq(qcScene_GetBodyCount(scene), 2);
}

START_TEST(a_pending_step_runs_beside_its_caller_and_refuses_changes_without_effect)
{
    World direct = MakeWorld(NULL, 14), begun = MakeWorld(NULL, 14);
    qcDetectDef def = DefOf(qc_methodSweep, 2);
    const qcResult *expected, *found;
    Move(&direct);
    Move(&begun);
    CHECK_OK(qcScene_Detect(direct.scene, &def, &expected));
    qcDetectDef held = def;
    Gate gate;
    MakeGate(&gate, &held);
    CHECK_OK(qcScene_DetectBegin(begun.scene, &held));
    // It comes to the filter without the caller's help.
    sem_wait(&gate.entered);
    Shake(&begun);
    CheckRefusals(&begun, &def);
    sem_post(&gate.open);
    CHECK_OK(qcScene_DetectEnd(begun.scene, &found));
    CheckEqual(expected, found, def.method);
    // The scene is as if nothing had been called.
    Move(&direct);
    CHECK_OK(qcScene_SetVertices(begun.scene, begun.cloth, direct.soup.positions, qc_positionF64, 0));
    qcTransform transform = qcIdentityTransform();
    transform.translation[0] = 0.01 * (double)direct.step;
    CHECK_OK(qcScene_SetTransform(begun.scene, begun.rigid, &transform));
    CHECK_OK(qcScene_Detect(direct.scene, &def, &expected));
    CHECK_OK(qcScene_Detect(begun.scene, &def, &found));
    CheckEqual(expected, found, def.method);
    EndWorld(&direct);
    EndWorld(&begun);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(calls_in_the_wrong_order_are_refused)
{
    World world = MakeWorld(NULL, 8);
    const qcResult* result = NULL;
    qcDetectDef def = DefOf(qc_methodSweep, 1);
    ck_assert_int_eq(qcScene_DetectEnd(world.scene, &result), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcScene_DetectEnd: no detection is pending");
    ck_assert_int_eq(qcScene_DetectEnd(NULL, &result), qc_statusBadInput);
    ck_assert_int_eq(qcScene_DetectBegin(NULL, &def), qc_statusBadInput);
    ck_assert_int_eq(qcScene_DetectBegin(world.scene, NULL), qc_statusBadInput);
    def.margin = -1.0;
    ck_assert_int_eq(qcScene_DetectBegin(world.scene, &def), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcScene_DetectBegin: margin is -1; it must be finite and 0 or more");
    // Nothing is pending.
    Move(&world);
    def.margin = 0.0;
    CHECK_OK(qcScene_DetectBegin(world.scene, &def));
    CHECK_OK(qcScene_DetectEnd(world.scene, &result));
    ck_assert_int_eq(qcScene_DetectEnd(world.scene, &result), qc_statusBadInput);
    CHECK_OK(qcScene_Detect(world.scene, &def, &result));
    ck_assert(result->profile.reused);
    EndWorld(&world);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_scene_is_destroyed_while_its_step_is_pending)
{
    for (int i = 0; i < 20; i++)
    {
        World world = MakeWorld(NULL, 20);
        qcDetectDef def = DefOf(qc_methodSweep, 2);
        CHECK_OK(qcScene_DetectBegin(world.scene, &def));
        if (i % 2 == 0)
            usleep(500);
        EndWorld(&world);
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
}
END_TEST

//  ---- failures, recordings, child processes -------------------------------------------------------------------------

/// Two steps, begun and ended. The first status that is not ok; the same step again then succeeds.
static qcStatus UseScene(const qcSoup* soup, size_t* pairs)
{
    qcScene* scene = NULL;
    const qcSceneDef sceneDef = qcDefaultSceneDef();
    qcBodyDef bodyDef = qcBodyDefOf(soup);
    bodyDef.deforming = true;
    qcBodyId id;
    qcStatus status = qcScene_Create(&sceneDef, &scene);
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &bodyDef, &id);
    const qcResult* result = NULL;
    qcDetectDef def = DefOf(qc_methodSweep, 1);
    if (status == qc_statusOk)
    {
        status = qcScene_DetectBegin(scene, &def);
        if (status == qc_statusOk)
            status = qcScene_DetectEnd(scene, &result);
        if (status != qc_statusOk)
        {
            ck_assert_ptr_nonnull(strstr(qcLastMessage(), "out of memory"));
            CHECK_OK(qcScene_DetectBegin(scene, &def));
            CHECK_OK(qcScene_DetectEnd(scene, &result));
        }
        *pairs = result->pairCount;
    }
    qcScene_Destroy(scene);
    return status;
}

START_TEST(a_failed_allocation_in_the_background_is_reported_at_the_end_and_the_scene_stays_valid)
{
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 8, 0.02, 0.03);
    size_t expected = 0;
    CHECK_OK(UseScene(&soup, &expected));
    ck_assert_uint_gt(expected, 0);
    for (size_t i = 1, calls = heap.calls; i <= calls; i++)
    {
        size_t pairs = expected;
        heap = (qcFailingHeap){0, 0, i};
        ck_assert_int_eq(UseScene(&soup, &pairs), qc_statusOutOfMemory);
        ck_assert_uint_eq(pairs, expected);
        ck_assert_uint_eq(heap.live, 0);
        ck_assert_uint_eq(qcGetByteCount(), 0);
    }
    qcSoup_Free(&soup);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
}
END_TEST

START_TEST(a_recording_of_steps_in_the_background_replays)
{
    const char* path = "steps.qcr";
    EnterFolder();
    World world = MakeWorld(NULL, 10);
    CHECK_OK(qcScene_Record(world.scene, path));
    qcDetectDef def = DefOf(qc_methodSweep, 2);
    Gate gate;
    for (int step = 0; step < 5; step++)
    {
        const qcResult* result;
        Move(&world);
        MakeGate(&gate, &def);
        sem_post(&gate.open);
        CHECK_OK(qcScene_DetectBegin(world.scene, &def));
        // Refused calls aren't recorded.
        ck_assert_int_eq(qcScene_MarkStart(world.scene), qc_statusBadInput);
        if (step < 4)
            CHECK_OK(qcScene_DetectEnd(world.scene, &result));
    }
    // The last one is pending.
    EndWorld(&world);
    Replay replay = ReplayFile(path, NULL, qc_methodSweep, 2);
    ck_assert(replay.isComplete);
    ck_assert_uint_eq(replay.detections, 5);
    LeaveFolder();
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// Opens it a while later.
static void* OpenGate(void* gate)
{
    usleep(20000);
    sem_post(&((Gate*)gate)->open);
    return NULL;
}

/// The exit status of a child that ends the parent's step and runs another one.
static int GoOnInChild(World* world, const qcDetectDef* def, uint64_t pairs)
{
    const qcResult* result;
    alarm(60); // against hanging
    if (qcScene_DetectEnd(world->scene, &result) != qc_statusOk)
        return 1;
    if (qcResult_Hash(result).pairs != pairs)
        return 2;
    Move(world);
    if (qcScene_DetectBegin(world->scene, def) != qc_statusOk)
        return 3;
    usleep(2000);
    if (qcScene_DetectEnd(world->scene, &result) != qc_statusOk || result->pairCount == 0)
        return 4;
    EndWorld(world);
    return qcGetByteCount() == 0 ? 0 : 5;
}

START_TEST(a_child_process_ends_the_step_that_was_pending_at_fork)
{
    if (!qcChildrenCanStartThreads() || !qcForksCanWait())
        return;
    World world = MakeWorld(NULL, 14), direct = MakeWorld(NULL, 14);
    qcDetectDef def = DefOf(qc_methodSweep, 2), held = def;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(direct.scene, &def, &result));
    uint64_t pairs = qcResult_Hash(result).pairs;
    EndWorld(&direct);
    Gate gate;
    MakeGate(&gate, &held);
    CHECK_OK(qcScene_DetectBegin(world.scene, &held));
    sem_wait(&gate.entered);
    // The step runs, and goes on during fork().
    pthread_t opener;
    ck_assert_int_eq(pthread_create(&opener, NULL, OpenGate, &gate), 0);
    fflush(NULL);
    pid_t child = fork();
    ck_assert_int_ge(child, 0);
    if (child == 0)
        _exit(GoOnInChild(&world, &def, pairs));
    int status = 0;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_msg(WIFEXITED(status) && WEXITSTATUS(status) == 0, "the child failed: %d", status);
    pthread_join(opener, NULL);
    CHECK_OK(qcScene_DetectEnd(world.scene, &result));
    ck_assert_uint_eq(qcResult_Hash(result).pairs, pairs);
    EndWorld(&world);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("detect begin", a_step_in_the_background_has_the_result_of_detect_by_every_method_and_number_of_threads,
             a_step_in_the_background_has_the_result_of_detect_on_every_device,
             a_step_ended_in_the_next_one_gives_the_result_of_the_previous_input,
             steps_of_several_scenes_run_at_once_also_with_one_device,
             a_pending_step_runs_beside_its_caller_and_refuses_changes_without_effect,
             calls_in_the_wrong_order_are_refused, a_scene_is_destroyed_while_its_step_is_pending,
             a_failed_allocation_in_the_background_is_reported_at_the_end_and_the_scene_stays_valid,
             a_recording_of_steps_in_the_background_replays, a_child_process_ends_the_step_that_was_pending_at_fork)
