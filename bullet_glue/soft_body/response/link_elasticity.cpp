// The stiffness of a link is what Bullet's sweeps over it amount to.
#include "soft_body/response/link_elasticity.h"

#include <algorithm>

namespace
{
// Links are at most that stiff, in units of the masses that they may have to carry. A link that bears a body alone
// stretches by a twentieth of the body's fall in a step.
constexpr btScalar s_maxStiffness = 20;
// Sweeps over a link that leave more than this of a stretch resist less than the inertia of its nodes. Such links, as
// of bending, are often the most.
constexpr btScalar s_maxLeft = btScalar(0.5);
// Contacts that push nodes by less than this in a step, as a share of the default thickness (a twentieth of an edge of
// cloth), need no help.
constexpr btScalar s_strain = btScalar(0.1);
// The cosine between the weight of a body that lies on a sheet and the normal of a contact, at least.
constexpr btScalar s_downwards = btScalar(0.3);

/// The share of the stretch of one link that is left after all sweeps.
btScalar LeftOfStretch(const btSoftBody& body, const btSoftBody::Material& material)
{
    return btPow(btClamped(1 - material.m_kLST, btScalar(0), btScalar(1)), btScalar(body.m_cfg.piterations));
}

/// The stiffness of a link times the square of the step: that of the spring which gives its two nodes the displacement
/// of all sweeps, if only they moved. `left`: of its stretch.
btScalar LinkStiffness(const btSoftBody::Link& link, btScalar left, btScalar largest)
{
    const btScalar inverse = link.m_n[0]->m_im + link.m_n[1]->m_im;
    if (!(link.m_c0 > 0) || !(inverse > 0))
        return 0;
    return left * largest * inverse < 1 - left ? largest : (1 / left - 1) / inverse;
}

/// True if an anchor ties its node to a body that Bullet doesn't move.
bool Holds(const btSoftBody::Anchor& anchor)
{
    return anchor.m_body != nullptr && anchor.m_body->isStaticOrKinematicObject();
}
} // namespace

/// Sheets that are held. What is free gives way, and ropes solve links and contacts in turns.
bool qcLinkElasticity::Covers(const qcSceneSoftBody& soft) const
{
    if (!soft.moves || !soft.body->isActive() || soft.body->m_links.size() == 0 || soft.topology.ropeCount > 0)
        return false;
    for (int i = 0; i < soft.body->m_anchors.size(); i++)
        if (Holds(soft.body->m_anchors[i]))
            return true;
    for (uint32_t i = 0; i < uint32_t(soft.NodeCount()); i++)
        if (!(soft.InverseMass(i) > 0))
            return true;
    return false;
}

/// Not a body that the sheet lies on: it carries the sheet.
bool qcLinkElasticity::MayLie(const btRigidBody& rigid, const btVector3& normal) const
{
    return normal.dot(rigid.getGravity()) >= s_downwards * rigid.getGravity().length();
}

bool qcLinkElasticity::IsStrain(const qcSceneSoftBody& soft, btScalar pushed) const
{
    return pushed > s_strain * soft.topology.defaultThickness;
}

bool qcLinkElasticity::Begin(const std::vector<LoadedBody>& bodies, btScalar timeStep)
{
    m_firstNodes.assign(1, 0);
    m_perDistance.clear();
    m_isHeld.clear();
    m_springs.clear();
    for (const LoadedBody& loaded : bodies)
    {
        const btSoftBody& body = *loaded.soft->body;
        const int first = m_firstNodes.back();
        btScalar mass = loaded.load;
        for (int i = 0; i < body.m_nodes.size(); i++)
            if (body.m_nodes[i].m_im > 0)
                mass += 1 / body.m_nodes[i].m_im;
        const btSoftBody::Material* material = nullptr;
        btScalar left = 1;
        for (int i = 0; i < body.m_links.size(); i++)
        {
            const btSoftBody::Link& link = body.m_links[i];
            if (material != link.m_material)
            {
                material = link.m_material;
                left = LeftOfStretch(body, *material);
            }
            if (left > s_maxLeft)
                continue;
            const btVector3 along = link.m_n[1]->m_x - link.m_n[0]->m_x;
            const btScalar length2 = along.length2();
            const btScalar stiffness = LinkStiffness(link, left, s_maxStiffness * mass);
            if (stiffness > 0 && length2 > 0)
                m_springs.push_back(
                    {{first + int(loaded.soft->IndexOf(link.m_n[0])), first + int(loaded.soft->IndexOf(link.m_n[1]))},
                     along / btSqrt(length2),
                     btSqrt(length2),
                     stiffness,
                     0});
        }
        // btSoftBody::solveConstraints damps by the same factor.
        m_perDistance.push_back((1 - body.m_cfg.kDP) / timeStep);
        m_firstNodes.push_back(first + body.m_nodes.size());
        m_isHeld.resize(size_t(m_firstNodes.back()), false);
        for (int i = 0; i < body.m_anchors.size(); i++)
            if (Holds(body.m_anchors[i]))
                m_isHeld[size_t(first) + loaded.soft->IndexOf(body.m_anchors[i].m_node)] = true;
    }
    return !m_springs.empty();
}

void qcLinkElasticity::Update(const Vector& x)
{
    for (Spring& spring : m_springs)
        spring.tension =
            std::max(spring.stiffness / spring.length * spring.direction.dot(x[spring.nodes[1]] - x[spring.nodes[0]]),
                     btScalar(0));
}

void qcLinkElasticity::AddForces(const Vector& x, Vector* to) const
{
    // All four scalars of a vector at once: the compiler makes vector instructions of that.
    for (const Spring& spring : m_springs)
    {
        const btScalar *const x0 = x[spring.nodes[0]], *const x1 = x[spring.nodes[1]], *const d = spring.direction;
        btScalar motion[4], product[4], force[4];
        for (int i = 0; i < 4; i++)
            motion[i] = x1[i] - x0[i];
        for (int i = 0; i < 4; i++)
            product[i] = d[i] * motion[i];
        const btScalar along = (spring.stiffness - spring.tension) * (product[0] + product[1] + product[2]);
        for (int i = 0; i < 4; i++)
            force[i] = spring.tension * motion[i] + d[i] * along;
        btScalar *const to0 = (*to)[spring.nodes[0]], *const to1 = (*to)[spring.nodes[1]];
        for (int i = 0; i < 4; i++)
            to0[i] -= force[i];
        for (int i = 0; i < 4; i++)
            to1[i] += force[i];
    }
}

void qcLinkElasticity::AddDiagonal(const std::vector<bool>&, std::vector<btMatrix3x3>* to)
{
    for (const Spring& spring : m_springs)
    {
        const btVector3 &d = spring.direction, e = d * (spring.stiffness - spring.tension);
        btMatrix3x3 block(d.x() * e, d.y() * e, d.z() * e);
        for (int axis = 0; axis < 3; axis++)
            block[axis][axis] += spring.tension;
        for (int node : spring.nodes)
            (*to)[size_t(node)] += block;
    }
}

void qcLinkElasticity::Move(size_t body, btSoftBody::Node* node, const btVector3& by) const
{
    node->m_x += by;
    node->m_v += by * m_perDistance[body];
}
