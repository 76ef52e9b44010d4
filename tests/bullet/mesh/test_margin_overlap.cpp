// Meshes whose margins overlap when they are added to the world: at rest they leave each other slowly, where Bullet's
// solver would turn the overlap into speed. And the rolling friction of such faces.
#include "bullet/mesh/mesh_world.h"

namespace
{
constexpr btScalar s_margin = btScalar(0.01);

/// Cubes of 1 m side by side, n along each axis, in the air or on a floor.
std::vector<btRigidBody*> AddCubes(qcMeshWorld& world, const int n[3])
{
    std::vector<btRigidBody*> cubes;
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape(s_margin));
    for (int i = 0; i < n[0] * n[1] * n[2]; i++)
        cubes.push_back(world.Add(
            shape, 10,
            btVector3(btScalar(i % n[0]), btScalar(0.5) + btScalar(i / n[0] % n[1]), btScalar(i / (n[0] * n[1])))));
    return cubes;
}

/// The highest speed of a body at the end of each of these steps.
double FastestIn(qcMeshWorld& world, const std::vector<btRigidBody*>& bodies, int steps)
{
    btScalar fastest = 0;
    for (int step = 0; step < steps; step++)
    {
        world.Step();
        for (const btRigidBody* body : bodies)
            fastest = std::max(fastest, body->getLinearVelocity().length());
    }
    printf("%zu cubes: at most %.3f m/s\n", bodies.size(), double(fastest));
    return double(fastest);
}

btScalar Between(const btRigidBody* a, const btRigidBody* b)
{
    return (b->getWorldTransform().getOrigin() - a->getWorldTransform().getOrigin()).length();
}

START_TEST(cubes_that_touch_leave_each_other_slowly)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    const int n[3] = {3, 3, 3};
    std::vector<btRigidBody*> cubes = AddCubes(world, n);
    // The outer ones move by 0.02 m/s along each axis. With all of the overlap at once it is 0.41 m/s.
    ck_assert_double_lt(FastestIn(world, cubes, 60), 0.1);
    world.Step(60);
    ck_assert_double_gt(double(Between(cubes[0], cubes[1])), 1 + 1.9 * double(s_margin));
    ck_assert_double_gt(double(Between(cubes[13], cubes[16])), 1 + 1.9 * double(s_margin));
}
END_TEST

// Pieces of a body that breaks in flight do so.
START_TEST(cubes_that_fly_and_turn_as_one_body_are_not_thrown_apart)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    const int n[3] = {3, 3, 3};
    const btVector3 velocity(3, 4, 0), spin(0, 0, btScalar(0.3));
    for (btRigidBody* cube : AddCubes(world, n))
    {
        cube->setLinearVelocity(velocity + spin.cross(cube->getWorldTransform().getOrigin()));
        cube->setAngularVelocity(spin);
    }
    const double before = world.KineticEnergy();
    world.Step(60);
    printf("%.2f J of %.0f\n", world.KineticEnergy() - before, before);
    // With all of the overlap at once it is 14 J.
    ck_assert_double_lt(world.KineticEnergy() - before, 1);
}
END_TEST

START_TEST(a_stack_of_cubes_that_touch_does_not_jump)
{
    qcMeshWorld world;
    qcAddFloor(world, qcFloor(_i));
    const int n[3] = {1, 5, 1};
    std::vector<btRigidBody*> cubes = AddCubes(world, n);
    // With all of the overlap at once it is 1 m/s.
    ck_assert_double_lt(FastestIn(world, cubes, 120), 0.2);
    world.Step(120);
    ck_assert_double_lt(world.KineticEnergy(), 1e-3);
    for (size_t i = 1; i < cubes.size(); i++)
        ck_assert_double_gt(double(Between(cubes[i - 1], cubes[i])), 1 + 1.5 * double(s_margin));
}
END_TEST

START_TEST(meshes_that_penetrate_are_pushed_apart_at_once)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    const int n[3] = {2, 1, 1};
    std::vector<btRigidBody*> cubes = AddCubes(world, n);
    cubes[1]->translate(btVector3(btScalar(-0.005), 0, 0));
    world.Step(8);
    ck_assert_double_gt(double(Between(cubes[0], cubes[1])), 1);
}
END_TEST

/// The speed at which two cubes leave each other after a step that begins with an overlap of margins.
double Rebound(btScalar closing)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    const int n[3] = {2, 1, 1};
    std::vector<btRigidBody*> cubes = AddCubes(world, n);
    cubes[0]->setLinearVelocity(btVector3(closing, 0, 0));
    world.Step();
    return double(cubes[1]->getLinearVelocity().x() - cubes[0]->getLinearVelocity().x());
}

START_TEST(only_slow_bodies_spare_their_margins)
{
    // In a step the slow one moves by a sixth of the margins, the fast one by 2.5 times the margins.
    ck_assert_double_lt(Rebound(btScalar(0.2)), 0.02);
    ck_assert_double_gt(Rebound(3), 0.1);
}
END_TEST

/// The smallest and the largest rolling friction of the world's contact points.
std::pair<btScalar, btScalar> RollingFriction(btDispatcher& dispatcher)
{
    std::pair<btScalar, btScalar> range(BT_LARGE_FLOAT, 0);
    for (int m = 0; m < dispatcher.getNumManifolds(); m++)
        for (int i = 0; i < dispatcher.getManifoldByIndexInternal(m)->getNumContacts(); i++)
        {
            btScalar rolling = dispatcher.getManifoldByIndexInternal(m)->getContactPoint(i).m_combinedRollingFriction;
            range = {std::min(range.first, rolling), std::max(range.second, rolling)};
        }
    return range;
}

START_TEST(faces_that_begin_in_contact_have_rolling_friction_from_their_second_step_on)
{
    qcMeshWorld world;
    world.world.setGravity(btVector3(0, 0, 0));
    const int n[3] = {2, 1, 1};
    for (btRigidBody* cube : AddCubes(world, n))
        cube->setRollingFriction(btScalar(0.1));
    world.Step();
    ck_assert_int_gt(qcContactsOf(world.dispatcher).points, 2);
    ck_assert_double_eq(double(RollingFriction(world.dispatcher).second), 0);
    world.Step();
    ck_assert_int_gt(qcContactsOf(world.dispatcher).points, 2);
    ck_assert_double_gt(double(RollingFriction(world.dispatcher).first), 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("margin overlap");
    tcase_add_test(tests, cubes_that_touch_leave_each_other_slowly);
    tcase_add_test(tests, cubes_that_fly_and_turn_as_one_body_are_not_thrown_apart);
    tcase_add_loop_test(tests, a_stack_of_cubes_that_touch_does_not_jump, 0, qc_floorCount);
    tcase_add_test(tests, meshes_that_penetrate_are_pushed_apart_at_once);
    tcase_add_test(tests, only_slow_bodies_spare_their_margins);
    tcase_add_test(tests, faces_that_begin_in_contact_have_rolling_friction_from_their_second_step_on);
    return qcRunCase("margin overlap", tests);
}
