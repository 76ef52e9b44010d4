// The collision algorithm of a convex shape and a qcMeshShape: Bullet's own, without slanted points at inner edges, and
// where a kinematic body goes away with it at the start of the step. It also notes where bodies start the step.
#ifndef QC_GLUE_MESH_CONTACT_CONVEX_MESH_ALGORITHM_H
#define QC_GLUE_MESH_CONTACT_CONVEX_MESH_ALGORITHM_H

#include "mesh_contact/contact_batch.h"
#include "mesh_contact/inner_edges.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btCollisionCreateFunc.h>

class qcConvexMeshAlgorithm : public btCollisionAlgorithm
{
  public:
    /// Takes over `contact`, which the dispatcher has allocated.
    qcConvexMeshAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch,
                          btCollisionAlgorithm* contact);
    ~qcConvexMeshAlgorithm() override;

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
                                   const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

  private:
    void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                    const btDispatcherInfo& dispatchInfo, qcInnerEdgeFilter::Points points, btManifoldResult* result);
    void MovePoints(const btCollisionObject* kinematic, btScalar timeStep);

    qcContactBatch* m_batch;
    btCollisionAlgorithm* m_contact;
    uint64_t m_mark = 0; ///< see qcContactBatch::MarkStarts
    /// Displacement and rotation from the end to the start of the last step, in the frame of the kinematic body.
    btVector3 m_leadLinear{0, 0, 0}, m_leadAngular{0, 0, 0};
};

/// Makes these algorithms, with contact by another function.
struct qcConvexMeshCreate : btCollisionAlgorithmCreateFunc
{
    qcConvexMeshCreate(qcContactBatch* ofWorld, btCollisionAlgorithmCreateFunc* contactFunction)
        : batch(ofWorld), contact(contactFunction)
    {
    }
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override;

    qcContactBatch* batch;
    btCollisionAlgorithmCreateFunc* contact;
};

#endif
