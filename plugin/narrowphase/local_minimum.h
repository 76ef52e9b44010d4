// The local-minimum filter: of the contacts between a deforming and a rigid body it keeps those at points of the rigid
// surface whose distance is a local minimum. Proof: plugin/docs/proofs/local_minimum_filter.md.
#ifndef QC_NARROWPHASE_LOCAL_MINIMUM_H
#define QC_NARROWPHASE_LOCAL_MINIMUM_H

#include "base/vec3.h"
#include "mesh/adjacency.h"
#include "scene/bodies.h"

/// The filter of one rigid body.
typedef struct qcLocalMinima
{
    uint32_t generation;   ///< of the body; 0: empty
    qcAdjacency adjacency; ///< by triangle
    qcArray owned;         ///< qcOwnedFeatures by triangle: qcBody::owned without flat edges and corners
} qcLocalMinima;

/// For a body with feature owners. O(triangles) for another body than in the last call, otherwise O(1).
qcStatus qcLocalMinima_Make(qcLocalMinima* localMinima, const qcBody* body);
void qcLocalMinima_Free(qcLocalMinima* localMinima);

static inline qcOwnedFeatures qcLocalMinima_Owned(const qcLocalMinima* localMinima, uint32_t triangle)
{
    return QC_AT(qcOwnedFeatures, localMinima->owned, triangle);
}

/// Whether no point of the adjacent triangles is nearer to the other body than the triangle's point with these weights.
/// `outward` leads from that point to the other body's.
bool qcLocalMinima_IsNearest(const qcLocalMinima* localMinima, const qcBody* body, uint32_t triangle,
                             const double weights[3], qcVector outward);

/// The opposite vertex of the triangle across the edge from corner `edge` to the next; false: there is none.
bool qcLocalMinima_GetOppositeVertex(const qcLocalMinima* localMinima, const qcBody* body, uint32_t triangle, int edge,
                                     qcVector* opposite);

/// Whether no point of a triangle is nearer to the other body than its edge is. `side` leads from the edge to the
/// triangle's third corner, `outward` from the edge to the other body, at right angles to the edge.
static inline bool qcLocalMinima_LeadsAway(qcVector side, qcVector outward)
{
    // 1e-6: rounding must not drop all of several equally near points.
    double dot = qcDot(side, outward);
    return dot <= 0.0 || dot * dot <= 1e-12 * qcDot(side, side) * qcDot(outward, outward);
}

#endif
