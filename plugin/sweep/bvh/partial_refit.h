// Refits a BVH after few of its vertices have moved: only boxes around those vertices grow.
#ifndef QC_SWEEP_BVH_PARTIAL_REFIT_H
#define QC_SWEEP_BVH_PARTIAL_REFIT_H

#include "sweep/bvh/body_bvh.h"

/// Brings the BVH to the body's current positions if it has a Verlet reference, at most an eighth of its vertices have
/// moved since then, and all are still within the lattice. Otherwise `refitted` is false and the BVH is unchanged.
/// Boxes around moved vertices are enlarged, with the margin of the last fit. Fills the motion flags of the reference;
/// motion above `maxMotion` is large. O(vertices).
qcStatus qcBodyBvh_PartialRefit(qcBodyBvh* bodyBvh, const qcBody* body, double maxMotion,
                                const qcTriangleKernels* kernels, qcBvhScratch* scratch, bool* refitted);

#endif
