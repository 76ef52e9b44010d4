// The projected overlap of a pair: the intersection of the projections of its two triangles along a direction, a convex
// polygon whose corners are its possible contact points. The stages of normals fill a list of them, those of points
// read it.
#ifndef QC_MANIFOLD_PROJECTED_OVERLAP_H
#define QC_MANIFOLD_PROJECTED_OVERLAP_H

#include "manifold/topology.h"
#include "base/worker_results.h"

enum
{
    /// Six vertices over a face, nine crossings of edges.
    qc_maxOverlapCorners = 15
};

/// See manifold/overlap_kernels.h.
typedef struct qcOverlapKernels qcOverlapKernels;

/// A possible contact point of one pair.
typedef struct qcRawPoint
{
    qcVector end[2];
    qcVector normal;
    double distance;
    uint32_t pair;
    uint32_t feature[2][2]; ///< see qcManifoldPoint
} qcRawPoint;

/// The projected overlap of one pair along one direction.
typedef struct qcProjectedOverlap
{
    int count;        ///< of the corners; below 0: not computed
    double low, high; ///< the smallest and the largest distance of a corner
    qcRawPoint corners[qc_maxOverlapCorners];
} qcProjectedOverlap;

/// Returns the number of corners: see qcOverlapKernels.
int qcProjectedOverlap_FindCorners(const qcOverlapKernels* kernels, const qcManifoldPair* pair, qcVector direction,
                                   qcRawPoint corners[qc_maxOverlapCorners]);
/// Does nothing if the overlap has been computed.
void qcProjectedOverlap_Compute(const qcOverlapKernels* kernels, const qcManifoldPair* pair, qcVector direction,
                                qcProjectedOverlap* overlap);
/// True if the corners of the pair's overlap span an area: see QC_MANIFOLD_AREA.
bool qcProjectedOverlap_IsArea(const qcManifoldPair* pair, const qcRawPoint* corners, int count);

//  ---- of all pairs ----------------------------------------------------------------------------------------

/// Where the corners of a pair are.
typedef struct qcCornerRange
{
    uint64_t first;
    uint16_t worker;
    uint8_t count;
} qcCornerRange;

/// What one worker found.
typedef struct qcOverlapWorker
{
    qcWorkerResult result;
    qcArray corners; ///< of qcRawPoint
    qcArray views;   ///< of qcTriangleView: scratch of the contact points
    bool changed;    ///< scratch of the propagation: a normal has changed in this round
} qcOverlapWorker;

typedef struct qcPairOverlaps
{
    qcArray ranges;  ///< of qcCornerRange, one a pair
    qcArray workers; ///< of qcOverlapWorker
} qcPairOverlaps;

/// Empties the lists of at least `threads` workers.
qcStatus qcPairOverlaps_Begin(uint32_t threads, qcPairOverlaps* overlaps);
/// Makes room for `count` more corners in a worker's list. False: this worker has failed, now or earlier.
bool qcPairOverlaps_Reserve(qcPairOverlaps* overlaps, uint32_t worker, size_t count);
/// The first failure among the workers.
qcStatus qcPairOverlaps_Status(const qcPairOverlaps* overlaps);
/// Appends the corners at distances up to `limit` to the worker's list, which has room, in place of those that the pair
/// had. `opposite`: the overlap was computed along the opposite of the normal.
void qcPairOverlaps_Set(qcPairOverlaps* overlaps, uint32_t pair, uint32_t worker, const qcProjectedOverlap* overlap,
                        qcVector normal, bool opposite, double limit);
void qcPairOverlaps_Free(qcPairOverlaps* overlaps);

static inline qcOverlapWorker* qcPairOverlaps_Worker(const qcPairOverlaps* overlaps, uint32_t worker)
{
    return &QC_AT(qcOverlapWorker, overlaps->workers, worker);
}

static inline qcRawPoint* qcPairOverlaps_Corners(const qcPairOverlaps* overlaps, uint32_t pair)
{
    const qcCornerRange* range = &QC_AT(qcCornerRange, overlaps->ranges, pair);
    return &QC_AT(qcRawPoint, qcPairOverlaps_Worker(overlaps, range->worker)->corners, range->first);
}

static inline int qcPairOverlaps_Count(const qcPairOverlaps* overlaps, uint32_t pair)
{
    return QC_AT(qcCornerRange, overlaps->ranges, pair).count;
}

#endif
