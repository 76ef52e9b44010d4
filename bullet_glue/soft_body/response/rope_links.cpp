// Links and anchors of ropes in the response of contacts.
//
// Bullet solves links, then contacts push nodes off what they touch. A face is pushed as a whole, but a rope over an
// edge at some nodes only: the next step begins with stretched links, which pull these nodes into the edge by
// centimetres. Contacts that push that far let the rope creep, though friction would hold it. Solved in alternation,
// links and contacts converge to a rope under tension that lies still. Without its anchors the rope would shorten off
// them. Cloth that bears a load by anchors is under tension as well.
#include "soft_body/response/rope_links.h"

#include <algorithm>

namespace
{
/// True if an anchor ties a body that moves to the soft one.
bool HasLoad(const btSoftBody& body)
{
    for (int i = 0; i < body.m_anchors.size(); i++)
        if (body.m_anchors[i].m_body != nullptr && body.m_anchors[i].m_body->getInvMass() > 0)
            return true;
    return false;
}
} // namespace

void qcRopeLinks::AddLink(Body* body, const btSoftBody::Link& link)
{
    // Bullet prepares m_c0 and m_c1 at the beginning of the step. A callback may have made nodes lighter since: with
    // the divisor of heavier ones each sweep would push them further apart.
    if (link.m_c0 <= 0)
        return;
    const btScalar divisor = (link.m_n[0]->m_im + link.m_n[1]->m_im) / link.m_material->m_kLST;
    qcSceneSoftBody& soft = *body->soft;
    const size_t nodes[2] = {soft.IndexOf(link.m_n[0]), soft.IndexOf(link.m_n[1])};
    m_links.push_back({{&soft.positions[nodes[0]], &soft.positions[nodes[1]]},
                       {&body->byLinks[nodes[0]], &body->byLinks[nodes[1]]},
                       {link.m_n[0]->m_im, link.m_n[1]->m_im},
                       link.m_c1,
                       std::max(link.m_c0, divisor)});
}

void qcRopeLinks::AddAnchor(qcSceneSoftBody& soft, const btSoftBody::Anchor& anchor)
{
    const btScalar share = anchor.m_influence * soft.body->m_cfg.kAHR;
    if (anchor.m_body == nullptr || !(anchor.m_node->m_im > 0) || !(share > 0))
        return;
    m_anchors.push_back({&soft.positions[soft.IndexOf(anchor.m_node)], anchor.m_body,
                         anchor.m_body->getWorldTransform() * anchor.m_local, anchor.m_c1, anchor.m_c0 * share,
                         anchor.m_c2});
}

void qcRopeLinks::Collect(qcSoftBodyScene& scene)
{
    m_bodies.clear();
    m_links.clear();
    m_anchors.clear();
    for (qcSceneSoftBody& soft : scene.Bodies())
    {
        if (!soft.moves || !soft.inContact)
            continue;
        const bool isLoaded = HasLoad(*soft.body);
        if (soft.topology.looseLinks.empty() && !isLoaded)
            continue;
        m_bodies.push_back({&soft, std::vector<btVector3>(soft.positions.size(), btVector3(0, 0, 0))});
        Body* body = &m_bodies.back();
        for (int i = 0; isLoaded && i < soft.body->m_links.size(); i++)
            AddLink(body, soft.body->m_links[i]);
        for (size_t i = 0; !isLoaded && i < soft.topology.looseLinks.size(); i++)
            AddLink(body, soft.body->m_links[soft.topology.looseLinks[i].first]);
        for (int i = 0; i < soft.body->m_anchors.size(); i++)
            AddAnchor(soft, soft.body->m_anchors[i]);
    }
}

void qcRopeLinks::Solve() const
{
    for (const Anchor& anchor : m_anchors)
    {
        const btVector3 impulse = anchor.impulse * (anchor.place - *anchor.position);
        *anchor.position += impulse * anchor.displacement;
        anchor.body->applyImpulse(-impulse, anchor.arm);
    }
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

/// A rope that few iterations of Bullet's solver leave stretched contracts in the sweeps. That gives it no velocity, or
/// it would whip: links may pass kinetic energy from node to node, and take it, but add none.
void qcRopeLinks::LimitVelocities() const
{
    for (const Body& body : m_bodies)
    {
        qcSceneSoftBody& soft = *body.soft;
        double work = 0, square = 0;
        for (size_t i = 0; i < body.byLinks.size(); i++)
        {
            const btScalar inverseMass = soft.body->m_nodes[int(i)].m_im;
            if (!(inverseMass > 0))
                continue;
            const btVector3 &by = body.byLinks[i], without = soft.VelocityMotionOf(i, soft.VelocityStartOf(i)) - by;
            work += double(by.dot(without) / inverseMass);
            square += double(by.length2() / inverseMass);
        }
        // The share of the motion by which the kinetic energy is what it is without.
        const double share = square > 0 ? std::min(std::max(-2 * work / square, 0.0), 1.0) : 1;
        if (!(share < 1))
            continue;
        soft.shifts.resize(soft.positions.size(), btVector3(0, 0, 0));
        for (size_t i = 0; i < body.byLinks.size(); i++)
            soft.shifts[i] += body.byLinks[i] * btScalar(1 - share);
    }
}
