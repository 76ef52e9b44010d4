// Wall-clock time for the profile.
#ifndef QC_PLUGIN_CLOCK_H
#define QC_PLUGIN_CLOCK_H

/// Milliseconds from some fixed moment; never goes back.
double qcClock_Now(void);

#endif
