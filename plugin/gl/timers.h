// Times of the parts of a job that runs again and again: by the device's clock (GL_TIMESTAMP, ARB_timer_query) and by
// the clock of the thread. Nothing waits for the device: see qcGlTimers_End.
#ifndef QC_GL_TIMERS_H
#define QC_GL_TIMERS_H

#include "gl/gl_functions.h"

enum
{
    qc_maxTimedParts = 16,
    qc_maxTimestamps = 128 ///< of a job
};

/// What an odd or an even job leaves on the device.
typedef struct qcGlTimestamps
{
    GLuint queries[qc_maxTimestamps];
    int parts[qc_maxTimestamps]; ///< that end there; the first ends none
    uint32_t count;              ///< issued
    uint32_t passed;             ///< that the device has passed for sure
    uint32_t read;
    uint64_t time; ///< of the last one read, in nanoseconds
} qcGlTimestamps;

/// Zeroed at first.
typedef struct qcGlTimers
{
    bool on;       ///< in this job
    bool made;     ///< the queries are
    bool hasClock; ///< the device has timestamps
    qcGlTimestamps sets[2];
    uint32_t jobs;
    double clock; ///< the thread's, at the last mark
    /// Milliseconds; below 0: the part did not run or was not measured.
    double threadMs[qc_maxTimedParts], deviceMs[qc_maxTimedParts];
} qcGlTimers;

/// Begins a job whose caller started it at `start` (qcClock_Now): the time since then is that of `part`. With `on`
/// false this and all that follow do nothing.
void qcGlTimers_Begin(const struct qcGlFunctions* gl, qcGlTimers* timers, bool on, double start, int part);
/// Whatever the thread did and the device was given since the last mark belongs to the part.
void qcGlTimers_Mark(const struct qcGlFunctions* gl, qcGlTimers* timers, int part);
/// After the thread has waited for the device: it has passed every mark so far.
void qcGlTimers_MarkPassed(qcGlTimers* timers);
/// Reads the times that the device has passed for sure; those behind them, of reading results back, are read at the end
/// of the next job. deviceMs of these parts is therefore that of the job before.
void qcGlTimers_End(const struct qcGlFunctions* gl, qcGlTimers* timers);
void qcGlTimers_Delete(const struct qcGlFunctions* gl, qcGlTimers* timers);

#endif
