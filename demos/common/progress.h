// Progress of work on standard error, if it takes longer than a second.
//
// On a terminal one line that turns and counts; elsewhere a line of text now and then.
// Thread-safety: one piece of work at a time; qcProgress_Update from any thread.
#ifndef QC_DEMOS_COMMON_PROGRESS_H
#define QC_DEMOS_COMMON_PROGRESS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Begins work of `total` steps; 0: an unknown number. The label ("reading a.ply") is copied.
/// A thread prints, so that work without calls of qcProgress_Update is shown too.
void qcProgress_Begin(uint64_t total, const char* label);

/// `done` steps are finished. Cheap: may be called for every step.
void qcProgress_Update(uint64_t done);

/// Ends it and clears the terminal's line. Call it before anything else is written to standard error.
void qcProgress_End(void);

#ifdef __cplusplus
}
#endif

#endif
