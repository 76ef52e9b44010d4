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

void qcSweptMultiBody::Damp(btScalar part)
{
    if (!m_body.isBaseStaticOrKinematic())
    {
        m_body.setBaseVel(m_body.getBaseVel() * part);
        m_body.setBaseOmega(m_body.getBaseOmega() * part);
    }
    for (int i = 0; i < m_body.getNumLinks(); i++)
    {
        const btMultibodyLink& link = m_body.getLink(i);
        if (link.m_dofCount == 0 || m_body.isLinkStaticOrKinematic(i))
            continue;
        std::array<btScalar, 6> velocities{};
        std::transform(m_body.getJointVelMultiDof(i), m_body.getJointVelMultiDof(i) + link.m_dofCount,
                       velocities.begin(), [part](btScalar x) { return x * part; });
        m_body.setJointVelMultiDof(i, velocities.data());
    }
}
