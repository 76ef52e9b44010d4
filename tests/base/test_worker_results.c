// Results of workers: the first failure of a loop and its message come back to the thread that started it.
#include "base/parallel_for.h"
#include "base/status.h"
#include "base/worker_results.h"
#include "support/check_ok.h"
#include "support/suite.h"

#include <stdint.h>
#include <string.h>

typedef struct Worker
{
    qcWorkerResult result;
    uint64_t calls;
} Worker;

enum
{
    qc_threads = 3,
    qc_calls = 1000,
    qc_failing = 500
};

static void FailAtOne(void* context, size_t index, uint32_t worker)
{
    Worker* w = &QC_AT(Worker, *(qcArray*)context, worker);
    w->calls++;
    (void)qcWorkerResult_Add(&w->result, index == qc_failing ? qcFailMemory(123, "a test") : qc_statusOk);
}

static uint64_t CountCalls(const qcArray* workers)
{
    uint64_t calls = 0;
    for (size_t i = 0; i < workers->count; i++)
        calls += QC_AT(Worker, *workers, i).calls;
    return calls;
}

START_TEST(a_failure_comes_back_with_its_message)
{
    qcArray workers = {0};
    CHECK_OK(qcWorkerResults_Begin(&workers, qc_threads, sizeof(Worker), "workers"));
    qcParallel_For(qc_threads, qc_calls, 2, FailAtOne, &workers);
    (void)qcFail(qc_statusBadInput, "an older message of this thread");
    ck_assert_int_eq(qcWorkerResults_End(&workers, sizeof(Worker)), qc_statusOutOfMemory);
    ck_assert_str_eq(qcLastMessage(), "out of memory: 123 bytes for a test");
    ck_assert_uint_eq(CountCalls(&workers), qc_calls);
    qcArray_Free(&workers);
}
END_TEST

START_TEST(a_new_loop_begins_without_the_failures_of_the_previous_one)
{
    qcArray workers = {0};
    CHECK_OK(qcWorkerResults_Begin(&workers, qc_threads, sizeof(Worker), "workers"));
    qcParallel_For(qc_threads, qc_calls, 2, FailAtOne, &workers);
    CHECK_OK(qcWorkerResults_Begin(&workers, 1, sizeof(Worker), "workers"));
    CHECK_OK(qcWorkerResults_End(&workers, sizeof(Worker)));
    ck_assert_uint_eq(workers.count, qc_threads);
    ck_assert_uint_eq(CountCalls(&workers), qc_calls);
    qcArray_Free(&workers);
}
END_TEST

START_TEST(the_first_failure_of_a_worker_is_kept)
{
    qcWorkerResult result = {.status = qc_statusOk};
    ck_assert(qcWorkerResult_Add(&result, qc_statusOk));
    ck_assert(!qcWorkerResult_Add(&result, qcFail(qc_statusDevice, "first")));
    ck_assert(!qcWorkerResult_Add(&result, qcFail(qc_statusOutOfMemory, "second")));
    ck_assert(qcWorkerResult_Add(&result, qc_statusOk));
    ck_assert(!qcWorkerResult_IsOk(&result));
    ck_assert_int_eq(qcWorkerResult_Check(&result), qc_statusDevice);
    ck_assert_str_eq(qcLastMessage(), "first");
}
END_TEST

START_TEST(a_long_message_is_cut_off)
{
    char text[300];
    memset(text, 'x', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    qcWorkerResult result = {.status = qc_statusOk};
    (void)qcWorkerResult_Add(&result, qcFail(qc_statusDevice, "%s", text));
    ck_assert_int_eq(qcWorkerResult_Check(&result), qc_statusDevice);
    ck_assert_uint_eq(strlen(qcLastMessage()), sizeof result.message - 1);
}
END_TEST

QC_RUN_TESTS("worker results", a_failure_comes_back_with_its_message,
             a_new_loop_begins_without_the_failures_of_the_previous_one, the_first_failure_of_a_worker_is_kept,
             a_long_message_is_cut_off)
