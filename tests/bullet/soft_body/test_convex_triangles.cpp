// Triangles of convex shapes: closed, outside of the shape, and near it.
#include "soft_body/scene/convex_triangles.h"

#include "bullet/soft_body/shape_models.h"

#include <BulletCollision/CollisionShapes/btConvexPointCloudShape.h>
#include <BulletCollision/CollisionShapes/btTetrahedronShape.h>
#include <BulletCollision/CollisionShapes/btTriangleShape.h>
#include <BulletCollision/CollisionShapes/btUniformScalingShape.h>

#include <random>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
using Shapes = std::vector<std::unique_ptr<btConvexShape>>;

void AddHulls(Shapes* shapes)
{
    std::minstd_rand random(3);
    std::uniform_real_distribution<double> part(-1, 1);
    for (int points : {4, 8, 30, 300})
    {
        auto* hull = new btConvexHullShape;
        for (int i = 0; i < points; i++)
            hull->addPoint(btVector3(btScalar(part(random)), btScalar(part(random)), btScalar(0.3 * part(random))));
        shapes->emplace_back(hull);
    }
    // A square, a line of points, a hull without margin.
    auto *flat = new btConvexHullShape, *line = new btConvexHullShape, *bare = new btConvexHullShape;
    for (int i = 0; i < 8; i++)
    {
        const btVector3 corner(btScalar(i & 1), btScalar(i >> 1 & 1), btScalar(i >> 2));
        flat->addPoint(btVector3(corner.x(), corner.y(), 0));
        line->addPoint(btVector3(btScalar(i), 0, 0));
        bare->addPoint(corner);
    }
    bare->setMargin(0);
    flat->setMargin(0);
    shapes->emplace_back(flat);
    shapes->emplace_back(line);
    shapes->emplace_back(bare);
}

Shapes AllShapes()
{
    Shapes shapes;
    for (double size : {0.001, 0.01, 0.5, 100.0})
    {
        const btScalar r = btScalar(size);
        shapes.emplace_back(new btSphereShape(r));
        shapes.emplace_back(new btBoxShape(btVector3(r, 2 * r, r / 2)));
        shapes.emplace_back(new btCapsuleShape(r, 3 * r));
        shapes.emplace_back(new btCapsuleShapeX(r, 300 * r));
        shapes.emplace_back(new btCylinderShapeZ(btVector3(r, r, 5 * r)));
        shapes.emplace_back(new btCylinderShapeX(btVector3(r / 100, r, r)));
        shapes.emplace_back(new btConeShapeX(r, 3 * r));
        shapes.emplace_back(new btConeShape(3 * r, r));
        const btVector3 centers[3] = {btVector3(0, 0, 0), btVector3(r, 0, 0), btVector3(0, r, r)};
        const btScalar radii[3] = {r, r / 2, r / 4};
        shapes.emplace_back(new btMultiSphereShape(centers, radii, 3));
    }
    AddHulls(&shapes);
    shapes.emplace_back(new btTriangleShape(btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0)));
    shapes.emplace_back(
        new btBU_Simplex1to4(btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 1, 0), btVector3(0, 0, 1)));
    for (const auto& shape : shapes)
        shape->setLocalScaling(shape->getLocalScaling());
    auto* scaled = new btCylinderShape(btVector3(1, 2, 1));
    scaled->setLocalScaling(btVector3(btScalar(0.5), 3, btScalar(0.5)));
    shapes.emplace_back(scaled);
    return shapes;
}

/// Each edge of a closed surface is used once in each direction.
void CheckClosed(const qcConvexTriangles& triangles)
{
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (size_t i = 0; i < triangles.indices.size(); i++)
        edges[{triangles.indices[i], triangles.indices[i % 3 == 2 ? i - 2 : i + 1]}]++;
    for (const auto& edge : edges)
    {
        ck_assert_int_eq(edge.second, 1);
        ck_assert_uint_eq(edges.count({edge.first.second, edge.first.first}), 1);
    }
}

/// The point of the shape, with its margin only if that is a part of it, that is furthest along the direction.
btVector3 Furthest(const btConvexShape& shape, const btVector3& direction)
{
    int type = shape.getShapeType();
    if (type == CONE_SHAPE_PROXYTYPE || (shape.isPolyhedral() && type != BOX_SHAPE_PROXYTYPE))
        return shape.localGetSupportingVertexWithoutMargin(direction);
    return shape.localGetSupportingVertex(direction);
}

void CheckAround(const btConvexShape& shape, const qcConvexTriangles& triangles, btScalar size)
{
    for (size_t i = 0; i < triangles.indices.size(); i += 3)
    {
        const btVector3 &a = triangles.points[triangles.indices[i]], &b = triangles.points[triangles.indices[i + 1]],
                        &c = triangles.points[triangles.indices[i + 2]];
        btVector3 normal = (b - a).cross(c - a);
        // Thin triangles have no reliable direction.
        btScalar longest = std::max((b - a).length(), std::max((c - a).length(), (c - b).length()));
        if (normal.length() < btScalar(2e-3) * longest * longest)
            continue;
        normal.normalize();
        ck_assert_double_le(double(normal.dot(Furthest(shape, normal) - a)), 1e-3 * double(size) * 0.1);
    }
}

/// True if the shape without its margin has no volume, along an axis.
bool IsFlat(const btConvexShape& shape)
{
    for (int axis = 0; axis < 3; axis++)
    {
        btVector3 up(0, 0, 0);
        up[axis] = 1;
        if (Furthest(shape, up)[axis] <= Furthest(shape, -up)[axis])
            return true;
    }
    return false;
}

/// No corner is outside of the shape by more than a bound, in many directions.
void CheckNear(const btConvexShape& shape, const qcConvexTriangles& triangles, btScalar size)
{
    btScalar bound = std::max(triangles.margin * btScalar(0.51), size / 200);
    if (shape.getShapeType() == BOX_SHAPE_PROXYTYPE || (shape.isPolyhedral() && !IsFlat(shape)))
        bound = size * btScalar(1e-5);
    // Bullet rounds the rims of a cylinder by its margin.
    if (shape.getShapeType() == CYLINDER_SHAPE_PROXYTYPE)
        bound += btScalar(0.42) * shape.getMargin();
    std::minstd_rand random(9);
    std::uniform_real_distribution<double> part(-1, 1);
    for (int i = 0; i < 500; i++)
    {
        btVector3 direction(btScalar(part(random)), btScalar(part(random)), btScalar(part(random)));
        direction.normalize();
        btScalar level = direction.dot(Furthest(shape, direction)), highest = -BT_LARGE_FLOAT;
        for (const btVector3& point : triangles.points)
            highest = std::max(highest, direction.dot(point));
        ck_assert_double_ge(double(highest), double(level) - 1e-4 * double(size));
        ck_assert_msg(highest - level <= bound, "%s, size %g, margin %g: %g", shape.getName(), double(size),
                      double(triangles.margin), double(highest - level));
    }
}
} // namespace

START_TEST(triangles_are_a_closed_surface_around_the_shape_and_near_it)
{
    for (const auto& shape : AllShapes())
    {
        qcConvexTriangles triangles, again;
        ck_assert(qcMakeConvexTriangles(shape.get(), &triangles));
        ck_assert(qcMakeConvexTriangles(shape.get(), &again));
        ck_assert(triangles.points == again.points && triangles.indices == again.indices);
        ck_assert_uint_ge(triangles.indices.size() / 3, 4);
        ck_assert_uint_le(triangles.indices.size() / 3, 4096);
        ck_assert(triangles.margin > 0);
        btVector3 lower, upper;
        shape->getAabb(btTransform::getIdentity(), lower, upper);
        btScalar size = (upper - lower)[(upper - lower).maxAxis()];
        CheckClosed(triangles);
        CheckAround(*shape, triangles, size);
        CheckNear(*shape, triangles, size);
    }
}
END_TEST

START_TEST(a_sphere_is_approximated_within_half_its_margin)
{
    for (double radius : {0.01, 0.1, 0.5, 1.0})
    {
        btSphereShape shape{btScalar(radius)};
        qcConvexTriangles triangles;
        ck_assert(qcMakeConvexTriangles(&shape, &triangles));
        for (const btVector3& point : triangles.points)
        {
            ck_assert_double_ge(double(point.length()), radius * (1 - 1e-6));
            ck_assert_double_le(double(point.length()), radius + double(triangles.margin) * 0.51);
        }
        for (size_t i = 0; i < triangles.indices.size(); i += 3)
        {
            const btVector3 &a = triangles.points[triangles.indices[i]],
                            &b = triangles.points[triangles.indices[i + 1]],
                            &c = triangles.points[triangles.indices[i + 2]];
            // The distance of the triangle's plane from the centre.
            ck_assert_double_ge(double((b - a).cross(c - a).normalized().dot(a)), radius * (1 - 1e-5));
        }
    }
}
END_TEST

START_TEST(a_shape_without_extent_or_without_an_end_has_no_triangles)
{
    btConvexHullShape point, infinite;
    point.setMargin(0);
    point.addPoint(btVector3(1, 1, 1));
    infinite.addPoint(btVector3(SIMD_INFINITY, 0, 0));
    infinite.addPoint(btVector3(0, 0, 1));
    qcConvexTriangles triangles;
    ck_assert(!qcMakeConvexTriangles(&point, &triangles));
    ck_assert(!qcMakeConvexTriangles(&infinite, &triangles));
}
END_TEST

QC_RUN_TESTS("convex_triangles", triangles_are_a_closed_surface_around_the_shape_and_near_it,
             a_sphere_is_approximated_within_half_its_margin, a_shape_without_extent_or_without_an_end_has_no_triangles)
