// The recorder of a broadphase: what changes during a query is written behind it, and a failure stops the recording
// only.
#define _DEFAULT_SOURCE // setenv
#include "recording/recorded_boxes.h"
#include "recording/recorded_bytes.h"
#include "support/failing_heap.h"
#include "support/kept_line.h"
#include "support/run_program.h"
#include "support/suite.h"

#include <unistd.h>

/// The kinds of the operations in a file are these, in this order.
static void CheckKinds(const char* path, const qcOperationKind* kinds, size_t count)
{
    qcRecording* recording = NULL;
    const qcOperation* operation;
    CHECK_OK(qcRecording_Open(path, &recording));
    ck_assert_str_eq(qcRecording_GetInfo(recording).device, "none");
    for (size_t i = 0; i < count; i++)
    {
        CHECK_OK(qcRecording_Next(recording, &operation));
        ck_assert_msg(operation->kind == kinds[i], "operation %zu: %s, not %s", i,
                      qcOperationKind_Name(operation->kind), qcOperationKind_Name(kinds[i]));
    }
    qcRecording_Close(recording);
}

START_TEST(changes_during_nested_queries_are_written_behind_the_last)
{
    EnterFolder();
    const double bounds[6] = {0, 0, 0, 1, 1, 1};
    qcBoxRecorder* recorder = NULL;
    CHECK_OK(qcBoxRecorder_Open("a.qcr", 8, &recorder));
    qcBoxRecorder_Move(recorder, 7, bounds);
    qcBoxRecorder_Begin(recorder);
    qcBoxRecorder_Begin(recorder);
    qcBoxRecorder_Add(recorder, 1, bounds, 1, 1);
    qcBoxRecorder_EndQuery(recorder, bounds, NULL, 0);
    qcBoxRecorder_Move(recorder, 1, bounds);
    qcBoxRecorder_Remove(recorder, 1);
    qcBoxRecorder_Reset(recorder);
    qcBoxRecorder_EndPairs(recorder, NULL, 0, false, NULL, 0);
    // An end without a begin: the query is written, and nothing else changes.
    qcBoxRecorder_EndQuery(recorder, bounds, NULL, 0);
    qcBoxRecorder_Move(recorder, 2, bounds);
    CHECK_OK(qcBoxRecorder_Close(recorder));
    const qcOperationKind kinds[] = {qc_operationMoveBoxes,  qc_operationQueryBox,  qc_operationFindPairs,
                                     qc_operationAddBox,     qc_operationMoveBoxes, qc_operationRemoveBox,
                                     qc_operationResetBoxes, qc_operationQueryBox,  qc_operationMoveBoxes,
                                     qc_operationEnd};
    CheckKinds("a.qcr", kinds, sizeof kinds / sizeof kinds[0]);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    LeaveFolder();
}
END_TEST

START_TEST(each_failed_allocation_stops_the_recording_and_what_was_written_is_read)
{
    EnterFolder();
    qcFailingHeap heap = {0, 0, 0};
    CHECK_OK(qcSetAllocator(qcFailingHeap_Allocate, qcFailingHeap_Release, &heap));
    size_t stops = 0, refusals = 0;
    bool failed = true;
    for (size_t call = 1; failed; call++)
    {
        heap.calls = 0;
        heap.failAt = call;
        qcBoxRecorder* recorder = NULL;
        qcStatus opened = qcBoxRecorder_Open("a.qcr", 4, &recorder), closed = qc_statusOk;
        if (opened == qc_statusOk)
        {
            MakeBoxCalls(recorder);
            closed = qcBoxRecorder_Close(recorder);
        }
        else
            ck_assert_ptr_null(recorder);
        failed = heap.calls >= call;
        heap.failAt = 0;
        ck_assert_uint_eq(heap.live, 0);
        ck_assert(failed == (opened != qc_statusOk || closed != qc_statusOk));
        ck_assert(opened == qc_statusOk || opened == qc_statusOutOfMemory);
        ck_assert(closed == qc_statusOk || closed == qc_statusOutOfMemory);
        refusals += opened != qc_statusOk;
        stops += closed != qc_statusOk;
        qcStatus status;
        if (opened == qc_statusOk)
            (void)CountOperations("a.qcr", &status);
        ck_assert(opened != qc_statusOk || status == qc_statusOk);
    }
    ck_assert_uint_ge(refusals, 3);
    ck_assert_uint_ge(stops, 4);
    CHECK_OK(qcSetAllocator(NULL, NULL, NULL));
    LeaveFolder();
}
END_TEST

START_TEST(a_full_disk_is_logged_once_and_reported_at_the_end)
{
    qcSetLog(KeepLine, NULL);
    qcBoxRecorder* recorder = NULL;
    CHECK_OK(qcBoxRecorder_Open("/dev/full", 8, &recorder));
    MakeBoxCalls(recorder);
    ck_assert_int_eq(qcBoxRecorder_Close(recorder), qc_statusFile);
    ck_assert_ptr_nonnull(strstr(qcLastMessage(), "the recording /dev/full stopped: behind byte 0: No space left"));
    ck_assert_int_eq(s_lines, 1);
    ck_assert_str_eq(s_line, qcLastMessage());
    qcSetLog(NULL, NULL);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_broadphase_is_recorded_where_the_environment_says_so)
{
    EnterFolder();
    qcBoxRecorder* recorder = NULL;
    unsetenv("QC_RECORD");
    CHECK_OK(qcBoxRecorder_Open(NULL, 4, &recorder));
    ck_assert_ptr_null(recorder);
    ck_assert_int_eq(setenv("QC_RECORD", "b", 1), 0);
    CHECK_OK(qcBoxRecorder_Open(NULL, 4, &recorder));
    ck_assert_ptr_nonnull(recorder);
    MakeBoxCalls(recorder);
    CHECK_OK(qcBoxRecorder_Close(recorder));
    qcStatus status;
    ck_assert_uint_eq(CountOperations("b.1.qcr", &status), 12);
    ck_assert_int_eq(status, qc_statusOk);
    // A path that no file system has.
    char prefix[5000];
    memset(prefix, 'a', sizeof prefix);
    prefix[sizeof prefix - 1] = 0;
    ck_assert_int_eq(setenv("QC_RECORD", prefix, 1), 0);
    qcSetLog(KeepLine, NULL);
    CHECK_OK(qcBoxRecorder_Open(NULL, 4, &recorder));
    ck_assert_ptr_null(recorder);
    ck_assert_str_eq(s_line, "QC_RECORD is longer than a path may be");
    qcSetLog(NULL, NULL);
    unsetenv("QC_RECORD");
    LeaveFolder();
}
END_TEST

START_TEST(without_a_log_a_failure_goes_to_standard_error)
{
    EnterFolder();
    ck_assert_int_eq(setenv("QC_RECORD", "no/such/folder", 1), 0);
    fflush(stderr);
    int kept = dup(STDERR_FILENO);
    ck_assert_ptr_nonnull(freopen("errors", "w", stderr));
    qcBoxRecorder* recorder = NULL;
    qcStatus status = qcBoxRecorder_Open(NULL, 4, &recorder);
    fflush(stderr);
    dup2(kept, STDERR_FILENO);
    close(kept);
    ck_assert_int_eq(status, qc_statusOk);
    ck_assert_ptr_null(recorder);
    char text[256];
    ck_assert(ReadText("errors", text, sizeof text));
    ck_assert_str_eq(text, "quickcullide: the recording no/such/folder.1.qcr can't be created: No such file or "
                           "directory\n");
    unsetenv("QC_RECORD");
    LeaveFolder();
}
END_TEST

START_TEST(mistakes_are_refused_by_name)
{
    qcBoxRecorder* recorder = NULL;
    ck_assert_int_eq(qcBoxRecorder_Open("a.qcr", 4, NULL), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcBoxRecorder_Open: recorder is null");
    ck_assert_int_eq(qcBoxRecorder_Open("a.qcr", 5, &recorder), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcBoxRecorder_Open: scalarSize is neither 4 nor 8");
    ck_assert_int_eq(qcBoxRecorder_Open("/no/such/folder/a.qcr", 4, &recorder), qc_statusFile);
    ck_assert_ptr_null(recorder);
    CHECK_OK(qcBoxRecorder_Close(NULL));
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("box_recorder", changes_during_nested_queries_are_written_behind_the_last,
             each_failed_allocation_stops_the_recording_and_what_was_written_is_read,
             a_full_disk_is_logged_once_and_reported_at_the_end, a_broadphase_is_recorded_where_the_environment_says_so,
             without_a_log_a_failure_goes_to_standard_error, mistakes_are_refused_by_name)
