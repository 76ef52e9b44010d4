// The description of a step: request, device, plan. Stages read it and change nothing.
#ifndef QC_PIPELINE_STEP_H
#define QC_PIPELINE_STEP_H

#include "plan/plan.h"
#include "scene/bodies.h"

/// Measures the methods' costs on a device (pipeline/calibrate.h). Called on first need.
typedef qcPlanCosts qcMeasureCosts(qcDevice* device, uint32_t threads);

typedef struct qcStep
{
    const qcDetectDef* def; ///< checked
    qcDevice* device;       ///< may be null
    qcMeasureCosts* measureCosts;
    qcPlan plan;
    uint32_t threads; ///< 1 or more
    /// Pairs whose boxes are further apart have no part in the step. Boxes are compared as lower > upper + distance:
    /// rounding is monotone, so two boxes at most the distance apart always pass.
    double queryDistance;
} qcStep;

/// Whether triangle pairs come from the bodies' BVHs. The paper's methods sweep their own PCS, brute force compares all
/// boxes.
static inline bool qcStep_UsesBvhs(const qcStep* step)
{
    return !step->plan.useImage && step->plan.method != qc_methodBrute;
}

/// Whether neighbours are listed, apart from the candidates: contacts exist between their features.
static inline bool qcStep_ListsNeighbours(const qcStep* step)
{
    return step->def->contactMargin > 0.0 && !step->def->neighbours;
}

#endif
