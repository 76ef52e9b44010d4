// Times of the parts of a repeated job, by the device's clock (GL_TIMESTAMP, ARB_timer_query) and by the thread's
// clock. Nothing waits for the device: see qcGlTimers_End.
#ifndef QC_GL_TIMERS_H
#define QC_GL_TIMERS_H

#include "gl/gl_functions.h"

enum
{
    qc_maxTimedParts = 16,
    qc_maxTimestamps = 128 ///< of a job
};

/// The timestamps of a job.
typedef struct qcGlTimestamps
{
    GLuint queries[qc_maxTimestamps];
    int parts[qc_maxTimestamps]; ///< the part that ends at each timestamp; the first ends none
    uint32_t count;              ///< timestamps issued
    uint32_t passed;             ///< timestamps that the device is known to have passed
    uint32_t read;               ///< timestamps read
    uint64_t time;               ///< of the last one read, in nanoseconds
} qcGlTimestamps;

/// All zero at first.
typedef struct qcGlTimers
{
    bool on;                ///< this job is timed
    bool created;           ///< the queries exist
    bool hasClock;          ///< the device has timestamps
    qcGlTimestamps sets[2]; ///< of even and odd jobs
    uint32_t jobs;
    double clock; ///< the thread's clock at the last mark
    /// Milliseconds; below 0: the part did not run or was not measured.
    double threadMs[qc_maxTimedParts], deviceMs[qc_maxTimedParts];
} qcGlTimers;

/// Begins a job. The time since `start` (qcClock_Now) belongs to `part`. With `on` false this call and those that
/// follow do nothing.
void qcGlTimers_Begin(const struct qcGlFunctions* gl, qcGlTimers* timers, bool on, double start, int part);
/// The thread's work and the device's commands since the last mark belong to the part.
void qcGlTimers_Mark(const struct qcGlFunctions* gl, qcGlTimers* timers, int part);
/// Call it after the thread has waited for the device: the device has passed every mark so far.
void qcGlTimers_MarkPassed(qcGlTimers* timers);
/// Reads the timestamps that the device has passed. Later ones, which end the parts that read results back, are read at
/// the end of the next job: deviceMs of these parts is that of the previous job. The thread's work in this call belongs
/// to `part`.
void qcGlTimers_End(const struct qcGlFunctions* gl, qcGlTimers* timers, int part);
void qcGlTimers_Delete(const struct qcGlFunctions* gl, qcGlTimers* timers);

#endif
