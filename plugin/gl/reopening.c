// A driver that resets again and again must not spend the host's time.
#include "gl/reopening.h"

// The longest pause, and the time after which a device counts as healthy, in first pauses.
static const double s_maxPauses = 64.0;

qcReopening qcReopening_Begin(double firstPause, double now)
{
    return (qcReopening){.firstPause = firstPause, .pause = firstPause, .opened = now};
}

void qcReopening_Fail(qcReopening* r, double now)
{
    const double max = s_maxPauses * r->firstPause;
    if (now - r->opened > max && r->due <= r->opened)
        r->pause = r->firstPause;
    r->due = now + r->pause;
    r->pause = 2.0 * r->pause < max ? 2.0 * r->pause : max;
}

void qcReopening_Succeed(qcReopening* r, double now)
{
    r->opened = now;
}

bool qcReopening_IsDue(const qcReopening* r, double now)
{
    return r->firstPause >= 0.0 && now >= r->due;
}
