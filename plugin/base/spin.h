// Waiting for another thread without sleep, for a bounded time: waking a thread takes 20 to 100 microseconds.
#ifndef QC_BASE_SPIN_H
#define QC_BASE_SPIN_H

#include <stdbool.h>

/// Whether the wait is over.
typedef bool qcSpinTest(const void* context);

/// Lets the core's other thread run, and saves power.
static inline void qcSpin_Pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// Spins until the test is true, for `maxMs` milliseconds at most. Returns its last value.
bool qcSpin_Until(qcSpinTest* isOver, const void* context, double maxMs);
/// Like qcSpin_Until, and lets other threads of the core run every few microseconds: the one that is waited for may be
/// among them.
bool qcSpin_AndYieldUntil(qcSpinTest* isOver, const void* context, double maxMs);

#endif
