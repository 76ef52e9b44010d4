// The library's loops on the threads of a Bullet task scheduler:
//
//     btITaskScheduler* scheduler = btCreateDefaultTaskScheduler();
//     btSetTaskScheduler(scheduler); // Bullet's loops
//     qcSetTaskScheduler(scheduler); // ours
#ifndef QUICKCULLIDE_BULLET_THREADS_H
#define QUICKCULLIDE_BULLET_THREADS_H

#include "base.h"

#include <LinearMath/btThreads.h>

/// qcSetParallelFor with the scheduler's parallelFor and as many workers as its getNumThreads says now: call this again
/// after setNumThreads. Null: the library's own threads again. The scheduler must live until the next call of this or
/// of qcSetParallelFor. One process, one scheduler: this is not part of a world.
///
/// Bullet's own thread numbers are not used, so that any scheduler will do, also one of yours in a Bullet that was
/// built without BT_THREADSAFE. Such a Bullet, Debian's for one, has no threads of its own:
/// btCreateDefaultTaskScheduler is null there, which leaves the library's own, and btGetSequentialTaskScheduler is one
/// thread.
///
/// qc_statusBadInput: the scheduler has no threads. Thread-safety: as qcSetParallelFor. Bullet's schedulers take one
/// loop at a time: scenes used on several threads at once may find themselves on one thread each.
QC_API qcStatus qcSetTaskScheduler(btITaskScheduler* scheduler);

#endif
