// Motion of rigid bodies within a step, and bounds on it.
#include "common/rigid_motion.h"

#include "common/object_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

qcRigidMotion::qcRigidMotion(const btCollisionObject* object) : centre(object->getWorldTransform().getOrigin())
{
    const btRigidBody* body = btRigidBody::upcast(object);
    if (body != nullptr && !qcIsStatic(object))
    {
        linear = body->getLinearVelocity();
        angular = body->getAngularVelocity();
    }
}

btScalar qcRecession(const btCollisionObject* object, const btVector3& point, const btVector3& direction,
                     btScalar timeStep, btScalar limit)
{
    if (!object->isKinematicObject())
        return 0;
    const btScalar travel = qcRigidMotion(object).VelocityAt(point).dot(direction) * timeStep;
    return travel > 0 && travel <= limit ? travel : btScalar(0);
}

btTransform qcKinematicStart(const btCollisionObject& object, const btTransform& end, btScalar timeStep)
{
    if (!object.isKinematicObject())
        return end;
    const btTransform& place = object.getWorldTransform();
    const qcRigidMotion motion(&object);
    btTransform start;
    btTransformUtil::integrateTransform(place, -motion.linear, -motion.angular, timeStep, start);
    return &end == &place ? start : start * (place.inverse() * end);
}

btScalar qcDisplacementBound(const btTransform& from, const btTransform& to, btScalar radius)
{
    btScalar turn = 0;
    for (int row = 0; row < 3; row++)
    {
        const btVector3 &x = from.getBasis()[row], &y = to.getBasis()[row];
        turn +=
            (x.x() - y.x()) * (x.x() - y.x()) + (x.y() - y.y()) * (x.y() - y.y()) + (x.z() - y.z()) * (x.z() - y.z());
    }
    return from.getOrigin().distance(to.getOrigin()) + btSqrt(turn) * radius;
}

btScalar qcMaxClosingDistance(const btCollisionObject* object, btScalar radius, btScalar timeStep, btScalar limit,
                              const qcRigidMotion& meanMotion)
{
    const btRigidBody* body = btRigidBody::upcast(object);
    if (!qcIsStatic(object) && (body == nullptr || timeStep <= 0))
        return limit;
    qcRigidMotion motion(object);
    motion.linear -= meanMotion.VelocityAt(motion.centre);
    motion.angular -= meanMotion.angular;
    return std::min(limit, motion.MaxSpeed(radius) * timeStep);
}
