// The triangles of Bullet's concave shapes, and numbers that tell whether a shape has changed.
#ifndef QC_GLUE_COMMON_SHAPE_TRIANGLES_H
#define QC_GLUE_COMMON_SHAPE_TRIANGLES_H

#include "quickcullide/bullet_mesh.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <vector>

/// A triangle of a shape, in Bullet's numbering.
struct qcTriangleSource
{
    int part, index;
};

/// The source of a triangle. `sources`: by triangle; none: they are those of one part, in order.
inline qcTriangleSource qcSourceOf(const std::vector<qcTriangleSource>& sources, uint32_t triangle)
{
    return sources.empty() ? qcTriangleSource{0, int(triangle)} : sources[triangle];
}

/// False if neither the shape nor a child of it can be a mesh. A cheap test that excludes most objects of a world.
inline bool qcMayHoldMeshes(const btCollisionShape* shape)
{
    return shape->isConcave() || shape->isCompound();
}

/// True if the shape consists of triangles. Planes and compounds don't.
bool qcIsMesh(const btCollisionShape* shape);

/// The shape as a qcMeshShape; null if it is none.
const qcMeshShape* qcAsMeshShape(const btCollisionShape* shape);
/// True for a mesh of GImpact, false for a compound of GImpact.
bool qcIsGImpactMesh(const btCollisionShape* shape);

/// A number that changes with the mesh. For Bullet's own shapes it depends on scaling and box only: their triangles are
/// not read.
uint64_t qcMeshRevision(const btCollisionShape* shape);
/// Likewise for a convex shape: a number of its kind, its box, some points on it and all its vertices. O(vertices).
uint64_t qcConvexRevision(const btConvexShape* shape);
/// A hash, and a number or vector behind what it has been made of. 0 and -0 are the same.
uint64_t qcMixScalar(uint64_t hash, btScalar value);
uint64_t qcMixVector(uint64_t hash, const btVector3& vector);

/// The number of triangles of a shape for which qcIsMesh is true. O(1) for the usual meshes, O(triangles) for others.
size_t qcCountTriangles(const btCollisionShape* shape);

/// The triangles of a shape, in its frame. Refers to the shape: valid while that stays as it is.
class qcMeshTriangles
{
  public:
    /// `box`: see qcMeshDef.
    qcMeshTriangles(const btCollisionShape* shape, const btVector3* box);
    qcMeshTriangles(const qcMeshTriangles&) = delete;
    qcMeshTriangles& operator=(const qcMeshTriangles&) = delete;

    const btVector3* points;
    uint32_t pointCount;
    const uint32_t* indices; ///< three a triangle
    uint32_t count;          ///< triangles
    /// One for each triangle; empty for a qcMeshShape, whose triangles keep their numbers.
    std::vector<qcTriangleSource> sources;

  private:
    void Reserve(size_t triangleCount);

    std::vector<btVector3> m_points;
    std::vector<uint32_t> m_indices;
};

/// A rigid mesh in world space as a body of a scene, without self-collision. Refers to the arrays.
qcBodyDef qcMeshBodyDef(const btVector3* points, uint32_t pointCount, const uint32_t* indices, uint32_t triangleCount,
                        const btTransform& transform, qcActivity activity);

/// A mesh to add to a scene.
struct qcMeshDef
{
    const btCollisionShape* shape;
    btTransform transform;
    qcActivity activity = qc_activityMoving;
    uint32_t owner = 0; ///< see qcBodyDef
    /// Lower and upper corner of a box in the shape's frame, or null. Triangles of Bullet's own static shapes that
    /// don't overlap it may be left out.
    const btVector3* box = nullptr;
};

/// Adds the triangles of a shape to a scene. `sources` receives qcMeshTriangles::sources.
qcStatus qcAddMesh(qcScene* scene, const qcMeshDef& mesh, qcBodyId* id, std::vector<qcTriangleSource>* sources);

qcTransform qcTransformOf(const btTransform& transform);

/// Makes qcLastMessage name the first position of a body, or number of its transform, that is not finite: a scene of
/// its own refuses the body. True: they all are finite, and there is no message.
bool qcExplainNotFinite(const qcBodyDef& def);
/// Likewise for an object's transform, otherwise its velocity.
void qcExplainNotFinite(const btCollisionObject& object);

/// The vector, rounded to Bullet's precision.
inline btVector3 qcVectorOf(const double v[3])
{
    return btVector3(btScalar(v[0]), btScalar(v[1]), btScalar(v[2]));
}

#endif
