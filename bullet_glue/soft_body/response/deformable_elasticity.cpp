// Bullet's forces as they are in btDeformableBackwardEulerObjective::multiply.
#include "soft_body/response/deformable_elasticity.h"

#include <BulletSoftBody/btDeformableBodySolver.h>

#include <algorithm>

namespace
{
// Steps after which what resists single nodes is found anew.
constexpr int s_maxAge = 100;

/// A colour for each node, so that neighbours have different ones: those that a link or a tetrahedron connects.
std::vector<int> ColourNodes(size_t count, const std::vector<qcNodeElasticity::LoadedBody>& bodies)
{
    std::vector<std::vector<int>> neighbours(count);
    auto connect = [&neighbours](const btSoftBody::Node* a, const btSoftBody::Node* b)
    {
        neighbours[size_t(a->index)].push_back(b->index);
        neighbours[size_t(b->index)].push_back(a->index);
    };
    for (const qcNodeElasticity::LoadedBody& loaded : bodies)
    {
        const btSoftBody& body = *loaded.soft->body;
        for (int i = 0; i < body.m_links.size(); i++)
            connect(body.m_links[i].m_n[0], body.m_links[i].m_n[1]);
        for (int i = 0; i < body.m_tetras.size(); i++)
            for (int k = 0; k < 6; k++)
            {
                static const int s_edges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
                btSoftBody::Node* const* nodes = body.m_tetras[i].m_n;
                connect(nodes[s_edges[k][0]], nodes[s_edges[k][1]]);
            }
    }
    std::vector<int> colours(count, -1);
    for (size_t i = 0; i < count; i++)
    {
        std::vector<bool> isTaken(neighbours[i].size() + 1, false);
        for (int neighbour : neighbours[i])
            if (colours[size_t(neighbour)] >= 0 && size_t(colours[size_t(neighbour)]) < isTaken.size())
                isTaken[size_t(colours[size_t(neighbour)])] = true;
        colours[i] = int(std::find(isTaken.begin(), isTaken.end(), false) - isTaken.begin());
    }
    return colours;
}

/// True for sheets that something holds.
bool IsHeldSheet(const btSoftBody& body)
{
    if (body.m_faces.size() == 0)
        return false;
    bool isHeld = body.m_deformableAnchors.size() > 0;
    for (int i = 0; i < body.m_nodes.size() && !isHeld; i++)
        isHeld = !(body.m_nodes[i].m_im > 0);
    return isHeld;
}
} // namespace

/// Bodies of tetrahedra, and sheets that are pinned or anchored: what is free gives way.
bool qcDeformableElasticity::Covers(const qcSceneSoftBody& soft) const
{
    return soft.moves && soft.body->isActive() && (soft.body->m_tetras.size() > 0 || IsHeldSheet(*soft.body));
}

/// Free sheets: the system costs more than all else in a step of those that only fall.
bool qcDeformableElasticity::CoversUnderLoad(const qcSceneSoftBody& soft) const
{
    return soft.moves && soft.body->isActive() && soft.body->m_faces.size() > 0;
}

/// False: Bullet's implicit solver without projection, of 3.24, doesn't move what is at rest, so that loads have no
/// counterpart there; or Bullet has numbered other nodes, as it does after one body was exchanged for another of as
/// many nodes.
bool qcDeformableElasticity::Begin(const std::vector<LoadedBody>& bodies, btScalar timeStep)
{
    const btDeformableBackwardEulerObjective& objective = *m_solver->m_objective;
    if (objective.m_implicit && !m_solver->m_useProjection)
        return false;
    m_timeStep = timeStep;
    m_bodies = bodies;
    for (const LoadedBody& loaded : bodies)
        for (int i = 0; i < loaded.soft->NodeCount(); i++)
        {
            const btSoftBody::Node& node = loaded.soft->body->m_nodes[i];
            if (node.index != loaded.soft->body->m_nodes[0].index + i || node.index < 0 ||
                node.index >= objective.m_nodes.size() || objective.m_nodes[node.index] != &node)
                return false;
        }
    m_forces.clear();
    for (int i = 0; i < objective.m_lf.size(); i++)
    {
        btDeformableLagrangianForce* force = objective.m_lf[i];
        auto isOf = [force](const LoadedBody& loaded)
        { return force->m_softBodies.findLinearSearch(loaded.soft->body) < force->m_softBodies.size(); };
        if (force->getForceType() != BT_GRAVITY_FORCE && std::any_of(bodies.begin(), bodies.end(), isOf))
            m_forces.push_back(force);
    }
    RelaxPressedLinks();
    return true;
}

void qcDeformableElasticity::RelaxPressedLinks()
{
    m_pressed.clear();
    for (const LoadedBody& loaded : m_bodies)
        for (int i = 0; i < loaded.soft->body->m_links.size(); i++)
        {
            btSoftBody::Link& link = loaded.soft->body->m_links[i];
            const btScalar length = (link.m_n[0]->m_q - link.m_n[1]->m_q).length();
            if (!(length < link.m_rl))
                continue;
            m_pressed.push_back({&link, link.m_rl});
            link.m_rl = length;
        }
}

void qcDeformableElasticity::End()
{
    for (const PressedLink& pressed : m_pressed)
        pressed.link->m_rl = pressed.restLength;
    m_pressed.clear();
}

int qcDeformableElasticity::NodeCount() const
{
    return m_solver->m_objective->m_nodes.size();
}

void qcDeformableElasticity::AddForces(const Vector& x, Vector* to) const
{
    for (btDeformableLagrangianForce* force : m_forces)
    {
        force->addScaledDampingForceDifferential(-m_timeStep, x, *to);
        force->addScaledElasticForceDifferential(-m_timeStep * m_timeStep, x, *to);
    }
}

/// Finds m_diagonal from the images of displacements of nodes of which no two are neighbours.
void qcDeformableElasticity::FindDiagonal(const std::vector<bool>& isNode)
{
    std::vector<qcObjectKey> keys;
    for (const LoadedBody& loaded : m_bodies)
        keys.emplace_back(loaded.soft->body, loaded.soft->uniqueId);
    const bool isKnown = m_diagonal.size() == isNode.size() && keys == m_bodiesOfDiagonal &&
                         m_forces == m_forcesOfDiagonal && m_timeStep == m_stepOfDiagonal;
    if (isKnown && ++m_ageOfDiagonal < s_maxAge)
        return;
    m_bodiesOfDiagonal = keys;
    m_forcesOfDiagonal = m_forces;
    m_stepOfDiagonal = m_timeStep;
    m_ageOfDiagonal = 0;
    m_diagonal.assign(isNode.size(), 0);
    Vector direction, image;
    direction.resize(int(isNode.size()));
    image.resize(int(isNode.size()));
    const std::vector<int> colours = ColourNodes(isNode.size(), m_bodies);
    const int count = colours.empty() ? 0 : *std::max_element(colours.begin(), colours.end()) + 1;
    for (int colour = 0; colour < count; colour++)
        for (int axis = 0; axis < 3; axis++)
        {
            qcSetZero(&direction);
            qcSetZero(&image);
            for (size_t i = 0; i < isNode.size(); i++)
                if (isNode[i] && colours[i] == colour)
                    direction[int(i)][axis] = 1;
            AddForces(direction, &image);
            for (size_t i = 0; i < isNode.size(); i++)
                if (isNode[i] && colours[i] == colour)
                    m_diagonal[i] += std::max(image[int(i)][axis], btScalar(0)) / 3;
        }
}

void qcDeformableElasticity::AddDiagonal(const std::vector<bool>& isNode, std::vector<btMatrix3x3>* to)
{
    FindDiagonal(isNode);
    for (size_t i = 0; i < isNode.size(); i++)
        for (int axis = 0; axis < 3; axis++)
            (*to)[i][axis][axis] += m_diagonal[i];
}

void qcDeformableElasticity::Move(size_t, btSoftBody::Node* node, const btVector3& by) const
{
    node->m_q = node->m_x += by;
    node->m_vn = node->m_v += by / m_timeStep;
}
