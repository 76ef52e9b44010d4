// Pairs of small meshes that a plane separates. Why contact is searched this far: plugin/docs/mesh_contact.md.
#include "mesh_contact/plane_pairs.h"

#include "mesh_contact/touching_faces.h"

#include <algorithm>
#include <tuple>

namespace
{
// Bodies that move in a step by no more than the threshold, or than this part of the smaller one, stop others; two that
// turn by more are sampled.
constexpr btScalar s_maxTurn = btScalar(0.05);
// They are sampled by planes if one of the two has more triangles than this: 12 tori of 576 come to rest after 13 s
// then, and after 8 s if their triangles are sampled (qc-bench piles, seven seeds), at the same cost.
constexpr size_t s_fewTriangles = 600;

/// How fast two meshes approach each other: the motion of one relative to the other, where the smaller one is.
struct Approach
{
    btVector3 linear; ///< motion of A relative to B in a step, at the centre of the smaller mesh
    btScalar turn;    ///< upper bound of what rotation adds elsewhere in it

    /// Upper bound along any direction.
    btScalar Max() const
    {
        return linear.length() + turn;
    }
    btScalar Along(const btVector3& axis) const
    {
        return std::max(linear.dot(axis) + turn, btScalar(0));
    }
};

Approach ApproachOf(const qcRigidMotion& motionA, const qcPlacedSupport& a, const qcRigidMotion& motionB,
                    const qcPlacedSupport& b, btScalar timeStep)
{
    const qcPlacedSupport& small = a.mesh->Radius() < b.mesh->Radius() ? a : b;
    const btVector3& centre = small.transform.getOrigin();
    return {(motionA.VelocityAt(centre) - motionB.VelocityAt(centre)) * timeStep,
            (motionA.angular - motionB.angular).length() * small.mesh->Radius() * timeStep};
}
} // namespace

void qcPlanePairs::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_contactCount = 0;
    m_pairs.clear();
    m_points.clear();
    m_bodies.clear();
    m_links.clear();
}

/// The entry of an object of one mesh.
qcPlanePairs::Body& qcPlanePairs::BodyOf(const btCollisionObject* object, const qcBatchObject& gathered)
{
    size_t slot = gathered.meshes.front().id.slot;
    m_bodies.resize(std::max(m_bodies.size(), slot + 1));
    Body& body = m_bodies[slot];
    if (!body.isKnown)
        body = {true, m_cache.FindMesh(object), qcRigidMotion(object)};
    return body;
}

qcPlanePairs::Contact qcPlanePairs::AddPair(const btCollisionObject* object0, const qcBatchObject& a,
                                            const btCollisionObject* object1, const qcBatchObject& b)
{
    if (a.meshes.size() != 1 || b.meshes.size() != 1)
        return Contact::none;
    const qcBatchMesh &placedA = a.meshes.front(), &placedB = b.meshes.front();
    const qcSupportMesh *meshA = BodyOf(object0, a).mesh, *meshB = BodyOf(object1, b).mesh;
    if (meshA == nullptr || meshB == nullptr || !placedA.placed || !placedB.placed)
        return Contact::none;
    qcPlacedSupport sideA{meshA, placedA.transform}, sideB{meshB, placedB.transform};
    const qcRigidMotion &motionA = m_bodies[placedA.id.slot].motion, &motionB = m_bodies[placedB.id.slot].motion;
    Approach approach = ApproachOf(motionA, sideA, motionB, sideB, m_timeStep);
    btScalar threshold = std::min(a.threshold, b.threshold), margins = a.margin + b.margin;
    btScalar rest = qcBatchScene::s_restDistance * threshold;
    btScalar spacing = std::max(threshold, s_maxTurn * std::min(meshA->Radius(), meshB->Radius()));
    btScalar travelA = motionA.MaxSpeed(meshA->Radius()) * m_timeStep,
             travelB = motionB.MaxSpeed(meshB->Radius()) * m_timeStep;
    // The two may meet within this distance, or if others stop one of them.
    btScalar distance = std::min(threshold, rest + a.maxClosing + b.maxClosing), max = approach.Max();
    if (std::max(travelA, travelB) > spacing)
        max = std::max({max, travelA, travelB});
    btVector3 guess = m_cache.GetAxis(object0, sideA.transform, object1, sideB.transform);
    qcSeparation separation;
    bool isTouching = guess.fuzzyZero() && qcFindTouchingFaces(sideA, sideB, &separation);
    if (isTouching)
        m_cache.KeepTouching(object0, sideA, object1, sideB);
    else
        separation =
            qcFindSeparation(sideA, sideB, guess, std::max(distance, rest + max) + margins, qcFaceSlack * threshold);
    m_cache.KeepAxis(object0, sideA.transform, object1, sideB.transform, separation.axis);
    btScalar closing = approach.Along(separation.axis);
    distance = std::max(distance, rest + closing) + margins;
    // Two that turn touch elsewhere than where they are nearest: samples follow the motion.
    const bool turns = !isTouching && separation.gap <= distance && approach.turn > spacing;
    if (turns && std::max(meshA->Triangles().count, meshB->Triangles().count) <= s_fewTriangles)
        return Contact::none;
    if (turns)
        distance = qcBatchScene::ContactDistance(a, b) + margins;
    Pair pair{placedA.id.slot, placedB.id.slot, false, m_points.size(), m_points.size(), separation.gap};
    bool hasContact = separation.gap <= distance;
    if (hasContact)
    {
        if (isTouching)
            qcPlaneContact::AddTouching(sideA, sideB, separation, &m_points);
        else if (separation.gap < -qcMaxHullOverlap * threshold ||
                 !m_contact.Find(sideA, sideB, separation, distance, turns || closing <= spacing, &m_points))
            return Contact::none;
        pair.end = m_points.size();
        m_contactCount++;
    }
    if (!turns && std::max(travelA, travelB) > spacing && separation.gap <= rest + max + margins)
        m_links.push_back({sideA,
                           sideB,
                           pair.low,
                           pair.high,
                           {travelA <= spacing, travelB <= spacing},
                           hasContact,
                           separation,
                           margins,
                           rest,
                           m_pairs.size()});
    if (pair.low > pair.high)
    {
        std::swap(pair.low, pair.high);
        pair.isSwapped = true;
    }
    m_pairs.push_back(pair);
    return turns ? Contact::atStart : Contact::all;
}

/// How much a pair has closed in along its axis at a time.
btScalar qcPlanePairs::ClosingUntil(const Link& link, btScalar time) const
{
    const Body &a = m_bodies[link.slotA], &b = m_bodies[link.slotB];
    return (a.motion.linear * std::min(time, a.stopTime) - b.motion.linear * std::min(time, b.stopTime))
        .dot(link.separation.axis);
}

/// When a pair touches; BT_LARGE_FLOAT: not in this step.
btScalar qcPlanePairs::TouchTime(const Link& link) const
{
    btScalar gap = std::max(link.separation.gap - link.margins, btScalar(0));
    btScalar times[3] = {m_bodies[link.slotA].stopTime, m_bodies[link.slotB].stopTime, m_timeStep};
    std::sort(times, times + 3);
    btScalar from = 0, closed = 0;
    for (btScalar to : times)
    {
        to = std::min(to, m_timeStep);
        btScalar next = ClosingUntil(link, to);
        if (next > gap && next > closed)
            return closed >= gap ? from : from + (to - from) * (gap - closed) / (next - closed);
        from = to;
        closed = next;
    }
    return BT_LARGE_FLOAT;
}

/// Adds the contact of a pair that touches since others have stopped one of its bodies, and stops the other one. True
/// if a body has been stopped earlier than before.
bool qcPlanePairs::FollowLink(Link* link)
{
    btScalar time = TouchTime(*link);
    if (time > m_timeStep)
        return false;
    if (!link->hasContact)
    {
        Pair& pair = m_pairs[link->pair];
        btScalar closing = ClosingUntil(*link, m_timeStep);
        size_t begin = m_points.size();
        link->hasContact = true;
        if (!m_contact.Find(link->a, link->b, link->separation, closing + link->rest + link->margins, false, &m_points))
        {
            link->separation.gap = BT_LARGE_FLOAT; // they pass each other
            return false;
        }
        pair.begin = begin;
        pair.end = m_points.size();
        for (size_t i = begin; i < pair.end; i++)
            m_points[i].endDistance = m_points[i].distance - link->margins - closing;
        m_contactCount++;
    }
    Body &a = m_bodies[link->slotA], &b = m_bodies[link->slotB];
    btScalar stopA = link->isQuasiStatic[1] || b.stopTime <= time ? time : BT_LARGE_FLOAT;
    btScalar stopB = link->isQuasiStatic[0] || a.stopTime <= time ? time : BT_LARGE_FLOAT;
    bool changes = stopA < a.stopTime || stopB < b.stopTime;
    a.stopTime = std::min(a.stopTime, stopA);
    b.stopTime = std::min(b.stopTime, stopB);
    return changes;
}

void qcPlanePairs::End()
{
    bool changes = true;
    for (int pass = 0; pass < qcMaxStops && changes; pass++)
    {
        changes = false;
        for (Link& link : m_links)
            changes = FollowLink(&link) || changes;
    }
    std::sort(m_pairs.begin(), m_pairs.end(),
              [](const Pair& x, const Pair& y) { return std::tie(x.low, x.high) < std::tie(y.low, y.high); });
}

const qcPlanePairs::Pair* qcPlanePairs::Find(uint32_t slotA, uint32_t slotB) const
{
    auto key = std::minmax({slotA, slotB});
    auto isBefore = [](const Pair& pair, const std::pair<uint32_t, uint32_t>& slots)
    { return std::make_pair(pair.low, pair.high) < slots; };
    auto found = std::lower_bound(m_pairs.begin(), m_pairs.end(), key, isBefore);
    bool same = found != m_pairs.end() && found->low == key.first && found->high == key.second;
    return same ? &*found : nullptr;
}

double qcPlanePairs::AppendPoints(qcBodyId a, qcBodyId b, std::vector<qcMeshPoint>* points) const
{
    const Pair* pair = Find(a.slot, b.slot);
    if (pair == nullptr)
        return 0;
    bool isSwapped = (a.slot > b.slot) != pair->isSwapped;
    for (size_t i = pair->begin; i < pair->end; i++)
    {
        points->push_back(m_points[i]);
        qcMeshPoint& point = points->back();
        if (!isSwapped)
            continue;
        std::swap(point.onA, point.onB);
        std::swap(point.sourceA, point.sourceB);
        point.normal = -point.normal;
    }
    return std::max(double(pair->gap), 0.0);
}
