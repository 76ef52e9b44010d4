// The potentially colliding set (PCS) of a step: the visibility set of each body and of each triangle.
// The cull stages write it, the sweep reads it. Quick-CULLIDE, VR 2005, sections 3.2 and 4.1.
#ifndef QC_SCENE_PCS_H
#define QC_SCENE_PCS_H

#include "base/memory.h"
#include "scene/visibility_sets.h"

typedef struct qcPcs
{
    qcArray bodySets; ///< uint8_t, by body of the step: its qcVisibilitySet among the bodies
    /// uint8_t, by global triangle index: both sets of the triangle, see qcPcs_Pack. Undefined for bodies whose pairs a
    /// device or BVHs find.
    qcArray triangleSets;
} qcPcs;

/// Every body in NFV; the sets of triangles are undefined. O(bodyCount).
qcStatus qcPcs_Reset(uint32_t bodyCount, uint32_t triangleCount, qcPcs* pcs);
/// The triangles from `first` to before `end` in BFV.
void qcPcs_ResetTriangles(uint32_t first, uint32_t end, qcPcs* pcs);
void qcPcs_Free(qcPcs* pcs);

/// A triangle's set against triangles of other bodies, and against triangles of its own body, as one byte. 0: both are
/// BFV, the triangle takes no part.
static inline uint8_t qcPcs_Pack(unsigned interSet, unsigned selfSet)
{
    return (uint8_t)(interSet | selfSet << 2);
}

static inline unsigned qcPcs_InterSet(uint8_t packed)
{
    return packed & 3u;
}

static inline unsigned qcPcs_SelfSet(uint8_t packed)
{
    return packed >> 2 & 3u;
}

#endif
