// Where the base and the joints of a multibody are, and the colliders of its links.
#ifndef QC_GLUE_COMMON_MULTIBODY_JOINTS_H
#define QC_GLUE_COMMON_MULTIBODY_JOINTS_H

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <array>
#include <vector>

class btMultiBodyLinkCollider;

/// The object as a link of its multibody. Null: it is none, or the multibody does not move it.
const btMultiBodyLinkCollider* qcAsLink(const btCollisionObject* object);

/// Moves the colliders of all links to where the joints are.
void qcMoveColliders(btMultiBody* body);

class qcJointPositions
{
  public:
    explicit qcJointPositions(const btMultiBody& body);
    /// Moves them back, without the colliders.
    void Set(btMultiBody* body) const;
    /// Moves them back, and all colliders.
    void Restore(btMultiBody* body) const;
    /// About the largest displacement of a link between these and others of the same multibody, whose links reach so
    /// far; 0 only if they are the same.
    btScalar DistanceTo(const qcJointPositions& other, btScalar reach) const;
    /// Positions on the way from these to others of the same multibody: 0 and 1 are the two ends, exactly. What is
    /// static or kinematic is at the other end.
    qcJointPositions Towards(const qcJointPositions& end, btScalar part, const btMultiBody& body) const;

  private:
    btVector3 m_basePosition;
    btQuaternion m_baseRotation;
    std::vector<std::array<btScalar, 7>> m_joints;
};

#endif
