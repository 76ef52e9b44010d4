// Whether coordinates are finite.
#ifndef QC_GLUE_COMMON_FINITE_H
#define QC_GLUE_COMMON_FINITE_H

#include <LinearMath/btTransform.h>

#include <cmath>

inline bool qcIsFinite(const btVector3& v)
{
    return std::isfinite(v.x()) && std::isfinite(v.y()) && std::isfinite(v.z());
}

inline bool qcIsFinite(const btTransform& transform)
{
    const btMatrix3x3& basis = transform.getBasis();
    return qcIsFinite(transform.getOrigin()) && qcIsFinite(basis[0]) && qcIsFinite(basis[1]) && qcIsFinite(basis[2]);
}

#endif
