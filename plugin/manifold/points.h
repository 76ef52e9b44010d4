// Last stage: contact points from the projected overlaps; those at one place are merged, and redundant ones dropped.
#ifndef QC_MANIFOLD_POINTS_H
#define QC_MANIFOLD_POINTS_H

#include "manifold/normals.h"

typedef struct qcContactPoints
{
    qcArray raw;             ///< of qcRawPoint, in the order of the pairs
    qcArray firstOfPair;     ///< of size_t: each pair's first raw point; one more at the end
    qcArray tolerances;      ///< of double, by region: points within this distance of each other are one
    qcArray order;           ///< of qcSortItem: region, raw point
    qcArray representatives; ///< of uint32_t, by raw point: the one that stands for it; UINT32_MAX: it was dropped
    qcArray nextMembers;     ///< of uint32_t, by raw point: the next one with the same representative, or UINT32_MAX
    //  scratch
    qcArray hasFallback;  ///< of bool, by pair
    qcArray heads, links; ///< hash table of the representatives by position
    qcArray sortScratch;
} qcContactPoints;

/// Points of all pairs: corners of their overlaps, and fallback points. Reverses, sorts and thins out the corners in
/// the overlaps, and adds those of settled pairs. In parallel.
qcStatus qcContactPoints_Collect(const qcContactInput* input, const qcContactNormals* normals, qcPairOverlaps* overlaps,
                                 qcContactPoints* points);
/// Merges points of a region at one place. The order is by region, in each the deepest first.
qcStatus qcContactPoints_Merge(const qcContactTopology* topology, qcContactPoints* points);
/// Coplanar reduction: drops representatives between others of a flat patch, unless a body deforms.
void qcContactPoints_Reduce(const qcContactTopology* topology, const qcContactNormals* normals,
                            qcContactPoints* points);
/// Reduces the order to representatives: by region, in each by distance; those at equal distance stay in the order in
/// which they were merged.
qcStatus qcContactPoints_Order(const qcContactTopology* topology, qcContactPoints* points);
void qcContactPoints_Free(qcContactPoints* points);

static inline const qcRawPoint* qcContactPoints_Raw(const qcContactPoints* points, uint64_t raw)
{
    return &QC_AT(const qcRawPoint, points->raw, raw);
}

static inline double qcContactPoints_Tolerance(const qcContactPoints* points, uint64_t region)
{
    return QC_AT(double, points->tolerances, region);
}

/// True if one end of both is at nearly the same position, and their normals are nearly parallel. The deeper one is
/// kept: the other is the same feature found from another triangle, or lies behind it.
static inline bool qcRawPoint_AreSame(const qcRawPoint* p, const qcRawPoint* q, double tolerance)
{
    qcVector d = qcMinus(p->end[0], q->end[0]), e = qcMinus(p->end[1], q->end[1]);
    double limit = tolerance * tolerance;
    // 30 degrees: a corner on a floor and against a wall is two contacts.
    return (qcDot(d, d) <= limit || qcDot(e, e) <= limit) && qcDot(p->normal, q->normal) >= 0.866;
}

#endif
