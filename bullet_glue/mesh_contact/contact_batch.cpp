// Contact of all pairs of meshes in a world from one query a step.
#include "mesh_contact/contact_batch.h"

#include "common/finite.h"
#include "common/object_motion.h"
#include "common/parallel_loop.h"
#include "common/profiled_detect.h"
#include "common/stopwatch.h"
#include "mesh_contact/scene/draw_candidates.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Pairs that a thread takes at a time, each of half a microsecond.
constexpr size_t s_storeBlock = 128;
// Rounding of a place in an object's frame, as a part of the distances that take part.
constexpr btScalar s_placeError = 64 * SIMD_EPSILON;

/// True if one of the two is a ghost. Ghosts have pairs of their own, which character controllers process at other
/// times.
bool AreOfGhost(const btCollisionObject* a, const btCollisionObject* b)
{
    return ((a->getInternalType() | b->getInternalType()) & btCollisionObject::CO_GHOST_OBJECT) != 0;
}

/// The box of a mesh in the frame of another one, enlarged.
void BoxIn(const qcPlacedMesh& mesh, const qcPlacedMesh& frame, btScalar distance, btVector3 box[2])
{
    mesh.shape->getAabb(frame.transform.inverse() * mesh.transform, box[0], box[1]);
    // Half of its size more on each side: normals of contact points depend on the triangles around them.
    btVector3 grow = (box[1] - box[0]) / 2 + btVector3(distance, distance, distance);
    box[0] -= grow;
    box[1] += grow;
}

/// See qcBatchScene::GetSpacing, for a single pair.
btScalar SpacingOf(const btCollisionShape* a, const btCollisionShape* b)
{
    const btScalar edge = std::min(qcEdgeLengthOf(a, qcCountTriangles(a)), qcEdgeLengthOf(b, qcCountTriangles(b)));
    const btScalar threshold = qcContactDistance(a, b);
    return edge < threshold ? threshold : btScalar(0);
}
} // namespace

btScalar qcContactDistance(const btCollisionShape* a, const btCollisionShape* b)
{
    // Bullet enlarges boxes in the broadphase by one threshold each: shapes further apart are no pair.
    btScalar distance = 2 * gContactBreakingThreshold;
    return std::min({distance, a->getContactBreakingThreshold(gContactBreakingThreshold),
                     b->getContactBreakingThreshold(gContactBreakingThreshold)});
}

void qcContactBatch::Note(qcStatus status)
{
    if (status != qc_statusOk)
        statistics.status = status;
}

qcDetectDef qcContactBatch::DetectDef(btScalar margin, btScalar spacing) const
{
    qcDetectDef def = qcProfiledDetectDef();
    def.method = settings.method;
    def.margin = double(margin);
    def.manifolds = true;
    def.spacing = double(spacing);
    def.threads = settings.threads;
    return def;
}

/// Records an object that is not finite.
void qcContactBatch::LeaveOut(const btCollisionObject* object)
{
    if (statistics.notFinite == object)
        return;
    statistics.notFinite = object;
    Note(qc_statusBadInput);
    qcExplainNotFinite(*object);
}

/// Forgets what LeaveOut has recorded.
void qcContactBatch::ForgetLeftOut()
{
    if (statistics.notFinite != nullptr)
        statistics.status = qc_statusOk;
    statistics.notFinite = nullptr;
}

/// True, and recorded, if one of the two is not finite.
bool qcContactBatch::AreLeftOut(const qcPlacedMesh& a, const qcPlacedMesh& b)
{
    for (const qcPlacedMesh* mesh : {&a, &b})
        if (!qcIsFinite(*mesh->object) || !qcIsFinite(mesh->transform))
        {
            LeaveOut(mesh->object);
            return true;
        }
    return false;
}

/// Leaves what is known of all pairs, without the work of a step.
void qcContactBatch::ClearStatistics()
{
    ForgetLeftOut();
    qcMeshContactStatistics known;
    known.status = statistics.status;
    known.batches = statistics.batches;
    known.queries = statistics.queries;
    known.bodies = statistics.bodies;
    known.manifolds = statistics.manifolds;
    known.points = statistics.points;
    known.method = statistics.method;
    known.device = statistics.device;
    known.fallback = statistics.fallback;
    statistics = known;
}

/// Marks the meshes of an object, whose triangles have to be tested.
void qcContactBatch::MarkTriangles(const qcBatchObject& gathered)
{
    for (const qcBatchMesh& mesh : gathered.meshes)
    {
        if (!mesh.placed)
            continue;
        // All are marked if the first one is: a compound is in many pairs.
        m_triangleSlots.resize(std::max(m_triangleSlots.size(), size_t(mesh.id.slot) + 1));
        if (m_triangleSlots[mesh.id.slot])
            break;
        m_triangleSlots[mesh.id.slot] = 1;
    }
}

/// Computes the pairs that planes separate, and passes on the others that are fast.
void qcContactBatch::ReadPairs()
{
    BT_PROFILE("qcMeshContact planes");
    m_axes.BeginStep();
    const std::vector<qcBatchPair>& due = m_validity.GetDue();
    m_planes.Compute(due, m_scene.GetTimeStep(), settings.threads);
    m_impacts.Begin(m_scene.GetTimeStep());
    m_triangleSlots.clear();
    for (size_t i = 0; i < due.size(); i++)
    {
        const qcBatchPair& pair = due[i];
        const qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
        const qcPlanePairs::Contact known = m_planes.KnownOf(i);
        if (known == qcPlanePairs::Contact::all)
            continue;
        btVector3 axis(0, 0, 0);
        if (known == qcPlanePairs::Contact::atStart)
            axis = m_axes.GetAxis(pair.object0, a.meshes.front().transform, pair.object1, b.meshes.front().transform);
        if (a.FirstPlaced() == nullptr || b.FirstPlaced() == nullptr)
            continue;
        m_impacts.AddPair({pair.object0, &a, m_axes.FindMesh(pair.object0)},
                          {pair.object1, &b, m_axes.FindMesh(pair.object1)}, axis);
        if (known != qcPlanePairs::Contact::none)
            continue;
        MarkTriangles(a);
        MarkTriangles(b);
    }
    statistics.planes = m_planes.GetPairCount();
}

/// Finds contacts that fast pairs will have within the step.
void qcContactBatch::SampleImpacts()
{
    BT_PROFILE("qcMeshContact look ahead");
    double start = qcNowMs();
    Note(m_impacts.Sample(m_scene.Get(), DetectDef(m_scene.GetMargin(), m_scene.GetSpacing())));
    statistics.moments = m_impacts.GetSampleCount();
    statistics.aheadMs = qcNowMs() - start;
}

/// The pair of two meshes' objects; null: the batch does not have it.
qcPairContact* qcContactBatch::FindPair(uint32_t slotA, uint32_t slotB)
{
    size_t count = m_slots.size();
    uint32_t a = slotA < count ? m_slots[slotA].owner : 0, b = slotB < count ? m_slots[slotB].owner : 0;
    return a != 0 && b != 0 ? m_pairs.Find(a, b) : nullptr;
}

/// The pair of two meshes' objects if it is to be queried; null otherwise.
qcPairContact* qcContactBatch::FindDue(uint32_t slotA, uint32_t slotB)
{
    qcPairContact* pair = FindPair(slotA, slotB);
    return pair != nullptr && pair->isDue && pair->checked == m_validity.GetNumber() ? pair : nullptr;
}

bool qcContactBatch::HasPair(void* context, uint32_t slotA, uint32_t slotB)
{
    return static_cast<qcContactBatch*>(context)->FindPair(slotA, slotB) != nullptr;
}

bool qcContactBatch::NeedsTriangles(void* context, uint32_t slotA, uint32_t slotB)
{
    auto* batch = static_cast<qcContactBatch*>(context);
    const std::vector<uint8_t>& marks = batch->m_triangleSlots;
    if (std::max(slotA, slotB) >= marks.size() || !marks[slotA] || !marks[slotB])
        return false;
    return !batch->m_planes.Has(slotA, slotB) && batch->FindDue(slotA, slotB) != nullptr;
}

void qcContactBatch::NumberSlots()
{
    m_slots.clear();
    for (const qcBatchPair& pair : m_validity.GetDue())
        for (const qcBatchObject* gathered : {pair.gathered0, pair.gathered1})
            for (size_t i = 0; i < gathered->meshes.size(); i++)
            {
                if (!gathered->meshes[i].placed)
                    continue;
                const uint32_t slot = gathered->meshes[i].id.slot;
                m_slots.resize(std::max(m_slots.size(), size_t(slot) + 1));
                // All have their numbers if the first one has: a compound is in many pairs.
                if (m_slots[slot].owner != 0)
                    break;
                m_slots[slot] = {gathered->owner, uint32_t(i)};
            }
}

qcStatus qcContactBatch::Detect()
{
    BT_PROFILE("qcMeshContact detect");
    qcDetectDef def = DetectDef(m_scene.GetMargin(), m_scene.GetSpacing());
    def.candidates = m_reportsCandidates;
    // The distances of fine meshes take longer than what they save.
    def.proximities = def.spacing == 0;
    def.pairFilter = NeedsTriangles;
    def.pairFilterContext = this;
    qcStatus status = qcScene_Detect(m_scene.Get(), &def, &m_result);
    if (status != qc_statusOk)
        return status;
    const qcProfile& profile = m_result->profile;
    statistics.method = profile.method;
    statistics.device = profile.device;
    statistics.fallback = profile.fallback;
    // A reused result has the times of the step that computed it.
    if (!profile.reused)
    {
        statistics.cullMs = profile.cullObjectsMs + profile.cullTrianglesMs;
        statistics.sweepMs = profile.sweepObjectsMs + profile.sweepTrianglesMs;
        statistics.exactMs = profile.exactMs;
        statistics.manifoldMs = profile.manifoldMs;
    }
    return qc_statusOk;
}

/// Lists the pairs of meshes with points of the last query or of impact sampling: few of those of two compounds.
void qcContactBatch::ListMeshPairs()
{
    m_meshPairs.clear();
    auto add = [this](uint32_t slotA, uint32_t slotB)
    {
        const Slot *a = &m_slots[slotA], *b = &m_slots[slotB];
        if (a->owner > b->owner)
            std::swap(a, b);
        m_meshPairs.push_back({a->owner, b->owner, a->mesh, b->mesh});
    };
    for (size_t i = 0; i < m_result->manifoldCount; i++)
        add(m_result->manifolds[i].bodyA, m_result->manifolds[i].bodyB);
    m_impacts.ForEachPair(add);
    std::sort(m_meshPairs.begin(), m_meshPairs.end());
    m_meshPairs.erase(std::unique(m_meshPairs.begin(), m_meshPairs.end()), m_meshPairs.end());
}

/// Keeps the points of two meshes of a pair from the last query.
void qcContactBatch::StorePoints(const qcBatchPair& pair, uint32_t i, uint32_t j, std::vector<qcMeshPoint>* scratch,
                                 qcPairContact* contact) const
{
    std::vector<qcMeshPoint>& points = *scratch;
    const qcBatchMesh &meshA = pair.gathered0->meshes[i], &meshB = pair.gathered1->meshes[j];
    points.clear();
    if (m_planes.Has(meshA.id.slot, meshB.id.slot))
        contact->gap = m_planes.AppendPoints(meshA.id, meshB.id, &points);
    else
        qcAppendPoints(*m_result, meshA.id, meshA.sources, meshB.id, meshB.sources, &points);
    size_t found = points.size();
    for (size_t k = 0; k < found; k++)
        contact->regions += k == 0 || points[k].region != points[k - 1].region;
    m_impacts.AppendPoints(meshA.id, meshA.transform, meshB.id, meshB.transform, &points);
    for (qcMeshPoint& point : points)
    {
        point.onA = meshA.transform.invXform(point.onA);
        point.onB = meshB.transform.invXform(point.onB);
        point.normal = point.normal * meshB.transform.getBasis();
        contact->points.push_back({i, j, size_t(&point - points.data()) >= found, point});
    }
}

/// Likewise of all its meshes.
void qcContactBatch::StorePoints(const qcBatchPair& pair, std::vector<qcMeshPoint>* scratch,
                                 qcPairContact* contact) const
{
    const qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
    contact->gap = std::min(contact->gap, a.isPlaced && b.isPlaced ? double(a.minReach + b.minReach) : 0);
    if (a.meshes.size() == 1 && b.meshes.size() == 1)
    {
        // It may be one that a plane separates, which no query has.
        if (a.isPlaced && b.isPlaced)
            StorePoints(pair, 0, 0, scratch, contact);
        return;
    }
    const MeshPair first{a.owner, b.owner, 0, 0};
    for (auto meshes = std::lower_bound(m_meshPairs.begin(), m_meshPairs.end(), first);
         meshes != m_meshPairs.end() && (*meshes)[0] == a.owner && (*meshes)[1] == b.owner; ++meshes)
        StorePoints(pair, (*meshes)[2], (*meshes)[3], scratch, contact);
}

/// Keeps what the query has found of a pair, but the distances of its triangles.
void qcContactBatch::StorePair(const qcBatchPair& pair, std::vector<qcMeshPoint>* scratch)
{
    const qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
    qcPairContact& contact = *m_pairs.Find(a.owner, b.owner);
    contact.points.clear();
    contact.regions = 0;
    // A scene does not test two bodies that both rest.
    contact.isKnown = m_result != nullptr && (a.activity == qc_activityMoving || b.activity == qc_activityMoving);
    contact.versionA = a.version;
    contact.versionB = b.version;
    contact.a = pair.object0->getWorldTransform();
    contact.b = pair.object1->getWorldTransform();
    contact.reach = qcBatchScene::ContactDistance(a, b);
    contact.gap = double(m_scene.GetMargin());
    if (m_result != nullptr)
        StorePoints(pair, scratch, &contact);
}

/// Keeps what the query has found of the due pairs.
void qcContactBatch::Store()
{
    const std::vector<qcBatchPair>& due = m_validity.GetDue();
    m_points.resize(qcWorkersOf(settings.threads));
    if (m_result != nullptr)
        ListMeshPairs();
    qcForEach(uint32_t(m_points.size()), due.size(), s_storeBlock,
              [&](size_t i, uint32_t worker) { StorePair(due[i], &m_points[worker]); });
    for (size_t i = 0; m_result != nullptr && i < m_result->pairCount; i++)
    {
        const qcPair& pair = m_result->pairs[i];
        if (qcPairContact* contact = FindDue(pair.bodyA, pair.bodyB))
            contact->gap =
                std::min(contact->gap, m_result->proximities != nullptr ? m_result->proximities[i].distance : 0);
    }
    m_pairs.Count(m_validity.GetNumber(), &statistics.manifolds, &statistics.points);
}

/// One query for all due pairs of the world.
void qcContactBatch::Run()
{
    BT_PROFILE("qcMeshContact batch");
    double start = qcNowMs();
    statistics.batches++;
    statistics.pairs = int(m_validity.GetDue().size());
    statistics.status = qc_statusOk;
    m_result = nullptr;
    if (m_scene.Get() == nullptr)
    {
        Note(m_scene.Create(m_device));
        if (m_scene.Get() == nullptr)
            return;
    }
    Note(m_scene.Gather(m_validity.GetDue()));
    for (const qcBatchPair& pair : m_validity.GetDue())
        for (const btCollisionObject* object : {pair.object0, pair.object1})
            if (object->isStaticOrKinematicObject())
                m_limiter.KeepTriangles(object);
    NumberSlots();
    statistics.bodies = m_scene.GetBodyCount();
    ReadPairs();
    double gathered = qcNowMs();
    // Before the query at the beginning of the step: the scene keeps its last result only.
    SampleImpacts();
    static const qcResult s_noPairs{};
    m_result = &s_noPairs;
    m_reportsCandidates = settings.reportsCandidates;
    qcStatus status = m_triangleSlots.empty() ? qc_statusOk : Detect();
    if (status != qc_statusOk)
        m_result = nullptr;
    Note(status);
    Store();
    statistics.gatherMs = gathered - start;
    statistics.detectMs = qcNowMs() - gathered - statistics.aheadMs;
}

/// The index of a mesh at its present transform among those of its object; -1: it is not there, or has changed since
/// the check.
int qcContactBatch::FindMesh(const qcBatchObject& gathered, const qcPlacedMesh& mesh) const
{
    const btTransform& object = mesh.object->getWorldTransform();
    auto isPlaced = [&](size_t index)
    {
        const qcBatchMesh& candidate = gathered.meshes[index];
        return candidate.shape == mesh.shape && candidate.margin == mesh.shape->getMargin() &&
               candidate.revision == qcMeshRevision(mesh.shape) &&
               qcDisplacementBound(object * candidate.local, mesh.transform, candidate.radius) <= gathered.tolerance;
    };
    // Its origin is displaced by no more than the tolerance, and rounding; twice that in the object's frame if the
    // basis is not quite orthogonal.
    const btVector3 &from = object.getOrigin(), &origin = mesh.transform.getOrigin();
    const btScalar distance =
        2 * gathered.tolerance + s_placeError * (from.length() + origin.length() + gathered.radius);
    const size_t found = gathered.places.FindFirst(object.getBasis().inverse() * (origin - from), distance, isPlaced);
    return found < gathered.meshes.size() ? int(found) : -1;
}

/// Appends the pair's known points. False if the last check did not have the pair.
bool qcContactBatch::ReadPair(const qcPlacedMesh& a, const qcPlacedMesh& b, std::vector<qcMeshPoint>* points) const
{
    const qcBatchObject *gatheredA = m_scene.Find(a.object), *gatheredB = m_scene.Find(b.object);
    if (gatheredA == nullptr || gatheredB == nullptr)
        return false;
    if (gatheredA->owner > gatheredB->owner)
    {
        size_t first = points->size();
        bool isRead = ReadPair(b, a, points);
        for (size_t i = first; i < points->size(); i++)
            (*points)[i].Swap();
        return isRead;
    }
    const qcPairContact* pair = m_pairs.Find(gatheredA->owner, gatheredB->owner);
    int meshA = FindMesh(*gatheredA, a), meshB = FindMesh(*gatheredB, b);
    if (pair == nullptr || !pair->isKnown || pair->checked != m_validity.GetNumber() || meshA < 0 || meshB < 0)
        return false;
    auto isBefore = [](const qcKnownPoint& known, const std::pair<uint32_t, uint32_t>& meshes)
    { return std::make_pair(known.meshA, known.meshB) < meshes; };
    const std::pair<uint32_t, uint32_t> meshes = {uint32_t(meshA), uint32_t(meshB)}; // the points are sorted by these
    for (auto known = std::lower_bound(pair->points.begin(), pair->points.end(), meshes, isBefore);
         known != pair->points.end() && known->meshA == meshes.first && known->meshB == meshes.second; known++)
        points->push_back(known->At(a.transform, b.transform));
    return true;
}

void qcContactBatch::FindPoints(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar timeStep, uint64_t* check,
                                std::vector<qcMeshPoint>* points)
{
    // While this thread waits for a loop of the batch, its scheduler has it process another pair.
    if (m_mutex.IsHeldHere())
        m_isHelped = true;
    else
    {
        std::lock_guard<qcLoopMutex> lock(m_mutex);
        if (AreLeftOut(a, b))
            return;
        if (m_isHelped)
            settings.threads = 1;
        m_scene.SetTimeStep(timeStep);
        // A pair is computed once a step. Its second call since a check, or a call after one of its bodies has moved,
        // belongs to a new step.
        bool checked =
            *check != m_validity.GetNumber() && m_validity.IsAsChecked(a.object) && m_validity.IsAsChecked(b.object);
        if (!checked)
        {
            if (!AreOfGhost(a.object, b.object))
                MarkStarts();
            bool holds = m_validity.Check();
            ClearStatistics();
            if (!holds)
                Run();
            if (m_validity.NotFinite() != nullptr)
                LeaveOut(m_validity.NotFinite());
        }
        *check = m_validity.GetNumber();
        if (ReadPair(a, b, points))
            return;
    }
    // The pair is not in the world's pair cache, or the batch is not there yet.
    QueryPair(a, b, qcContactDistance(a.shape, b.shape) + a.shape->getMargin() + b.shape->getMargin(), points);
}

void qcContactBatch::MarkStarts()
{
    m_limiter.MarkStarts();
    m_mark++;
    m_isMarked = true;
}

void qcContactBatch::MarkStarts(const btCollisionObject* a, const btCollisionObject* b, uint64_t* mark)
{
    if (AreOfGhost(a, b) || m_mutex.IsHeldHere())
        return;
    // The second call since a mark, or the first one since the end of a step, belongs to a new step.
    auto isNew = [this, mark] { return !m_isMarked || *mark == m_mark; };
    if (*mark != 0 && isNew())
    {
        std::lock_guard<qcLoopMutex> lock(m_mutex);
        if (isNew())
            MarkStarts();
    }
    *mark = m_mark;
}

void qcContactBatch::QueryPair(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar distance,
                               std::vector<qcMeshPoint>* points)
{
    BT_PROFILE("qcMeshContact query");
    std::unique_lock<qcLoopMutex> lock(m_mutex, std::defer_lock);
    const bool isHeldHere = m_mutex.IsHeldHere();
    if (!isHeldHere)
        lock.lock();
    if (AreLeftOut(a, b))
        return;
    qcDetectDef detectDef = DetectDef(distance, SpacingOf(a.shape, b.shape));
    if (isHeldHere)
        detectDef.threads = 1;
    else
        lock.unlock();
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcStatus status = qcScene_Create(&def, &scene);
    const std::unique_ptr<qcScene, decltype(&qcScene_Destroy)> owner(scene, qcScene_Destroy);
    qcBodyId idA, idB;
    std::vector<qcTriangleSource> sourcesA, sourcesB;
    btVector3 boxA[2], boxB[2];
    BoxIn(b, a, distance, boxA);
    BoxIn(a, b, distance, boxB);
    // A new scene has no measured costs for the planner, and its geometry is not on the device.
    detectDef.method = qc_methodSweep;
    const qcResult* result = nullptr;
    if (status == qc_statusOk)
        status = qcAddMesh(scene, {a.shape, a.transform, qc_activityMoving, 0, boxA}, &idA, &sourcesA);
    if (status == qc_statusOk)
        status = qcAddMesh(scene, {b.shape, b.transform, qc_activityMoving, 0, boxB}, &idB, &sourcesB);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &detectDef, &result);
    if (status == qc_statusOk)
        qcAppendPoints(*result, idA, sourcesA, idB, sourcesB, points);
    if (!isHeldHere)
        lock.lock();
    statistics.queries++;
    Note(status);
}

const qcBatchObject* qcContactBatch::FindCurrent(const btCollisionObject* object)
{
    const qcBatchObject* gathered = m_scene.Find(object);
    return gathered != nullptr && m_scene.IsUnchanged(object, *gathered) ? gathered : nullptr;
}

bool qcContactBatch::StayApart(const qcKnownStep& a, const qcKnownStep& b)
{
    if (a.object.owner > b.object.owner)
        return StayApart(b, a);
    const qcPairContact* pair = m_pairs.Find(a.object.owner, b.object.owner);
    return pair != nullptr && pair->versionA == a.object.version && pair->versionB == b.object.version &&
           qcPairContacts::StayApart(*pair, {a.start, a.end, a.object.radius}, {b.start, b.end, b.object.radius});
}

void qcContactBatch::InvalidateShape(const btCollisionShape* shape)
{
    std::lock_guard<qcLoopMutex> lock(m_mutex);
    m_scene.InvalidateShape(shape);
    m_axes.InvalidateShape(shape);
    m_limiter.InvalidateShape(shape);
}

/// Limits the motions of the step, and records anew whether an object of the world is not finite.
void qcContactBatch::Limit(btScalar timeStep)
{
    ForgetLeftOut();
    m_limiter.Limit(timeStep, &statistics);
    m_isMarked = false;
    if (m_limiter.NotFinite() != nullptr)
        LeaveOut(m_limiter.NotFinite());
}

void qcContactBatch::LimitMotion(btScalar timeStep)
{
    std::lock_guard<qcLoopMutex> lock(m_mutex);
    std::vector<const btCollisionObject*> moved;
    if (m_isLimited)
        m_limiter.LimitAgain(
            timeStep, {}, [](const btCollisionObject*) { return nullptr; }, &moved, &statistics);
    else
        Limit(timeStep);
    m_isLimited = false;
}

void qcContactBatch::LimitFirst(btScalar timeStep)
{
    std::lock_guard<qcLoopMutex> lock(m_mutex);
    Limit(timeStep);
    m_isLimited = true;
}

void qcContactBatch::LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                                const qcStartFunction& startOf, std::vector<const btCollisionObject*>* moved)
{
    std::lock_guard<qcLoopMutex> lock(m_mutex);
    m_limiter.LimitAgain(timeStep, held, startOf, moved, &statistics);
}

void qcContactBatch::Draw(btIDebugDraw* drawer, int modes)
{
    std::lock_guard<qcLoopMutex> lock(m_mutex);
    // The triangles of pairs that a plane separates are not queried before they are drawn.
    if (m_result != nullptr && m_planes.GetPairCount() > 0)
    {
        qcDetectDef def = DetectDef(m_scene.GetMargin(), m_scene.GetSpacing());
        def.candidates = m_reportsCandidates;
        def.pairFilter = HasPair;
        def.pairFilterContext = this;
        if (qcScene_Detect(m_scene.Get(), &def, &m_result) != qc_statusOk)
            m_result = nullptr;
    }
    if (m_result != nullptr)
        qcDrawCandidates(m_scene, *m_result, modes, drawer);
}
