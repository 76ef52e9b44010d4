// One step: all stages, in the order of the data flow.
#ifndef QC_PIPELINE_DETECT_H
#define QC_PIPELINE_DETECT_H

#include "manifold/manifold.h"
#include "narrowphase/narrowphase.h"
#include "pipeline/pcs_report.h"
#include "pipeline/method_stage.h"
#include "pipeline/vertex_buffers.h"

/// The memory of each stage, retained between steps, and the last result.
typedef struct qcDetector
{
    qcStepTriangles triangles;
    qcPcs pcs;
    qcImageCull imageCull;
    qcBodyPairs bodyPairs;
    qcMethodStage triangleStage;
    qcVertexBuffers vertexBuffers;
    qcNarrowphase narrowphase;
    qcAllManifolds manifolds;
    qcPcsReport pcsReport;
    qcResult result;
    //  The request of the last result, and the scene's revision then. valid: there is a result.
    bool valid;
    uint64_t revision;
    qcDetectDef def;
} qcDetector;

/// `def` has been checked; `device` may be null. Fills detector->result, or retains it if scene and request are the
/// same as in the last call.
qcStatus qcDetector_Run(const qcDetectDef* def, qcDevice* device, qcMeasureCosts* measureCosts, qcBodies* bodies,
                        qcDetector* detector);
void qcDetector_Free(qcDetector* detector);

#endif
