// The whole line, once: what a scene keeps between steps, and the step.
#ifndef QC_PIPELINE_DETECT_H
#define QC_PIPELINE_DETECT_H

#include "sweep/candidates.h"
#include "cull/visibility/image_cull.h"
#include "cull/layers/layers.h"
#include "manifold/manifold.h"
#include "narrowphase/narrowphase.h"
#include "sweep/islands.h"
#include "sweep/bvh_candidates.h"

typedef struct qcDetector
{
    qcStepTriangles triangles;
    qcCull cull;
    qcCullLayers cullLayers;
    qcBodyPairs objects;
    qcIslands parts;
    qcPlanHistory history;
    double plannedTriangles; ///< what the planner chose a method for in the step; 0: it did not choose
    qcBvhCandidates surfaces;
    qcArray onDevice;             ///< uint8_t, by body of the step: answered by the device
    qcArray onSurfaces;           ///< uint8_t, by body of the step: answered by the sweep of surfaces
    qcArray elsewhere;            ///< uint8_t, by body of the step: either
    qcArray neighboursOnSurfaces; ///< uint8_t, by body of the step: answered by the device, its neighbours by the sweep
    qcArray layersKeys, layersContactKeys, layersSure; ///< the device's candidates, as in qcPairBuffer
    qcCandidates candidates;
    qcNarrowphase narrow;
    qcAllManifolds manifolds;
    qcArray pcs, marks;
    qcResult result;
    char fallback[320]; ///< what the profile points at
    //  What the result answers; valid: there is one.
    bool valid;
    uint64_t revision;
    qcDetectDef def;
} qcDetector;

/// `def` has been checked. `device` may be null.
qcStatus qcDetector_Run(qcDetector* detector, qcBodies* bodies, qcDevice* device, const qcDetectDef* def);
void qcDetector_Free(qcDetector* detector);

#endif
