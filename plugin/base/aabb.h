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

#endif
