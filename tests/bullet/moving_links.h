// Motion and energy of the links of a multibody.
#ifndef QC_TESTS_BULLET_MOVING_LINKS_H
#define QC_TESTS_BULLET_MOVING_LINKS_H

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <vector>

/// Moves the colliders of all links to where the joints are.
inline void qcPlaceColliders(btMultiBody& body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body.forwardKinematics(rotations, origins);
    body.updateCollisionObjectWorldTransforms(rotations, origins);
}

struct qcMovingLink
{
    btScalar mass;
    btVector3 inertia;
    btTransform place;
    btVector3 turn, velocity; ///< in the link's frame, as Bullet has them
};

/// Calls function(link) for all links, and for the base unless it is fixed.
template <typename Function> void qcForEachLink(const btMultiBody& body, Function function)
{
    std::vector<btVector3> turns(size_t(body.getNumLinks()) + 1), velocities(turns);
    body.compTreeLinkVelocities(turns.data(), velocities.data());
    if (!body.hasFixedBase())
        function(qcMovingLink{body.getBaseMass(), body.getBaseInertia(), body.getBaseWorldTransform(), turns[0],
                              velocities[0]});
    for (int i = 0; i < body.getNumLinks(); i++)
        function(qcMovingLink{body.getLinkMass(i), body.getLinkInertia(i), body.getLink(i).m_cachedWorldTransform,
                              turns[size_t(i) + 1], velocities[size_t(i) + 1]});
}

/// Kinetic, and of gravity.
inline btScalar qcEnergyOf(const btMultiBody& body, const btVector3& gravity)
{
    btScalar sum = 0;
    qcForEachLink(body,
                  [&](const qcMovingLink& link)
                  {
                      sum += (link.velocity.length2() * link.mass + (link.inertia * link.turn).dot(link.turn)) / 2 -
                             gravity.dot(link.place.getOrigin()) * link.mass;
                  });
    return sum;
}

#endif
