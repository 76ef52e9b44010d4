// What the methods cost on a machine with a device: measured by calibrate.c, kept by the device, used by the planner.
#ifndef QC_PLAN_COSTS_H
#define QC_PLAN_COSTS_H

/// Milliseconds: of a step (Fixed), and for each triangle that takes part.
typedef struct qcPlanCosts
{
    double sweepPerTriangle;
    double layersFixed, layersPerTriangle;
} qcPlanCosts;

#endif
