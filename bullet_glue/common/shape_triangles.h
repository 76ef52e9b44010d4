// The triangles of Bullet's concave shapes.
#ifndef QC_GLUE_COMMON_SHAPE_TRIANGLES_H
#define QC_GLUE_COMMON_SHAPE_TRIANGLES_H

#include "quickcullide/bullet_mesh.h"

#include <vector>

/// Which triangle of a shape this is, as Bullet counts them.
struct qcTriangleSource
{
    int part, index;
};

/// False for roots that hold no mesh, so that most objects of a world cost no more than this.
inline bool qcMayHoldMeshes(const btCollisionShape* shape)
{
    return shape->isConcave() || shape->isCompound();
}

/// Does the shape consist of triangles? Planes, which have none of their own, and compounds do not.
bool qcIsMesh(const btCollisionShape* shape);

/// The shape as ours, or null.
const qcMeshShape* qcAsMeshShape(const btCollisionShape* shape);
bool qcIsGImpactMesh(const btCollisionShape* shape);

/// Differs between two meshes that are not the same, as far as can be told without reading them.
uint64_t qcMeshRevision(const btCollisionShape* shape);

/// The triangles of a shape, in its frame. Refers to the shape: valid while that stays as it is.
class qcMeshTriangles
{
  public:
    /// `box`: see qcAddMesh.
    qcMeshTriangles(const btCollisionShape* shape, const btVector3* box);
    qcMeshTriangles(const qcMeshTriangles&) = delete;
    qcMeshTriangles& operator=(const qcMeshTriangles&) = delete;

    const btVector3* points;
    uint32_t pointCount;
    const uint32_t* indices; ///< three a triangle
    uint32_t count;          ///< triangles
    /// What each triangle is; empty for a qcMeshShape, whose triangles keep their numbers.
    std::vector<qcTriangleSource> sources;

  private:
    std::vector<btVector3> m_points;
    std::vector<uint32_t> m_indices;
};

/// A rigid mesh in world space as a body of a scene, without self-collision. Refers to the arrays.
qcBodyDef qcMeshBodyDef(const btVector3* points, uint32_t pointCount, const uint32_t* indices, uint32_t triangleCount,
                        const btTransform& transform, qcActivity activity);

/// Adds the shape's triangles to a scene. `owner`: of the body, see qcBodyDef. `box` (may be null): those of Bullet's
/// own static shapes that do not meet it, in the shape's frame, may be left out. `sources` receives those of the
/// triangles.
qcStatus qcAddMesh(qcScene* scene, const btCollisionShape* shape, const btTransform& transform, qcActivity activity,
                   uint32_t owner, const btVector3* box, qcBodyId* id, std::vector<qcTriangleSource>* sources);

qcTransform qcTransformOf(const btTransform& transform);

/// Rounded to Bullet's precision.
inline btVector3 qcVectorOf(const double v[3])
{
    return btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2]));
}

#endif
