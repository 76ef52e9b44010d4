// Costs of the methods on one machine and device: measured by pipeline/calibrate.c, stored by the device, used by the
// planner.
#ifndef QC_PLAN_COSTS_H
#define QC_PLAN_COSTS_H

/// Milliseconds of a step, and of each triangle that takes part. Infinite: the method does not run here.
typedef struct qcPlanCosts
{
    double sweepPerTriangle;
    double layersFixed, layersPerTriangle;
} qcPlanCosts;

#endif
