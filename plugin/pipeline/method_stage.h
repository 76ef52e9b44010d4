// From body pairs to candidates: the cull and the sweep over triangles, each island by its method.
#ifndef QC_PIPELINE_METHOD_STAGE_H
#define QC_PIPELINE_METHOD_STAGE_H

#include "cull/layers/layers.h"
#include "cull/visibility/image_cull.h"
#include "pipeline/island_routing.h"

/// Retained between steps.
typedef struct qcMethodStage
{
    qcCandidates candidates; ///< the output
    char fallback[320];      ///< why the device did not answer: qcProfile::fallback points here
    qcIslandRouting routing;
    qcCullLayers layers;
    qcArray layersKeys, layersAdjacentKeys, layersClassified; ///< the device's pairs, as in qcCandidates
    qcBvhCandidates bvhs;
} qcMethodStage;

/// Culls to the PCS: islands on the device to candidates already, BVHs of the other bodies are brought up to date, the
/// triangles of all others are marked, and culled in the image by `cullide` and `quick`.
qcStatus qcMethodStage_Cull(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                            qcMethodStage* stage, qcImageCull* imageCull, qcPcs* pcs, qcProfile* profile);

/// Finds the candidates in the PCS. O(n log n + candidates) on the CPU.
qcStatus qcMethodStage_Sweep(const qcStep* step, const qcStepTriangles* triangles, const qcBodyPairs* pairs,
                             const qcPcs* pcs, qcMethodStage* stage, qcProfile* profile);
void qcMethodStage_Free(qcMethodStage* stage);

#endif
