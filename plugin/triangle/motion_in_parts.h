// Separation over a linear motion, part by part: where no fixed direction separates two triangles all the way, each
// half of the motion may have one of its own. Proof: plugin/docs/proofs/motion_in_parts.md.
#ifndef QC_TRIANGLE_MOTION_IN_PARTS_H
#define QC_TRIANGLE_MOTION_IN_PARTS_H

#include "triangle/motion_certificate.h"

/// True if the triangles are proven to have no common point at any time of the motion: by one direction, or by one for
/// each half, quarter, eighth or sixteenth. False proves nothing. O(1).
bool qcMotion_StaysApart(const qcMovingTriangle* a, const qcMovingTriangle* b);

#endif
