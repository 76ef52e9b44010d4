// Pairs of a soft and a rigid body: qcSoftBodyContact answers them, in place of Bullet's algorithms.
//
// Bullet tests nodes by themselves: edges and faces pass, and a node that moves by more than the body's size does.
// For a concave shape it makes a prism 12 cm thick of each triangle nearby and pushes each node out of each prism. The
// result on a fine mesh: tests/bullet/soft_body/test_soft_body_mesh.cpp.
#include "soft_body/algorithm_override.h"

#include "common/shape_triangles.h"
#include "soft_body/scene/soft_scene.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBodySolvers.h>

#include <mutex>

namespace
{
/// Bullet's algorithm is running: those that it creates for single triangles of a concave shape are its own, too.
thread_local bool t_isInBullets = false;
std::mutex s_liveObjects;

/// The rigid one of the two.
const btCollisionObjectWrapper* RigidOf(const btCollisionObjectWrapper* a, const btCollisionObjectWrapper* b)
{
    return a->getCollisionShape()->getShapeType() == SOFTBODY_SHAPE_PROXYTYPE ? b : a;
}

/// False where Bullet's deformable solver would read an impulse matrix that its test of nodes has not set: it sets that
/// for rigid bodies and links alone, and sensors threw the nodes in them away.
bool AnswersNodes(const btCollisionObject* soft, const btCollisionObject* object)
{
    const btSoftBody* body = btSoftBody::upcast(soft);
    return body == nullptr || body->m_softBodySolver == nullptr ||
           const_cast<btSoftBody*>(body)->getSoftBodySolver()->getSolverType() != btSoftBodySolver::DEFORMABLE_SOLVER ||
           btRigidBody::upcast(object) != nullptr || btMultiBodyLinkCollider::upcast(object) != nullptr;
}
} // namespace

/// Runs Bullet's algorithm where the soft body's settings or the other shape require it. Both may change in each step.
class qcAlgorithmOverride::Gate : public btCollisionAlgorithm
{
  public:
    Gate(btCollisionAlgorithmConstructionInfo& info, btCollisionAlgorithm* original, qcSoftBodyScene& scene)
        : btCollisionAlgorithm(info), m_original(original), m_scene(scene)
    {
    }
    Gate(const Gate&) = delete;
    Gate& operator=(const Gate&) = delete;

    ~Gate() override
    {
        if (m_original == nullptr)
            return;
        m_original->~btCollisionAlgorithm();
        m_dispatcher->freeCollisionAlgorithm(m_original);
    }

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& info, btManifoldResult* result) override
    {
        const btCollisionObjectWrapper *rigid = RigidOf(body0, body1), *soft = rigid == body0 ? body1 : body0;
        if (!t_isInBullets && IsOurs(*soft, *rigid))
        {
            // Bullet may dispatch pairs on several threads.
            std::lock_guard<std::mutex> lock(s_liveObjects);
            m_scene.liveObjects.emplace_back(rigid->getCollisionObject());
            return;
        }
        if (!AnswersNodes(soft->getCollisionObject(), rigid->getCollisionObject()))
            return;
        const bool wasInBullets = t_isInBullets;
        t_isInBullets = true;
        m_original->processCollision(body0, body1, info, result);
        t_isInBullets = wasInBullets;
    }

    btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1, const btDispatcherInfo& info,
                                   btManifoldResult* result) override
    {
        return m_original != nullptr ? m_original->calculateTimeOfImpact(body0, body1, info, result) : btScalar(1);
    }

    void getAllContactManifolds(btManifoldArray& manifolds) override
    {
        if (m_original != nullptr)
            m_original->getAllContactManifolds(manifolds);
    }

  private:
    bool IsOurs(const btCollisionObjectWrapper& soft, const btCollisionObjectWrapper& rigid) const
    {
        if (m_original == nullptr)
            return true;
        const btSoftBody* body = btSoftBody::upcast(soft.getCollisionObject());
        return body != nullptr && !m_scene.hasFailed && rigid.getCollisionObject()->hasContactResponse() &&
               qcHasSurface(rigid.getCollisionShape()) && qcCollidesWithSurfaces(body, m_scene.GetSettings(body));
    }

    btCollisionAlgorithm* m_original; ///< null for a qcMeshShape
    qcSoftBodyScene& m_scene;
};

struct qcAlgorithmOverride::CreateFunc : btCollisionAlgorithmCreateFunc
{
    explicit CreateFunc(qcSoftBodyScene& softScene) : scene(softScene)
    {
    }

    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        bool isMesh = qcAsMeshShape(RigidOf(body0, body1)->getCollisionShape()) != nullptr;
        btCollisionAlgorithm* bullets = isMesh ? nullptr : original->CreateCollisionAlgorithm(info, body0, body1);
        if (!isMesh && bullets == nullptr)
            return nullptr;
        return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Gate))) Gate(info, bullets, scene);
    }

    qcSoftBodyScene& scene;
    btCollisionAlgorithmCreateFunc* original = nullptr;
};

namespace
{
/// Compounds are taken apart into their children by Bullet's own algorithm.
bool IsOverridden(int type)
{
    return type != SOFTBODY_SHAPE_PROXYTYPE && !btBroadphaseProxy::isCompound(type) &&
           (btBroadphaseProxy::isConvex(type) || btBroadphaseProxy::isConcave(type));
}
} // namespace

qcAlgorithmOverride::qcAlgorithmOverride(qcSoftBodyScene& scene)
{
    for (int i = 0; i < 2 * MAX_BROADPHASE_COLLISION_TYPES; i++)
        m_createFuncs.emplace_back(new CreateFunc(scene));
}

qcAlgorithmOverride::~qcAlgorithmOverride()
{
    Register(nullptr);
}

void qcAlgorithmOverride::Register(btDispatcher* dispatcher)
{
    if (dispatcher == m_dispatcher)
        return;
    auto* previous = dynamic_cast<btCollisionDispatcher*>(m_dispatcher);
    auto* next = dynamic_cast<btCollisionDispatcher*>(dispatcher);
    m_dispatcher = dispatcher;
    const int soft = SOFTBODY_SHAPE_PROXYTYPE;
    for (int type = 0; type < MAX_BROADPHASE_COLLISION_TYPES; type++)
    {
        if (!IsOverridden(type))
            continue;
        CreateFunc &first = *m_createFuncs[2 * size_t(type)], &second = *m_createFuncs[2 * size_t(type) + 1];
        if (previous != nullptr)
        {
            previous->registerCollisionCreateFunc(soft, type, first.original);
            previous->registerCollisionCreateFunc(type, soft, second.original);
        }
        if (next != nullptr)
        {
            btCollisionConfiguration* configuration = next->getCollisionConfiguration();
            first.original = configuration->getCollisionAlgorithmCreateFunc(soft, type);
            second.original = configuration->getCollisionAlgorithmCreateFunc(type, soft);
            next->registerCollisionCreateFunc(soft, type, &first);
            next->registerCollisionCreateFunc(type, soft, &second);
        }
    }
}
