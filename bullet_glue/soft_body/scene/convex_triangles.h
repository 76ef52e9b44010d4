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

/// The triangles contain the shape. Flat faces are exact. Curved ones are approximated from outside to half the margin
/// or, at the limit of triangles, to a 400th of the radius (sphere, capsule, cylinder, cone) or a 100th of the half
/// extent (others). A flat hull is thickened by a 50th of it. Same shape, same triangles; at most 4096, but for hulls
/// of more vertices. False: the shape is empty or not finite.
bool qcMakeConvexTriangles(const btConvexShape* shape, qcConvexTriangles* triangles);

#endif
