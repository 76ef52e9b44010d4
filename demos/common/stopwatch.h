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

/// Waits until spinning threads have gone to sleep: they would keep cores busy during the next measurement.
void qcStopwatch_Rest(void);

#ifdef __cplusplus
}
#endif

#endif
