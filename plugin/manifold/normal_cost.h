// The cost of a candidate normal: how far a pair and those adjacent to it overlap along it.
#ifndef QC_MANIFOLD_NORMAL_COST_H
#define QC_MANIFOLD_NORMAL_COST_H

#include "manifold/normals.h"

enum
{
    /// Unsettled pairs at once; a block takes some 20 microseconds.
    qc_normalBlock = 32,
    qc_minNormalBlocks = 16
};

/// Another normal must be cheaper by this factor, so that rounding never decides.
#define QC_CHEAPER 0.9

/// A pair with those adjacent to it.
typedef struct qcNeighbourhood
{
    const qcManifoldPair* pair;
    const qcPairProximity* proximity;
    const qcPairAdjacency* adjacency;
    qcAdjacentPairs adjacent[2]; ///< by the side whose triangle is the common one
    double rounding;             ///< of a cost
} qcNeighbourhood;

/// A candidate normal, with the costs of both directions.
typedef struct qcNormalCandidate
{
    qcVector normal;
    int face; ///< the side whose face's normal it is, or -1
    double along, against;
    qcSeparation separation;     ///< of the pair itself
    qcProjectedOverlap* overlap; ///< along the normal; computed where it is needed
} qcNormalCandidate;

static inline size_t qcNormalBlocks_Count(const qcContactInput* input)
{
    return (input->regions->unsettledPairs.count + qc_normalBlock - 1) / qc_normalBlock;
}

/// One past the last unsettled pair of a block.
static inline size_t qcNormalBlocks_End(const qcContactInput* input, size_t block)
{
    size_t end = (block + 1) * qc_normalBlock, count = input->regions->unsettledPairs.count;
    return end < count ? end : count;
}

qcNeighbourhood qcNeighbourhood_Of(const qcContactInput* input, uint32_t pair);
/// Computes the costs of a candidate and of its opposite: the weighted sum of the separation distances of the pair and
/// of the adjacent pairs, negative ones taken as 0. The pair itself has weight six, an adjacent pair the number of
/// vertices that it shares. False: neither direction costs less than `limit`; the costs may then be incomplete.
bool qcNeighbourhood_FindCost(const qcNeighbourhood* n, double limit, qcNormalCandidate* candidate);

static inline double qcPositive(double x)
{
    return x > 0.0 ? x : 0.0;
}

/// A cost must be below this to be cheaper than the best.
static inline double qcNeighbourhood_Limit(const qcNeighbourhood* n, double best)
{
    return QC_CHEAPER * best - n->rounding;
}

/// Max distance of the corners of a pair's overlap that are kept. Infinity where the orientation may reverse the
/// normal.
double qcContactInput_CornerLimit(const qcContactInput* input, const qcManifoldPair* pair);

#endif
