// From reported pairs with their proximities to manifolds: one for each connected region of contact.
#ifndef QC_PLUGIN_MANIFOLD_H
#define QC_PLUGIN_MANIFOLD_H

#include "proximity.h"
#include "triangles.h"

typedef struct qcManifolds
{
    qcArray work;      ///< of qcManifoldPair, in the order of the reported pairs
    qcArray triangles; ///< of qcManifoldTriangle: those of the pairs
    qcArray numbers;   ///< of each triangle of the step: one more than its place among these; all 0 between builds
    qcArray vertices, table;   ///< welded vertices by position, and their hash table
    qcArray last;              ///< of a vertex, while regions are joined: one more than an entry of pairsOf
    qcArray freePairs;         ///< of uint32_t: those that no plane settles
    qcArray pairsOf;           ///< of qcPairSide: by triangle, the pairs that it is in
    qcArray places;            ///< of qcManifoldPlace: the same of pairs that are free
    qcArray proximities, feet; ///< of reported pairs, if the input has none: of those that are free
    qcArray choices, heard;    ///< a normal for each pair, and what it is in the next round
    qcArray nodes;             ///< trees of regions, later of signs
    qcArray regions;           ///< of qcPairRegion
    qcArray planes;            ///< one a region, while planes are looked for
    qcArray parts;             ///< while signs are looked for
    qcArray numbered;          ///< regions in the order of the result
    qcArray workers;           ///< of qcManifoldWorker
    qcArray corners;           ///< of qcPairCorners, one a pair
    qcArray raw;               ///< points as the pairs see them, in the order of the pairs
    qcArray firstRaw;          ///< of each pair, and one more
    qcArray witnessed;         ///< bool: what the pair said itself is a point
    qcArray order, scratch;
    qcArray heads, links; ///< a hash table of the points that stay, by place
    qcArray keepers;      ///< of each raw point: the one that stands for it
    qcArray members;      ///< of each keeper: the raw points that it stands for, linked
    //  results
    qcArray manifolds, points; ///< of qcManifold, of qcManifoldPoint
} qcManifolds;

/// The pairs of a result, with what is known of each.
typedef struct qcManifoldInput
{
    const qcPair* pairs;
    const qcProximity* proximities; ///< null: those that are needed are computed
    const qcFeet* feet;             ///< of the proximities
    size_t count;
    double margin; ///< no point lies farther apart than this
} qcManifoldInput;

/// Builds the manifolds of the pairs of a result. O(n log n). Where two bodies touch no point is deeper than rounding,
/// and where they overlap by a small share of their triangles, within the margin, none is deeper than a small multiple
/// of it.
qcStatus qcManifolds_Build(qcManifolds* manifolds, const qcTriangles* triangles, const qcManifoldInput* input,
                           uint32_t threads);
void qcManifolds_Free(qcManifolds* manifolds);

#endif
