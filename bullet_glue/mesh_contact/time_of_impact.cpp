// The moments of a step.
//
// The motion is that of the velocities at the beginning; of what the solver changes only that who meets what stands
// still stays there is foreseen.
#include "mesh_contact/time_of_impact.h"

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>

namespace
{
// Between two moments a pair passes by at most its contact breaking threshold, or this part of the smaller body: what
// is small beside that is pushed out again without harm. At 2 % the steps of qc-fracture (seed 1) took 1.4 times as
// long, and a pile of bunnies got no less deep into each other.
constexpr btScalar s_spacing = btScalar(0.05);
// A step has no more moments than this: enough for what passes by its own radius.
constexpr int s_mostMoments = 16;
// As many may follow each other.
constexpr int s_mostRounds = 16;
// At a moment contact is looked for over this part of what is looked at in the beginning: what is farther is nearer at
// the next one. Most of a moment's time is spent on pairs of triangles that are near, but do not touch.
constexpr btScalar s_reach = btScalar(0.5);
// A region whose deepest point is deeper than one moment brings it was met before, and lies askew by now.
constexpr btScalar s_fresh = 1;
// Two bodies deeper in each other than this, in moments, would have been stopped: the rest of the way is not theirs.
constexpr btScalar s_stopped = btScalar(1.5);

/// Where the bodies of a pair are at some time.
struct Places
{
    btTransform a, b;

    /// Of the ends of a point in the frames of their meshes, along its normal.
    btScalar Distance(const qcMeshPoint& point) const
    {
        return (a * point.onA - b * point.onB).dot(point.normal);
    }
};

/// By how much points of two bodies pass each other at most where both may be: within the smaller one.
btScalar SpeedBetween(const qcMovingMesh& a, const qcMovingMesh& b)
{
    qcMeshMotion motionA(a.object), motionB(b.object);
    const qcMovingMesh& small = a.radius < b.radius ? a : b;
    btVector3 centre = small.object->getWorldTransform().getOrigin();
    return (motionA.At(centre) - motionB.At(centre)).length() +
           (motionA.angular - motionB.angular).length() * small.radius;
}

/// Of two that were apart by the one distance and then by the other, which is 0 or less: when they met.
btScalar MeetingTime(btScalar before, btScalar last, btScalar time, btScalar distance)
{
    return last > 0 ? before + (time - before) * last / (last - distance) : before;
}

/// By how much it may move from one moment to the next.
btScalar SpacingOf(const qcMovingMesh& mesh)
{
    return std::max(mesh.threshold, s_spacing * mesh.radius);
}

btScalar SpeedOf(const qcMovingMesh& mesh)
{
    return qcMeshMotion(mesh.object).Fastest(mesh.radius);
}
} // namespace

void qcMeshAhead::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_momentCount = 0;
    m_meshes.clear();
    m_indexOf.clear();
    m_pairs.clear();
}

size_t qcMeshAhead::Keep(const qcMovingMesh& mesh)
{
    auto [found, fresh] = m_indexOf.emplace(mesh.id.slot, m_meshes.size());
    if (fresh)
        m_meshes.push_back({mesh, qcMeshMotion(mesh.object)});
    return found->second;
}

void qcMeshAhead::Consider(const qcMovingMesh& a, const qcMovingMesh& b)
{
    bool swapped = a.id.slot > b.id.slot;
    const qcMovingMesh &low = swapped ? b : a, &high = swapped ? a : b;
    btScalar least = std::min(SpacingOf(a), SpacingOf(b)), way = SpeedBetween(low, high) * m_timeStep;
    btScalar wayLow = SpeedOf(low) * m_timeStep, wayHigh = SpeedOf(high) * m_timeStep;
    Pair pair;
    pair.still[0] = wayLow <= least;
    pair.still[1] = wayHigh <= least;
    pair.follows = way <= least && !pair.still[0] && !pair.still[1];
    if (way <= least)
        way = std::max(wayLow, wayHigh);
    btScalar moments = way / least;
    // Velocities may be anything.
    if (!(moments > 1) || !std::isfinite(moments))
        return;
    pair.a = Keep(low);
    pair.b = Keep(high);
    pair.slotA = low.id.slot;
    pair.slotB = high.id.slot;
    pair.moments = int(std::min(btScalar(s_mostMoments), std::ceil(moments)));
    pair.speed = way / m_timeStep;
    // Those that follow were looked at as if they came no nearer.
    pair.reach = pair.follows ? btScalar(0) : std::min(a.reach, b.reach);
    m_pairs.push_back(pair);
}

/// As far as it comes: a mesh that stays has moved until then.
btTransform qcMeshAhead::At(const Mesh& mesh, btScalar time)
{
    const qcMovingMesh& moving = mesh.moving;
    if (time == 0 || moving.object->isStaticObject())
        return moving.transform;
    const btTransform& now = moving.object->getWorldTransform();
    btTransform then;
    btTransformUtil::integrateTransform(now, mesh.motion.linear, mesh.motion.angular, std::min(time, mesh.stop), then);
    return then * (now.inverse() * moving.transform);
}

qcStatus qcMeshAhead::Place(qcScene* scene, btScalar time) const
{
    qcStatus status = qc_statusOk;
    for (const Mesh& mesh : m_meshes)
    {
        if (mesh.moving.object->isStaticObject())
            continue;
        qcTransform transform = qcTransformOf(At(mesh, time));
        qcStatus placed = qcScene_SetTransform(scene, mesh.moving.id, &transform);
        status = status == qc_statusOk ? placed : status;
    }
    return status;
}

const qcMeshAhead::Pair* qcMeshAhead::PairOf(uint32_t slotA, uint32_t slotB) const
{
    auto key = std::minmax({slotA, slotB});
    auto isBefore = [](const Pair& pair, const std::pair<uint32_t, uint32_t>& slots)
    { return std::make_pair(pair.slotA, pair.slotB) < slots; };
    auto found = std::lower_bound(m_pairs.begin(), m_pairs.end(), key, isBefore);
    bool same = found != m_pairs.end() && found->slotA == key.first && found->slotB == key.second;
    return same ? &*found : nullptr;
}

bool qcMeshAhead::IsDue(void* context, uint32_t slotA, uint32_t slotB)
{
    const Pair* pair = static_cast<const qcMeshAhead*>(context)->PairOf(slotA, slotB);
    return pair != nullptr && pair->due;
}

/// The pairs of the next round: first those that pass each other fast, then those of which one stays now. False if
/// there is none.
bool qcMeshAhead::ChooseAsked(bool first)
{
    bool any = false;
    for (Pair& pair : m_pairs)
    {
        bool stays = m_meshes[pair.a].Stays(m_timeStep) || m_meshes[pair.b].Stays(m_timeStep);
        pair.asked = !pair.over && (first ? !pair.follows : stays);
        any = any || pair.asked;
    }
    return any;
}

/// Each of them at as many of the moments as it needs; false if there is none.
bool qcMeshAhead::ChooseDue(int moment, int moments)
{
    bool any = false;
    for (Pair& pair : m_pairs)
    {
        bool more = moment * pair.moments / moments > (moment - 1) * pair.moments / moments;
        // Until one of them stays, those who follow come no nearer.
        btScalar time = m_timeStep * btScalar(moment) / btScalar(moments);
        bool apart = !pair.follows || m_meshes[pair.a].Stays(time) || m_meshes[pair.b].Stays(time);
        pair.due = pair.asked && !pair.over && more && apart;
        any = any || pair.due;
    }
    return any;
}

/// Keeps the points that are out of reach at the beginning of the step, come near in it, and were apart at the moment
/// before this one.
void qcMeshAhead::Take(const qcResult& result, btScalar time, Pair* pair)
{
    const Mesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    std::vector<qcMeshPoint> points;
    qcAppendPoints(result, a.moving.id, *a.moving.sources, b.moving.id, *b.moving.sources, &points);
    btTransform backA = At(a, time).inverse(), backB = At(b, time).inverse();
    Places first{a.moving.transform, b.moving.transform}, before{At(a, pair->before), At(b, pair->before)};
    btScalar shells = a.moving.margin + b.moving.margin;
    btScalar passed = pair->speed * (time - pair->before), stop = BT_LARGE_FLOAT;
    for (size_t from = 0, end = 0; from < points.size(); from = end)
    {
        btScalar deepest = 0;
        for (; end < points.size() && points[end].region == points[from].region; end++)
            deepest = std::min(deepest, points[end].distance - shells);
        pair->over = pair->over || deepest < -s_stopped * passed;
        for (size_t i = from; i < end; i++)
        {
            qcMeshPoint& point = points[i];
            point.onA = backA * point.onA;
            point.onB = backB * point.onB;
            btScalar distance = first.Distance(point) - shells, last = before.Distance(point) - shells;
            if (point.distance <= shells && last > point.distance - shells)
                stop = std::min(stop, MeetingTime(pair->before, last, time, point.distance - shells));
            btVector3 wayA = a.Stays(time) ? btVector3(0, 0, 0) : a.motion.At(first.a * point.onA) * m_timeStep;
            btVector3 wayB = b.Stays(time) ? btVector3(0, 0, 0) : b.motion.At(first.b * point.onB) * m_timeStep;
            point.ahead = distance - (wayB - wayA).dot(point.normal);
            if (deepest >= -s_fresh * passed && last >= 0 && distance > pair->reach && point.ahead <= pair->reach)
                pair->points.push_back(point);
        }
    }
    pair->before = time;
    if (pair->still[0] || a.Stays(stop))
        m_stops[pair->b] = std::min(m_stops[pair->b], stop);
    if (pair->still[1] || b.Stays(stop))
        m_stops[pair->a] = std::min(m_stops[pair->a], stop);
}

/// Goes through the moments with the pairs that are asked for, which are over then.
qcStatus qcMeshAhead::Look(qcScene* scene, const qcDetectDef& def)
{
    int moments = 0;
    for (const Pair& pair : m_pairs)
        if (pair.asked)
            moments = std::max(moments, pair.moments);
    qcStatus status = qc_statusOk;
    for (int moment = 1; moment <= moments && status == qc_statusOk; moment++)
    {
        if (!ChooseDue(moment, moments))
            continue;
        m_momentCount++;
        btScalar time = m_timeStep * btScalar(moment) / btScalar(moments);
        const qcResult* result = nullptr;
        status = Place(scene, time);
        if (status == qc_statusOk)
            status = qcScene_Detect(scene, &def, &result);
        for (Pair& pair : m_pairs)
            if (status == qc_statusOk && pair.due)
                Take(*result, time, &pair);
    }
    for (Pair& pair : m_pairs)
        pair.over = pair.over || pair.asked;
    for (size_t i = 0; i < m_meshes.size(); i++)
        m_meshes[i].stop = m_stops[i];
    return status;
}

qcStatus qcMeshAhead::Find(qcScene* scene, const qcDetectDef& def)
{
    if (!ChooseAsked(true))
        return qc_statusOk;
    std::sort(m_pairs.begin(), m_pairs.end(),
              [](const Pair& x, const Pair& y)
              { return std::make_pair(x.slotA, x.slotB) < std::make_pair(y.slotA, y.slotB); });
    double shells = 0;
    for (const Pair& pair : m_pairs)
        shells = std::max(shells, double(m_meshes[pair.a].moving.margin + m_meshes[pair.b].moving.margin));
    qcDetectDef ahead = def;
    ahead.margin = shells + double(s_reach) * std::max(def.margin - shells, 0.0);
    ahead.pairFilter = IsDue;
    ahead.pairFilterContext = this;
    // The planner learns nothing from these.
    ahead.method = qc_methodSweep;
    m_stops.assign(m_meshes.size(), BT_LARGE_FLOAT);
    qcStatus status = Look(scene, ahead);
    for (int round = 1; round < s_mostRounds && status == qc_statusOk && ChooseAsked(false); round++)
        status = Look(scene, ahead);
    qcStatus placed = Place(scene, 0);
    return status == qc_statusOk ? placed : status;
}

void qcMeshAhead::Append(qcBodyId a, const btTransform& transformA, qcBodyId b, const btTransform& transformB,
                         std::vector<qcMeshPoint>* points) const
{
    const Pair* pair = PairOf(a.slot, b.slot);
    if (pair == nullptr)
        return;
    bool swapped = a.slot > b.slot;
    for (qcMeshPoint point : pair->points)
    {
        if (swapped)
        {
            std::swap(point.onA, point.onB);
            std::swap(point.sourceA, point.sourceB);
            point.normal = -point.normal;
        }
        point.onA = transformA * point.onA;
        point.onB = transformB * point.onB;
        point.distance = (point.onA - point.onB).dot(point.normal);
        // The ends are not yet above each other. Bullet's points are: half of the way is given to each.
        btVector3 aside = (point.onA - point.onB - point.distance * point.normal) / 2;
        point.onA -= aside;
        point.onB += aside;
        points->push_back(point);
    }
}
