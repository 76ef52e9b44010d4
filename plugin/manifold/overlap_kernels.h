// Kernels of the projected overlap, and of distances: compiled once for each instruction set and chosen at run time.
// The result does not depend on the instruction set: the operations are the same, side by side, and none is fused.
#ifndef QC_MANIFOLD_OVERLAP_KERNELS_H
#define QC_MANIFOLD_OVERLAP_KERNELS_H

#include "manifold/projected_overlap.h"

enum
{
    qc_overlapLanes = 4, ///< of a triangle's corners or edges; the fourth is the first again
    qc_distanceLanes = 8 ///< pairs of a qcDistanceBatch
};

/// Pairs of triangles: by side, corner, axis and pair.
typedef struct qcDistanceBatch
{
    float corner[2][3][3][qc_distanceLanes];
} qcDistanceBatch;

/// A triangle seen along a direction: the data that does not depend on the other triangle, computed at first use.
typedef struct qcTriangleView
{
    const qcManifoldTriangle* triangle;
    uint32_t region; ///< where views are cached: the region whose normal is the direction
    bool hasEdges, hasFace;
    //  by axis, then by lane:
    double edge[3][qc_overlapLanes];        ///< edge e: from corner e to the next
    double edgeNormal[3][qc_overlapLanes];  ///< edge x direction
    double oppositeHeight[qc_overlapLanes]; ///< along edgeNormal, from edge e: the corner opposite to it
    qcVector face;                          ///< the triangle's normal, not of unit length
    double facing;                          ///< face . direction
} qcTriangleView;

static inline void qcTriangleView_Begin(qcTriangleView* view, const qcManifoldTriangle* triangle)
{
    view->triangle = triangle;
    view->hasEdges = view->hasFace = false;
}

struct qcOverlapKernels
{
    /// Corners of the projected overlap of two triangles along a direction, with their signed distances. Returns their
    /// number; 0 where the projections are disjoint. Along the opposite direction the distances are opposite, and all
    /// else is equal. The views are of the two sides, along this direction.
    int (*findOverlap)(const qcManifoldPair* pair, qcVector direction, qcTriangleView* views[2],
                       qcRawPoint corners[qc_maxOverlapCorners]);
    /// The shortest difference of each pair, from triangle 1 to triangle 0, and its squared length: that of two of
    /// their points, up to rounding the closest ones. Infinity: coordinates are too large.
    void (*findDistances)(const qcDistanceBatch* batch, float difference[3][qc_distanceLanes],
                          float length2[qc_distanceLanes]);
};

extern const qcOverlapKernels qcOverlapKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcOverlapKernels qcOverlapKernels_avx2;
#endif

/// The best that this machine runs. The environment's QC_KERNELS (plain, avx2) names another.
const qcOverlapKernels* qcOverlapKernels_Get(void);

#endif
