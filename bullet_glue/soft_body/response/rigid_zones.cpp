// Parts of soft bodies and meshes that move through a step as one rigid body.
#include "soft_body/response/rigid_zones.h"

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <map>

namespace
{
constexpr uint32_t s_none = UINT32_MAX;
// Of a tensor of inertia, relative to its trace: the least determinant with which it is inverted.
constexpr btScalar s_flattest = btScalar(1e-4);

btTransform Translation(const btVector3& by)
{
    return btTransform(btMatrix3x3::getIdentity(), by);
}

/// The motion of one rigid body that has the linear and angular momentum of its parts. No other rigid motion with these
/// has less energy, and what the parts do has no less: a zone takes energy, and never gives any.
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

    btTransform Find() const
    {
        btVector3 linear = m_linear / m_mass;
        // Nodes on one line have no tensor to invert, and little to turn.
        btScalar size = m_inertia[0][0] + m_inertia[1][1] + m_inertia[2][2];
        btVector3 turn(0, 0, 0);
        if (m_inertia.determinant() > s_flattest * size * size * size)
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

void qcSoftZones::Clear()
{
    m_parts.clear();
}

void qcSoftZones::Begin()
{
    m_firstNode.clear();
    for (qcSceneSoftBody& soft : m_scene.Bodies())
    {
        m_firstNode.push_back(uint32_t(m_parts.size()));
        for (size_t i = 0; i < soft.places.size(); i++)
            m_parts.push_back(
                {&soft, nullptr, uint32_t(i), Translation(soft.start[i] + soft.MotionOf(i, soft.start[i]))});
    }
    m_firstObject = uint32_t(m_parts.size());
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_scene.meshes.Rigids())
        m_parts.push_back({nullptr, rigid.get(), 0, rigid->object->getWorldTransform()});
    m_sets.Reset(m_parts.size());
    m_isMember.assign(m_parts.size(), false);
    m_isHeld.assign(m_parts.size(), false);
    m_zones.assign(m_parts.size(), s_none);
}

void qcSoftZones::AddPartsOf(uint32_t slot, uint32_t triangle, std::vector<uint32_t>* parts) const
{
    const qcSceneSoftBody* soft = m_scene.Find(slot);
    if (soft != nullptr)
    {
        uint32_t first = m_firstNode[size_t(soft - m_scene.Bodies().data())];
        for (size_t c = 0; c < 3; c++)
            parts->push_back(first + soft->topology.indices[3 * size_t(triangle) + c]);
        return;
    }
    qcSceneRigid* rigid = nullptr;
    m_scene.meshes.Find(slot, &rigid);
    auto isIt = [rigid](const Part& part) { return part.rigid == rigid; };
    auto part = std::find_if(m_parts.begin() + m_firstObject, m_parts.end(), isIt);
    parts->push_back(uint32_t(part - m_parts.begin()));
}

bool qcSoftZones::Add(const qcPair& pair)
{
    if (m_parts.empty())
        Begin();
    std::vector<uint32_t> parts;
    AddPartsOf(pair.bodyA, pair.triangleA, &parts);
    AddPartsOf(pair.bodyB, pair.triangleB, &parts);
    uint32_t root = m_sets.Find(parts[0]);
    bool moved = true, held = false;
    for (uint32_t part : parts)
    {
        moved = moved && m_zones[part] != s_none && m_zones[part] == m_zones[parts[0]];
        held = held || m_isHeld[m_sets.Find(part)];
        root = m_sets.Unite(root, part);
        m_isMember[part] = true;
    }
    // They have moved as one, and still penetrate: by rounding alone, or pinned parts have different motions.
    m_isHeld[root] = held || moved;
    return !moved || !held;
}

/// From the start of the zone's parts to their end.
btTransform qcSoftZones::MotionOf(const std::vector<uint32_t>& zone) const
{
    RigidMotion mean;
    for (uint32_t number : zone)
    {
        const Part& part = m_parts[number];
        if (part.rigid != nullptr)
        {
            if (!part.rigid->IsFree())
                return part.rigid->MotionTo(part.target);
            mean.AddMass(*part.rigid);
            continue;
        }
        const btVector3& start = part.soft->start[part.node];
        if (part.soft->InverseMass(part.node) == 0)
            return Translation(part.target.getOrigin() - start);
        mean.AddMass(start, 1 / part.soft->InverseMass(part.node));
    }
    mean.FindCenter();
    for (uint32_t number : zone)
    {
        const Part& part = m_parts[number];
        if (part.rigid != nullptr)
            mean.AddMotion(*part.rigid, part.target);
        else
            mean.AddMotion(part.soft->start[part.node], part.target.getOrigin(), 1 / part.soft->InverseMass(part.node));
    }
    return mean.Find();
}

void qcSoftZones::MoveZone(const std::vector<uint32_t>& zone)
{
    uint32_t root = m_sets.Find(zone[0]);
    btTransform motion = m_isHeld[root] ? btTransform::getIdentity() : MotionOf(zone);
    bool stays = motion == btTransform::getIdentity();
    for (uint32_t number : zone)
    {
        const Part& part = m_parts[number];
        if (part.rigid != nullptr)
            m_scene.meshes.MoveFromStart(*part.rigid, motion);
        else if (part.soft->InverseMass(part.node) > 0)
        {
            const btVector3& start = part.soft->start[part.node];
            part.soft->places[part.node] = stays ? start : motion * start;
            if (!part.soft->shifts.empty())
                part.soft->shifts[part.node].setZero();
        }
    }
}

void qcSoftZones::Move()
{
    std::map<uint32_t, std::vector<uint32_t>> zones;
    for (uint32_t i = 0; i < m_parts.size(); i++)
        if (m_isMember[i])
            zones[m_zones[i] = m_sets.Find(i)].push_back(i);
    for (const auto& zone : zones)
        MoveZone(zone.second);
}

int qcSoftZones::NodeCount() const
{
    int count = 0;
    for (size_t i = 0; i < m_parts.size(); i++)
        count += m_isMember[i] && m_parts[i].rigid == nullptr;
    return count;
}
