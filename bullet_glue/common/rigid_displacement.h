// How a push displaces a body, free or guided: joints or factors let it give way in some directions, and in others
// hardly or not at all.
#ifndef QC_GLUE_COMMON_RIGID_DISPLACEMENT_H
#define QC_GLUE_COMMON_RIGID_DISPLACEMENT_H

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

/// A rotation vector, and a translation of the centre.
struct qcRigidDisplacement
{
    btVector3 angular{0, 0, 0}, linear{0, 0, 0};

    /// The displacement of the point at `arm` from the centre.
    btVector3 At(const btVector3& arm) const
    {
        return linear + angular.cross(arm);
    }
};

/// The largest rotation by one displacement, in radians: it is linear in the push.
constexpr btScalar qcMaxRotation = btScalar(0.25);

/// A transform moved by a displacement.
inline btTransform qcDisplaced(const btTransform& from, const qcRigidDisplacement& by)
{
    btTransform to(from.getBasis(), from.getOrigin() + by.linear);
    const btScalar angle = by.angular.length();
    if (angle > SIMD_EPSILON)
    {
        const btQuaternion rotation(by.angular / angle, std::min(angle, qcMaxRotation));
        to.setRotation((rotation * from.getRotation()).normalized());
    }
    return to;
}

/// The displacement of a dynamic body if `push`, an impulse times the time step, acts at `arm` from its centre.
inline qcRigidDisplacement qcDisplacementBy(const btRigidBody& body, const btVector3& arm, const btVector3& push)
{
    return {body.getInvInertiaTensorWorld() * arm.cross(push) * body.getAngularFactor(),
            push * body.getLinearFactor() * body.getInvMass()};
}

/// True if a dynamic body can take any rigid motion: no factor and no infinite inertia restricts it.
inline bool qcIsFree(const btRigidBody& body)
{
    const btVector3 all(1, 1, 1), &turns = body.getInvInertiaDiagLocal();
    return body.getInvMass() > 0 && turns[turns.minAxis()] > 0 && body.getLinearFactor() == all &&
           body.getAngularFactor() == all;
}

/// The least part of a guided object's motion by which it gives way to a push.
constexpr btScalar qcMinAlongGuide = btScalar(0.05);

/// True if the displacement by a push on a guided object leads elsewhere: less than this part of it is along the push.
/// Such an object stays. Without a bound a body beside a leaning wall jumped by metres in a step (test_mesh_through),
/// and positions beside cloth became infinite (test_soft_multibody).
inline bool qcIsLedElsewhere(const btVector3& displacement, const btVector3& push, btScalar minAlong = qcMinAlongGuide)
{
    return !(displacement.dot(push) > minAlong * displacement.length() * push.length());
}

#endif
