// From reported pairs with their proximities to manifolds: one for each connected region of contact.
#ifndef QC_PLUGIN_MANIFOLD_H
#define QC_PLUGIN_MANIFOLD_H

#include "triangles.h"

typedef struct qcManifolds
{
    qcArray work;               ///< of qcManifoldPair, in the order of the reported pairs
    qcArray vertices, table;    ///< welded vertices by position, and their hash table
    qcArray items, at;          ///< pairs by key, and where in that list a pair's keys stand
    qcArray choices;            ///< a normal for each pair
    qcArray nodes;              ///< trees of regions, later of signs
    qcArray regions, parts;     ///< while signs are looked for
    qcArray numbered;           ///< regions in the order of the result
    qcArray sinks, blocks, raw; ///< points as the pairs see them: of one worker, of one block of pairs, all
    qcArray firstRaw;           ///< of each pair, and one more
    qcArray unheard;            ///< bool: neither the pair nor one beside it has a point
    qcArray order, scratch;
    qcArray heads, links; ///< a hash table of the points that stay, by place
    qcArray keepers;      ///< of each raw point: the one that stands for it
    qcArray members;      ///< of each keeper: the raw points that it stands for, linked
    //  results
    qcArray manifolds, points; ///< of qcManifold, of qcManifoldPoint
} qcManifolds;

/// Builds the manifolds of the pairs of a result. `margin`: no point lies farther apart than this. O(n log n).
qcStatus qcManifolds_Build(qcManifolds* manifolds, const qcTriangles* triangles, const qcPair* pairs,
                           const qcProximity* proximities, size_t count, double margin, uint32_t threads);
void qcManifolds_Free(qcManifolds* manifolds);

#endif
