// Restitution, by impulses after the solver's.
#include "mesh_contact/bounces.h"

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <vector>

namespace
{
// Sweeps over all bounces: the four points of a face share one.
constexpr int s_sweeps = 10;
// Bodies that have come nearer to each other up to this part of the way touch. Corners of a box that lands flat differ
// by rounding: the solver stops some of them, and the others would turn it.
constexpr btScalar s_touching = btScalar(0.01);
// Arms that have changed by more than this part of the shorter one turn the bodies in another way than the solver did.
constexpr btScalar s_slid = btScalar(0.1);

/// One of the two bodies at a point.
struct Side
{
    btRigidBody* body; ///< null: it does not move
    btVector3 arm;     ///< from its centre to the point

    Side(const btCollisionObject* object, const btVector3& fromCentre)
        : body(const_cast<btRigidBody*>(btRigidBody::upcast(object))), arm(fromCentre)
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
    btVector3 normal; ///< from b to a
    btScalar restitution;
    btScalar speed;       ///< at which the two part
    btScalar stopping;    ///< impulse that stops the two, in part the solver's
    btScalar parting = 0; ///< impulse that parts them
    btScalar left = 0;    ///< speed of approach that the solver has left, at its arms
    bool hasSlid = false; ///< the arms are no longer about those of the solver

    btScalar PartingSpeed() const
    {
        return normal.dot(a.Velocity() - b.Velocity());
    }

    Bounce(const btPersistentManifold& manifold, const btManifoldPoint& point, const qcBounceMark& mark)
        : a(manifold.getBody0(), mark.armA), b(manifold.getBody1(), mark.armB), normal(point.m_normalWorldOnB),
          restitution(mark.restitution), speed(mark.restitution * mark.approach), stopping(point.m_appliedImpulse)
    {
        left = -PartingSpeed();
        Meet();
    }

    /// Both bodies have slid along each other since the arms were found. From now on they have one point in common,
    /// else the impulses would change their angular momentum. The lighter body's arm changes less: that of a body on a
    /// static one remains.
    void Meet()
    {
        const btScalar shareA = a.body != nullptr ? a.body->getInvMass() : btScalar(0);
        const btScalar shareB = b.body != nullptr ? b.body->getInvMass() : btScalar(0);
        if (!(shareA > 0) || !(shareB > 0))
            return;
        const btVector3 slide = b.body->getCenterOfMassPosition() + b.arm - a.body->getCenterOfMassPosition() - a.arm;
        hasSlid = slide.length2() > s_slid * s_slid * std::min(a.arm.length2(), b.arm.length2());
        a.arm += slide * (shareB / (shareA + shareB));
        b.arm -= slide * (shareA / (shareA + shareB));
    }

    /// The two part with no more than the energy that the solver has taken by its impulse at its arms.
    void LimitSpeed(btScalar approach)
    {
        const btScalar now = PartingSpeed(), squared = now * now + stopping * (approach + left) * InverseMass();
        speed = std::min(speed, restitution * btSqrt(std::max(squared, btScalar(0))));
    }

    btScalar InverseMass() const
    {
        return a.InverseMass(normal) + b.InverseMass(normal);
    }

    /// The impulse that has slowed down the approach, for a solver that writes none.
    btScalar FindStopping(btScalar approach) const
    {
        btScalar inverseMass = InverseMass();
        return inverseMass > 0 ? (approach + PartingSpeed()) / inverseMass : btScalar(0);
    }

    /// Changes an impulse, within a limit, so that the two part at this speed.
    void Solve(btScalar target, btScalar limit, btScalar* impulse) const
    {
        btScalar inverseMass = InverseMass();
        if (!(inverseMass > 0))
            return;
        btScalar sum = btClamped(*impulse + (target - PartingSpeed()) / inverseMass, btScalar(0), limit);
        a.Push(normal * (sum - *impulse));
        b.Push(normal * (*impulse - sum));
        *impulse = sum;
    }

    /// True if the two touch at the end of the step, by their velocities, or lack hardly anything to it.
    bool Touches(btScalar distance, btScalar timeStep) const
    {
        return (1 - s_touching) * distance <= -PartingSpeed() * timeStep;
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

/// From a body's centre to a point of its surface.
btVector3 ArmTo(const btVector3& point, const btCollisionObject* object)
{
    return point - object->getWorldTransform().getOrigin();
}

/// A link of a multibody has other velocities than those of a rigid body.
bool MayBounce(const btPersistentManifold& manifold)
{
    return manifold.getBody0()->getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK &&
           manifold.getBody1()->getInternalType() != btCollisionObject::CO_FEATHERSTONE_LINK;
}

/// The solver skips islands that fall asleep: their impulses are of an earlier step.
bool IsAsleep(const btCollisionObject* object)
{
    return !object->isStaticOrKinematicObject() && object->getActivationState() == ISLAND_SLEEPING;
}

/// Appends the bounce at a point, if the bodies touch there, or the solver has stopped them, and they were not too
/// slow.
void AddBounce(const btPersistentManifold& manifold, const btManifoldPoint& point, const qcBounceMark& mark,
               const btContactSolverInfo& info, std::vector<Bounce>* bounces)
{
    if (!(mark.approach >= info.m_restitutionVelocityThreshold) || IsAsleep(manifold.getBody0()) ||
        IsAsleep(manifold.getBody1()))
        return;
    Bounce bounce(manifold, point, mark);
    // Impulses are written for warm starting only.
    if ((info.m_solverMode & SOLVER_USE_WARMSTARTING) == 0)
        bounce.stopping = bounce.FindStopping(mark.approach);
    if (!(bounce.stopping > 0) && !bounce.Touches(mark.distance, info.m_timeStep))
        return;
    if (bounce.stopping > 0 && bounce.hasSlid)
        bounce.LimitSpeed(mark.approach);
    bounces->push_back(bounce);
}
} // namespace

void qcBounces::Mark(btPersistentManifold* manifold)
{
    Marks marks{manifold->getBody0(), manifold->getBody1(), {}};
    bool anyBounces = false;
    for (int i = 0; i < manifold->getNumContacts() && m_isEnabled && MayBounce(*manifold); i++)
    {
        btManifoldPoint& point = manifold->getContactPoint(i);
        if (!(point.m_combinedRestitution > 0))
            continue;
        Side a(manifold->getBody0(), ArmTo(point.getPositionWorldOnA(), manifold->getBody0()));
        Side b(manifold->getBody1(), ArmTo(point.getPositionWorldOnB(), manifold->getBody1()));
        btScalar approach = point.m_normalWorldOnB.dot(b.Velocity() - a.Velocity());
        if (!(approach > 0))
            continue;
        marks.points[size_t(i)] = {a.arm, b.arm, point.m_combinedRestitution, approach, point.getDistance()};
        point.m_combinedRestitution = 0;
        anyBounces = true;
    }
    std::lock_guard<std::mutex> lock(m_mutex);
    if (anyBounces)
        m_marks[manifold] = marks;
    else
        m_marks.erase(manifold);
}

void qcBounces::Apply(btDynamicsWorld* world)
{
    std::vector<Bounce> bounces;
    btDispatcher* dispatcher = world->getDispatcher();
    // An action may have removed bodies: manifolds that are left have theirs. Their order is that of the dispatcher.
    for (int m = 0; m < dispatcher->getNumManifolds() && !m_marks.empty(); m++)
    {
        btPersistentManifold* manifold = dispatcher->getManifoldByIndexInternal(m);
        auto entry = m_marks.find(manifold);
        if (entry == m_marks.end() || entry->second.body0 != manifold->getBody0() ||
            entry->second.body1 != manifold->getBody1())
            continue;
        for (int i = 0; i < manifold->getNumContacts(); i++)
        {
            const qcBounceMark& mark = entry->second.points[size_t(i)];
            if (!(mark.restitution > 0))
                continue;
            btManifoldPoint& point = manifold->getContactPoint(i);
            point.m_combinedRestitution = mark.restitution;
            AddBounce(*manifold, point, mark, world->getSolverInfo(), &bounces);
        }
    }
    m_marks.clear();
    for (int sweep = 0; sweep < s_sweeps; sweep++)
        for (Bounce& bounce : bounces)
            bounce.Stop();
    for (int sweep = 0; sweep < s_sweeps; sweep++)
        for (Bounce& bounce : bounces)
            bounce.Part();
}
