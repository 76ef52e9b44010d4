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
btScalar MaxSpeedBetween(const qcMovingObject& a, const qcMovingObject& b)
{
    qcRigidMotion motionA(a.object), motionB(b.object);
    const qcMovingObject& small = a.gathered->boxRadius < b.gathered->boxRadius ? a : b;
    return qcMaxSpeedBetween(motionA, motionB, small.object->getWorldTransform().getOrigin(),
                             small.gathered->boxRadius);
}

/// The time at which two bodies touched, by linear interpolation of their distance: `previous` at `previousTime`, and
/// `distance`, 0 or less, at `time`.
btScalar TouchTime(btScalar previousTime, btScalar previous, btScalar time, btScalar distance)
{
    return previous > 0 ? previousTime + (time - previousTime) * previous / (previous - distance) : previousTime;
}

/// Upper bound of the motion of a slow object in a step.
btScalar SlowTravelOf(const qcBatchObject& object)
{
    return std::max(object.threshold, s_slow * object.boxRadius);
}

btScalar MaxSpeedOf(const qcMovingObject& moving)
{
    return qcRigidMotion(moving.object).MaxSpeed(moving.gathered->boxRadius);
}
} // namespace

void qcImpactSampler::Begin(btScalar timeStep)
{
    m_timeStep = timeStep;
    m_sampleCount = 0;
    m_objects.clear();
    m_objectPairs.clear();
    m_objectPairOf.Clear(0);
    m_slots.clear();
    m_meshes.clear();
    m_stopTimes.clear();
    m_meshOf.Clear(0);
    m_pairs.clear();
    m_pairOf.Clear(0);
}

/// The index of an object, which is added if it is new. One of its meshes is in the scene.
uint32_t qcImpactSampler::AddObject(const qcMovingObject& moving)
{
    const std::vector<qcBatchMesh>& meshes = moving.gathered->meshes;
    const uint32_t first = moving.gathered->FirstPlaced()->id.slot;
    if (first < m_slots.size() && m_slots[first].object > 0)
        return m_slots[first].object - 1;
    m_objects.push_back({moving, qcRigidMotion(moving.object)});
    Object& object = m_objects.back();
    for (size_t i = 0; i < meshes.size(); i++)
    {
        if (!meshes[i].placed)
            continue;
        const uint32_t slot = meshes[i].id.slot;
        m_slots.resize(std::max(m_slots.size(), size_t(slot) + 1));
        m_slots[slot] = {uint32_t(m_objects.size()), uint32_t(i)};
        object.meshCount++;
        object.maxMargin = std::max(object.maxMargin, meshes[i].margin);
    }
    return uint32_t(m_objects.size()) - 1;
}

/// The index of a mesh of one of the objects, which is added if it is new.
size_t qcImpactSampler::AddMesh(uint32_t slot)
{
    const uint32_t index = m_meshOf.FindOrAdd(slot, uint32_t(m_meshes.size()));
    if (index == m_meshes.size())
    {
        const uint32_t object = m_slots[slot].object - 1;
        m_meshes.push_back({object, &m_objects[object].moving.gathered->meshes[m_slots[slot].mesh]});
        m_stopTimes.push_back(BT_LARGE_FLOAT);
    }
    return index;
}

/// Adds a pair of meshes of two objects, in the state that it has had so far.
qcImpactSampler::Pair& qcImpactSampler::AddMeshes(size_t objects, uint32_t slotA, uint32_t slotB)
{
    const auto [low, high] = std::minmax({slotA, slotB});
    m_pairOf.FindOrAdd(KeyOf(low, high), uint32_t(m_pairs.size()));
    m_pairs.emplace_back();
    Pair& pair = m_pairs.back();
    pair.objects = objects;
    pair.slotA = low;
    pair.slotB = high;
    pair.a = AddMesh(low);
    pair.b = AddMesh(high);
    pair.axis.setValue(0, 0, 0);
    return pair;
}

void qcImpactSampler::AddPair(const qcMovingObject& a, const qcMovingObject& b, const btVector3& axis)
{
    const uint32_t slotA = a.gathered->FirstPlaced()->id.slot, slotB = b.gathered->FirstPlaced()->id.slot;
    bool swapped = slotA > slotB;
    const qcMovingObject &low = swapped ? b : a, &high = swapped ? a : b;
    btScalar slow = std::min(SlowTravelOf(*a.gathered), SlowTravelOf(*b.gathered));
    btScalar travel = MaxSpeedBetween(low, high) * m_timeStep;
    btScalar travelLow = MaxSpeedOf(low) * m_timeStep, travelHigh = MaxSpeedOf(high) * m_timeStep;
    ObjectPair pair;
    pair.isQuasiStatic[0] = travelLow <= slow;
    pair.isQuasiStatic[1] = travelHigh <= slow;
    pair.isCoMoving = travel <= slow && !pair.isQuasiStatic[0] && !pair.isQuasiStatic[1];
    if (travel <= slow)
        travel = std::max(travelLow, travelHigh);
    // Velocities need not be finite.
    if (!(travel > slow) || !std::isfinite(travel))
        return;
    pair.a = AddObject(low);
    pair.b = AddObject(high);
    pair.sampleCount = int(std::min(btScalar(s_maxSamples), std::ceil(travel / slow)));
    pair.maxSpeed = travel / m_timeStep;
    pair.threshold = std::min(a.gathered->threshold, b.gathered->threshold);
    // The query at the beginning of the step assumes that co-moving bodies don't close in on each other.
    pair.contactDistance =
        pair.isCoMoving ? btScalar(0) : std::min(a.gathered->maxContactDistance, b.gathered->maxContactDistance);
    const size_t index = m_objectPairs.size();
    const auto [first, second] = std::minmax({pair.a, pair.b});
    m_objectPairOf.FindOrAdd(KeyOf(first, second), uint32_t(index));
    m_objectPairs.push_back(pair);
    // Hulls are compared without a query. A query reports those few meshes of compounds that come near each other.
    if (m_objects[pair.a].meshCount * m_objects[pair.b].meshCount == 1)
        AddMeshes(index, slotA, slotB).axis = swapped ? -axis : axis;
}

/// The pair of two meshes' objects; null: it is not fast.
const qcImpactSampler::ObjectPair* qcImpactSampler::FindObjects(uint32_t slotA, uint32_t slotB) const
{
    if (std::max(slotA, slotB) >= m_slots.size() || m_slots[slotA].object == 0 || m_slots[slotB].object == 0)
        return nullptr;
    const auto [low, high] = std::minmax({m_slots[slotA].object - 1, m_slots[slotB].object - 1});
    const uint32_t* index = m_objectPairOf.Find(KeyOf(low, high));
    return index != nullptr ? &m_objectPairs[*index] : nullptr;
}

/// Null: a mesh that goes on.
const qcImpactSampler::Mesh* qcImpactSampler::FindMesh(uint32_t slot) const
{
    const uint32_t* index = m_meshOf.Find(slot);
    return index != nullptr ? &m_meshes[*index] : nullptr;
}

const qcImpactSampler::Pair* qcImpactSampler::FindPair(uint32_t slotA, uint32_t slotB) const
{
    const auto [low, high] = std::minmax({slotA, slotB});
    const uint32_t* index = m_pairOf.Find(KeyOf(low, high));
    return index != nullptr ? &m_pairs[*index] : nullptr;
}

/// A stopped mesh stays where it was at its stop time.
btTransform qcImpactSampler::TransformAt(const Mesh& mesh, btScalar time) const
{
    const Object& object = m_objects[mesh.object];
    const btCollisionObject* moving = object.moving.object;
    if (time == 0 || qcIsStatic(moving))
        return mesh.placed->transform;
    const btTransform& now = moving->getWorldTransform();
    btTransform then;
    btTransformUtil::integrateTransform(now, object.motion.linear, object.motion.angular, std::min(time, mesh.stopTime),
                                        then);
    return then * (now.inverse() * mesh.placed->transform);
}

qcImpactSampler::PairTransforms qcImpactSampler::TransformsAt(const Pair& pair, btScalar time) const
{
    return {TransformAt(m_meshes[pair.a], time), TransformAt(m_meshes[pair.b], time)};
}

/// Places the meshes of an object that moves.
qcStatus qcImpactSampler::SetTransforms(qcScene* scene, const Object& object, btScalar time) const
{
    // Where those are that go on: see TransformAt.
    const btTransform &now = object.moving.object->getWorldTransform(), toObject = now.inverse();
    btTransform then;
    btTransformUtil::integrateTransform(now, object.motion.linear, object.motion.angular, time, then);
    qcStatus status = qc_statusOk;
    for (const qcBatchMesh& placed : object.moving.gathered->meshes)
    {
        if (!placed.placed)
            continue;
        const Mesh* kept = FindMesh(placed.id.slot);
        const btTransform place = time == 0         ? placed.transform
                                  : kept != nullptr ? TransformAt(*kept, time)
                                                    : then * (toObject * placed.transform);
        const qcTransform transform = qcTransformOf(place);
        status = qcFirstError(status, qcScene_SetTransform(scene, placed.id, &transform));
    }
    return status;
}

qcStatus qcImpactSampler::SetTransforms(qcScene* scene, btScalar time) const
{
    qcStatus status = qc_statusOk;
    for (const Object& object : m_objects)
        if (!qcIsStatic(object.moving.object))
            status = qcFirstError(status, SetTransforms(scene, object, time));
    return status;
}

/// True if the present pass samples two meshes of a pair of objects: the first one if these pass each other, else the
/// first one for which one of the two has stopped.
bool qcImpactSampler::IsOfPass(const ObjectPair& objects, const Mesh* a, const Mesh* b) const
{
    const int stopped = std::min(a != nullptr ? a->stopPass : s_never, b != nullptr ? b->stopPass : s_never);
    return m_pass == (objects.isCoMoving ? stopped : 0);
}

/// Co-moving bodies close in on each other only after one of them has stopped.
bool qcImpactSampler::IsClosing(const ObjectPair& objects, const Mesh* a, const Mesh* b, btScalar time) const
{
    return !objects.isCoMoving || (a != nullptr && a->IsStoppedAt(time)) || (b != nullptr && b->IsStoppedAt(time));
}

/// The number of pairs of meshes that the present pass samples.
uint64_t qcImpactSampler::CountOfPass(const ObjectPair& objects) const
{
    const Object &a = m_objects[objects.a], &b = m_objects[objects.b];
    if (!objects.isCoMoving)
        return m_pass == 0 ? a.meshCount * b.meshCount : 0;
    // All pairs that had not stopped before, but those of two meshes that go on.
    const uint64_t restA = a.meshCount - a.stoppedCount, restB = b.meshCount - b.stoppedCount;
    return restA * restB - (restA - a.newlyStoppedCount) * (restB - b.newlyStoppedCount);
}

bool qcImpactSampler::IsDue(void* context, uint32_t slotA, uint32_t slotB)
{
    const auto* sampler = static_cast<const qcImpactSampler*>(context);
    const ObjectPair* objects = sampler->FindObjects(slotA, slotB);
    if (objects == nullptr || !objects->isDue)
        return false;
    if (const Pair* pair = sampler->FindPair(slotA, slotB))
        return pair->isDue;
    const Mesh *a = sampler->FindMesh(slotA), *b = sampler->FindMesh(slotB);
    return sampler->IsOfPass(*objects, a, b) && sampler->IsClosing(*objects, a, b, sampler->m_time);
}

/// Selects the pairs of a pass: in the first one those that pass each other fast, later those with a stopped body.
/// False if there is none.
bool qcImpactSampler::SelectPairs()
{
    bool any = false;
    for (ObjectPair& objects : m_objectPairs)
    {
        objects.dueCount = CountOfPass(objects);
        objects.previousTime = 0;
        any = any || objects.dueCount > 0;
    }
    return any;
}

/// Selects the pairs of a sample, so that each has as many samples as it needs. False if there is none.
bool qcImpactSampler::SelectDue(int sample, int sampleCount)
{
    bool any = false;
    m_time = m_timeStep * btScalar(sample) / btScalar(sampleCount);
    for (ObjectPair& objects : m_objectPairs)
    {
        if (objects.isDue)
            objects.previousTime = m_timeStep * btScalar(sample - 1) / btScalar(sampleCount);
        bool next = sample * objects.sampleCount / sampleCount > (sample - 1) * objects.sampleCount / sampleCount;
        bool closing =
            !objects.isCoMoving || std::min(m_objects[objects.a].stopTime, m_objects[objects.b].stopTime) <= m_time;
        objects.isDue = objects.dueCount > 0 && next && closing;
        any = any || objects.isDue;
    }
    for (Pair& pair : m_pairs)
    {
        const ObjectPair& objects = m_objectPairs[pair.objects];
        const Mesh &a = m_meshes[pair.a], &b = m_meshes[pair.b];
        pair.isDue = objects.isDue && !pair.isDone && IsOfPass(objects, &a, &b) && IsClosing(objects, &a, &b, m_time);
    }
    return any;
}

/// Takes the points of a region that are beyond the contact distance at the beginning of the step, within it at the
/// end, and were apart at the previous sample. Moves their ends to the frames of the meshes. Returns when the bodies
/// touched, if that was since the previous sample.
btScalar qcImpactSampler::TakeRegion(qcMeshPoint* begin, qcMeshPoint* end, Pair* pair)
{
    const ObjectPair& objects = m_objectPairs[pair->objects];
    const Mesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    PairTransforms first{a.placed->transform, b.placed->transform}, previous = TransformsAt(*pair, pair->previousTime);
    btTransform toA = TransformAt(a, m_time).inverse(), toB = TransformAt(b, m_time).inverse();
    btScalar margins = a.placed->margin + b.placed->margin, travel = objects.maxSpeed * (m_time - pair->previousTime);
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
            stopTime = std::min(stopTime, TouchTime(pair->previousTime, last, m_time, point->distance - margins));
        const btVector3 none(0, 0, 0);
        const qcRigidMotion &motionA = m_objects[a.object].motion, &motionB = m_objects[b.object].motion;
        btVector3 travelA = a.IsStoppedAt(m_time) ? none : motionA.VelocityAt(first.a * point->onA) * m_timeStep;
        btVector3 travelB = b.IsStoppedAt(m_time) ? none : motionB.VelocityAt(first.b * point->onB) * m_timeStep;
        point->endDistance = distance - (travelB - travelA).dot(point->normal);
        if (deepest >= -s_maxDepth * travel && last >= 0 && distance > objects.contactDistance &&
            point->endDistance <= objects.contactDistance)
            pair->points.push_back(*point);
    }
    return stopTime;
}

/// True if points of a sample, with ends in the frames of the meshes, stop the pair before its next sample.
bool qcImpactSampler::IsStoppedBy(const std::vector<qcMeshPoint>& points, const Pair& pair) const
{
    const ObjectPair& objects = m_objectPairs[pair.objects];
    btScalar interval = m_timeStep / btScalar(objects.sampleCount);
    btScalar margins = m_meshes[pair.a].placed->margin + m_meshes[pair.b].placed->margin;
    PairTransforms next = TransformsAt(pair, m_time + interval);
    return std::any_of(points.begin(), points.end(),
                       [&](const qcMeshPoint& point)
                       { return next.DistanceOf(point) - margins < -s_maxNextDepth * objects.maxSpeed * interval; });
}

/// Takes the points of a pair from a sample, and updates the stop times.
void qcImpactSampler::TakePoints(std::vector<qcMeshPoint>* points, Pair* pair)
{
    ObjectPair& objects = m_objectPairs[pair->objects];
    const Mesh &a = m_meshes[pair->a], &b = m_meshes[pair->b];
    btScalar stopTime = BT_LARGE_FLOAT;
    for (size_t begin = 0, end = 0; begin < points->size(); begin = end)
    {
        while (end < points->size() && (*points)[end].region == (*points)[begin].region)
            end++;
        stopTime = std::min(stopTime, TakeRegion(points->data() + begin, points->data() + end, pair));
    }
    pair->isDone = pair->isDone || IsStoppedBy(*points, *pair);
    objects.dueCount -= pair->isDone;
    pair->previousTime = m_time;
    // Slots of two compounds may alternate.
    const bool isSwapped = a.object != objects.a;
    if (objects.isQuasiStatic[isSwapped] || a.IsStoppedAt(stopTime))
        m_stopTimes[pair->b] = std::min(m_stopTimes[pair->b], stopTime);
    if (objects.isQuasiStatic[!isSwapped] || b.IsStoppedAt(stopTime))
        m_stopTimes[pair->a] = std::min(m_stopTimes[pair->a], stopTime);
}

/// Samples a pair by the plane between its hulls, up to a distance. False: its triangles have to be tested.
bool qcImpactSampler::TestPlane(btScalar distance, Pair* pair)
{
    pair->isByPlane = false;
    if (pair->axis.fuzzyZero())
        return false;
    const ObjectPair& objects = m_objectPairs[pair->objects];
    PairTransforms now = TransformsAt(*pair, m_time);
    auto hullOf = [this](size_t mesh) { return m_objects[m_meshes[mesh].object].moving.hull; };
    const qcPlacedSupport a{hullOf(pair->a), now.a}, b{hullOf(pair->b), now.b};
    qcSeparation separation = qcFindSeparation(a, b, pair->axis, distance, qcFaceSlack * objects.threshold);
    btScalar maxOverlap = qcMaxHullOverlap * objects.threshold;
    if (separation.gap < -maxOverlap)
    {
        // Hulls that have passed through a plane since the previous sample are still next to it.
        maxOverlap = std::max(maxOverlap, s_maxPairDepth * objects.maxSpeed * (m_time - pair->previousTime));
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
        TakePoints(&m_points, pair);
    return pair->isByPlane;
}

/// Samples due pairs by planes. False if there are no others.
bool qcImpactSampler::TestPlanes(btScalar distance)
{
    bool anyTriangles = false;
    for (Pair& pair : m_pairs)
    {
        pair.isDue = pair.isDue && !TestPlane(distance, &pair);
        anyTriangles = anyTriangles || pair.isDue;
    }
    for (const ObjectPair& objects : m_objectPairs)
        anyTriangles =
            anyTriangles || (objects.isDue && m_objects[objects.a].meshCount * m_objects[objects.b].meshCount > 1);
    return anyTriangles;
}

/// Adds the pairs of meshes that a sample has found near each other, and no earlier one of the pass.
void qcImpactSampler::AddReported(const qcResult& result)
{
    for (size_t i = 0; i < result.manifoldCount; i++)
    {
        const qcManifold& manifold = result.manifolds[i];
        if (FindPair(manifold.bodyA, manifold.bodyB) != nullptr)
            continue;
        const ObjectPair* objects = FindObjects(manifold.bodyA, manifold.bodyB);
        if (objects == nullptr)
            continue;
        Pair& pair = AddMeshes(size_t(objects - m_objectPairs.data()), manifold.bodyA, manifold.bodyB);
        pair.isDue = true;
        if (IsClosing(*objects, &m_meshes[pair.a], &m_meshes[pair.b], objects->previousTime))
            pair.previousTime = objects->previousTime;
    }
}

/// Samples the due pairs by their triangles.
qcStatus qcImpactSampler::TestTriangles(qcScene* scene, const qcDetectDef& def)
{
    const qcResult* result = nullptr;
    qcStatus status = SetTransforms(scene, m_time);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &def, &result);
    if (status != qc_statusOk)
        return status;
    AddReported(*result);
    for (Pair& pair : m_pairs)
    {
        if (!pair.isDue)
            continue;
        const qcBatchMesh &a = *m_meshes[pair.a].placed, &b = *m_meshes[pair.b].placed;
        m_points.clear();
        qcAppendPoints(*result, a.id, a.sources, b.id, b.sources, &m_points);
        TakePoints(&m_points, &pair);
    }
    return status;
}

/// Marks the pairs of a pass as done, and what has stopped in it.
void qcImpactSampler::EndPass()
{
    for (ObjectPair& objects : m_objectPairs)
        objects.isDue = false;
    for (Pair& pair : m_pairs)
        pair.isDone = pair.isDone || IsOfPass(m_objectPairs[pair.objects], &m_meshes[pair.a], &m_meshes[pair.b]);
    m_pass++;
    for (Object& object : m_objects)
    {
        object.stoppedCount += object.newlyStoppedCount;
        object.newlyStoppedCount = 0;
        object.stopTime = BT_LARGE_FLOAT;
    }
    for (size_t i = 0; i < m_meshes.size(); i++)
    {
        Mesh& mesh = m_meshes[i];
        mesh.stopTime = m_stopTimes[i];
        if (mesh.stopPass != s_never || !mesh.IsStoppedAt(m_timeStep))
            continue;
        mesh.stopPass = m_pass;
        m_objects[mesh.object].newlyStoppedCount++;
        m_objects[mesh.object].stopTime = std::min(m_objects[mesh.object].stopTime, mesh.stopTime);
    }
}

/// Samples the selected pairs.
qcStatus qcImpactSampler::RunPass(qcScene* scene, const qcDetectDef& def)
{
    int sampleCount = 0;
    for (const ObjectPair& objects : m_objectPairs)
        if (objects.dueCount > 0)
            sampleCount = std::max(sampleCount, objects.sampleCount);
    qcStatus status = qc_statusOk;
    for (int sample = 1; sample <= sampleCount && status == qc_statusOk; sample++)
    {
        if (!SelectDue(sample, sampleCount))
            continue;
        m_sampleCount++;
        if (TestPlanes(btScalar(def.margin)))
            status = TestTriangles(scene, def);
    }
    EndPass();
    return status;
}

qcDetectDef qcImpactSampler::SampleDef(const qcDetectDef& def)
{
    double margins = 0;
    for (const ObjectPair& objects : m_objectPairs)
        margins = std::max(margins, double(m_objects[objects.a].maxMargin + m_objects[objects.b].maxMargin));
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
    m_pass = 0;
    if (!SelectPairs())
        return qc_statusOk;
    qcDetectDef sampleDef = SampleDef(def);
    qcStatus status = RunPass(scene, sampleDef);
    while (m_pass < qcMaxStops && status == qc_statusOk && SelectPairs())
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
