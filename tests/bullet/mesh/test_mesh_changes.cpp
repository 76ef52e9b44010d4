// Shapes that change or are replaced while their bodies lie on each other: contact is that of the present mesh.
#include "bullet/mesh/mesh_world.h"

#include <functional>
#include <limits>
#include <new>

namespace
{
double CubeHeight(const btRigidBody* body)
{
    return double(body->getWorldTransform().getOrigin().y());
}

/// A cube whose margin lies on the margin of the floor, and that never sleeps.
btRigidBody* AddCube(qcMeshWorld& world, btCollisionShape* shape, btScalar floorMargin)
{
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, btScalar(0.5) + shape->getMargin() + floorMargin, 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    world.Step(30);
    return cube;
}

START_TEST(a_resting_cube_that_is_scaled_up_rises)
{
    qcMeshWorld world;
    btScalar margin = qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = AddCube(world, shape, margin);
    double before = CubeHeight(cube);
    shape->setLocalScaling(btVector3(1, btScalar(1.04), 1));
    world.Step(120);
    ck_assert_double_eq_tol(CubeHeight(cube), before + 0.02, 1e-3);
}
END_TEST

START_TEST(a_cube_scaled_into_another_has_contact_in_that_step)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    btRigidBody* cubes[4];
    // Two pairs side by side, without contact with each other.
    for (int i = 0; i < 4; i++)
    {
        btScalar x = btScalar(1.025) * btScalar(i) + (i < 2 ? btScalar(0) : btScalar(0.5));
        cubes[i] = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(x, 0, 0));
        cubes[i]->setActivationState(DISABLE_DEACTIVATION);
    }
    world.Step(2);
    // Without the outer ones the only pair is a new one, of cubes that have not moved.
    for (int i = 0; i < 4; i += 3)
        cubes[i]->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(10 + 10 * i), 0)));
    cubes[1]->getCollisionShape()->setLocalScaling(btVector3(btScalar(2.02), 1, 1));
    world.Step();
    ck_assert_int_gt(qcContactsOf(world.dispatcher).points, 0);
}
END_TEST

START_TEST(a_new_mesh_at_an_old_address_is_read_anew)
{
    qcMeshWorld world;
    btScalar margin = qcAddFloor(world, qc_floorOurs);
    alignas(16) unsigned char room[sizeof(qcMeshShape)];
    auto make = [&](btScalar half)
    {
        qcModel model = qcBoxModel(btVector3(half, half, half), 2);
        qcPositionType type = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;
        auto* shape = new (room) qcMeshShape(model.positions.data(), type, 0, uint32_t(model.positions.size() / 3),
                                             model.indices.data(), model.TriangleCount());
        shape->setMargin(btScalar(0.01));
        return shape;
    };
    qcMeshShape* shape = make(btScalar(0.5));
    btRigidBody* cube = AddCube(world, shape, margin);
    double before = CubeHeight(cube);
    shape->~qcMeshShape();
    shape = make(btScalar(0.52));
    cube->setCollisionShape(shape);
    world.Step(120);
    ck_assert_double_eq_tol(CubeHeight(cube), before + 0.02, 1e-3);
    world.world.removeRigidBody(cube);
    world.bodies.pop_back();
    shape->~qcMeshShape();
}
END_TEST

START_TEST(a_terrain_at_the_address_of_a_deleted_one_is_read_anew)
{
    qcMeshWorld world;
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, 0, 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    alignas(16) unsigned char room[sizeof(btHeightfieldTerrainShape)];
    // All tiles have the same box. In every other round a step is made without one.
    for (int round = 0; round < 8; round++)
    {
        const std::vector<float> heights(81, round % 2 == 0 ? 0.0f : 0.8f);
        auto* terrain = new (room) btHeightfieldTerrainShape(9, 9, heights.data(), btScalar(-1), btScalar(1), 1, false);
        btRigidBody* tile = world.Add(terrain, 0, btVector3(0, 0, 0));
        const double rest = double(heights[0]) + 0.5 + double(shape->getMargin() + terrain->getMargin());
        cube->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(rest + 0.1), 0)));
        cube->setLinearVelocity(btVector3(0, 0, 0));
        cube->setAngularVelocity(btVector3(0, 0, 0));
        world.Step(60);
        ck_assert_double_eq_tol(CubeHeight(cube), rest, 0.005);
        world.world.removeRigidBody(tile);
        world.bodies.pop_back();
        terrain->~btHeightfieldTerrainShape();
        if (round % 4 >= 2)
            world.Step();
    }
}
END_TEST

/// Floors of Bullet's shapes whose triangles the application changes. A spike in the model's corner keeps the box.
struct RisingFloor
{
    qcMeshWorld world;
    qcModel* model = nullptr;
    float heights[81] = {};
    btCollisionShape* shape = nullptr;
    std::function<void()> tellBullet = []() {};

    explicit RisingFloor(qcFloor kind)
    {
        world.contact.takeOverGImpact();
        if (kind == qc_floorTerrain)
            shape = world.Keep(std::unique_ptr<btCollisionShape>(
                new btHeightfieldTerrainShape(9, 9, heights, btScalar(-1), btScalar(1), 1, false)));
        else
        {
            qcModel flat = qcFloorModel(4, 8);
            flat.positions[1] = 1;
            shape = kind == qc_floorStatic ? world.StaticMesh(flat) : world.GImpact(flat, btScalar(0.01));
            model = world.models.back().get();
        }
        if (kind == qc_floorStatic)
            tellBullet = [this]()
            {
                const btVector3 far(10, 10, 10);
                static_cast<btBvhTriangleMeshShape*>(shape)->refitTree(-far, far);
            };
        if (kind == qc_floorGImpact)
            tellBullet = [this]()
            {
                static_cast<btGImpactMeshShape*>(shape)->postUpdate();
                static_cast<btGImpactMeshShape*>(shape)->updateBound();
            };
        world.Add(shape, 0, btVector3(0, 0, 0));
    }

    void Rise(btScalar height)
    {
        for (size_t i = 4; model != nullptr && i < model->positions.size(); i += 3)
            model->positions[i] = height;
        std::fill_n(heights, 81, float(height));
        tellBullet();
        world.contact.updateShape(shape);
    }
};

START_TEST(bullets_meshes_may_change_under_a_resting_mesh)
{
    for (qcFloor kind : {qc_floorStatic, qc_floorGImpact, qc_floorTerrain})
    {
        RisingFloor floor(kind);
        btRigidBody* cube = AddCube(floor.world, floor.world.Keep(qcCubeModel().MakeShape()), floor.shape->getMargin());
        double before = CubeHeight(cube);
        for (int i = 1; i <= 60; i++)
        {
            floor.Rise(btScalar(0.005 * i));
            floor.world.Step();
        }
        floor.world.Step(120);
        ck_assert_double_eq_tol(CubeHeight(cube), before + 0.3, 1e-3);
    }
}
END_TEST

START_TEST(a_change_of_bounds_is_detected_without_update_shape)
{
    qcMeshWorld world;
    qcModel model = qcFloorModel(4, 8);
    auto* floor = static_cast<btBvhTriangleMeshShape*>(world.StaticMesh(model));
    world.Add(floor, 0, btVector3(0, 0, 0));
    btRigidBody* cube = AddCube(world, world.Keep(qcCubeModel().MakeShape()), floor->getMargin());
    double before = CubeHeight(cube);
    std::vector<btScalar>& positions = world.models.back()->positions;
    for (size_t i = 1; i < positions.size(); i += 3)
        positions[i] = btScalar(0.02);
    const btVector3 far(10, 10, 10);
    floor->refitTree(-far, far);
    world.Step(120);
    ck_assert_double_eq_tol(CubeHeight(cube), before + 0.02, 1e-3);
}
END_TEST

START_TEST(a_body_may_be_given_a_shape_of_any_kind)
{
    for (qcFloor kind : {qc_floorStatic, qc_floorOurs, qc_floorPlane})
    {
        qcMeshWorld world;
        btScalar margin = qcAddFloor(world, kind);
        btCollisionShape* mesh = world.Keep(qcCubeModel().MakeShape());
        const btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
        btCollisionShape* box = world.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(half)));
        auto* compound = new btCompoundShape;
        compound->addChildShape(btTransform::getIdentity(), box);
        world.Keep(std::unique_ptr<btCollisionShape>(compound));
        auto* plane = new btStaticPlaneShape(btVector3(0, -1, 0), 0);
        world.Keep(std::unique_ptr<btCollisionShape>(plane));
        btRigidBody* cube = AddCube(world, mesh, margin);
        double rest = CubeHeight(cube);
        for (btCollisionShape* other :
             {box, static_cast<btCollisionShape*>(compound), static_cast<btCollisionShape*>(plane)})
        {
            // No contact until the body is added again, as with Bullet's algorithms for concave shapes.
            cube->setCollisionShape(other);
            world.Step(3);
            ck_assert_int_eq(qcContactsOf(world.dispatcher).points, 0);
            cube->setCollisionShape(mesh);
            world.Step(120);
            ck_assert_double_eq_tol(CubeHeight(cube), rest, 1e-3);
        }
    }
}
END_TEST

START_TEST(empty_meshes_and_transforms_that_are_not_finite_disturb_no_other_body)
{
    qcMeshWorld world;
    btScalar margin = qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btCollisionShape* empty =
        world.Keep(std::unique_ptr<btCollisionShape>(new qcMeshShape(nullptr, qc_positionF32, 0, 0, nullptr, 0)));
    auto* compound = new btCompoundShape;
    world.Keep(std::unique_ptr<btCollisionShape>(compound));
    compound->addChildShape(btTransform::getIdentity(), empty);
    btRigidBody* cube = AddCube(world, shape, margin);
    double rest = CubeHeight(cube);
    world.Add(empty, 1, btVector3(0, btScalar(0.5), 0));
    world.Add(compound, 1, btVector3(0, btScalar(1.2), 0));
    world.Step(60);
    ck_assert_double_eq_tol(CubeHeight(cube), rest, 1e-3);
    btRigidBody* lost = world.Add(shape, 1, btVector3(2, btScalar(0.52), 0));
    btRigidBody* upper = world.Add(shape, 1, btVector3(0, btScalar(rest) + btScalar(1.02), 0));
    world.Step(10);
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
    lost->setLinearVelocity(btVector3(nan, nan, nan));
    for (int i = 0; i < 60; i++)
        world.world.stepSimulation(qcStep, 0);
    ck_assert_double_eq_tol(CubeHeight(cube), rest, 1e-3);
    ck_assert_double_eq_tol(CubeHeight(upper), rest + 1.02, 2e-3);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_changes", a_resting_cube_that_is_scaled_up_rises,
             a_cube_scaled_into_another_has_contact_in_that_step, a_new_mesh_at_an_old_address_is_read_anew,
             a_terrain_at_the_address_of_a_deleted_one_is_read_anew, bullets_meshes_may_change_under_a_resting_mesh,
             a_change_of_bounds_is_detected_without_update_shape, a_body_may_be_given_a_shape_of_any_kind,
             empty_meshes_and_transforms_that_are_not_finite_disturb_no_other_body)
