// Motion of rigid bodies within a step, and bounds on it.
#ifndef QC_GLUE_COMMON_RIGID_MOTION_H
#define QC_GLUE_COMMON_RIGID_MOTION_H

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

/// Upper bound of the length of a chain of bodies that stop each other in a step.
constexpr int qcMaxStops = 16;

/// Velocities of the points of a rigid body.
struct qcRigidMotion
{
    btVector3 centre{0, 0, 0}, linear{0, 0, 0}, angular{0, 0, 0};

    /// At rest.
    qcRigidMotion() = default;
    /// The present velocities of a rigid body. Static objects, and objects of other types, are at rest.
    explicit qcRigidMotion(const btCollisionObject* object);

    btVector3 VelocityAt(const btVector3& point) const
    {
        return linear + angular.cross(point - centre);
    }

    /// Upper bound of the speed of points at most `radius` from the centre.
    btScalar MaxSpeed(btScalar radius) const
    {
        return linear.length() + angular.length() * radius;
    }
};

/// Upper bound of the speed at which points of two bodies pass each other, at most `radius` from a place.
inline btScalar qcMaxSpeedBetween(const qcRigidMotion& a, const qcRigidMotion& b, const btVector3& place,
                                  btScalar radius)
{
    return (a.VelocityAt(place) - b.VelocityAt(place)).length() + (a.angular - b.angular).length() * radius;
}

/// How far a point of a kinematic body recedes along a direction in the step; 0 for other objects, and beyond `limit`:
/// what is further away falls, or the body was put elsewhere. Bullet has moved such a body already, and its solver
/// moves it once more by its velocity: what lies on it would be in equilibrium that much deeper.
btScalar qcRecession(const btCollisionObject* object, const btVector3& point, const btVector3& direction,
                     btScalar timeStep, btScalar limit);

/// Where a part of an object starts the step that it ends at `end`, if that is a kinematic body, which Bullet has moved
/// already; `end` for other objects.
btTransform qcKinematicStart(const btCollisionObject& object, const btTransform& end, btScalar timeStep);

/// Upper bound of the displacement between two transforms of points at most `radius` from the body's origin.
btScalar qcDisplacementBound(const btTransform& from, const btTransform& to, btScalar radius);

/// Upper bound of the displacement in a step, relative to `meanMotion`, of an object's points at most `radius` from its
/// origin. At most `limit`, which is also the result if the motion is unknown.
btScalar qcMaxClosingDistance(const btCollisionObject* object, btScalar radius, btScalar timeStep, btScalar limit,
                              const qcRigidMotion& meanMotion);

#endif
