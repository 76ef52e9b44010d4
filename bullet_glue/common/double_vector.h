// Vectors in double precision, whatever Bullet's is.
#ifndef QC_GLUE_COMMON_DOUBLE_VECTOR_H
#define QC_GLUE_COMMON_DOUBLE_VECTOR_H

#include <LinearMath/btVector3.h>

#include <array>

using qcDoubleVector = std::array<double, 3>;

inline qcDoubleVector qcDoubleVectorOf(const btVector3& v)
{
    return {double(v.x()), double(v.y()), double(v.z())};
}

inline qcDoubleVector qcMinus(const qcDoubleVector& a, const qcDoubleVector& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

inline double qcDotOf(const qcDoubleVector& a, const qcDoubleVector& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline qcDoubleVector qcCrossOf(const qcDoubleVector& a, const qcDoubleVector& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

#endif
