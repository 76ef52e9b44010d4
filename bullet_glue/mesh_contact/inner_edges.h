// Contact points of convex shapes at edges and vertices inside of a qcMeshShape.
//
// Bullet tests each triangle as if it were alone. One beside the contact has a point at its edge, with a slanted
// normal, and what slides over the mesh trips on it. Such a point is no local minimum of distance: Johnson, Cohen: A
// Framework for Efficient Minimum Distance Computations, 1998.
#ifndef QC_GLUE_MESH_CONTACT_INNER_EDGES_H
#define QC_GLUE_MESH_CONTACT_INNER_EDGES_H

#include "quickcullide/bullet_mesh.h"

#include <BulletCollision/CollisionDispatch/btManifoldResult.h>

/// Passes the points of a convex shape and a mesh on to Bullet's result, except those at inner edges from which the
/// mesh leads nearer to the convex shape: points with a gap are left out, since another triangle has a nearer point;
/// where the shape has sunk in by no more than the contact breaking threshold, they get that triangle's normal,
/// unless they have that of a face of the shape, which lies on a ridge.
class qcInnerEdgeFilter : public btManifoldResult
{
  public:
    /// Which points are passed on: all, those where kinematic bodies of the pair go away from the other body, or the
    /// others.
    enum class Points
    {
        all,
        receding,
        notReceding
    };

    /// `mesh`: of a qcMeshShape. All are needed as long as the filter.
    qcInnerEdgeFilter(const btCollisionObjectWrapper& mesh, const btCollisionObjectWrapper& convex, Points points,
                      btManifoldResult* result);
    /// Hands over the manifold that Bullet's algorithm has filled.
    ~qcInnerEdgeFilter() override;
    qcInnerEdgeFilter(const qcInnerEdgeFilter&) = delete;
    qcInnerEdgeFilter& operator=(const qcInnerEdgeFilter&) = delete;

    void setShapeIdentifiersA(int part, int index) override;
    void setShapeIdentifiersB(int part, int index) override;
    /// `normal`: from the mesh to the convex shape, whichever of the two is body 0; `point`: on the mesh.
    void addContactPoint(const btVector3& normal, const btVector3& point, btScalar distance) override;

  private:
    bool IsPassed(const btVector3& normal, const btVector3& point) const;
    btVector3 NearerNormal(const btVector3 corners[3], const btVector3& point, const btVector3& outward,
                           btScalar size) const;
    bool IsFlatUnder(const btVector3& normal, const btVector3& point, btScalar size) const;

    const qcMeshShape& m_mesh;
    const btTransform& m_place; ///< of the mesh
    const btCollisionObjectWrapper &m_meshBody, &m_convexBody;
    const btVector3 m_center; ///< in the frame of the mesh
    const Points m_points;
    btManifoldResult* m_result;
    int m_triangle = -1; ///< that Bullet's algorithm is at
};

#endif
