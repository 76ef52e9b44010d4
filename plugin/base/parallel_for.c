// Loops over threads of the host or of our own pool. Each thread gets one task: the host need not number its workers,
// and may run any number of its threads at any time.
//
// Worker w begins with the w-th part of the indices: what it wrote in one loop it finds in its own core's caches in the
// next loop, and in the next step (cloth of 20 K triangles, two cores: 0.43 ms a step, 0.72 if each takes the next free
// index). A worker without indices steals half of another one's: Blumofe, Leiserson: Scheduling Multithreaded
// Computations by Work Stealing, 1999.
#include "base/parallel_for.h"

#include "base/thread_pool.h"
#include "base/status.h"

#include <fenv.h>
#include <stdatomic.h>
#include <stdbool.h>

enum
{
    // The hand-over to threads that are awake takes so many times less than waking them.
    qc_hotFactor = 8
};

/// Indices of a worker that have not begun: `next` from bit 32, `end` below it. On a cache line of its own, since it is
/// written for each index.
typedef struct Part
{
    _Alignas(64) _Atomic uint64_t range;
} Part;

typedef struct Loop
{
    qcParallelFunction* function;
    void* context;
    size_t first; ///< index 0 of the parts
    uint32_t partCount;
    /// The caller's floating-point environment. Threads of a host may flush subnormals, which the error bounds exclude.
    fenv_t environment;
    Part parts[qc_maxWorkers];
} Loop;

static qcParallelForFunction* s_parallelFor;
static uint32_t s_workers;
static void* s_context;

qcStatus qcSetParallelFor(qcParallelForFunction* parallelFor, uint32_t workers, void* context)
{
    if (parallelFor != NULL && workers == 0)
        return qcFail(qc_statusBadInput, "qcSetParallelFor: parallelFor is given, but workers is 0");
    s_parallelFor = parallelFor;
    s_workers = workers;
    s_context = context;
    return qc_statusOk;
}

uint32_t qcParallel_Threads(uint32_t requested)
{
    uint32_t threads = requested;
    if (s_parallelFor != NULL && (requested == 0 || requested > s_workers))
        threads = s_workers;
    if (threads == 0)
        threads = qcPool_CoreCount();
    return threads < qc_maxWorkers ? threads : qc_maxWorkers;
}

static uint64_t MakeRange(uint64_t next, uint64_t end)
{
    return next << 32 | end;
}

static uint32_t NextOf(uint64_t range)
{
    return (uint32_t)(range >> 32);
}

static uint32_t EndOf(uint64_t range)
{
    return (uint32_t)range;
}

/// Takes the next index of a part. False: none is left.
static bool TakeIndex(Part* part, uint32_t* index)
{
    uint64_t range = atomic_load(&part->range);
    do
    {
        *index = NextOf(range);
        if (*index >= EndOf(range))
            return false;
    } while (!atomic_compare_exchange_weak(&part->range, &range, MakeRange(*index + 1, EndOf(range))));
    return true;
}

/// Moves the upper half of another part, at least one index, to the worker's own, which is empty. No thread changes an
/// empty part but its own worker.
static bool StealFrom(Part* other, Part* own)
{
    uint64_t range = atomic_load(&other->range);
    uint32_t next, end, middle;
    do
    {
        next = NextOf(range);
        end = EndOf(range);
        if (next >= end)
            return false;
        middle = next + (end - next) / 2;
    } while (!atomic_compare_exchange_weak(&other->range, &range, MakeRange(next, middle)));
    atomic_store(&own->range, MakeRange(middle, end));
    return true;
}

static bool Steal(Loop* loop, uint32_t worker)
{
    for (uint32_t k = 1; k < loop->partCount; k++)
        if (StealFrom(&loop->parts[(worker + k) % loop->partCount], &loop->parts[worker]))
            return true;
    return false;
}

static void TakeIndices(Loop* loop, uint32_t worker)
{
    uint32_t index;
    do
        while (TakeIndex(&loop->parts[worker % loop->partCount], &index))
            loop->function(loop->context, loop->first + index, worker);
    while (Steal(loop, worker));
}

static void RunTask(uint32_t index, void* taskContext)
{
    Loop* loop = taskContext;
    fenv_t own;
    fegetenv(&own);
    fesetenv(&loop->environment);
    TakeIndices(loop, index);
    fesetenv(&own);
}

/// Runs `count` indices from loop->first on, 2^32 - 1 at most: of a part for each task, or of one part.
static void RunParts(Loop* loop, uint32_t threads, size_t count, bool dealt)
{
    uint32_t tasks = count < threads ? (uint32_t)count : threads;
    loop->partCount = dealt ? tasks : 1;
    for (uint64_t k = 0; k < loop->partCount; k++)
        atomic_init(&loop->parts[k].range, MakeRange(k * count / loop->partCount, (k + 1) * count / loop->partCount));
    if (s_parallelFor != NULL)
        s_parallelFor(tasks, RunTask, loop, s_context);
    else
        qcPool_Run(tasks, RunTask, loop);
    TakeIndices(loop, 0);
}

/// Whether the loop takes longer than its hand-over to threads.
static bool IsWorthThreads(uint32_t threads, size_t count, size_t minCount)
{
    if (threads < 2 || count < 2)
        return false;
    return count >= minCount || (s_parallelFor == NULL && count >= minCount / qc_hotFactor && qcPool_IsAwake());
}

/// All indices; `loop` has the function and its context.
static void Run(Loop* loop, uint32_t threads, size_t count, size_t minCount, bool dealt)
{
    if (!IsWorthThreads(threads, count, minCount))
    {
        for (size_t i = 0; i < count; i++)
            loop->function(loop->context, i, 0);
        return;
    }
    fegetenv(&loop->environment);
    for (loop->first = 0; loop->first < count; loop->first += UINT32_MAX)
        RunParts(loop, threads, count - loop->first < UINT32_MAX ? count - loop->first : UINT32_MAX, dealt);
}

void qcParallel_For(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function, void* context)
{
    Loop loop;
    loop.function = function;
    loop.context = context;
    Run(&loop, threads, count, minCount, true);
}

void qcParallel_ForLargestFirst(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function,
                                void* context)
{
    Loop loop;
    loop.function = function;
    loop.context = context;
    Run(&loop, threads, count, minCount, false);
}

void qcParallel_Wake(uint32_t threads)
{
    if (threads > 1 && s_parallelFor == NULL)
        qcPool_Wake(threads);
}

void qcParallel_Rest(void)
{
    qcPool_Rest();
}

typedef struct PublicLoop
{
    qcLoopFunction* function;
    void* context;
} PublicLoop;

static void RunPublicLoop(void* context, size_t index, uint32_t worker)
{
    const PublicLoop* loop = context;
    loop->function(index, worker, loop->context);
}

uint32_t qcGetWorkerCount(void)
{
    return qcParallel_Threads(0);
}

void qcParallelFor(uint32_t workers, size_t count, qcLoopFunction* function, void* loopContext)
{
    PublicLoop loop = {.function = function, .context = loopContext};
    qcParallel_For(qcParallel_Threads(workers), count, 2, RunPublicLoop, &loop);
}
