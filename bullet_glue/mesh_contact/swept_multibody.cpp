// The motion of a multibody in a step, in the coordinates of its joints.
#include "mesh_contact/swept_multibody.h"

#include "common/object_key.h"
#include "common/object_motion.h"
#include "mesh_contact/rigid_motion.h"
#include "mesh_contact/swept_objects.h"

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

/// Scales the velocities of what Bullet moves.
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

/// Half the length of all links in a row.
btScalar HalfSizeOf(const btMultiBody& body)
{
    btScalar sum = 0;
    for (size_t i = 0; i < size_t(body.getNumLinks()) + 1; i++)
        if (const btMultiBodyLinkCollider* collider = ColliderOf(body, i))
            sum += qcHalfSize(collider->getCollisionShape());
    return sum;
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

/// Where a step by the present velocities takes all colliders. The joints are back at the target.
std::vector<btTransform> qcSweptMultiBody::StepFrom(const qcJointPositions& from, btScalar timeStep,
                                                    qcJointPositions* end)
{
    from.Restore(&m_body);
    m_body.stepPositionsMultiDof(timeStep);
    qcMoveColliders(&m_body);
    *end = qcJointPositions(m_body);
    std::vector<btTransform> places = ReadColliders();
    m_target.Restore(&m_body);
    return places;
}

void qcSweptMultiBody::ReadMotion(btScalar timeStep)
{
    ReadTarget();
    m_wasStopped = m_isStopped;
    m_isStopped = m_hasStart = false;
    if (!IsDynamic(m_body) || AreAllSame(m_records, m_targets))
        return;
    qcJointPositions stepped = m_target;
    if (m_records.size() == m_targets.size())
    {
        // What the application moves, such as a base, has moved there, or was put there.
        const qcJointPositions placed = m_recorded.Towards(m_target, 0, m_body);
        const std::vector<btTransform> places = StepFrom(placed, 0, &stepped);
        const bool hasMoved = LargestDisplacement(m_body, m_records, places) <= HalfSizeOf(m_body);
        const std::vector<btTransform> expected = StepFrom(placed, timeStep, &stepped);
        // The solver may correct more than velocities.
        m_hasStart = LargestDisplacement(m_body, expected, m_targets) <=
                     gContactBreakingThreshold + LargestDisplacement(m_body, m_records, m_targets) / 2;
        m_start = hasMoved ? m_recorded : placed;
        m_starts = hasMoved ? m_records : places;
    }
    if (!m_hasStart)
    {
        m_starts = StepFrom(m_target, -timeStep, &m_start);
        m_hasStart = LargestDisplacement(m_body, m_starts, m_targets) > 0;
    }
}

void qcSweptMultiBody::ReadTarget()
{
    m_target = qcJointPositions(m_body);
    m_targets = ReadColliders();
    m_targetMoment = MomentOf(m_body);
    m_members.clear();
    m_motion.reset();
    m_fraction = 1;
    m_isMoved = true;
}

void qcSweptMultiBody::Add(qcSweptObject* swept)
{
    m_members.push_back({swept, 0, swept->end});
}

/// The motion of all members by pushes, which starts at the target.
qcMultiBodyMotion& qcSweptMultiBody::Motion()
{
    if (m_motion == nullptr)
    {
        m_motion = std::make_unique<qcMultiBodyMotion>(m_body, nullptr);
        for (Member& member : m_members)
            member.index = m_motion->AddLink(qcAsLink(member.swept->object)->m_link);
    }
    return *m_motion;
}

size_t qcSweptMultiBody::IndexOf(const qcSweptObject& link)
{
    Motion();
    return std::find_if(m_members.begin(), m_members.end(), [&link](const Member& m) { return m.swept == &link; })
        ->index;
}

qcRigidDisplacement qcSweptMultiBody::DisplacementBy(const qcSweptObject& link, const btVector3& arm,
                                                     const btVector3& push)
{
    const size_t index = IndexOf(link);
    return m_motion->CanMove(index) ? m_motion->DisplacementBy(index, arm, push) : qcRigidDisplacement();
}

void qcSweptMultiBody::Push(const qcSweptObject& link, const btVector3& arm, const btVector3& push)
{
    const size_t index = IndexOf(link);
    std::vector<btVector3> turns;
    for (const Member& member : m_members)
        turns.push_back(m_motion->Displacement(member.index).angular);
    m_motion->Push(index, arm, push);
    btScalar part = 1;
    for (size_t i = 0; i < m_members.size(); i++)
    {
        const btScalar further = (m_motion->Displacement(m_members[i].index).angular - turns[i]).length();
        const btScalar room = std::max(qcMaxRotation - turns[i].length(), btScalar(0));
        part = further * part > room ? room / further : part;
    }
    if (part < 1)
        m_motion->Push(index, arm, push * (part - 1));
    for (Member& member : m_members)
    {
        member.swept->end = qcDisplaced(member.before, m_motion->Displacement(member.index));
        member.swept->pushes++;
    }
}

void qcSweptMultiBody::CommitPushes()
{
    if (m_motion == nullptr || !m_motion->Commit())
        return;
    m_isStopped = true;
    m_target = qcJointPositions(m_body);
    ReadEnds();
}

void qcSweptMultiBody::ReadEnds()
{
    for (Member& member : m_members)
        member.swept->end = member.before = member.swept->object->getWorldTransform();
}

btVector3 qcSweptMultiBody::VelocityAt(const qcSweptObject& link, const btVector3& arm)
{
    const size_t index = IndexOf(link);
    return m_motion->VelocityAt(index, arm);
}

void qcSweptMultiBody::ApplyImpulse(const qcSweptObject& link, const btVector3& arm, const btVector3& impulse)
{
    const size_t index = IndexOf(link);
    if (m_motion->CanMove(index))
        m_motion->ApplyImpulse(index, arm, impulse);
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
    m_isStopped = true;
    return true;
}

void qcSweptMultiBody::Move()
{
    if (m_isMoved)
        return;
    m_isMoved = true;
    m_start.Towards(m_target, m_fraction, m_body).Restore(&m_body);
    ReadEnds();
}

void qcSweptMultiBody::UpdateVelocities(const btVector3& gravity)
{
    const btScalar lost = gravity.dot(m_targetMoment - MomentOf(m_body)), energy = KineticEnergyOf(m_body);
    if (lost > 0 && energy > 0)
        ScaleVelocities(&m_body, btSqrt(std::max(1 - lost / energy, btScalar(0))));
}
