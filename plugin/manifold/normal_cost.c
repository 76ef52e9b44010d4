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

/// The costs of both directions: along, against.
static qcTwoDoubles PlusCost(qcTwoDoubles costs, qcSeparation separation, double weight)
{
    // Without branches: which distances are negative can't be predicted.
    const qcTwoDoubles distances = {separation.along, separation.against};
    return costs + qcTwoDoubles_Both(weight) * qcTwoDoubles_Max(distances, qcTwoDoubles_Both(0.0));
}

/// Adds the pairs that are adjacent through the triangle of a side, whose heights are given.
static qcTwoDoubles PlusAdjacent(const qcNeighbourhood* n, int side, qcHeightRange common, qcVector origin,
                                 const qcNormalCandidate* candidate, qcTwoDoubles costs)
{
    const qcAdjacentPairs adjacent = n->adjacent[side];
    const qcVector direction = candidate->normal;
    const bool areStored = side == candidate->face;
    for (uint32_t i = 0; i < adjacent.count; i++)
    {
        const qcPairSide* other = qcPairAdjacency_Side(n->adjacency, adjacent.entries[i]);
        qcHeightRange h = areStored ? other->heights : qcManifoldTriangle_Heights(other->other, origin, direction);
        costs = PlusCost(costs, side == 0 ? qcSeparation_Of(common, h) : qcSeparation_Of(h, common),
                         (double)(adjacent.entries[i] & qc_sharedVertices));
    }
    return costs;
}

static bool IsEitherBelow(qcTwoDoubles costs, double limit)
{
    return costs[0] < limit || costs[1] < limit;
}

bool qcNeighbourhood_FindCost(const qcNeighbourhood* n, double limit, qcNormalCandidate* candidate)
{
    const qcManifoldPair* pair = n->pair;
    qcVector origin = pair->side[candidate->face == 0 ? 0 : 1]->corner[0];
    const qcHeightRange heights[2] = {qcManifoldTriangle_Heights(pair->side[0], origin, candidate->normal),
                                      qcManifoldTriangle_Heights(pair->side[1], origin, candidate->normal)};
    candidate->separation = qcSeparation_Of(heights[0], heights[1]);
    qcTwoDoubles costs = PlusCost(qcTwoDoubles_Both(0.0), candidate->separation, s_ownWeight);
    // The side whose heights are stored comes first.
    int first = candidate->face == 1 ? 1 : 0;
    for (int k = 0; k < 2 && IsEitherBelow(costs, limit); k++)
    {
        int side = k == 0 ? first : 1 - first;
        costs = PlusAdjacent(n, side, heights[side], origin, candidate, costs);
    }
    candidate->along = costs[0];
    candidate->against = costs[1];
    return IsEitherBelow(costs, limit);
}

double qcContactInput_CornerLimit(const qcContactInput* input, const qcManifoldPair* pair)
{
    if (qcContactProximity_Region(input->proximity, pair)->ambiguous)
        return INFINITY;
    return qcManifoldPair_Limit(pair, input->margin);
}
