// The collision algorithms of pairs with a mesh: from contact points to Bullet's manifolds.
#ifndef QC_GLUE_MESH_CONTACT_COLLISION_ALGORITHM_H
#define QC_GLUE_MESH_CONTACT_COLLISION_ALGORITHM_H

#include "mesh_contact/contact_batch.h"
#include "mesh_contact/points/contact_reduction.h"
#include "mesh_contact/points/margin_overlap.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

/// Groups the contact points of a pair, and keeps a manifold for each group. Derived classes find the points.
class qcPointsAlgorithm : public btCollisionAlgorithm
{
  public:
    /// `query`: the algorithm lives for one query (contactTest, contactPairTest), which reports every point and reads
    /// no batch.
    qcPointsAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch, bool query);
    ~qcPointsAlgorithm() override;

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    /// Meshes have no continuous collision detection: 1.
    btScalar calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
                                   const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;
    void getAllContactManifolds(btManifoldArray& manifolds) override;

  protected:
    /// Appends points with normals from body 1 to body 0: at least those whose distance beyond the margins is at most
    /// the contact distance and `farther`, and those that the motion of the step brings so near.
    virtual void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                            btScalar farther, btScalar timeStep, std::vector<qcMeshPoint>* points) = 0;
    /// The part of a distance between triangles that belongs to the shape's margin.
    virtual btScalar MarginOf(const btCollisionShape* shape) const = 0;
    /// True if points that are reached within the step are not reduced to four.
    virtual bool KeepsReached() const
    {
        return false;
    }

    qcContactBatch* m_batch;
    bool m_query;

  private:
    static constexpr int s_maxGroups = 4;

    btPersistentManifold* GetManifold(int i, const btCollisionObjectWrapper& body0,
                                      const btCollisionObjectWrapper& body1);
    int ChooseManifold(const qcPointGroup& group, const btTransform& bodyA, const bool used[s_maxGroups]) const;
    void ClearUnused(const bool used[s_maxGroups]);
    void MarkKnown(const btTransform& bodyA, std::vector<qcMeshPoint>* points) const;
    void ReportAll(const std::vector<qcMeshPoint>& points, btScalar contactDistance,
                   const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                   btManifoldResult* result);
    void UpdateManifolds(std::vector<qcMeshPoint>* points, btScalar contactDistance,
                         const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                         btManifoldResult* result);

    qcMarginOverlap m_overlap;
    bool m_isShared; ///< a parent algorithm owns the only manifold
    btPersistentManifold* m_manifolds[s_maxGroups] = {};
};

/// Two meshes.
class qcMeshMeshAlgorithm : public qcPointsAlgorithm
{
  public:
    using qcPointsAlgorithm::qcPointsAlgorithm;

  protected:
    void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, btScalar farther,
                    btScalar timeStep, std::vector<qcMeshPoint>* points) override;
    btScalar MarginOf(const btCollisionShape* shape) const override;

  private:
    uint64_t m_check = 0; ///< number of the batch's check at this pair's last call
};

/// A qcMeshShape and a btStaticPlaneShape, in either order. Contact points are the mesh's vertices.
class qcMeshPlaneAlgorithm : public qcPointsAlgorithm
{
  public:
    using qcPointsAlgorithm::qcPointsAlgorithm;

  protected:
    void FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1, btScalar farther,
                    btScalar timeStep, std::vector<qcMeshPoint>* points) override;
    btScalar MarginOf(const btCollisionShape* shape) const override;
    bool KeepsReached() const override
    {
        return true;
    }

  private:
    uint64_t m_mark = 0; ///< see qcContactBatch::MarkStarts
};

#endif
