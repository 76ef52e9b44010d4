// Closest points of vertices, edges, faces and triangles in double precision, and the frame of a pair of triangles, in
// which nothing overflows or underflows. Accuracy: plugin/docs/proofs/closest_points.md.
#ifndef QC_TRIANGLE_CLOSEST_POINTS_H
#define QC_TRIANGLE_CLOSEST_POINTS_H

#include "base/vec3.h"

#include <stdbool.h>

/// Parameter of the point of segment p-q closest to x, within 0..1.
double qcClosest_OnSegment(qcVector p, qcVector q, qcVector x);

/// Weights, none negative, of the corners at the point of a triangle closest to x.
void qcClosest_OnTriangle(const qcVector corner[3], qcVector x, double weights[3]);

/// Parameters, within 0..1, of closest points of the segments p-q and r-s. If both are strictly inside, they are the
/// closest points of the lines. For segments that are parallel within rounding one of them is at an end.
void qcClosest_OfSegments(qcVector p, qcVector q, qcVector r, qcVector s, double* t, double* u);

/// The vector from the closest point of a triangle to x.
qcVector qcClosest_FromTriangle(const qcVector corner[3], qcVector x);

/// The vector from the closest point of the segment r-s to that of p-q.
qcVector qcClosest_FromSegment(qcVector p, qcVector q, qcVector r, qcVector s);

/// Two triangles, translated so that the first corner of A is the origin, and scaled by a power of two so that the
/// largest coordinate is within [1, 2) (all are 0 if all corners coincide). The relative error of each coordinate is at
/// most 2^-53, at any distance from the origin of the world.
typedef struct qcPairFrame
{
    qcVector a[3], b[3];
    /// World = origin + 2^exponent * local.
    const double* origin;
    int exponent;
    double factors[2]; ///< their product is 2^-exponent, which may exceed the range of double
} qcPairFrame;

/// Points to `a`.
void qcPairFrame_Set(qcPairFrame* frame, const double a[3][3], const double b[3][3]);

/// A length of the world in the frame. Exact unless the result is below 2^-1022 or overflows.
static inline double qcPairFrame_Length(const qcPairFrame* frame, double length)
{
    return length * frame->factors[0] * frame->factors[1];
}

typedef struct qcClosestPoints
{
    double weightsA[3], weightsB[3]; ///< none negative
    qcVector difference;             ///< from B's point to A's
} qcClosestPoints;

/// The closest points of two disjoint triangles in their frame. For intersecting triangles: some points of each.
void qcClosest_OfTriangles(const qcVector a[3], const qcVector b[3], qcClosestPoints* closest);

#endif
