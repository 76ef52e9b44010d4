// Momentum and energy where contacts can't separate surfaces, cloth among moving meshes, bodies that are tangled at the
// start.
#include "bench/soft/pile_scene.h"
#include "bench/soft/tangle_scene.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/add_loop.h"
#include "bullet/mesh/mesh_bunny.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_apartStep = btScalar(1.0 / 60);

/// A world without gravity, whose cloths are 2500 and 900 nodes.
struct FlyingWorld : qcSoftWorld
{
    FlyingWorld()
    {
        SetGravity(btVector3(0, 0, 0));
    }

    /// A square; `tilt`: how much higher one corner lies.
    btSoftBody* Add(btScalar half, btScalar y, btScalar tilt, int nodes)
    {
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-half, y, -half),
                                                           btVector3(half, y, -half), btVector3(-half, y, half),
                                                           btVector3(half, y + tilt, half), nodes, nodes, 0, true);
        cloth->setTotalMass(1);
        return AddThin(cloth);
    }

    btScalar Energy() const
    {
        btScalar sum = 0;
        for (const btSoftBody* cloth : cloths)
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                sum += cloth->m_nodes[i].m_v.length2() / cloth->m_nodes[i].m_im / 2;
        return sum;
    }

    void Step()
    {
        world.stepSimulation(s_apartStep, 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    }
};

const double s_apartSpeeds[] = {5, 20, 50};
} // namespace

START_TEST(cloths_thrown_at_each_other_keep_momentum_and_gain_no_energy)
{
    btScalar speed = btScalar(s_apartSpeeds[_i]);
    FlyingWorld world;
    world.Add(1, 0, 0, 50);
    btSoftBody* thrown = world.Add(btScalar(0.6), btScalar(0.35), btScalar(0.5), 30);
    thrown->setVelocity(btVector3(0, -speed, 0));
    int planes = 0;
    btScalar energy = world.Energy();
    for (int step = 0; step < 12; step++)
    {
        world.Step();
        const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
        planes += statistics.planes;
        ck_assert_int_eq(statistics.remaining, 0);
        ck_assert_uint_eq(qcCountTangled({world.cloths[0], world.cloths[1]}), 0);
        btVector3 momentum = qcMomentumOf(world.cloths[0]) + qcMomentumOf(world.cloths[1]);
        ck_assert_double_le(double((momentum - btVector3(0, -speed, 0)).length()), 1e-3 * double(speed));
        ck_assert_double_le(double(world.Energy()), 1.01 * double(energy));
    }
    // Contacts alone did not separate them.
    ck_assert_int_gt(planes, 100);
}
END_TEST

/// The momentum along the thrown cloth that it gives to the other one in a step in which planes alone hold them apart;
/// `normal`: that across it.
static double SidewaysMomentum(btScalar sideways, btScalar friction, double* normal)
{
    FlyingWorld world;
    qcSoftBodySettings settings;
    settings.friction = friction;
    btSoftBody* hit = world.Add(1, 0, 0, 16);
    btSoftBody* thrown = world.Add(btScalar(0.5), btScalar(0.1), btScalar(0.02), 9);
    for (btSoftBody* cloth : world.cloths)
        world.softSolver.setSettings(cloth, settings);
    thrown->setVelocity(btVector3(sideways, -20, 0));
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
    ck_assert_int_gt(world.softSolver.getStatistics().planes, 100);
    *normal = -double(qcMomentumOf(hit).y());
    return double(qcMomentumOf(hit).x());
}

START_TEST(planes_have_coulomb_friction)
{
    double normal = 0;
    // The cloths give each other 5 kg m/s. The slow one sticks: both would move at 1 m/s if they were rigid.
    double smooth = SidewaysMomentum(2, 0, &normal), stuck = SidewaysMomentum(2, btScalar(0.5), &normal);
    ck_assert_double_lt(smooth, 0.1);
    ck_assert_double_gt(stuck, 0.5);
    ck_assert_double_lt(stuck, 1);
    // The quick one slides. Without friction it gives some momentum, since it is bent.
    smooth = SidewaysMomentum(10, 0, &normal);
    double slid = SidewaysMomentum(10, btScalar(0.2), &normal) - smooth;
    ck_assert_double_gt(slid, 0.6 * 0.2 * normal);
    ck_assert_double_lt(slid, 0.2 * normal);
}
END_TEST

#ifdef QC_BUNNY
START_TEST(a_cloth_over_a_pile_of_moving_meshes_does_not_hang)
{
    qcModel bunny = qcBunnyModel(QC_BUNNY, 1000);
    qcPileSceneDef def;
    def.positions = bunny.positions;
    def.indices = bunny.indices;
    qcPileScene scene(def);
    scene.quick.setThreadCount(1);
    scene.contact.setThreadCount(1);
    btScalar highest = 0;
    for (int step = 0; step < 140; step++)
    {
        scene.Step();
        const qcSoftBodyStatistics& statistics = scene.quick.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.remaining, 0);
        ck_assert_int_lt(statistics.zoneNodes, def.nodes * def.nodes / 2);
        // Falling, or lying over the pile: not in the air, and not at rest as a whole.
        ck_assert_int_lt(scene.Measure().still, def.nodes * def.nodes / 2);
        for (const auto& body : scene.bodies)
            highest = std::max(highest, body->getLinearVelocity().length());
    }
    qcPileMeasure end = scene.Measure();
    ck_assert_double_lt(double(end.height), 1.2);
    ck_assert_double_lt(double(highest), 12);
}
END_TEST
#endif

// Most of twelve starts end after 30 to 50 steps, one or two after 65, one of Bullet's after 60.
constexpr int s_scrambledSteps = 80;

/// Adds the last step after which something is tangled, of ours and of Bullet's.
static void RunScrambled(unsigned randomSeed, int* oursLast, int* bulletsLast)
{
    qcScrambledScene ours(true, 5, randomSeed), bullets(false, 5, randomSeed);
    size_t start = ours.CountTangled();
    ck_assert_uint_gt(start, 10000);
    ck_assert_uint_eq(start, bullets.CountTangled());
    int lastOfOurs = 0, lastOfBullets = 0;
    for (int step = 1; step <= s_scrambledSteps; step++)
    {
        ours.Step();
        bullets.Step();
        const qcSoftBodyStatistics& statistics = ours.quick->getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_le(statistics.remaining, statistics.exempt + statistics.unproven);
        ck_assert_uint_eq(size_t(statistics.remaining), ours.CountTangled());
        lastOfOurs = statistics.remaining > 0 ? step : lastOfOurs;
        lastOfBullets = bullets.CountTangled() > 0 ? step : lastOfBullets;
    }
    ck_assert_int_lt(lastOfOurs, s_scrambledSteps);
    *oursLast += lastOfOurs;
    *bulletsLast += lastOfBullets;
}

START_TEST(scrambled_bodies_recover_no_later_than_in_bullet)
{
    // Single starts differ by ten steps either way.
    int oursLast = 0, bulletsLast = 0;
    for (unsigned randomSeed = 1; randomSeed <= 6; randomSeed++)
        RunScrambled(randomSeed, &oursLast, &bulletsLast);
    ck_assert_int_le(oursLast, bulletsLast);
}
END_TEST

START_TEST(rings_that_begin_inside_of_each_other_fall_freely_and_come_apart)
{
    qcRingsScene ours(true), bullets(false);
    ck_assert_uint_gt(ours.CountTangled(), 10);
    btScalar start = ours.Height();
    btVector3 momentum(0, 0, 0);
    for (int step = 1; step <= 30; step++)
    {
        ours.Step();
        bullets.Step();
        if (step > 2)
            ck_assert_uint_eq(ours.CountTangled(), 0);
    }
    // Free fall by semi-implicit Euler steps.
    ck_assert_double_eq_tol(double(start - ours.Height()), 10 * 30 * 31 / 7200.0, 1e-3);
    ck_assert_double_ge(double(start - ours.Height()), double(start - bullets.Height()));
    for (const btSoftBody* ring : ours.rings)
        momentum += qcMomentumOf(ring);
    ck_assert_double_le(double(btFabs(momentum.x()) + btFabs(momentum.z())), 0.1);
}
END_TEST

START_TEST(untangling_throws_no_energy_in)
{
    // Two cloths that cross at right angles, at rest.
    FlyingWorld world;
    btSoftBody* upright = world.Add(btScalar(0.5), 0, 0, 21);
    world.Add(1, btScalar(0.013), 0, 40);
    upright->transform(btTransform(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI), btVector3(btScalar(0.03), 0, 0)));
    size_t start = qcCountTangled({world.cloths[0], world.cloths[1]}), most = 0;
    ck_assert_uint_gt(start, 10);
    for (int step = 0; step < 60; step++)
    {
        world.Step();
        most = std::max(most, qcCountTangled({world.cloths[0], world.cloths[1]}));
        ck_assert_double_lt(double(qcSpeedOf(world.cloths[0])), 0.5);
    }
    ck_assert_uint_le(most, 2 * start);
}
END_TEST

START_TEST(a_corner_that_begins_below_a_mesh_does_not_take_the_rest_through)
{
    qcSoftWorld world;
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(4, 1).MakeShape();
    btRigidBody floor(0, nullptr, shape.get());
    world.world.addRigidBody(&floor);
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), btVector3(-1, btScalar(-0.05), -1),
                                                       btVector3(1, btScalar(0.3), -1), btVector3(-1, btScalar(0.3), 1),
                                                       btVector3(1, btScalar(0.3), 1), 20, 20, 0, true);
    cloth->setTotalMass(1);
    cloth->m_cfg.piterations = 4;
    world.world.addSoftBody(cloth);
    size_t start = qcCountPenetrating({qcWorldMeshOf(cloth), qcWorldMeshOf(*shape, floor.getWorldTransform())}, true);
    ck_assert_uint_gt(start, 0);
    for (int step = 0; step < 120; step++)
    {
        world.world.stepSimulation(s_apartStep, 0);
        const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.unproven, 0);
        ck_assert_uint_le(size_t(statistics.exempt), start);
    }
    int below = 0;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        below += cloth->m_nodes[i].m_x.y() < 0;
    ck_assert_int_le(below, 10);
    world.world.removeSoftBody(cloth);
    delete cloth;
    world.world.removeRigidBody(&floor);
}
END_TEST

START_TEST(a_cloth_crushed_between_two_meshes_is_reported_and_not_thrown_away)
{
    qcSoftWorld world;
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(2, 8).MakeShape();
    btRigidBody floor(0, nullptr, shape.get()), press(0, nullptr, shape.get());
    press.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    press.setActivationState(DISABLE_DEACTIVATION);
    auto movePress = [&](int centimetres)
    {
        btQuaternion tilt(btVector3(1, 0, 0), btScalar(0.2));
        press.setWorldTransform(btTransform(tilt, btVector3(0, btScalar(centimetres) / 100, 0)));
    };
    movePress(70);
    world.world.addRigidBody(&floor);
    world.world.addRigidBody(&press);
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), btVector3(-1, btScalar(0.1), -1),
                                                       btVector3(1, btScalar(0.1), -1), btVector3(-1, btScalar(0.1), 1),
                                                       btVector3(1, btScalar(0.15), 1), 16, 16, 0, true);
    cloth->setTotalMass(1);
    cloth->m_cfg.piterations = 4;
    world.world.addSoftBody(cloth);
    int unproven = 0;
    for (int step = 1; step <= 60; step++)
    {
        // The lower edge of the press reaches the floor at 20 cm, and goes through it.
        movePress(70 - step);
        world.world.stepSimulation(s_apartStep, 0);
        const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_le(statistics.remaining, statistics.exempt + statistics.unproven);
        if (70 - step > 22)
            ck_assert_int_eq(statistics.remaining, 0);
        unproven += statistics.unproven;
        ck_assert_double_lt(double(qcSpeedOf(cloth)), 2);
    }
    ck_assert_int_gt(unproven, 0);
    world.world.removeSoftBody(cloth);
    delete cloth;
    world.world.removeRigidBody(&press);
    world.world.removeRigidBody(&floor);
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("soft bodies apart");
    qcAddLoop(tests, cloths_thrown_at_each_other_keep_momentum_and_gain_no_energy, 3);
    tcase_add_test(tests, planes_have_coulomb_friction);
#ifdef QC_BUNNY
    tcase_add_test(tests, a_cloth_over_a_pile_of_moving_meshes_does_not_hang);
#endif
    tcase_add_test(tests, scrambled_bodies_recover_no_later_than_in_bullet);
    tcase_add_test(tests, rings_that_begin_inside_of_each_other_fall_freely_and_come_apart);
    tcase_add_test(tests, untangling_throws_no_energy_in);
    tcase_add_test(tests, a_corner_that_begins_below_a_mesh_does_not_take_the_rest_through);
    tcase_add_test(tests, a_cloth_crushed_between_two_meshes_is_reported_and_not_thrown_away);
    return qcRunCase("soft bodies apart", tests);
}
