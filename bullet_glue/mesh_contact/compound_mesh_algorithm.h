// The collision algorithm of a compound and another shape, of which one holds meshes: Bullet's own, but that it also
// takes children which overlap the other shape where a kinematic body of the two starts the step.
#ifndef QC_GLUE_MESH_CONTACT_COMPOUND_MESH_ALGORITHM_H
#define QC_GLUE_MESH_CONTACT_COMPOUND_MESH_ALGORITHM_H

#include <BulletCollision/CollisionDispatch/btCompoundCollisionAlgorithm.h>

class qcCompoundMeshAlgorithm : public btCompoundCollisionAlgorithm
{
  public:
    using btCompoundCollisionAlgorithm::btCompoundCollisionAlgorithm;

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override;

  private:
    void RefreshManifolds(btManifoldResult* result);
    void ProcessChild(const btCollisionObjectWrapper& compound, const btCollisionObjectWrapper& other, int child,
                      const btDispatcherInfo& dispatchInfo, btManifoldResult* result);
    void RemoveChild(int child);
};

/// Makes these algorithms for kinematic bodies where one of the two objects holds meshes, those of another function for
/// others, for compounds of many children and where gCompoundCompoundChildShapePairCallback chooses among them.
struct qcCompoundMeshCreate : btCollisionAlgorithmCreateFunc
{
    explicit qcCompoundMeshCreate(btCollisionAlgorithmCreateFunc* contactFunction) : contact(contactFunction)
    {
    }
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override;

    btCollisionAlgorithmCreateFunc* contact;
};

/// For queries: Bullet's algorithms with those of queries for children that hold meshes. At the distance 0 Bullet takes
/// those of steps, which count as a part of one.
struct qcCompoundQueryCreate : btCollisionAlgorithmCreateFunc
{
    explicit qcCompoundQueryCreate(btCollisionAlgorithmCreateFunc* queryFunction) : query(queryFunction)
    {
    }
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* body0,
                                                   const btCollisionObjectWrapper* body1) override;

    btCollisionAlgorithmCreateFunc* query;
};

#endif
