// The moments of a step.
//
// The motion is that of the velocities at the beginning. What the solver changes, because a body meets a third one say,
// is not foreseen: such a pair is met as deep as that takes it.
#include "mesh_ahead.h"

#include "mesh_motion.h"

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>

namespace
{
// Between two moments a pair passes by at most its contact breaking threshold, or this part of the smaller body: what
// is small beside that is pushed out again without harm. (At 2 % the same piles take 1.3 times as long and get in each
// other as deep.)
constexpr btScalar s_spacing = btScalar(0.05);
// A step has no more moments than this: what passes by more than a third of its size in one is not to be saved.
constexpr int s_mostMoments = 16;
// At a moment contact is looked for over this part of what is looked at in the beginning: the next moment is as far.
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
} // namespace

void qcMeshAhead::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_meshes.clear();
    m_indexOf.clear();
    m_pairs.clear();
}

size_t qcMeshAhead::Keep(const qcMovingMesh& mesh)
{
    auto [found, fresh] = m_indexOf.emplace(mesh.id.slot, m_meshes.size());
    if (fresh)
        m_meshes.push_back(mesh);
    return found->second;
}

void qcMeshAhead::Consider(const qcMovingMesh& a, const qcMovingMesh& b)
{
    btScalar spacing = std::max(std::min(a.threshold, b.threshold), s_spacing * std::min(a.radius, b.radius));
    btScalar moments = SpeedBetween(a, b) * m_timeStep / spacing;
    // Velocities may be anything.
    if (!(moments > 1) || !std::isfinite(moments))
        return;
    bool swapped = a.id.slot > b.id.slot;
    Pair pair;
    pair.a = Keep(swapped ? b : a);
    pair.b = Keep(swapped ? a : b);
    pair.slotA = m_meshes[pair.a].id.slot;
    pair.slotB = m_meshes[pair.b].id.slot;
    pair.moments = int(std::min(btScalar(s_mostMoments), std::ceil(moments)));
    m_pairs.push_back(pair);
}

int qcMeshAhead::CountMoments() const
{
    int most = 0;
    for (const Pair& pair : m_pairs)
        most = std::max(most, pair.moments);
    return most;
}

btTransform qcMeshAhead::At(const qcMovingMesh& mesh, btScalar time)
{
    if (time == 0 || mesh.object->isStaticObject())
        return mesh.transform;
    qcMeshMotion motion(mesh.object);
    const btTransform& now = mesh.object->getWorldTransform();
    btTransform then;
    btTransformUtil::integrateTransform(now, motion.linear, motion.angular, time, then);
    return then * (now.inverse() * mesh.transform);
}

qcStatus qcMeshAhead::Place(qcScene* scene, btScalar time) const
{
    qcStatus status = qc_statusOk;
    for (const qcMovingMesh& mesh : m_meshes)
    {
        if (mesh.object->isStaticObject())
            continue;
        qcTransform transform = qcTransformOf(At(mesh, time));
        qcStatus placed = qcScene_SetTransform(scene, mesh.id, &transform);
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

/// Each pair at as many of the moments as it needs; false if there is none.
bool qcMeshAhead::ChooseDue(int moment, int moments)
{
    bool any = false;
    for (Pair& pair : m_pairs)
    {
        pair.due = !pair.over && moment * pair.moments / moments > (moment - 1) * pair.moments / moments;
        any = any || pair.due;
    }
    return any;
}

/// Keeps the points that are out of reach at the beginning of the step, come near in it, and were apart at the moment
/// before this one.
void qcMeshAhead::Take(const qcResult& result, btScalar time, Pair* pair) const
{
    const qcMovingMesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    std::vector<qcMeshPoint> points;
    qcAppendPoints(result, a.id, *a.sources, b.id, *b.sources, &points);
    btTransform backA = At(a, time).inverse(), backB = At(b, time).inverse();
    Places first{a.transform, b.transform}, before{At(a, pair->before), At(b, pair->before)};
    qcMeshMotion motionA(a.object), motionB(b.object);
    btScalar shells = a.margin + b.margin, reach = std::min(a.reach, b.reach);
    btScalar spacing = SpeedBetween(a, b) * (time - pair->before);
    for (size_t from = 0, end = 0; from < points.size(); from = end)
    {
        btScalar deepest = 0;
        for (; end < points.size() && points[end].region == points[from].region; end++)
            deepest = std::min(deepest, points[end].distance - shells);
        pair->over = pair->over || deepest < -s_stopped * spacing;
        for (size_t i = from; i < end && deepest >= -s_fresh * spacing; i++)
        {
            qcMeshPoint& point = points[i];
            point.onA = backA * point.onA;
            point.onB = backB * point.onB;
            btScalar distance = first.Distance(point) - shells;
            btVector3 closing = motionB.At(first.b * point.onB) - motionA.At(first.a * point.onA);
            if (before.Distance(point) >= shells && distance > reach &&
                distance <= reach + closing.dot(point.normal) * m_timeStep)
                pair->points.push_back(point);
        }
    }
    pair->before = time;
}

qcStatus qcMeshAhead::Find(qcScene* scene, const qcDetectDef& def)
{
    std::sort(m_pairs.begin(), m_pairs.end(),
              [](const Pair& x, const Pair& y)
              { return std::make_pair(x.slotA, x.slotB) < std::make_pair(y.slotA, y.slotB); });
    double shells = 0;
    for (const Pair& pair : m_pairs)
        shells = std::max(shells, double(m_meshes[pair.a].margin + m_meshes[pair.b].margin));
    qcDetectDef ahead = def;
    ahead.margin = shells + double(s_reach) * std::max(def.margin - shells, 0.0);
    ahead.pairFilter = IsDue;
    ahead.pairFilterContext = this;
    // The planner learns nothing from these.
    ahead.method = qc_methodSweep;
    qcStatus status = qc_statusOk;
    int moments = CountMoments();
    for (int moment = 1; moment <= moments && status == qc_statusOk; moment++)
    {
        if (!ChooseDue(moment, moments))
            continue;
        btScalar time = m_timeStep * btScalar(moment) / btScalar(moments);
        const qcResult* result = nullptr;
        status = Place(scene, time);
        if (status == qc_statusOk)
            status = qcScene_Detect(scene, &ahead, &result);
        for (Pair& pair : m_pairs)
            if (status == qc_statusOk && pair.due)
                Take(*result, time, &pair);
    }
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
