// Two BVHs at both ends of a motion, in common lattices with world axes. Proof: plugin/docs/proofs/motion_sweep.md.
#ifndef QC_SWEEP_BVH_MOTION_BVHS_H
#define QC_SWEEP_BVH_MOTION_BVHS_H

#include "sweep/bvh/triangle_bvh.h"

typedef struct qcBvhOfBody
{
    const qcTriangleBvh* bvh;
    const qcBody* body;
} qcBvhOfBody;

/// Fills both BVHs: in the lattice of the first if it is in world coordinates, otherwise in one around it. `isOne`:
/// both are the same. False: the transforms are too inexact for the filter of triangles.
bool qcMotionBvhs_Find(const qcBvhOfBody bvhs[2], bool isOne, qcMotionBvh motions[2]);

#endif
