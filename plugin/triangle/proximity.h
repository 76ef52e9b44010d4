// Closest points, distance, depth and direction of two triangles, rounded in double.
#ifndef QC_TRIANGLE_PROXIMITY_H
#define QC_TRIANGLE_PROXIMITY_H

#include "quickcullide/scene.h"

/// Of the closest points of a pair: between which corners of its triangle each lies; bit c: corner c.
typedef struct qcClosestFeatures
{
    uint8_t corners[2];
} qcClosestFeatures;

/// `relation` is what qcExact_Relate or qcExact_Within says; any but disjoint, which counts as near.
void qcProximity_Of(const double a[3][3], const double b[3][3], qcRelation relation, qcProximity* proximity,
                    qcClosestFeatures* feet);

#endif
