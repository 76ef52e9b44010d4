// A recording that can't be written changes nothing in the scene. QC_RECORD, forks and crashes.
#define _DEFAULT_SOURCE // setrlimit, setenv
#include "recording/random_history.h"
#include "support/replay.h"
#include "support/failing_heap.h"
#include "support/kept_line.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

/// A history's hash over all results, recorded if `path` is not null.
static uint64_t RunHistory(const char* path, qcStatus* started, qcStatus* ended)
{
    qcScene* scene = qcMakeScene(NULL);
    *started = path != NULL ? qcScene_Record(scene, path) : qc_statusOk;
    History history = History_Start(3, scene, 12);
    for (int i = 0; i < 10; i++)
        History_Step(&history);
    *ended = qcScene_Record(scene, NULL);
    qcScene_Destroy(scene);
    History_End(&history);
    return history.pairs;
}

START_TEST(a_full_disk_stops_the_recording_and_nothing_else)
{
    qcSetLog(KeepLine, NULL);
    qcStatus started, ended;
    uint64_t pairs = RunHistory(NULL, &started, &ended);
    ck_assert_uint_gt(pairs, 0);
    ck_assert_uint_eq(RunHistory("/dev/full", &started, &ended), pairs);
    ck_assert_int_eq(started, qc_statusFile);
    ck_assert_ptr_nonnull(strstr(s_line, "No space left on device"));
    ck_assert_int_eq(ended, qc_statusOk);
    qcSetLog(NULL, NULL);
    ck_assert_uint_eq(RunHistory("/no/such/folder/a.qcr", &started, &ended), pairs);
    ck_assert_int_eq(started, qc_statusFile);
    qcScene* scene = qcMakeScene(NULL);
    ck_assert_int_eq(qcScene_Record(scene, "/no/such/folder/a.qcr"), qc_statusFile);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "/no/such/folder/a.qcr can't be created"));
    ck_assert_int_eq(qcScene_Record(NULL, "a.qcr"), qc_statusBadInput);
    qcScene_Destroy(scene);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// A disk that is full later: writes beyond 20 000 bytes fail.
START_TEST(a_disk_that_fills_up_is_logged_once_and_the_file_stays_usable)
{
    EnterFolder();
    qcStatus started, ended;
    uint64_t pairs = RunHistory(NULL, &started, &ended);
    s_lines = 0;
    // The limit is a child's own; SIGXFSZ, its signal, is ignored.
    pid_t child = fork();
    if (child == 0)
    {
        qcSetLog(KeepLine, NULL);
        struct rlimit limit = {20000, 20000};
        signal(SIGXFSZ, SIG_IGN);
        bool isRight = setrlimit(RLIMIT_FSIZE, &limit) == 0 && RunHistory("a.qcr", &started, &ended) == pairs &&
                       started == qc_statusOk && ended == qc_statusFile && s_lines == 1 &&
                       strstr(qcLastMessage(), "the recording a.qcr stopped: behind byte") != NULL;
        _exit(isRight ? 0 : 1);
    }
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_int_eq(status, 0);
    qcRecording* recording;
    CHECK_OK(qcRecording_Open("a.qcr", &recording));
    const qcOperation* operation;
    size_t count = 0;
    while (qcRecording_Next(recording, &operation) == qc_statusOk && operation->kind != qc_operationEnd)
        count++;
    ck_assert_uint_gt(count, 3);
    qcRecording_Close(recording);
    LeaveFolder();
}
END_TEST

static bool RejectAll(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    (void)slotA;
    (void)slotB;
    return false;
}

START_TEST(each_failed_allocation_of_the_recorder_stops_the_recording_only)
{
    EnterFolder();
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    qcSoup soup = qcSoup_MakeFoldedCloth(2, 8, 0.02, 0.03);
    size_t stops = 0;
    for (size_t call = 1; call < 60; call++)
    {
        heap.failAt = 0;
        qcScene* scene = qcMakeScene(NULL);
        qcBodyDef def = qcBodyDefOf(&soup);
        def.deforming = true;
        qcBodyId id;
        CHECK_OK(qcScene_AddBody(scene, &def, &id));
        qcAddSoup(scene, &soup);
        // Once, so that the scene itself allocates nothing in the second round.
        qcDetectDef detect = qcDefaultDetectDef();
        detect.threads = 1;
        detect.pairFilter = RejectAll;
        const qcResult* result;
        CHECK_OK(qcScene_Detect(scene, &detect, &result));
        size_t pairs = result->pairCount;
        heap.calls = 0;
        heap.failAt = call;
        qcStatus started = qcScene_Record(scene, "a.qcr"), status = qc_statusOk;
        for (int i = 0; i < 3 && status == qc_statusOk; i++)
        {
            CHECK_OK(qcScene_SetVertices(scene, id, soup.positions, qc_positionF64, 0));
            CHECK_OK(qcScene_SetMargin(scene, id, 1.0));
            status = qcScene_Detect(scene, &detect, &result);
        }
        bool failed = heap.calls >= heap.failAt;
        heap.failAt = 0;
        qcStatus ended = qcScene_Record(scene, NULL);
        // The scene's own allocations in a detection may fail too: that is its own status.
        ck_assert(status != qc_statusOk || result->pairCount == pairs);
        ck_assert(started == qc_statusOk || started == qc_statusOutOfMemory);
        ck_assert(ended == qc_statusOk || ended == qc_statusOutOfMemory);
        ck_assert(!failed || started != qc_statusOk || ended != qc_statusOk || status != qc_statusOk);
        stops += started != qc_statusOk || ended != qc_statusOk;
        qcScene_Destroy(scene);
        ck_assert_uint_eq(heap.live, 0);
    }
    ck_assert_uint_gt(stops, 5);
    qcSoup_Free(&soup);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    LeaveFolder();
}
END_TEST

START_TEST(the_environment_variable_records_every_scene_and_replaces_no_file)
{
    EnterFolder();
    WriteText("a.2.qcr", "mine");
    ck_assert_int_eq(setenv("QC_RECORD", "a", 1), 0);
    qcStatus started, ended;
    for (int i = 0; i < 2; i++)
        RunHistory(NULL, &started, &ended);
    ck_assert_int_eq(unsetenv("QC_RECORD"), 0);
    RunHistory(NULL, &started, &ended);
    char text[16];
    ck_assert(ReadText("a.2.qcr", text, sizeof text));
    ck_assert_str_eq(text, "mine");
    ck_assert_uint_eq(CountEntries(), 3);
    ck_assert_uint_eq(ReplayFile("a.1.qcr", NULL, qc_methodSweep, 1).detections, 10);
    ck_assert_uint_eq(ReplayFile("a.3.qcr", NULL, qc_methodSweep, 1).detections, 10);
    LeaveFolder();
}
END_TEST

START_TEST(a_prefix_that_can_not_be_written_is_logged_and_changes_nothing)
{
    qcStatus started, ended;
    uint64_t pairs = RunHistory(NULL, &started, &ended);
    ck_assert_int_eq(setenv("QC_RECORD", "/no/such/folder/a", 1), 0);
    qcSetLog(KeepLine, NULL);
    s_lines = 0;
    ck_assert_uint_eq(RunHistory(NULL, &started, &ended), pairs);
    ck_assert_int_eq(s_lines, 1);
    ck_assert_ptr_nonnull(strstr(s_line, "/no/such/folder/a.1.qcr can't be created: No such file or directory"));
    qcSetLog(NULL, NULL);
    ck_assert_int_eq(unsetenv("QC_RECORD"), 0);
}
END_TEST

START_TEST(a_recorder_without_memory_is_logged_and_the_scene_goes_on)
{
    EnterFolder();
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    ck_assert_int_eq(setenv("QC_RECORD", "a", 1), 0);
    qcSetLog(KeepLine, NULL);
    s_lines = 0;
    int scenes = 0;
    bool failed = true;
    for (size_t call = 1; failed; call++)
    {
        heap.calls = 0;
        heap.failAt = call;
        qcSceneDef def = qcDefaultSceneDef();
        qcScene* scene = NULL;
        qcStatus status = qcScene_Create(&def, &scene);
        failed = heap.calls >= call;
        heap.failAt = 0;
        ck_assert(status == qc_statusOk || (failed && status == qc_statusOutOfMemory));
        scenes += failed && status == qc_statusOk;
        qcScene_Destroy(scene);
        ck_assert_uint_eq(heap.live, 0);
    }
    // Each scene whose recorder failed has a line of its own.
    ck_assert_int_gt(scenes, 2);
    ck_assert_int_eq(s_lines, scenes);
    ck_assert_ptr_nonnull(strstr(s_line, "out of memory"));
    qcSetLog(NULL, NULL);
    ck_assert_int_eq(unsetenv("QC_RECORD"), 0);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    LeaveFolder();
}
END_TEST

START_TEST(a_child_of_fork_leaves_the_parents_file_alone)
{
    EnterFolder();
    qcScene* scene = qcMakeScene(NULL);
    CHECK_OK(qcScene_Record(scene, "a.qcr"));
    History history = History_Start(5, scene, 6);
    for (int i = 0; i < 4; i++)
        History_Step(&history);
    pid_t child = fork();
    if (child == 0)
    {
        for (int i = 0; i < 4; i++)
            History_Step(&history);
        qcScene_Destroy(scene);
        _exit(0);
    }
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_int_eq(status, 0);
    for (int i = 0; i < 4; i++)
        History_Step(&history);
    qcScene_Destroy(scene);
    History_End(&history);
    Replay replay = ReplayFile("a.qcr", NULL, qc_methodSweep, 1);
    ck_assert_uint_eq(replay.detections, 8);
    ck_assert(replay.isComplete);
    LeaveFolder();
}
END_TEST

static bool CrashInFilter(void* context, uint32_t slotA, uint32_t slotB)
{
    (void)context;
    (void)slotA;
    (void)slotB;
    _exit(7);
}

START_TEST(a_detection_that_crashed_is_the_last_operation)
{
    EnterFolder();
    pid_t child = fork();
    if (child == 0)
    {
        qcScene* scene = qcMakeScene(NULL);
        qcSoup soup = qcSoup_MakeGrid(4);
        qcScene_Record(scene, "a.qcr");
        qcAddSoup(scene, &soup);
        qcAddSoup(scene, &soup);
        qcDetectDef def = qcDefaultDetectDef();
        def.pairFilter = CrashInFilter;
        const qcResult* result;
        qcScene_Detect(scene, &def, &result);
        _exit(0);
    }
    int status;
    ck_assert_int_eq(waitpid(child, &status, 0), child);
    ck_assert_int_eq(WEXITSTATUS(status), 7);
    qcRecording* recording;
    CHECK_OK(qcRecording_Open("a.qcr", &recording));
    const qcOperation* operation;
    for (int i = 0; i < 3; i++)
        CHECK_OK(qcRecording_Next(recording, &operation));
    ck_assert_int_eq(operation->kind, qc_operationDetect);
    ck_assert(!operation->hasResult);
    CHECK_OK(qcRecording_Next(recording, &operation));
    ck_assert_int_eq(operation->kind, qc_operationEnd);
    ck_assert(!operation->isComplete);
    qcRecording_Close(recording);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("recorder_failures", a_full_disk_stops_the_recording_and_nothing_else,
             a_disk_that_fills_up_is_logged_once_and_the_file_stays_usable,
             each_failed_allocation_of_the_recorder_stops_the_recording_only,
             the_environment_variable_records_every_scene_and_replaces_no_file,
             a_prefix_that_can_not_be_written_is_logged_and_changes_nothing,
             a_recorder_without_memory_is_logged_and_the_scene_goes_on, a_child_of_fork_leaves_the_parents_file_alone,
             a_detection_that_crashed_is_the_last_operation)
