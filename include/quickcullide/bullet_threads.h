/// @file
/// The library's loops on the threads of a Bullet task scheduler:
///
///     btITaskScheduler* scheduler = btCreateDefaultTaskScheduler();
///     btSetTaskScheduler(scheduler); // Bullet's loops
///     qcSetTaskScheduler(scheduler); // this library's loops
#ifndef QUICKCULLIDE_BULLET_THREADS_H
#define QUICKCULLIDE_BULLET_THREADS_H

#include "base.h"

#include <LinearMath/btThreads.h>

/// Calls qcSetParallelFor with the scheduler's parallelFor and its present number of threads: call it again after
/// setNumThreads. Null restores the library's own threads. The setting holds for the whole process, not for one world.
/// The scheduler must live until the next call of this function or of qcSetParallelFor.
///
/// Any scheduler works, also one of your own in a Bullet that was built without BT_THREADSAFE, because Bullet's thread
/// numbers are not used. Such a Bullet (Debian's, for example) has no threads: btCreateDefaultTaskScheduler returns
/// null, which leaves the library's own threads, and btGetSequentialTaskScheduler has one thread.
///
/// A scheduler may have a thread that waits for a loop run other tasks. If the world's dispatcher has its pairs processed
/// by such tasks, qcMeshContact notices it: pairs that it is handed during a query are queried alone, and from the next
/// step on its loops run on the calling thread, as after setThreadCount(1). To keep them on all threads, let parallelFor
/// run tasks of its own loop alone (tbb::this_task_arena::isolate).
///
/// qc_statusBadInput: the scheduler has no threads. Thread-safety: as qcSetParallelFor. Bullet's schedulers run one
/// loop at a time: scenes used on several threads at once may run on one thread each.
QC_API qcStatus qcSetTaskScheduler(btITaskScheduler* scheduler);

#endif
