// Bullet's own algorithm for a soft body and a concave shape makes a prism 12 cm thick of each triangle in reach,
// samples a distance field for each, and pushes each node out of each prism by itself: see
// tests/bullet/soft_body/test_soft_body_mesh.cpp for what becomes of that on a fine mesh. Here the pair is left to
// qcSoftBodyContact.
#include "soft_body/algorithm_override.h"

#include "common/shape_triangles.h"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btEmptyCollisionAlgorithm.h>

struct qcSoftMeshTakeOver::Create : btCollisionAlgorithmCreateFunc
{
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        // Another class with the shape type of qcMeshShape: as without us.
        if (qcAsMeshShape(body0->getCollisionShape()) == nullptr &&
            qcAsMeshShape(body1->getCollisionShape()) == nullptr)
            return bullets->CreateCollisionAlgorithm(info, body0, body1);
        return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btEmptyAlgorithm))) btEmptyAlgorithm(info);
    }

    btCollisionAlgorithmCreateFunc* bullets = nullptr;
};

qcSoftMeshTakeOver::qcSoftMeshTakeOver() : m_create(new Create), m_swappedCreate(new Create)
{
}

qcSoftMeshTakeOver::~qcSoftMeshTakeOver()
{
    Register(nullptr);
}

void qcSoftMeshTakeOver::Register(btDispatcher* dispatcher)
{
    if (dispatcher == m_dispatcher)
        return;
    const int soft = SOFTBODY_SHAPE_PROXYTYPE, mesh = FAST_CONCAVE_MESH_PROXYTYPE;
    if (auto* old = dynamic_cast<btCollisionDispatcher*>(m_dispatcher))
    {
        old->registerCollisionCreateFunc(soft, mesh, m_create->bullets);
        old->registerCollisionCreateFunc(mesh, soft, m_swappedCreate->bullets);
    }
    m_dispatcher = dispatcher;
    if (auto* now = dynamic_cast<btCollisionDispatcher*>(dispatcher))
    {
        btCollisionConfiguration* configuration = now->getCollisionConfiguration();
        m_create->bullets = configuration->getCollisionAlgorithmCreateFunc(soft, mesh);
        m_swappedCreate->bullets = configuration->getCollisionAlgorithmCreateFunc(mesh, soft);
        now->registerCollisionCreateFunc(soft, mesh, m_create.get());
        now->registerCollisionCreateFunc(mesh, soft, m_swappedCreate.get());
    }
}
