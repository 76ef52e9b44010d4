// qcParallelFor: a caller's loops run on the threads of the library's own loops.
#include "quickcullide/base.h"

#include "support/check_ok.h"
#include "support/suite.h"

#include <stdatomic.h>
#include <stdlib.h>

enum
{
    qc_loopCount = 1000,
    qc_hostWorkers = 3
};

typedef struct Counts
{
    atomic_uint byIndex[qc_loopCount];
    atomic_flag isBusy[256];
    uint32_t workers;
    atomic_int wrong; ///< calls with a worker that is out of range or busy
} Counts;

static void CountIndex(size_t index, uint32_t worker, void* loopContext)
{
    Counts* counts = loopContext;
    if (worker >= counts->workers || atomic_flag_test_and_set(&counts->isBusy[worker]))
    {
        counts->wrong++;
        return;
    }
    counts->byIndex[index]++;
    atomic_flag_clear(&counts->isBusy[worker]);
}

/// Runs a loop on at most `workers` threads (0: all) and checks that worker numbers are below `limit`.
static void CheckLoop(uint32_t workers, size_t count, uint32_t limit)
{
    Counts* counts = calloc(1, sizeof *counts);
    ck_assert_ptr_nonnull(counts);
    counts->workers = limit;
    qcParallelFor(workers, count, CountIndex, counts);
    ck_assert_int_eq(counts->wrong, 0);
    for (size_t i = 0; i < qc_loopCount; i++)
        ck_assert_uint_eq(counts->byIndex[i], i < count ? 1 : 0);
    free(counts);
}

static void CheckLoops(void)
{
    uint32_t all = qcGetWorkerCount();
    const size_t counts[] = {0, 1, 2, qc_loopCount};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
    {
        CheckLoop(0, counts[i], all);
        CheckLoop(1, counts[i], 1);
        CheckLoop(2, counts[i], 2);
        CheckLoop(256, counts[i], 256);
    }
}

static uint32_t s_hostLoops, s_maxTasks;

static void RunOnHost(uint32_t count, qcTask* task, void* taskContext, void* context)
{
    (void)context;
    s_hostLoops++;
    s_maxTasks = count > s_maxTasks ? count : s_maxTasks;
    for (uint32_t i = 0; i < count; i++)
        task(i, taskContext);
}

START_TEST(each_index_runs_once_and_no_two_calls_at_a_time_have_one_worker)
{
    ck_assert_uint_ge(qcGetWorkerCount(), 1);
    CheckLoops();
}
END_TEST

START_TEST(a_loop_runs_on_the_host_s_threads)
{
    CHECK_OK(qcSetParallelFor(RunOnHost, qc_hostWorkers, NULL));
    ck_assert_uint_eq(qcGetWorkerCount(), qc_hostWorkers);
    CheckLoops();
    ck_assert_uint_gt(s_hostLoops, 0);
    ck_assert_uint_eq(s_maxTasks, qc_hostWorkers);
    CHECK_OK(qcSetParallelFor(NULL, 0, NULL));
}
END_TEST

QC_RUN_TESTS("caller's loops", each_index_runs_once_and_no_two_calls_at_a_time_have_one_worker,
             a_loop_runs_on_the_host_s_threads)
