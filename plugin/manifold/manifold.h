// From reported pairs with their proximities to manifolds: one for each connected region of contact.
#ifndef QC_MANIFOLD_MANIFOLD_H
#define QC_MANIFOLD_MANIFOLD_H

#include "triangle/proximity.h"
#include "scene/step_triangles.h"

/// The manifolds of all bodies.
typedef struct qcAllManifolds
{
    qcArray runs;     ///< of qcSortItem: pairs of one triangle of A that follow each other, sorted by their bodies
    qcArray meetings; ///< of qcBodyPairRange: where two bodies meet, or one itself, sorted by them
    qcArray order;    ///< of qcSortItem: meetings, the largest first
    qcArray scratch;
    qcArray makers; ///< of qcManifoldBuilder, one a thread
    //  results
    qcArray manifolds, points; ///< of qcManifold, of qcManifoldPoint
} qcAllManifolds;

/// The pairs of a result, with what is known of each.
typedef struct qcManifoldInput
{
    const qcPair* pairs;
    const qcProximity* proximities; ///< null: those that are needed are computed
    const qcClosestFeatures* feet;  ///< of the proximities
    size_t count;
    double margin; ///< no point lies farther apart than this
} qcManifoldInput;

/// Builds the manifolds of the pairs of a result, which are sorted as the ABI promises. O(n log n). Where two bodies
/// touch no point is deeper than rounding, and where they overlap by a small share of their triangles, within the
/// margin, none is deeper than a small multiple of it.
qcStatus qcAllManifolds_Build(qcAllManifolds* all, const qcStepTriangles* triangles, const qcManifoldInput* input,
                              uint32_t threads);
void qcAllManifolds_Free(qcAllManifolds* all);

#endif
