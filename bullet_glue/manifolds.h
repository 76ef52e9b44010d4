// Contacts of soft bodies as Bullet manifolds, for whoever listens to the dispatcher.
#ifndef QC_BULLET_GLUE_MANIFOLDS_H
#define QC_BULLET_GLUE_MANIFOLDS_H

#include "soft_body_response.h"

class btDispatcher;
class btPersistentManifold;

class qcManifolds
{
  public:
    ~qcManifolds();

    /// Gives all manifolds back. `alive`: the soft bodies that are still in the world; nobody is told of the end of
    /// contacts of others, nor with meshes, of which that is not known.
    void Release(const btAlignedObjectArray<btSoftBody*>& alive);

    /// Reports the contacts that became constraints. Distances are between surfaces of the bodies' thickness: negative
    /// where they press into each other. Bodies whose world has no dispatcher are left out.
    void Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts);

  private:
    btPersistentManifold* Next(btDispatcher* dispatcher, const btCollisionObject* a, const btCollisionObject* b);

    /// A manifold and the dispatcher that it came from.
    std::vector<std::pair<btDispatcher*, btPersistentManifold*>> m_manifolds;
};

#endif
