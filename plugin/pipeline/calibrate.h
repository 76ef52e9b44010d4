// What the methods cost on this machine with this device: measured once for each, for the planner.
#ifndef QC_PIPELINE_CALIBRATE_H
#define QC_PIPELINE_CALIBRATE_H

#include "plan/plan.h"

/// The costs with as many threads; measured at the first call (a few milliseconds, and the device compiles its
/// kernels), then kept with the device. A device that fails costs infinitely much.
qcPlanCosts qcCalibrate(qcDevice* device, uint32_t threads);

#endif
