// Loops over threads of the host or of our own pool. Each thread gets one task, which takes indices until none is left:
// the host need not number its workers, and may run any number of its threads at any time.
#include "base/parallel_for.h"

#include "base/thread_pool.h"
#include "base/status.h"

#include <fenv.h>
#include <stdatomic.h>

typedef struct Loop
{
    qcParallelFunction* function;
    void* context;
    size_t count;
    /// The caller's floating-point environment. Threads of a host may flush subnormals, which the error bounds exclude.
    fenv_t environment;
    /// On a cache line of its own, since it is written for each index; the rest is only read.
    _Alignas(64) atomic_size_t next;
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

static void TakeIndices(Loop* loop, uint32_t worker)
{
    for (;;)
    {
        size_t i = atomic_fetch_add_explicit(&loop->next, 1, memory_order_relaxed);
        if (i >= loop->count)
            return;
        loop->function(loop->context, i, worker);
    }
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

void qcParallel_For(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function, void* context)
{
    if (threads > 1 && count >= minCount)
    {
        Loop loop = {.function = function, .context = context, .count = count};
        fegetenv(&loop.environment);
        uint32_t tasks = count < threads ? (uint32_t)count : threads;
        if (s_parallelFor != NULL)
            s_parallelFor(tasks, RunTask, &loop, s_context);
        else
            qcPool_Run(tasks, RunTask, &loop);
        TakeIndices(&loop, 0);
        return;
    }
    for (size_t i = 0; i < count; i++)
        function(context, i, 0);
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
