// Axis-aligned bounding boxes: the lower and the upper corner. Where a lower coordinate exceeds the upper one the box
// is empty.
#ifndef QC_BASE_AABB_H
#define QC_BASE_AABB_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

typedef struct qcBounds
{
    double lower[3], upper[3];
} qcBounds;

/// Makes a box empty: extended by a finite box or point, it becomes that.
static inline void qcBounds_Clear(double lower[3], double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = DBL_MAX;
        upper[axis] = -DBL_MAX;
    }
}

/// Extends a box by another one.
static inline void qcBounds_IncludeBox(const double otherLower[3], const double otherUpper[3], double lower[3],
                                       double upper[3])
{
    for (int axis = 0; axis < 3; axis++)
    {
        lower[axis] = otherLower[axis] < lower[axis] ? otherLower[axis] : lower[axis];
        upper[axis] = otherUpper[axis] > upper[axis] ? otherUpper[axis] : upper[axis];
    }
}

/// Extends a box by a point.
static inline void qcBounds_IncludePoint(const double point[3], double lower[3], double upper[3])
{
    qcBounds_IncludeBox(point, point, lower, upper);
}

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

/// Whether two boxes overlap or touch.
static inline bool qcBounds_Overlap(const qcBounds* a, const qcBounds* b)
{
    // One branch instead of six: which comparison fails is unpredictable.
    return (a->lower[0] <= b->upper[0]) & (a->upper[0] >= b->lower[0]) & (a->lower[1] <= b->upper[1]) &
           (a->upper[1] >= b->lower[1]) & (a->lower[2] <= b->upper[2]) & (a->upper[2] >= b->lower[2]);
}

/// Whether along each axis two boxes are at most a distance apart.
static inline bool qcBounds_AreNear(const double lowerA[3], const double upperA[3], const double lowerB[3],
                                    const double upperB[3], double distance)
{
    bool near = true;
    for (int axis = 0; axis < 3; axis++)
        near = near && lowerA[axis] <= upperB[axis] + distance && lowerB[axis] <= upperA[axis] + distance;
    return near;
}

#endif
