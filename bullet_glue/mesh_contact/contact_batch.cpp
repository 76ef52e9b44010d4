// Contact of all pairs of meshes in a world from one query a step.
#include "mesh_contact/contact_batch.h"

#include "common/profiled_detect.h"
#include "common/stopwatch.h"
#include "mesh_contact/draw_candidates.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
/// The box of a mesh in the frame of another one, enlarged.
void BoxIn(const qcPlacedMesh& mesh, const qcPlacedMesh& frame, btScalar distance, btVector3 box[2])
{
    mesh.shape->getAabb(frame.transform.inverse() * mesh.transform, box[0], box[1]);
    // Half of its size more on each side: normals of contact points depend on the triangles around them.
    btVector3 grow = (box[1] - box[0]) / 2 + btVector3(distance, distance, distance);
    box[0] -= grow;
    box[1] += grow;
}
} // namespace

btScalar qcContactDistance(const btCollisionShape* a, const btCollisionShape* b)
{
    // Bullet enlarges boxes in the broadphase by one threshold each: shapes further apart are no pair.
    btScalar distance = 2 * gContactBreakingThreshold;
    return std::min({distance, a->getContactBreakingThreshold(gContactBreakingThreshold),
                     b->getContactBreakingThreshold(gContactBreakingThreshold)});
}

void qcMeshBatch::Note(qcStatus status)
{
    if (status != qc_statusOk)
        statistics.status = status;
}

qcDetectDef qcMeshBatch::DetectDef(btScalar margin) const
{
    qcDetectDef def = qcProfiledDetectDef();
    def.method = settings.method;
    def.margin = double(margin);
    def.manifolds = true;
    def.threads = settings.threads;
    return def;
}

/// Finds contacts that fast pairs will have within the step.
void qcMeshBatch::SampleImpacts()
{
    BT_PROFILE("qcMeshContact look ahead");
    double start = qcNowMs();
    m_impacts.Begin(m_scene.GetTimeStep());
    auto moving = [](const btCollisionObject* object, const qcBatchObject& gathered, const qcBatchMesh& mesh)
    {
        return qcMovingMesh{object,          mesh.id,
                            mesh.transform,  &mesh.sources,
                            gathered.radius, gathered.threshold,
                            mesh.margin,     gathered.maxContactDistance};
    };
    m_scene.ForEachPair(
        [&](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            const qcBatchObject &a = *m_scene.Find(object0), &b = *m_scene.Find(object1);
            if (!(a.isOurs || b.isOurs) || !settings.world->getDispatcher()->needsCollision(object0, object1))
                return;
            for (const qcBatchMesh& meshA : a.meshes)
                for (const qcBatchMesh& meshB : b.meshes)
                    if (meshA.placed && meshB.placed)
                        m_impacts.AddPair(moving(object0, a, meshA), moving(object1, b, meshB));
        });
    Note(m_impacts.Sample(m_scene.Get(), DetectDef(m_scene.GetMargin())));
    statistics.moments = m_impacts.GetSampleCount();
    statistics.aheadMs = qcNowMs() - start;
}

qcStatus qcMeshBatch::Detect()
{
    BT_PROFILE("qcMeshContact detect");
    qcDetectDef def = DetectDef(m_scene.GetMargin());
    def.candidates = settings.reportsCandidates;
    qcStatus status = qcScene_Detect(m_scene.Get(), &def, &m_result);
    if (status != qc_statusOk)
        return status;
    const qcProfile& profile = m_result->profile;
    statistics.manifolds = int(m_result->manifoldCount);
    statistics.points = int(m_result->manifoldPointCount);
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

/// One query for all pairs of the world.
void qcMeshBatch::Run()
{
    BT_PROFILE("qcMeshContact batch");
    double start = qcNowMs();
    uint64_t batches = statistics.batches, queries = statistics.queries;
    statistics = qcMeshContactStatistics();
    statistics.batches = batches + 1;
    statistics.queries = queries;
    m_result = nullptr;
    if (m_scene.Get() == nullptr)
    {
        Note(m_scene.Create(m_device));
        if (m_scene.Get() == nullptr)
            return;
    }
    Note(m_scene.Gather());
    statistics.bodies = m_scene.GetBodyCount();
    double gathered = qcNowMs();
    // Before the query at the beginning of the step: the scene keeps its last result only.
    SampleImpacts();
    qcStatus status = Detect();
    if (status != qc_statusOk)
        m_result = nullptr;
    Note(status);
    statistics.gatherMs = gathered - start;
    statistics.detectMs = qcNowMs() - gathered - statistics.aheadMs;
}

/// The mesh as the last batch has it; null if it has changed since.
const qcBatchMesh* qcMeshBatch::FindMesh(const qcPlacedMesh& mesh, bool* moving) const
{
    const qcBatchObject* gathered = m_scene.Find(mesh.object);
    if (gathered == nullptr || !m_scene.IsUpToDate(mesh.object, *gathered))
        return nullptr;
    *moving = *moving || gathered->activity == qc_activityMoving;
    // The pair may be new since the check, which then left out the mesh.
    auto isCurrent = [&](const qcBatchMesh& candidate) { return candidate.IsCurrent(mesh.shape, mesh.transform); };
    auto found = std::find_if(gathered->meshes.begin(), gathered->meshes.end(), isCurrent);
    return found != gathered->meshes.end() ? &*found : nullptr;
}

/// Appends the pair's points of the last batch. False if the batch does not contain the pair.
bool qcMeshBatch::ReadPair(const qcPlacedMesh& a, const qcPlacedMesh& b, std::vector<qcMeshPoint>* points) const
{
    bool moving = false;
    const qcBatchMesh *meshA = FindMesh(a, &moving), *meshB = FindMesh(b, &moving);
    if (m_result == nullptr || meshA == nullptr || meshB == nullptr || !moving)
        return false;
    qcAppendPoints(*m_result, meshA->id, meshA->sources, meshB->id, meshB->sources, points);
    // Points have moved with their bodies since the query, as those of a btPersistentManifold do.
    for (qcMeshPoint& point : *points)
    {
        point.onA = a.transform * meshA->transform.invXform(point.onA);
        point.onB = b.transform * meshB->transform.invXform(point.onB);
        point.distance = (point.onA - point.onB).dot(point.normal);
    }
    m_impacts.AppendPoints(meshA->id, a.transform, meshB->id, b.transform, points);
    return true;
}

void qcMeshBatch::FindPoints(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar timeStep, unsigned* check,
                             std::vector<qcMeshPoint>* points)
{
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        m_scene.SetTimeStep(timeStep);
        // A pair is computed once a step. Its second call since a check, or a call after one of its bodies has moved,
        // belongs to a new step.
        bool checked =
            *check != m_validity.GetNumber() && m_validity.IsAsChecked(a.object) && m_validity.IsAsChecked(b.object);
        if (!checked)
        {
            m_limiter.MarkStarts();
            if (!m_validity.Check() || m_result == nullptr)
                Run();
        }
        *check = m_validity.GetNumber();
        if (ReadPair(a, b, points))
            return;
    }
    // The pair is not in the world's pair cache.
    QueryPair(a, b, qcContactDistance(a.shape, b.shape) + a.shape->getMargin() + b.shape->getMargin(), points);
}

void qcMeshBatch::QueryPair(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar distance,
                            std::vector<qcMeshPoint>* points)
{
    BT_PROFILE("qcMeshContact query");
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcBodyId idA, idB;
    std::vector<qcTriangleSource> sourcesA, sourcesB;
    btVector3 boxA[2], boxB[2];
    BoxIn(b, a, distance, boxA);
    BoxIn(a, b, distance, boxB);
    qcDetectDef detectDef = DetectDef(distance);
    // A new scene has no measured costs for the planner, and its geometry is not on the device.
    detectDef.method = qc_methodSweep;
    const qcResult* result = nullptr;
    qcStatus status = qcScene_Create(&def, &scene);
    if (status == qc_statusOk)
        status = qcAddMesh(scene, {a.shape, a.transform, qc_activityMoving, 0, boxA}, &idA, &sourcesA);
    if (status == qc_statusOk)
        status = qcAddMesh(scene, {b.shape, b.transform, qc_activityMoving, 0, boxB}, &idB, &sourcesB);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &detectDef, &result);
    if (status == qc_statusOk)
        qcAppendPoints(*result, idA, sourcesA, idB, sourcesB, points);
    qcScene_Destroy(scene);
    std::lock_guard<std::mutex> lock(m_mutex);
    statistics.queries++;
    Note(status);
}

void qcMeshBatch::InvalidateShape(const btCollisionShape* shape)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    m_scene.InvalidateShape(shape);
    m_limiter.InvalidateShape(shape);
}

void qcMeshBatch::LimitMotion(btScalar timeStep)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    std::vector<const btCollisionObject*> moved;
    if (m_isLimited)
        m_limiter.LimitAgain(timeStep, {}, &moved, &statistics);
    else
        m_limiter.Limit(timeStep, &statistics);
    m_isLimited = false;
}

void qcMeshBatch::LimitFirst(btScalar timeStep)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    m_limiter.Limit(timeStep, &statistics);
    m_isLimited = true;
}

void qcMeshBatch::LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                             std::vector<const btCollisionObject*>* moved)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    m_limiter.LimitAgain(timeStep, held, moved, &statistics);
}

void qcMeshBatch::Draw(btIDebugDraw* drawer, int modes)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    if (m_result != nullptr)
        qcDrawCandidates(m_scene, *m_result, modes, drawer);
}
