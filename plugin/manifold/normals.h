// Fifth stage: the normal of each pair, and its projected overlap along it. Separating planes give those of settled
// pairs; the others are chosen, propagated, oriented and corrected, a file each: plugin/docs/manifolds.md.
#ifndef QC_MANIFOLD_NORMALS_H
#define QC_MANIFOLD_NORMALS_H

#include "manifold/pair_adjacency.h"

/// Results of the earlier stages, and how this stage runs.
typedef struct qcContactInput
{
    const qcBodies* bodies;
    const qcContactTopology* topology;
    const qcContactRegions* regions;
    const qcContactProximity* proximity;
    const qcPairAdjacency* adjacency;
    const qcOverlapKernels* kernels;
    double margin; ///< in the topology's unit of length
    uint32_t threads;
} qcContactInput;

typedef struct qcPairNormal
{
    qcVector normal;       ///< unit, from side 1 towards side 0
    bool disjoint;         ///< the pair is separated, and along its normal side 0 lies above side 1, or beside it
    bool keepsReported;    ///< the normal is that of the pair's proximity, up to its sign
    bool flipped;          ///< the orientation has reversed the normal: the distances of the overlap are opposite
    bool isNoLocalMinimum; ///< separated, and an adjacent pair is closer at the same closest features
    //  propagation
    bool changed;      ///< the normal is that of an adjacent pair
    bool intersecting; ///< the normal is one along which triangles intersect or touch
    bool reliable;     ///< the normal is that of a coplanar contact, or taken from one
    uint16_t round;    ///< the last round in which the normal has changed, from 1
    double cost;       ///< see qcNeighbourhood_FindCost
} qcPairNormal;

typedef struct qcContactNormals
{
    qcArray pairs; ///< of qcPairNormal
    //  scratch
    qcArray next;               ///< of qcPairNormal: of the next round of propagation
    qcArray rounds;             ///< of uint16_t, by triangle: the last such round in which one of its pairs changed
    qcArray components, nodes;  ///< of the orientation, by pair
    qcArray references;         ///< likewise, by region
    qcArray waysOut;            ///< of the outward normals, by region
    qcArray items, sortScratch; ///< of the orientation: links; of the minimum translation: pairs by region
} qcContactNormals;

/// Finds the normals of all pairs, and the overlaps along them. The steps below are serial unless stated otherwise.
qcStatus qcContactNormals_Find(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals);
void qcContactNormals_Free(qcContactNormals* normals);

/// Sets the normal of a pair, and computes its overlap along it. Serial.
qcStatus qcContactNormals_Set(const qcContactInput* input, uint32_t pair, qcVector normal, qcPairOverlaps* overlaps,
                              qcContactNormals* normals);

//  ---- the steps, in their order ---------------------------------------------------------------------------

/// Chooses the normal of each pair from the pair itself and those adjacent to it. In parallel.
qcStatus qcContactNormals_Choose(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals);
/// Propagates normals where triangles intersect: from coplanar contacts to the pairs around them. In parallel.
qcStatus qcContactNormals_Propagate(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals);
/// Determines the signs of the normals in each ambiguous region.
qcStatus qcContactNormals_Orient(const qcContactInput* input, const qcPairOverlaps* overlaps,
                                 qcContactNormals* normals);
/// Replaces normals that don't lead out of two closed bodies in regions with a clear way out.
qcStatus qcContactNormals_LeadOut(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals);
/// Applies the minimum-translation fallback to regions that penetrate.
qcStatus qcContactNormals_Shorten(const qcContactInput* input, qcPairOverlaps* overlaps, qcContactNormals* normals);

static inline qcPairNormal* qcContactNormals_Pair(const qcContactNormals* normals, uint32_t pair)
{
    return &QC_AT(qcPairNormal, normals->pairs, pair);
}

#endif
