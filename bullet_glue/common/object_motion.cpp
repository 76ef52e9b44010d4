// Objects that the application gives another transform between steps: they move there, or are put elsewhere.
#include "common/object_motion.h"

#include "common/finite.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <cmath>

namespace
{
// Substeps of a call of stepSimulation.
constexpr btScalar s_maxSteps = 64;
} // namespace

bool qcIsFinite(const btCollisionObject& object)
{
    const btRigidBody* body = btRigidBody::upcast(&object);
    return qcIsFinite(object.getWorldTransform()) &&
           (body == nullptr || (qcIsFinite(body->getLinearVelocity()) && qcIsFinite(body->getAngularVelocity())));
}

btScalar qcHalfSize(const btCollisionShape* shape)
{
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    return (upper - lower).length() / 2;
}

btScalar qcMaxDisplacement(const btCollisionShape* shape, const btTransform& from, const btTransform& to)
{
    // A corner of the box moves furthest: the difference of two transforms is affine.
    btVector3 box[2];
    shape->getAabb(btTransform::getIdentity(), box[0], box[1]);
    btScalar largest = 0;
    for (int corner = 0; corner < 8; corner++)
    {
        btVector3 point(box[corner & 1].x(), box[corner >> 1 & 1].y(), box[corner >> 2].z());
        btScalar squared = (from * point).distance2(to * point);
        if (std::isnan(squared))
            return squared;
        largest = std::max(largest, squared);
    }
    return btSqrt(largest);
}

bool qcIsMotion(const btCollisionObject* object, const btTransform& from, const btTransform& to,
                const btVector3& previous, btScalar timeStep)
{
    const btCollisionShape* shape = object->getCollisionShape();
    btScalar half = qcHalfSize(shape);
    if (qcMaxDisplacement(shape, from, to) <= half)
        return true;
    const btRigidBody* body = btRigidBody::upcast(object);
    bool hasVelocity = body != nullptr && body->isKinematicObject() && body->isActive();
    btVector3 step = hasVelocity ? body->getLinearVelocity() * timeStep : previous;
    btVector3 moved = to.getOrigin() - from.getOrigin();
    btScalar steps = std::round(moved.dot(step) / step.length2());
    return steps >= 1 && steps <= s_maxSteps && (moved - step * steps).length() <= half;
}

bool qcIsIntegrated(const btRigidBody& body, const btTransform& from, const btTransform& to, btScalar timeStep)
{
    const btScalar half = qcHalfSize(body.getCollisionShape());
    if (qcMaxDisplacement(body.getCollisionShape(), from, to) <= half)
        return true;
    const btVector3 moved = to.getOrigin() - from.getOrigin();
    auto isAlong = [&](const btVector3& velocity)
    {
        const btVector3 motion = velocity * timeStep;
        const btScalar length2 = motion.length2();
        const btScalar part = length2 > 0 ? btClamped(moved.dot(motion) / length2, btScalar(0), btScalar(1)) : 0;
        return moved.distance(motion * part) <= half;
    };
    return isAlong(body.getLinearVelocity()) || isAlong(body.getInterpolationLinearVelocity());
}
