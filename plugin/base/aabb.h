// The axis-aligned bounding box of vertices.
#ifndef QC_BASE_AABB_H
#define QC_BASE_AABB_H

#include <stddef.h>

/// Extends a box by vertices (three doubles each), all finite.
void qcBounds_Include(const double* positions, size_t vertexCount, double lower[3], double upper[3]);
/// Extends a box by vertices of three floats each.
void qcBounds_IncludeFloats(const float* positions, size_t vertexCount, double lower[3], double upper[3]);

#endif
