// Two-pass visibility culling to a potentially colliding set (PCS).
#ifndef QC_PLUGIN_CULL_VISIBILITY_H
#define QC_PLUGIN_CULL_VISIBILITY_H

#include "memory.h"
#include "quickcullide/scene.h"
#include "visibility_sets.h"

/// A run of triangles that is tested and drawn as one.
typedef struct qcCullPrimitive
{
    uint32_t firstTriangle, triangleCount; ///< in qcCullJob::corners
    /// Primitives of one group don't hide each other: the triangles of one body, seen by other bodies. Groups are
    /// numbered from 0 in rendering order and lie together.
    uint32_t group;
} qcCullPrimitive;

typedef struct qcCullJob
{
    qcDevice* device;
    bool quick;                      ///< quick or cullide
    qcCullLevel level;               ///< decides the depth comparison, and names the records
    uint32_t body;                   ///< names the records of qc_levelSelf
    const char* views;               ///< letters, ended by a zero
    uint32_t resolution, iterations; ///< 0 iterations: until nothing changes
    const float* corners;            ///< nine a triangle, within [-1, 1]
    uint32_t triangleCount;
    const qcCullPrimitive* primitives;
    uint32_t primitiveCount;
} qcCullJob;

/// Memory that culling keeps between steps.
typedef struct qcCullScratch
{
    qcArray steps, visible, stepOf;
} qcCullScratch;

/// sets: one a primitive, in and out; all qc_setNfv to begin with. `records` (of qcPassRecord) grows by one a pass.
qcStatus qcCullVisibility_Run(const qcCullJob* job, qcCullScratch* scratch, qcVisibilitySet* sets, qcArray* records);
void qcCullScratch_Free(qcCullScratch* scratch);

#endif
