// Measures what the methods cost on this machine with this device, for the planner.
#ifndef QC_PIPELINE_CALIBRATE_H
#define QC_PIPELINE_CALIBRATE_H

#include "plan/plan.h"

/// The costs with this number of threads. The first call for a device and a number of threads measures them (some 20
/// milliseconds, at most 250, plus the compilation of the device's kernels); later ones return the saved costs.
/// Infinite for a device that fails.
qcPlanCosts qcCalibrate(qcDevice* device, uint32_t threads);

#endif
