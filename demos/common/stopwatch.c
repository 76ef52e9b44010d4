// Clock and medians of the benchmarks.
#define _POSIX_C_SOURCE 200809L
#include "common/stopwatch.h"

#include <stdlib.h>
#include <time.h>

double qcStopwatch_NowMs(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static int CompareTimes(const void* a, const void* b)
{
    double x = *(const double*)a, y = *(const double*)b;
    return (x > y) - (x < y);
}

double qcStopwatch_Median(double* times, size_t count)
{
    if (count == 0)
        return 0.0;
    qsort(times, count, sizeof *times, CompareTimes);
    return 0.5 * (times[(count - 1) / 2] + times[count / 2]);
}

void qcStopwatch_Rest(void)
{
    // Threads of libgomp spin for some milliseconds.
    const struct timespec rest = {.tv_nsec = 20000000};
    nanosleep(&rest, NULL);
}
