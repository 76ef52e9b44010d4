// Bodies that are copies of each other: the cluster order of one suits the others.
#ifndef QC_SWEEP_BVH_BVH_COPY_H
#define QC_SWEEP_BVH_BVH_COPY_H

#include "sweep/bvh/triangle_bvh.h"

/// Equal for bodies whose triangles connect the same vertices; bodies of other triangles rarely have the same one.
/// O(1).
uint64_t qcBvhCopy_KeyOf(const qcBody* body);

/// True if the triangles of two bodies connect the same vertices, and the clusters of the first one's BVH are about as
/// compact in the second one. Positions only have to be those of some step. O(triangles), at the speed of memory.
bool qcBvhCopy_Suits(const qcTriangleBvh* bvh, const qcBody* body, const qcBody* copy);

#endif
