// Some triangles of a mesh, and the box around most of them: without the outliers, which are few vertices far away from
// the others, and few triangles much larger than the others. (Trimmed range: Tukey, 1962.)
#ifndef QC_MESH_TRIANGLE_SAMPLE_H
#define QC_MESH_TRIANGLE_SAMPLE_H

#include "base/aabb.h"

#include <stdbool.h>
#include <stdint.h>

enum
{
    qc_maxSampled = 64 ///< triangles
};

/// Spread evenly over a mesh.
typedef struct qcTriangleSample
{
    uint32_t count;
    double corners[qc_maxSampled][3][3];
} qcTriangleSample;

/// Takes triangles at equal distances. `indices`: three a triangle; `positions`: three doubles a vertex.
void qcTriangleSample_Take(qcTriangleSample* sample, const uint32_t* indices, uint32_t triangleCount,
                           const double* positions);
/// The number of triangles to sample from so many. 0: outliers among so few cost little.
uint32_t qcTriangleSample_Count(uint32_t triangleCount);
/// The median of the triangles' longest sides, along an axis.
double qcTriangleSample_MedianSize(const qcTriangleSample* sample);

/// True if numbers that are spread over a box, 2^16 of them along an axis, are too coarse for triangles of this size.
static inline bool qcBounds_AreWide(const double lower[3], const double upper[3], double triangleSize)
{
    return qcBounds_Widest(lower, upper) > 0x1p15 * triangleSize;
}

/// Reduces the box around a mesh to one around most of its triangles. False: it is not wide for them, or most of them
/// are spread over it; the box is unchanged.
bool qcTriangleSample_Trim(const qcTriangleSample* sample, double lower[3], double upper[3]);

#endif
