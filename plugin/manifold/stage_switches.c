// The switches of qc-ablation's core; no part of the library.
#include "manifold/stage_switches.h"

#include <stdlib.h>
#include <string.h>

static const char* const s_names[qc_stageCount] = {
    "separatingPlane", "neighbourCost",      "localMinimum",   "propagation", "orientation",
    "outwardNormals",  "minimumTranslation", "fallbackPoints", "merge",       "coplanarReduction",
};

static bool s_off[qc_stageCount];

void qcManifoldStages_Read(void)
{
    const char* off = getenv("QC_MANIFOLD_OFF");
    for (int i = 0; i < qc_stageCount; i++)
        s_off[i] = off != NULL && strstr(off, s_names[i]) != NULL;
}

bool qcManifoldStages_Runs(qcManifoldStage stage)
{
    return !s_off[stage];
}
