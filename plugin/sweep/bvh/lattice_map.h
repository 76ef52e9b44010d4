// How boxes and points of one BVH are transformed to the lattice and the frame of another, with bounds for all
// rounding.
#ifndef QC_SWEEP_BVH_LATTICE_MAP_H
#define QC_SWEEP_BVH_LATTICE_MAP_H

#include "base/rigid_transform.h"
#include "kernels/triangle_kernels.h"

/// The transforms from one BVH's lattice and frame to those of another one.
typedef struct qcLatticeMap
{
    const qcLatticeTransform *to, *from;
    const qcRelativeTransform* relative;
    double fromPointError;
    bool rounds;     ///< false: both BVHs are in world coordinates, which are compared unchanged
    double query;    ///< boxes and points grow by it, points also where nothing is local
    bool growsBoxes; ///< world boxes include the margin. Local ones don't
    qcTransformedBvh* transformed;
    qcDistanceThresholds* thresholds;
} qcLatticeMap;

/// Fills the transforms. False: they are too inexact for the filter of triangles.
bool qcLatticeMap_Find(const qcLatticeMap* map);

#endif
