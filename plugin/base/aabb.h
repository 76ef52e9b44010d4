// Axis-aligned bounding boxes.
#ifndef QC_BASE_AABB_H
#define QC_BASE_AABB_H

#include <math.h>
#include <stddef.h>

/// Extends a box by vertices (three doubles each), all finite.
void qcBounds_Include(const double* positions, size_t vertexCount, double lower[3], double upper[3]);
/// Extends a box by vertices of three floats each.
void qcBounds_IncludeFloats(const float* positions, size_t vertexCount, double lower[3], double upper[3]);

/// The longest side of a box.
static inline double qcBounds_Widest(const double lower[3], const double upper[3])
{
    return fmax(upper[0] - lower[0], fmax(upper[1] - lower[1], upper[2] - lower[2]));
}

/// The box around a triangle.
static inline void qcBounds_OfTriangle(const double corners[3][3], double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        double x = corners[0][axis], y = corners[1][axis], z = corners[2][axis];
        double low = x < y ? x : y, high = x < y ? y : x;
        lower[axis] = z < low ? z : low;
        upper[axis] = z > high ? z : high;
    }
}

#endif
