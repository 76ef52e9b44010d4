// Energies are those in the frame that moves with the soft body, so that a cloth that is lifted lifts what lies on it.
#include "soft_body/response/rebounds.h"

#include "soft_body/response/position_constraints.h"

#include <algorithm>

namespace
{
// The share of the energy taken that is given back.
constexpr btScalar s_restitution = btScalar(0.5);

btScalar KineticEnergy(const btRigidBody& body, const btVector3& velocity, const btVector3& angularVelocity)
{
    const btVector3 spin = body.getWorldTransform().getBasis().transpose() * angularVelocity;
    const btVector3& inverse = body.getInvInertiaDiagLocal();
    btScalar energy = velocity.length2() / body.getInvMass();
    for (int axis = 0; axis < 3; axis++)
        if (inverse[axis] > 0)
            energy += spin[axis] * spin[axis] / inverse[axis];
    return energy / 2;
}

/// The mean velocity of the nodes by Bullet's solvers.
btVector3 MeanVelocity(const qcSceneSoftBody& soft, btScalar timeStep)
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < soft.NodeCount(); i++)
        sum += soft.body->m_nodes[i].m_x - soft.start[size_t(i)];
    return sum / (btScalar(soft.NodeCount()) * timeStep);
}
} // namespace

void qcRebounds::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_previous.swap(m_rebounds);
    m_rebounds.clear();
}

qcRebounds::Rebound& qcRebounds::Find(const qcSceneSoftBody& soft, const qcObjectKey& rigid, int index)
{
    auto isOf = [&rigid](const Rebound& rebound) { return rebound.rigid == rigid; };
    auto found = std::find_if(m_rebounds.begin(), m_rebounds.end(), isOf);
    if (found != m_rebounds.end())
        return *found;
    const btRigidBody& body = *btRigidBody::upcast(rigid.object);
    auto previous = std::find_if(m_previous.begin(), m_previous.end(), isOf);
    Rebound rebound = {rigid, index, MeanVelocity(soft, m_timeStep), {}, 0, 0, 0};
    rebound.start = body.getLinearVelocity() - body.getGravity() * m_timeStep - rebound.frame;
    rebound.startEnergy = KineticEnergy(body, rebound.start, body.getAngularVelocity());
    rebound.energy = previous != m_previous.end() ? previous->energy : btScalar(0);
    m_rebounds.push_back(rebound);
    return m_rebounds.back();
}

void qcRebounds::Limit(const qcSceneSoftBody& soft, const qcObjectKey& rigid, const btVector3& motion,
                       const btVector3& sprung, qcElasticSpring* spring)
{
    Rebound& rebound = Find(soft, rigid, spring->point.rigid);
    const btScalar share = qcGapRecoveryOf(m_timeStep);
    const btVector3& normal = spring->normal;
    const btScalar missing = normal.dot(spring->missing);
    // Along the surface the inertia of both sides is stopped.
    spring->missing += (1 - share) * (sprung - normal * normal.dot(sprung));
    if (missing <= 0)
        return;
    const btScalar speed = btSqrt(2 * rebound.energy * btRigidBody::upcast(rigid.object)->getInvMass());
    const btScalar approach = normal.dot(motion - rebound.frame * m_timeStep), ofNodes = missing - approach;
    const btScalar maxRecovery = std::max(share * ofNodes, speed * m_timeStep);
    rebound.speed = std::max(rebound.speed, maxRecovery / m_timeStep);
    const btScalar limited = btClamped(approach + std::min(ofNodes, maxRecovery), btScalar(0), missing);
    spring->missing += normal * (limited - missing);
    spring->isClosed = limited > 0;
}

/// The kinetic energy that the body gets by this share of the solution, but for what gravity gives it.
btScalar qcRebounds::GainOf(const qcElasticSystem& system, const Rebound& rebound, btScalar share) const
{
    const btRigidBody& body = *btRigidBody::upcast(rebound.rigid.object);
    const qcRigidDisplacement by = system.DisplacementOf(rebound.index);
    const btVector3 velocity = body.getLinearVelocity() + by.linear * (share / m_timeStep) - rebound.frame;
    const btScalar ofGravity = body.getGravity().dot(velocity + rebound.start) * m_timeStep / (2 * body.getInvMass());
    return KineticEnergy(body, velocity, body.getAngularVelocity() + by.angular * (share / m_timeStep)) -
           rebound.startEnergy - ofGravity;
}

/// The share of a solution's velocity with which the body has no more energy than before, but for gravity and what
/// springs may give. Iterations that stop early give more: boxes spun, and were thrown off their sheet.
btScalar qcRebounds::ShareOf(const qcElasticSystem& system, const Rebound& rebound) const
{
    const btRigidBody& body = *btRigidBody::upcast(rebound.rigid.object);
    const btScalar excess = GainOf(system, rebound, 1) - rebound.speed * rebound.speed / (2 * body.getInvMass());
    if (!(excess > 0))
        return 1;
    const qcRigidDisplacement by = system.DisplacementOf(rebound.index);
    const btVector3 velocity = body.getLinearVelocity() - rebound.frame, change = by.linear / m_timeStep;
    const btVector3 spin = body.getAngularVelocity(), changeOfSpin = by.angular / m_timeStep;
    const btScalar before = KineticEnergy(body, velocity, spin);
    const btScalar after = KineticEnergy(body, velocity + change, spin + changeOfSpin);
    const btScalar square = KineticEnergy(body, change, changeOfSpin), linear = after - before - square;
    if (!(square > 0))
        return 1;
    const btScalar left = std::max(after - excess - before, btScalar(0));
    const btScalar share = (btSqrt(linear * linear + 4 * square * left) - linear) / (2 * square);
    return btClamped(share, btScalar(0), btScalar(1));
}

void qcRebounds::End(qcElasticSystem* solution)
{
    for (Rebound& rebound : m_rebounds)
    {
        const btScalar share = ShareOf(*solution, rebound);
        solution->SetVelocityShare(rebound.index, share);
        const btScalar gain = GainOf(*solution, rebound, share);
        rebound.energy = std::max(btScalar(0), rebound.energy - (gain > 0 ? gain : s_restitution * gain));
    }
}
