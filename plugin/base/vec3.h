// Vectors of three doubles.
#ifndef QC_BASE_VEC3_H
#define QC_BASE_VEC3_H

#include "base/scalar.h"

typedef struct qcVector
{
    double x, y, z;
} qcVector;

static inline qcVector qcVector_Load(const double* p)
{
    return (qcVector){p[0], p[1], p[2]};
}

static inline qcVector qcMinus(qcVector a, qcVector b)
{
    return (qcVector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline qcVector qcNegated(qcVector v)
{
    return (qcVector){-v.x, -v.y, -v.z};
}

/// a + s b
static inline qcVector qcPlusScaled(qcVector a, qcVector b, double s)
{
    return (qcVector){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static inline double qcDot(qcVector a, qcVector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline qcVector qcCross(qcVector a, qcVector b)
{
    return (qcVector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

#endif
