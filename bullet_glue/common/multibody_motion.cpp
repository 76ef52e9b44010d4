// Displacements in the coordinates of the joints.
//
// Roy Featherstone, Rigid Body Dynamics Algorithms, 2008: the Jacobian J of a link takes velocities of the joints to
// that of the link, and its transpose J' forces on the link to those on the joints. With the inertia M of the joints a
// link moves by J M^-1 J' of a push on it. Bullet has M^-1 from the step's beginning.
#include "common/multibody_motion.h"

#include <algorithm>
#include <cmath>

namespace
{
btVector3 CenterOfLink(const btMultiBody& body, int link)
{
    return body.localPosToWorld(link, btVector3(0, 0, 0));
}

/// Torque about the centre, then force.
std::array<btScalar, 6> WrenchOf(const btVector3& arm, const btVector3& push)
{
    const btVector3 turn = arm.cross(push);
    return {turn.x(), turn.y(), turn.z(), push.x(), push.y(), push.z()};
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
} // namespace

qcMultiBodyMotion::qcMultiBodyMotion(btMultiBody& body, const qcJointPositions* start)
    : m_body(body), m_pushed(size_t(6 + body.getNumDofs()), btScalar(0)), m_moved(m_pushed), m_start(start),
      m_solved(body), m_solvedVelocities(body.getVelocityVector(), body.getVelocityVector() + m_pushed.size())
{
}

/// Sets to 0 what is static or kinematic, which Bullet's step leaves where it is. Bullet's inverse inertia takes such a
/// joint for free unless all up to the base are such: its neighbours give way a little too much or too little.
void qcMultiBodyMotion::KeepFixed(Coordinates* moved) const
{
    if (m_body.isBaseStaticOrKinematic())
        std::fill_n(moved->begin(), 6, btScalar(0));
    for (int i = 0; i < m_body.getNumLinks(); i++)
        if (m_body.isLinkStaticOrKinematic(i))
            std::fill_n(moved->begin() + 6 + m_body.getLink(i).m_dofOffset, m_body.getLink(i).m_dofCount, btScalar(0));
}

/// The derivatives of a link's rotation and translation. Bullet leaves the rotation of planar joints out of that of the
/// link, so rotations are read from the motion of points next to the centre.
void qcMultiBodyMotion::FindJacobian(int link, std::array<Coordinates, 6>* jacobian) const
{
    btAlignedObjectArray<btScalar> scalars;
    btAlignedObjectArray<btVector3> vectors;
    btAlignedObjectArray<btMatrix3x3> matrices;
    const btVector3 center = CenterOfLink(m_body, link);
    jacobian->fill(Coordinates(m_pushed.size(), btScalar(0)));
    for (size_t k = 0; k < 6; k++)
    {
        // The rotation about axis k moves the point at axis k + 1 along axis k + 2.
        btVector3 arm(0, 0, 0), along(0, 0, 0);
        if (k < 3)
            arm[int(k + 1) % 3] = 1;
        along[int(k < 3 ? k + 2 : k) % 3] = 1;
        m_body.fillContactJacobianMultiDof(link, center + arm, along, (*jacobian)[k].data(), scalars, vectors,
                                           matrices);
    }
    for (size_t k = 0; k < 3; k++)
        for (size_t i = 0; i < m_pushed.size(); i++)
            (*jacobian)[k][i] -= (*jacobian)[3 + (k + 2) % 3][i];
}

/// The displacement of the coordinates by a force on them. 0 for a multibody that no world has stepped: nothing is
/// known of it.
void qcMultiBodyMotion::FindResponse(const Coordinates& force, Coordinates* response) const
{
    btAlignedObjectArray<btScalar> scalars;
    btAlignedObjectArray<btVector3> vectors;
    // Bullet reads accelerations of links that are kinematic up to the base from here, and does not write them.
    vectors.resize(4 * (m_body.getNumLinks() + 1), btVector3(0, 0, 0));
    response->assign(m_pushed.size(), btScalar(0));
    m_body.calcAccelerationDeltasMultiDof(force.data(), response->data(), scalars, vectors);
    KeepFixed(response);
    if (!std::all_of(response->begin(), response->end(), [](btScalar x) { return std::isfinite(x); }))
        response->assign(m_pushed.size(), btScalar(0));
}

size_t qcMultiBodyMotion::AddLink(int link)
{
    m_links.emplace_back();
    Link& added = m_links.back();
    FindJacobian(link, &added.jacobian);
    for (size_t k = 0; k < 6; k++)
        FindResponse(added.jacobian[k], &added.response[k]);
    for (size_t k = 0; k < 6; k++)
        added.yield[k] = DisplacementOf(added, added.response[k]);
    return m_links.size() - 1;
}

bool qcMultiBodyMotion::CanMove(size_t link) const
{
    return !std::all_of(m_links[link].response.begin(), m_links[link].response.end(), IsZero);
}

qcRigidDisplacement qcMultiBodyMotion::DisplacementOf(const Link& link, const Coordinates& moved)
{
    qcRigidDisplacement displacement;
    for (size_t k = 0; k < 3; k++)
    {
        displacement.angular[int(k)] = Dot(link.jacobian[k], moved);
        displacement.linear[int(k)] = Dot(link.jacobian[k + 3], moved);
    }
    return displacement;
}

qcRigidDisplacement qcMultiBodyMotion::DisplacementBy(size_t link, const btVector3& arm, const btVector3& push) const
{
    const std::array<qcRigidDisplacement, 6>& yield = m_links[link].yield;
    const std::array<btScalar, 6> wrench = WrenchOf(arm, push);
    qcRigidDisplacement sum;
    for (size_t k = 0; k < 6; k++)
    {
        sum.angular += yield[k].angular * wrench[k];
        sum.linear += yield[k].linear * wrench[k];
    }
    return sum;
}

/// Adds the displacement of the coordinates by a push on a link.
void qcMultiBodyMotion::AddResponse(size_t link, const btVector3& arm, const btVector3& push, Coordinates* moved) const
{
    const std::array<btScalar, 6> wrench = WrenchOf(arm, push);
    for (size_t k = 0; k < 6; k++)
        for (size_t i = 0; i < moved->size(); i++)
            (*moved)[i] += m_links[link].response[k][i] * wrench[k];
}

btVector3 qcMultiBodyMotion::VelocityAt(size_t link, const btVector3& arm) const
{
    const btScalar* present = m_body.getVelocityVector();
    return DisplacementOf(m_links[link], Coordinates(present, present + m_pushed.size())).At(arm);
}

void qcMultiBodyMotion::ApplyImpulse(size_t link, const btVector3& arm, const btVector3& impulse)
{
    Coordinates change(m_pushed.size(), btScalar(0));
    AddResponse(link, arm, impulse, &change);
    m_body.applyDeltaVeeMultiDof(change.data(), 1);
}

void qcMultiBodyMotion::Push(size_t link, const btVector3& arm, const btVector3& push)
{
    AddResponse(link, arm, push, &m_pushed);
    FindDisplacements();
}

void qcMultiBodyMotion::Push(const Coordinates& moved)
{
    for (size_t i = 0; i < moved.size(); i++)
        m_pushed[i] += moved[i];
    FindDisplacements();
}

void qcMultiBodyMotion::FindDisplacements()
{
    for (Link& link : m_links)
        link.displacement = DisplacementOf(link, m_pushed);
}

/// The columns of Cholesky's factor, with the largest of what is left first.
std::vector<qcMultiBodyMotion::Coordinates> qcMultiBodyMotion::FindRoots() const
{
    const size_t count = m_pushed.size();
    std::vector<Coordinates> left(count), roots;
    for (size_t i = 0; i < count; i++)
    {
        Coordinates force(count, btScalar(0));
        force[i] = 1;
        FindResponse(force, &left[i]);
    }
    btScalar largest = 0;
    for (size_t round = 0; round < count; round++)
    {
        size_t pivot = 0;
        for (size_t i = 1; i < count; i++)
            if (left[i][i] > left[pivot][pivot])
                pivot = i;
        largest = std::max(largest, left[pivot][pivot]);
        if (!(left[pivot][pivot] > 16 * SIMD_EPSILON * largest))
            break;
        const btScalar scale = 1 / btSqrt(left[pivot][pivot]);
        Coordinates root(count);
        for (size_t i = 0; i < count; i++)
            root[i] = left[pivot][i] * scale;
        for (size_t i = 0; i < count; i++)
            for (size_t k = 0; k < count; k++)
                left[i][k] -= root[i] * root[k];
        roots.push_back(std::move(root));
    }
    return roots;
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
    qcMoveColliders(&m_body);
    for (size_t i = 0; i < m_pushed.size(); i++)
        m_moved[i] += m_pushed[i];
    ForgetPushes();
    return m_hasMoved = true;
}

void qcMultiBodyMotion::UpdateVelocities(btScalar timeStep)
{
    m_body.applyDeltaVeeMultiDof(m_moved.data(), 1 / timeStep);
    std::fill(m_moved.begin(), m_moved.end(), btScalar(0));
}

/// Forgets pushes since the last Commit.
void qcMultiBodyMotion::ForgetPushes()
{
    std::fill(m_pushed.begin(), m_pushed.end(), btScalar(0));
    for (Link& link : m_links)
        link.displacement = qcRigidDisplacement();
}

/// Forgets all pushes that velocities don't follow yet.
void qcMultiBodyMotion::Clear()
{
    ForgetPushes();
    std::fill(m_moved.begin(), m_moved.end(), btScalar(0));
}

void qcMultiBodyMotion::Restore()
{
    Clear();
    if (m_hasMoved)
        m_solved.Restore(&m_body);
    SetVelocities(m_solvedVelocities);
}

bool qcMultiBodyMotion::ReturnToStart()
{
    if (m_start == nullptr)
        return false;
    Clear();
    m_start->Restore(&m_body);
    // Velocities of what is kinematic are the application's.
    Coordinates stopped = m_solvedVelocities;
    KeepFixed(&stopped);
    for (size_t i = 0; i < stopped.size(); i++)
        stopped[i] = m_solvedVelocities[i] - stopped[i];
    SetVelocities(stopped);
    m_hasMoved = m_hasReturned = true;
    return true;
}
