// The surface of a convex shape as triangles: exact for boxes and polyhedra, outside of curved surfaces by a bounded
// error.
#ifndef QC_GLUE_SOFT_BODY_SCENE_CONVEX_TRIANGLES_H
#define QC_GLUE_SOFT_BODY_SCENE_CONVEX_TRIANGLES_H

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <cstdint>
#include <vector>

/// A closed surface; triangles are counter-clockwise seen from outside.
struct qcConvexTriangles
{
    std::vector<btVector3> points;
    std::vector<uint32_t> indices;
    /// Distance at which soft bodies are kept from the triangles. Bullet's margin where that lies outside of the shape
    /// proper (polyhedra, cones), otherwise up to 1 cm and an eighth of the smallest half extent.
    btScalar margin = 0;
};

/// Contains the shape. Curved surfaces lie inside of it by at most half the margin or, if the count of triangles is at
/// its limit, by at most a 400th (sphere, capsule, cylinder, cone) or about a 50th (others) of the size. Same shape,
/// same triangles. At most 4096 triangles, but for hulls of many vertices. False: the shape is empty or not finite.
bool qcMakeConvexTriangles(const btConvexShape* shape, qcConvexTriangles* triangles);

#endif
