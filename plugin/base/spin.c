// Loops of tests; the clock is read now and then.
#include "base/spin.h"

#include "base/clock.h"

#include <sched.h>

enum
{
    qc_spinsPerClockRead = 64,
    // Eight pauses take 0.2 to 0.5 microseconds, like a yield where no other thread is ready.
    qc_spinsPerYield = 8
};

static bool Spin(qcSpinTest* isOver, const void* context, double maxMs, bool yields)
{
    double start = qcClock_Now();
    do
        for (int i = 0; i < qc_spinsPerClockRead; i++)
        {
            if (isOver(context))
                return true;
            qcSpin_Pause();
            if (yields && i % qc_spinsPerYield == qc_spinsPerYield - 1)
                sched_yield();
        }
    while (qcClock_Now() - start < maxMs);
    return false;
}

bool qcSpin_Until(qcSpinTest* isOver, const void* context, double maxMs)
{
    return Spin(isOver, context, maxMs, false);
}

bool qcSpin_AndYieldUntil(qcSpinTest* isOver, const void* context, double maxMs)
{
    return Spin(isOver, context, maxMs, true);
}
