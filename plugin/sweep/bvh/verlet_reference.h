// Reference positions of a body: those of its vertices when its pairs were put in the Verlet list
// (sweep/bvh/verlet_list.h), and the vertices that have moved since.
#ifndef QC_SWEEP_BVH_VERLET_REFERENCE_H
#define QC_SWEEP_BVH_VERLET_REFERENCE_H

#include "sweep/bvh/triangle_bvh.h"

/// Motion since the reference, of a vertex or of a triangle's corner that moved farthest.
typedef enum qcMotionFlag
{
    qc_motionNone,
    qc_motionSmall,
    qc_motionLarge ///< more than the list allows for. It has a bit that the others don't have
} qcMotionFlag;

typedef struct qcVerletReference
{
    double margin;         ///< the list had all pairs up to this distance, in scene units
    qcArray positions;     ///< double, three a vertex of the body. Empty: there is no reference
    uint64_t fitCount;     ///< qcTriangleBvh::fitCount of the reference or its last partial refit
    qcArray bvhVertex;     ///< uint32_t by vertex of the body: its index in the BVH, or vertexCount
    qcArray movedVertices; ///< uint32_t: vertices of the BVH that differ from the reference
    qcArray motionFlags;   ///< uint8_t by slot: qcMotionFlag
} qcVerletReference;

/// Stores the body's positions, to which the BVH is fitted. The list holds its pairs within `margin`.
/// O(vertices). On failure there is no reference.
qcStatus qcVerletReference_Set(qcVerletReference* reference, const qcTriangleBvh* bvh, const qcBody* body,
                               double margin);
/// Drops the positions; memory is retained.
void qcVerletReference_Clear(qcVerletReference* reference);
/// True if there is a reference for the current fit of the BVH.
bool qcVerletReference_IsValid(const qcVerletReference* reference, const qcTriangleBvh* bvh);
void qcVerletReference_Free(qcVerletReference* reference);

#endif
