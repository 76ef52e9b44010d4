// What a direction costs a pair and the pairs around it, and what its triangles have in common along one.
#include "manifold/normal_cost.h"

#include <math.h>

// The weight of the pair itself: its own six vertices.
static const double s_self = 6.0;

qcNeighbourhood qcNeighbourhood_Of(const qcManifoldBuilder* m, uint32_t index)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcNeighbourhood n = {m, pair, {qcManifoldBuilder_Ring(m, pair, 0), qcManifoldBuilder_Ring(m, pair, 1)}, 0.0};
    n.rounding = qcManifoldPair_Rounding(pair) * (s_self + n.ring[0].count + n.ring[1].count);
    return n;
}

static void AddWays(qcTrial* trial, qcWaysOut ways, double weight)
{
    trial->along += weight * qcPositive(ways.along);
    trial->against += weight * qcPositive(ways.against);
}

/// The pairs beside this one whose common triangle, at these heights, is that of a side.
static void AddRing(const qcNeighbourhood* n, int side, qcHeights common, qcVector origin, qcTrial* trial)
{
    qcRing ring = n->ring[side];
    qcVector direction = trial->normal;
    for (uint32_t i = 0; i < ring.count; i++)
    {
        const qcManifoldPlace* place = qcManifoldBuilder_Beside(n->manifolds, ring.entries[i]);
        qcHeights h =
            side == trial->face ? place->heights : qcManifoldTriangle_Heights(place->moved, origin, direction);
        AddWays(trial, side == 0 ? qcWaysOut_Of(common, h) : qcWaysOut_Of(h, common),
                (double)(ring.entries[i] & qc_ringShared));
    }
}

bool qcNeighbourhood_FindCost(const qcNeighbourhood* n, double limit, qcTrial* trial)
{
    const qcManifoldPair* pair = n->pair;
    qcVector origin = pair->side[trial->face == 0 ? 0 : 1]->corner[0];
    const qcHeights heights[2] = {qcManifoldTriangle_Heights(pair->side[0], origin, trial->normal),
                                  qcManifoldTriangle_Heights(pair->side[1], origin, trial->normal)};
    trial->along = trial->against = 0.0;
    trial->ways = qcWaysOut_Of(heights[0], heights[1]);
    AddWays(trial, trial->ways, s_self);
    // What the places know already comes first.
    int first = trial->face == 1 ? 1 : 0;
    for (int k = 0; k < 2 && (trial->along < limit || trial->against < limit); k++)
        AddRing(n, k == 0 ? first : 1 - first, heights[k == 0 ? first : 1 - first], origin, trial);
    return trial->along < limit || trial->against < limit;
}

void qcLook_Along(const qcManifoldBuilder* m, const qcManifoldPair* pair, qcVector normal, qcLook* look)
{
    if (look->count >= 0)
        return;
    look->count = qcManifoldBuilder_FindCommonPart(m, pair, normal, look->corners);
    look->low = INFINITY;
    look->high = -INFINITY;
    for (int i = 0; i < look->count; i++)
    {
        double distance = look->corners[i].distance;
        look->low = distance < look->low ? distance : look->low;
        look->high = distance > look->high ? distance : look->high;
    }
}

void qcManifoldBuilder_KeepCorners(qcManifoldBuilder* m, uint32_t index, uint32_t worker, const qcLook* look,
                                   qcVector normal, bool opposite, double margin)
{
    const qcManifoldPair* pair = qcManifoldBuilder_Pair(m, index);
    qcArray* points = &QC_AT(qcManifoldWorker, m->workers, worker).points;
    double limit = qcManifoldPair_Limit(pair, margin);
    if (qcManifoldBuilder_PairRegion(m, pair)->unsettled)
        limit = INFINITY;
    qcPairCorners* kept = &QC_AT(qcPairCorners, m->corners, index);
    *kept = (qcPairCorners){points->count, (uint16_t)worker, 0};
    for (int i = 0; i < look->count; i++)
    {
        double distance = opposite ? -look->corners[i].distance : look->corners[i].distance;
        if (!(distance <= limit))
            continue;
        qcRawPoint* point = &QC_AT(qcRawPoint, *points, points->count++);
        *point = look->corners[i];
        point->normal = normal;
        point->distance = distance;
        point->pair = index;
        kept->count++;
    }
}
