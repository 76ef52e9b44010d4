// The origin of a set's floats. Far from zero floats are coarse: at 1e8 they are 8 apart, a box of half a unit becomes
// a box of 8 or 16, and in a crowd nearly all overlap. Such a set takes its floats relative to a point among its boxes.
// Found boxes and pairs do not depend on the origin; the order of found boxes does.
#ifndef QC_BROADPHASE_BOX_ORIGIN_H
#define QC_BROADPHASE_BOX_ORIGIN_H

#include "base/aabb.h"
#include "broadphase/bvh_forest.h"

/// All zero: the floats of a box are its coordinates.
typedef struct qcBoxOrigin
{
    double at[3];
    bool isSet; ///< `at` is not zero
} qcBoxOrigin;

enum
{
    qc_originSample = 64
};

/// Makes a box of floats that contains a box minus the origin.
void qcBoxOrigin_EncloseFrom(const qcBoxOrigin* origin, qcFloatBox* box, const double lower[3], const double upper[3]);

/// Makes a box of floats that contains a box minus the origin. Returns whether it is known to equal the box itself:
/// never with an origin.
static inline bool qcBoxOrigin_Enclose(const qcBoxOrigin* origin, qcFloatBox* box, const double lower[3],
                                       const double upper[3])
{
    if (!origin->isSet)
        return qcFloatBox_Enclose(box, lower, upper);
    qcBoxOrigin_EncloseFrom(origin, box, lower, upper);
    return false;
}

/// Whether rounding adds half or more to the edges of a box. False for an infinite box, which no origin helps.
static inline bool qcFloatBox_IsCoarse(const qcFloatBox* box, const double lower[3], const double upper[3])
{
    double edges = 0.0, floatEdges = 0.0;
    for (int k = 0; k < 3; k++)
    {
        edges += upper[k] - lower[k];
        floatEdges += (double)box->upper[k] - (double)box->lower[k];
    }
    // False for NaN, the edge of a box at infinity. A point is coarse unless its floats are exact.
    return (edges < INFINITY) & (floatEdges > 1.5 * edges);
}

/// Moves the origin to the median of coarse boxes, if they are half of the sample or more, and if at most a quarter as
/// many are coarse there. Returns whether it moved. At most qc_originSample bounds.
bool qcBoxOrigin_Choose(qcBoxOrigin* origin, const qcBounds* sample, uint32_t count);

#endif
