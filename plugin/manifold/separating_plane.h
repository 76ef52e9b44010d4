// Second stage: regions whose two sides are separated by one plane. All their pairs have its normal. The later stages
// of normals process the pairs of the other regions only, the unsettled ones.
#ifndef QC_MANIFOLD_SEPARATING_PLANE_H
#define QC_MANIFOLD_SEPARATING_PLANE_H

#include "manifold/projected_overlap.h"

typedef struct qcContactRegion
{
    bool hasSeparatingPlane;
    qcVector normal; ///< of the plane, unit, from side 1 towards side 0
} qcContactRegion;

typedef struct qcContactRegions
{
    qcArray regions;        ///< of qcContactRegion
    qcArray unsettledPairs; ///< of uint32_t: the pairs of regions without a separating plane, ascending
    //  scratch
    qcArray planes;    ///< one a region
    qcArray visitedBy; ///< of uint32_t, by triangle: the region and side that have its heights
} qcContactRegions;

/// `margin`: max distance of a contact point, in the topology's unit of length.
qcStatus qcContactRegions_Find(const qcContactTopology* topology, const qcOverlapKernels* kernels, double margin,
                               qcContactRegions* regions);
void qcContactRegions_Free(qcContactRegions* regions);

static inline const qcContactRegion* qcContactRegions_Of(const qcContactRegions* regions, const qcManifoldPair* pair)
{
    return &QC_AT(const qcContactRegion, regions->regions, pair->region);
}

/// True if a separating plane gives the pair's normal.
static inline bool qcContactRegions_IsSettled(const qcContactRegions* regions, const qcManifoldPair* pair)
{
    return qcContactRegions_Of(regions, pair)->hasSeparatingPlane;
}

static inline uint32_t qcContactRegions_UnsettledPair(const qcContactRegions* regions, size_t i)
{
    return QC_AT(uint32_t, regions->unsettledPairs, i);
}

#endif
