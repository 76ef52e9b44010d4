// Objects that the application gives another transform between steps: they move there, or are put elsewhere.
#ifndef QC_GLUE_COMMON_OBJECT_MOTION_H
#define QC_GLUE_COMMON_OBJECT_MOTION_H

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/CollisionShapes/btCollisionShape.h>

#include <algorithm>

class btRigidBody;

/// True if the object does not move: static, and not kinematic. Bodies without mass that are made kinematic have both
/// flags, unless the application takes the first one away.
inline bool qcIsStatic(const btCollisionObject* object)
{
    return object->isStaticObject() && !object->isKinematicObject();
}

/// True if the object's transform and velocities are finite.
bool qcIsFinite(const btCollisionObject& object);

// Rounding of a place, as a part of its distance from the origin.
constexpr btScalar qcPlaceRounding = 8 * SIMD_EPSILON;

/// A translation of many points. A new origin of the world moves all by one, and none against another.
struct qcTranslation
{
    btVector3 by{0, 0, 0}; ///< zero: there is none
    btScalar error = 0;    ///< of a displacement, by the rounding of the points that were added

    /// Takes the displacement of a point; the first one decides. False: it has another one, or none.
    bool Add(const btVector3& from, const btVector3& to, btScalar rounding = qcPlaceRounding)
    {
        error = std::max(error, rounding * (from.length() + to.length()));
        if (by.isZero())
            by = to - from;
        return by.length() > error && (to - from - by).length() <= error;
    }
    /// True if a point has moved by the translation, up to rounding.
    bool IsOf(const btVector3& from, const btVector3& to) const
    {
        return by.length() > error &&
               (to - from - by).length() <= std::max(error, qcPlaceRounding * (from.length() + to.length()));
    }
    /// True if something has moved by the translation alone, up to rounding.
    bool IsOf(const btTransform& from, const btTransform& to) const
    {
        auto isTurned = [&](int row)
        { return (from.getBasis()[row] - to.getBasis()[row]).length2() > qcPlaceRounding * qcPlaceRounding; };
        return IsOf(from.getOrigin(), to.getOrigin()) && !isTurned(0) && !isTurned(1) && !isTurned(2);
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
