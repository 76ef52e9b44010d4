// The cull stages of `cullide` and `quick`: bodies first, then triangles.
#ifndef QC_CULL_VISIBILITY_IMAGE_CULL_H
#define QC_CULL_VISIBILITY_IMAGE_CULL_H

#include "cull/visibility/two_pass.h"
#include "plan/plan.h"
#include "scene/pcs.h"
#include "scene/step_triangles.h"

typedef struct qcImageCull
{
    qcArray records; ///< of qcPassRecord: of all levels of the step, an output
    //  Scratch, retained between steps.
    qcArray corners, vertices, primitives, sets;
    qcArray bodies; ///< uint32_t: bodies of the level
    qcCullScratch scratch;
} qcImageCull;

/// How the step is culled.
typedef struct qcImageCullJob
{
    qcDevice* device;
    const qcPlan* plan;
    const qcDetectDef* def;
} qcImageCullJob;

/// Finds the set of each body among the bodies, and begins the records.
qcStatus qcImageCull_Bodies(const qcImageCullJob* job, const qcStepTriangles* triangles, qcImageCull* cull, qcPcs* pcs);

/// Finds the sets of the triangles in the PCS: against other bodies (all together), and against their own body (body by
/// body). Adds to the records.
qcStatus qcImageCull_Triangles(const qcImageCullJob* job, const qcStepTriangles* triangles, qcImageCull* cull,
                               qcPcs* pcs);
void qcImageCull_Free(qcImageCull* cull);

#endif
