// How deep Bullet's contact has let convex shapes sink into meshes.
#ifndef QC_GLUE_MESH_CONTACT_CONTACT_DEPTHS_H
#define QC_GLUE_MESH_CONTACT_CONTACT_DEPTHS_H

#include <LinearMath/btScalar.h>

#include <functional>
#include <unordered_map>

class btCollisionObject;
class btDispatcher;
class btPersistentManifold;

/// Depths are those of Bullet's points: margins included, where contact of the step was found. They are about right.
class qcContactDepths
{
  public:
    /// Reads all manifolds of awake objects with one that has meshes.
    void Read(btDispatcher* dispatcher, const std::function<bool(const btCollisionObject*)>& hasMeshes);
    /// The largest depth of an object in another one that has meshes; 0 if it is small.
    btScalar DepthOf(const btCollisionObject* object) const;

  private:
    void Add(const btCollisionObject* object, btScalar depth);

    std::unordered_map<const btCollisionObject*, btScalar> m_depths;
};

#endif
