// Energy, contacts and penetrating pairs of a Bullet world.
#include "bench/stability/world_measure.h"

#include "bench/stability/world_support.h"
#include "common/bullet/mesh_body.h"
#include "quickcullide/bullet_mesh.h"
#include "quickcullide/bullet_positions.h"

#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <memory>
#include <vector>

namespace
{
enum Group : uint32_t
{
    s_fixed = 1,
    s_moving = 2
};

struct SceneDeleter
{
    void operator()(qcScene* scene) const
    {
        qcScene_Destroy(scene);
    }
};

void AddSoftEnergy(const btSoftBody& soft, const btVector3& gravity, qcWorldMeasure* measure)
{
    for (int i = 0; i < soft.m_nodes.size(); i++)
    {
        const btSoftBody::Node& node = soft.m_nodes[i];
        if (node.m_im <= 0)
            continue;
        double mass = 1 / double(node.m_im);
        measure->mass += mass;
        measure->kinetic += mass * double(node.m_v.length2()) / 2;
        measure->energy -= mass * double(gravity.dot(node.m_x));
    }
}

void AddRigidEnergy(const btRigidBody& rigid, const btVector3& gravity, qcWorldMeasure* measure)
{
    double mass = double(rigid.getMass());
    btVector3 spin = rigid.getAngularVelocity() * rigid.getWorldTransform().getBasis();
    measure->mass += mass;
    measure->kinetic += mass * double(rigid.getLinearVelocity().length2()) / 2;
    measure->energy -= mass * double(gravity.dot(rigid.getWorldTransform().getOrigin()));
    for (int axis = 0; axis < 3; axis++)
        if (rigid.getInvInertiaDiagLocal()[axis] > 0)
            measure->kinetic += double(spin[axis] * spin[axis] / rigid.getInvInertiaDiagLocal()[axis]) / 2;
}

/// Faces, and the links of ropes as triangles with two equal corners.
qcStatus AddSoft(qcScene* scene, const btSoftBody& soft, bool selfCollision)
{
    std::vector<uint32_t> indices;
    auto add = [&](const btSoftBody::Node* node) { indices.push_back(uint32_t(node - &soft.m_nodes[0])); };
    for (int i = 0; i < soft.m_faces.size(); i++)
        for (const btSoftBody::Node* node : soft.m_faces[i].m_n)
            add(node);
    for (int i = 0; i < soft.m_links.size() && soft.m_faces.size() == 0; i++)
        for (int corner : {0, 1, 1})
            add(soft.m_links[i].m_n[corner]);
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = soft.m_nodes.size() != 0 ? &soft.m_nodes[0].m_x : nullptr;
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btSoftBody::Node);
    def.vertexCount = uint32_t(soft.m_nodes.size());
    def.indices = indices.data();
    def.triangleCount = uint32_t(indices.size() / 3);
    def.deforming = true;
    def.selfCollision = selfCollision;
    def.group = s_moving;
    qcBodyId id;
    return qcScene_AddBody(scene, &def, &id);
}

/// `owner`: the same for all meshes of an object.
qcStatus AddMesh(qcScene* scene, const qcMeshShape& mesh, const btTransform& place, bool isFixed, uint32_t owner)
{
    qcBodyDef def = qcMeshBodyDef(mesh, place);
    def.group = isFixed ? s_fixed : s_moving;
    def.mask = isFixed ? s_moving : s_moving | s_fixed;
    def.owner = owner;
    qcBodyId id;
    return qcScene_AddBody(scene, &def, &id);
}

/// The meshes of a shape, also in compounds; `count` grows by their number.
qcStatus AddShape(qcScene* scene, const btCollisionShape& shape, const btTransform& place, bool isFixed, uint32_t owner,
                  size_t* count)
{
    qcStatus status = qc_statusOk;
    if (auto mesh = dynamic_cast<const qcMeshShape*>(&shape))
    {
        ++*count;
        return AddMesh(scene, *mesh, place, isFixed, owner);
    }
    if (!shape.isCompound())
        return qc_statusOk;
    const auto& compound = static_cast<const btCompoundShape&>(shape);
    for (int i = 0; i < compound.getNumChildShapes() && status == qc_statusOk; i++)
        status =
            AddShape(scene, *compound.getChildShape(i), place * compound.getChildTransform(i), isFixed, owner, count);
    return status;
}
} // namespace

qcWorldMeasure qcMeasureWorld(const btDiscreteDynamicsWorld& world)
{
    qcWorldMeasure measure;
    btVector3 gravity = world.getGravity();
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMoves(*objects[i]))
            continue;
        measure.bodies++;
        if (const btSoftBody* soft = btSoftBody::upcast(objects[i]))
            AddSoftEnergy(*soft, gravity, &measure);
        else if (const btRigidBody* rigid = btRigidBody::upcast(objects[i]))
            AddRigidEnergy(*rigid, gravity, &measure);
    }
    measure.energy += measure.kinetic;
    // Bullet's getter is const on the array only.
    auto dispatcher = const_cast<btDispatcher*>(world.getDispatcher());
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(m);
        measure.contacts += manifold.getNumContacts();
        for (int i = 0; i < manifold.getNumContacts(); i++)
            measure.depth = std::max(measure.depth, -double(manifold.getContactPoint(i).getDistance()));
    }
    return measure;
}

bool qcCountPenetrating(const btDiscreteDynamicsWorld& world, bool selfCollision, qcPenetratingPairs* pairs)
{
    *pairs = qcPenetratingPairs();
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* made = nullptr;
    qcStatus status = qcScene_Create(&sceneDef, &made);
    std::unique_ptr<qcScene, SceneDeleter> scene(made);
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    std::vector<bool> isSoft; // of each body of the scene
    for (int i = 0; i < objects.size() && status == qc_statusOk; i++)
    {
        const btSoftBody* soft = btSoftBody::upcast(objects[i]);
        size_t count = soft != nullptr;
        status = soft != nullptr
                     ? AddSoft(scene.get(), *soft, selfCollision)
                     : AddShape(scene.get(), *objects[i]->getCollisionShape(), objects[i]->getWorldTransform(),
                                objects[i]->isStaticOrKinematicObject(), uint32_t(i + 1), &count);
        isSoft.insert(isSoft.end(), count, soft != nullptr);
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    const qcResult* result = nullptr;
    if (status == qc_statusOk)
        status = qcScene_Detect(scene.get(), &def, &result);
    if (status != qc_statusOk)
        return false;
    pairs->all = result->pairCount;
    for (size_t i = 0; i < result->pairCount; i++)
        pairs->soft += isSoft[result->pairs[i].bodyA] || isSoft[result->pairs[i].bodyB];
    return true;
}

void qcKeepAwake(btDiscreteDynamicsWorld* world)
{
    btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        if (qcMoves(*objects[i]))
            objects[i]->forceActivationState(DISABLE_DEACTIVATION);
}
