// Medians of measurements, in C++.
#ifndef QC_DEMOS_COMMON_MEDIAN_H
#define QC_DEMOS_COMMON_MEDIAN_H

#include "common/stopwatch.h"

#include <vector>

/// See qcStopwatch_Median.
inline double qcMedianOf(std::vector<double> values)
{
    return qcStopwatch_Median(values.data(), values.size());
}

#endif
