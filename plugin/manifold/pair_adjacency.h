// Fourth stage: which unsettled pairs are adjacent. Two pairs are if they have one triangle in common and their other
// triangles share a vertex.
#ifndef QC_MANIFOLD_PAIR_ADJACENCY_H
#define QC_MANIFOLD_PAIR_ADJACENCY_H

#include "manifold/pair_proximity.h"

enum
{
    /// Previous and next pairs that are visited in the list of those of a triangle whose other triangle has a given
    /// vertex: enough for a fan of seventeen triangles, and a bound for one of a hundred thousand.
    qc_maxFanSteps = 8,
    /// Pairs adjacent through one of a pair's triangles: through each corner of the other.
    qc_maxAdjacentPairs = 3 * 2 * qc_maxFanSteps,
    /// An entry of a list of adjacent pairs: the number of a pair side times qc_sideStep, plus the number of shared
    /// vertices.
    qc_sideStep = 1 << 2,
    qc_sharedVertices = 3
};

/// One side of an unsettled pair: the pair as an entry of its triangle of this side. The adjacent pairs have this
/// triangle too.
typedef struct qcPairSide
{
    const qcManifoldTriangle* other; ///< the triangle of the other side
    qcHeightRange heights;           ///< of `other`, along the normal of this side's triangle, from its first corner
    double gap;                      ///< signed distance of the pair
    uint32_t pair;
    uint16_t worker; ///< whose list has the adjacent pairs
    uint8_t adjacentCount;
    uint64_t firstAdjacent; ///< in the worker's list
} qcPairSide;

/// The pair sides of a triangle, in the order of the pairs.
typedef struct qcSideRange
{
    uint32_t first, count;
} qcSideRange;

/// What one worker found, and its scratch.
typedef struct qcAdjacencyWorker
{
    qcWorkerResult result;
    qcArray adjacent;               ///< of uint32_t: see qc_sideStep
    qcArray fanOfVertex;            ///< of uint32_t, by vertex: the fan of the current triangle plus 1, or 0
    qcArray fans, fanLists, visits; ///< of the current triangle
} qcAdjacencyWorker;

typedef struct qcPairAdjacency
{
    qcArray sides;   ///< of qcPairSide, by triangle
    qcArray ranges;  ///< of qcSideRange, by triangle
    qcArray sideOf;  ///< of uint32_t, two a pair: the numbers of its sides; set where unsettled
    qcArray workers; ///< of qcAdjacencyWorker
} qcPairAdjacency;

/// Lists the adjacent pairs of each side of an unsettled pair, each once. In fans too large for
/// qc_maxFanSteps some are left out. In parallel.
qcStatus qcPairAdjacency_Find(const qcContactTopology* topology, const qcContactRegions* regions,
                              const qcContactProximity* proximity, uint32_t threads, qcPairAdjacency* adjacency);
void qcPairAdjacency_Free(qcPairAdjacency* adjacency);

typedef struct qcAdjacentPairs
{
    const uint32_t* entries; ///< see qc_sideStep
    uint32_t count;
} qcAdjacentPairs;

/// The pairs that have the pair's triangle of this side too.
static inline qcAdjacentPairs qcPairAdjacency_Of(const qcPairAdjacency* adjacency, uint32_t pair, int side)
{
    uint32_t number = QC_AT(uint32_t, adjacency->sideOf, 2 * (size_t)pair + (size_t)side);
    const qcPairSide* own = &QC_AT(qcPairSide, adjacency->sides, number);
    const qcArray* adjacent = &QC_AT(qcAdjacencyWorker, adjacency->workers, own->worker).adjacent;
    return (qcAdjacentPairs){(const uint32_t*)adjacent->data + own->firstAdjacent, own->adjacentCount};
}

/// The adjacent pair of an entry, as a side of the common triangle.
static inline const qcPairSide* qcPairAdjacency_Side(const qcPairAdjacency* adjacency, uint32_t entry)
{
    return &QC_AT(const qcPairSide, adjacency->sides, entry / qc_sideStep);
}

#endif
