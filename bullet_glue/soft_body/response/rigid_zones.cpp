// Zones of nodes and meshes that move through a step as one rigid body.
#include "soft_body/response/rigid_zones.h"

#include "common/object_motion.h"

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <map>

namespace
{
// A tensor of inertia is inverted if its determinant, relative to its trace cubed, is at least this.
constexpr btScalar s_minDeterminant = btScalar(1e-4);
// Relative rounding of a transformed point, with room.
constexpr btScalar s_roundingBound = 64 * SIMD_EPSILON;

btTransform Translation(const btVector3& by)
{
    return btTransform(btMatrix3x3::getIdentity(), by);
}

/// The motion of one rigid body with the linear and angular momentum of its members.
class RigidMotion
{
  public:
    void AddMass(const btVector3& start, btScalar mass)
    {
        m_mass += mass;
        m_center += start * mass;
    }

    void AddMass(const qcSceneRigid& rigid)
    {
        AddMass(rigid.start.getOrigin(), 1 / rigid.body->getInvMass());
    }

    void FindCenter()
    {
        m_center /= m_mass;
    }

    void AddMotion(const btVector3& start, const btVector3& end, btScalar mass)
    {
        btVector3 arm = start - m_center, motion = end - start;
        m_linear += motion * mass;
        m_angular += arm.cross(motion) * mass;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                m_inertia[i][j] += mass * ((i == j ? arm.length2() : btScalar(0)) - arm[i] * arm[j]);
    }

    void AddMotion(const qcSceneRigid& rigid, const btTransform& end)
    {
        AddMotion(rigid.start.getOrigin(), end.getOrigin(), 1 / rigid.body->getInvMass());
        btMatrix3x3 inertia = rigid.body->getInvInertiaTensorWorld().inverse();
        btVector3 axis;
        btScalar angle;
        btTransformUtil::calculateDiffAxisAngle(rigid.start, end, axis, angle);
        m_inertia += inertia;
        m_angular += inertia * (axis * angle);
    }

    btTransform Find(bool rotates) const
    {
        btVector3 linear = m_linear / m_mass;
        // The tensor of nodes on one line is singular: they don't rotate.
        btScalar size = m_inertia[0][0] + m_inertia[1][1] + m_inertia[2][2];
        btVector3 turn(0, 0, 0);
        if (rotates && m_inertia.determinant() > s_minDeterminant * size * size * size)
            turn = m_inertia.inverse() * m_angular;
        btScalar angle = turn.length();
        btMatrix3x3 basis = btMatrix3x3::getIdentity();
        if (angle > SIMD_EPSILON)
            basis.setRotation(btQuaternion(turn / angle, angle));
        return btTransform(basis, m_center + linear - basis * m_center);
    }

  private:
    btScalar m_mass = 0;
    btVector3 m_center{0, 0, 0}, m_linear{0, 0, 0}, m_angular{0, 0, 0};
    btMatrix3x3 m_inertia{0, 0, 0, 0, 0, 0, 0, 0, 0};
};
} // namespace

void qcRigidZones::Clear()
{
    m_members.clear();
}

void qcRigidZones::CollectMembers()
{
    m_firstNode.clear();
    for (qcSceneSoftBody& soft : m_scene.Bodies())
    {
        m_firstNode.push_back(uint32_t(m_members.size()));
        for (size_t i = 0; i < soft.positions.size(); i++)
            m_members.push_back(
                {&soft, nullptr, uint32_t(i), Translation(soft.start[i] + soft.MotionOf(i, soft.start[i]))});
    }
    m_firstObject = uint32_t(m_members.size());
    m_sets.Reset(0);
    m_isInZone.clear();
    m_states.clear();
    m_moved.clear();
    m_motions.clear();
    m_zones.clear();
    m_carriers.clear();
}

/// Appends the objects that are new in the scene.
void qcRigidZones::CollectObjects()
{
    const std::vector<std::unique_ptr<qcSceneRigid>>& rigids = m_scene.meshes.Rigids();
    for (size_t i = m_members.size() - m_firstObject; i < rigids.size(); i++)
        m_members.push_back({nullptr, rigids[i].get(), 0, rigids[i]->object->getWorldTransform()});
    m_sets.Grow(m_members.size());
    m_isInZone.resize(m_members.size(), false);
    m_states.resize(m_members.size());
    m_moved.resize(m_members.size(), Motion::Rigid);
    m_motions.resize(m_members.size(), btTransform::getIdentity());
    m_zones.resize(m_members.size(), s_none);
}

void qcRigidZones::Renew()
{
    for (Member& member : m_members)
        if (member.rigid != nullptr && !member.rigid->IsFree())
            member.target = member.rigid->object->getWorldTransform();
    m_states.assign(m_members.size(), State());
    m_moved.assign(m_members.size(), Motion::Rigid);
}

void qcRigidZones::AppendMembersOf(uint32_t slot, uint32_t triangle, std::vector<uint32_t>* members) const
{
    const qcSceneSoftBody* soft = m_scene.Find(slot);
    if (soft != nullptr)
    {
        for (size_t c = 0; c < 3; c++)
            members->push_back(MemberOf(soft, soft->topology.indices[3 * size_t(triangle) + c]));
        return;
    }
    qcSceneRigid* rigid = nullptr;
    // A mesh that deforms moves by no rigid motion, and unites no zones: see Carry.
    if (m_scene.meshes.Find(slot, &rigid)->Deforms())
        return;
    members->push_back(MemberOf(rigid));
}

uint32_t qcRigidZones::MemberOf(const qcSceneRigid* rigid) const
{
    auto isIt = [rigid](const Member& member) { return member.rigid == rigid; };
    return uint32_t(std::find_if(m_members.begin() + m_firstObject, m_members.end(), isIt) - m_members.begin());
}

/// Appends what moves with the members: the bodies that nodes are tied to, and all nodes tied to bodies.
void qcRigidZones::AppendTied(std::vector<uint32_t>* members) const
{
    for (size_t i = 0; i < members->size(); i++)
    {
        const Member& member = m_members[(*members)[i]];
        if (member.rigid != nullptr)
            for (const qcTiedNode& node : member.rigid->tied)
                members->push_back(MemberOf(node.soft, node.node));
        else if (const qcSceneRigid* rigid = member.soft->TiedTo(member.node))
        {
            const uint32_t body = MemberOf(rigid);
            if (std::find(members->begin(), members->end(), body) == members->end())
                members->push_back(body);
        }
    }
}

/// Zero: a fixed node. A tied one moves with its body, which is in its zone.
btScalar qcRigidZones::InverseMassOf(const Member& node)
{
    return node.soft->TiedTo(node.node) != nullptr ? node.soft->body->m_nodes[int(node.node)].m_im
                                                   : node.soft->InverseMass(node.node);
}

/// Has the zone of a member go with a triangle of a mesh that deforms.
void qcRigidZones::Carry(uint32_t slot, uint32_t triangle, uint32_t member)
{
    qcSceneRigid* rigid = nullptr;
    const qcSceneMesh* mesh = m_scene.Find(slot) == nullptr ? m_scene.meshes.Find(slot, &rigid) : nullptr;
    if (mesh == nullptr || !mesh->Deforms())
        return;
    btVector3 motion(0, 0, 0);
    for (size_t c = 0; c < 3; c++)
    {
        const uint32_t vertex = mesh->shape->getIndices()[3 * size_t(triangle) + c];
        motion += (rigid->PresentOf(*mesh, vertex) - rigid->StartOf(*mesh, vertex)) / 3;
    }
    m_carriers.push_back({member, motion});
}

bool qcRigidZones::Add(const qcPair& pair)
{
    if (m_members.empty())
        CollectMembers();
    CollectObjects();
    std::vector<uint32_t> members;
    AppendMembersOf(pair.bodyA, pair.triangleA, &members);
    AppendMembersOf(pair.bodyB, pair.triangleB, &members);
    AppendTied(&members);
    Carry(pair.bodyA, pair.triangleA, members[0]);
    Carry(pair.bodyB, pair.triangleB, members[0]);
    const uint32_t last = m_zones[members[0]];
    bool movedAsOne = last != s_none;
    uint32_t root = m_sets.Find(members[0]);
    State united = m_states[root];
    for (uint32_t member : members)
    {
        movedAsOne = movedAsOne && m_zones[member] == last;
        const State& other = m_states[m_sets.Find(member)];
        united.min = std::max(united.min, other.min);
        united.hasGrown = united.hasGrown || other.hasGrown;
        root = m_sets.Unite(root, member);
        m_isInZone[member] = true;
    }
    Motion moved = movedAsOne ? m_moved[last] : Motion::Rigid;
    united.hasGrown = united.hasGrown || !movedAsOne;
    if (movedAsOne)
        united.min = std::max(united.min, moved == Motion::Rigid ? Motion::Translation : Motion::None);
    m_states[root] = united;
    return !movedAsOne || moved != Motion::None;
}

/// The motion of a zone from the start of the step. A fixed member determines it, and if there is none, a guided one.
btTransform qcRigidZones::FindMotion(const std::vector<uint32_t>& zone, bool rotates) const
{
    RigidMotion mean;
    const Member* guided = nullptr;
    for (uint32_t index : zone)
    {
        const Member& member = m_members[index];
        if (member.rigid == nullptr)
        {
            const btVector3& start = member.soft->start[member.node];
            if (InverseMassOf(member) == 0)
                return Translation(member.target.getOrigin() - start);
            mean.AddMass(start, 1 / InverseMassOf(member));
        }
        else if (member.rigid->isFixed || !member.rigid->CanMove())
            return member.rigid->MotionTo(member.target);
        else if (member.rigid->IsFree())
            mean.AddMass(*member.rigid);
        else if (guided == nullptr)
            guided = &member;
    }
    if (guided != nullptr)
        return guided->rigid->MotionTo(guided->target);
    mean.FindCenter();
    for (uint32_t index : zone)
    {
        const Member& member = m_members[index];
        if (member.rigid != nullptr)
            mean.AddMotion(*member.rigid, member.target);
        else
            mean.AddMotion(member.soft->start[member.node], member.target.getOrigin(), 1 / InverseMassOf(member));
    }
    return mean.Find(rotates);
}

void qcRigidZones::MoveZone(const std::vector<uint32_t>& zone)
{
    uint32_t root = m_sets.Find(zone[0]);
    State& state = m_states[root];
    // A zone that has grown is not returned to its start before it has moved.
    if (state.hasGrown)
        state = {std::min(state.min, Motion::Translation), false};
    m_moved[root] = state.min;
    // What touches a kinematic mesh would be run through if it stayed while the mesh moves on.
    auto isCarrier = [this](uint32_t index)
    { return m_members[index].rigid != nullptr && !m_members[index].rigid->IsFree(); };
    const Carried& carried = m_carried[root];
    btTransform motion = btTransform::getIdentity();
    if (carried.count > 0)
        motion = Translation(carried.sum / btScalar(carried.count));
    else if (state.min != Motion::None || std::any_of(zone.begin(), zone.end(), isCarrier))
        motion = FindMotion(zone, state.min == Motion::Rigid);
    m_motions[root] = motion;
    bool stays = qcAreSame(motion, btTransform::getIdentity());
    for (uint32_t index : zone)
    {
        const Member& member = m_members[index];
        if (member.rigid != nullptr)
            m_scene.meshes.MoveFromStart(*member.rigid, motion);
        else if (InverseMassOf(member) > 0)
        {
            const btVector3& start = member.soft->start[member.node];
            member.soft->positions[member.node] = stays ? start : motion * start;
            if (!member.soft->shifts.empty())
                member.soft->shifts[member.node].setZero();
        }
    }
}

void qcRigidZones::Move()
{
    std::map<uint32_t, std::vector<uint32_t>> zones;
    for (uint32_t i = 0; i < m_members.size(); i++)
        if (m_isInZone[i])
            zones[m_zones[i] = m_sets.Find(i)].push_back(i);
    m_carried.assign(m_members.size(), Carried());
    for (const Carrier& carrier : m_carriers)
    {
        Carried& carried = m_carried[m_sets.Find(carrier.member)];
        carried.sum += carrier.motion;
        carried.count++;
    }
    for (const auto& zone : zones)
        MoveZone(zone.second);
}

/// Upper bound of the distance of the triangle's corners at the end from where the motion takes them, with the rounding
/// of both and of itself.
btScalar qcRigidZones::DeviationOf(uint32_t slot, uint32_t triangle, const btTransform& motion) const
{
    btScalar deviation = 0, size = motion.getOrigin().length();
    if (const qcSceneSoftBody* soft = m_scene.Find(slot))
    {
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t node = soft->topology.indices[3 * size_t(triangle) + c];
            deviation = std::max(deviation, (motion * soft->start[node]).distance(soft->positions[node]));
            size = std::max(size, soft->start[node].length() + soft->positions[node].length());
        }
        return deviation + s_roundingBound * size;
    }
    qcSceneRigid* rigid = nullptr;
    const qcSceneMesh* mesh = m_scene.meshes.Find(slot, &rigid);
    const btTransform &start = rigid->start, &now = rigid->object->getWorldTransform();
    if (mesh->Deforms())
        for (size_t c = 0; c < 3; c++)
        {
            const uint32_t vertex = mesh->shape->getIndices()[3 * size_t(triangle) + c];
            deviation =
                std::max(deviation, (motion * rigid->StartOf(*mesh, vertex)).distance(rigid->PresentOf(*mesh, vertex)));
        }
    else
        deviation = qcMaxDisplacement(mesh->shape, motion * start * mesh->local, now * mesh->local);
    size += start.getOrigin().length() + now.getOrigin().length() +
            2 * rigid->object->getCollisionShape()->getAngularMotionDisc();
    return deviation + s_roundingBound * size;
}

/// The zone in which all of both triangles was in the last Move, or s_none.
uint32_t qcRigidZones::ZoneOf(const qcPair& pair) const
{
    if (m_members.empty())
        return s_none;
    std::vector<uint32_t> members;
    AppendMembersOf(pair.bodyA, pair.triangleA, &members);
    AppendMembersOf(pair.bodyB, pair.triangleB, &members);
    // An object may be new in the scene.
    auto zoneOf = [this](uint32_t member) { return member < m_members.size() ? m_zones[member] : s_none; };
    const uint32_t zone = zoneOf(members[0]);
    auto isInIt = [&](uint32_t member) { return zoneOf(member) == zone; };
    return std::all_of(members.begin(), members.end(), isInIt) ? zone : s_none;
}

bool qcRigidZones::KeepsApart(const qcPair& pair, btScalar distance) const
{
    const uint32_t zone = ZoneOf(pair);
    if (zone == s_none)
        return false;
    // On the way from the identity to a rotation by an angle, an affine motion shortens no vector below the cosine of
    // half the angle.
    const btTransform& motion = m_motions[zone];
    const btMatrix3x3& basis = motion.getBasis();
    btScalar cosine = (basis[0][0] + basis[1][1] + basis[2][2] - 1) / 2;
    btScalar minStretch = btSqrt(std::max(btScalar(0), (1 + cosine) / 2)) - s_roundingBound;
    return distance * minStretch >
           DeviationOf(pair.bodyA, pair.triangleA, motion) + DeviationOf(pair.bodyB, pair.triangleB, motion);
}

int qcRigidZones::NodeCount() const
{
    int count = 0;
    for (size_t i = 0; i < m_members.size(); i++)
        count += m_isInZone[i] && m_members[i].rigid == nullptr;
    return count;
}
