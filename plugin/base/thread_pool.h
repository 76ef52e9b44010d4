// The library's own threads: started by the first loop that uses them, asleep between loops, ended with the process.
//
// Why not OpenMP: at the end of a loop libgomp waits for all threads that it woke. If one shares the caller's core, the
// wait is a time slice, 4 to 16 ms. Between loops its threads spin, on cores that software GL draws with (folded cloth
// of 250 K on llvmpipe, two cores: 39 ms a step, 32 without). Here the caller takes the indices that no thread has
// begun.
#ifndef QC_BASE_THREAD_POOL_H
#define QC_BASE_THREAD_POOL_H

#include "quickcullide/base.h"

#include <stdbool.h>

/// Calls task(index, taskContext) for index 0 on the calling thread, and for some of the indices from 1 to count - 1,
/// none twice, each on a thread of its own, the same one in every loop; returns once all these calls have returned. Any
/// thread may call it, but only one loop runs at a time: during another thread's loop it calls task(0) alone. Threads
/// start with the affinity of the thread that runs the first loop.
void qcPool_Run(uint32_t count, qcTask* task, void* taskContext);

/// Wakes the threads that sleep, before the first loop of `count` indices begins. It costs some 10 microseconds if
/// there are any.
void qcPool_Wake(uint32_t count);

/// Threads sleep at once, rather than spin for the next loop: the caller waits for something else, which needs their
/// cores.
void qcPool_Rest(void);

/// Whether threads spin for the next loop, and begin it within a microsecond. They do so for a while after each loop.
bool qcPool_IsAwake(void);

/// The number of cores that the process may run on, at least 1.
uint32_t qcPool_CoreCount(void);

#endif
