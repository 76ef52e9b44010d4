// What lies around the points of a rigid body, and so at which of them a contact can bind.
#ifndef QC_NARROWPHASE_LOCAL_MINIMUM_H
#define QC_NARROWPHASE_LOCAL_MINIMUM_H

#include "mesh/adjacency.h"
#include "scene/bodies.h"
#include "base/vec3.h"

typedef struct qcLocalMinima
{
    uint32_t generation;   ///< the body's; 0: nothing is known
    qcAdjacency adjacency; ///< by triangle
    qcArray owned;         ///< qcOwnedFeatures by triangle: what it stands for, without what is flat
} qcLocalMinima;

/// Of a body with owners. O(triangles) for another body than before.
qcStatus qcLocalMinima_Make(qcLocalMinima* surroundings, const qcBody* body);
void qcLocalMinima_Free(qcLocalMinima* surroundings);

static inline qcOwnedFeatures qcLocalMinima_Owned(const qcLocalMinima* surroundings, uint32_t triangle)
{
    return QC_AT(qcOwnedFeatures, surroundings->owned, triangle);
}

/// `outward` leads from a point of the triangle, which has these weights, to a point of another body: is no point of
/// the triangles around nearer to that?
bool qcLocalMinima_IsNearest(const qcLocalMinima* surroundings, const qcBody* body, uint32_t triangle,
                             const double weights[3], qcVector outward);

/// The corner of the triangle over the edge from corner `edge` to the next; false: there is not one.
bool qcLocalMinima_GetOver(const qcLocalMinima* surroundings, const qcBody* body, uint32_t triangle, int edge,
                           qcVector* over);

/// `side` leads from an edge to the far corner of a triangle that has it, `outward` from the edge to a point of another
/// body, at right angles to the edge: is no point of the triangle nearer to that?
static inline bool qcLocalMinima_LeadsAway(qcVector side, qcVector outward)
{
    // 1e-6: of points that are as near as each other rounding must not drop all.
    double dot = qcDot(side, outward);
    return dot <= 0.0 || dot * dot <= 1e-12 * qcDot(side, side) * qcDot(outward, outward);
}

#endif
