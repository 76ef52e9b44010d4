// The library's own threads are woken on other cores than the caller's, within what the host allows them.
#define _GNU_SOURCE // sched_getaffinity, usleep

#include "base/parallel_for.h"
#include "base/thread_pool.h"
#include "support/suite.h"

#include <sched.h>
#include <stdatomic.h>
#include <unistd.h>

enum
{
    qc_workers = 2
};

static cpu_set_t OneCore(int core)
{
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)core, &set);
    return set;
}

/// The cores that the calling thread may run on.
static cpu_set_t PresentCores(void)
{
    cpu_set_t set;
    ck_assert_int_eq(sched_getaffinity(0, sizeof set, &set), 0);
    return set;
}

static void AllowCores(const cpu_set_t* set)
{
    ck_assert_int_eq(sched_setaffinity(0, sizeof *set, set), 0);
}

/// The first and the second core of the set; -1 where there is none.
static void FindTwoCores(const cpu_set_t* set, int cores[2])
{
    cores[0] = cores[1] = -1;
    for (int core = CPU_SETSIZE; core-- > 0;)
        if (CPU_ISSET((size_t)core, set))
        {
            cores[1] = cores[0];
            cores[0] = core;
        }
}

/// What one loop does on the library's thread.
typedef struct Visit
{
    const cpu_set_t* allow; ///< set by the thread itself, as a host may do; null: none
    cpu_set_t cores;        ///< of the thread, when it began
    atomic_bool done;
} Visit;

static void VisitThread(void* context, size_t index, uint32_t worker)
{
    Visit* visit = context;
    if (index == 0 && worker == 0)
        while (!visit->done)
            usleep(100);
    if (worker == 0 || visit->done)
        return;
    visit->cores = PresentCores();
    if (visit->allow != NULL)
        AllowCores(visit->allow);
    visit->done = true;
}

/// Runs a loop on the calling thread and on one of the library's, which slept. Returns that thread's cores.
static cpu_set_t CoresOfThread(const cpu_set_t* allow)
{
    Visit visit = {.allow = allow};
    while (qcPool_IsAwake())
        usleep(100);
    // It falls asleep a moment after it counts as asleep.
    usleep(1000);
    qcParallel_For(qc_workers, qc_workers, 2, VisitThread, &visit);
    return visit.cores;
}

START_TEST(a_woken_thread_has_all_cores_but_the_caller_s)
{
    const cpu_set_t all = PresentCores();
    int cores[2];
    FindTwoCores(&all, cores);
    // The threads start with the cores of the thread that first needs them.
    (void)CoresOfThread(NULL);
    for (int i = 0; i < 4 && cores[1] >= 0; i++)
    {
        const cpu_set_t caller = OneCore(cores[i % 2]);
        AllowCores(&caller);
        cpu_set_t expected = all, found = CoresOfThread(NULL);
        CPU_CLR((size_t)cores[i % 2], &expected);
        ck_assert_msg(CPU_EQUAL(&found, &expected), "a caller on core %d", cores[i % 2]);
        AllowCores(&all);
    }
}
END_TEST

START_TEST(cores_that_the_host_takes_away_are_not_used_again)
{
    const cpu_set_t all = PresentCores();
    int cores[2];
    FindTwoCores(&all, cores);
    if (cores[1] < 0)
        return;
    const cpu_set_t first = OneCore(cores[0]), second = OneCore(cores[1]);
    AllowCores(&first);
    (void)CoresOfThread(&second);
    AllowCores(&second);
    // Its only core is the caller's.
    cpu_set_t found = CoresOfThread(&all);
    ck_assert(CPU_EQUAL(&found, &second));
    AllowCores(&first);
    cpu_set_t expected = all;
    CPU_CLR((size_t)cores[0], &expected);
    found = CoresOfThread(NULL);
    ck_assert(CPU_EQUAL(&found, &expected));
}
END_TEST

START_TEST(on_one_core_threads_share_it_with_the_caller)
{
    const cpu_set_t all = PresentCores();
    int cores[2];
    FindTwoCores(&all, cores);
    const cpu_set_t one = OneCore(cores[0]);
    AllowCores(&one);
    ck_assert_uint_eq(qcPool_CoreCount(), 1);
    for (int i = 0; i < 3; i++)
    {
        cpu_set_t found = CoresOfThread(NULL);
        ck_assert(CPU_EQUAL(&found, &one));
    }
}
END_TEST

QC_RUN_TESTS("affinity", a_woken_thread_has_all_cores_but_the_caller_s,
             cores_that_the_host_takes_away_are_not_used_again, on_one_core_threads_share_it_with_the_caller)
