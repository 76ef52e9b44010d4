// The state of a soft body over a step.
#include "soft_body/scene/scene_soft_body.h"

#include "common/finite.h"
#include "soft_body/scene/lone_bodies.h"

#include <algorithm>

namespace
{
// Anchors are at one point if they are no further apart than this share of both thicknesses.
constexpr btScalar s_tiedShare = btScalar(1e-3);

bool CanMove(const qcSoftAnchor& anchor)
{
    return anchor.object != nullptr && !anchor.object->isStaticOrKinematicObject();
}

/// Finds the neighbours of nodes that are anchored to objects that can move. `indices`: of the triangles.
void FindNeighbours(const std::vector<uint32_t>& indices, size_t nodeCount, std::vector<qcSoftAnchor>* anchors)
{
    std::vector<bool> isLoaded;
    for (const qcSoftAnchor& anchor : *anchors)
        if (CanMove(anchor))
        {
            isLoaded.resize(nodeCount, false);
            isLoaded[anchor.node] = true;
        }
    for (size_t i = 0; !isLoaded.empty() && i < indices.size(); i += 3)
        if (isLoaded[indices[i]] || isLoaded[indices[i + 1]] || isLoaded[indices[i + 2]])
            for (qcSoftAnchor& anchor : *anchors)
                if (CanMove(anchor) && anchor.IsOneOf(&indices[i]))
                    anchor.neighbours.insert(anchor.neighbours.end(), &indices[i], &indices[i] + 3);
}
} // namespace

bool qcCollidesWithSurfaces(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    using Collision = btSoftBody::fCollision;
    // Bullet places the nodes of a reduced model itself.
    const int flags = body->m_cfg.collisions;
    return (flags & Collision::RVSmask) != 0 && (flags & Collision::CL_RS) == 0 && !settings.bulletNodeContacts &&
           !body->m_reducedModel;
}

bool qcSceneSoftBody::ReadApplied(btVector3 btSoftBody::Node::*member)
{
    applied.clear();
    if (!hasEnd || positions.size() != size_t(NodeCount()) || positions.empty())
        return false;
    size_t same = 0;
    while (same < positions.size() && qcAreSame(positions[same], body->m_nodes[int(same)].*member))
        same++;
    if (same == positions.size())
        return true;
    btVector3 lower = positions[0], upper = lower;
    btScalar largest = 0;
    for (size_t i = 0; i < positions.size(); i++)
    {
        lower.setMin(positions[i]);
        upper.setMax(positions[i]);
        applied.push_back(body->m_nodes[int(i)].*member - positions[i]);
        largest = std::max(largest, applied[i].length2());
    }
    if (4 * largest <= (upper - lower).length2())
        return true;
    applied.clear();
    return false;
}

void qcSceneSoftBody::ReadCut(btVector3 btSoftBody::Node::*member)
{
    cutPositions.clear();
    for (int n = 0; n < NodeCount(); n++)
        cutPositions.push_back(body->m_nodes[n].*member);
}

void qcSceneSoftBody::FindRestored()
{
    const size_t count = size_t(NodeCount());
    isRestored = false;
    if (!hasEnd || positions.size() != count || velocities.size() != count)
        return;
    size_t free = 0, changed = 0;
    for (size_t i = 0; i < count; i++)
    {
        const btSoftBody::Node& node = body->m_nodes[int(i)];
        if (node.m_im <= 0)
            continue;
        free++;
        changed += !qcAreSame(node.m_x, positions[i]) && !qcAreSame(node.m_v, velocities[i]);
    }
    isRestored = 2 * changed > free;
}

void qcSceneSoftBody::ReadAnchors()
{
    pinned.clear();
    anchors.clear();
    // Bullet places the nodes of a reduced model, and those at its deformable anchors.
    if (body->m_reducedModel || body->m_deformableAnchors.size() > 0)
        pinned.resize(size_t(NodeCount()), body->m_reducedModel);
    for (int i = 0; i < body->m_anchors.size(); i++)
    {
        const btSoftBody::Anchor& anchor = body->m_anchors[i];
        anchors.push_back({uint32_t(IndexOf(anchor.m_node)), anchor.m_body, anchor.m_local, nullptr, {}});
    }
    for (int i = 0; i < body->m_deformableAnchors.size(); i++)
    {
        const btSoftBody::DeformableNodeRigidAnchor& anchor = body->m_deformableAnchors[i];
        const size_t node = IndexOf(anchor.m_node);
        pinned[node] = true;
        anchors.push_back({uint32_t(node), anchor.m_cti.m_colObj, anchor.m_local, nullptr, {}});
    }
    FindNeighbours(topology.indices, size_t(NodeCount()), &anchors);
}

bool qcSceneSoftBody::ReadSolved()
{
    bool isFinite = true;
    solved.resize(size_t(NodeCount()));
    for (size_t i = 0; i < solved.size(); i++)
    {
        solved[i] = body->m_nodes[int(i)].m_x;
        isFinite = isFinite && qcIsFinite(solved[i]);
    }
    if (!isFinite)
    {
        solved = start;
        moves = false;
    }
    hasSolvedBox = qcFindMotionBox(start, solved, 0, solvedBox);
    return isFinite;
}

bool qcSceneSoftBody::IsTiedTo(const qcSceneSoftBody& other, const uint32_t nodes[3],
                               const uint32_t nodesOfOther[3]) const
{
    const btScalar apart = s_tiedShare * (thickness + other.thickness);
    for (const qcSoftAnchor& anchor : anchors)
        if (anchor.IsOneOf(nodes))
            for (const qcSoftAnchor& second : other.anchors)
                if (second.object == anchor.object && second.IsOneOf(nodesOfOther) &&
                    second.local.distance2(anchor.local) <= apart * apart)
                    return true;
    return false;
}

bool qcSceneSoftBody::IsStretched(bool starts)
{
    if (!starts && IsSolved())
        return isSolvedStretched;
    const bool isStretched = qcIsStretchedChain(start, positions, thickness);
    if (starts)
        isSolvedStretched = isStretched;
    return isStretched;
}

void qcSceneSoftBody::Shift(const std::vector<btVector3>& by)
{
    shifts.resize(positions.size(), btVector3(0, 0, 0));
    for (size_t i = 0; i < by.size(); i++)
    {
        positions[i] += by[i];
        shifts[i] += by[i];
    }
}

btVector3 qcSceneSoftBody::VelocityMotionOf(size_t node, const btVector3& from) const
{
    const btVector3 motion = MotionOf(node, from);
    const btScalar length2 = applied.empty() ? btScalar(0) : applied[node].length2();
    if (!(length2 > 0))
        return motion;
    const btScalar taken = -applied[node].dot(MotionOf(node, solved[node])) / length2;
    return motion + applied[node] * std::min(std::max(taken, btScalar(0)), btScalar(1));
}

bool qcSceneSoftBody::FindMotionBox(btScalar reach, btVector3 box[2]) const
{
    if (!IsSolved())
        return qcFindMotionBox(start, positions, reach, box);
    box[0] = solvedBox[0];
    box[1] = solvedBox[1];
    qcEnlarge(reach, box);
    return hasSolvedBox;
}

namespace
{
constexpr btScalar s_friction = btScalar(0.3);
// m_cfg.kDF of a soft body whose application has not set it.
constexpr btScalar s_bulletsFriction = btScalar(0.2);

/// True if the friction is Bullet's m_cfg.kDF.
bool HasBulletsFriction(const qcSceneSoftBody& soft)
{
    return soft.settings.friction < 0 && soft.body->m_cfg.kDF != s_bulletsFriction;
}
} // namespace

btScalar qcSceneSoftBody::Friction() const
{
    return HasBulletsFriction(*this) ? body->m_cfg.kDF : settings.friction < 0 ? s_friction : settings.friction;
}

btScalar qcSceneSoftBody::FrictionOn(const btCollisionObject& rigid) const
{
    return HasBulletsFriction(*this) ? body->m_cfg.kDF * rigid.getFriction() : (Friction() + rigid.getFriction()) / 2;
}
