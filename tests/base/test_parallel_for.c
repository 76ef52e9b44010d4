// Loops on threads of the host: results are those of one thread, however the host runs its tasks.
#define _DEFAULT_SOURCE // usleep

#include "support/devices.h"
#include "base/parallel_for.h"
#include "support/sanitizers.h"
#include "support/scenes.h"
#include "support/suite.h"

#include <fenv.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

//  ---- hosts -------------------------------------------------------------------------------------------------------

enum
{
    qc_maxTasks = 8
};

/// One loop as passed to the host.
typedef struct Loop
{
    uint32_t count;
    qcTask* task;
    void* taskContext;
} Loop;

static void RunAscending(const Loop* loop)
{
    for (uint32_t i = 0; i < loop->count; i++)
        loop->task(i, loop->taskContext);
}

static void RunDescending(const Loop* loop)
{
    for (uint32_t i = loop->count; i-- > 0;)
        loop->task(i, loop->taskContext);
}

static void RunNone(const Loop* loop)
{
    (void)loop;
}

static void RunLast(const Loop* loop)
{
    loop->task(loop->count - 1, loop->taskContext);
}

/// A share of the tasks: every `step`-th, descending.
typedef struct Share
{
    const Loop* loop;
    uint32_t first, step;
    pthread_t thread;
} Share;

static void* RunShare(void* context)
{
    const Share* share = context;
    for (uint32_t i = share->first; i < share->loop->count; i += share->step)
        share->loop->task(share->loop->count - 1 - i, share->loop->taskContext);
    return NULL;
}

static void RunOn(const Loop* loop, uint32_t threads)
{
    Share shares[qc_maxTasks];
    for (uint32_t i = 0; i < threads; i++)
    {
        shares[i] = (Share){.loop = loop, .first = i, .step = threads};
        ck_assert_int_eq(pthread_create(&shares[i].thread, NULL, RunShare, &shares[i]), 0);
    }
    for (uint32_t i = 0; i < threads; i++)
        ck_assert_int_eq(pthread_join(shares[i].thread, NULL), 0);
}

/// A thread for each task, none of them the caller's.
static void RunThreads(const Loop* loop)
{
    RunOn(loop, loop->count);
}

/// Several tasks on one thread, and a second thread.
static void RunTwoThreads(const Loop* loop)
{
    RunOn(loop, 2);
}

/// A thread in another rounding mode, which must not affect results.
static void* RunRoundingUp(void* context)
{
    fesetround(FE_UPWARD);
    RunShare(context);
    return fegetround() == FE_UPWARD ? NULL : context;
}

static void RunThreadRoundingUp(const Loop* loop)
{
    Share share = {.loop = loop, .step = 1};
    void* changed;
    ck_assert_int_eq(pthread_create(&share.thread, NULL, RunRoundingUp, &share), 0);
    ck_assert_int_eq(pthread_join(share.thread, &changed), 0);
    ck_assert_ptr_null(changed);
}

typedef struct Host
{
    const char* name;
    void (*run)(const Loop*);
    uint32_t workers;
    _Atomic uint32_t loops;
} Host;

static Host s_hosts[] = {
    {"a thread a task", RunThreads, 3, 0},
    {"more tasks than cores", RunThreads, qc_maxTasks, 0},
    {"tasks on two threads, last ones first", RunTwoThreads, 5, 0},
    {"one after another", RunAscending, 4, 0},
    {"one after another, backwards", RunDescending, 4, 0},
    {"only the last task", RunLast, 4, 0},
    {"no task", RunNone, 2, 0},
    {"a thread that rounds up", RunThreadRoundingUp, 2, 0},
    {"one worker", RunAscending, 1, 0},
};

enum
{
    qc_hostCount = sizeof s_hosts / sizeof s_hosts[0]
};

static void RunLoop(uint32_t count, qcTask* task, void* taskContext, void* context)
{
    Host* host = context;
    // A loop of one task runs on the caller.
    if (count < 2 || count > host->workers)
        abort();
    host->run(&(Loop){count, task, taskContext});
    host->loops++;
}

static void Use(Host* host)
{
    CHECK_OK(host != NULL ? qcSetParallelFor(RunLoop, host->workers, host) : qcSetParallelFor(NULL, 0, NULL));
}

//  ---- loops -------------------------------------------------------------------------------------------------------

enum
{
    qc_loopCount = 1000
};

typedef struct Counts
{
    atomic_uint byIndex[qc_loopCount];
    atomic_flag busy[qc_maxWorkers];
    atomic_int wrong;
    uint32_t threads;
    int rounding;
} Counts;

static void CountIndex(void* context, size_t index, uint32_t worker)
{
    Counts* counts = context;
    counts->wrong += worker >= counts->threads || atomic_flag_test_and_set(&counts->busy[worker]);
    counts->wrong += fegetround() != counts->rounding;
    counts->byIndex[index]++;
    atomic_flag_clear(&counts->busy[worker]);
}

START_TEST(each_index_runs_once_and_concurrent_calls_have_different_workers)
{
    Host* host = &s_hosts[_i];
    Use(host);
    for (uint32_t requested = 0; requested <= 6; requested++)
        for (size_t count = 0; count <= qc_loopCount; count = 3 * count + 1)
        {
            static Counts counts;
            memset(&counts, 0, sizeof counts);
            counts.rounding = FE_TONEAREST;
            counts.threads = qcParallel_Threads(requested);
            ck_assert_uint_eq(counts.threads, requested == 0 || requested > host->workers ? host->workers : requested);
            qcParallel_For(counts.threads, count, 2, CountIndex, &counts);
            ck_assert_int_eq(counts.wrong, 0);
            for (size_t i = 0; i < qc_loopCount; i++)
                ck_assert_msg(counts.byIndex[i] == (i < count), "%s: index %zu of %zu ran %u times", host->name, i,
                              count, counts.byIndex[i]);
        }
    ck_assert_int_eq(host->loops != 0, host->workers > 1);
}
END_TEST

START_TEST(tasks_run_in_the_rounding_mode_of_the_caller)
{
    static Counts counts = {.rounding = FE_DOWNWARD};
    Use(&s_hosts[_i]);
    counts.threads = qcParallel_Threads(0);
    fesetround(FE_DOWNWARD);
    qcParallel_For(counts.threads, qc_loopCount, 2, CountIndex, &counts);
    int after = fegetround();
    fesetround(FE_TONEAREST);
    ck_assert_int_eq(after, FE_DOWNWARD);
    ck_assert_int_eq(counts.wrong, 0);
}
END_TEST

//  ---- parts -------------------------------------------------------------------------------------------------------

typedef void Loops(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function, void* context);

static Loops* const s_loops[] = {qcParallel_For, qcParallel_ForLargestFirst};

START_TEST(each_index_runs_once_on_the_librarys_own_threads)
{
    Use(NULL);
    for (uint32_t threads = 1; threads <= 6; threads++)
        for (size_t count = 0; count <= qc_loopCount; count = 3 * count + 1)
        {
            static Counts counts;
            memset(&counts, 0, sizeof counts);
            counts.rounding = FE_TONEAREST;
            counts.threads = threads;
            qcParallel_Wake(threads);
            s_loops[_i](threads, count, 2, CountIndex, &counts);
            ck_assert_int_eq(counts.wrong, 0);
            for (size_t i = 0; i < qc_loopCount; i++)
                ck_assert_uint_eq(counts.byIndex[i], i < count);
        }
}
END_TEST

enum
{
    qc_partWorkers = 4
};

/// What each worker has run.
typedef struct Ranges
{
    size_t first[qc_partWorkers];
    atomic_size_t count[qc_partWorkers];
} Ranges;

static void RecordIndex(void* context, size_t index, uint32_t worker)
{
    Ranges* ranges = context;
    if (ranges->count[worker]++ == 0)
        ranges->first[worker] = index;
}

/// Runs the last task alone.
static void RunLastTask(uint32_t count, qcTask* task, void* taskContext, void* context)
{
    (void)context;
    task(count - 1, taskContext);
}

START_TEST(a_worker_begins_with_its_own_part_and_takes_those_of_others_when_it_is_done)
{
    static Ranges ranges;
    CHECK_OK(qcSetParallelFor(RunLastTask, qc_partWorkers, NULL));
    qcParallel_For(qc_partWorkers, qc_loopCount, 2, RecordIndex, &ranges);
    ck_assert_uint_eq(ranges.count[qc_partWorkers - 1], qc_loopCount);
    ck_assert_uint_eq(ranges.first[qc_partWorkers - 1], qc_loopCount * (qc_partWorkers - 1) / qc_partWorkers);
}
END_TEST

START_TEST(the_largest_come_first_if_one_worker_takes_all)
{
    static Ranges ranges;
    CHECK_OK(qcSetParallelFor(RunLastTask, qc_partWorkers, NULL));
    qcParallel_ForLargestFirst(qc_partWorkers, qc_loopCount, 2, RecordIndex, &ranges);
    ck_assert_uint_eq(ranges.count[qc_partWorkers - 1], qc_loopCount);
    ck_assert_uint_eq(ranges.first[qc_partWorkers - 1], 0);
}
END_TEST

static void Wait(void* context, size_t index, uint32_t worker)
{
    (void)worker;
    Ranges* ranges = context;
    // The first index of worker 0 lasts until all others have run: the rest of its part is stolen.
    if (index == 0)
        while (ranges->count[1] < qc_loopCount - 1)
            usleep(100);
    else
        ranges->count[1]++;
}

START_TEST(indices_behind_a_long_one_are_stolen)
{
    static Ranges ranges;
    Use(NULL);
    qcParallel_For(2, qc_loopCount, 2, Wait, &ranges);
    ck_assert_uint_eq(ranges.count[1], qc_loopCount - 1);
}
END_TEST

START_TEST(threads_that_sleep_are_woken_by_the_next_loop)
{
    static Ranges ranges;
    Use(NULL);
    for (int i = 0; i < 3; i++)
    {
        ranges.count[1] = 0;
        qcParallel_For(2, qc_loopCount, 2, Wait, &ranges);
        ck_assert_uint_eq(ranges.count[1], qc_loopCount - 1);
        usleep(5000);
        if (i == 1)
            qcParallel_Wake(2);
    }
}
END_TEST

static void SpendTime(void* context, size_t index, uint32_t worker)
{
    (void)context, (void)index, (void)worker;
    usleep(100);
}

/// Milliseconds that the cores have spent on the process.
static double ProcessorMs(void)
{
    struct timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

START_TEST(more_threads_than_cores_sleep_when_no_loop_runs)
{
    Use(NULL);
    for (uint32_t threads = 4; threads <= 64; threads *= 4)
        for (bool called = false;; called = true)
        {
            for (int i = 0; i < 10; i++)
                qcParallel_For(threads, 2 * threads, 1, SpendTime, NULL);
            if (called)
                qcParallel_Wake(threads);
            // Threads spin for a while.
            usleep(100000);
            double begin = ProcessorMs();
            usleep(200000);
            ck_assert_double_lt(ProcessorMs() - begin, 40.0);
            if (called)
                break;
        }
}
END_TEST

START_TEST(threads_that_rest_run_the_next_loop)
{
    static Ranges ranges;
    Use(NULL);
    for (int i = 0; i < 100; i++)
    {
        ranges.count[1] = 0;
        qcParallel_For(2, qc_loopCount, 2, Wait, &ranges);
        ck_assert_uint_eq(ranges.count[1], qc_loopCount - 1);
        qcParallel_Rest();
        if (i % 4 == 0)
            qcParallel_Wake(2);
        if (i % 3 == 0)
            usleep((useconds_t)i * 10);
    }
}
END_TEST

//  ---- scenes ------------------------------------------------------------------------------------------------------

static uint64_t Hash(uint64_t hash, const void* data, size_t size)
{
    const unsigned char* bytes = data;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3ULL; // FNV-1a
    return hash;
}

/// The hash of the counts and of all arrays, whose elements have no padding.
static uint64_t HashOf(const qcResult* r)
{
    const size_t counts[] = {r->pairCount,     r->pcsCount,           r->contactCount,
                             r->manifoldCount, r->manifoldPointCount, (size_t)r->profile.candidates};
    uint64_t hash = Hash(0xcbf29ce484222325ULL, counts, sizeof counts);
    hash = Hash(hash, r->pairs, r->pairCount * sizeof *r->pairs);
    hash = Hash(hash, r->segments, r->segments != NULL ? r->pairCount * sizeof *r->segments : 0);
    hash = Hash(hash, r->proximities, r->proximities != NULL ? r->pairCount * sizeof *r->proximities : 0);
    hash = Hash(hash, r->pcs, r->pcsCount * sizeof *r->pcs);
    hash = Hash(hash, r->contacts, r->contactCount * sizeof *r->contacts);
    hash = Hash(hash, r->manifolds, r->manifoldCount * sizeof *r->manifolds);
    return Hash(hash, r->manifoldPoints, r->manifoldPointCount * sizeof *r->manifoldPoints);
}

/// A self-colliding cloth and a sphere, large enough for loops to use threads.
typedef struct World
{
    qcScene* scene;
    qcBodyId cloth;
} World;

static qcSoup MakeCloth(uint64_t seed)
{
    return qcSoup_MakeFoldedCloth(seed, 130, 0.02, 0.011);
}

static World MakeWorld(qcDevice* device)
{
    World world = {.scene = qcMakeScene(device)};
    qcSoup sphere = qcSoup_MakeSphere(3, 0.4), cloth = MakeCloth(0);
    qcBodyDef def = qcBodyDefOf(&cloth);
    def.deforming = true;
    CHECK_OK(qcScene_AddBody(world.scene, &def, &world.cloth));
    qcAddSoup(world.scene, &sphere);
    qcSoup_Free(&sphere);
    qcSoup_Free(&cloth);
    return world;
}

typedef struct Question
{
    const char* name;
    qcMethod method;
    double margin, contactMargin;
    bool rest;      ///< also segments, proximities and manifolds
    uint32_t loops; ///< min number of loops on threads, in each step after the first
} Question;

static const Question s_questions[] = {
    {"sweep", qc_methodSweep, 0.0, 0.0, false, 4},    {"segments, manifolds", qc_methodSweep, 0.0, 0.0, true, 8},
    {"margin", qc_methodSweep, 0.001, 0.0, false, 4}, {"contacts", qc_methodSweep, 0.0, 0.002, false, 4},
    {"layers", qc_methodLayers, 0.0, 0.0, false, 2},
};

enum
{
    qc_questionCount = sizeof s_questions / sizeof s_questions[0]
};

static qcDetectDef DefOf(const Question* question, uint32_t threads)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = question->method;
    def.margin = question->margin;
    def.contactMargin = question->contactMargin;
    def.segments = def.proximities = def.manifolds = question->rest;
    def.threads = threads;
    return def;
}

/// Sets new vertices and detects.
static uint64_t Step(World* world, uint64_t seed, const Question* question, uint32_t threads)
{
    qcSoup cloth = MakeCloth(seed);
    CHECK_OK(qcScene_SetVertices(world->scene, world->cloth, cloth.positions, qc_positionF64, 0));
    qcSoup_Free(&cloth);
    qcDetectDef def = DefOf(question, threads);
    const qcResult* result = NULL;
    CHECK_OK(qcScene_Detect(world->scene, &def, &result));
    ck_assert_int_eq(result->profile.method, question->method);
    ck_assert_uint_gt(result->pairCount, 1000);
    ck_assert_int_eq(result->manifoldPointCount > 100, question->rest);
    ck_assert_int_eq(result->contactCount > 1000, question->contactMargin > 0.0);
    return HashOf(result);
}

/// Compares a scene whose steps run on changing hosts, and on the library's own threads, with a scene on one thread.
static void CheckQuestion(qcDevice* device, const Question* question)
{
    World world = MakeWorld(device), serial = MakeWorld(device);
    for (int step = 0; step < qc_hostCount + 2; step++)
    {
        uint64_t expected = Step(&serial, (uint64_t)step, question, 1);
        Host* host = step <= qc_hostCount ? &s_hosts[step % qc_hostCount] : NULL;
        uint32_t loops = host != NULL ? host->loops : 0;
        Use(host);
        ck_assert_msg(Step(&world, (uint64_t)step, question, host != NULL ? 0 : 3) == expected, "%s: %s",
                      question->name, host != NULL ? host->name : "none");
        if (step != 0 && host != NULL && host->workers > 1)
            ck_assert_msg(host->loops - loops >= question->loops, "%s: %s: %u loops", question->name, host->name,
                          host->loops - loops);
    }
    qcScene_Destroy(world.scene);
    qcScene_Destroy(serial.scene);
}

START_TEST(hosts_that_change_step_by_step_give_the_results_of_one_thread)
{
    const Question* question = &s_questions[_i];
    if (question->method != qc_methodLayers)
        CheckQuestion(NULL, question);
    else
        QC_FOR_EACH_DEVICE(device)
        {
            qcDeviceInfo info;
            CHECK_OK(qcDevice_GetInfo(device, &info));
            if (info.compute)
                CheckQuestion(device, question);
        }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

typedef struct User
{
    pthread_t thread;
    uint64_t hashes[3];
} User;

static void StepOften(User* user, uint32_t threads)
{
    World world = MakeWorld(NULL);
    for (uint64_t step = 0; step < 3; step++)
        user->hashes[step] = Step(&world, step, &s_questions[0], threads);
    qcScene_Destroy(world.scene);
}

static void* StepOnHost(void* user)
{
    StepOften(user, 0);
    return NULL;
}

static void* StepOnOwnThreads(void* user)
{
    StepOften(user, 3);
    return NULL;
}

START_TEST(scenes_on_two_threads_share_a_host)
{
    User one, users[2];
    StepOften(&one, 1);
    Use(&s_hosts[0]);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(pthread_create(&users[i].thread, NULL, StepOnHost, &users[i]), 0);
    for (int i = 0; i < 2; i++)
    {
        ck_assert_int_eq(pthread_join(users[i].thread, NULL), 0);
        ck_assert_mem_eq(users[i].hashes, one.hashes, sizeof one.hashes);
    }
    ck_assert_uint_gt(s_hosts[0].loops, 0);
}
END_TEST

START_TEST(scenes_on_two_threads_share_the_librarys_own_threads)
{
    User one, users[2];
    StepOften(&one, 1);
    for (int i = 0; i < 2; i++)
        ck_assert_int_eq(pthread_create(&users[i].thread, NULL, StepOnOwnThreads, &users[i]), 0);
    for (int i = 0; i < 2; i++)
    {
        ck_assert_int_eq(pthread_join(users[i].thread, NULL), 0);
        ck_assert_mem_eq(users[i].hashes, one.hashes, sizeof one.hashes);
    }
}
END_TEST

START_TEST(a_child_process_starts_its_own_threads)
{
    if (!qcChildrenCanStartThreads())
        return;
    User parent, child;
    StepOften(&parent, 3);
    pid_t pid = fork();
    ck_assert_int_ge(pid, 0);
    if (pid == 0)
    {
        StepOften(&child, 3);
        // The threads of the library end in exit().
        exit(memcmp(child.hashes, parent.hashes, sizeof child.hashes) == 0 ? 0 : 1);
    }
    int status = 0;
    ck_assert_int_eq(waitpid(pid, &status, 0), pid);
    ck_assert(WIFEXITED(status) && WEXITSTATUS(status) == 0);
    StepOften(&child, 3);
    ck_assert_mem_eq(child.hashes, parent.hashes, sizeof child.hashes);
}
END_TEST

//  ---- bad input ----------------------------------------------------------------------------------------------------

START_TEST(a_host_without_workers_is_rejected_and_the_previous_one_stays)
{
    Host* host = &s_hosts[3];
    Use(host);
    ck_assert_int_eq(qcSetParallelFor(RunLoop, 0, &s_hosts[4]), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcSetParallelFor: parallelFor is given, but workers is 0");
    ck_assert_uint_eq(qcParallel_Threads(0), host->workers);
    static Counts counts = {.rounding = FE_TONEAREST};
    counts.threads = host->workers;
    qcParallel_For(host->workers, qc_loopCount, 2, CountIndex, &counts);
    ck_assert_uint_eq(host->loops, 1);
}
END_TEST

START_TEST(the_count_of_workers_is_limited_to_the_maximum)
{
    CHECK_OK(qcSetParallelFor(RunLoop, UINT32_MAX, &s_hosts[3]));
    ck_assert_uint_eq(qcParallel_Threads(0), qc_maxWorkers);
    ck_assert_uint_eq(qcParallel_Threads(UINT32_MAX), qc_maxWorkers);
    ck_assert_uint_eq(qcParallel_Threads(7), 7);
}
END_TEST

int main(void)
{
    TCase* tests = qcMakeCase("tasks");
    tcase_add_loop_test(tests, each_index_runs_once_and_concurrent_calls_have_different_workers, 0, qc_hostCount);
    tcase_add_loop_test(tests, tasks_run_in_the_rounding_mode_of_the_caller, 0, qc_hostCount);
    tcase_add_loop_test(tests, each_index_runs_once_on_the_librarys_own_threads, 0, 2);
    tcase_add_test(tests, a_worker_begins_with_its_own_part_and_takes_those_of_others_when_it_is_done);
    tcase_add_test(tests, the_largest_come_first_if_one_worker_takes_all);
    tcase_add_test(tests, indices_behind_a_long_one_are_stolen);
    tcase_add_test(tests, threads_that_sleep_are_woken_by_the_next_loop);
    tcase_add_test(tests, more_threads_than_cores_sleep_when_no_loop_runs);
    tcase_add_test(tests, threads_that_rest_run_the_next_loop);
    tcase_add_loop_test(tests, hosts_that_change_step_by_step_give_the_results_of_one_thread, 0, qc_questionCount);
    tcase_add_test(tests, scenes_on_two_threads_share_a_host);
    tcase_add_test(tests, scenes_on_two_threads_share_the_librarys_own_threads);
    tcase_add_test(tests, a_child_process_starts_its_own_threads);
    tcase_add_test(tests, a_host_without_workers_is_rejected_and_the_previous_one_stays);
    tcase_add_test(tests, the_count_of_workers_is_limited_to_the_maximum);
    return qcRunCase("tasks", tests);
}
