// Two-pass visibility culling to a potentially colliding set (PCS).
#ifndef QC_CULL_VISIBILITY_TWO_PASS_H
#define QC_CULL_VISIBILITY_TWO_PASS_H

#include "cull/visibility/draw_order.h"
#include "gl/visibility/occlusion_queries.h"
#include "quickcullide/scene.h"
#include "scene/visibility_sets.h"

typedef struct qcCullJob
{
    qcDevice* device;
    bool quick;                                     ///< quick or cullide
    qcCullLevel level;                              ///< of the records; decides the depth comparison
    uint32_t body;                                  ///< of the records of qc_levelSelf: slot
    const char* views;                              ///< axes as letters, zero-terminated
    uint32_t resolution, iterations;                ///< 0 iterations: until nothing changes
    bool backToFront, secondPassFromBack, reliable; ///< as in qcDetectDef
    double growth[3];                               ///< reliable: half the margin in each axis of the image
    const float* corners;                           ///< nine a triangle, within [-1, 1]
    uint32_t triangleCount;
    const qcCullPrimitive* primitives;
    uint32_t primitiveCount;
} qcCullJob;

/// Memory, retained between steps. Free it before the device.
typedef struct qcCullScratch
{
    qcVisibility* visibility; ///< null: none yet
    qcArray steps, visible, stepOf, setsOfViews;
    qcCullOrder order;
} qcCullScratch;

/// sets: one a primitive, in and out; all qc_setNfv to begin with. `records` (of qcPassRecord) grows by one a pass.
qcStatus qcCullVisibility_Run(const qcCullJob* job, qcCullScratch* scratch, qcVisibilitySet* sets, qcArray* records);
void qcCullScratch_Free(qcCullScratch* scratch);

#endif
