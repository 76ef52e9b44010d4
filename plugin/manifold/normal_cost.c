// The cost of a candidate normal.
#include "manifold/normal_cost.h"

#include <math.h>

// The weight of the pair itself: its own six vertices.
static const double s_ownWeight = 6.0;

qcNeighbourhood qcNeighbourhood_Of(const qcContactInput* input, uint32_t pair)
{
    const qcPairAdjacency* adjacency = input->adjacency;
    qcNeighbourhood n = {.pair = qcContactTopology_Pair(input->topology, pair),
                         .proximity = qcContactProximity_Pair(input->proximity, pair),
                         .adjacency = adjacency,
                         .adjacent = {qcPairAdjacency_Of(adjacency, pair, 0), qcPairAdjacency_Of(adjacency, pair, 1)}};
    n.rounding = qcManifoldPair_Rounding(n.pair) * (s_ownWeight + n.adjacent[0].count + n.adjacent[1].count);
    return n;
}

static void AddCost(qcNormalCandidate* candidate, qcSeparation separation, double weight)
{
    candidate->along += weight * qcPositive(separation.along);
    candidate->against += weight * qcPositive(separation.against);
}

/// Adds the pairs that are adjacent through the triangle of a side, whose heights are given.
static void AddAdjacent(const qcNeighbourhood* n, int side, qcHeightRange common, qcVector origin,
                        qcNormalCandidate* candidate)
{
    qcAdjacentPairs adjacent = n->adjacent[side];
    qcVector direction = candidate->normal;
    for (uint32_t i = 0; i < adjacent.count; i++)
    {
        const qcPairSide* other = qcPairAdjacency_Side(n->adjacency, adjacent.entries[i]);
        qcHeightRange h =
            side == candidate->face ? other->heights : qcManifoldTriangle_Heights(other->other, origin, direction);
        AddCost(candidate, side == 0 ? qcSeparation_Of(common, h) : qcSeparation_Of(h, common),
                (double)(adjacent.entries[i] & qc_sharedVertices));
    }
}

bool qcNeighbourhood_FindCost(const qcNeighbourhood* n, double limit, qcNormalCandidate* candidate)
{
    const qcManifoldPair* pair = n->pair;
    qcVector origin = pair->side[candidate->face == 0 ? 0 : 1]->corner[0];
    const qcHeightRange heights[2] = {qcManifoldTriangle_Heights(pair->side[0], origin, candidate->normal),
                                      qcManifoldTriangle_Heights(pair->side[1], origin, candidate->normal)};
    candidate->along = candidate->against = 0.0;
    candidate->separation = qcSeparation_Of(heights[0], heights[1]);
    AddCost(candidate, candidate->separation, s_ownWeight);
    // The side whose heights are stored comes first.
    int first = candidate->face == 1 ? 1 : 0;
    for (int k = 0; k < 2 && (candidate->along < limit || candidate->against < limit); k++)
    {
        int side = k == 0 ? first : 1 - first;
        AddAdjacent(n, side, heights[side], origin, candidate);
    }
    return candidate->along < limit || candidate->against < limit;
}

double qcContactInput_CornerLimit(const qcContactInput* input, const qcManifoldPair* pair)
{
    if (qcContactProximity_Region(input->proximity, pair)->ambiguous)
        return INFINITY;
    return qcManifoldPair_Limit(pair, input->margin);
}
