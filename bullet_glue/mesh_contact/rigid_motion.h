// How far bodies come in a step.
#ifndef QC_GLUE_MESH_CONTACT_RIGID_MOTION_H
#define QC_GLUE_MESH_CONTACT_RIGID_MOTION_H

#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

/// How something moves now.
struct qcMeshMotion
{
    btVector3 centre{0, 0, 0}, linear{0, 0, 0}, angular{0, 0, 0};

    /// Stands still.
    qcMeshMotion() = default;
    /// A rigid body's velocities; anything else stands still.
    explicit qcMeshMotion(const btCollisionObject* object);

    btVector3 At(const btVector3& point) const
    {
        return linear + angular.cross(point - centre);
    }

    /// The speed of a point no further than `radius` from the centre, at most.
    btScalar Fastest(btScalar radius) const
    {
        return linear.length() + angular.length() * radius;
    }
};

/// How far a point of a body moves at most from one place to another one, if it is no further than `radius` from the
/// body's origin.
btScalar qcMotion(const btTransform& from, const btTransform& to, btScalar radius);

/// How far a point of an object, no further than `radius` from its origin, may come in a step, as seen by who drifts;
/// at most `limit`.
btScalar qcApproach(const btCollisionObject* object, btScalar radius, btScalar timeStep, btScalar limit,
                    const qcMeshMotion& drift);

#endif
