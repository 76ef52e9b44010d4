// Switches for the stages of manifolds. The library has none: every stage runs, and the conditions below are constants.
// The core of qc-ablation (QC_MANIFOLD_SWITCHES) reads from the environment's QC_MANIFOLD_OFF which stages are off.
#ifndef QC_MANIFOLD_STAGE_SWITCHES_H
#define QC_MANIFOLD_STAGE_SWITCHES_H

#include <stdbool.h>

#ifdef QC_MANIFOLD_SWITCHES

typedef enum qcManifoldStage
{
    qc_stage_separatingPlane,
    qc_stage_neighbourCost,
    qc_stage_localMinimum,
    qc_stage_propagation,
    qc_stage_orientation,
    qc_stage_outwardNormals,
    qc_stage_minimumTranslation,
    qc_stage_fallbackPoints,
    qc_stage_merge,
    qc_stage_coplanarReduction,
    qc_stageCount
} qcManifoldStage;

/// Reads QC_MANIFOLD_OFF: names as in the enumeration, separated by commas. To be called while no stage runs.
void qcManifoldStages_Read(void);
bool qcManifoldStages_Runs(qcManifoldStage stage);

#define QC_READ_STAGE_SWITCHES() qcManifoldStages_Read()
#define QC_STAGE_RUNS(stage) qcManifoldStages_Runs(qc_stage_##stage)

#else

#define QC_READ_STAGE_SWITCHES() ((void)0)
#define QC_STAGE_RUNS(stage) true

#endif

#endif
