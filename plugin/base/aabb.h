// The box around vertices.
#ifndef QC_BASE_AABB_H
#define QC_BASE_AABB_H

#include <stddef.h>

/// Widens a box, least and greatest of each coordinate, by vertices. All are finite.
void qcBounds_Include(const double* positions, size_t vertexCount, double lower[3], double upper[3]);

#endif
