// A surface after few of its vertices have moved: nothing is fitted anew but what they are corners of.
#ifndef QC_SWEEP_BVH_PARTIAL_REFIT_H
#define QC_SWEEP_BVH_PARTIAL_REFIT_H

#include "sweep/bvh/triangle_bvh.h"

/// How a vertex, or the one of a triangle's corners that went furthest, has moved since the surface was noted.
typedef enum qcMotionMark
{
    qc_markStill,
    qc_markMoved,
    qc_markFar ///< by more than was allowed; a bit that the others have not
} qcMotionMark;

/// Notes where the body is, which is where the surface is fitted.
qcStatus qcTriangleBvh_Note(qcTriangleBvh* surface, const qcBody* body);
/// What was noted no longer counts.
void qcTriangleBvh_Forget(qcTriangleBvh* surface);

/// Brings the surface to where the body is now, if it was noted since it was fitted, not many vertices have moved since
/// then, and all are still in its lattice; otherwise `follows` is false, and the surface is as it was. Boxes of what
/// moved are grown by where it is now, with the margin of the fit. Fills surface->placeMarks: by place, a qcMotionMark;
/// `far` is how far a vertex may move. O(vertices).
qcStatus qcTriangleBvh_Follow(qcTriangleBvh* surface, const qcBody* body, double far, const qcTriangleKernels* kernels,
                              qcBvhScratch* scratch, bool* follows);

#endif
