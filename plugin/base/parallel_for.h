// Loops over threads, our own (base/thread_pool.h) or the host's (qcSetParallelFor). Which thread runs what is not
// determined: callers collect by worker and sort.
#ifndef QC_BASE_PARALLEL_FOR_H
#define QC_BASE_PARALLEL_FOR_H

#include <stddef.h>
#include <stdint.h>

enum
{
    qc_maxWorkers = 256
};

/// `worker` is below the number of threads asked for, and no two calls at the same time have the same.
typedef void qcParallelFunction(void* context, size_t index, uint32_t worker);

/// The number of threads to use where `requested` are wished for: 0 means one per core. At most qc_maxWorkers, and the
/// host's workers where it gave some.
uint32_t qcParallel_Threads(uint32_t requested);

/// Calls the function once for each index below `count` and returns when all calls have. With fewer than `least`
/// indices (2 or more) on one thread alone: waking another takes 20 to 100 microseconds, in which the caller goes on.
void qcParallel_For(uint32_t threads, size_t count, size_t least, qcParallelFunction* function, void* context);

#endif
