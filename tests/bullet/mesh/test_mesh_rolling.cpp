// Round meshes that roll: a vertex leaves the straight line along which Bullet's solver takes it.
#include "bullet/mesh/mesh_world.h"

namespace
{
constexpr btScalar s_rollRadius = btScalar(0.5);

/// A ball of 20 * 4^level triangles, or a roller.
qcModel RoundModel(btScalar radius, int kind)
{
    return kind == 0   ? qcSphereModel(double(radius), 4)
           : kind == 1 ? qcSphereModel(double(radius), 5)
                       : qcCylinderModel(double(radius), double(radius) / 2, 128);
}

/// A round body that rolls along x on a floor without slipping.
struct RollingWorld
{
    qcMeshWorld made;
    btRigidBody* body;
    double energy; ///< kinetic, at the beginning
    double start;

    RollingWorld(const qcModel& model, btScalar radius, btScalar speed, qcFloor floor)
    {
        made.world.setGravity(btVector3(0, btScalar(-9.81), 0));
        const btScalar margin = qcAddFloor(made, floor);
        made.bodies.back()->setFriction(1);
        btCollisionShape* shape = made.Keep(model.MakeShape());
        const btScalar outer = radius + shape->getMargin();
        body = made.Add(shape, 10, btVector3(btScalar(-3.5), outer + margin, 0));
        body->setFriction(btScalar(0.8));
        body->setActivationState(DISABLE_DEACTIVATION);
        body->setLinearVelocity(btVector3(speed, 0, 0));
        body->setAngularVelocity(btVector3(0, 0, -speed / outer));
        energy = made.KineticEnergy();
        start = made.Energy();
    }

    void Step(double seconds, int stepsPerSecond, double* maxGain)
    {
        for (int i = 0; i < int(seconds * stepsPerSecond); i++)
        {
            made.world.stepSimulation(1 / btScalar(stepsPerSecond), 0);
            *maxGain = std::max(*maxGain, (made.Energy() - start) / energy);
        }
        ck_assert_int_eq(made.contact.getStatistics().status, qc_statusOk);
    }
};

START_TEST(round_meshes_lose_no_more_speed_at_60_steps_a_second_than_at_960)
{
    for (int floor = 0; floor < qc_floorCount; floor++)
    {
        double speeds[2], maxGain = 0;
        for (int fine = 0; fine < 2; fine++)
        {
            RollingWorld rolling(RoundModel(s_rollRadius, _i), s_rollRadius, 3, qcFloor(floor));
            rolling.Step(2, fine != 0 ? 960 : 60, &maxGain);
            speeds[fine] = double(rolling.body->getLinearVelocity().x());
        }
        printf("  round mesh %d, floor %d: %.2f m/s at 60 steps a second, %.2f at 960\n", _i, floor, speeds[0],
               speeds[1]);
        ck_assert_double_gt(speeds[0], 0.9 * speeds[1]);
        ck_assert_double_lt(maxGain, 0.01);
    }
}
END_TEST

START_TEST(round_meshes_that_roll_slowly_do_not_become_faster)
{
    for (btScalar radius : {btScalar(0.2), btScalar(1)})
        for (int stepsPerSecond : {60, 240})
        {
            const btScalar speed = btScalar(0.2) * btSqrt(radius);
            RollingWorld rolling(RoundModel(radius, _i), radius, speed, qc_floorPlane);
            double maxGain = 0;
            rolling.Step(10, stepsPerSecond, &maxGain);
            printf("  round mesh %d, radius %g, %d steps a second: %.2f of its energy gained\n", _i, double(radius),
                   stepsPerSecond, maxGain);
            ck_assert_double_lt(maxGain, 0.5);
        }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_rolling");
    tcase_add_loop_test(tests, round_meshes_lose_no_more_speed_at_60_steps_a_second_than_at_960, 0, 3);
    tcase_add_loop_test(tests, round_meshes_that_roll_slowly_do_not_become_faster, 0, 3);
    return qcRunCase("mesh_rolling", tests);
}
