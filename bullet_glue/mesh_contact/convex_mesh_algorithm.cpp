// The collision algorithm of a convex shape and a qcMeshShape: Bullet's own, without slanted points at inner edges. It
// also notes where bodies start the step.
#include "mesh_contact/convex_mesh_algorithm.h"

#include "common/shape_triangles.h"
#include "mesh_contact/inner_edges.h"
#include "mesh_contact/rigid_motion.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

namespace
{
/// A mesh with a larger margin: Bullet's algorithm looks for triangles within the margin.
class GrownMesh : public btConcaveShape
{
  public:
    GrownMesh(const qcMeshShape& mesh, btScalar growth) : m_mesh(mesh)
    {
        m_shapeType = mesh.getShapeType();
        m_collisionMargin = mesh.getMargin() + growth;
    }

    void processAllTriangles(btTriangleCallback* callback, const btVector3& lower,
                             const btVector3& upper) const override
    {
        m_mesh.processAllTriangles(callback, lower, upper);
    }
    void getAabb(const btTransform& transform, btVector3& lower, btVector3& upper) const override
    {
        m_mesh.getAabb(transform, lower, upper);
    }
    void setLocalScaling(const btVector3& /*scaling*/) override
    {
    }
    const btVector3& getLocalScaling() const override
    {
        return m_mesh.getLocalScaling();
    }
    void calculateLocalInertia(btScalar mass, btVector3& inertia) const override
    {
        m_mesh.calculateLocalInertia(mass, inertia);
    }
    const char* getName() const override
    {
        return m_mesh.getName();
    }

  private:
    const qcMeshShape& m_mesh;
};

btCollisionObjectWrapper WithShape(const btCollisionObjectWrapper& body, const btCollisionShape& shape)
{
    return {body.m_parent, &shape, body.getCollisionObject(), body.getWorldTransform(), body.m_partId, body.m_index};
}
} // namespace

qcConvexMeshAlgorithm::qcConvexMeshAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcMeshBatch* batch,
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
    const bool isMeshFirst = body == body0;
    const btCollisionObjectWrapper& convexBody = isMeshFirst ? *body1 : *body0;
    const btScalar timeStep = dispatchInfo.m_timeStep;
    const btScalar growth =
        qcMaxRecession(convexBody.getCollisionObject(), timeStep, qcMaxLead * gContactBreakingThreshold);
    qcInnerEdgeFilter filtered(*mesh, growth, *body, convexBody, timeStep, result);
    if (growth <= 0)
    {
        m_contact->processCollision(body0, body1, dispatchInfo, &filtered);
        return;
    }
    const GrownMesh grown(*mesh, growth);
    const btCollisionObjectWrapper grownBody = WithShape(*body, grown);
    m_contact->processCollision(isMeshFirst ? &grownBody : body0, isMeshFirst ? body1 : &grownBody, dispatchInfo,
                                &filtered);
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
