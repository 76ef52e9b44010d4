// Convex shapes slide over a mesh as over a plane: edges between its triangles don't trip them.
#include "bullet/mesh/mesh_world.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletCollision/CollisionShapes/btCylinderShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>

#include <cmath>

namespace
{
constexpr btScalar s_margin = btScalar(0.01), s_half = btScalar(0.25);

/// A crate whose bottom rises by 2 cm towards its edges: on a plane it stands on the middle.
std::unique_ptr<btCollisionShape> MakeBevelledCrate()
{
    auto hull = std::make_unique<btConvexHullShape>();
    const btScalar margin = btScalar(0.02), bottom = margin - s_half, edge = btScalar(0.35), middle = btScalar(0.2);
    hull->setMargin(margin);
    for (int i = 0; i < 4; i++)
    {
        const btScalar x = i % 2 == 0 ? btScalar(-1) : btScalar(1), z = i / 2 == 0 ? btScalar(-1) : btScalar(1);
        hull->addPoint(btVector3(middle * x, bottom, middle * z));
        hull->addPoint(btVector3(edge * x, bottom + btScalar(0.02), edge * z));
        hull->addPoint(btVector3(edge * x, -bottom, edge * z));
    }
    return hull;
}

/// A body without friction, on a floor of triangles of 25 cm.
struct SlidingWorld : qcMeshWorld
{
    btRigidBody* body = nullptr;

    /// `uneven`: how far the floor's vertices are off the plane at most.
    SlidingWorld(int kind, btScalar speed, btScalar uneven, bool inCompound)
    {
        qcModel model = qcFloorModel(30, 240);
        for (size_t i = 0; i < model.positions.size(); i += 3)
            model.positions[i + 1] += uneven * (btScalar(i * 7919 % 13) / 6 - 1);
        btCollisionShape* ground = Keep(model.MakeShape());
        ground->setMargin(s_margin);
        if (inCompound)
        {
            auto parent = std::make_unique<btCompoundShape>();
            parent->addChildShape(btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.3)), btVector3(1, 0, 2)),
                                  ground);
            ground = Keep(std::move(parent));
        }
        Add(ground, 0, btVector3(0, 0, 0))->setFriction(0);
        std::unique_ptr<btCollisionShape> shape;
        switch (kind)
        {
            case 0: shape = std::make_unique<btSphereShape>(s_half); break;
            case 1: shape = std::make_unique<btBoxShape>(btVector3(btScalar(0.5), s_half, btScalar(0.4))); break;
            case 2: shape = std::make_unique<btCapsuleShapeX>(s_half, btScalar(0.6)); break;
            default: shape = MakeBevelledCrate();
        }
        btTransform place(btQuaternion(btVector3(0, 1, 0), btScalar(0.2)),
                          btVector3(-speed, s_half + s_margin + uneven, btScalar(-0.3)));
        body = Add(Keep(std::move(shape)), 1, place);
        body->setFriction(0);
        body->setActivationState(DISABLE_DEACTIVATION);
        body->setLinearVelocity(btVector3(speed, 0, speed / 20));
    }
};

START_TEST(convex_shapes_slide_over_triangles_as_over_a_plane)
{
    for (btScalar speed : {btScalar(2), btScalar(8), btScalar(25)})
        for (bool inCompound : {false, true})
        {
            SlidingWorld world(_i, speed, 0, inCompound);
            const btVector3 start = world.body->getLinearVelocity();
            for (int step = 0; step < 110; step++)
            {
                world.Step();
                const btScalar height = world.body->getWorldTransform().getOrigin().y();
                ck_assert_msg(height < s_half + 2 * s_margin, "shape %d, %g m/s: at %g m", _i, double(speed),
                              double(height));
            }
            const btVector3 change = world.body->getLinearVelocity() - start;
            ck_assert_msg(change.length() < btScalar(0.03) * speed, "shape %d, %g m/s: changes by %g m/s", _i,
                          double(speed), double(change.length()));
            ck_assert_double_lt(double(world.body->getAngularVelocity().length()), 0.2 * double(speed));
        }
}
END_TEST

START_TEST(uneven_ground_takes_little_of_their_speed)
{
    const btScalar speed = 15;
    SlidingWorld world(_i, speed, btScalar(0.01), false);
    world.Step(110);
    ck_assert_double_gt(double(world.body->getLinearVelocity().length()), 0.9 * double(speed));
}
END_TEST

/// The acceleration of a box down a slope, in the second half of a second. One of box and ground is a mesh.
double SlideDown(double slope, double friction, bool isMesh)
{
    qcMeshWorld world;
    const double tilt = std::atan(slope);
    world.world.setGravity(btVector3(btScalar(10 * std::sin(tilt)), btScalar(-10 * std::cos(tilt)), 0));
    const btVector3 half(btScalar(0.5), s_half, btScalar(0.4)), large(8, 1, 8);
    btCollisionShape* ground =
        isMesh ? world.Keep(std::make_unique<btBoxShape>(large)) : world.Keep(qcFloorModel(8, 16).MakeShape());
    btCollisionShape* shape =
        isMesh ? world.Keep(qcBoxModel(half, 3).MakeShape()) : world.Keep(std::make_unique<btBoxShape>(half));
    world.Add(ground, 0, btVector3(0, isMesh ? btScalar(-1) : btScalar(0), 0))->setFriction(1);
    btRigidBody* body = world.Add(shape, 1, btVector3(0, s_half + s_margin, 0));
    body->setFriction(btScalar(friction));
    body->setActivationState(DISABLE_DEACTIVATION);
    world.Step(30);
    const btScalar middle = body->getLinearVelocity().x();
    world.Step(30);
    return 2 * double(body->getLinearVelocity().x() - middle);
}

START_TEST(boxes_slide_down_slopes_as_friction_has_it)
{
    const double friction = 0.4;
    for (bool isMesh : {false, true})
        for (double factor : {0.8, 1.3, 2.0})
        {
            const double tilt = std::atan(factor * friction);
            const double expected = std::max(0.0, 10 * (std::sin(tilt) - friction * std::cos(tilt)));
            const double found = SlideDown(factor * friction, friction, isMesh);
            // Bullet's contact has one point a step for each triangle of a mesh, and rocks it.
            const double tolerance = isMesh ? 0.25 : 0.1;
            ck_assert_msg(std::fabs(found - expected) < 0.05 + tolerance * expected,
                          "mesh %d, factor %g: %g m/s2, not %g", isMesh, factor, found, expected);
        }
}
END_TEST

/// A convex shape that is held by a ridge, a border or a step of a mesh has slanted and level normals as before.
START_TEST(outer_edges_hold_convex_shapes)
{
    qcMeshWorld world;
    btCollisionShape* table = world.Keep(qcBoxModel(btVector3(1, 1, 1), 4).MakeShape());
    world.Add(table, 0, btVector3(0, 0, 0));
    btCollisionShape* ball = world.Keep(std::make_unique<btSphereShape>(s_half));
    // Against the side of the table, above half of its height, and off its upper edge.
    btRigidBody* beside = world.Add(ball, 1, btVector3(btScalar(2.2), btScalar(0.3), 0));
    btRigidBody* over = world.Add(ball, 1, btVector3(btScalar(1.05), btScalar(1.4), 0));
    beside->setGravity(btVector3(0, 0, 0));
    beside->setLinearVelocity(btVector3(-5, 0, 0));
    world.Step(60);
    ck_assert_double_gt(double(beside->getWorldTransform().getOrigin().x()), 1.2);
    ck_assert_double_gt(double(over->getWorldTransform().getOrigin().x()), 1.1);
    ck_assert_double_lt(double(over->getWorldTransform().getOrigin().y()), 1);
}
END_TEST

/// Two rails along z whose ridges are at height 0, with flanks of this slope, a rectangle each.
qcModel RailModel(btScalar half, btScalar slope)
{
    qcModel model;
    for (btScalar x : {btScalar(-0.3), btScalar(0.3)})
        for (btScalar side : {btScalar(-1), btScalar(1)})
        {
            const btVector3 along(0, 0, 2 * half), down(side * btScalar(0.1), -slope * btScalar(0.1), 0);
            qcAddGrid(&model, btVector3(x, 0, -half), side < 0 ? down : along, side < 0 ? along : down, 1, 1);
        }
    return model;
}

/// Flat faces lie on the ridges, whatever the slope of their flanks: contact has the face's normal.
START_TEST(ridges_that_a_flat_face_slides_along_have_its_normal)
{
    const btScalar height = btScalar(0.2);
    const bool isCylinder = _i == 1;
    for (const btScalar slope : {btScalar(0.3), btScalar(1), btScalar(3)})
    {
        int loaded = 0, tilted = 0;
        btScalar drift = 0;
        for (int start = 0; start < 4; start++)
        {
            qcMeshWorld world;
            // Coordinates without roundings that agree.
            const btTransform place(btQuaternion(btVector3(1, btScalar(start), 2).normalized(), btScalar(0.7)));
            world.world.setGravity(place.getBasis() * btVector3(0, -10, 0));
            btCollisionShape* rails = world.Keep(RailModel(4, slope).MakeShape());
            rails->setMargin(s_margin);
            world.Add(rails, 0, place);
            std::unique_ptr<btCollisionShape> shape =
                std::make_unique<btBoxShape>(btVector3(s_half * 2, height, s_half));
            if (isCylinder)
                shape = std::make_unique<btCylinderShape>(btVector3(s_half * 2, height, s_half * 2));
            btRigidBody* body = world.Add(world.Keep(std::move(shape)), 5,
                                          place * btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(start) / 10),
                                                              btVector3(0, height + btScalar(0.015), -2)));
            body->setFriction(btScalar(0.02));
            body->setActivationState(DISABLE_DEACTIVATION);
            body->setLinearVelocity(place.getBasis() * btVector3(0, 0, 1));
            for (int i = 0; i < 120; i++)
            {
                world.Step();
                const btVector3 up = body->getWorldTransform().getBasis().getColumn(1);
                for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
                {
                    const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(m);
                    for (int k = 0; k < manifold->getNumContacts(); k++)
                    {
                        const btManifoldPoint& point = manifold->getContactPoint(k);
                        loaded += point.getAppliedImpulse() > 0;
                        tilted +=
                            point.getAppliedImpulse() > 0 && btFabs(up.dot(point.m_normalWorldOnB)) < btScalar(0.995);
                    }
                }
            }
            drift = std::max(drift, btFabs((place.inverse() * body->getWorldTransform().getOrigin()).x()));
        }
        ck_assert_int_gt(loaded, 500);
        ck_assert_msg(tilted <= loaded / 100, "slope %g: %d of %d tilted", double(slope), tilted, loaded);
        ck_assert_msg(drift < btScalar(0.1), "slope %g: off by %g m", double(slope), double(drift));
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("inner_edges");
    tcase_add_loop_test(tests, convex_shapes_slide_over_triangles_as_over_a_plane, 0, 4);
    tcase_add_loop_test(tests, uneven_ground_takes_little_of_their_speed, 0, 3);
    tcase_add_test(tests, boxes_slide_down_slopes_as_friction_has_it);
    tcase_add_test(tests, outer_edges_hold_convex_shapes);
    tcase_add_loop_test(tests, ridges_that_a_flat_face_slides_along_have_its_normal, 0, 2);
    return qcRunCase("inner_edges", tests);
}
