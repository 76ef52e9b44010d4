// The linear system by conjugate gradients. Friction by springs whose stiffness along the surface is reduced to what it
// holds, so that all forces take energy; contacts that pull are opened, and the system is solved again.
#include "soft_body/response/elastic_system.h"

#include "common/union_find.h"

#include <algorithm>
#include <cmath>

namespace
{
// Rounds only change how exact the solution is. A resting load takes one.
constexpr int s_maxRounds = 4;
// The residual at the end, as a share of the forces of the springs; iterations from one look at it to the next.
constexpr btScalar s_tolerance = btScalar(0.03);
constexpr int s_checkInterval = 4;
// Where elasticity may help displacements, no node makes more than this multiple of what a spring misses. Where it
// resists, measured ones make up to 2.
constexpr btScalar s_reach = 3;
// Changes of a friction's share that are worth another round.
constexpr btScalar s_heldChange = btScalar(0.1);
// In the system, locked directions of a body give way by this part of what free ones do. Factors then lock the body.
constexpr btScalar s_locked = btScalar(1e-6);

btMatrix3x3 OnDiagonal(const btVector3& d)
{
    return btMatrix3x3(d.x(), 0, 0, 0, d.y(), 0, 0, 0, d.z());
}

btMatrix3x3 Scaled(btScalar s)
{
    return OnDiagonal(btVector3(s, s, s));
}

/// A third of the trace.
btScalar MeanOf(const btMatrix3x3& block)
{
    return (block[0][0] + block[1][1] + block[2][2]) / 3;
}

/// Resistance of a body to translation along the axes.
btMatrix3x3 MassOf(const btRigidBody& body)
{
    btVector3 motion = body.getLinearFactor();
    motion.setMax(btVector3(s_locked, s_locked, s_locked));
    motion *= body.getInvMass();
    return OnDiagonal(btVector3(1, 1, 1) / motion);
}

/// Resistance of a body to rotation about the axes.
btMatrix3x3 InertiaOf(const btRigidBody& body)
{
    const btMatrix3x3& inverse = body.getInvInertiaTensorWorld();
    if (qcIsFree(body))
        return inverse.inverse();
    const btVector3& factor = body.getAngularFactor();
    const btMatrix3x3 roots =
        OnDiagonal(btVector3(btSqrt(btMax(factor.x(), btScalar(0))), btSqrt(btMax(factor.y(), btScalar(0))),
                             btSqrt(btMax(factor.z(), btScalar(0)))));
    const btScalar mean = MeanOf(inverse);
    const btScalar unit = mean > 0 ? mean : body.getInvMass();
    return ((roots * inverse * roots) * (1 / unit) + Scaled(s_locked)).inverse() * (1 / unit);
}

/// One where a factor lets a body move, and zero where it is locked.
btVector3 FreedomOf(const btVector3& factor)
{
    return btVector3(btScalar(factor.x() > 0), btScalar(factor.y() > 0), btScalar(factor.z() > 0));
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
} // namespace

void qcElasticSystem::Begin()
{
    m_rigids.clear();
    m_links.Begin();
}

int qcElasticSystem::AddRigid(btRigidBody* body)
{
    auto found =
        std::find_if(m_rigids.begin(), m_rigids.end(), [body](const Rigid& rigid) { return rigid.body == body; });
    if (found == m_rigids.end())
        found = m_rigids.insert(found, {body, MassOf(*body), InertiaOf(*body), 1});
    return int(found - m_rigids.begin());
}

qcElasticPoint qcElasticSystem::AddPoint(const btCollisionObject& object, const btVector3& arm)
{
    qcElasticPoint point;
    if (object.isStaticOrKinematicObject())
        return point;
    point.arm = arm;
    if (const btMultiBodyLinkCollider* link = qcAsLink(&object))
        point.link = m_links.AddPoint(*link, arm);
    else if (const btRigidBody* body = btRigidBody::upcast(&object))
        point.rigid = body->getInvMass() > 0 ? AddRigid(const_cast<btRigidBody*>(body)) : -1;
    return point;
}

/// Ties a node to the body that it is anchored to, which moves it. False: it has no such anchor.
bool qcElasticSystem::Tie(const btSoftBody& body, int node, int number)
{
    for (int i = 0; i < body.m_deformableAnchors.size(); i++)
    {
        const btSoftBody::DeformableNodeRigidAnchor& anchor = body.m_deformableAnchors[i];
        const btCollisionObject& object = *anchor.m_cti.m_colObj;
        if (anchor.m_node != &body.m_nodes[node] || !(anchor.m_node->m_im > 0) || !object.isActive())
            continue;
        const qcElasticPoint point = AddPoint(object, anchor.m_node->m_x - object.getWorldTransform().getOrigin());
        if (point.Moves())
            m_tied.push_back({number, point});
        return point.Moves();
    }
    return false;
}

/// The nodes that the system moves.
void qcElasticSystem::FindNodes(const std::vector<qcNodeElasticity::LoadedBody>& bodies)
{
    m_nodes.assign(size_t(m_elasticity->NodeCount()), nullptr);
    m_masses.assign(m_nodes.size(), 0);
    m_bodyOfNode.assign(m_nodes.size(), -1);
    m_bodyInverses.resize(bodies.size());
    m_isFree.assign(bodies.size(), true);
    m_tied.clear();
    for (size_t body = 0; body < bodies.size(); body++)
        for (int i = 0; i < bodies[body].soft->NodeCount(); i++)
        {
            const auto number = size_t(m_elasticity->FirstNodeOf(body) + i);
            m_bodyOfNode[number] = int(body);
            const bool movesAlone =
                bodies[body].soft->InverseMass(uint32_t(i)) > 0 && !m_elasticity->IsHeld(int(number));
            m_isFree[body] = m_isFree[body] && movesAlone;
            if (movesAlone || Tie(*bodies[body].soft->body, i, int(number)))
            {
                m_nodes[number] = &bodies[body].soft->body->m_nodes[i];
                m_masses[number] = 1 / m_nodes[number]->m_im;
            }
        }
}

void qcElasticSystem::FindInertia()
{
    std::vector<bool> isNode(m_nodes.size());
    m_inertia.assign(m_nodes.size(), Scaled(0));
    for (size_t i = 0; i < m_nodes.size(); i++)
    {
        isNode[i] = m_nodes[i] != nullptr;
        if (isNode[i])
            m_inertia[i] = Scaled(m_masses[i]);
    }
    m_elasticity->AddDiagonal(isNode, &m_inertia);
}

/// Finds the bodies that springs connect, where none is held.
void qcElasticSystem::FindGroups()
{
    const size_t bodyCount = m_bodyInverses.size(), fixed = bodyCount + m_rigids.size();
    qcUnionFind sets;
    sets.Reset(fixed + 1);
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] == nullptr && m_bodyOfNode[i] >= 0)
            sets.Unite(uint32_t(m_bodyOfNode[i]), uint32_t(fixed));
    for (size_t i = 0; i < m_rigids.size(); i++)
        if (!qcIsFree(*m_rigids[i].body))
            sets.Unite(uint32_t(bodyCount + i), uint32_t(fixed));
    auto setOf = [bodyCount, fixed](const qcElasticPoint& point)
    { return point.rigid < 0 ? uint32_t(fixed) : uint32_t(bodyCount) + uint32_t(point.rigid); };
    for (const Tied& tied : m_tied)
        sets.Unite(uint32_t(m_bodyOfNode[size_t(tied.node)]), setOf(tied.point));
    for (const qcElasticSpring& spring : *m_springs)
    {
        uint32_t sides[2] = {uint32_t(fixed), setOf(spring.point)};
        for (int i = 0; i < spring.nodeCount; i++)
            sides[spring.weights[i] < 0] = uint32_t(m_bodyOfNode[size_t(spring.nodes[i])]);
        sets.Unite(sides[0], sides[1]);
    }
    m_groups.resize(fixed);
    for (size_t i = 0; i < fixed; i++)
    {
        const uint32_t set = sets.Find(uint32_t(i));
        m_groups[i] = set == sets.Find(uint32_t(fixed)) ? -1 : int(set);
    }
}

/// Makes the momentum of each group zero. What is inside of one changes none, and neither do iterations that don't get
/// to the end.
void qcElasticSystem::RemoveMomentum(Vector* x) const
{
    if (std::all_of(m_groups.begin(), m_groups.end(), [](int group) { return group < 0; }))
        return;
    const size_t bodyCount = m_bodyInverses.size();
    m_momenta.assign(m_groups.size(), {btVector3(0, 0, 0), 0});
    auto forEach = [&](const auto& function)
    {
        for (size_t i = 0; i < m_nodes.size(); i++)
            if (m_nodes[i] != nullptr && m_groups[size_t(m_bodyOfNode[i])] >= 0)
                function(m_momenta[size_t(m_groups[size_t(m_bodyOfNode[i])])], m_masses[i], (*x)[int(i)]);
        for (size_t i = 0; i < m_rigids.size(); i++)
            if (m_groups[bodyCount + i] >= 0)
                function(m_momenta[size_t(m_groups[bodyCount + i])], 1 / m_rigids[i].body->getInvMass(),
                         (*x)[At(int(i))]);
    };
    forEach(
        [](Momentum& momentum, btScalar mass, const btVector3& displacement)
        {
            momentum.sum += mass * displacement;
            momentum.mass += mass;
        });
    forEach([](const Momentum& momentum, btScalar, btVector3& displacement)
            { displacement -= momentum.sum / momentum.mass; });
}

void qcElasticSystem::SetStiffness()
{
    for (qcElasticSpring& spring : *m_springs)
    {
        btScalar compliance = 0;
        for (int i = 0; i < spring.nodeCount; i++)
            if (m_nodes[size_t(spring.nodes[i])] != nullptr)
                compliance += spring.weights[i] * spring.weights[i] / MeanOf(m_inertia[size_t(spring.nodes[i])]);
        spring.stiffness = compliance > 0 ? m_elasticity->SpringStiffness() / compliance : btScalar(0);
    }
}

btVector3 qcElasticSystem::Relative(const qcElasticSpring& spring, const Vector& x) const
{
    btVector3 sum(0, 0, 0);
    for (int i = 0; i < spring.nodeCount; i++)
        sum += spring.weights[i] * x[spring.nodes[i]];
    return spring.point.Moves() ? sum - MotionAt(spring.point, x) : sum;
}

btVector3 qcElasticSystem::MotionAt(const qcElasticPoint& point, const Vector& x) const
{
    if (point.link >= 0)
        return m_links.MotionAt(point.link, x);
    return x[At(point.rigid)] + x[At(point.rigid) + 1].cross(point.arm);
}

void qcElasticSystem::AddForceAt(const qcElasticPoint& point, const btVector3& force, Vector* to) const
{
    if (point.link >= 0)
    {
        m_links.AddForceAt(point.link, force, to);
        return;
    }
    (*to)[At(point.rigid)] += force;
    (*to)[At(point.rigid) + 1] += point.arm.cross(force);
}

/// Adds a stiffness at the point to what resists its body.
void qcElasticSystem::AddBlocksAt(const qcElasticPoint& point, const btMatrix3x3& stiffness)
{
    if (point.link >= 0)
    {
        m_links.AddBlocks(point.link, stiffness, &m_inverses);
        return;
    }
    btMatrix3x3 cross;
    point.arm.getSkewSymmetricMatrix(&cross[0], &cross[1], &cross[2]);
    m_inverses[size_t(At(point.rigid))] += stiffness;
    m_inverses[size_t(At(point.rigid)) + 1] += cross * stiffness * cross.transpose();
}

/// Sets the displacements of anchored nodes to those of their bodies.
void qcElasticSystem::MoveTied(Vector* x) const
{
    for (const Tied& tied : m_tied)
        (*x)[tied.node] = MotionAt(tied.point, *x);
}

/// Moves the forces on anchored nodes to their bodies.
void qcElasticSystem::PassTiedForces(Vector* forces) const
{
    for (const Tied& tied : m_tied)
    {
        AddForceAt(tied.point, (*forces)[tied.node], forces);
        (*forces)[tied.node].setZero();
    }
}

/// Adds a force on the nodes, and its reaction.
void qcElasticSystem::AddForce(const qcElasticSpring& spring, const btVector3& force, Vector* to) const
{
    for (int i = 0; i < spring.nodeCount; i++)
        if (m_nodes[size_t(spring.nodes[i])] != nullptr)
            (*to)[spring.nodes[i]] += spring.weights[i] * force;
    if (spring.point.Moves())
        AddForceAt(spring.point, -force, to);
}

/// Multiplies by the resistance of the nodes to displacement: masses and elasticity.
void qcElasticSystem::MultiplyNodes(const Vector& x, Vector* result) const
{
    Vector& b = *result;
    for (size_t i = 0; i < m_nodes.size(); i++)
        b[int(i)] = m_masses[i] * x[int(i)];
    m_elasticity->AddForces(x, result);
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] == nullptr)
            b[int(i)].setZero();
}

/// Likewise of all bodies, springs included.
void qcElasticSystem::Multiply(const Vector& x, Vector* result) const
{
    Vector& b = *result;
    MultiplyNodes(x, result);
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        b[At(i)] = m_rigids[size_t(i)].mass * x[At(i)];
        b[At(i) + 1] = m_rigids[size_t(i)].inertia * x[At(i) + 1];
    }
    m_links.SetMasses(x, result);
    for (const qcElasticSpring& spring : *m_springs)
        if (spring.isClosed)
            AddForce(spring, ForceOf(spring, Relative(spring, x)), &b);
    PassTiedForces(result);
}

/// The inverses of the diagonal blocks, of three rows each, and of the blocks of the translations of soft bodies
/// without pinned nodes: elasticity does not resist these, so that single nodes are a poor guide to them.
void qcElasticSystem::FindBlocks()
{
    m_inverses.assign(size_t(m_x.size()), Scaled(0));
    for (size_t i = size_t(At(int(m_rigids.size()))); i < m_inverses.size(); i++)
        m_inverses[i] = Scaled(1);
    m_bodyInverses.assign(m_bodyInverses.size(), Scaled(0));
    for (size_t i = 0; i < m_nodes.size(); i++)
    {
        if (m_nodes[i] == nullptr)
            continue;
        m_inverses[i] = m_inertia[i];
        m_bodyInverses[size_t(m_bodyOfNode[i])] += Scaled(m_masses[i]);
    }
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        m_inverses[size_t(At(i))] = m_rigids[size_t(i)].mass;
        m_inverses[size_t(At(i)) + 1] = m_rigids[size_t(i)].inertia;
    }
    for (const qcElasticSpring& spring : *m_springs)
    {
        if (!spring.isClosed)
            continue;
        const btMatrix3x3 stiffness = StiffnessOf(spring);
        btScalar weights[2] = {0, 0};
        int body[2] = {-1, -1};
        for (int i = 0; i < spring.nodeCount; i++)
        {
            const int side = spring.weights[i] < 0;
            m_inverses[size_t(spring.nodes[i])] += stiffness * (spring.weights[i] * spring.weights[i]);
            if (m_nodes[size_t(spring.nodes[i])] == nullptr)
                continue;
            weights[side] += spring.weights[i];
            body[side] = m_bodyOfNode[size_t(spring.nodes[i])];
        }
        for (int side = 0; side < 2; side++)
            if (body[side] >= 0)
                m_bodyInverses[size_t(body[side])] += stiffness * (weights[side] * weights[side]);
        if (spring.point.Moves())
            AddBlocksAt(spring.point, stiffness);
    }
    for (const Tied& tied : m_tied)
        AddBlocksAt(tied.point, m_inverses[size_t(tied.node)]);
    for (size_t i = 0; i < m_inverses.size(); i++)
        m_inverses[i] = i < m_nodes.size() && m_nodes[i] == nullptr ? Scaled(0) : m_inverses[i].inverse();
    for (const Tied& tied : m_tied)
        m_inverses[size_t(tied.node)] = Scaled(0);
    for (size_t i = 0; i < m_bodyInverses.size(); i++)
        m_bodyInverses[i] =
            m_isFree[i] && m_bodyInverses[i].determinant() > 0 ? m_bodyInverses[i].inverse() : Scaled(0);
}

void qcElasticSystem::Precondition(const Vector& r, Vector* result) const
{
    for (int i = 0; i < r.size(); i++)
        (*result)[i] = m_inverses[size_t(i)] * r[i];
    MoveTied(result);
    if (std::find(m_isFree.begin(), m_isFree.end(), true) == m_isFree.end())
        return;
    m_sums.assign(m_bodyInverses.size(), btVector3(0, 0, 0));
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] != nullptr)
            m_sums[size_t(m_bodyOfNode[i])] += r[int(i)];
    for (size_t body = 0; body < m_sums.size(); body++)
        m_sums[body] = m_bodyInverses[body] * m_sums[body];
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] != nullptr)
            (*result)[int(i)] += m_sums[size_t(m_bodyOfNode[i])];
}

/// The square of the forces of the springs, in the norm of the residual. It changes m_image.
double qcElasticSystem::SquareOfForces()
{
    qcSetZero(&m_forcesOfSprings);
    for (const qcElasticSpring& spring : *m_springs)
        if (spring.isClosed)
            AddForce(spring, ForceOf(spring, spring.missing - Relative(spring, m_x)), &m_forcesOfSprings);
    PassTiedForces(&m_forcesOfSprings);
    Precondition(m_forcesOfSprings, &m_image);
    return Dot(m_forcesOfSprings, m_image);
}

/// True if x + step * direction displaces no node much farther than the springs have to go.
bool qcElasticSystem::IsWithinReach(const Vector& x, btScalar step, const Vector& direction) const
{
    if (m_elasticity->AlwaysResists())
        return true;
    for (int i = 0; i < int(m_nodes.size()); i++)
        if (!((x[i] + step * direction[i]).length2() <= m_reach2))
            return false;
    return true;
}

/// Solves for the springs that are closed, from m_x on.
void qcElasticSystem::SolveClosed(int round)
{
    qcSetZero(&m_right);
    btScalar missing2 = 0;
    for (const qcElasticSpring& spring : *m_springs)
        if (spring.isClosed)
        {
            AddForce(spring, ForceOf(spring, spring.missing), &m_right);
            missing2 = std::max(missing2, spring.missing.length2());
        }
    m_reach2 = s_reach * s_reach * missing2;
    PassTiedForces(&m_right);
    FindBlocks();
    RemoveMomentum(&m_x);
    Multiply(m_x, &m_image);
    // Iterations only lower the energy. So does the best multiple of the guess.
    const double curvatureOfGuess = Dot(m_x, m_image);
    double share = curvatureOfGuess > 0 ? Dot(m_x, m_right) / curvatureOfGuess : 0;
    if (!IsWithinReach(m_x, btScalar(share) - 1, m_x))
        share = 0;
    for (int i = 0; i < m_x.size(); i++)
    {
        m_x[i] *= btScalar(share);
        m_image[i] *= btScalar(share);
    }
    for (int i = 0; i < m_x.size(); i++)
        m_residual[i] = m_right[i] - m_image[i];
    Precondition(m_residual, &m_preconditioned);
    RemoveMomentum(&m_preconditioned);
    m_direction.copyFromArray(m_preconditioned);
    double square = Dot(m_residual, m_preconditioned);
    for (int k = 0; k < m_elasticity->MaxIterations(round) && square > 0; k++)
    {
        // Converged: the residual is small against the forces of the springs.
        if (k % s_checkInterval == 0 && square < double(s_tolerance) * double(s_tolerance) * SquareOfForces())
            return;
        Multiply(m_direction, &m_image);
        const double curvature = Dot(m_direction, m_image);
        // A body far from its shape at rest has directions in which elasticity helps. What has been found is enough.
        if (!(curvature > 0))
            return;
        const auto step = btScalar(square / curvature);
        if (!IsWithinReach(m_x, step, m_direction))
            return;
        qcAddScaled(step, m_direction, &m_x);
        qcAddScaled(-step, m_image, &m_residual);
        Precondition(m_residual, &m_preconditioned);
        RemoveMomentum(&m_preconditioned);
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
        btScalar held = across > spring.friction * along ? spring.friction * along / across : btScalar(1);
        // The force that it will have can be far less than its gap would give.
        if (!spring.isClosed)
            held = 0;
        changed = changed || isClosed != spring.isClosed || (isClosed && btFabs(held - spring.held) > s_heldChange);
        spring.isClosed = isClosed;
        if (isClosed)
            spring.held = held;
    }
    return changed;
}

/// Takes back what springs have given a rigid body along the surface beyond the friction of what presses on it. Where
/// iterations stop early, springs still have forces that nothing has taken up. Their friction stopped boxes that slid.
void qcElasticSystem::LimitFriction(int rigid)
{
    btVector3 pressure(0, 0, 0), friction(0, 0, 0), torque(0, 0, 0);
    btScalar held = 0;
    for (const qcElasticSpring& spring : *m_springs)
    {
        if (!spring.isClosed || spring.point.rigid != rigid)
            continue;
        const btVector3 force = ForceOf(spring, spring.missing - Relative(spring, m_x));
        const btScalar along = spring.normal.dot(force);
        const btVector3 across = force - spring.normal * along;
        pressure -= spring.normal * std::max(along, btScalar(0));
        friction -= across;
        torque -= spring.point.arm.cross(across);
        held += spring.friction * std::max(along, btScalar(0));
    }
    const btScalar ofSprings = pressure.length();
    if (!(ofSprings > 0) || !(held > 0))
        return;
    const btVector3 momentum = m_rigids[size_t(rigid)].mass * m_x[At(rigid)], axis = pressure / ofSprings;
    const btScalar along = momentum.dot(axis);
    const btVector3 across = momentum - axis * along;
    const btScalar excess = across.length() - held / ofSprings * std::max(along, btScalar(0));
    if (!(excess > 0))
        return;
    m_x[At(rigid)] -= m_rigids[size_t(rigid)].mass.inverse() * (across * (excess / across.length()));
    if (!friction.isZero())
        m_x[At(rigid) + 1] -=
            m_rigids[size_t(rigid)].inertia.inverse() * (torque * std::min(excess / friction.length(), btScalar(1)));
}

bool qcElasticSystem::Solve(qcNodeElasticity* elasticity, const std::vector<qcNodeElasticity::LoadedBody>& bodies,
                            std::vector<qcElasticSpring>* springs)
{
    m_elasticity = elasticity;
    m_springs = springs;
    FindNodes(bodies);
    const int size = m_links.Number(At(int(m_rigids.size())));
    const bool isGuess = m_x.size() == size;
    for (Vector* vector : {&m_x, &m_forcesOfSprings, &m_right, &m_residual, &m_preconditioned, &m_direction, &m_image})
        vector->resize(size, btVector3(0, 0, 0));
    for (int i = 0; i < size; i++)
        if (!isGuess || (i < int(m_nodes.size()) && m_nodes[size_t(i)] == nullptr))
            m_x[i].setZero();
    MoveTied(&m_x);
    // What rests is displaced in each step alike.
    FindGroups();
    if (isGuess)
        m_elasticity->Update(m_x);
    FindInertia();
    SetStiffness();
    if (isGuess)
        UpdateSprings();
    SolveClosed(0);
    for (int round = 1; round < s_maxRounds && UpdateSprings(); round++)
    {
        m_elasticity->Update(m_x);
        FindInertia();
        SolveClosed(round);
    }
    // Elsewhere iterations go on to the end, and momentum would be lost.
    for (int i = 0; i < int(m_rigids.size()) && !m_elasticity->KeepsEnergy(); i++)
        LimitFriction(i);
    for (int i = 0; i < size; i++)
        if (!std::isfinite(m_x[i].length2()))
        {
            m_x.clear();
            return false;
        }
    return true;
}

qcRigidDisplacement qcElasticSystem::DisplacementOf(int rigid) const
{
    const btRigidBody& body = *m_rigids[size_t(rigid)].body;
    return {m_x[At(rigid) + 1] * FreedomOf(body.getAngularFactor()),
            m_x[At(rigid)] * FreedomOf(body.getLinearFactor())};
}

void qcElasticSystem::Apply(btScalar timeStep)
{
    // Rotations are finite: what is anchored stays at its place on the body.
    for (const Tied& tied : m_tied)
        if (tied.point.rigid >= 0)
        {
            const btTransform& from = m_rigids[size_t(tied.point.rigid)].body->getWorldTransform();
            const btVector3& place = m_nodes[size_t(tied.node)]->m_x;
            m_x[tied.node] = qcDisplaced(from, DisplacementOf(tied.point.rigid)) * from.invXform(place) - place;
        }
    for (size_t i = 0; i < m_nodes.size(); i++)
        if (m_nodes[i] != nullptr)
            m_elasticity->Move(size_t(m_bodyOfNode[i]), m_nodes[i], m_x[int(i)]);
    for (int i = 0; i < int(m_rigids.size()); i++)
    {
        btRigidBody& body = *m_rigids[size_t(i)].body;
        const qcRigidDisplacement by = DisplacementOf(i);
        const btScalar perDistance = m_rigids[size_t(i)].velocityShare / timeStep;
        body.setLinearVelocity(body.getLinearVelocity() + by.linear * perDistance);
        body.setAngularVelocity(body.getAngularVelocity() + by.angular * perDistance);
        body.setCenterOfMassTransform(qcDisplaced(body.getWorldTransform(), by));
    }
    m_links.Apply(m_x, timeStep);
}
