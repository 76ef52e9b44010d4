// Pairs of triangles whose boxes overlap and that no axis separates: of a surface with itself, or of two.
#ifndef QC_SWEEP_BVH_BVH_PAIRS_H
#define QC_SWEEP_BVH_BVH_PAIRS_H

#include "sweep/bvh/triangle_bvh.h"

enum
{
    // A worker's queue is filtered when it holds so many pairs: 16 KiB, and the room that two nodes may need.
    qc_queueFull = 2048
};

/// Pairs of places, in no order but that those come first whose relation is known: `a` of the first surface, `b` of the
/// second.
typedef struct qcFoundPairs
{
    qcPlacePair* pairs;
    /// In this order: those that are apart by no more than the margin that is told, those that are apart by more, those
    /// that penetrate.
    size_t near, apart, penetrating;
    size_t count; ///< in all
} qcFoundPairs;

/// Through the kernels: what is surely apart goes, what is known comes first. `found` has its pairs, in no order.
void qcFoundPairs_Filter(qcFoundPairs* found, const qcSurfaceKernels* kernels, const qcFilterSide sides[2],
                         const qcFilterBound* bound);

/// The bound for pairs of a surface with itself: what is no further apart than `nearest` is near, what is by more than
/// `margin` is too far.
qcFilterBound qcSurface_FindBound(const qcSurface* surface, double margin, double nearest);

/// Takes what has been found. False: no more is wanted.
typedef bool qcSurfacePairsFunction(void* context, const qcFoundPairs* found, uint32_t worker);

typedef struct qcSurfacePairsJob
{
    const qcSurfaceKernels* kernels;
    const qcSurface *a, *b; ///< the same: pairs within it, each once
    const qcBody *bodyA, *bodyB;
    double margin;                ///< no more than both were fitted with
    double nearest;               ///< pairs that are apart by no more than this are near
    bool neighbours;              ///< of one surface: pairs that share a vertex index are found too
    bool flatDiscs;               ///< of one surface: what qcSurface_FindFlat found is made use of
    uint8_t *reachedA, *reachedB; ///< by node: set where it was compared with a node of the other. May be null
    qcSurfacePairsFunction* function;
    void* context;
} qcSurfacePairsJob;

/// Memory that is kept between steps.
typedef struct qcSurfacePairs
{
    qcArray searches; ///< of Search: one for each job
    qcArray items;    ///< of Item: pairs of groups, of all searches
    qcArray queues;   ///< of qcPlacePair, room for each worker
} qcSurfacePairs;

/// Does all jobs, side by side. The surfaces of each have been fitted, with the same margin, and that of the pairs is
/// no more.
qcStatus qcSurfacePairs_Find(qcSurfacePairs* pairs, const qcSurfacePairsJob* jobs, size_t jobCount, uint32_t threads);
void qcSurfacePairs_Free(qcSurfacePairs* pairs);

#endif
