// Timestamps in two alternating sets, so that reading one never waits for the device.
#include "gl/timers.h"

#include "base/clock.h"

#include <assert.h>

static void Add(double* ms, double more)
{
    *ms = *ms < 0.0 ? more : *ms + more;
}

static qcGlTimestamps* Current(qcGlTimers* timers)
{
    return &timers->sets[timers->jobs % 2];
}

static void Create(const struct qcGlFunctions* gl, qcGlTimers* timers)
{
    GLint bits = 0;
    gl->GetQueryiv(GL_TIMESTAMP, GL_QUERY_COUNTER_BITS, &bits);
    timers->hasClock = bits > 0;
    timers->created = true;
    for (int i = 0; i < 2; i++)
        gl->GenQueries(qc_maxTimestamps, timers->sets[i].queries);
}

static void Stamp(const struct qcGlFunctions* gl, qcGlTimers* timers, int part)
{
    qcGlTimestamps* set = Current(timers);
    if (!timers->hasClock || set->count == qc_maxTimestamps)
        return;
    set->parts[set->count] = part;
    gl->QueryCounter(set->queries[set->count++], GL_TIMESTAMP);
}

void qcGlTimers_Begin(const struct qcGlFunctions* gl, qcGlTimers* timers, bool on, double start, int part)
{
    timers->on = on;
    if (!on)
        return;
    if (!timers->created)
        Create(gl, timers);
    timers->jobs++;
    qcGlTimestamps* set = Current(timers);
    set->count = set->passed = set->read = 0;
    for (int i = 0; i < qc_maxTimedParts; i++)
        timers->threadMs[i] = timers->deviceMs[i] = -1.0;
    timers->clock = qcClock_Now();
    timers->threadMs[part] = timers->clock - start;
    Stamp(gl, timers, -1);
}

void qcGlTimers_Mark(const struct qcGlFunctions* gl, qcGlTimers* timers, int part)
{
    assert(part < qc_maxTimedParts);
    if (!timers->on)
        return;
    double now = qcClock_Now();
    Add(&timers->threadMs[part], now - timers->clock);
    timers->clock = now;
    Stamp(gl, timers, part);
}

void qcGlTimers_MarkPassed(qcGlTimers* timers)
{
    qcGlTimestamps* set = Current(timers);
    set->passed = set->count;
}

static void Read(const struct qcGlFunctions* gl, qcGlTimers* timers, qcGlTimestamps* set, uint32_t end)
{
    for (; set->read < end; set->read++)
    {
        GLuint64 time = 0;
        gl->GetQueryObjectui64v(set->queries[set->read], GL_QUERY_RESULT, &time);
        if (set->read > 0)
            Add(&timers->deviceMs[set->parts[set->read]], 1e-6 * (double)(time - set->time));
        set->time = time;
    }
}

void qcGlTimers_End(const struct qcGlFunctions* gl, qcGlTimers* timers, int part)
{
    if (!timers->on)
        return;
    qcGlTimestamps *set = Current(timers), *previous = &timers->sets[(timers->jobs + 1) % 2];
    Read(gl, timers, previous, previous->count);
    Read(gl, timers, set, set->passed);
    // A job that ran out of timestamps has incomplete times.
    for (int i = 0; set->count == qc_maxTimestamps && i < qc_maxTimedParts; i++)
        timers->deviceMs[i] = -1.0;
    // Without a flush the last timestamps stay in the driver until the next job.
    gl->Flush();
    double now = qcClock_Now();
    Add(&timers->threadMs[part], now - timers->clock);
    timers->clock = now;
}

void qcGlTimers_Delete(const struct qcGlFunctions* gl, qcGlTimers* timers)
{
    for (int i = 0; timers->created && i < 2; i++)
        gl->DeleteQueries(qc_maxTimestamps, timers->sets[i].queries);
}
