// Closest points, distance, depth and direction of two triangles, rounded in double.
#ifndef QC_TRIANGLE_PROXIMITY_H
#define QC_TRIANGLE_PROXIMITY_H

#include "quickcullide/scene.h"

/// The features that the closest points of a pair lie on: for each triangle the corners that span it, bit c for corner
/// c.
typedef struct qcClosestFeatures
{
    uint8_t corners[2];
} qcClosestFeatures;

/// `relation` is the result of qcExact_Relate or qcExact_Within; disjoint is treated as near. `features` are those of
/// the closest points.
void qcProximity_Of(const double a[3][3], const double b[3][3], qcRelation relation, qcProximity* proximity,
                    qcClosestFeatures* features);

#endif
