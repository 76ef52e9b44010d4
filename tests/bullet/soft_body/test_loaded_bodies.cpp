// Bodies of tetrahedra that carry many times their own mass in the deformable world: they keep their shape and come to
// rest, what they carry as well, and momentum stays as it is.
#include "bullet/soft_body/load_world.h"

#include <BulletSoftBody/btDeformableNeoHookeanForce.h>

namespace
{
START_TEST(a_cube_carries_many_times_its_mass)
{
    for (bool implicit : {true, false})
        for (btScalar times : {btScalar(1), btScalar(10), btScalar(implicit ? 40 : 15)})
        {
            qcLoadWorld world(btVector3(0, -10, 0), implicit);
            btSoftBody* cube = world.AddCube(btScalar(0.02), qcCubeMass);
            btRigidBody* box = world.AddBox(btScalar(1.25), times * qcCubeMass);
            world.Step(240);
            ck_assert_double_gt(qcSmallestVolume(cube), 0.7);
            // By load, Young's modulus and area the cube is some 3 % lower under the heaviest.
            ck_assert_double_gt(double(box->getWorldTransform().getOrigin().y()), 1.18);
            ck_assert_double_lt(double(box->getWorldTransform().getOrigin().y()), 1.25);
            ck_assert_double_lt(double(qcSpeedOf(cube)), times > 20 ? 0.3 : 0.1);
            ck_assert_double_lt(double(box->getLinearVelocity().length()), times > 20 ? 0.3 : 0.1);
        }
}
END_TEST

START_TEST(a_load_whose_factors_guide_it_is_carried_as_a_free_one)
{
    btScalar height[3];
    for (int i = 0; i < 3; i++)
    {
        qcLoadWorld world(btVector3(0, -10, 0));
        btSoftBody* cube = world.AddCube(btScalar(0.02), qcCubeMass);
        btRigidBody* box = world.AddBox(btScalar(1.25), 10 * qcCubeMass);
        if (i > 0)
            box->setAngularFactor(0);
        if (i > 1)
            box->setLinearFactor(btVector3(0, 1, 0));
        world.Step(240);
        ck_assert_double_gt(qcSmallestVolume(cube), 0.7);
        ck_assert_double_lt(double(box->getLinearVelocity().length()), 0.1);
        const btVector3 place = box->getWorldTransform().getOrigin();
        height[i] = place.y();
        ck_assert_double_lt(double(btVector3(place.x(), 0, place.z()).length()), i > 1 ? 1e-6 : 0.05);
        if (i > 0)
            ck_assert_double_lt(double(box->getWorldTransform().getRotation().getAngle()), 1e-4);
    }
    ck_assert_double_eq_tol(double(height[1]), double(height[0]), 0.01);
    ck_assert_double_eq_tol(double(height[2]), double(height[0]), 0.01);
}
END_TEST

/// The volume of a cube whose sides are 0.66 apart, as a share of that at rest. `presses`: kinematic boxes press these
/// together, in a second; otherwise their nodes are moved.
double VolumeOfSqueezed(bool presses)
{
    btBoxShape plateShape(btVector3(btScalar(0.1), 1, 1));
    plateShape.setMargin(btScalar(0.01));
    qcLoadWorld world(btVector3(0, 0, 0));
    btSoftBody* cube = world.AddCube(2, qcCubeMass);
    std::vector<int> sides[2];
    btRigidBody* plates[2] = {nullptr, nullptr};
    for (int side = 0; side < 2; side++)
        for (int i = 0; i < cube->m_nodes.size(); i++)
            if (btFabs(cube->m_nodes[i].m_x.x() - (btScalar(side) - btScalar(0.5))) < btScalar(0.01))
                sides[side].push_back(i);
    for (int side = 0; side < 2 && presses; side++)
    {
        world.boxes.emplace_back(new btRigidBody(0, nullptr, &plateShape));
        plates[side] = world.boxes.back().get();
        plates[side]->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        plates[side]->setActivationState(DISABLE_DEACTIVATION);
        plates[side]->setFriction(2);
        plates[side]->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(btScalar(side == 0 ? -0.65 : 0.65), btScalar(2.5), 0)));
        world.world->addRigidBody(plates[side]);
    }
    for (int side = 0; side < 2 && !presses; side++)
        for (int node : sides[side])
            cube->setMass(node, 0);
    const int steps = 120;
    for (int i = 1; i <= 3 * steps; i++)
    {
        const btScalar half = btScalar(0.5) - btScalar(0.17) * btScalar(std::min(i, steps)) / btScalar(steps);
        for (int side = 0; side < 2; side++)
        {
            const btScalar x = side == 0 ? -half : half;
            if (presses)
                // The cube has a margin of 0.02.
                plates[side]->setWorldTransform(btTransform(
                    btQuaternion::getIdentity(), btVector3(x * (1 + btScalar(0.12) / half), btScalar(2.5), 0)));
            else
                for (int node : sides[side])
                    cube->m_nodes[node].m_x.setX(x), cube->m_nodes[node].m_q.setX(x);
        }
        world.Step(1);
    }
    ck_assert_double_gt(qcSmallestVolume(cube), 0);
    ck_assert_double_lt(double(qcSpeedOf(cube)), 0.05);
    return qcWholeVolume(cube);
}

START_TEST(a_cube_that_is_squeezed_keeps_its_stiffness)
{
    const double squeezed = VolumeOfSqueezed(true), reference = VolumeOfSqueezed(false);
    printf("squeezed cube: %.1f %% of its volume, by its nodes %.1f %%\n", 100 * squeezed, 100 * reference);
    ck_assert_double_eq_tol(squeezed, reference, 0.03);
}
END_TEST

START_TEST(a_cube_that_lies_on_the_floor_keeps_its_shape_and_comes_to_rest)
{
    // Near the limit of Bullet's explicit solver; contacts alone made such cubes tremble at up to 8 m/s.
    for (const double rate : {60.0, 120.0})
        for (const btScalar tilt : {btScalar(0), btScalar(0.2)})
        {
            btDeformableNeoHookeanForce elasticity(1000, 2000, btScalar(0.02));
            qcLoadWorld world(btVector3(0, -10, 0), false);
            world.step = btScalar(1 / rate);
            btSoftBody* cube = qcAsTetraBody(qcMakeTetraCube(world.world->getWorldInfo(), btVector3(0, 0, 0),
                                                             qcLoadCells, btScalar(0.8) / qcLoadCells, false));
            cube->rotate(btQuaternion(btVector3(1, 0, btScalar(0.3)).normalized(), tilt));
            cube->translate(btVector3(0, btScalar(0.4), 0));
            cube->setTotalMass(2);
            cube->m_cfg.kDF = btScalar(0.5);
            cube->setVelocity(btVector3(1, 0, 0));
            world.cloths.push_back(cube);
            world.world->addSoftBody(cube);
            world.world->addForce(cube, &world.gravity);
            world.world->addForce(cube, &elasticity);
            world.Step(int(4 * rate));
            printf("cube on the floor, %g steps/s, tilt %g: %.1f %% of its smallest volume, %.4f m/s\n", rate,
                   double(tilt), 100 * qcSmallestVolume(cube), double(qcSpeedOf(cube)));
            ck_assert_double_gt(qcSmallestVolume(cube), 0.97);
            ck_assert_double_lt(double(qcSpeedOf(cube)), 0.02);
            world.world->removeForce(cube, &elasticity);
        }
}
END_TEST

START_TEST(a_light_cube_carries_a_heavy_one)
{
    qcLoadWorld world(btVector3(0, -10, 0));
    btSoftBody *lower = world.AddCube(btScalar(0.02), qcCubeMass),
               *upper = world.AddCube(btScalar(1.05), 10 * qcCubeMass);
    world.Step(240);
    ck_assert_double_gt(qcSmallestVolume(lower), 0.7);
    ck_assert_double_gt(qcSmallestVolume(upper), 0.7);
    ck_assert_double_lt(double(qcSpeedOf(lower)), 0.1);
    ck_assert_double_lt(double(qcSpeedOf(upper)), 0.3);
}
END_TEST

START_TEST(momentum_is_kept_and_energy_does_not_grow)
{
    qcLoadWorld world(btVector3(0, 0, 0));
    btSoftBody* cube = world.AddCube(3, qcCubeMass);
    btRigidBody* box = world.AddBox(btScalar(4.3), 5);
    box->setLinearVelocity(btVector3(btScalar(0.2), -2, 0));
    const btVector3 begin = box->getLinearVelocity() * 5;
    bool hasTouched = false;
    for (int i = 0; i < 100; i++)
    {
        world.Step(1);
        hasTouched = hasTouched || world.world->getStatistics().contacts > 0;
        const btVector3 momentum = box->getLinearVelocity() * 5 + qcMomentumOf(cube);
        ck_assert_double_lt(double((momentum - begin).length()), 0.02 * double(begin.length()));
        ck_assert_double_lt(double(box->getLinearVelocity().length()), 2.02);
    }
    ck_assert(hasTouched);
    ck_assert_double_gt(double(-qcMomentumOf(cube).y()), 0.5);
    ck_assert_double_gt(qcSmallestVolume(cube), 0.3);
}
END_TEST

/// How far a box slides in a second on a cube with this friction, where gravity has a fifth of its strength sideways.
double SlideOnCube(btScalar friction)
{
    qcLoadWorld world(btVector3(2, -10, 0));
    btSoftBody* cube = world.AddCube(btScalar(0.02), qcCubeMass);
    qcSoftBodySettings settings = world.world->getSettings(cube);
    settings.friction = friction;
    ck_assert_int_eq(world.world->setSettings(cube, settings), qc_statusOk);
    // The cube stays on the floor.
    for (int i = 0; i < cube->m_nodes.size(); i++)
        if (cube->m_nodes[i].m_x.y() < btScalar(0.03))
            cube->setMass(i, 0);
    btRigidBody* box = world.AddBox(btScalar(1.23), 1);
    box->setFriction(friction);
    world.Step(240);
    return double(box->getWorldTransform().getOrigin().x());
}

START_TEST(friction_holds_a_load)
{
    ck_assert_double_lt(SlideOnCube(btScalar(0.6)), 0.1);
    // Without friction it has left the cube.
    ck_assert_double_gt(SlideOnCube(0), 0.5);
}
END_TEST

START_TEST(a_load_may_go)
{
    qcLoadWorld world(btVector3(0, -10, 0));
    btSoftBody *lower = world.AddCube(btScalar(0.02), qcCubeMass), *upper = world.AddCube(btScalar(1.05), qcCubeMass);
    btRigidBody* box = world.AddBox(btScalar(2.28), 5);
    world.Step(60);
    world.world->removeRigidBody(box);
    world.boxes.clear();
    world.Step(10);
    world.world->removeSoftBody(upper);
    world.cloths.pop_back();
    delete upper;
    world.Step(240);
    ck_assert_double_gt(qcSmallestVolume(lower), 0.95);
    ck_assert_double_lt(double(qcSpeedOf(lower)), 0.02);
}
END_TEST
} // namespace

QC_RUN_TESTS("loaded_bodies", a_cube_carries_many_times_its_mass,
             a_load_whose_factors_guide_it_is_carried_as_a_free_one, a_cube_that_is_squeezed_keeps_its_stiffness,
             a_cube_that_lies_on_the_floor_keeps_its_shape_and_comes_to_rest, a_light_cube_carries_a_heavy_one,
             momentum_is_kept_and_energy_does_not_grow, friction_holds_a_load, a_load_may_go)
