// Where the base and the joints of a multibody are, and the colliders of its links.
#include "common/multibody_joints.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>

namespace
{
/// Joints that turn about any axis have the four components of a quaternion.
std::array<btScalar, 7> JointBetween(const std::array<btScalar, 7>& from, const std::array<btScalar, 7>& to,
                                     btScalar part, bool isSpherical)
{
    std::array<btScalar, 7> between{};
    if (isSpherical)
    {
        const btQuaternion turn = btQuaternion(from[0], from[1], from[2], from[3])
                                      .slerp(btQuaternion(to[0], to[1], to[2], to[3]), part)
                                      .normalized();
        return {turn.x(), turn.y(), turn.z(), turn.w()};
    }
    for (size_t i = 0; i < between.size(); i++)
        between[i] = from[i] + (to[i] - from[i]) * part;
    return between;
}
} // namespace

const btMultiBodyLinkCollider* qcAsLink(const btCollisionObject* object)
{
    const btMultiBodyLinkCollider* link = btMultiBodyLinkCollider::upcast(object);
    const btMultiBody* multibody = link != nullptr ? link->m_multiBody : nullptr;
    if (multibody == nullptr)
        return nullptr;
    return (link->m_link < 0 ? multibody->getBaseCollider() : multibody->getLinkCollider(link->m_link)) == link
               ? link
               : nullptr;
}

void qcMoveColliders(btMultiBody* body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body->forwardKinematics(rotations, origins);
    body->updateCollisionObjectWorldTransforms(rotations, origins);
}

qcJointPositions::qcJointPositions(const btMultiBody& body)
    : m_basePosition(body.getBasePos()), m_baseRotation(body.getWorldToBaseRot()), m_joints(size_t(body.getNumLinks()))
{
    for (int i = 0; i < body.getNumLinks(); i++)
    {
        m_joints[size_t(i)].fill(0);
        std::copy_n(body.getJointPosMultiDof(i), body.getLink(i).m_posVarCount, m_joints[size_t(i)].begin());
    }
}

void qcJointPositions::Set(btMultiBody* body) const
{
    body->setBasePos(m_basePosition);
    body->setWorldToBaseRot(m_baseRotation);
    for (int i = 0; i < body->getNumLinks(); i++)
        body->setJointPosMultiDof(i, m_joints[size_t(i)].data());
}

void qcJointPositions::Restore(btMultiBody* body) const
{
    Set(body);
    qcMoveColliders(body);
}

btScalar qcJointPositions::DistanceTo(const qcJointPositions& other, btScalar reach) const
{
    btScalar turns = (m_baseRotation - other.m_baseRotation).length();
    for (size_t i = 0; i < m_joints.size(); i++)
        for (size_t k = 0; k < m_joints[i].size(); k++)
            turns += btFabs(m_joints[i][k] - other.m_joints[i][k]);
    // A quaternion differs by half the angle. A joint slides by as much as its position differs.
    return m_basePosition.distance(other.m_basePosition) + turns * std::max(2 * reach, btScalar(1));
}

qcJointPositions qcJointPositions::Towards(const qcJointPositions& end, btScalar part, const btMultiBody& body) const
{
    qcJointPositions between = end;
    if (part >= 1)
        return between;
    if (!body.isBaseStaticOrKinematic())
    {
        between.m_basePosition = m_basePosition;
        between.m_baseRotation = m_baseRotation;
        if (part > 0)
        {
            between.m_basePosition = m_basePosition.lerp(end.m_basePosition, part);
            between.m_baseRotation = m_baseRotation.slerp(end.m_baseRotation, part).normalized();
        }
    }
    for (size_t i = 0; i < m_joints.size(); i++)
        if (!body.isLinkStaticOrKinematic(int(i)))
            between.m_joints[i] = part > 0
                                      ? JointBetween(m_joints[i], end.m_joints[i], part,
                                                     body.getLink(int(i)).m_jointType == btMultibodyLink::eSpherical)
                                      : m_joints[i];
    return between;
}
