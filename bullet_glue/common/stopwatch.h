// The clock of the statistics.
#ifndef QC_GLUE_COMMON_STOPWATCH_H
#define QC_GLUE_COMMON_STOPWATCH_H

#include <chrono>

/// Milliseconds of a monotonic clock.
inline double qcNowMs()
{
    using namespace std::chrono;
    return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}

#endif
