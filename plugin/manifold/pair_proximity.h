// Third stage: closest points, normal and signed distance of each pair in regions without a separating plane.
#ifndef QC_MANIFOLD_PAIR_PROXIMITY_H
#define QC_MANIFOLD_PAIR_PROXIMITY_H

#include "manifold/separating_plane.h"

/// The proximity of one unsettled pair.
typedef struct qcPairProximity
{
    qcVector normal;  ///< unit, from side 1 towards side 0: along the closest points, or the direction of least depth
    double gap;       ///< the distance, or minus the depth
    bool separated;   ///< not intersecting, and a plane across the normal lies between the triangles
    bool penetrating; ///< other than in one plane
} qcPairProximity;

/// One region, over its unsettled pairs.
typedef struct qcRegionProximity
{
    bool ambiguous;   ///< some pair is not separated: the region's orientation needs a decision
    bool penetrating; ///< some pair penetrates
} qcRegionProximity;

typedef struct qcContactProximity
{
    const qcProximity* reported;       ///< by qcManifoldPair::source
    const qcClosestFeatures* features; ///< likewise
    qcArray pairs;                     ///< of qcPairProximity, by pair; set where unsettled
    qcArray regions;                   ///< of qcRegionProximity
    //  the proximities and features, where the input has none
    qcArray computed, computedFeatures;
} qcContactProximity;

/// `input` holds the proximities in the scene's unit of length; they are computed where it has none, or where the
/// topology has another unit. In parallel.
qcStatus qcContactProximity_Find(const qcManifoldInput* input, const qcContactTopology* topology,
                                 const qcContactRegions* regions, uint32_t threads, qcContactProximity* proximity);
void qcContactProximity_Free(qcContactProximity* proximity);

static inline const qcPairProximity* qcContactProximity_Pair(const qcContactProximity* proximity, uint32_t pair)
{
    return &QC_AT(const qcPairProximity, proximity->pairs, pair);
}

static inline const qcRegionProximity* qcContactProximity_Region(const qcContactProximity* proximity,
                                                                 const qcManifoldPair* pair)
{
    return &QC_AT(const qcRegionProximity, proximity->regions, pair->region);
}

#endif
