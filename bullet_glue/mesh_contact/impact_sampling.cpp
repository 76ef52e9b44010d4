// Sampling the rigid motion of a step. plugin/docs/mesh_contact.md
#include "mesh_contact/impact_sampling.h"

#include "common/first_error.h"
#include "common/object_motion.h"

#include <LinearMath/btTransformUtil.h>

#include <algorithm>
#include <cmath>

namespace
{
// A pair is fast if its bodies pass each other in a step by more than the contact breaking threshold and this part of
// the smaller body's radius: bodies that small a depth inside each other separate without harm. Between two samples
// they pass by no more, either. With samples four times as far apart qc-bench piles takes a tenth less while bodies
// fall, but the points of such a depth throw a ball that falls straight four times as far aside (test_mesh_impact).
constexpr btScalar s_slow = btScalar(0.05);
// Enough for bodies that pass each other by the radius of the smaller one.
constexpr int s_maxSamples = 16;
// Samples search this part of the query's distance: what is further away is nearer at the next sample. Most of a
// sample's time goes to pairs of triangles that are near, but don't touch.
constexpr btScalar s_queryDistance = btScalar(0.5);
// A region deeper than this, in units of the motion since the previous sample, was touched before that one: its normals
// are not reliable.
constexpr btScalar s_maxDepth = 1;
// Bodies deeper than this, in the same units, would have stopped before: later samples are not on their way.
constexpr btScalar s_maxPairDepth = btScalar(1.5);
// The points of a sample stop bodies that they will be this deep in at the next one, in the same units: it means
// nothing. It would cost most: where surfaces cross, all of their triangles have manifolds.
constexpr btScalar s_maxNextDepth = btScalar(0.5);

/// Upper bound of the speed at which points of two bodies pass each other where both can be: within the smaller body.
btScalar MaxSpeedBetween(const qcMovingMesh& a, const qcMovingMesh& b)
{
    qcRigidMotion motionA(a.object), motionB(b.object);
    const qcMovingMesh& small = a.radius < b.radius ? a : b;
    return qcMaxSpeedBetween(motionA, motionB, small.object->getWorldTransform().getOrigin(), small.radius);
}

/// The time at which two bodies touched, by linear interpolation of their distance: `previous` at `previousTime`, and
/// `distance`, 0 or less, at `time`.
btScalar TouchTime(btScalar previousTime, btScalar previous, btScalar time, btScalar distance)
{
    return previous > 0 ? previousTime + (time - previousTime) * previous / (previous - distance) : previousTime;
}

/// Upper bound of the motion of a slow mesh in a step.
btScalar SlowTravelOf(const qcMovingMesh& mesh)
{
    return std::max(mesh.threshold, s_slow * mesh.radius);
}

btScalar MaxSpeedOf(const qcMovingMesh& mesh)
{
    return qcRigidMotion(mesh.object).MaxSpeed(mesh.radius);
}
} // namespace

void qcImpactSampler::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_sampleCount = 0;
    m_meshes.clear();
    m_indexOf.clear();
    m_pairs.clear();
}

/// The index of a mesh, which is added if it is new.
size_t qcImpactSampler::AddMesh(const qcMovingMesh& mesh)
{
    auto [found, added] = m_indexOf.emplace(mesh.id.slot, m_meshes.size());
    if (added)
        m_meshes.push_back({mesh, qcRigidMotion(mesh.object)});
    return found->second;
}

void qcImpactSampler::AddPair(const qcMovingMesh& a, const qcMovingMesh& b, const btVector3& axis)
{
    bool swapped = a.id.slot > b.id.slot;
    const qcMovingMesh &low = swapped ? b : a, &high = swapped ? a : b;
    btScalar slow = std::min(SlowTravelOf(a), SlowTravelOf(b)), travel = MaxSpeedBetween(low, high) * m_timeStep;
    btScalar travelLow = MaxSpeedOf(low) * m_timeStep, travelHigh = MaxSpeedOf(high) * m_timeStep;
    Pair pair;
    pair.isQuasiStatic[0] = travelLow <= slow;
    pair.isQuasiStatic[1] = travelHigh <= slow;
    pair.isCoMoving = travel <= slow && !pair.isQuasiStatic[0] && !pair.isQuasiStatic[1];
    if (travel <= slow)
        travel = std::max(travelLow, travelHigh);
    // Velocities need not be finite.
    if (!(travel > slow) || !std::isfinite(travel))
        return;
    pair.a = AddMesh(low);
    pair.b = AddMesh(high);
    pair.slotA = low.id.slot;
    pair.slotB = high.id.slot;
    pair.sampleCount = int(std::min(btScalar(s_maxSamples), std::ceil(travel / slow)));
    pair.maxSpeed = travel / m_timeStep;
    pair.threshold = std::min(a.threshold, b.threshold);
    pair.axis = swapped ? -axis : axis;
    // The query at the beginning of the step assumes that co-moving bodies don't close in on each other.
    pair.contactDistance = pair.isCoMoving ? btScalar(0) : std::min(a.contactDistance, b.contactDistance);
    m_pairs.push_back(pair);
}

/// A stopped mesh stays where it was at its stop time.
btTransform qcImpactSampler::TransformAt(const Mesh& mesh, btScalar time)
{
    const qcMovingMesh& moving = mesh.moving;
    if (time == 0 || qcIsStatic(moving.object))
        return moving.transform;
    const btTransform& now = moving.object->getWorldTransform();
    btTransform then;
    btTransformUtil::integrateTransform(now, mesh.motion.linear, mesh.motion.angular, std::min(time, mesh.stopTime),
                                        then);
    return then * (now.inverse() * moving.transform);
}

qcImpactSampler::PairTransforms qcImpactSampler::TransformsAt(const Pair& pair, btScalar time) const
{
    return {TransformAt(m_meshes[pair.a], time), TransformAt(m_meshes[pair.b], time)};
}

qcStatus qcImpactSampler::SetTransforms(qcScene* scene, btScalar time) const
{
    qcStatus status = qc_statusOk;
    for (const Mesh& mesh : m_meshes)
    {
        if (qcIsStatic(mesh.moving.object))
            continue;
        qcTransform transform = qcTransformOf(TransformAt(mesh, time));
        status = qcFirstError(status, qcScene_SetTransform(scene, mesh.moving.id, &transform));
    }
    return status;
}

void qcImpactSampler::SortPairs()
{
    std::sort(m_pairs.begin(), m_pairs.end(),
              [](const Pair& x, const Pair& y)
              { return std::make_pair(x.slotA, x.slotB) < std::make_pair(y.slotA, y.slotB); });
}

const qcImpactSampler::Pair* qcImpactSampler::FindPair(uint32_t slotA, uint32_t slotB) const
{
    auto key = std::minmax({slotA, slotB});
    auto isBefore = [](const Pair& pair, const std::pair<uint32_t, uint32_t>& slots)
    { return std::make_pair(pair.slotA, pair.slotB) < slots; };
    auto found = std::lower_bound(m_pairs.begin(), m_pairs.end(), key, isBefore);
    bool same = found != m_pairs.end() && found->slotA == key.first && found->slotB == key.second;
    return same ? &*found : nullptr;
}

bool qcImpactSampler::IsDue(void* context, uint32_t slotA, uint32_t slotB)
{
    const Pair* pair = static_cast<const qcImpactSampler*>(context)->FindPair(slotA, slotB);
    return pair != nullptr && pair->isDue;
}

/// Selects the pairs of a pass: in the first one those that pass each other fast, later those with a stopped body.
/// False if there is none.
bool qcImpactSampler::SelectPairs(bool firstPass)
{
    bool any = false;
    for (Pair& pair : m_pairs)
    {
        bool hasStopped = m_meshes[pair.a].IsStoppedAt(m_timeStep) || m_meshes[pair.b].IsStoppedAt(m_timeStep);
        pair.isSelected = !pair.isDone && (firstPass ? !pair.isCoMoving : hasStopped);
        any = any || pair.isSelected;
    }
    return any;
}

/// Selects the pairs of a sample, so that each has as many samples as it needs. False if there is none.
bool qcImpactSampler::SelectDue(int sample, int sampleCount)
{
    bool any = false;
    for (Pair& pair : m_pairs)
    {
        bool next = sample * pair.sampleCount / sampleCount > (sample - 1) * pair.sampleCount / sampleCount;
        // Co-moving bodies close in on each other only after one of them has stopped.
        btScalar time = m_timeStep * btScalar(sample) / btScalar(sampleCount);
        bool closing = !pair.isCoMoving || m_meshes[pair.a].IsStoppedAt(time) || m_meshes[pair.b].IsStoppedAt(time);
        pair.isDue = pair.isSelected && !pair.isDone && next && closing;
        any = any || pair.isDue;
    }
    return any;
}

/// Takes the points of a region that are beyond the contact distance at the beginning of the step, within it at the
/// end, and were apart at the previous sample. Moves their ends to the frames of the meshes. Returns when the bodies
/// touched, if that was since the previous sample.
btScalar qcImpactSampler::TakeRegion(qcMeshPoint* begin, qcMeshPoint* end, btScalar time, Pair* pair)
{
    const Mesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    PairTransforms first{a.moving.transform, b.moving.transform}, previous = TransformsAt(*pair, pair->previousTime);
    btTransform toA = TransformAt(a, time).inverse(), toB = TransformAt(b, time).inverse();
    btScalar margins = a.moving.margin + b.moving.margin, travel = pair->maxSpeed * (time - pair->previousTime);
    btScalar deepest = 0, stopTime = BT_LARGE_FLOAT;
    for (qcMeshPoint* point = begin; point < end; point++)
    {
        point->onA = toA * point->onA;
        point->onB = toB * point->onB;
        // A separated point whose ends have passed each other is behind the surface that it passed.
        if (m_isFine && !pair->isByPlane && point->distance > 0 && first.DistanceOf(*point) < 0)
        {
            point->normal = -point->normal;
            point->distance = -point->distance;
            // Bodies that overlapped at the previous sample, too, would have stopped before.
            pair->isDone = pair->isDone || previous.DistanceOf(*point) < 0;
        }
        deepest = std::min(deepest, point->distance - margins);
    }
    pair->isDone = pair->isDone || deepest < -s_maxPairDepth * travel;
    for (qcMeshPoint* point = begin; point < end; point++)
    {
        btScalar distance = first.DistanceOf(*point) - margins, last = previous.DistanceOf(*point) - margins;
        if (point->distance <= margins && last > point->distance - margins)
            stopTime = std::min(stopTime, TouchTime(pair->previousTime, last, time, point->distance - margins));
        const btVector3 none(0, 0, 0);
        btVector3 travelA = a.IsStoppedAt(time) ? none : a.motion.VelocityAt(first.a * point->onA) * m_timeStep;
        btVector3 travelB = b.IsStoppedAt(time) ? none : b.motion.VelocityAt(first.b * point->onB) * m_timeStep;
        point->endDistance = distance - (travelB - travelA).dot(point->normal);
        if (deepest >= -s_maxDepth * travel && last >= 0 && distance > pair->contactDistance &&
            point->endDistance <= pair->contactDistance)
            pair->points.push_back(*point);
    }
    return stopTime;
}

/// True if points of a sample, with ends in the frames of the meshes, stop the pair before its next sample.
bool qcImpactSampler::IsStoppedBy(const std::vector<qcMeshPoint>& points, btScalar time, const Pair& pair) const
{
    btScalar interval = m_timeStep / btScalar(pair.sampleCount);
    btScalar margins = m_meshes[pair.a].moving.margin + m_meshes[pair.b].moving.margin;
    PairTransforms next = TransformsAt(pair, time + interval);
    return std::any_of(points.begin(), points.end(),
                       [&](const qcMeshPoint& point)
                       { return next.DistanceOf(point) - margins < -s_maxNextDepth * pair.maxSpeed * interval; });
}

/// Takes the points of a pair from a sample, and updates the stop times.
void qcImpactSampler::TakePoints(std::vector<qcMeshPoint>* points, btScalar time, Pair* pair)
{
    const Mesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    btScalar stopTime = BT_LARGE_FLOAT;
    for (size_t begin = 0, end = 0; begin < points->size(); begin = end)
    {
        while (end < points->size() && (*points)[end].region == (*points)[begin].region)
            end++;
        stopTime = std::min(stopTime, TakeRegion(points->data() + begin, points->data() + end, time, pair));
    }
    pair->isDone = pair->isDone || IsStoppedBy(*points, time, *pair);
    pair->previousTime = time;
    if (pair->isQuasiStatic[0] || a.IsStoppedAt(stopTime))
        m_stopTimes[pair->b] = std::min(m_stopTimes[pair->b], stopTime);
    if (pair->isQuasiStatic[1] || b.IsStoppedAt(stopTime))
        m_stopTimes[pair->a] = std::min(m_stopTimes[pair->a], stopTime);
}

/// Samples a pair by the plane between its hulls, up to a distance. False: its triangles have to be tested.
bool qcImpactSampler::TestPlane(btScalar distance, btScalar time, Pair* pair)
{
    pair->isByPlane = false;
    if (pair->axis.fuzzyZero())
        return false;
    PairTransforms now = TransformsAt(*pair, time);
    const qcPlacedSupport a{m_meshes[pair->a].moving.hull, now.a}, b{m_meshes[pair->b].moving.hull, now.b};
    qcSeparation separation = qcFindSeparation(a, b, pair->axis, distance, qcFaceSlack * pair->threshold);
    btScalar maxOverlap = qcMaxHullOverlap * pair->threshold;
    if (separation.gap < -maxOverlap)
    {
        // Hulls that have passed through a plane since the previous sample are still next to it.
        maxOverlap = std::max(maxOverlap, s_maxPairDepth * pair->maxSpeed * (time - pair->previousTime));
        separation = qcSeparation();
        separation.axis = pair->axis;
        separation.gap = qcGapAlong(a, b, pair->axis);
    }
    bool isNext = separation.gap >= -maxOverlap;
    pair->axis = isNext ? separation.axis : btVector3(0, 0, 0);
    m_points.clear();
    pair->isByPlane =
        separation.gap > distance || (isNext && m_contact.Find(a, b, separation, distance, true, &m_points));
    if (pair->isByPlane)
        TakePoints(&m_points, time, pair);
    return pair->isByPlane;
}

/// Samples the due pairs by their triangles.
qcStatus qcImpactSampler::TestTriangles(qcScene* scene, const qcDetectDef& def, btScalar time)
{
    const qcResult* result = nullptr;
    qcStatus status = SetTransforms(scene, time);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &def, &result);
    for (Pair& pair : m_pairs)
    {
        if (status != qc_statusOk || !pair.isDue)
            continue;
        const qcMovingMesh &a = m_meshes[pair.a].moving, &b = m_meshes[pair.b].moving;
        m_points.clear();
        qcAppendPoints(*result, a.id, *a.sources, b.id, *b.sources, &m_points);
        TakePoints(&m_points, time, &pair);
    }
    return status;
}

/// Samples the selected pairs and marks them as done.
qcStatus qcImpactSampler::RunPass(qcScene* scene, const qcDetectDef& def)
{
    int sampleCount = 0;
    for (const Pair& pair : m_pairs)
        if (pair.isSelected)
            sampleCount = std::max(sampleCount, pair.sampleCount);
    qcStatus status = qc_statusOk;
    for (int sample = 1; sample <= sampleCount && status == qc_statusOk; sample++)
    {
        if (!SelectDue(sample, sampleCount))
            continue;
        m_sampleCount++;
        btScalar time = m_timeStep * btScalar(sample) / btScalar(sampleCount);
        bool anyTriangles = false;
        for (Pair& pair : m_pairs)
        {
            pair.isDue = pair.isDue && !TestPlane(btScalar(def.margin), time, &pair);
            anyTriangles = anyTriangles || pair.isDue;
        }
        if (anyTriangles)
            status = TestTriangles(scene, def, time);
    }
    for (Pair& pair : m_pairs)
        pair.isDone = pair.isDone || pair.isSelected;
    for (size_t i = 0; i < m_meshes.size(); i++)
        m_meshes[i].stopTime = m_stopTimes[i];
    return status;
}

qcDetectDef qcImpactSampler::SampleDef(const qcDetectDef& def)
{
    double margins = 0;
    for (const Pair& pair : m_pairs)
        margins = std::max(margins, double(m_meshes[pair.a].moving.margin + m_meshes[pair.b].moving.margin));
    qcDetectDef sampleDef = def;
    sampleDef.margin = margins + double(s_queryDistance) * std::max(def.margin - margins, 0.0);
    // Bodies overlap at a sample; TakeRegion finds by their motion on which side of a surface a point lies.
    sampleDef.unoriented = m_isFine = def.spacing > 0;
    sampleDef.pairFilter = IsDue;
    sampleDef.pairFilterContext = this;
    // The planner's costs are those of the queries at the beginning of steps.
    sampleDef.method = qc_methodSweep;
    return sampleDef;
}

qcStatus qcImpactSampler::Sample(qcScene* scene, const qcDetectDef& def)
{
    SortPairs();
    if (!SelectPairs(true))
        return qc_statusOk;
    m_stopTimes.assign(m_meshes.size(), BT_LARGE_FLOAT);
    qcDetectDef sampleDef = SampleDef(def);
    qcStatus status = RunPass(scene, sampleDef);
    for (int pass = 1; pass < qcMaxStops && status == qc_statusOk && SelectPairs(false); pass++)
        status = RunPass(scene, sampleDef);
    return qcFirstError(status, SetTransforms(scene, 0));
}

void qcImpactSampler::AppendPoints(qcBodyId a, const btTransform& transformA, qcBodyId b, const btTransform& transformB,
                                   std::vector<qcMeshPoint>* points) const
{
    const Pair* pair = FindPair(a.slot, b.slot);
    if (pair == nullptr)
        return;
    bool swapped = a.slot > b.slot;
    for (qcMeshPoint point : pair->points)
    {
        if (swapped)
            point.Swap();
        point.onA = transformA * point.onA;
        point.onB = transformB * point.onB;
        point.AlignEnds();
        points->push_back(point);
    }
}
