// Loops over threads. Which thread runs what is not determined: callers collect by worker and sort.
#ifndef QC_PLUGIN_PARALLEL_H
#define QC_PLUGIN_PARALLEL_H

#include <stddef.h>
#include <stdint.h>

enum
{
    qc_maxWorkers = 256
};

/// `worker` is below the number of threads asked for, and no two calls at the same time have the same.
typedef void qcParallelFunction(void* context, size_t index, uint32_t worker);

/// The number of threads to use where `requested` are wished for: 0 means one per core; at most qc_maxWorkers.
uint32_t qcParallel_Threads(uint32_t requested);

/// Calls the function once for each index below `count` and returns when all calls have. With fewer than `least`
/// indices (2 or more) on one thread alone: waking another and waiting for it costs some 10 microseconds, and on a busy
/// machine milliseconds.
void qcParallel_For(uint32_t threads, size_t count, size_t least, qcParallelFunction* function, void* context);

/// Lets go of the threads of loops before. OpenMP's wait for the next loop by spinning, some milliseconds long (libgomp;
/// folded cloth of 250 K on llvmpipe with two cores: 39 ms a step, 32 without them). The next loop starts new ones, in
/// some 50 microseconds.
void qcParallel_Rest(void);

#endif
