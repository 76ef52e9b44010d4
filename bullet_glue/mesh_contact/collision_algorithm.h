// The collision algorithms of a pair with a mesh: from contact points to Bullet's manifolds.
#ifndef QC_GLUE_MESH_CONTACT_COLLISION_ALGORITHM_H
#define QC_GLUE_MESH_CONTACT_COLLISION_ALGORITHM_H

#include "mesh_contact/contact_batch.h"
#include "mesh_contact/contact_reduction.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

/// What all algorithms for points found at once do: group them, and keep a manifold for each group.
class qcPointsAlgorithm : public btCollisionAlgorithm
{
  public:
    /// `query`: the algorithm lives for one question (contactTest, contactPairTest): every point is reported, and
    /// nothing is read from a batch.
    qcPointsAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcMeshBatch* batch, bool query);
    ~qcPointsAlgorithm() override;

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    /// Meshes have no continuous collision detection: 1.
    btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
                                   const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

  protected:
    /// Points from body 1 towards body 0: all whose shells are no further apart than `reach`, or than a step brings
    /// them together.
    virtual void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                            btScalar reach, btScalar timeStep, std::vector<qcMeshPoint>* points) = 0;
    /// What the shells take of a distance.
    virtual btScalar MarginOf(const btCollisionShape* shape) const = 0;

    qcMeshBatch* m_batch;
    bool m_query;

  private:
    static constexpr int s_groups = 4;

    btPersistentManifold* Manifold(int i, const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1);
    int Successor(const qcPointGroup& group, const btTransform& bodyA, const bool used[s_groups]) const;
    void Clear(const bool used[s_groups]);
    void ReportAll(const std::vector<qcMeshPoint>& points, btScalar reach, const btCollisionObjectWrapper& body0,
                   const btCollisionObjectWrapper& body1, btManifoldResult* result);

    bool m_shared; ///< the manifold is that of a parent: one, not ours to release
    btPersistentManifold* m_manifolds[s_groups] = {};
};

/// Two meshes.
class qcMeshMeshAlgorithm : public qcPointsAlgorithm
{
  public:
    using qcPointsAlgorithm::qcPointsAlgorithm;

  protected:
    void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, btScalar reach,
                    btScalar timeStep, std::vector<qcMeshPoint>* points) override;
    btScalar MarginOf(const btCollisionShape* shape) const override;

  private:
    unsigned m_check = 0; ///< of the batch, when this pair last asked
};

/// A qcMeshShape and a btStaticPlaneShape, in either order: the mesh's vertices.
class qcMeshPlaneAlgorithm : public qcPointsAlgorithm
{
  public:
    using qcPointsAlgorithm::qcPointsAlgorithm;

  protected:
    void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, btScalar reach,
                    btScalar timeStep, std::vector<qcMeshPoint>* points) override;
    btScalar MarginOf(const btCollisionShape* shape) const override;
};

#endif
