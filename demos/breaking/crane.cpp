// The body is kinematic while it is carried: straight up, then over the next target.
#include "breaking/crane.h"

#include <algorithm>
#include <utility>

namespace
{
constexpr btScalar s_height = btScalar(1.7);       // of the body's centre above the target when it is dropped, m
constexpr btScalar s_fallSeconds = btScalar(1.6);  // it is taken up after that even if it has hit nothing
constexpr btScalar s_restSeconds = btScalar(0.35); // from the impact until it is taken up
constexpr btScalar s_speed = 6;                    // m/s, mean

/// From 0 to 1, at rest at both ends.
btScalar Smooth(btScalar t)
{
    return t * t * (3 - 2 * t);
}
} // namespace

qcCrane::qcCrane(btRigidBody* body, btScalar mass, const btVector3& inertia, const btQuaternion& upright,
                 std::function<btVector3()> findTarget)
    : m_body(body), m_mass(mass), m_inertia(inertia), m_upright(upright), m_findTarget(std::move(findTarget)),
      m_target(m_findTarget())
{
    btTransform place(ReleaseOrientation(), ReleasePlace());
    m_body->setWorldTransform(place);
    m_body->setInterpolationWorldTransform(place);
    m_carried = BT_LARGE_FLOAT;
}

btVector3 qcCrane::ReleasePlace() const
{
    return m_target + btVector3(0, s_height, 0);
}

btQuaternion qcCrane::ReleaseOrientation() const
{
    // A turn by the golden angle from drop to drop, and a tilt: it never lands twice in the same way.
    btScalar turn = btScalar(2.4) * btScalar(m_drops), tilt = btScalar(0.5) * btSin(turn);
    return btQuaternion(btVector3(0, 1, 0), turn) * btQuaternion(btVector3(1, 0, 0), tilt) * m_upright;
}

void qcCrane::NoteImpact()
{
    if (!m_carries && !m_hasHit)
    {
        m_hasHit = true;
        m_clock = 0;
    }
}

// Taken out of the world and added again, the body would be new to collision detection, which costs a long step.
void qcCrane::Grab()
{
    m_body->setMassProps(0, btVector3(0, 0, 0));
    m_body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    StopBody();
    m_carries = true;
    m_carried = 0;
    m_target = m_findTarget();
    m_from = m_body->getWorldTransform().getOrigin();
    m_fromOrientation = m_body->getOrientation();
}

void qcCrane::Drop()
{
    m_body->setCollisionFlags(0);
    m_body->setMassProps(m_mass, m_inertia);
    StopBody();
    m_carries = false;
    m_hasHit = false;
    m_clock = 0;
    m_drops++;
}

void qcCrane::StopBody()
{
    m_body->updateInertiaTensor();
    m_body->setLinearVelocity(btVector3(0, 0, 0));
    m_body->setAngularVelocity(btVector3(0, 0, 0));
    m_body->setInterpolationWorldTransform(m_body->getWorldTransform());
    m_body->setActivationState(DISABLE_DEACTIVATION);
}

void qcCrane::Carry(btScalar seconds)
{
    btVector3 to = ReleasePlace(), up(m_from.x(), to.y(), m_from.z());
    btScalar rise = std::max(btFabs(to.y() - m_from.y()) / s_speed, seconds),
             pass = to.distance(up) / s_speed + seconds;
    m_carried = std::min(m_carried + seconds, rise + pass);
    btVector3 place =
        m_carried < rise ? m_from.lerp(up, Smooth(m_carried / rise)) : up.lerp(to, Smooth((m_carried - rise) / pass));
    btQuaternion turned = m_fromOrientation.slerp(ReleaseOrientation(), Smooth(m_carried / (rise + pass)));
    m_body->setWorldTransform(btTransform(turned, place));
}

void qcCrane::Update(btScalar seconds)
{
    m_clock += seconds;
    if (m_carries)
    {
        bool hasArrived =
            m_carried > 0 && m_body->getWorldTransform().getOrigin().distance(ReleasePlace()) < SIMD_EPSILON * 100;
        if (hasArrived)
            Drop();
        else
            Carry(seconds);
    }
    else if (m_clock > (m_hasHit ? s_restSeconds : s_fallSeconds))
        Grab();
}
