// Meshes near soft bodies: found through the broadphase, moved by contacts.
#include "soft_body/scene/rigid_meshes.h"

#include "common/object_key.h"
#include "common/shape_triangles.h"
#include "common/weld_vertices.h"
#include "quickcullide/bullet_positions.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <LinearMath/btTransformUtil.h>

#include <algorithm>

namespace
{
void CollectMeshes(const btCollisionShape* shape, const btTransform& local, std::vector<qcSceneMesh>* meshes)
{
    if (shape->isCompound())
    {
        const auto* compound = static_cast<const btCompoundShape*>(shape);
        for (int i = 0; i < compound->getNumChildShapes(); i++)
            CollectMeshes(compound->getChildShape(i), local * compound->getChildTransform(i), meshes);
        return;
    }
    const qcMeshShape* ours = qcAsMeshShape(shape);
    if (ours == nullptr || ours->getTriangleCount() == 0)
        return;
    qcSceneMesh mesh;
    mesh.shape = ours;
    mesh.local = local;
    mesh.revision = ours->getRevision();
    meshes->push_back(mesh);
}

bool AreSame(const std::vector<qcSceneMesh>& a, const std::vector<qcSceneMesh>& b)
{
    auto isSame = [](const qcSceneMesh& m, const qcSceneMesh& n)
    { return m.shape == n.shape && m.revision == n.revision && m.local == n.local; };
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), isSame);
}

/// With vertices at the same position as one, so that corners and edges that triangles share are met once.
qcStatus AddMesh(qcScene* scene, qcSceneMesh& mesh, qcActivity activity)
{
    const qcMeshShape& shape = *mesh.shape;
    std::vector<uint32_t> first = qcFirstAtPosition(shape.getVertices(), shape.getVertexCount());
    std::vector<uint32_t> indices(shape.getIndices(), shape.getIndices() + 3 * size_t(shape.getTriangleCount()));
    for (uint32_t& index : indices)
        index = first[index];
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = shape.getVertices();
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btVector3);
    def.vertexCount = shape.getVertexCount();
    def.indices = indices.data();
    def.triangleCount = shape.getTriangleCount();
    def.transform = qcTransformOf(mesh.placed);
    def.activity = activity;
    def.selfCollision = false;
    def.group = qcMeshGroup;
    def.mask = qcSoftGroup;
    return qcScene_AddBody(scene, &def, &mesh.id);
}

/// Where the object was a step ago. Bullet gives kinematic bodies the velocity that led to where they are.
btTransform StartOf(const qcSceneRigid& rigid, btScalar timeStep)
{
    const btTransform& now = rigid.object->getWorldTransform();
    const btRigidBody* body = btRigidBody::upcast(rigid.object);
    if (body == nullptr || !body->isActive() || body->isStaticObject())
        return now;
    btTransform start;
    btTransformUtil::integrateTransform(now, body->getLinearVelocity(), body->getAngularVelocity(), -timeStep, start);
    // Where that is known, to the last bit, with whatever Bullet did beside velocities: what did not penetrate there
    // must not seem to. But further away than the mesh is large somebody put it elsewhere since then, which is no
    // motion.
    auto isThere = [&](const qcSceneMesh& mesh)
    {
        btVector3 box[2];
        mesh.shape->getAabb(btTransform::getIdentity(), box[0], box[1]);
        return qcMotionOf(mesh, rigid.end * mesh.local, start * mesh.local) <= (box[1] - box[0]).length() / 2;
    };
    bool known = rigid.ended && std::all_of(rigid.meshes.begin(), rigid.meshes.end(), isThere);
    return known ? rigid.end : start;
}

class Seeker : public btBroadphaseAabbCallback
{
  public:
    explicit Seeker(std::vector<btCollisionObject*>* sought) : m_sought(sought)
    {
    }

    bool process(const btBroadphaseProxy* proxy) override
    {
        auto* object = static_cast<btCollisionObject*>(proxy->m_clientObject);
        const btCollisionShape* shape = object->getCollisionShape();
        if (shape->isCompound() || qcAsMeshShape(shape) != nullptr)
            m_sought->push_back(object);
        return true;
    }

  private:
    std::vector<btCollisionObject*>* m_sought;
};
} // namespace

btScalar qcMotionOf(const qcSceneMesh& mesh, const btTransform& from, const btTransform& to)
{
    // The furthest moves a corner of the box, since a difference of motions is affine.
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

bool qcFindPlace(const qcSceneRigid& rigid, const qcSceneMesh& mesh, btTransform* place)
{
    std::vector<qcSceneMesh> present;
    CollectMeshes(rigid.object->getCollisionShape(), rigid.object->getWorldTransform(), &present);
    size_t number = size_t(&mesh - rigid.meshes.data());
    if (number >= present.size() || present[number].shape != mesh.shape || present[number].revision != mesh.revision)
        return false;
    *place = present[number].local;
    return true;
}

void qcPlaceVertex(const qcSceneMesh& mesh, const btTransform& transform, uint32_t vertex, double place[3])
{
    const btVector3& p = mesh.shape->getVertices()[vertex];
    qcTransform t = qcTransformOf(transform);
    for (int axis = 0; axis < 3; axis++)
    {
        const double* row = &t.linear[3 * axis];
        place[axis] = row[0] * double(p.x()) + row[1] * double(p.y()) + row[2] * double(p.z()) + t.translation[axis];
    }
}

btVector3 qcSceneRigid::Yield(const btVector3& arm, const btVector3& push) const
{
    if (body == nullptr)
        return btVector3(0, 0, 0);
    btVector3 turn = body->getInvInertiaTensorWorld() * arm.cross(push) * body->getAngularFactor();
    return push * body->getLinearFactor() * body->getInvMass() + turn.cross(arm);
}

void qcSceneRigid::Push(const btVector3& arm, const btVector3& push)
{
    if (body == nullptr)
        return;
    linear += push * body->getLinearFactor() * body->getInvMass();
    angular += body->getInvInertiaTensorWorld() * arm.cross(push) * body->getAngularFactor();
}

bool qcSceneRigid::IsFree() const
{
    const btVector3 all(1, 1, 1);
    if (body == nullptr || body->getInvMass() <= 0)
        return false;
    const btVector3& turns = body->getInvInertiaDiagLocal();
    return turns[turns.minAxis()] > 0 && body->getLinearFactor() == all && body->getAngularFactor() == all;
}

btTransform qcSceneRigid::MotionTo(const btTransform& transform) const
{
    return transform == start ? btTransform::getIdentity() : transform * start.inverse();
}

void qcSoftBodyMeshes::Seek(btBroadphaseInterface* broadphase, const btVector3& lower, const btVector3& upper)
{
    Seeker seeker(&m_sought);
    broadphase->aabbTest(lower, upper, seeker);
}

qcStatus qcSoftBodyMeshes::Add(qcScene* scene, qcSceneRigid* rigid)
{
    for (qcSceneMesh& mesh : rigid->meshes)
    {
        mesh.placed = rigid->object->getWorldTransform() * mesh.local;
        qcStatus status = AddMesh(scene, mesh, rigid->activity);
        if (status != qc_statusOk)
            return status;
    }
    return qc_statusOk;
}

/// What is another one in each step.
void qcSoftBodyMeshes::Refresh(qcSceneRigid* rigid, btScalar timeStep)
{
    btRigidBody* body = btRigidBody::upcast(rigid->object);
    bool pushed = body != nullptr && body->isActive() && !body->isStaticOrKinematicObject();
    rigid->body = pushed ? body : nullptr;
    qcActivity activity = rigid->object->isStaticObject() ? qc_activityStatic
                          : rigid->object->isActive()     ? qc_activityMoving
                                                          : qc_activitySleeping;
    // Pairs that slept were not in the last result.
    rigid->ended = rigid->ended && activity == rigid->activity;
    rigid->activity = activity;
    rigid->solved = rigid->object->getWorldTransform();
    rigid->start = StartOf(*rigid, timeStep);
    rigid->movedLinear.setZero();
    rigid->movedAngular.setZero();
    rigid->fromStart = false;
}

void qcSoftBodyMeshes::NumberMeshes()
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

qcStatus qcSoftBodyMeshes::Synchronize(qcScene* scene, btScalar timeStep)
{
    auto isBefore = [](const btCollisionObject* a, const btCollisionObject* b)
    { return qcAdditionOf(a) < qcAdditionOf(b); };
    std::sort(m_sought.begin(), m_sought.end(), isBefore);
    m_sought.erase(std::unique(m_sought.begin(), m_sought.end()), m_sought.end());
    std::vector<std::unique_ptr<qcSceneRigid>> known, now;
    known.swap(m_rigids);
    for (btCollisionObject* object : m_sought)
    {
        std::unique_ptr<qcSceneRigid> rigid(new qcSceneRigid);
        CollectMeshes(object->getCollisionShape(), btTransform::getIdentity(), &rigid->meshes);
        if (rigid->meshes.empty())
            continue;
        rigid->object = object;
        rigid->addition = qcAdditionOf(object);
        auto isSame = [&](const std::unique_ptr<qcSceneRigid>& other)
        {
            return other && other->object == object && other->addition == rigid->addition &&
                   AreSame(other->meshes, rigid->meshes);
        };
        auto found = std::find_if(known.begin(), known.end(), isSame);
        if (found != known.end())
            rigid = std::move(*found);
        now.push_back(std::move(rigid));
    }
    m_sought.clear();
    auto removeFrom = [&](const qcSceneRigid& rigid)
    {
        for (const qcSceneMesh& mesh : rigid.meshes)
            if (qcScene_IsValid(scene, mesh.id))
                qcScene_RemoveBody(scene, mesh.id);
    };
    for (const std::unique_ptr<qcSceneRigid>& rigid : known)
        if (rigid)
            removeFrom(*rigid);
    qcStatus status = qc_statusOk;
    for (std::unique_ptr<qcSceneRigid>& rigid : now)
    {
        qcActivity before = rigid->activity;
        Refresh(rigid.get(), timeStep);
        qcStatus mine = qc_statusOk;
        if (rigid->meshes[0].id.generation == 0)
            mine = Add(scene, rigid.get());
        else if (rigid->activity != before)
            for (const qcSceneMesh& mesh : rigid->meshes)
                mine = std::max(mine, qcScene_SetActivity(scene, mesh.id, rigid->activity));
        if (mine == qc_statusOk)
            m_rigids.push_back(std::move(rigid));
        else
            removeFrom(*rigid);
        if (status == qc_statusOk)
            status = mine;
    }
    NumberMeshes();
    return status;
}

bool qcSoftBodyMeshes::StartWhereTheyEnded() const
{
    auto isThere = [](const std::unique_ptr<qcSceneRigid>& rigid)
    { return rigid->ended && rigid->start == rigid->end; };
    return std::all_of(m_rigids.begin(), m_rigids.end(), isThere);
}

qcStatus qcSoftBodyMeshes::Place(qcScene* scene, bool atStart)
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (qcSceneMesh& mesh : rigid->meshes)
        {
            qcScene_SetMargin(scene, mesh.id, double(mesh.shape->getMargin()));
            btTransform transform = (atStart ? rigid->start : rigid->object->getWorldTransform()) * mesh.local;
            if (mesh.placed == transform)
                continue;
            qcTransform placed = qcTransformOf(transform);
            qcStatus status = qcScene_SetTransform(scene, mesh.id, &placed);
            if (status != qc_statusOk)
                return status;
            mesh.placed = transform;
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
        // What Bullet interpolates from, and the tensor, go along.
        body->setCenterOfMassTransform(btTransform(rigid->object->getWorldTransform()));
    }
    NoteEnds();
}

void qcSoftBodyMeshes::NoteEnds()
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
    {
        rigid->ended = true;
        rigid->end = rigid->object->getWorldTransform();
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
    NoteEnds();
}

const qcSceneMesh* qcSoftBodyMeshes::Find(uint32_t slot, qcSceneRigid** rigid)
{
    if (slot >= m_meshOfSlot.size() || m_meshOfSlot[slot].first == nullptr)
        return nullptr;
    *rigid = m_meshOfSlot[slot].first;
    return &(*rigid)->meshes[m_meshOfSlot[slot].second];
}
