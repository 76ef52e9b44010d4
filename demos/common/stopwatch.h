// Clock and medians of the benchmarks.
#ifndef QC_DEMOS_COMMON_STOPWATCH_H
#define QC_DEMOS_COMMON_STOPWATCH_H

#include <stddef.h>

/// Milliseconds of a clock that never goes back.
double qcBenchTime_NowMs(void);

/// Sorts the times and returns their median; 0 for none.
double qcBenchTime_Median(double* times, size_t count);

/// Until threads that wait for work by looking again and again have gone to sleep: the next one that is measured would
/// find its cores busy.
void qcBenchTime_Rest(void);

#endif
