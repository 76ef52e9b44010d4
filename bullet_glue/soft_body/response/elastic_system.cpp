// The linear system by conjugate gradients. Friction by springs whose stiffness along the surface is reduced to what it
// holds, so that all forces take energy; contacts that pull are opened, and the system is solved again.
#include "soft_body/response/elastic_system.h"

#include "common/rigid_displacement.h"

#include <algorithm>
#include <cmath>

namespace
{
// Stiffness of a spring, in units of that of its nodes with all others fixed. Softer ones leave more of a load to the
// contacts that follow, which know no elasticity; stiffer ones take more iterations.
constexpr btScalar s_stiffness = 20;
// Iterations and rounds only change how exact the solution is. A resting stack takes one round of 15 to 25.
constexpr int s_maxIterations = 100, s_maxRounds = 4;
constexpr btScalar s_tolerance = btScalar(1e-2);
// Changes of a friction's share that are worth another round.
constexpr btScalar s_heldChange = btScalar(0.1);

btMatrix3x3 Scaled(btScalar s)
{
    return btMatrix3x3(s, 0, 0, 0, s, 0, 0, 0, s);
}

/// The stiffness of a spring in all directions of space.
btMatrix3x3 StiffnessOf(const qcElasticSpring& spring)
{
    const btVector3 n = spring.normal * (spring.stiffness * (1 - spring.held));
    const btMatrix3x3 along(n.x() * spring.normal, n.y() * spring.normal, n.z() * spring.normal);
    return Scaled(spring.stiffness * spring.held) + along;
}

/// The force of a spring for a relative displacement.
btVector3 ForceOf(const qcElasticSpring& spring, const btVector3& displacement)
{
    const btVector3 along = spring.normal * spring.normal.dot(displacement);
    return spring.stiffness * (along + spring.held * (displacement - along));
}

double Dot(const qcElasticSystem::Vector& a, const qcElasticSystem::Vector& b)
{
    double sum = 0;
    for (int i = 0; i < a.size(); i++)
        sum += double(a[i].dot(b[i]));
    return sum;
}

void SetZero(qcElasticSystem::Vector* x)
{
    for (int i = 0; i < x->size(); i++)
        (*x)[i].setZero();
}
} // namespace

void qcElasticSystem::Begin()
{
    m_rigids.clear();
}

int qcElasticSystem::AddRigid(btRigidBody* body)
{
    auto found =
        std::find_if(m_rigids.begin(), m_rigids.end(), [body](const Rigid& rigid) { return rigid.body == body; });
    if (found == m_rigids.end())
        found = m_rigids.insert(found, {body, 1 / body->getInvMass(), body->getInvInertiaTensorWorld().inverse()});
    return int(found - m_rigids.begin());
}

/// The nodes that the system moves, and the forces on them.
void qcElasticSystem::FindNodes(const btDeformableBackwardEulerObjective& objective,
                                const std::vector<qcSceneSoftBody*>& bodies)
{
    m_forces.clear();
    m_nodes.assign(size_t(objective.m_nodes.size()), nullptr);
    for (const qcSceneSoftBody* soft : bodies)
        for (int i = 0; i < soft->NodeCount(); i++)
            if (soft->InverseMass(uint32_t(i)) > 0)
                m_nodes[size_t(soft->body->m_nodes[i].index)] = &soft->body->m_nodes[i];
    for (int i = 0; i < objective.m_lf.size(); i++)
    {
        btDeformableLagrangianForce* force = objective.m_lf[i];
        auto isOf = [force](const qcSceneSoftBody* soft)
        { return force->m_softBodies.findLinearSearch(soft->body) < force->m_softBodies.size(); };
        if (force->getForceType() != BT_GRAVITY_FORCE && std::any_of(bodies.begin(), bodies.end(), isOf))
            m_forces.push_back(force);
    }
}

void qcElasticSystem::SetStiffness()
{
    for (qcElasticSpring& spring : *m_springs)
    {
        btScalar compliance = 0;
        for (int i = 0; i < spring.nodeCount; i++)
            if (const btSoftBody::Node* node = m_nodes[size_t(spring.nodes[i])])
            {
                const btMatrix3x3& mass = node->m_effectiveMass;
                const btScalar mean = (mass[0][0] + mass[1][1] + mass[2][2]) / 3;
                compliance += spring.weights[i] * spring.weights[i] / mean;
            }
        spring.stiffness = compliance > 0 ? s_stiffness / compliance : btScalar(0);
    }
}

btVector3 qcElasticSystem::Relative(const qcElasticSpring& spring, const Vector& x) const
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < spring.nodeCount; i++)
        sum += spring.weights[i] * x[spring.nodes[i]];
    return spring.rigid < 0 ? sum : sum - x[At(spring.rigid)] - x[At(spring.rigid) + 1].cross(spring.arm);
}

/// Adds a force on the nodes, and its reaction.
void qcElasticSystem::AddForce(const qcElasticSpring& spring, const btVector3& force, Vector* to) const
{
    for (int i = 0; i < spring.nodeCount; i++)
        if (m_nodes[size_t(spring.nodes[i])] != nullptr)
            (*to)[spring.nodes[i]] += spring.weights[i] * force;
    if (spring.rigid < 0)
        return;
    (*to)[At(spring.rigid)] -= force;
    (*to)[At(spring.rigid) + 1] -= spring.arm.cross(force);
}

/// What resists a displacement: masses, elasticity and damping as in btDeformableBackwardEulerObjective::multiply,
/// springs.
void qcElasticSystem::Multiply(const Vector& x, Vector* result) const
{
    Vector& b = *result;
    for (size_t i = 0; i < m_nodes.size(); i++)
        b[int(i)] = m_nodes[i] != nullptr ? x[int(i)] / m_nodes[i]->m_im : btVector3(0, 0, 0);
    for (btDeformableLagrangianForce* force : m_forces)
    {
        force->addScaledDampingForceDifferential(-m_timeStep, x, b);
        force->addScaledElasticForceDifferential(-m_timeStep * m_timeStep, x, b);
    }
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] == nullptr)
            b[int(i)].setZero();
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        b[At(i)] = m_rigids[size_t(i)].mass * x[At(i)];
        b[At(i) + 1] = m_rigids[size_t(i)].inertia * x[At(i) + 1];
    }
    for (const qcElasticSpring& spring : *m_springs)
        if (spring.isClosed)
            AddForce(spring, ForceOf(spring, Relative(spring, x)), &b);
}

/// The inverses of the diagonal blocks, of three rows each.
void qcElasticSystem::FindBlocks()
{
    m_inverses.assign(size_t(m_x.size()), Scaled(0));
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] != nullptr)
            m_inverses[i] = m_nodes[i]->m_effectiveMass;
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        m_inverses[size_t(At(i))] = Scaled(m_rigids[size_t(i)].mass);
        m_inverses[size_t(At(i)) + 1] = m_rigids[size_t(i)].inertia;
    }
    for (const qcElasticSpring& spring : *m_springs)
    {
        if (!spring.isClosed)
            continue;
        const btMatrix3x3 stiffness = StiffnessOf(spring);
        for (int i = 0; i < spring.nodeCount; i++)
            m_inverses[size_t(spring.nodes[i])] += stiffness * (spring.weights[i] * spring.weights[i]);
        if (spring.rigid < 0)
            continue;
        btMatrix3x3 cross;
        spring.arm.getSkewSymmetricMatrix(&cross[0], &cross[1], &cross[2]);
        m_inverses[size_t(At(spring.rigid))] += stiffness;
        m_inverses[size_t(At(spring.rigid)) + 1] += cross * stiffness * cross.transpose();
    }
    for (size_t i = 0; i < m_inverses.size(); i++)
        m_inverses[i] = i < m_nodes.size() && m_nodes[i] == nullptr ? Scaled(0) : m_inverses[i].inverse();
}

void qcElasticSystem::Precondition(const Vector& r, Vector* result) const
{
    for (int i = 0; i < r.size(); i++)
        (*result)[i] = m_inverses[size_t(i)] * r[i];
}

/// Solves for the springs that are closed, from m_x on.
void qcElasticSystem::SolveClosed()
{
    SetZero(&m_right);
    for (const qcElasticSpring& spring : *m_springs)
        if (spring.isClosed)
            AddForce(spring, ForceOf(spring, spring.missing), &m_right);
    FindBlocks();
    Multiply(m_x, &m_image);
    // Iterations only lower the energy. From a guess that has less than no displacement has, none is gained.
    if (!(Dot(m_x, m_image) < 2 * Dot(m_x, m_right)))
    {
        SetZero(&m_x);
        SetZero(&m_image);
    }
    for (int i = 0; i < m_x.size(); i++)
        m_residual[i] = m_right[i] - m_image[i];
    Precondition(m_right, &m_preconditioned);
    const double enough = double(s_tolerance) * double(s_tolerance) * Dot(m_right, m_preconditioned);
    Precondition(m_residual, &m_preconditioned);
    m_direction.copyFromArray(m_preconditioned);
    double square = Dot(m_residual, m_preconditioned);
    for (int k = 0; k < s_maxIterations && square > enough; k++)
    {
        Multiply(m_direction, &m_image);
        const double curvature = Dot(m_direction, m_image);
        // Not so for a body that is far from its shape at rest: what has been found is enough.
        if (!(curvature > 0))
            return;
        const auto step = btScalar(square / curvature);
        for (int i = 0; i < m_x.size(); i++)
        {
            m_x[i] += step * m_direction[i];
            m_residual[i] -= step * m_image[i];
        }
        Precondition(m_residual, &m_preconditioned);
        const double next = Dot(m_residual, m_preconditioned);
        for (int i = 0; i < m_x.size(); i++)
            m_direction[i] = m_preconditioned[i] + btScalar(next / square) * m_direction[i];
        square = next;
    }
}

/// Closes springs that are pressed, opens those that would pull, and weakens them along the surface as far as friction
/// doesn't hold. False: nothing has changed much.
bool qcElasticSystem::UpdateSprings()
{
    bool changed = false;
    for (qcElasticSpring& spring : *m_springs)
    {
        const btVector3 force = spring.stiffness * (spring.missing - Relative(spring, m_x));
        const btScalar along = spring.normal.dot(force), across = (force - spring.normal * along).length();
        const bool isClosed = along > 0;
        const btScalar held = across > spring.friction * along ? spring.friction * along / across : btScalar(1);
        changed = changed || isClosed != spring.isClosed || (isClosed && btFabs(held - spring.held) > s_heldChange);
        spring.isClosed = isClosed;
        if (isClosed)
            spring.held = held;
    }
    return changed;
}

bool qcElasticSystem::Solve(const btDeformableBackwardEulerObjective& objective,
                            const std::vector<qcSceneSoftBody*>& bodies, btScalar timeStep,
                            std::vector<qcElasticSpring>* springs)
{
    m_timeStep = timeStep;
    m_springs = springs;
    FindNodes(objective, bodies);
    SetStiffness();
    const int size = At(int(m_rigids.size()));
    const bool isGuess = m_x.size() == size;
    for (Vector* vector : {&m_x, &m_right, &m_residual, &m_preconditioned, &m_direction, &m_image})
        vector->resize(size, btVector3(0, 0, 0));
    for (int i = 0; i < size; i++)
        if (!isGuess || (i < int(m_nodes.size()) && m_nodes[size_t(i)] == nullptr))
            m_x[i].setZero();
    // What rests is displaced in each step alike.
    if (isGuess)
        UpdateSprings();
    SolveClosed();
    for (int round = 1; round < s_maxRounds && UpdateSprings(); round++)
        SolveClosed();
    for (int i = 0; i < size; i++)
        if (!std::isfinite(m_x[i].length2()))
        {
            m_x.clear();
            return false;
        }
    return true;
}

void qcElasticSystem::Apply() const
{
    for (size_t i = 0; i < m_nodes.size(); i++)
    {
        if (m_nodes[i] == nullptr)
            continue;
        btSoftBody::Node& node = *m_nodes[i];
        node.m_q = node.m_x += m_x[int(i)];
        node.m_vn = node.m_v += m_x[int(i)] / m_timeStep;
    }
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        btRigidBody& body = *m_rigids[size_t(i)].body;
        const qcRigidDisplacement by = {m_x[At(i) + 1], m_x[At(i)]};
        body.setLinearVelocity(body.getLinearVelocity() + by.linear / m_timeStep);
        body.setAngularVelocity(body.getAngularVelocity() + by.angular / m_timeStep);
        body.setCenterOfMassTransform(qcDisplaced(body.getWorldTransform(), by));
    }
}
