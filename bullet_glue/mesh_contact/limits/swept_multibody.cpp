// The motion of a multibody in a step, in the coordinates of its joints.
#include "mesh_contact/limits/swept_multibody.h"

#include "common/finite.h"
#include "common/object_key.h"
#include "common/object_motion.h"
#include "common/rigid_motion.h"
#include "mesh_contact/limits/swept_object.h"

#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
/// The index of a link's collider among the places of a multibody.
size_t PlaceOf(const btCollisionObject* link)
{
    return size_t(qcAsLink(link)->m_link + 1);
}

/// True if Bullet moves the joint of a link.
bool IsMovedJoint(const btMultiBody& body, int link)
{
    return body.getLink(link).m_dofCount > 0 && !body.isLinkStaticOrKinematic(link);
}

/// True if Bullet moves the base or a joint.
bool IsMoved(const btMultiBody& body)
{
    if (!body.isBaseStaticOrKinematic())
        return true;
    for (int i = 0; i < body.getNumLinks(); i++)
        if (IsMovedJoint(body, i))
            return true;
    return false;
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

bool AreFinite(const std::vector<btTransform>& places)
{
    return std::all_of(places.begin(), places.end(), [](const btTransform& place) { return qcIsFinite(place); });
}

bool AreAllSame(const std::vector<btTransform>& a, const std::vector<btTransform>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](const btTransform& x, const btTransform& y) { return qcAreSame(x, y); });
}
} // namespace

/// Null: it has none, or one without a shape, which has no place.
const btCollisionObject* qcSweptMultiBody::ColliderOf(int link) const
{
    const btMultiBodyLinkCollider* collider = link < 0 ? m_body.getBaseCollider() : m_body.getLinkCollider(link);
    return collider != nullptr && collider->getCollisionShape() != nullptr ? collider : nullptr;
}

qcSweptMultiBody::Places qcSweptMultiBody::ReadColliders() const
{
    Places places;
    for (int link = -1; link < m_body.getNumLinks(); link++)
    {
        const btCollisionObject* collider = ColliderOf(link);
        places.push_back(collider != nullptr ? collider->getWorldTransform() : btTransform::getIdentity());
    }
    return places;
}

/// The colliders where the joints have these positions. Joints and colliders return to the target.
qcSweptMultiBody::Places qcSweptMultiBody::PlacesAt(const qcJointPositions& joints)
{
    joints.Restore(&m_body);
    Places places = ReadColliders();
    m_target.Restore(&m_body);
    return places;
}

/// The positions of the joints after a step by the present velocities; static and kinematic links stay. The joints
/// themselves return to the target.
qcJointPositions qcSweptMultiBody::StepFrom(const qcJointPositions& from, btScalar timeStep)
{
    from.Set(&m_body);
    m_body.stepPositionsMultiDof(timeStep);
    qcJointPositions end(m_body);
    m_target.Set(&m_body);
    return end.Towards(from, 0, m_body);
}

/// Half the length of all links in a row.
btScalar qcSweptMultiBody::HalfSize() const
{
    btScalar sum = 0;
    ForEachCollider([&sum](const btCollisionObject* collider) { sum += qcHalfSize(collider->getCollisionShape()); });
    return sum;
}

/// The largest displacement of a point of a link.
btScalar qcSweptMultiBody::LargestDisplacement(const Places& from, const Places& to) const
{
    btScalar largest = 0;
    for (size_t i = 0; i < from.size(); i++)
        if (const btCollisionObject* collider = ColliderOf(int(i) - 1))
            largest = std::max(
                largest, qcDisplacementBound(from[i], to[i], collider->getCollisionShape()->getAngularMotionDisc()));
    return largest;
}

/// True if the target is where the velocities were to take the joints, or about there: the solver may correct more than
/// velocities.
bool qcSweptMultiBody::IsExplained(const qcJointPositions& expected)
{
    if (expected.DistanceTo(m_target, 2 * HalfSize()) <= gContactBreakingThreshold)
        return true;
    const Places places = PlacesAt(expected);
    return AreFinite(places) && LargestDisplacement(places, m_targets) <=
                                    gContactBreakingThreshold + LargestDisplacement(m_records, m_targets) / 2;
}

void qcSweptMultiBody::FindStart(btScalar timeStep)
{
    m_puts.clear();
    if (m_records.size() == m_targets.size())
    {
        m_start = m_recorded;
        m_starts = m_records;
        if (AreAllSame(m_records, m_targets))
            return;
        // What the application moves, such as a base, has moved there, or was put there.
        const qcJointPositions placed = m_recorded.Towards(m_target, 0, m_body);
        if (IsExplained(StepFrom(placed, timeStep)))
        {
            if (placed.DistanceTo(m_recorded, 1) == 0)
                return;
            m_put = placed;
            m_puts = PlacesAt(placed);
            if (LargestDisplacement(m_records, m_puts) > HalfSize())
                StartWherePut();
            return;
        }
    }
    m_start = StepFrom(m_target, -timeStep);
    m_starts = PlacesAt(m_start);
}

void qcSweptMultiBody::StartWherePut()
{
    if (m_puts.empty())
        return;
    m_start = m_put;
    m_starts.swap(m_puts);
    m_puts.clear();
}

void qcSweptMultiBody::ReadMotion(btScalar timeStep)
{
    ReadTarget();
    m_wasStopped = m_isStopped;
    m_isStopped = false;
    m_hasStart = IsMoved(m_body) && AreFinite(m_targets);
    if (m_hasStart)
        FindStart(timeStep);
    m_hasStart = m_hasStart && AreFinite(m_starts);
}

void qcSweptMultiBody::ReadTarget()
{
    m_target = qcJointPositions(m_body);
    m_targets = ReadColliders();
    m_hasLeft = false;
    m_members.clear();
    m_motion.reset();
    m_fraction = 1;
    m_isMoved = true;
}

bool qcSweptMultiBody::IsDynamic(const btMultiBodyLinkCollider& collider) const
{
    const int link = collider.m_link;
    return m_hasStart && size_t(link + 1) < m_starts.size() &&
           (link < 0 ? !m_body.isBaseStaticOrKinematic() : !m_body.isLinkAndAllAncestorsStaticOrKinematic(link));
}

const btTransform& qcSweptMultiBody::StartOf(const btCollisionObject* link) const
{
    return m_starts[PlaceOf(link)];
}

bool qcSweptMultiBody::CanMove(const btCollisionObject* collider) const
{
    if (HasFreeBase())
        return true;
    for (int link = qcAsLink(collider)->m_link; link >= 0; link = m_body.getParent(link))
        if (IsMovedJoint(m_body, link))
            return true;
    return false;
}

void qcSweptMultiBody::Add(qcSweptObject* swept)
{
    // A compound is read as a mesh, and again as convex shapes.
    const bool isKnown = std::any_of(m_members.begin(), m_members.end(),
                                     [swept](const Member& member) { return member.swept == swept; });
    if (!isKnown)
        m_members.push_back({swept, 0, swept->object->getWorldTransform()});
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
    if (m_motion == nullptr)
        return;
    const bool hadLeft = m_hasLeft;
    KeepTarget();
    if (!m_motion->Commit())
    {
        m_hasLeft = hadLeft;
        return;
    }
    m_isStopped = true;
    m_target = qcJointPositions(m_body);
    m_motion.reset(); // further pushes act where these have led
    ReadEnds();
}

void qcSweptMultiBody::ReadEnds()
{
    for (Member& member : m_members)
    {
        member.swept->end = member.before = member.swept->object->getWorldTransform();
        member.swept->multibody = this;
    }
}

btVector3 qcSweptMultiBody::VelocityAt(const qcSweptObject& link, const btVector3& arm)
{
    const size_t index = IndexOf(link);
    return m_motion->VelocityAt(index, arm);
}

void qcSweptMultiBody::ApplyImpulse(const qcSweptObject& link, const btVector3& arm, const btVector3& impulse,
                                    bool isDriven)
{
    const size_t index = IndexOf(link);
    if (!m_motion->CanMove(index))
        return;
    const btScalar before = isDriven ? KineticEnergyOf(m_body) : btScalar(0);
    m_motion->ApplyImpulse(index, arm, impulse);
    if (isDriven)
        m_allowedEnergy += std::max(KineticEnergyOf(m_body) - before, btScalar(0));
}

void qcSweptMultiBody::RecordEnd()
{
    m_recorded = qcJointPositions(m_body);
    m_records = ReadColliders();
}

/// Before the joints leave the target.
void qcSweptMultiBody::KeepTarget()
{
    if (!m_hasLeft)
    {
        m_targetMoment = MomentOf(m_body);
        m_allowedEnergy = KineticEnergyOf(m_body);
    }
    m_hasLeft = true;
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

bool qcSweptMultiBody::ReturnToStart(const btVector3& gravity)
{
    const Places before = ReadColliders();
    KeepTarget();
    m_start.Towards(m_target, 0, m_body).Restore(&m_body);
    UpdateVelocities(gravity);
    m_isStopped = true;
    for (const Member& member : m_members)
        member.swept->isLimited = true;
    return !AreAllSame(before, ReadColliders());
}

void qcSweptMultiBody::Move()
{
    if (m_isMoved)
        return;
    m_isMoved = true;
    KeepTarget();
    m_start.Towards(m_target, m_fraction, m_body).Restore(&m_body);
    ReadEnds();
}

void qcSweptMultiBody::UpdateVelocities(const btVector3& gravity)
{
    if (!m_hasLeft)
        return;
    const btScalar lost = gravity.dot(m_targetMoment - MomentOf(m_body)), energy = KineticEnergyOf(m_body);
    const btScalar allowed = std::max(m_allowedEnergy - std::max(lost, btScalar(0)), btScalar(0));
    if (energy > allowed)
        ScaleVelocities(&m_body, btSqrt(allowed / energy));
}
