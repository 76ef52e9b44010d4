// The transform of a body of a qcScene where Bullet has an object.
#ifndef QC_DEMOS_COMMON_BULLET_BODY_TRANSFORM_H
#define QC_DEMOS_COMMON_BULLET_BODY_TRANSFORM_H

#include <quickcullide/quickcullide.h>

#include <LinearMath/btTransform.h>

inline qcTransform qcBodyTransformOf(const btTransform& place)
{
    qcTransform transform;
    for (int i = 0; i < 9; i++)
        transform.linear[i] = double(place.getBasis()[i / 3][i % 3]);
    for (int axis = 0; axis < 3; axis++)
        transform.translation[axis] = double(place.getOrigin()[axis]);
    return transform;
}

#endif
