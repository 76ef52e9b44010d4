// Triangle meshes of the scenes of `qc-bench through`.
#ifndef QC_DEMOS_BENCH_THROUGH_SHAPES_H
#define QC_DEMOS_BENCH_THROUGH_SHAPES_H

#include "quickcullide/bullet.h"

#include <BulletCollision/CollisionShapes/btTriangleIndexVertexArray.h>

#include <memory>
#include <vector>

struct qcTriangles
{
    std::vector<btScalar> positions; ///< three a vertex
    std::vector<uint32_t> indices;   ///< three a triangle

    uint32_t Add(const btVector3& p);
    void Add(uint32_t a, uint32_t b, uint32_t c);
    std::unique_ptr<qcMeshShape> MakeShape() const;
    /// For Bullet's own shapes; refers to these triangles.
    std::unique_ptr<btTriangleIndexVertexArray> MakeArray() const;
};

/// A horizontal square, seen from above; `waves`: height of bumps; `cells` along an edge, of two triangles each.
qcTriangles qcMakeFloor(btScalar half, int cells, btScalar waves = 0);
qcTriangles qcMakeBox(const btVector3& half);
/// Around the z axis; `sides` around it, with caps.
qcTriangles qcMakeCylinder(btScalar radius, btScalar halfLength, int sides);
qcTriangles qcMakeSphere(btScalar radius, int around, int across);
/// Around the z axis.
qcTriangles qcMakeTorus(btScalar radius, btScalar tube, int around, int across);
/// Small regular tetrahedra in a horizontal grid of `side` by `side`.
qcTriangles qcMakeTetrahedra(btScalar edge, int side, btScalar spacing);
/// An open box without thickness, its floor at y = 0; `cells` along each edge.
qcTriangles qcMakeBin(btScalar half, btScalar height, int cells);
/// The Stanford bunny, about 1 high, its centre of mass at the origin, with about this many triangles; a torus where
/// the model is missing, with a message on standard error once.
const qcTriangles& qcMakeBunny(uint32_t triangleCount);

#endif
