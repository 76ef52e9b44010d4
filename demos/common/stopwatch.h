// Clock and medians of the benchmarks.
#ifndef QC_DEMOS_COMMON_STOPWATCH_H
#define QC_DEMOS_COMMON_STOPWATCH_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Milliseconds of a clock that never goes back.
double qcStopwatch_NowMs(void);

/// Sorts the times and returns their median; 0 for none.
double qcStopwatch_Median(double* times, size_t count);

/// Until threads that wait for work by looking again and again have gone to sleep: the next one that is measured would
/// find its cores busy.
void qcStopwatch_Rest(void);

#ifdef __cplusplus
}
#endif

#endif
