// Fracture runs on the host's threads and starts none of its own; its pieces don't depend on them.
#include "quickcullide/bullet_fracture.h"
#include "quickcullide/bullet_threads.h"

#include "bullet/fracture/fracture_models.h"
#include "bullet/thread_scheduler.h"

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <thread>

// After the standard headers: check defines a macro named fail.
#include "support/check_ok.h"
#include "support/suite.h"

namespace
{
std::atomic<int> s_started{0}; ///< threads that this process has started

/// A host that runs tasks on the calling thread.
struct SequentialHost
{
    uint32_t workers;
    bool isLastOnly; ///< skips all tasks but the last one, as a host may
    int loops = 0;
    uint32_t maxTasks = 0;
};

void RunSequentially(uint32_t count, qcTask* task, void* taskContext, void* context)
{
    auto* host = static_cast<SequentialHost*>(context);
    host->loops++;
    host->maxTasks = std::max(host->maxTasks, count);
    for (uint32_t i = host->isLastOnly ? count - 1 : 0; i < count; i++)
        task(i, taskContext);
}

/// A torus in 300 cells, and a box with two sites so close to each other that its cells are cut one by one.
std::vector<qcFractureDef> Models()
{
    qcFractureDef torus = qcTorusToBreak(32, 16, 1, 0.4), box = qcBoxToBreak(1, 1, 1);
    qcScatterInside(&torus, 300, 5);
    qcScatterInside(&box, 40, 6);
    box.sites.push_back(box.sites[0] + btVector3(btScalar(1e-7), 0, 0));
    return {torus, box};
}

std::vector<qcFracture> SplitModels()
{
    std::vector<qcFracture> fractures;
    for (const qcFractureDef& def : Models())
    {
        fractures.push_back(qcFracture_Split(def));
        ck_assert_int_eq(fractures.back().status, qc_statusOk);
        ck_assert_uint_gt(fractures.back().pieces.size(), 20);
    }
    return fractures;
}

void CheckEqual(const std::vector<qcFracture>& fractures, const std::vector<qcFracture>& expected)
{
    for (size_t k = 0; k < expected.size(); k++)
    {
        ck_assert(fractures[k].volume == expected[k].volume && fractures[k].lostVolume == expected[k].lostVolume);
        ck_assert_uint_eq(fractures[k].pieces.size(), expected[k].pieces.size());
        for (size_t i = 0; i < expected[k].pieces.size(); i++)
        {
            const qcPiece &a = fractures[k].pieces[i], &b = expected[k].pieces[i];
            ck_assert(a.vertices == b.vertices && a.indices == b.indices && a.frame == b.frame);
            ck_assert(a.site == b.site && a.firstCutTriangle == b.firstCutTriangle && a.volume == b.volume);
        }
    }
}
} // namespace

/// Replaces the C library's function, counts and calls it.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument)
{
    using Create = int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
    static auto* create = reinterpret_cast<Create*>(dlsym(RTLD_NEXT, "pthread_create"));
    s_started++;
    return create(thread, attributes, run, argument);
}

START_TEST(pieces_are_the_same_on_any_number_of_threads)
{
    CHECK_OK(qcSetParallelFor(nullptr, 0, nullptr));
    const std::vector<qcFracture> expected = SplitModels();
    for (uint32_t workers : {1u, 2u, 7u, 300u})
        for (bool isLastOnly : {false, true})
        {
            SequentialHost host{workers, isLastOnly};
            CHECK_OK(qcSetParallelFor(RunSequentially, workers, &host));
            CheckEqual(SplitModels(), expected);
        }
    for (int threads : {2, 5})
    {
        qcThreadScheduler scheduler(threads);
        CHECK_OK(qcSetTaskScheduler(&scheduler));
        CheckEqual(SplitModels(), expected);
        ck_assert_int_eq(scheduler.maxIterations, threads);
        CHECK_OK(qcSetTaskScheduler(nullptr));
    }
}
END_TEST

START_TEST(fracture_calls_the_host_s_loop_and_starts_no_thread)
{
    SequentialHost host{4, false};
    CHECK_OK(qcSetParallelFor(RunSequentially, host.workers, &host));
    SplitModels();
    ck_assert_int_eq(s_started, 0);
    // Cells, each halving of them but the first, the pieces of the single cells, and the box's cells one by one.
    ck_assert_int_ge(host.loops, 8);
    ck_assert_uint_eq(host.maxTasks, host.workers);
    // A host of one worker needs no loop.
    SequentialHost alone{1, false};
    CHECK_OK(qcSetParallelFor(RunSequentially, alone.workers, &alone));
    SplitModels();
    ck_assert_int_eq(s_started, 0);
    ck_assert_int_eq(alone.loops, 0);
    CHECK_OK(qcSetParallelFor(nullptr, 0, nullptr));
}
END_TEST

START_TEST(all_threads_are_those_of_the_scheduler)
{
    qcThreadScheduler scheduler(3);
    CHECK_OK(qcSetTaskScheduler(&scheduler));
    SplitModels();
    ck_assert_int_gt(scheduler.loops, 0);
    ck_assert_int_gt(scheduler.started, 0);
    ck_assert_int_eq(s_started, scheduler.started);
    CHECK_OK(qcSetTaskScheduler(nullptr));
}
END_TEST

START_TEST(several_threads_may_break_meshes_at_once)
{
    const std::vector<qcFracture> expected = SplitModels();
    std::vector<qcFracture> found[3];
    std::vector<std::thread> threads;
    for (std::vector<qcFracture>& fractures : found)
        threads.emplace_back(
            [&fractures]
            {
                for (const qcFractureDef& def : Models())
                    fractures.push_back(qcFracture_Split(def));
            });
    for (std::thread& thread : threads)
        thread.join();
    for (const std::vector<qcFracture>& fractures : found)
        CheckEqual(fractures, expected);
}
END_TEST

QC_RUN_TESTS("fracture threads", pieces_are_the_same_on_any_number_of_threads,
             fracture_calls_the_host_s_loop_and_starts_no_thread, all_threads_are_those_of_the_scheduler,
             several_threads_may_break_meshes_at_once)
