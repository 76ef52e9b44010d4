// Loops over threads, our own (base/thread_pool.h) or the host's (qcSetParallelFor). Which thread runs an index is not
// determined: callers collect results by worker (base/worker_results.h) and sort them.
#ifndef QC_BASE_PARALLEL_FOR_H
#define QC_BASE_PARALLEL_FOR_H

#include <stddef.h>
#include <stdint.h>

enum
{
    qc_maxWorkers = 256
};

/// `worker` is below the number of threads; two calls at the same time never have the same worker.
typedef void qcParallelFunction(void* context, size_t index, uint32_t worker);

/// The number of threads to use when `requested` are given (0: one per core): at most qc_maxWorkers, and at most the
/// workers of the host's qcSetParallelFor.
uint32_t qcParallel_Threads(uint32_t requested);

/// Wakes our own threads, if they sleep, before a step whose first loops are too short to do so.
void qcParallel_Wake(uint32_t threads);
/// Our own threads sleep until the next loop, or until they are woken: see qcPool_Rest.
void qcParallel_Rest(void);

/// Calls the function once for each index below `count`; returns once all calls have returned. `minCount` indices (2 or
/// more) take as long as waking a thread, 20 to 100 microseconds: fewer run on the calling thread alone. While our own
/// threads are awake, that is in the loops of a step after the first, an eighth of it is enough.
///
/// Worker w begins with the w-th of equal parts of the indices, in ascending order. Loops over the same data should
/// number it in the same order: each core then finds its part in its caches.
void qcParallel_For(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function, void* context);

/// Like qcParallel_For, but each worker takes the next index: for few indices of unequal work, the largest first.
void qcParallel_ForLargestFirst(uint32_t threads, size_t count, size_t minCount, qcParallelFunction* function,
                                void* context);

#endif
