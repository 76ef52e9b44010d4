// Displacements in the coordinates of the joints.
//
// Roy Featherstone, Rigid Body Dynamics Algorithms, 2008: the Jacobian J of a link takes velocities of the joints to
// that of the link, and forces on the link to those on the joints as its transpose. With the inertia M of the joints a
// link moves by J M^-1 J' of a push on it. Bullet has M^-1 from the step's beginning.
#include "soft_body/scene/multibody_motion.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <algorithm>
#include <cmath>

namespace
{
btVector3 CenterOfLink(const btMultiBody& body, int link)
{
    return body.localPosToWorld(link, btVector3(0, 0, 0));
}

btScalar Dot(const std::vector<btScalar>& a, const std::vector<btScalar>& b)
{
    btScalar sum = 0;
    for (size_t i = 0; i < a.size(); i++)
        sum += a[i] * b[i];
    return sum;
}

bool IsZero(const std::vector<btScalar>& coordinates)
{
    return std::all_of(coordinates.begin(), coordinates.end(), [](btScalar x) { return x == 0; });
}

/// Moves the colliders of all links to where the joints are.
void MoveColliders(btMultiBody* body)
{
    btAlignedObjectArray<btQuaternion> rotations;
    btAlignedObjectArray<btVector3> origins;
    body->forwardKinematics(rotations, origins);
    body->updateCollisionObjectWorldTransforms(rotations, origins);
}
} // namespace

qcJointPositions::qcJointPositions(const btMultiBody& body)
    : m_basePosition(body.getBasePos()), m_baseRotation(body.getWorldToBaseRot()), m_joints(size_t(body.getNumLinks()))
{
    for (int i = 0; i < body.getNumLinks(); i++)
        std::copy_n(body.getJointPosMultiDof(i), body.getLink(i).m_posVarCount, m_joints[size_t(i)].begin());
}

void qcJointPositions::Restore(btMultiBody* body) const
{
    body->setBasePos(m_basePosition);
    body->setWorldToBaseRot(m_baseRotation);
    for (int i = 0; i < body->getNumLinks(); i++)
        body->setJointPosMultiDof(i, m_joints[size_t(i)].data());
    MoveColliders(body);
}

qcMultiBodyMotion::qcMultiBodyMotion(btMultiBody& body, const qcJointPositions* start)
    : m_body(body), m_pushed(size_t(6 + body.getNumDofs()), btScalar(0)), m_moved(m_pushed), m_start(start),
      m_solved(body)
{
}

/// Joints and bases that are static or kinematic stay, as in Bullet's step.
void qcMultiBodyMotion::KeepFixed(Coordinates* moved) const
{
    if (m_body.isBaseStaticOrKinematic())
        std::fill_n(moved->begin(), 6, btScalar(0));
    for (int i = 0; i < m_body.getNumLinks(); i++)
        if (m_body.isLinkStaticOrKinematic(i))
            std::fill_n(moved->begin() + 6 + m_body.getLink(i).m_dofOffset, m_body.getLink(i).m_dofCount, btScalar(0));
}

size_t qcMultiBodyMotion::AddLink(int link)
{
    Link added;
    btAlignedObjectArray<btScalar> scalars;
    btAlignedObjectArray<btVector3> vectors;
    btAlignedObjectArray<btMatrix3x3> matrices;
    for (size_t k = 0; k < 6; k++)
    {
        btVector3 axis(0, 0, 0), none(0, 0, 0);
        axis[int(k % 3)] = 1;
        added.share[k] = added.response[k] = Coordinates(m_pushed.size(), btScalar(0));
        m_body.fillConstraintJacobianMultiDof(link, CenterOfLink(m_body, link), k < 3 ? axis : none,
                                              k < 3 ? none : axis, added.share[k].data(), scalars, vectors, matrices);
        m_body.calcAccelerationDeltasMultiDof(added.share[k].data(), added.response[k].data(), scalars, vectors);
        KeepFixed(&added.response[k]);
        // Nothing is known of a multibody that no world has stepped, and nothing moves it.
        if (!std::all_of(added.response[k].begin(), added.response[k].end(),
                         [](btScalar x) { return std::isfinite(x); }))
            std::fill(added.response[k].begin(), added.response[k].end(), btScalar(0));
    }
    m_links.push_back(std::move(added));
    return m_links.size() - 1;
}

bool qcMultiBodyMotion::CanMove(size_t link) const
{
    return !std::all_of(m_links[link].response.begin(), m_links[link].response.end(), IsZero);
}

qcMultiBodyMotion::Coordinates qcMultiBodyMotion::CoordinatesBy(const Link& link, const btVector3& arm,
                                                                const btVector3& push) const
{
    const btVector3 turn = arm.cross(push);
    Coordinates moved(m_pushed.size(), btScalar(0));
    for (size_t k = 0; k < 6; k++)
    {
        const btScalar by = k < 3 ? turn[int(k)] : push[int(k - 3)];
        for (size_t i = 0; i < moved.size(); i++)
            moved[i] += by * link.response[k][i];
    }
    return moved;
}

qcRigidDisplacement qcMultiBodyMotion::DisplacementOf(const Link& link, const Coordinates& moved)
{
    qcRigidDisplacement displacement;
    for (size_t k = 0; k < 3; k++)
    {
        displacement.angular[int(k)] = Dot(link.share[k], moved);
        displacement.linear[int(k)] = Dot(link.share[k + 3], moved);
    }
    return displacement;
}

qcRigidDisplacement qcMultiBodyMotion::DisplacementBy(size_t link, const btVector3& arm, const btVector3& push) const
{
    return DisplacementOf(m_links[link], CoordinatesBy(m_links[link], arm, push));
}

void qcMultiBodyMotion::Push(size_t link, const btVector3& arm, const btVector3& push)
{
    const Coordinates moved = CoordinatesBy(m_links[link], arm, push);
    for (size_t i = 0; i < moved.size(); i++)
        m_pushed[i] += moved[i];
    for (Link& other : m_links)
        other.displacement = DisplacementOf(other, m_pushed);
}

void qcMultiBodyMotion::SetVelocities(const Coordinates& velocities)
{
    m_body.setBaseOmega(btVector3(velocities[0], velocities[1], velocities[2]));
    m_body.setBaseVel(btVector3(velocities[3], velocities[4], velocities[5]));
    for (int i = 0; i < m_body.getNumLinks(); i++)
        if (m_body.getLink(i).m_dofCount > 0)
            m_body.setJointVelMultiDof(i, &velocities[size_t(6 + m_body.getLink(i).m_dofOffset)]);
}

bool qcMultiBodyMotion::Commit()
{
    if (IsZero(m_pushed))
        return false;
    // A step of one second by these velocities. Given as an argument, Bullet reads others for planar joints.
    const btScalar* present = m_body.getVelocityVector();
    const Coordinates velocities(present, present + m_pushed.size());
    SetVelocities(m_pushed);
    m_body.stepPositionsMultiDof(1);
    SetVelocities(velocities);
    MoveColliders(&m_body);
    for (size_t i = 0; i < m_pushed.size(); i++)
        m_moved[i] += m_pushed[i];
    std::fill(m_pushed.begin(), m_pushed.end(), btScalar(0));
    for (Link& link : m_links)
        link.displacement = qcRigidDisplacement();
    return m_hasMoved = true;
}

void qcMultiBodyMotion::UpdateVelocities(btScalar timeStep)
{
    m_body.applyDeltaVeeMultiDof(m_moved.data(), 1 / timeStep);
    std::fill(m_moved.begin(), m_moved.end(), btScalar(0));
}

/// Forgets pushes.
void qcMultiBodyMotion::Clear()
{
    std::fill(m_pushed.begin(), m_pushed.end(), btScalar(0));
    std::fill(m_moved.begin(), m_moved.end(), btScalar(0));
    for (Link& link : m_links)
        link.displacement = qcRigidDisplacement();
}

void qcMultiBodyMotion::Restore()
{
    Clear();
    if (m_hasMoved)
        m_solved.Restore(&m_body);
}

bool qcMultiBodyMotion::ReturnToStart()
{
    if (m_start == nullptr)
        return false;
    Clear();
    m_start->Restore(&m_body);
    m_body.clearVelocities();
    m_hasMoved = true;
    return true;
}
