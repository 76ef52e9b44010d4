// From reported pairs with their proximities to manifolds: one for each connected region of contact.
#ifndef QC_MANIFOLD_MANIFOLD_H
#define QC_MANIFOLD_MANIFOLD_H

#include "triangle/proximity.h"
#include "scene/step_triangles.h"

/// The manifolds of all bodies.
typedef struct qcAllManifolds
{
    qcArray runs;      ///< of qcSortItem: consecutive pairs with the same triangle of A, sorted by their bodies
    qcArray bodyPairs; ///< of qcBodyPairRange, sorted by bodies
    qcArray order;     ///< of qcSortItem: body pairs, the largest first
    qcArray scratch;
    qcArray builders; ///< of qcManifoldBuilder, one a worker
    //  results
    qcArray manifolds, points; ///< of qcManifold, of qcManifoldPoint
} qcAllManifolds;

/// The pairs of a result, with their proximities.
typedef struct qcManifoldInput
{
    const qcPair* pairs;
    const qcProximity* proximities;    ///< null: those that are needed are computed
    const qcClosestFeatures* features; ///< of the proximities
    size_t count;
    double margin;   ///< max distance of a contact point, in scene units
    double spacing;  ///< see qcDetectDef
    bool unoriented; ///< see qcDetectDef
} qcManifoldInput;

/// Builds the manifolds of the pairs of a result, which are sorted as the ABI promises. O(n log n). Where two bodies
/// touch no point is deeper than rounding, and where they overlap by a small share of their triangles, within the
/// margin, none is deeper than a small multiple of it.
qcStatus qcAllManifolds_Build(qcAllManifolds* all, const qcStepTriangles* triangles, const qcManifoldInput* input,
                              uint32_t threads);
void qcAllManifolds_Free(qcAllManifolds* all);

#endif
