// The batch: gathering the meshes of a world, one query, reading a pair.
#include "mesh_contact/contact_batch.h"

#include "common/compound_children.h"
#include "common/stopwatch.h"
#include "common/object_key.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// A body counts as where it was until a point of it has moved by this part of its contact breaking threshold: meshes at
// rest, which creep by a thousandth of that in each step, need no query. The query reaches as much further.
constexpr btScalar s_slack = btScalar(0.03);
// Of fine meshes points are looked for no further than this part of an edge. More would be too much: within 4 cm of a
// triangle of 1 cm lie a hundred others.
constexpr btScalar s_edge = btScalar(0.5);

// Where the speeds that are left are less than this share, bodies move together. (What lies still but for a tremor has
// no common motion: there this would only make contact flicker.)
constexpr btScalar s_ownMotion = btScalar(0.25);

/// About how long the edges of a mesh are, if its area is that of its box.
btScalar EdgeOf(const btCollisionShape* shape, size_t triangleCount)
{
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    btVector3 size = upper - lower;
    btScalar area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    return triangleCount > 0 ? btScalar(1.5) * btSqrt(area / btScalar(triangleCount)) : BT_LARGE_FLOAT;
}

btScalar RadiusOf(const btCollisionShape* shape)
{
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    btVector3 far = lower.absolute();
    far.setMax(upper.absolute());
    return far.length();
}

/// The box of a mesh, in the frame of another one, grown.
void BoxIn(const qcPlacedMesh& mesh, const qcPlacedMesh& frame, btScalar reach, btVector3 box[2])
{
    mesh.shape->getAabb(frame.transform.inverse() * mesh.transform, box[0], box[1]);
    // The normals of contact points are looked at with what is around them: as much again on each side.
    btVector3 grow = (box[1] - box[0]) / 2 + btVector3(reach, reach, reach);
    box[0] -= grow;
    box[1] += grow;
}
} // namespace

qcMeshBatch::~qcMeshBatch()
{
    qcScene_Destroy(m_scene);
}

void qcMeshBatch::Note(qcStatus status)
{
    if (status != qc_statusOk)
        statistics.status = status;
}

qcDetectDef qcMeshBatch::DetectDef(btScalar margin) const
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.margin = double(margin);
    def.manifolds = true;
    def.threads = threads;
    return def;
}

btScalar qcMeshBatch::Reach(const btCollisionShape* a, const btCollisionShape* b) const
{
    // Bullet's broadphase boxes are grown by one threshold each: what is further apart is not a pair.
    btScalar reach = 2 * gContactBreakingThreshold;
    return std::min({reach, a->getContactBreakingThreshold(gContactBreakingThreshold),
                     b->getContactBreakingThreshold(gContactBreakingThreshold)});
}

/// The meshes of a shape, where Bullet's compound algorithms would place them, to the last bit.
void qcMeshBatch::CollectMeshes(const btCollisionShape* shape, const btTransform& transform,
                                std::vector<Mesh>* meshes) const
{
    auto add = [meshes](const btCollisionShape* mesh, const btTransform& meshTransform)
    {
        if (!qcIsMesh(mesh))
            return;
        meshes->emplace_back();
        meshes->back().shape = mesh;
        meshes->back().transform = meshTransform;
    };
    qcForEachSimpleShape(shape, transform, add);
}

/// Has the scene the mesh at this place, or so near that its contact points serve?
bool qcMeshBatch::IsAt(const Mesh& mesh, const btTransform& transform)
{
    return mesh.placed && qcMotion(mesh.transform, transform, mesh.radius) <= mesh.slack;
}

/// Has the scene this shape as it is now, at this place?
bool qcMeshBatch::IsAs(const Mesh& held, const btCollisionShape* shape, const btTransform& transform)
{
    return held.shape == shape && held.margin == shape->getMargin() && IsAt(held, transform) &&
           held.revision == qcMeshRevision(shape);
}

/// What depends on the shape only.
void qcMeshBatch::Measure(const btCollisionShape& root, Object* known) const
{
    known->threshold =
        std::min(root.getContactBreakingThreshold(gContactBreakingThreshold), 2 * gContactBreakingThreshold);
    known->ours = false;
    known->radius = RadiusOf(&root);
    for (Mesh& mesh : known->meshes)
    {
        mesh.slack = s_slack * known->threshold;
        mesh.radius = RadiusOf(mesh.shape);
        if (const qcMeshShape* ours = qcAsMeshShape(mesh.shape))
            mesh.edge = EdgeOf(ours, ours->getTriangleCount());
        known->ours = known->ours || qcAsMeshShape(mesh.shape) != nullptr ||
                      (gimpact && mesh.shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE);
    }
}

/// Takes the object's present meshes, keeping what the scene has of them.
void qcMeshBatch::Refresh(const btCollisionObject* object, Object* known)
{
    m_collected.clear();
    CollectMeshes(object->getCollisionShape(), object->getWorldTransform(), &m_collected);
    for (Mesh& mesh : m_collected)
    {
        mesh.revision = qcMeshRevision(mesh.shape);
        mesh.margin = mesh.shape->getMargin();
    }
    auto isSame = [](const Mesh& a, const Mesh& b) { return a.shape == b.shape && a.revision == b.revision; };
    bool same = std::equal(m_collected.begin(), m_collected.end(), known->meshes.begin(), known->meshes.end(), isSame);
    for (size_t i = 0; same && i < m_collected.size(); i++)
    {
        Mesh& mesh = known->meshes[i];
        mesh.margin = m_collected[i].margin;
        if (IsAt(mesh, m_collected[i].transform))
            continue;
        mesh.placed = false;
        mesh.transform = m_collected[i].transform;
    }
    if (!same)
    {
        Forget(known);
        known->meshes.swap(m_collected);
        Measure(*object->getCollisionShape(), known);
    }
    btScalar edge = BT_LARGE_FLOAT;
    for (const Mesh& mesh : known->meshes)
        edge = std::min(edge, mesh.edge);
    known->limit = std::min(known->threshold, std::max(s_rest * known->threshold, s_edge * edge));
    known->approach = qcApproach(object, known->radius, m_timeStep, known->limit, m_drift);
    known->margin = 0;
    for (const Mesh& mesh : known->meshes)
        known->margin = std::max(known->margin, mesh.margin + mesh.slack);
}

/// Takes the object's meshes out of the scene.
void qcMeshBatch::Forget(Object* known)
{
    for (Mesh& mesh : known->meshes)
        if (mesh.inScene)
            qcScene_RemoveBody(m_scene, mesh.id);
    known->meshes.clear();
}

/// The object, as it is in this gathering.
qcMeshBatch::Object* qcMeshBatch::Know(const btCollisionObject* object)
{
    Object& known = m_objects[object];
    if (known.seen == m_gathering)
        return &known;
    if (known.owner == 0)
        known.owner = ++m_owners;
    known.uniqueId = qcUniqueIdOf(object);
    known.seen = known.present = m_gathering;
    known.state = StateOf(object);
    Refresh(object, &known);
    return &known;
}

/// The mean motion of what may hold meshes, if that is nearly all of it: fresh pieces of a body that flew and turned
/// come no nearer to each other, as distances are the same for who drifts along.
void qcMeshBatch::FindDrift()
{
    m_drift = qcMeshMotion();
    std::vector<const btRigidBody*> moving;
    const btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btRigidBody* body = btRigidBody::upcast(objects[i]);
        if (body != nullptr && !body->isStaticOrKinematicObject() && body->isActive() &&
            qcMayHoldMeshes(body->getCollisionShape()))
            moving.push_back(body);
    }
    qcMeshMotion mean;
    for (const btRigidBody* body : moving)
    {
        btScalar share = 1 / btScalar(moving.size());
        mean.centre += share * body->getWorldTransform().getOrigin();
        mean.linear += share * body->getLinearVelocity();
        mean.angular += share * body->getAngularVelocity();
    }
    btScalar speeds = 0, speedsThere = 0;
    for (const btRigidBody* body : moving)
    {
        speeds += body->getLinearVelocity().length();
        speedsThere += (body->getLinearVelocity() - mean.At(body->getWorldTransform().getOrigin())).length();
    }
    if (speedsThere < s_ownMotion * speeds)
        m_drift = mean;
}

/// Marks the objects of pairs that are ours, and finds out how far contact reaches.
void qcMeshBatch::WantPairs()
{
    m_margin = 0;
    ForEachPair(
        [this](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            Object &known0 = *Know(object0), &known1 = *Know(object1);
            if (known0.meshes.empty() || known1.meshes.empty() || !(known0.ours || known1.ours))
                return;
            known0.wanted = known1.wanted = true;
            btScalar rest = s_rest * std::min(known0.threshold, known1.threshold);
            btScalar reach = std::min({known0.limit, known1.limit, rest + known0.approach + known1.approach});
            m_margin = std::max(m_margin, reach + known0.margin + known1.margin);
        });
}

/// Brings the scene up to date with an object.
void qcMeshBatch::Place(const btCollisionObject* object, Object* known)
{
    qcActivity activity = object->isActive()         ? qc_activityMoving
                          : object->isStaticObject() ? qc_activityStatic
                                                     : qc_activitySleeping;
    for (Mesh& mesh : known->meshes)
    {
        qcStatus status = qc_statusOk;
        if (!mesh.inScene)
        {
            status = qcAddMesh(m_scene, mesh.shape, mesh.transform, activity, known->owner, nullptr, &mesh.id,
                               &mesh.sources);
            mesh.inScene = status == qc_statusOk;
            if (!mesh.sources.empty())
                mesh.edge = EdgeOf(mesh.shape, mesh.sources.size());
        }
        else
        {
            if (activity != known->activity)
                status = qcScene_SetActivity(m_scene, mesh.id, activity);
            if (!mesh.placed && status == qc_statusOk)
            {
                qcTransform transform = qcTransformOf(mesh.transform);
                status = qcScene_SetTransform(m_scene, mesh.id, &transform);
            }
        }
        // Of two bodies the sum is at least what WantPairs asks for them.
        btScalar reach = std::min(known->limit, s_rest * known->threshold / 2 + known->approach);
        if (status == qc_statusOk)
            status = qcScene_SetMargin(m_scene, mesh.id, double(reach + mesh.margin + mesh.slack));
        mesh.placed = status == qc_statusOk;
        Note(status);
        statistics.bodies += mesh.inScene;
    }
    known->activity = activity;
}

qcStatus qcMeshBatch::Detect()
{
    BT_PROFILE("qcMeshContact detect");
    qcDetectDef def = DetectDef(m_margin);
    qcStatus status = qcScene_Detect(m_scene, &def, &m_result);
    if (status != qc_statusOk)
        return status;
    const qcProfile& profile = m_result->profile;
    statistics.manifolds = int(m_result->manifoldCount);
    statistics.points = int(m_result->manifoldPointCount);
    statistics.method = profile.method;
    statistics.device = profile.device;
    statistics.fallback = profile.fallback;
    // A result that is given again has the times of the step that it is from.
    if (!profile.reused)
    {
        statistics.cullMs = profile.cullObjectsMs + profile.cullTrianglesMs;
        statistics.sweepMs = profile.sweepObjectsMs + profile.sweepTrianglesMs;
        statistics.exactMs = profile.exactMs;
        statistics.manifoldMs = profile.manifoldMs;
    }
    return qc_statusOk;
}

/// Drops what left the world, in the order in which it came: what takes its slots next must not depend on addresses.
void qcMeshBatch::ForgetGone()
{
    const btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMayHoldMeshes(objects[i]->getCollisionShape()))
            continue;
        auto found = m_objects.find(objects[i]);
        if (found != m_objects.end() && found->second.uniqueId == qcUniqueIdOf(objects[i]))
            found->second.present = m_gathering;
    }
    std::vector<std::pair<int, const btCollisionObject*>> gone;
    for (const auto& [object, known] : m_objects)
        if (known.present != m_gathering)
            gone.emplace_back(known.uniqueId, object);
    std::sort(gone.begin(), gone.end());
    for (const auto& [uniqueId, object] : gone)
    {
        Forget(&m_objects[object]);
        m_objects.erase(object);
    }
}

/// Finds what pairs that move fast come upon in the step.
void qcMeshBatch::LookAhead()
{
    BT_PROFILE("qcMeshContact look ahead");
    double start = qcNowMs();
    m_ahead.Begin(m_timeStep);
    auto moving = [](const btCollisionObject* object, const Object& known, const Mesh& mesh)
    {
        return qcMovingMesh{object,       mesh.id,         mesh.transform, &mesh.sources,
                            known.radius, known.threshold, known.limit,    mesh.margin};
    };
    ForEachPair(
        [&](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            const Object &known0 = *Know(object0), &known1 = *Know(object1);
            if (!(known0.ours || known1.ours) || !world->getDispatcher()->needsCollision(object0, object1))
                return;
            for (const Mesh& mesh0 : known0.meshes)
                for (const Mesh& mesh1 : known1.meshes)
                    if (mesh0.placed && mesh1.placed)
                        m_ahead.Consider(moving(object0, known0, mesh0), moving(object1, known1, mesh1));
        });
    Note(m_ahead.Find(m_scene, DetectDef(m_margin)));
    statistics.moments = m_ahead.GetMomentCount();
    statistics.aheadMs = qcNowMs() - start;
}

/// Brings the scene up to date with the world.
void qcMeshBatch::Gather()
{
    BT_PROFILE("qcMeshContact gather");
    m_gathering++;
    ForgetGone();
    FindDrift();
    WantPairs();
    const btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMayHoldMeshes(objects[i]->getCollisionShape()) || m_objects.find(objects[i]) == m_objects.end())
            continue;
        Object* known = Know(objects[i]);
        if (known->wanted)
            Place(objects[i], known);
    }
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
    if (m_scene == nullptr)
    {
        qcSceneDef def = qcDefaultSceneDef();
        def.device = m_device;
        Note(qcScene_Create(&def, &m_scene));
        if (m_scene == nullptr)
            return;
    }
    Gather();
    double gathered = qcNowMs();
    // First: the result that is read is the scene's last.
    LookAhead();
    qcStatus status = Detect();
    if (status != qc_statusOk)
        m_result = nullptr;
    Note(status);
    statistics.gatherMs = gathered - start;
    statistics.detectMs = qcNowMs() - gathered - statistics.aheadMs;
}

/// The mesh, if the last query saw it as it is, at this place.
const qcMeshBatch::Mesh* qcMeshBatch::Held(const qcPlacedMesh& mesh, bool* moving) const
{
    auto found = m_objects.find(mesh.object);
    if (found == m_objects.end() || !IsSeen(mesh.object, found->second))
        return nullptr;
    const Object& known = found->second;
    *moving = *moving || known.activity == qc_activityMoving;
    for (const Mesh& held : known.meshes)
        // Its pair may be a new one: nobody has looked at the mesh since it changed.
        if (IsAs(held, mesh.shape, mesh.transform))
            return &held;
    return nullptr;
}

/// The pair's points of the last query; false if it did not look at this pair.
bool qcMeshBatch::Read(const qcPlacedMesh& a, const qcPlacedMesh& b, std::vector<qcMeshPoint>* points) const
{
    bool moving = false;
    const Mesh *meshA = Held(a, &moving), *meshB = Held(b, &moving);
    if (m_result == nullptr || meshA == nullptr || meshB == nullptr || !moving)
        return false;
    qcAppendPoints(*m_result, meshA->id, meshA->sources, meshB->id, meshB->sources, points);
    // Each point moves with its body since the query, as those of a btPersistentManifold do.
    for (qcMeshPoint& point : *points)
    {
        point.onA = a.transform * meshA->transform.invXform(point.onA);
        point.onB = b.transform * meshB->transform.invXform(point.onB);
        point.distance = (point.onA - point.onB).dot(point.normal);
    }
    m_ahead.Append(meshA->id, a.transform, meshB->id, b.transform, points);
    return true;
}

void qcMeshBatch::Find(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar timeStep, unsigned* check,
                       std::vector<qcMeshPoint>* points)
{
    {
        std::lock_guard<std::mutex> lock(m_mutex);
        m_timeStep = timeStep;
        // A step asks for each pair once: who asks again is in the next one, as is who moved since the check.
        bool checked = *check != m_check && IsAsChecked(a.object) && IsAsChecked(b.object);
        if (!checked && !CheckAll())
            Run();
        *check = m_check;
        if (Read(a, b, points))
            return;
    }
    // Not a pair of the world: its answer is its own, too.
    Query(a, b, Reach(a.shape, b.shape) + a.shape->getMargin() + b.shape->getMargin(), points);
}

void qcMeshBatch::Change(const btCollisionShape* shape)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    for (auto& [object, known] : m_objects)
        for (Mesh& mesh : known.meshes)
            if (mesh.shape == shape)
                mesh.revision = 0; // no shape's
}

void qcMeshBatch::Query(const qcPlacedMesh& a, const qcPlacedMesh& b, btScalar reach, std::vector<qcMeshPoint>* points)
{
    BT_PROFILE("qcMeshContact query");
    qcSceneDef def = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcBodyId idA, idB;
    std::vector<qcTriangleSource> sourcesA, sourcesB;
    btVector3 boxA[2], boxB[2];
    BoxIn(b, a, reach, boxA);
    BoxIn(a, b, reach, boxB);
    qcDetectDef detectDef = DetectDef(reach);
    // The planner has no history here, and the device none of the geometry.
    detectDef.method = qc_methodSweep;
    const qcResult* result = nullptr;
    qcStatus status = qcScene_Create(&def, &scene);
    if (status == qc_statusOk)
        status = qcAddMesh(scene, a.shape, a.transform, qc_activityMoving, 0, boxA, &idA, &sourcesA);
    if (status == qc_statusOk)
        status = qcAddMesh(scene, b.shape, b.transform, qc_activityMoving, 0, boxB, &idB, &sourcesB);
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &detectDef, &result);
    if (status == qc_statusOk)
        qcAppendPoints(*result, idA, sourcesA, idB, sourcesB, points);
    qcScene_Destroy(scene);
    std::lock_guard<std::mutex> lock(m_mutex);
    statistics.queries++;
    Note(status);
}
