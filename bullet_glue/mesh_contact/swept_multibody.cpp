// The motion of a multibody in a step, in the coordinates of its joints.
#include "mesh_contact/swept_multibody.h"

#include "common/object_key.h"
#include "mesh_contact/rigid_motion.h"

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
const btMultiBodyLinkCollider* ColliderOf(const btMultiBody& body, size_t i)
{
    return i == 0 ? body.getBaseCollider() : body.getLinkCollider(int(i) - 1);
}

/// True if Bullet moves the base or a joint.
bool IsDynamic(const btMultiBody& body)
{
    if (!body.isBaseStaticOrKinematic())
        return true;
    for (int i = 0; i < body.getNumLinks(); i++)
        if (body.getLink(i).m_dofCount > 0 && !body.isLinkStaticOrKinematic(i))
            return true;
    return false;
}

/// The largest displacement of a point of a link.
btScalar LargestDisplacement(const btMultiBody& body, const std::vector<btTransform>& from,
                             const std::vector<btTransform>& to)
{
    btScalar largest = 0;
    for (size_t i = 0; i < from.size(); i++)
        if (const btMultiBodyLinkCollider* collider = ColliderOf(body, i))
            largest = std::max(
                largest, qcDisplacementBound(from[i], to[i], collider->getCollisionShape()->getAngularMotionDisc()));
    return largest;
}

/// The sum of masses times places.
btVector3 MomentOf(const btMultiBody& body)
{
    btVector3 sum = body.hasFixedBase() ? btVector3(0, 0, 0) : body.getBaseMass() * body.getBasePos();
    for (int i = 0; i < body.getNumLinks(); i++)
        sum += body.getLinkMass(i) * body.localPosToWorld(i, btVector3(0, 0, 0));
    return sum;
}

btScalar KineticEnergyOf(const btMultiBody& body)
{
    std::vector<btVector3> turns(size_t(body.getNumLinks()) + 1), velocities(turns);
    body.compTreeLinkVelocities(turns.data(), velocities.data());
    auto energyOf = [](btScalar mass, const btVector3& inertia, const btVector3& turn, const btVector3& velocity)
    { return (velocity.length2() * mass + (inertia * turn).dot(turn)) / 2; };
    btScalar sum = body.hasFixedBase() ? btScalar(0)
                                       : energyOf(body.getBaseMass(), body.getBaseInertia(), turns[0], velocities[0]);
    for (int i = 0; i < body.getNumLinks(); i++)
        sum += energyOf(body.getLinkMass(i), body.getLinkInertia(i), turns[size_t(i) + 1], velocities[size_t(i) + 1]);
    return sum;
}

/// Of what Bullet moves.
void ScaleVelocities(btMultiBody* body, btScalar factor)
{
    if (!body->isBaseStaticOrKinematic())
    {
        body->setBaseVel(body->getBaseVel() * factor);
        body->setBaseOmega(body->getBaseOmega() * factor);
    }
    for (int i = 0; i < body->getNumLinks(); i++)
    {
        const int count = body->getLink(i).m_dofCount;
        std::array<btScalar, 6> scaled{};
        if (count == 0 || body->isLinkStaticOrKinematic(i))
            continue;
        for (int k = 0; k < count; k++)
            scaled[size_t(k)] = body->getJointVelMultiDof(i)[k] * factor;
        body->setJointVelMultiDof(i, scaled.data());
    }
}

bool AreAllSame(const std::vector<btTransform>& a, const std::vector<btTransform>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const btTransform& x, const btTransform& y) { return qcAreSame(x, y); });
}
} // namespace

std::vector<btTransform> qcSweptMultiBody::ReadColliders() const
{
    std::vector<btTransform> places;
    for (size_t i = 0; i < size_t(m_body.getNumLinks()) + 1; i++)
    {
        const btMultiBodyLinkCollider* collider = ColliderOf(m_body, i);
        places.push_back(collider != nullptr ? collider->getWorldTransform() : btTransform::getIdentity());
    }
    return places;
}

void qcSweptMultiBody::ReadMotion(btScalar timeStep)
{
    ReadTarget();
    m_hasStart = false;
    if (!IsDynamic(m_body) || AreAllSame(m_records, m_targets))
        return;
    m_body.stepPositionsMultiDof(-timeStep);
    qcMoveColliders(&m_body);
    m_start = qcJointPositions(m_body);
    m_starts = ReadColliders();
    m_target.Restore(&m_body);
    const btScalar motion = LargestDisplacement(m_body, m_starts, m_targets);
    m_hasStart = motion > 0;
    // Bullet bounds the rotation of a joint in a step, so fast ones do not lead back to where they began.
    if (m_records.size() == m_starts.size() &&
        LargestDisplacement(m_body, m_records, m_starts) <= gContactBreakingThreshold + motion)
    {
        m_start = m_recorded;
        m_starts = m_records;
        m_hasStart = true;
    }
}

void qcSweptMultiBody::ReadTarget()
{
    m_target = qcJointPositions(m_body);
    m_targets = ReadColliders();
    m_targetMoment = MomentOf(m_body);
    m_fraction = 1;
    m_isMoved = true;
}

void qcSweptMultiBody::RecordEnd()
{
    m_recorded = qcJointPositions(m_body);
    m_records = ReadColliders();
}

bool qcSweptMultiBody::CutTo(btScalar part)
{
    if (part >= m_fraction)
        return false;
    m_fraction = part;
    m_isMoved = false;
    return true;
}

bool qcSweptMultiBody::Move()
{
    if (m_isMoved)
        return false;
    m_isMoved = true;
    m_start.Towards(m_target, m_fraction, m_body).Restore(&m_body);
    return true;
}

void qcSweptMultiBody::UpdateVelocities(const btVector3& gravity)
{
    const btScalar lost = gravity.dot(m_targetMoment - MomentOf(m_body)), energy = KineticEnergyOf(m_body);
    if (lost > 0 && energy > 0)
        ScaleVelocities(&m_body, btSqrt(std::max(1 - lost / energy, btScalar(0))));
}
