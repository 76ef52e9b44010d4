// Pairs of small meshes that a plane separates. Why contact is searched this far: plugin/docs/mesh_contact.md.
#include "mesh_contact/planes/plane_pairs.h"

#include "common/object_motion.h"
#include "common/parallel_loop.h"
#include "mesh_contact/planes/touching_faces.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btTransformUtil.h>

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
// Pairs that a thread takes at a time: of 2 to 10 microseconds each, so that fewer are not worth a second thread.
constexpr size_t s_block = 32;
// Hulls that have not met after so many advances pass very closely: they count as touching.
constexpr int s_maxAdvances = 32;

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

const qcPlacedSupport& SmallerOf(const qcPlacedSupport& a, const qcPlacedSupport& b)
{
    return a.mesh->Radius() < b.mesh->Radius() ? a : b;
}

Approach ApproachOf(const qcRigidMotion& motionA, const qcPlacedSupport& a, const qcRigidMotion& motionB,
                    const qcPlacedSupport& b, btScalar timeStep)
{
    const qcPlacedSupport& small = SmallerOf(a, b);
    const btVector3& centre = small.transform.getOrigin();
    return {(motionA.VelocityAt(centre) - motionB.VelocityAt(centre)) * timeStep,
            (motionA.angular - motionB.angular).length() * small.mesh->Radius() * timeStep};
}

/// True for static objects and rigid bodies; see qcRigidMotion.
bool HasKnownMotion(const btCollisionObject* object)
{
    return qcIsStatic(object) || btRigidBody::upcast(object) != nullptr;
}

/// The first time after `from` at which a pair that approaches has closed in by a gap; BT_LARGE_FLOAT: there is none.
/// `times`: the ends of the parts of the step in which it approaches evenly. closedAt(closed, from, to): by how much it
/// has closed in at the end of a part, `closed` at its start.
template <typename Closed>
btScalar FirstTimeOf(btScalar gap, btScalar from, const std::array<btScalar, 3>& times, const Closed& closedAt)
{
    btScalar closed = 0;
    for (btScalar to : times)
    {
        if (to <= from)
            continue;
        const btScalar next = closedAt(closed, from, to);
        if (next >= gap && next > closed)
            return closed >= gap ? from : from + (to - from) * (gap - closed) / (next - closed);
        from = to;
        closed = next;
    }
    return BT_LARGE_FLOAT;
}
} // namespace

/// Reads an object of one mesh that is in the scene.
void qcPlanePairs::ReadBody(const btCollisionObject* object, const qcBatchObject& gathered)
{
    if (gathered.meshes.size() != 1 || !gathered.meshes.front().placed)
        return;
    size_t slot = gathered.meshes.front().id.slot;
    m_bodies.resize(std::max(m_bodies.size(), slot + 1));
    Body& body = m_bodies[slot];
    const btRigidBody* rigid = btRigidBody::upcast(object);
    if (!body.isKnown)
        body = {true, m_cache.FindMesh(object), qcRigidMotion(object), rigid != nullptr ? rigid->getInvMass() : 0};
}

/// An object's mesh and its place; a null mesh: it does not consist of one small mesh.
qcPlacedSupport qcPlanePairs::SideOf(const qcBatchObject& gathered) const
{
    const bool isPlaced = gathered.meshes.size() == 1 && gathered.meshes.front().placed;
    if (!isPlaced)
        return {nullptr, btTransform::getIdentity()};
    const qcBatchMesh& mesh = gathered.meshes.front();
    return {m_bodies[mesh.id.slot].mesh, mesh.transform};
}

/// True if both objects consist of one small mesh each.
bool qcPlanePairs::AreSmall(const qcBatchPair& pair) const
{
    return SideOf(*pair.gathered0).mesh != nullptr && SideOf(*pair.gathered1).mesh != nullptr;
}

/// Computes the contact of a pair. Calls with different workers may run at once.
qcPlanePairs::Result qcPlanePairs::ComputePair(const qcBatchPair& duePair, size_t index, uint32_t worker)
{
    Result result{};
    if (!AreSmall(duePair))
        return result;
    const btCollisionObject *object0 = duePair.object0, *object1 = duePair.object1;
    const qcBatchObject &a = *duePair.gathered0, &b = *duePair.gathered1;
    const uint32_t slotA = a.meshes.front().id.slot, slotB = b.meshes.front().id.slot;
    const qcPlacedSupport sideA = SideOf(a), sideB = SideOf(b);
    const qcSupportMesh *meshA = sideA.mesh, *meshB = sideB.mesh;
    const qcRigidMotion &motionA = m_bodies[slotA].motion, &motionB = m_bodies[slotB].motion;
    std::vector<qcMeshPoint>& points = m_workers[worker].points;
    Approach approach = ApproachOf(motionA, sideA, motionB, sideB, m_timeStep);
    btScalar threshold = std::min(a.threshold, b.threshold), margins = a.margin + b.margin;
    btScalar rest = qcBatchScene::s_restDistance * threshold;
    btScalar spacing = std::max(threshold, s_maxTurn * std::min(meshA->Radius(), meshB->Radius()));
    btScalar travelA = motionA.MaxSpeed(meshA->Radius()) * m_timeStep,
             travelB = motionB.MaxSpeed(meshB->Radius()) * m_timeStep;
    // The two may meet within these distances, or if others stop one of them.
    const btScalar always = std::min(threshold, rest + a.maxClosing + b.maxClosing), lead = a.lead + b.lead;
    btScalar max = approach.Max();
    if (std::max(travelA, travelB) > spacing)
        max = std::max({max, travelA, travelB});
    btVector3 guess = m_cache.GetAxis(object0, sideA.transform, object1, sideB.transform);
    qcSeparation separation;
    result.isTouching = guess.fuzzyZero() && qcFindTouchingFaces(sideA, sideB, &separation);
    if (!result.isTouching)
        separation = qcFindSeparation(sideA, sideB, guess, std::max(always, rest + max) + lead + margins,
                                      qcFaceSlack * threshold);
    m_cache.KeepAxis(object0, sideA.transform, object1, sideB.transform, separation.axis);
    btScalar closing = approach.Along(separation.axis);
    btScalar distance = std::max(always, rest + closing) + lead + margins;
    // Two that turn touch elsewhere than where they are nearest: samples follow the motion.
    const bool turns = !result.isTouching && separation.gap <= distance && approach.turn > spacing;
    if (turns && std::max(meshA->Triangles().count, meshB->Triangles().count) <= s_fewTriangles)
        return result;
    if (turns)
        distance = qcBatchScene::ContactDistance(a, b) + margins;
    result.pair = {slotA, slotB, false, worker, points.size(), points.size(), separation.gap};
    const bool isNear = separation.gap <= distance;
    // A slow body may be stopped by others: the two meet where it is within what it moves.
    const bool isSlowA = travelA <= spacing, isSlowB = travelB <= spacing, isFast = !isSlowA || !isSlowB;
    const btScalar slow = (isSlowA ? travelA : 0) + (isSlowB ? travelB : 0);
    Link link{sideA, sideB, slotA, slotB, {isSlowA, isSlowB}, false, separation, margins, rest, rest + slow, index};
    // Bodies that move across the plane may have passed each other when they reach it. Motions of links are not known.
    Meeting meeting{0, sideA, sideB, separation};
    const bool passes = isNear && !turns && isFast && separation.gap > rest + lead + margins &&
                        closing >= separation.gap - margins && HasKnownMotion(object0) && HasKnownMotion(object1) &&
                        !Meet(link, &meeting);
    if (meeting.time > 0)
        distance = std::max(always, link.reach + ClosingAfter(link, meeting)) + lead + margins;
    if (result.isTouching && isNear)
        qcPlaneContact::AddTouching(sideA, sideB, separation, &points);
    else if (isNear && !passes &&
             (separation.gap < -qcMaxHullOverlap * threshold ||
              !FindPointsOf(link, meeting, distance, turns || closing <= spacing || meeting.time > 0,
                            &m_workers[worker])))
        return result;
    result.pair.end = points.size();
    link.hasContact = isNear && !passes;
    if (!turns && isFast && separation.gap <= rest + max + margins)
        m_workers[worker].links.push_back(link);
    if (slotA > slotB)
    {
        std::swap(result.pair.low, result.pair.high);
        result.pair.isSwapped = true;
    }
    result.known = turns ? Contact::atStart : Contact::all;
    return result;
}

/// Collects the links of all workers, in the order of their pairs.
void qcPlanePairs::CollectLinks()
{
    m_links.clear();
    for (const Worker& worker : m_workers)
        m_links.insert(m_links.end(), worker.links.begin(), worker.links.end());
    std::sort(m_links.begin(), m_links.end(), [](const Link& x, const Link& y) { return x.pair < y.pair; });
}

/// Collects the pairs of which something is known.
void qcPlanePairs::CollectPairs()
{
    m_pairs.clear();
    for (const Result& result : m_results)
        if (result.known != Contact::none)
            m_pairs.push_back(result.pair);
    std::sort(m_pairs.begin(), m_pairs.end(),
              [](const Pair& x, const Pair& y) { return std::tie(x.low, x.high) < std::tie(y.low, y.high); });
}

void qcPlanePairs::Compute(const std::vector<qcBatchPair>& pairs, btScalar timeStep, unsigned threads)
{
    m_timeStep = timeStep;
    m_bodies.clear();
    for (const qcBatchPair& pair : pairs)
    {
        ReadBody(pair.object0, *pair.gathered0);
        ReadBody(pair.object1, *pair.gathered1);
        if (AreSmall(pair))
            m_cache.AddPair(pair.object0, pair.object1);
    }
    m_workers.resize(qcWorkersOf(threads));
    for (Worker& worker : m_workers)
    {
        worker.points.clear();
        worker.links.clear();
    }
    m_results.resize(pairs.size());
    qcForEach(uint32_t(m_workers.size()), pairs.size(), s_block,
              [&](size_t i, uint32_t worker) { m_results[i] = ComputePair(pairs[i], i, worker); });
    for (size_t i = 0; i < pairs.size(); i++)
        if (m_results[i].isTouching)
            m_cache.KeepTouching(pairs[i].object0, SideOf(*pairs[i].gathered0), pairs[i].object1,
                                 SideOf(*pairs[i].gathered1));
    CollectLinks();
    Follow();
    CollectPairs();
}

/// Where the mesh of a body is at a time: it moves until it is stopped.
btTransform qcPlanePairs::PlaceAt(uint32_t slot, const btTransform& start, btScalar time) const
{
    const Body& body = m_bodies[slot];
    btTransform centre = btTransform::getIdentity(), moved;
    centre.setOrigin(body.motion.centre);
    btTransformUtil::integrateTransform(centre, body.motion.linear, body.motion.angular, std::min(time, body.stopTime),
                                        moved);
    return moved * centre.inverse() * start;
}

/// The ends of the parts of the step in which the bodies of a pair move evenly.
std::array<btScalar, 3> qcPlanePairs::TimesOf(const Link& link) const
{
    std::array<btScalar, 3> times = {std::min(m_bodies[link.slotA].stopTime, m_timeStep),
                                     std::min(m_bodies[link.slotB].stopTime, m_timeStep), m_timeStep};
    std::sort(times.begin(), times.end());
    return times;
}

/// The motion of a body right after a time, about its place at an earlier one.
qcRigidMotion qcPlanePairs::MotionAt(uint32_t slot, btScalar since, btScalar time) const
{
    const Body& body = m_bodies[slot];
    qcRigidMotion motion = time < body.stopTime ? body.motion : qcRigidMotion();
    motion.centre = body.motion.centre + body.motion.linear * std::min(since, body.stopTime);
    return motion;
}

/// Upper bound of the mean speed, from a time of the step to its end, at which a pair closes in along the axis of a
/// meeting: by the motion of the smaller mesh relative to the larger one, where it is.
btScalar qcPlanePairs::ClosingSpeed(const Link& link, const Meeting& since, btScalar time) const
{
    const qcRigidMotion motionA = MotionAt(link.slotA, since.time, time),
                        motionB = MotionAt(link.slotB, since.time, time);
    const Approach speed = ApproachOf(motionA, since.a, motionB, since.b, 1);
    const qcPlacedSupport& small = SmallerOf(since.a, since.b);
    const btVector3& place = small.transform.getOrigin();
    const btScalar radius = small.mesh->Radius(), turnA = motionA.angular.length(), turnB = motionB.angular.length();
    const btScalar far = (place - motionA.centre).length() + (place - motionB.centre).length() + radius;
    // Velocities of turning bodies change within the step.
    const btScalar acceleration = (turnA * turnA + turnB * turnB) * far +
                                  2 * std::max(turnA, turnB) * (speed.linear.length() + radius * (turnA + turnB));
    return speed.linear.dot(since.separation.axis) + speed.turn + acceleration * (m_timeStep - since.time) / 2;
}

/// Upper bound of how far a pair closes in along the axis of a meeting until the end of the step.
btScalar qcPlanePairs::ClosingAfter(const Link& link, const Meeting& since) const
{
    btScalar from = since.time, closed = 0, largest = 0;
    for (btScalar to : TimesOf(link))
    {
        closed += to > from ? ClosingSpeed(link, since, from) * (to - from) : btScalar(0);
        largest = std::max(largest, closed);
        from = std::max(from, to);
    }
    return largest;
}

/// The first time at which a pair may have closed in by a gap along the axis of a meeting; BT_LARGE_FLOAT: not in this
/// step.
btScalar qcPlanePairs::TimeOfClosing(const Link& link, const Meeting& since, btScalar gap) const
{
    auto closedAt = [&](btScalar closed, btScalar from, btScalar to)
    { return closed + ClosingSpeed(link, since, from) * (to - from); };
    return FirstTimeOf(gap, since.time, TimesOf(link), closedAt);
}

/// How much a pair has closed in along its axis at a time.
btScalar qcPlanePairs::ClosingUntil(const Link& link, btScalar time) const
{
    const Body &a = m_bodies[link.slotA], &b = m_bodies[link.slotB];
    return (a.motion.linear * std::min(time, a.stopTime) - b.motion.linear * std::min(time, b.stopTime))
        .dot(link.separation.axis);
}

/// When a pair reaches the plane between the two; BT_LARGE_FLOAT: not in this step.
btScalar qcPlanePairs::TouchTime(const Link& link) const
{
    const btScalar gap = std::max(link.separation.gap - link.margins, btScalar(0));
    return FirstTimeOf(gap, 0, TimesOf(link), [&](btScalar, btScalar, btScalar to) { return ClosingUntil(link, to); });
}

/// Finds where two hulls come as near as contact at rest, from the start of the step, which `meeting` has, by
/// conservative advancement (Mirtich: Impulse-based dynamic simulation of rigid body systems, 1996): they can't meet
/// before they have closed in by the gap between them. False: not in this step, they pass each other.
bool qcPlanePairs::Meet(const Link& link, Meeting* meeting) const
{
    for (int i = 0; i < s_maxAdvances; i++)
    {
        const btScalar gap = meeting->separation.gap - link.margins - link.reach;
        if (gap <= 0)
            return true;
        meeting->time = TimeOfClosing(link, *meeting, gap);
        if (meeting->time > m_timeStep)
            return false;
        meeting->a.transform = PlaceAt(link.slotA, link.a.transform, meeting->time);
        meeting->b.transform = PlaceAt(link.slotB, link.b.transform, meeting->time);
        meeting->separation = qcFindSeparation(meeting->a, meeting->b, meeting->separation.axis, BT_LARGE_FLOAT, 0);
    }
    return true;
}

/// Finds the points of a pair where it meets, up to a distance beyond, and appends them where the bodies are at the
/// start. See qcPlaneContact::Find.
bool qcPlanePairs::FindPointsOf(const Link& link, const Meeting& meeting, btScalar distance, bool orClosest,
                                Worker* worker) const
{
    const size_t begin = worker->points.size();
    if (!worker->contact.Find(meeting.a, meeting.b, meeting.separation, distance, orClosest, &worker->points))
        return false;
    if (meeting.time <= 0)
        return true;
    const btTransform backA = link.a.transform * meeting.a.transform.inverse(),
                      backB = link.b.transform * meeting.b.transform.inverse();
    // The arm of the lighter body changes less; see qcBounces.
    const btScalar inverseA = m_bodies[link.slotA].inverseMass, inverseB = m_bodies[link.slotB].inverseMass;
    const btScalar partOfA = inverseA + inverseB > 0 ? inverseB / (inverseA + inverseB) : btScalar(0.5);
    for (size_t i = begin; i < worker->points.size(); i++)
    {
        qcMeshPoint& point = worker->points[i];
        point.onA = backA * point.onA;
        point.onB = backB * point.onB;
        point.AlignEnds(partOfA);
    }
    return true;
}

/// Adds the contact of a pair that touches since others have stopped one of its bodies, and stops the other one. True
/// if a body has been stopped earlier than before.
bool qcPlanePairs::FollowLink(Link* link)
{
    btScalar time = TouchTime(*link);
    if (time > m_timeStep)
        return false;
    // What is not next to each other at the start may pass each other.
    Meeting meeting{0, link->a, link->b, link->separation};
    if (link->separation.gap > link->rest + link->margins && !Meet(*link, &meeting))
        return false;
    time = std::max(time, meeting.time);
    if (!link->hasContact)
    {
        Pair& pair = m_results[link->pair].pair;
        Worker& worker = m_workers[pair.worker];
        const btScalar closing = ClosingUntil(*link, m_timeStep),
                       left = meeting.time > 0 ? ClosingAfter(*link, meeting) : closing;
        size_t begin = worker.points.size();
        link->hasContact = true;
        if (!FindPointsOf(*link, meeting, left + link->reach + link->margins, false, &worker))
        {
            link->separation.gap = BT_LARGE_FLOAT; // they pass each other
            return false;
        }
        pair.begin = begin;
        pair.end = worker.points.size();
        for (size_t i = begin; i < pair.end; i++)
            worker.points[i].endDistance = worker.points[i].distance - link->margins - closing;
    }
    Body &a = m_bodies[link->slotA], &b = m_bodies[link->slotB];
    btScalar stopA = link->isQuasiStatic[1] || b.stopTime <= time ? time : BT_LARGE_FLOAT;
    btScalar stopB = link->isQuasiStatic[0] || a.stopTime <= time ? time : BT_LARGE_FLOAT;
    bool changes = stopA < a.stopTime || stopB < b.stopTime;
    a.stopTime = std::min(a.stopTime, stopA);
    b.stopTime = std::min(b.stopTime, stopB);
    return changes;
}

/// Adds contact of bodies that follow one that is stopped in the step.
void qcPlanePairs::Follow()
{
    bool changes = true;
    for (int pass = 0; pass < qcMaxStops && changes; pass++)
    {
        changes = false;
        for (Link& link : m_links)
            changes = FollowLink(&link) || changes;
    }
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
        points->push_back(m_workers[pair->worker].points[i]);
        if (isSwapped)
            points->back().Swap();
    }
    return std::max(double(pair->gap), 0.0);
}
