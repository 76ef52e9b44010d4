// Static planes under small meshes.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_FLOOR_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_FLOOR_H

#include "common/support_mesh.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <vector>

/// A static plane under a small mesh. Limits move the mesh no deeper into it than it was at the target.
struct qcSweptFloor
{
    btVector3 normal; ///< unit, upwards
    btScalar level;   ///< smallest product of a vertex with the normal

    /// Height of the mesh's lowest vertex above the level, where it has this transform.
    btScalar HeightOf(const qcSupportMesh& mesh, const btTransform& place) const;
};

/// The static planes of a world.
class qcStaticPlanes
{
  public:
    /// Reads which there are: valid until an object leaves the world.
    void Read(const btCollisionWorld& world);
    /// Appends the planes that a body with this mesh may reach at the target, and has contact with.
    void FindFloors(btCollisionWorld* world, btCollisionObject* body, const qcSupportMesh& mesh,
                    const btTransform& target, std::vector<qcSweptFloor>* floors) const;

  private:
    std::vector<btCollisionObject*> m_planes;
};

#endif
