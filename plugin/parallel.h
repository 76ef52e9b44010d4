// Loops over threads, those of OpenMP or of the host (qcSetParallelFor). Which thread runs what is not determined:
// callers collect by worker and sort.
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

/// The number of threads to use where `requested` are wished for: 0 means one per core. At most qc_maxWorkers, and the
/// host's workers where it gave some.
uint32_t qcParallel_Threads(uint32_t requested);

/// Calls the function once for each index below `count` and returns when all calls have. With fewer than `least`
/// indices (2 or more) on one thread alone. What a loop costs beyond its work (OpenMP of gcc 12, two cores): 1 to 4
/// microseconds while its threads still wait, 100 when they have gone to sleep, 4 to 16 milliseconds, a time slice,
/// when the system wakes one on the caller's core: after a sleep of the caller's, or on a busy machine.
void qcParallel_For(uint32_t threads, size_t count, size_t least, qcParallelFunction* function, void* context);

/// Lets go of OpenMP's threads of loops before, which wait for the next loop by spinning, some milliseconds long
/// (libgomp; folded cloth of 250 K on llvmpipe with two cores: 39 ms a step, 32 without them). The next loop starts new
/// ones, in some 50 microseconds.
void qcParallel_Rest(void);

#endif
