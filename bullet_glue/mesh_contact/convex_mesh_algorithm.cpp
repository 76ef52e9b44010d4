// The collision algorithm of a convex shape and a qcMeshShape: Bullet's own, without slanted points at inner edges. It
// also notes where bodies start the step.
#include "mesh_contact/convex_mesh_algorithm.h"

#include "common/shape_triangles.h"
#include "mesh_contact/inner_edges.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

qcConvexMeshAlgorithm::qcConvexMeshAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch,
                                             btCollisionAlgorithm* contact)
    : btCollisionAlgorithm(info), m_batch(batch), m_contact(contact)
{
}

qcConvexMeshAlgorithm::~qcConvexMeshAlgorithm()
{
    m_contact->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(m_contact);
}

void qcConvexMeshAlgorithm::processCollision(const btCollisionObjectWrapper* body0,
                                             const btCollisionObjectWrapper* body1,
                                             const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    m_batch->MarkStarts(body0->getCollisionObject(), body1->getCollisionObject(), &m_mark);
    const btCollisionObjectWrapper* body = qcAsMeshShape(body0->getCollisionShape()) != nullptr ? body0 : body1;
    const qcMeshShape* mesh = qcAsMeshShape(body->getCollisionShape());
    if (mesh == nullptr)
    {
        // The program's own shape of the same kind.
        m_contact->processCollision(body0, body1, dispatchInfo, result);
        return;
    }
    const btVector3& center = (body == body0 ? body1 : body0)->getWorldTransform().getOrigin();
    qcInnerEdgeFilter filtered(*mesh, body->getWorldTransform(), center, result);
    m_contact->processCollision(body0, body1, dispatchInfo, &filtered);
}

btScalar qcConvexMeshAlgorithm::calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
                                                      const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    return m_contact->calculateTimeOfImpact(body0, body1, dispatchInfo, result);
}

void qcConvexMeshAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
    m_contact->getAllContactManifolds(manifolds);
}

btCollisionAlgorithm* qcConvexMeshCreate::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                   const btCollisionObjectWrapper* body0,
                                                                   const btCollisionObjectWrapper* body1)
{
    btCollisionAlgorithm* made = contact->CreateCollisionAlgorithm(info, body0, body1);
    void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(qcConvexMeshAlgorithm));
    return new (place) qcConvexMeshAlgorithm(info, batch, made);
}
