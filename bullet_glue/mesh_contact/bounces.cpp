// Restitution of contact points that bodies reach within a step.
#include "mesh_contact/bounces.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <vector>

namespace
{
// Sweeps over all bounces: the four points of a face share one.
constexpr int s_sweeps = 10;

/// One of the two bodies at a point.
struct Side
{
    btRigidBody* body; ///< null: it does not move
    btVector3 arm;     ///< from its centre to the point

    Side(const btCollisionObject* object, const btVector3& local)
        : body(const_cast<btRigidBody*>(btRigidBody::upcast(object))),
          arm(object->getWorldTransform().getBasis() * local)
    {
    }

    btVector3 Velocity() const
    {
        return body != nullptr ? body->getVelocityInLocalPoint(arm) : btVector3(0, 0, 0);
    }

    btScalar InverseMass(const btVector3& normal) const
    {
        return body != nullptr ? body->computeImpulseDenominator(body->getCenterOfMassPosition() + arm, normal) : 0;
    }

    void Push(const btVector3& impulse) const
    {
        if (body != nullptr)
            body->applyImpulse(impulse, arm);
    }
};

struct Bounce
{
    Side a, b;
    btVector3 normal;     ///< from b to a
    btScalar speed;       ///< at which the two part
    btScalar restitution; ///< that the speed contains
    btScalar stopping;    ///< impulse that stops the two, in part the solver's
    btScalar parting = 0; ///< impulse that parts them

    Bounce(const btPersistentManifold& manifold, const btManifoldPoint& point, btScalar combinedRestitution)
        : a(manifold.getBody0(), point.m_localPointA), b(manifold.getBody1(), point.m_localPointB),
          normal(point.m_normalWorldOnB), speed(-point.m_combinedRestitution), restitution(combinedRestitution),
          stopping(point.m_appliedImpulse)
    {
    }

    btScalar PartingSpeed() const
    {
        return normal.dot(a.Velocity() - b.Velocity());
    }

    /// Changes an impulse, within a limit, so that the two part at this speed.
    void Solve(btScalar target, btScalar limit, btScalar* impulse) const
    {
        btScalar inverseMass = a.InverseMass(normal) + b.InverseMass(normal);
        if (!(inverseMass > 0))
            return;
        btScalar sum = btClamped(*impulse + (target - PartingSpeed()) / inverseMass, btScalar(0), limit);
        a.Push(normal * (sum - *impulse));
        b.Push(normal * (*impulse - sum));
        *impulse = sum;
    }

    void Stop()
    {
        Solve(0, BT_LARGE_FLOAT, &stopping);
    }

    /// With no more than the restitution's part of what has stopped the two: bodies that many points stop, or others on
    /// their way, gain no energy.
    void Part()
    {
        Solve(speed, restitution * stopping, &parting);
    }
};

/// A link of a multibody has other velocities than those of a rigid body.
bool MayBounce(const btPersistentManifold& manifold)
{
    return manifold.getBody0()->getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK &&
           manifold.getBody1()->getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK;
}
} // namespace

void qcMarkBounces(btPersistentManifold* manifold)
{
    if (!MayBounce(*manifold))
        return;
    for (int i = 0; i < manifold->getNumContacts(); i++)
    {
        btManifoldPoint& point = manifold->getContactPoint(i);
        if (!(point.getDistance() > 0) || !(point.m_combinedRestitution > 0))
            continue;
        btScalar approach = -Bounce(*manifold, point, 0).PartingSpeed();
        point.m_combinedRestitution *= -std::max(approach, btScalar(0));
    }
}

void qcApplyBounces(btDynamicsWorld* world)
{
    std::vector<Bounce> bounces;
    btDispatcher* dispatcher = world->getDispatcher();
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        btPersistentManifold* manifold = dispatcher->getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold->getNumContacts(); i++)
        {
            btManifoldPoint& point = manifold->getContactPoint(i);
            if (!(point.m_combinedRestitution < 0))
                continue;
            btScalar restitution = gCalculateCombinedRestitutionCallback(manifold->getBody0(), manifold->getBody1());
            btScalar least = restitution * world->getSolverInfo().m_restitutionVelocityThreshold;
            if (point.m_appliedImpulse > 0 && -point.m_combinedRestitution >= least)
                bounces.emplace_back(*manifold, point, restitution);
            point.m_combinedRestitution = restitution;
        }
    }
    for (int sweep = 0; sweep < s_sweeps; sweep++)
        for (Bounce& bounce : bounces)
            bounce.Stop();
    for (int sweep = 0; sweep < s_sweeps; sweep++)
        for (Bounce& bounce : bounces)
            bounce.Part();
}
