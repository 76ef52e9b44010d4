// The cull stages of the image methods: bodies first, then triangles.
#ifndef QC_CULL_VISIBILITY_IMAGE_CULL_H
#define QC_CULL_VISIBILITY_IMAGE_CULL_H

#include "cull/visibility/two_pass.h"
#include "plan/plan.h"
#include "scene/step_triangles.h"

/// Memory that the stages keep between steps.
typedef struct qcCull
{
    qcArray corners, primitives, sets;
    qcArray bodies;  ///< uint32_t: bodies that take part in a level
    qcArray records; ///< of qcPassRecord: of all levels of the step
    qcCullScratch scratch;
} qcCull;

/// Finds the set of each body among the bodies (qcStepTriangles::bodySet).
qcStatus qcCull_Objects(qcCull* cull, qcStepTriangles* triangles, qcDevice* device, const qcPlan* plan,
                        const qcDetectDef* def);

/// Finds the sets of the triangles in the PCS: against other bodies (all together), against their own (body by body).
qcStatus qcCull_Triangles(qcCull* cull, qcStepTriangles* triangles, qcDevice* device, const qcPlan* plan,
                          const qcDetectDef* def);
void qcCull_Free(qcCull* cull);

#endif
