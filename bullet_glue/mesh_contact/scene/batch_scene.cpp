// The meshes of a world as bodies of one scene. Why contact is searched this far: plugin/docs/mesh_contact.md.
#include "mesh_contact/scene/batch_scene.h"

#include "common/changed_shapes.h"
#include "common/compound_children.h"
#include "common/object_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Contact of fine meshes is searched no further than this part of an edge: within 4 cm of a triangle of 1 cm lie a
// hundred others. At a half, 20 bunnies have twice as many pairs of triangles, and are no less deep (qc-bench piles);
// at a tenth, a chain of tori comes to rest later (test_mesh_rest).
constexpr btScalar s_maxEdges = btScalar(0.2);
// Bodies move together if their speeds relative to the mean motion are less than this share of their speeds. (Bodies
// that only tremble at rest have no mean motion, which would make contact flicker.)
constexpr btScalar s_maxRelativeSpeed = btScalar(0.25);

btScalar RadiusOf(const btCollisionShape* shape)
{
    btVector3 lower, upper;
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    btVector3 far = lower.absolute();
    far.setMax(upper.absolute());
    return far.length();
}

/// Likewise for a mesh, by its vertices: the corners of its box lie half as far again from the origin.
btScalar RadiusOf(const qcMeshShape& mesh)
{
    btScalar squared = 0;
    for (uint32_t i = 0; i < mesh.getVertexCount(); i++)
        squared = std::max(squared, mesh.getVertices()[i].length2());
    return btSqrt(squared) * (1 + 4 * SIMD_EPSILON) + mesh.getMargin();
}
} // namespace

btScalar qcEdgeLengthOf(const btCollisionShape* mesh, size_t triangleCount)
{
    btVector3 lower, upper;
    mesh->getAabb(btTransform::getIdentity(), lower, upper);
    btVector3 size = upper - lower;
    btScalar area = 2 * (size.x() * size.y() + size.y() * size.z() + size.z() * size.x());
    return triangleCount > 0 ? btScalar(1.5) * btSqrt(area / btScalar(triangleCount)) : BT_LARGE_FLOAT;
}

void qcCollectMeshes(const btCollisionShape* shape, const btTransform& transform, std::vector<qcBatchMesh>* meshes)
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

qcObjectState qcObjectState::Of(const btCollisionObject* object)
{
    const btRigidBody* body = btRigidBody::upcast(object);
    const btVector3 zero(0, 0, 0);
    return {object->getWorldTransform(), body != nullptr ? body->getLinearVelocity() : zero,
            body != nullptr ? body->getAngularVelocity() : zero, object->isActive()};
}

bool qcObjectState::IsStateOf(const btCollisionObject* object) const
{
    qcObjectState now = Of(object);
    return qcAreSame(transform, now.transform) && qcAreSame(linear, now.linear) && qcAreSame(angular, now.angular) &&
           active == now.active;
}

qcBatchScene::~qcBatchScene()
{
    qcScene_Destroy(m_scene);
}

qcStatus qcBatchScene::Create(qcDevice* device)
{
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    return qcScene_Create(&def, &m_scene);
}

const qcBatchObject* qcBatchScene::Find(const btCollisionObject* object) const
{
    auto found = m_objects.find(qcObjectKey(object));
    return found != m_objects.end() ? &found->second : nullptr;
}

qcBatchObject* qcBatchScene::Find(const btCollisionObject* object)
{
    auto found = m_objects.find(qcObjectKey(object));
    return found != m_objects.end() ? &found->second : nullptr;
}

btScalar qcBatchScene::MaxClosing(const btCollisionObject* object, const qcBatchObject& gathered) const
{
    return qcMaxClosingDistance(object, gathered.radius, m_timeStep, gathered.maxContactDistance, m_meanMotion);
}

btScalar qcBatchScene::ContactDistance(const qcBatchObject& a, const qcBatchObject& b)
{
    btScalar rest = s_restDistance * std::min(a.threshold, b.threshold);
    return std::min({a.maxContactDistance, b.maxContactDistance, rest + a.maxClosing + b.maxClosing}) + a.lead + b.lead;
}

void qcBatchScene::InvalidateShape(const btCollisionShape* shape)
{
    for (auto& [key, object] : m_objects)
        for (qcBatchMesh& mesh : object.meshes)
            if (mesh.shape == shape)
                mesh.revision = qcStaleRevision;
}

/// Sets what depends on the shape only.
void qcBatchScene::Measure(const btCollisionShape& root, qcBatchObject* object) const
{
    object->threshold =
        std::min(root.getContactBreakingThreshold(gContactBreakingThreshold), 2 * gContactBreakingThreshold);
    object->tolerance = s_tolerance * object->threshold;
    object->isOurs = false;
    object->boxRadius = RadiusOf(&root);
    object->radius = 0;
    root.getAabb(btTransform::getIdentity(), object->lower, object->upper);
    object->margin = 0;
    for (qcBatchMesh& mesh : object->meshes)
    {
        const qcMeshShape* ours = qcAsMeshShape(mesh.shape);
        mesh.radius = ours != nullptr ? RadiusOf(*ours) : RadiusOf(mesh.shape);
        object->radius = std::max(object->radius, mesh.local.getOrigin().length() + mesh.radius);
        if (ours != nullptr)
            mesh.edgeLength = qcEdgeLengthOf(ours, ours->getTriangleCount());
        object->isOurs = object->isOurs || ours != nullptr ||
                         (m_settings.gimpact && mesh.shape->getShapeType() == GIMPACT_SHAPE_PROXYTYPE);
        object->margin = std::max(object->margin, mesh.margin + object->tolerance);
    }
}

bool qcBatchScene::IsUnchanged(const btCollisionObject* object, const qcBatchObject& gathered) const
{
    size_t count = 0;
    bool isSame = true;
    auto compare = [&](const btCollisionShape* shape, const btTransform& local)
    {
        if (!isSame || !qcIsMesh(shape))
            return;
        isSame = count < gathered.meshes.size();
        if (!isSame)
            return;
        const qcBatchMesh& mesh = gathered.meshes[count++];
        isSame = mesh.shape == shape && mesh.margin == shape->getMargin() && mesh.revision == qcMeshRevision(shape) &&
                 qcAreSame(mesh.local, local);
    };
    qcForEachSimpleShape(object->getCollisionShape(), btTransform::getIdentity(), compare);
    return isSame && count == gathered.meshes.size();
}

bool qcBatchScene::Refresh(const btCollisionObject* object, qcBatchObject* gathered)
{
    if (IsUnchanged(object, *gathered))
        return false;
    gathered->version = ++m_lastVersion;
    m_present.clear();
    qcCollectMeshes(object->getCollisionShape(), btTransform::getIdentity(), &m_present);
    for (qcBatchMesh& mesh : m_present)
    {
        mesh.revision = qcMeshRevision(mesh.shape);
        mesh.margin = mesh.shape->getMargin();
        mesh.local = mesh.transform;
    }
    auto isSame = [](const qcBatchMesh& a, const qcBatchMesh& b)
    { return a.shape == b.shape && a.revision == b.revision; };
    if (std::equal(m_present.begin(), m_present.end(), gathered->meshes.begin(), gathered->meshes.end(), isSame))
        for (size_t i = 0; i < m_present.size(); i++)
        {
            gathered->meshes[i].margin = m_present[i].margin;
            gathered->meshes[i].local = m_present[i].local;
        }
    else
    {
        RemoveMeshes(gathered);
        gathered->meshes.swap(m_present);
    }
    Measure(*object->getCollisionShape(), gathered);
    std::vector<btVector3> origins;
    for (const qcBatchMesh& mesh : gathered->meshes)
        origins.push_back(mesh.local.getOrigin());
    gathered->places = qcMeshPlaces(origins, gathered->tolerance);
    return true;
}

void qcBatchScene::RemoveMeshes(qcBatchObject* object)
{
    for (qcBatchMesh& mesh : object->meshes)
        if (mesh.inScene)
            qcScene_RemoveBody(m_scene, mesh.id);
    object->meshes.clear();
}

qcBatchObject* qcBatchScene::FindOrAdd(const btCollisionObject* object)
{
    qcBatchObject& gathered = m_objects[qcObjectKey(object)];
    if (gathered.owner == 0)
    {
        // Those of objects that have just left count as in use, since what is known of their pairs is kept for a while.
        gathered.owner = m_owners.Take(
            [this](auto add)
            {
                for (const auto& entry : m_objects)
                    add(entry.second.owner);
            });
        gathered.present = m_gathering;
        Refresh(object, &gathered);
    }
    return &gathered;
}

/// Updates the object once a gathering.
void qcBatchScene::Update(const btCollisionObject* object, qcBatchObject* gathered)
{
    if (gathered->gathered == m_gathering)
        return;
    gathered->gathered = m_gathering;
    gathered->pairDistance = 0;
    gathered->isPlaced = false;
    gathered->edgeLength = BT_LARGE_FLOAT;
    for (qcBatchMesh& mesh : gathered->meshes)
    {
        gathered->edgeLength = std::min(gathered->edgeLength, mesh.edgeLength);
        btTransform now = object->getWorldTransform() * mesh.local;
        mesh.placed = mesh.placed && qcAreSame(mesh.transform, now);
        mesh.transform = now;
    }
    gathered->maxContactDistance = std::min(
        gathered->threshold, std::max(s_restDistance * gathered->threshold, s_maxEdges * gathered->edgeLength));
    gathered->maxClosing = MaxClosing(object, *gathered);
    const btScalar lead =
        object->isKinematicObject() ? qcRigidMotion(object).linear.length() * m_timeStep : btScalar(0);
    gathered->lead = lead <= qcMaxLead * gathered->threshold ? lead : btScalar(0);
}

/// Sets the mean motion of the bodies that may hold meshes if most of their motion is common, else none. Fragments of a
/// body that flew and turned don't close in on each other.
void qcBatchScene::FindMeanMotion()
{
    m_meanMotion = qcRigidMotion();
    std::vector<const btRigidBody*> moving;
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btRigidBody* body = btRigidBody::upcast(objects[i]);
        if (body != nullptr && !body->isStaticOrKinematicObject() && body->isActive() && qcIsFinite(*body) &&
            qcMayHoldMeshes(body->getCollisionShape()))
            moving.push_back(body);
    }
    qcRigidMotion mean;
    for (const btRigidBody* body : moving)
    {
        btScalar share = 1 / btScalar(moving.size());
        mean.centre += share * body->getWorldTransform().getOrigin();
        mean.linear += share * body->getLinearVelocity();
        mean.angular += share * body->getAngularVelocity();
    }
    btScalar speeds = 0, relativeSpeeds = 0;
    for (const btRigidBody* body : moving)
    {
        speeds += body->getLinearVelocity().length();
        relativeSpeeds += (body->getLinearVelocity() - mean.VelocityAt(body->getWorldTransform().getOrigin())).length();
    }
    if (relativeSpeeds < s_maxRelativeSpeed * speeds)
        m_meanMotion = mean;
}

/// Updates the objects of pairs, and sets the margin of the query.
void qcBatchScene::UpdatePairs(const std::vector<qcBatchPair>& pairs)
{
    m_margin = 0;
    m_spacing = 0;
    for (const qcBatchPair& pair : pairs)
    {
        qcBatchObject &a = *pair.gathered0, &b = *pair.gathered1;
        Update(pair.object0, &a);
        Update(pair.object1, &b);
        a.inScene = b.inScene = true;
        btScalar contactDistance = ContactDistance(a, b);
        a.pairDistance = std::max(a.pairDistance, contactDistance / 2);
        b.pairDistance = std::max(b.pairDistance, contactDistance / 2);
        m_margin = std::max(m_margin, contactDistance + a.margin + b.margin);
        btScalar threshold = std::min(a.threshold, b.threshold);
        if (std::min(a.edgeLength, b.edgeLength) < threshold)
            m_spacing = m_spacing > 0 ? std::min(m_spacing, threshold) : threshold;
    }
}

qcStatus qcBatchScene::UpdateMesh(qcBatchMesh* mesh, const qcBatchObject& gathered, qcActivity activity)
{
    qcStatus status = qc_statusOk;
    if (!mesh->inScene)
    {
        qcMeshDef def{mesh->shape, mesh->transform, activity, gathered.owner};
        status = qcAddMesh(m_scene, def, &mesh->id, &mesh->sources);
        mesh->inScene = status == qc_statusOk;
        if (!mesh->sources.empty())
            mesh->edgeLength = qcEdgeLengthOf(mesh->shape, mesh->sources.size());
    }
    else
    {
        if (activity != gathered.activity)
            status = qcScene_SetActivity(m_scene, mesh->id, activity);
        if (!mesh->placed && status == qc_statusOk)
        {
            qcTransform transform = qcTransformOf(mesh->transform);
            status = qcScene_SetTransform(m_scene, mesh->id, &transform);
        }
    }
    // The sum over two bodies is at least the distance that UpdatePairs requires for them.
    mesh->reach = gathered.pairDistance + mesh->margin + gathered.tolerance;
    if (status == qc_statusOk)
        status = qcScene_SetMargin(m_scene, mesh->id, double(mesh->reach));
    mesh->placed = status == qc_statusOk;
    return status;
}

/// Brings the scene up to date with an object.
void qcBatchScene::UpdateScene(const btCollisionObject* object, qcBatchObject* gathered)
{
    qcActivity activity = object->isActive()   ? qc_activityMoving
                          : qcIsStatic(object) ? qc_activityStatic
                                               : qc_activitySleeping;
    gathered->isPlaced = true;
    gathered->minReach = BT_LARGE_FLOAT;
    for (qcBatchMesh& mesh : gathered->meshes)
    {
        qcStatus status = UpdateMesh(&mesh, *gathered, activity);
        if (status != qc_statusOk)
            m_status = status;
        gathered->isPlaced = gathered->isPlaced && mesh.placed;
        gathered->minReach = std::min(gathered->minReach, mesh.reach);
    }
    gathered->activity = activity;
}

/// Removes objects that left the world in the order in which they were added: slots that are used again must not depend
/// on addresses.
void qcBatchScene::RemoveGone()
{
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        if (qcMayHoldMeshes(objects[i]->getCollisionShape()))
            if (qcBatchObject* found = Find(objects[i]))
                found->present = m_gathering;
    std::vector<qcObjectKey> gone;
    for (const auto& [key, object] : m_objects)
        if (object.present != m_gathering)
            gone.push_back(key);
    std::sort(gone.begin(), gone.end(),
              [](const qcObjectKey& a, const qcObjectKey& b)
              { return std::make_pair(a.uniqueId, a.object) < std::make_pair(b.uniqueId, b.object); });
    for (const qcObjectKey& key : gone)
    {
        auto found = m_objects.find(key);
        RemoveMeshes(&found->second);
        m_objects.erase(found);
    }
}

qcStatus qcBatchScene::Gather(const std::vector<qcBatchPair>& pairs)
{
    BT_PROFILE("qcMeshContact gather");
    m_gathering++;
    m_status = qc_statusOk;
    m_bodyCount = 0;
    RemoveGone();
    FindMeanMotion();
    UpdatePairs(pairs);
    // In the order in which the world has the objects: slots must not depend on that of pairs.
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        qcBatchObject* gathered = qcMayHoldMeshes(objects[i]->getCollisionShape()) ? Find(objects[i]) : nullptr;
        if (gathered == nullptr || !gathered->inScene)
            continue;
        if (gathered->gathered == m_gathering)
            UpdateScene(objects[i], gathered);
        for (const qcBatchMesh& mesh : gathered->meshes)
            m_bodyCount += mesh.inScene;
    }
    return m_status;
}
