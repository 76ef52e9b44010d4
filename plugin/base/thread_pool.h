// The library's own threads: started when a loop first wants them, asleep between loops, gone at the end of the
// process.
//
// Why not OpenMP's: at the end of a loop libgomp waits for all threads that it woke, and when the system has put one on
// the caller's core, that is a time slice, 4 to 16 ms, on a busy machine; between loops its threads spin, on cores that
// software GL draws with (folded cloth of 250 K on llvmpipe with two cores: 39 ms a step, 32 without them). Here the
// caller does what threads haven't begun, and waits for those alone that have.
#ifndef QC_BASE_THREAD_POOL_H
#define QC_BASE_THREAD_POOL_H

#include "quickcullide/base.h"

/// Calls task(index, taskContext) for some of the indices from 1 to count - 1, none twice, each on a thread of its own,
/// and for index 0 on the calling one; returns when those calls have. One loop at a time: while another thread's runs,
/// task(0) is all there is.
void qcPool_Run(uint32_t count, qcTask* task, void* taskContext);

/// Cores that the process may run on.
uint32_t qcPool_CoreCount(void);

#endif
