// Directions for a pair: what one costs it and the pairs around it, and what its triangles have in common along one.
#ifndef QC_MANIFOLD_NORMAL_COST_H
#define QC_MANIFOLD_NORMAL_COST_H

#include "manifold/manifold_builder.h"

enum
{
    /// Free pairs at once; a block takes some 100 microseconds.
    qc_normalBlock = 128,
    qc_leastNormalBlocks = 4
};

/// Another direction must be cheaper by this factor, so that rounding never decides.
#define QC_CHEAPER 0.9

/// A pair with those beside it.
typedef struct qcNeighbourhood
{
    const qcManifoldBuilder* manifolds;
    const qcManifoldPair* pair;
    qcRing ring[2];  ///< by the side whose triangle is the common one
    double rounding; ///< of a cost
} qcNeighbourhood;

/// What a pair's triangles have in common, seen along a direction.
typedef struct qcLook
{
    int count; ///< below 0: not looked
    double low, high;
    qcRawPoint corners[qc_maxCommonCorners];
} qcLook;

/// A direction, and what it costs both ways.
typedef struct qcTrial
{
    qcVector normal;
    int face; ///< the side whose face's normal it is, or -1
    double along, against;
    qcWaysOut ways; ///< of the pair itself
    qcLook* look;   ///< along it, for whoever looks
} qcTrial;

/// What a pair has chosen.
typedef struct qcNormalChoice
{
    qcVector normal;
    double cost;
    //  Where triangles meet, and what is heard there:
    uint16_t news; ///< the round in which it took its direction from another one, from 1
    bool moved;    ///< it did
    bool apart;    ///< as qcManifoldPair's
    bool meets;    ///< its direction is that of triangles that meet
    bool firm;     ///< stands flat, or follows one that does
} qcNormalChoice;

static inline size_t qcNormalBlocks_Count(const qcManifoldBuilder* manifolds)
{
    return (manifolds->freePairs.count + qc_normalBlock - 1) / qc_normalBlock;
}

/// One past the last free pair of a block.
static inline size_t qcNormalBlocks_End(const qcManifoldBuilder* manifolds, size_t block)
{
    size_t end = (block + 1) * qc_normalBlock, count = manifolds->freePairs.count;
    return end < count ? end : count;
}

qcNeighbourhood qcNeighbourhood_Of(const qcManifoldBuilder* manifolds, uint32_t pair);
/// Going along a direction until the pair is free, or against it, how far do the pairs around it still overlap? The sum
/// of the ways out, in which a pair around counts by the vertices that it shares, and the pair itself six times.
/// False: neither way costs less than `limit`, however much is still to be added.
bool qcNeighbourhood_FindCost(const qcNeighbourhood* n, double limit, qcTrial* trial);

static inline double qcPositive(double x)
{
    return x > 0.0 ? x : 0.0;
}

/// A cost must be below this to be cheaper than the best.
static inline double qcNeighbourhood_Limit(const qcNeighbourhood* n, double best)
{
    return QC_CHEAPER * best - n->rounding;
}

/// Once.
void qcLook_Along(const qcManifoldBuilder* manifolds, const qcManifoldPair* pair, qcVector normal, qcLook* look);
/// Keeps the corners of a look that can become points, in the worker's list, which has room for them. If the normal may
/// be turned around still, all of them. `opposite`: the look was along the opposite of the normal.
void qcManifoldBuilder_KeepCorners(qcManifoldBuilder* manifolds, uint32_t pair, uint32_t worker, const qcLook* look,
                                   qcVector normal, bool opposite, double margin);

/// Where triangles meet, the pair's own look says little: those around are heard. In parallel.
qcStatus qcManifoldBuilder_FollowNeighbours(qcManifoldBuilder* manifolds, double margin, uint32_t threads);

#endif
