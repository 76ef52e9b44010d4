// Meshes near soft bodies: collected from the broadphase, moved by contacts.
#include "soft_body/scene/rigid_meshes.h"

#include "common/compound_children.h"
#include "common/object_key.h"
#include "common/shape_triangles.h"
#include "common/weld_vertices.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

namespace
{
/// The qcMeshShapes that a shape consists of; `local` of each is the given transform times its own in the shape.
std::vector<qcSceneMesh> MeshesOf(const btCollisionShape* shape, const btTransform& transform)
{
    std::vector<qcSceneMesh> meshes;
    auto add = [&meshes](const btCollisionShape* simple, const btTransform& local)
    {
        const qcMeshShape* mesh = qcAsMeshShape(simple);
        if (mesh != nullptr && mesh->getTriangleCount() > 0)
        {
            meshes.emplace_back();
            meshes.back().shape = mesh;
            meshes.back().local = local;
            meshes.back().revision = mesh->getRevision();
        }
    };
    qcForEachSimpleShape(shape, transform, add);
    return meshes;
}

bool AreSame(const std::vector<qcSceneMesh>& a, const std::vector<qcSceneMesh>& b)
{
    auto isSame = [](const qcSceneMesh& m, const qcSceneMesh& n)
    { return m.shape == n.shape && m.revision == n.revision && m.local == n.local; };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), isSame);
}

/// Adds a mesh with its vertices welded: contacts at corners and edges that triangles share are found once.
qcStatus AddMesh(qcScene* scene, qcSceneMesh& mesh, qcActivity activity)
{
    const qcMeshShape& shape = *mesh.shape;
    std::vector<uint32_t> first = qcFirstAtPosition(shape.getVertices(), shape.getVertexCount());
    std::vector<uint32_t> indices(shape.getIndices(), shape.getIndices() + 3 * size_t(shape.getTriangleCount()));
    for (uint32_t& index : indices)
        index = first[index];
    qcBodyDef def = qcMeshBodyDef(shape.getVertices(), shape.getVertexCount(), indices.data(), shape.getTriangleCount(),
                                  mesh.sceneTransform, activity);
    def.group = qcMeshGroup;
    def.mask = qcSoftGroup;
    return qcScene_AddBody(scene, &def, &mesh.id);
}

class OverlapCallback : public btBroadphaseAabbCallback
{
  public:
    explicit OverlapCallback(std::vector<btCollisionObject*>* objects) : m_objects(objects)
    {
    }

    bool process(const btBroadphaseProxy* proxy) override
    {
        Add(static_cast<btCollisionObject*>(proxy->m_clientObject));
        return true;
    }

    void Add(btCollisionObject* object)
    {
        const btCollisionShape* shape = object->getCollisionShape();
        if (shape->isCompound() || qcAsMeshShape(shape) != nullptr)
            m_objects->push_back(object);
    }

  private:
    std::vector<btCollisionObject*>* m_objects;
};

qcStatus AddMeshes(qcScene* scene, qcSceneRigid* rigid)
{
    for (qcSceneMesh& mesh : rigid->meshes)
    {
        mesh.sceneTransform = rigid->object->getWorldTransform() * mesh.local;
        qcStatus status = AddMesh(scene, mesh, rigid->activity);
        if (status != qc_statusOk)
            return status;
    }
    return qc_statusOk;
}

void RemoveMeshes(qcScene* scene, const qcSceneRigid& rigid)
{
    for (const qcSceneMesh& mesh : rigid.meshes)
        if (qcScene_IsValid(scene, mesh.id))
            qcScene_RemoveBody(scene, mesh.id);
}

/// Reads what may differ in each step.
void ReadState(qcSceneRigid* rigid, const btTransform& start)
{
    btRigidBody* body = btRigidBody::upcast(rigid->object);
    bool isPushed = body != nullptr && body->isActive() && !body->isStaticOrKinematicObject();
    rigid->body = isPushed ? body : nullptr;
    bool moves = rigid->object->isActive() && !rigid->object->isStaticObject();
    qcActivity activity = moves || !qcAreSame(start, rigid->object->getWorldTransform()) ? qc_activityMoving
                          : rigid->object->isStaticObject()                              ? qc_activityStatic
                                                                                         : qc_activitySleeping;
    // The previous result has no pairs of two sleeping bodies.
    rigid->hasEnd = rigid->hasEnd && activity == rigid->activity;
    rigid->activity = activity;
    rigid->solved = rigid->object->getWorldTransform();
    rigid->start = start;
    rigid->movedLinear.setZero();
    rigid->movedAngular.setZero();
    rigid->fromStart = rigid->isFixed = false;
}
} // namespace

btScalar qcMaxDisplacement(const qcSceneMesh& mesh, const btTransform& from, const btTransform& to)
{
    // A corner of the box moves furthest: the difference of two transforms is affine.
    btVector3 box[2];
    mesh.shape->getAabb(btTransform::getIdentity(), box[0], box[1]);
    btScalar largest = 0;
    for (int corner = 0; corner < 8; corner++)
    {
        btVector3 point(box[corner & 1].x(), box[corner >> 1 & 1].y(), box[corner >> 2].z());
        largest = std::max(largest, (from * point).distance2(to * point));
    }
    return btSqrt(largest);
}

bool qcFindTransform(const qcSceneRigid& rigid, const qcSceneMesh& mesh, btTransform* transform)
{
    std::vector<qcSceneMesh> present = MeshesOf(rigid.object->getCollisionShape(), rigid.object->getWorldTransform());
    size_t index = size_t(&mesh - rigid.meshes.data());
    if (index >= present.size() || present[index].shape != mesh.shape || present[index].revision != mesh.revision)
        return false;
    *transform = present[index].local;
    return true;
}

btVector3 qcSceneRigid::DisplacementAt(const btVector3& arm, const btVector3& push) const
{
    if (body == nullptr || isFixed)
        return btVector3(0, 0, 0);
    btVector3 turn = body->getInvInertiaTensorWorld() * arm.cross(push) * body->getAngularFactor();
    return push * body->getLinearFactor() * body->getInvMass() + turn.cross(arm);
}

void qcSceneRigid::Push(const btVector3& arm, const btVector3& push)
{
    if (body == nullptr || isFixed)
        return;
    linear += push * body->getLinearFactor() * body->getInvMass();
    angular += body->getInvInertiaTensorWorld() * arm.cross(push) * body->getAngularFactor();
}

bool qcSceneRigid::IsFree() const
{
    const btVector3 all(1, 1, 1);
    if (body == nullptr || isFixed || body->getInvMass() <= 0)
        return false;
    const btVector3& turns = body->getInvInertiaDiagLocal();
    return turns[turns.minAxis()] > 0 && body->getLinearFactor() == all && body->getAngularFactor() == all;
}

btTransform qcSceneRigid::MotionTo(const btTransform& transform) const
{
    return transform == start ? btTransform::getIdentity() : transform * start.inverse();
}

void qcSoftBodyMeshes::CollectOverlapping(btBroadphaseInterface* broadphase, const btVector3& lower,
                                          const btVector3& upper)
{
    OverlapCallback callback(&m_overlapping);
    broadphase->aabbTest(lower, upper, callback);
    m_starts.ForEachMoved(lower, upper, [&callback](btCollisionObject* object) { callback.Add(object); });
}

/// The collected objects that have meshes. Those that are tracked already, unchanged, are moved out of m_rigids.
std::vector<std::unique_ptr<qcSceneRigid>> qcSoftBodyMeshes::TakeTracked()
{
    auto isBefore = [](const btCollisionObject* a, const btCollisionObject* b)
    { return qcUniqueIdOf(a) < qcUniqueIdOf(b); };
    std::sort(m_overlapping.begin(), m_overlapping.end(), isBefore);
    m_overlapping.erase(std::unique(m_overlapping.begin(), m_overlapping.end()), m_overlapping.end());
    std::vector<std::unique_ptr<qcSceneRigid>> rigids;
    for (btCollisionObject* object : m_overlapping)
    {
        std::unique_ptr<qcSceneRigid> rigid(new qcSceneRigid);
        rigid->meshes = MeshesOf(object->getCollisionShape(), btTransform::getIdentity());
        if (rigid->meshes.empty())
            continue;
        rigid->object = object;
        rigid->uniqueId = qcUniqueIdOf(object);
        auto isSame = [&](const std::unique_ptr<qcSceneRigid>& other)
        {
            return other && other->object == object && other->uniqueId == rigid->uniqueId &&
                   AreSame(other->meshes, rigid->meshes);
        };
        auto found = std::find_if(m_rigids.begin(), m_rigids.end(), isSame);
        if (found != m_rigids.end())
            rigid = std::move(*found);
        rigids.push_back(std::move(rigid));
    }
    m_overlapping.clear();
    return rigids;
}

/// Appends the object, with its meshes in the scene. After a failure it is not tracked, and none of them is there.
qcStatus qcSoftBodyMeshes::Track(qcScene* scene, std::unique_ptr<qcSceneRigid> rigid)
{
    qcActivity previous = rigid->activity;
    ReadState(rigid.get(), m_starts.StartOf(rigid->object));
    qcStatus status = qc_statusOk;
    if (rigid->meshes[0].id.generation == 0)
        status = AddMeshes(scene, rigid.get());
    else if (rigid->activity != previous)
        for (const qcSceneMesh& mesh : rigid->meshes)
            status = std::max(status, qcScene_SetActivity(scene, mesh.id, rigid->activity));
    if (status == qc_statusOk)
        m_rigids.push_back(std::move(rigid));
    else
        RemoveMeshes(scene, *rigid);
    return status;
}

void qcSoftBodyMeshes::IndexSlots()
{
    m_meshOfSlot.clear();
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (size_t i = 0; i < rigid->meshes.size(); i++)
        {
            uint32_t slot = rigid->meshes[i].id.slot;
            if (slot >= m_meshOfSlot.size())
                m_meshOfSlot.resize(slot + 1, {nullptr, 0});
            m_meshOfSlot[slot] = {rigid.get(), i};
        }
}

qcStatus qcSoftBodyMeshes::Sync(qcScene* scene)
{
    std::vector<std::unique_ptr<qcSceneRigid>> rigids = TakeTracked();
    for (const std::unique_ptr<qcSceneRigid>& gone : m_rigids)
        if (gone)
            RemoveMeshes(scene, *gone);
    m_rigids.clear();
    qcStatus status = qc_statusOk;
    for (std::unique_ptr<qcSceneRigid>& rigid : rigids)
    {
        qcStatus tracked = Track(scene, std::move(rigid));
        if (status == qc_statusOk)
            status = tracked;
    }
    IndexSlots();
    return status;
}

bool qcSoftBodyMeshes::StartWhereTheyEnded() const
{
    auto startsThere = [](const std::unique_ptr<qcSceneRigid>& rigid)
    { return rigid->hasEnd && rigid->start == rigid->end; };
    return std::all_of(m_rigids.begin(), m_rigids.end(), startsThere);
}

qcStatus qcSoftBodyMeshes::SyncTransforms(qcScene* scene, bool atStart)
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (qcSceneMesh& mesh : rigid->meshes)
        {
            qcScene_SetMargin(scene, mesh.id, double(mesh.shape->getMargin()));
            btTransform transform = (atStart ? rigid->start : rigid->object->getWorldTransform()) * mesh.local;
            if (mesh.sceneTransform == transform)
                continue;
            qcTransform converted = qcTransformOf(transform);
            qcStatus status = qcScene_SetTransform(scene, mesh.id, &converted);
            if (status != qc_statusOk)
                return status;
            mesh.sceneTransform = transform;
        }
    return qc_statusOk;
}

void qcSoftBodyMeshes::Commit()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        if (rigid->linear.isZero() && rigid->angular.isZero())
            continue;
        btTransform moved;
        btTransformUtil::integrateTransform(rigid->object->getWorldTransform(), rigid->linear, rigid->angular, 1,
                                            moved);
        rigid->object->setWorldTransform(moved);
        rigid->movedLinear += rigid->linear;
        rigid->movedAngular += rigid->angular;
        rigid->linear.setZero();
        rigid->angular.setZero();
    }
}

void qcSoftBodyMeshes::MoveFromStart(qcSceneRigid& rigid, const btTransform& motion)
{
    if (!rigid.IsFree())
        return;
    rigid.fromStart = true;
    rigid.object->setWorldTransform(motion == btTransform::getIdentity() ? rigid.start : motion * rigid.start);
}

void qcSoftBodyMeshes::UpdateVelocities(btScalar timeStep)
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        btRigidBody* body = rigid->body;
        bool moved = rigid->fromStart || !rigid->movedLinear.isZero() || !rigid->movedAngular.isZero();
        if (body == nullptr || !moved)
            continue;
        if (rigid->fromStart)
        {
            btVector3 linear, angular;
            btTransformUtil::calculateVelocity(rigid->start, rigid->object->getWorldTransform(), timeStep, linear,
                                               angular);
            body->setLinearVelocity(linear);
            body->setAngularVelocity(angular);
        }
        else
        {
            body->setLinearVelocity(body->getLinearVelocity() + rigid->movedLinear / timeStep);
            body->setAngularVelocity(body->getAngularVelocity() + rigid->movedAngular / timeStep);
        }
        // Also sets Bullet's interpolation transform and the inertia tensor in world space.
        body->setCenterOfMassTransform(btTransform(rigid->object->getWorldTransform()));
        rigid->fromStart = false;
        rigid->movedLinear.setZero();
        rigid->movedAngular.setZero();
    }
    RecordEnds();
}

bool qcSoftBodyMeshes::Fix(const std::vector<const btCollisionObject*>& objects)
{
    bool any = false;
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        if (std::find(objects.begin(), objects.end(), rigid->object) != objects.end())
            rigid->isFixed = any = true;
    return any;
}

void qcSoftBodyMeshes::RecordEnds()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        rigid->hasEnd = true;
        rigid->end = rigid->object->getWorldTransform();
        m_starts.RecordEnd(rigid->object);
    }
}

void qcSoftBodyMeshes::Restore()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        rigid->linear.setZero();
        rigid->angular.setZero();
        if (rigid->body != nullptr)
            rigid->object->setWorldTransform(rigid->solved);
    }
    RecordEnds();
}

const qcSceneMesh* qcSoftBodyMeshes::Find(uint32_t slot, qcSceneRigid** rigid)
{
    if (slot >= m_meshOfSlot.size() || m_meshOfSlot[slot].first == nullptr)
        return nullptr;
    *rigid = m_meshOfSlot[slot].first;
    return &(*rigid)->meshes[m_meshOfSlot[slot].second];
}
