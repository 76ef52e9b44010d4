// Wall-clock time for the profile.
#ifndef QC_BASE_CLOCK_H
#define QC_BASE_CLOCK_H

/// Milliseconds from some fixed moment; never goes back.
double qcClock_Now(void);

#endif
