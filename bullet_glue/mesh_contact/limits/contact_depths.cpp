// Depths of objects in each other where Bullet has contact points, and the motions that this contact has stopped.
#include "mesh_contact/limits/contact_depths.h"

#include "common/multibody_joints.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
// Smaller depths are those of bodies at rest: parts of the contact breaking threshold, and of the smaller object's
// size.
constexpr btScalar s_smallDepth = btScalar(0.1), s_smallPart = btScalar(0.05);
// Part of the contact breaking threshold: twice the way of a free fall in a step of 1/60 s.
constexpr btScalar s_smallHeldOff = btScalar(0.25);

btScalar DeepestOf(const btPersistentManifold& manifold)
{
    btScalar depth = 0;
    for (int i = 0; i < manifold.getNumContacts(); i++)
        depth = std::max(depth, -manifold.getContactPoint(i).getDistance());
    return depth;
}

btScalar ImpulseOf(const btPersistentManifold& manifold)
{
    btScalar impulse = 0;
    for (int i = 0; i < manifold.getNumContacts(); i++)
        impulse += manifold.getContactPoint(i).m_appliedImpulse;
    return impulse;
}

/// The speed that an impulse at the centre gives an object. That of a link is an upper bound: others may move with it.
btScalar SpeedPerImpulse(const btCollisionObject* object)
{
    if (const btMultiBodyLinkCollider* link = qcAsLink(object))
    {
        const btScalar mass =
            link->m_link >= 0 ? link->m_multiBody->getLink(link->m_link).m_mass : link->m_multiBody->getBaseMass();
        return mass > 0 ? 1 / mass : btScalar(0);
    }
    const btRigidBody* body = btRigidBody::upcast(object);
    return body != nullptr ? body->getInvMass() : btScalar(0);
}

/// The size of the smaller object (getAngularMotionDisc): Bullet makes its manifolds' thresholds of it.
btScalar SmallerSizeOf(const btPersistentManifold& manifold)
{
    return manifold.getContactBreakingThreshold() / gContactBreakingThreshold;
}
} // namespace

void qcContactDepths::Add(const btCollisionObject* object, btScalar depth, btScalar heldOff)
{
    Entry& entry = m_entries[object];
    entry.depth = std::max(entry.depth, depth);
    entry.heldOff = std::max(entry.heldOff, heldOff);
}

void qcContactDepths::Read(btDispatcher* dispatcher, btScalar timeStep)
{
    Clear();
    for (int i = 0; i < dispatcher->getNumManifolds(); i++)
    {
        const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(i);
        const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
        if (!(a->isActive() || b->isActive()) || !dispatcher->needsResponse(a, b))
            continue;
        btScalar depth = DeepestOf(manifold);
        if (depth <= std::min(s_smallDepth * gContactBreakingThreshold, s_smallPart * SmallerSizeOf(manifold)))
            depth = 0;
        const btScalar impulse = ImpulseOf(manifold);
        for (const btCollisionObject* object : {a, b})
        {
            btScalar heldOff = impulse * SpeedPerImpulse(object) * timeStep;
            if (heldOff <= s_smallHeldOff * gContactBreakingThreshold)
                heldOff = 0;
            if (depth > 0 || heldOff > 0)
                Add(object, depth, heldOff);
        }
    }
}

btScalar qcContactDepths::DepthOf(const btCollisionObject* object) const
{
    auto found = m_entries.find(object);
    return found != m_entries.end() ? found->second.depth : btScalar(0);
}

btScalar qcContactDepths::HeldOffOf(const btCollisionObject* object) const
{
    auto found = m_entries.find(object);
    return found != m_entries.end() ? found->second.heldOff : btScalar(0);
}
