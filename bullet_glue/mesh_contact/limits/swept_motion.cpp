// Where an object is in a step.
#include "mesh_contact/limits/swept_motion.h"

#include <LinearMath/btTransformUtil.h>

btTransform qcSweptMotion::At(btScalar part) const
{
    if (part >= 1)
        return target;
    if (part <= 0)
        return carried;
    btVector3 axis;
    btScalar angle;
    btTransformUtil::calculateDiffAxisAngle(carried, target, axis, angle);
    btMatrix3x3 turn(btQuaternion(axis, part * angle));
    return btTransform(turn * carried.getBasis(), carried.getOrigin().lerp(target.getOrigin(), part));
}
