// Links of ropes in the response of contacts.
//
// Bullet solves links, then contacts push nodes off what they touch. A face is pushed as a whole, but a rope over an
// edge at some nodes only: the next step begins with stretched links, which pull these nodes into the edge by
// centimetres. Contacts that push that far let the rope creep, though friction would hold it. Solved in alternation,
// links and contacts converge to a rope under tension that lies still. Nodes at anchors stay where Bullet's solver has
// them: next to loads that swing. Cloth that bears a load by anchors is under tension as well.
#include "soft_body/response/rope_links.h"

#include <algorithm>

namespace
{
// Links of bodies with loads contract to this part of their lengths before the sweeps at most: few iterations of
// Bullet's solver leave them stretched, and loads away from their nodes. Those of other bodies contract to rest.
constexpr btScalar s_contracted = btScalar(0.97);

/// True if an anchor ties a body that moves to the soft one.
bool HasLoad(const btSoftBody& body)
{
    for (int i = 0; i < body.m_anchors.size(); i++)
        if (body.m_anchors[i].m_body != nullptr && body.m_anchors[i].m_body->getInvMass() > 0)
            return true;
    return false;
}
} // namespace

void qcRopeLinks::AddLink(Body* body, const btSoftBody::Link& link, btScalar contracted)
{
    // Bullet prepares m_c0 and m_c1 at the beginning of the step. A callback may have made nodes lighter since: with
    // the divisor of heavier ones each sweep would push them further apart.
    if (link.m_c0 <= 0)
        return;
    const btScalar divisor = (link.m_n[0]->m_im + link.m_n[1]->m_im) / link.m_material->m_kLST;
    qcSceneSoftBody& soft = *body->soft;
    const size_t nodes[2] = {soft.IndexOf(link.m_n[0]), soft.IndexOf(link.m_n[1])};
    const btScalar least2 = contracted * contracted * soft.positions[nodes[0]].distance2(soft.positions[nodes[1]]);
    m_links.push_back({{&soft.positions[nodes[0]], &soft.positions[nodes[1]]},
                       {&body->byLinks[nodes[0]], &body->byLinks[nodes[1]]},
                       {m_isAnchored[nodes[0]] ? 0 : link.m_n[0]->m_im, m_isAnchored[nodes[1]] ? 0 : link.m_n[1]->m_im},
                       std::max(link.m_c1, least2),
                       std::max(link.m_c0, divisor)});
}

void qcRopeLinks::Collect(qcSoftBodyScene& scene)
{
    m_bodies.clear();
    m_links.clear();
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        if (!soft.moves || !soft.inContact)
            continue;
        const bool isLoaded = HasLoad(*soft.body);
        if (soft.topology.looseLinks.empty() && !isLoaded)
            continue;
        m_bodies.push_back({&soft, std::vector<btVector3>(soft.positions.size(), btVector3(0, 0, 0))});
        Body* body = &m_bodies.back();
        m_isAnchored.assign(soft.positions.size(), false);
        for (const qcSoftAnchor& anchor : soft.anchors)
            m_isAnchored[anchor.node] = true;
        for (int i = 0; isLoaded && i < soft.body->m_links.size(); i++)
            AddLink(body, soft.body->m_links[i], s_contracted);
        for (size_t i = 0; !isLoaded && i < soft.topology.looseLinks.size(); i++)
            AddLink(body, soft.body->m_links[soft.topology.looseLinks[i].first], 0);
    }
}

void qcRopeLinks::Solve() const
{
    for (const Link& link : m_links)
    {
        btVector3 along = *link.position[1] - *link.position[0];
        btScalar length2 = along.length2();
        if (link.restLength2 + length2 <= SIMD_EPSILON)
            continue;
        along *= (link.restLength2 - length2) / (link.divisor * (link.restLength2 + length2));
        for (int end = 0; end < 2; end++)
        {
            const btVector3 by = along * (end == 0 ? -link.inverseMass[0] : link.inverseMass[1]);
            *link.position[end] += by;
            *link.byLinks[end] += by;
        }
    }
}

/// A rope that contracts in the sweeps would whip, if that gave it velocity. Its nodes keep the share of the motion by
/// links that leaves them the least kinetic energy: all of it where links hold nodes against contacts.
void qcRopeLinks::LimitVelocities() const
{
    for (const Body& body : m_bodies)
    {
        qcSceneSoftBody& soft = *body.soft;
        soft.LimitLinks(body.byLinks, 1,
                        [&](size_t i) { return soft.VelocityMotionOf(i, soft.VelocityStartOf(i)) - body.byLinks[i]; });
    }
}
