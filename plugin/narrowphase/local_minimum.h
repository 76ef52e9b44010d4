// What lies around the points of a rigid body, and so at which of them a contact can bind.
#ifndef QC_NARROWPHASE_LOCAL_MINIMUM_H
#define QC_NARROWPHASE_LOCAL_MINIMUM_H

#include "mesh/adjacency.h"
#include "scene/bodies.h"
#include "base/vec3.h"

typedef struct qcSurroundings
{
    uint32_t generation;   ///< the body's; 0: nothing is known
    qcAdjacency adjacency; ///< by triangle
    qcArray owned;         ///< qcOwnedFeatures by triangle: what it stands for, without what is flat
} qcSurroundings;

/// Of a body with owners. O(triangles) for another body than before.
qcStatus qcSurroundings_Make(qcSurroundings* surroundings, const qcBody* body);
void qcSurroundings_Free(qcSurroundings* surroundings);

static inline qcOwnedFeatures qcSurroundings_Owned(const qcSurroundings* surroundings, uint32_t triangle)
{
    return QC_AT(qcOwnedFeatures, surroundings->owned, triangle);
}

/// `outward` leads from a point of the triangle, which has these weights, to a point of another body: is no point of
/// the triangles around nearer to that?
bool qcSurroundings_IsNearest(const qcSurroundings* surroundings, const qcBody* body, uint32_t triangle,
                              const double weights[3], qcVector outward);

/// The corner of the triangle over the edge from corner `edge` to the next; false: there is not one.
bool qcSurroundings_GetOver(const qcSurroundings* surroundings, const qcBody* body, uint32_t triangle, int edge,
                            qcVector* over);

/// `side` leads from an edge to the far corner of a triangle that has it, `outward` from the edge to a point of another
/// body, at right angles to the edge: is no point of the triangle nearer to that?
static inline bool qcSurroundings_LeadsAway(qcVector side, qcVector outward)
{
    // 1e-6: of points that are as near as each other rounding must not drop all.
    double dot = qcDot(side, outward);
    return dot <= 0.0 || dot * dot <= 1e-12 * qcDot(side, side) * qcDot(outward, outward);
}

#endif
