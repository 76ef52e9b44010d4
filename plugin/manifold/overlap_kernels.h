// What two triangles have in common, seen along a direction: compiled once for each instruction set and chosen at run
// time. What is found does not depend on the instruction set: the same operations, side by side, and none is fused.
#ifndef QC_MANIFOLD_OVERLAP_KERNELS_H
#define QC_MANIFOLD_OVERLAP_KERNELS_H

#include "manifold/manifold_builder.h"

enum
{
    qc_overlapLanes = 4 ///< of a triangle's corners or edges; the fourth is the first again
};

/// A triangle seen along a direction: what is the same whatever the other one is, filled as far as somebody asked.
typedef struct qcTriangleView
{
    const qcManifoldTriangle* triangle;
    uint32_t region; ///< whose normal the direction is, for whoever keeps views
    bool hasEdges, hasFace;
    //  by axis, then by lane:
    double edge[3][qc_overlapLanes];   ///< edge e: from corner e to the next
    double across[3][qc_overlapLanes]; ///< an edge x the direction
    double inner[qc_overlapLanes];     ///< across edge e, from it: the corner that it lacks
    qcVector face;                     ///< its normal, not of unit length
    double facing;                     ///< that along the direction
} qcTriangleView;

static inline void qcTriangleView_Begin(qcTriangleView* view, const qcManifoldTriangle* triangle)
{
    view->triangle = triangle;
    view->hasEdges = view->hasFace = false;
}

struct qcOverlapKernels
{
    /// Corners of what the two triangles have in common seen along a direction, with their gaps; none where they lie
    /// beside each other. Returns their number. Along the opposite direction the gaps are opposite, and all else is the
    /// same. The views are of the two sides, along this direction.
    int (*findCommonPart)(const qcManifoldPair* pair, qcVector normal, qcTriangleView* views[2],
                          qcRawPoint corners[qc_maxCommonCorners]);
};

extern const qcOverlapKernels qcOverlapKernels_scalar;
#ifdef QC_KERNELS_X86
extern const qcOverlapKernels qcOverlapKernels_avx2;
#endif

/// The best that this machine runs. The environment's QC_KERNELS (plain, avx2) names another.
const qcOverlapKernels* qcOverlapKernels_Get(void);

#endif
