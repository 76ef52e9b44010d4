// Pairs of a soft body and a qcMeshShape get an empty algorithm: qcSoftBodyContact answers them.
//
// Bullet's own algorithm for a soft body and a concave shape makes a prism 12 cm thick of each triangle nearby, samples
// a distance field for each, and pushes each node out of each prism by itself. The result on a fine mesh:
// tests/bullet/soft_body/test_soft_body_mesh.cpp.
#include "soft_body/algorithm_override.h"

#include "common/shape_triangles.h"

#include <BulletCollision/CollisionDispatch/btCollisionConfiguration.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btEmptyCollisionAlgorithm.h>

struct qcAlgorithmOverride::CreateFunc : btCollisionAlgorithmCreateFunc
{
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override
    {
        // Another class with the shape type of qcMeshShape keeps its algorithm.
        if (qcAsMeshShape(body0->getCollisionShape()) == nullptr &&
            qcAsMeshShape(body1->getCollisionShape()) == nullptr)
            return original->CreateCollisionAlgorithm(info, body0, body1);
        return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(btEmptyAlgorithm))) btEmptyAlgorithm(info);
    }

    btCollisionAlgorithmCreateFunc* original = nullptr;
};

qcAlgorithmOverride::qcAlgorithmOverride() : m_createFunc(new CreateFunc), m_swappedCreateFunc(new CreateFunc)
{
}

qcAlgorithmOverride::~qcAlgorithmOverride()
{
    Register(nullptr);
}

void qcAlgorithmOverride::Register(btDispatcher* dispatcher)
{
    if (dispatcher == m_dispatcher)
        return;
    const int soft = SOFTBODY_SHAPE_PROXYTYPE, mesh = FAST_CONCAVE_MESH_PROXYTYPE;
    if (auto* previous = dynamic_cast<btCollisionDispatcher*>(m_dispatcher))
    {
        previous->registerCollisionCreateFunc(soft, mesh, m_createFunc->original);
        previous->registerCollisionCreateFunc(mesh, soft, m_swappedCreateFunc->original);
    }
    m_dispatcher = dispatcher;
    if (auto* next = dynamic_cast<btCollisionDispatcher*>(dispatcher))
    {
        btCollisionConfiguration* configuration = next->getCollisionConfiguration();
        m_createFunc->original = configuration->getCollisionAlgorithmCreateFunc(soft, mesh);
        m_swappedCreateFunc->original = configuration->getCollisionAlgorithmCreateFunc(mesh, soft);
        next->registerCollisionCreateFunc(soft, mesh, m_createFunc.get());
        next->registerCollisionCreateFunc(mesh, soft, m_swappedCreateFunc.get());
    }
}
