// Objects that the application gives another transform between steps: they move there, or are put elsewhere.
#ifndef QC_GLUE_COMMON_OBJECT_MOTION_H
#define QC_GLUE_COMMON_OBJECT_MOTION_H

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

class btRigidBody;

/// True if the object does not move: static, and not kinematic. Bodies without mass that are made kinematic have both
/// flags, unless the application takes the first one away.
inline bool qcIsStatic(const btCollisionObject* object)
{
    return object->isStaticObject() && !object->isKinematicObject();
}

/// True if the object's transform and velocities are finite.
bool qcIsFinite(const btCollisionObject& object);

/// A translation of all objects, with the rounding of a displacement by it.
struct qcTranslation
{
    btVector3 by{0, 0, 0}; ///< zero: there is none
    btScalar error = 0;

    /// The rounding of the displacement of a point.
    static btScalar ErrorOf(const btVector3& from, const btVector3& to)
    {
        return 8 * SIMD_EPSILON * (from.length() + to.length());
    }
    /// True if a point has moved by it, up to rounding.
    bool IsOf(const btVector3& from, const btVector3& to) const
    {
        return (to - from - by).length() <= error + ErrorOf(from, to);
    }
};

/// Half the diagonal of a shape's box.
btScalar qcHalfSize(const btCollisionShape* shape);

/// Upper bound of the displacement of a shape's points from one transform to another. Not a number if one of these has
/// such.
btScalar qcMaxDisplacement(const btCollisionShape* shape, const btTransform& from, const btTransform& to);

/// True if the object, which Bullet does not integrate, has moved from one transform to another; false if it was put
/// elsewhere. It moves if that is by at most half its size, or by its velocity in a whole number of steps: Bullet gives
/// an active kinematic body the velocity of its motion over all substeps, unless the application sets its interpolation
/// transform, too. Any other object has the velocity of its previous motion, `previous`, a step.
bool qcIsMotion(const btCollisionObject* object, const btTransform& from, const btTransform& to,
                const btVector3& previous, btScalar timeStep);

/// True if the body has moved from one transform to another as Bullet integrates it in a step; false if a callback of
/// the application has put it elsewhere meanwhile. Bullet moves it by a part of what one of its velocities makes:
/// contact changes them, and continuous collision stops it on its way. Half its size is left to all else.
bool qcIsIntegrated(const btRigidBody& body, const btTransform& from, const btTransform& to, btScalar timeStep);

#endif
