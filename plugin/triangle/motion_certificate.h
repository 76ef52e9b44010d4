// Separation over a linear motion: one direction that separates two triangles at the start and at the end separates
// them at every time between. Proof and rounding: plugin/docs/proofs/motion_certificate.md.
#ifndef QC_TRIANGLE_MOTION_CERTIFICATE_H
#define QC_TRIANGLE_MOTION_CERTIFICATE_H

#include <stdbool.h>
#include <stdint.h>

/// Corners of a triangle at the start and at the end of a linear motion. Equal corners make it a segment or a point.
typedef struct qcMovingTriangle
{
    double start[3][3], end[3][3];
} qcMovingTriangle;

/// True if the boxes are apart along one axis, in the same order at both ends. Exact. `direction`: see
/// qcMotion_Separates.
bool qcMotion_BoxesSeparate(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3]);

/// True if a direction is found, and proven, that separates the triangles at both ends. False proves nothing. Fills
/// `direction` (may be null), of any length, from B towards A. O(1).
bool qcMotion_Separates(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3]);

/// Likewise, for triangles that qcMotion_BoxesSeparate does not prove apart.
bool qcMotion_FindDirection(const qcMovingTriangle* a, const qcMovingTriangle* b, double direction[3]);

/// True if two triangles with common corners, whose positions are equal at both ends, are proven to have no other
/// common point. `indicesA`, `indicesB`: the corners' vertex indices.
bool qcMotion_SeparatesNeighbours(const qcMovingTriangle* a, const uint32_t indicesA[3], const qcMovingTriangle* b,
                                  const uint32_t indicesB[3]);

#endif
