// Soft bodies that penetrate or touch at the start: they come apart, without being thrown, and nothing else passes.
#include "bullet/soft_body/tangled_scenes.h"
#include "support/long_form.h"

#include <array>
#include <cstdio>
#include <set>

// After the standard headers: check defines a macro named fail.
#include "bullet/add_loop.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
const int s_sceneCount = int(sizeof(qcTangledScenes) / sizeof(qcTangledScenes[0]));

using Key = std::array<uint32_t, 3>; ///< body, triangle or vertex, other body
using Pair = std::array<uint32_t, 4>;

std::vector<qcWorldMesh> SoupsOf(const qcTangledWorld& world)
{
    std::vector<qcWorldMesh> soups;
    for (const btSoftBody* cloth : world.cloths)
        soups.push_back(qcWorldMeshOf(cloth));
    return soups;
}

/// Penetrating pairs in and among the soft bodies, found without the glue.
std::set<Pair> FindPenetrating(const std::vector<qcWorldMesh>& soups)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    ck_assert_int_eq(qcScene_Create(&sceneDef, &scene), qc_statusOk);
    for (const qcWorldMesh& soup : soups)
    {
        qcBodyDef def = qcBodyOf(soup);
        def.selfCollision = true;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
        ck_assert_uint_eq(id.slot, uint32_t(&soup - soups.data()));
    }
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = nullptr;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusOk);
    std::set<Pair> pairs;
    for (size_t i = 0; i < result->pairCount; i++)
        pairs.insert(
            {result->pairs[i].bodyA, result->pairs[i].triangleA, result->pairs[i].bodyB, result->pairs[i].triangleB});
    qcScene_Destroy(scene);
    return pairs;
}

size_t CountTangled(const qcTangledWorld& world)
{
    std::vector<qcWorldMesh> soups = SoupsOf(world);
    size_t count = FindPenetrating(soups).size();
    for (const auto& body : world.bodies)
        for (const qcWorldMesh& soup : SoupsOf(world))
            count += qcCountPenetrating(
                {soup, qcWorldMeshOf(*static_cast<qcMeshShape*>(body->getCollisionShape()), body->getWorldTransform())},
                true);
    return count;
}

/// The pairs that began to penetrate away from all pairs that did before.
size_t CountPassed(const std::vector<qcWorldMesh>& soups, const std::set<Pair>& before, const std::set<Pair>& after)
{
    std::set<Key> tangled;
    auto add = [&](uint32_t body, uint32_t triangle, uint32_t other)
    {
        for (size_t c = 0; c < 3; c++)
            tangled.insert({body, soups[body].indices[3 * size_t(triangle) + c], other});
    };
    for (const Pair& pair : before)
    {
        add(pair[0], pair[1], pair[2]);
        add(pair[2], pair[3], pair[0]);
    }
    auto isNear = [&](uint32_t body, uint32_t triangle, uint32_t other)
    {
        const uint32_t* corners = &soups[body].indices[3 * size_t(triangle)];
        return std::any_of(corners, corners + 3,
                           [&](uint32_t corner) {
                               return tangled.count({body, corner, other}) != 0;
                           });
    };
    return size_t(std::count_if(after.begin(), after.end(),
                                [&](const Pair& pair)
                                { return !isNear(pair[0], pair[1], pair[2]) || !isNear(pair[2], pair[3], pair[0]); }));
}

btVector3 MomentumOf(const qcTangledWorld& world)
{
    btVector3 sum(0, 0, 0);
    for (const btSoftBody* cloth : world.cloths)
        sum += qcMomentumOf(cloth);
    return sum;
}

void CheckStep(const qcTangledWorld& world)
{
    const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
    ck_assert_int_eq(statistics.status, qc_statusOk);
    ck_assert_int_eq(statistics.unproven, 0);
    ck_assert_int_eq(statistics.remaining, statistics.exempt);
    ck_assert_uint_eq(size_t(statistics.remaining), CountTangled(world));
}
} // namespace

START_TEST(what_starts_tangled_comes_apart_and_is_not_thrown)
{
    const qcTangledSceneDef& def = qcTangledScenes[_i];
    qcTangledWorld world(def.gravity);
    def.make(&world);
    ck_assert_uint_gt(CountTangled(world), 20);
    for (int step = 1; step <= def.steps; step++)
    {
        world.Step();
        CheckStep(world);
        if (def.gravity > 0)
            continue;
        // A part moves by half the thickness of 1 cm in a step, 0.3 m/s, but gets no such speed.
        ck_assert_double_lt(double(world.MaxSpeed()), def.speed);
        ck_assert_double_lt(double(world.Energy()), 0.02);
        if (world.bodies.empty())
            ck_assert_double_lt(double(MomentumOf(world).length()), 1e-4);
    }
    ck_assert_uint_le(CountTangled(world), def.left);
}
END_TEST

START_TEST(nothing_passes_away_from_a_tangle)
{
    const qcTangledSceneDef& def = qcTangledScenes[_i];
    qcTangledWorld world(def.gravity);
    def.make(&world);
    std::vector<qcWorldMesh> soups = SoupsOf(world);
    std::set<Pair> before = FindPenetrating(soups);
    for (int step = 1; step <= 60; step++)
    {
        world.Step();
        std::set<Pair> after = FindPenetrating(SoupsOf(world));
        ck_assert_uint_eq(CountPassed(soups, before, after), 0);
        before = after;
    }
}
END_TEST

START_TEST(the_smaller_part_goes_back_to_the_side_of_the_larger_one)
{
    void (*const makes[])(qcTangledWorld*) = {qcMakeThroughSheet, qcMakeCornerBelowSheet};
    for (auto make : makes)
    {
        qcTangledWorld world(10);
        make(&world);
        for (int step = 0; step < 150; step++)
            world.Step();
        ck_assert_double_gt(double(qcLowestNode(world.cloths[0])), 0);
    }
}
END_TEST

START_TEST(tangles_stay_where_the_setting_is_off)
{
    qcTangledWorld world;
    qcMakeCrossed(&world);
    qcSoftBodySettings settings;
    settings.untangle = false;
    // One of two is enough.
    world.softSolver.setSettings(world.cloths[1], settings);
    std::vector<qcWorldMesh> start = SoupsOf(world);
    int count = int(CountTangled(world));
    for (int step = 0; step < 10; step++)
    {
        world.Step();
        CheckStep(world);
        ck_assert_int_eq(world.softSolver.getStatistics().exempt, count);
    }
    std::vector<qcWorldMesh> end = SoupsOf(world);
    for (size_t body = 0; body < 2; body++)
        for (size_t i = 0; i < start[body].positions.size(); i++)
            ck_assert_double_eq_tol(start[body].positions[i], end[body].positions[i], 1e-6);
    // Tangles that don't come apart don't grow either, where the cloths are pulled further into each other.
    world.cloths[1]->addVelocity(btVector3(0, 1, 0));
    for (int step = 0; step < 30; step++)
    {
        world.Step();
        CheckStep(world);
        ck_assert_int_le(world.softSolver.getStatistics().exempt, count);
    }
}
END_TEST

START_TEST(the_setting_changes_nothing_where_nothing_is_tangled)
{
    std::vector<qcWorldMesh> ends[2];
    for (int untangle = 0; untangle < 2; untangle++)
    {
        qcTangledWorld world(10);
        btSoftBody* cloth = world.AddCloth(btScalar(0.5), btScalar(0.5), 21, 21);
        qcTurn(cloth, btVector3(1, 0, 0), btScalar(1.2), btVector3(0, btScalar(0.6), 0));
        world.AddMesh(qcFloorModel(4, 7), 0, btVector3(0, 0, 0));
        qcSoftBodySettings settings;
        settings.untangle = untangle == 1;
        world.softSolver.setSettings(cloth, settings);
        int contacts = 0;
        for (int step = 0; step < 80; step++)
        {
            world.Step();
            contacts += world.softSolver.getStatistics().contacts;
            ck_assert_int_eq(world.softSolver.getStatistics().exempt, 0);
        }
        ck_assert_int_gt(contacts, 1000);
        ends[untangle] = SoupsOf(world);
    }
    ck_assert(ends[0][0].positions == ends[1][0].positions);
}
END_TEST

START_TEST(a_tangle_with_a_free_mesh_keeps_momentum)
{
    qcTangledWorld world;
    btRigidBody* box = world.AddMesh(qcBoxModel(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 3), 2,
                                     btVector3(btScalar(0.01), btScalar(-0.1), btScalar(0.02)));
    btSoftBody* cloth = world.AddCloth(btScalar(0.6), btScalar(0.6), 25, 25);
    // It moves further through the cloth.
    box->setLinearVelocity(btVector3(0, 1, 0));
    box->setDamping(0, 0);
    bool isTangled = true;
    for (int step = 0; step < 60; step++)
    {
        world.Step();
        CheckStep(world);
        isTangled = world.softSolver.getStatistics().remaining > 0;
        btVector3 momentum = qcMomentumOf(cloth) + box->getLinearVelocity() * 2;
        ck_assert_double_le(double((momentum - btVector3(0, 2, 0)).length()), 2e-2);
        ck_assert_double_le(double(world.Energy() + box->getLinearVelocity().length2()), 1.01);
    }
    ck_assert(!isTangled);
}
END_TEST

START_TEST(surfaces_that_touch_at_the_start_come_apart)
{
    qcTangledWorld world;
    (_i == 0 ? qcMakeTouching : qcMakeNearlyTouching)(&world);
    for (int step = 0; step < 60; step++)
    {
        world.Step();
        CheckStep(world);
        ck_assert_double_lt(double(world.MaxSpeed()), 1);
    }
    ck_assert_int_eq(world.softSolver.getStatistics().remaining, 0);
    ck_assert_int_eq(world.softSolver.getStatistics().planes, 0);
    ck_assert_int_eq(world.softSolver.getStatistics().zoneNodes, 0);
}
END_TEST

START_TEST(cloths_that_cross_along_common_positions_fall_freely_and_come_apart)
{
    qcTangledWorld world(10);
    qcMakeCrossedAtNodes(&world);
    ck_assert_uint_eq(CountTangled(world), 0);
    // Touching surfaces are held as one while they fall; rounding decides when they begin to penetrate, and part.
    // Nothing changes from step to step: the long form looks for drift.
    const int steps = qcIsLongForm() ? 400 : 100;
    for (int step = 0; step < steps; step++)
    {
        world.Step();
        CheckStep(world);
    }
    ck_assert_int_eq(world.softSolver.getStatistics().remaining, 0);
    // What touches does not hold them.
    ck_assert_double_eq_tol(double(MomentumOf(world).y()), -10 * steps / 60.0 * 2, 0.1);
}
END_TEST

/// Angular momentum about the vertical through the origin, around which both cloths lie.
static double SpinOf(const qcTangledWorld& world)
{
    btScalar sum = 0;
    for (const btSoftBody* cloth : world.cloths)
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_x.cross(cloth->m_nodes[i].m_v).y() / cloth->m_nodes[i].m_im;
    return double(sum);
}

START_TEST(cloths_that_move_as_one_keep_spinning)
{
    qcTangledWorld world;
    qcMakeCrossedAtNodes(&world);
    for (btSoftBody* cloth : world.cloths)
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            cloth->m_nodes[i].m_v = btVector3(0, 1, 0).cross(cloth->m_nodes[i].m_x);
    const double start = SpinOf(world);
    int zoneNodes = 0;
    for (int step = 0; step < 10; step++)
    {
        world.Step();
        CheckStep(world);
        zoneNodes += world.softSolver.getStatistics().zoneNodes;
    }
    // The touching rows of both are zones in each step. They keep four fifths of the spin, and would keep a quarter if
    // zones did not rotate.
    ck_assert_int_gt(zoneNodes, 500);
    ck_assert_double_gt(SpinOf(world), start / 2);
}
END_TEST

// Their corners hold both on the wrong sides for ever: untangling strains links in each step.
START_TEST(pinned_cloths_that_cross_are_not_shaken)
{
    const btScalar perSecond = btScalar(240);
    for (int run = 0; run < 6; run++)
    {
        qcTangledWorld world(10);
        for (int i = 0; i < 2; i++)
        {
            btSoftBody* cloth = world.AddCloth(btScalar(0.9), btScalar(0.9), 18, 18);
            for (int corner : {0, 17, 17 * 18, 18 * 18 - 1})
                cloth->setMass(corner, 0);
            cloth->m_cfg.piterations = 1 + run % 3 * 2;
        }
        qcTurn(world.cloths[1], btVector3(1, btScalar(0.2 * run), 0).normalized(), SIMD_HALF_PI,
               btVector3(btScalar(0.11), btScalar(0.1 * run), btScalar(0.07)));
        ck_assert_uint_gt(CountTangled(world), 20);
        auto energyOf = [&world]()
        {
            btScalar energy = world.Energy();
            for (const btSoftBody* cloth : world.cloths)
                for (int i = 0; i < cloth->m_nodes.size(); i++)
                    if (cloth->m_nodes[i].m_im > 0)
                        energy += 10 * cloth->m_nodes[i].m_x.y() / cloth->m_nodes[i].m_im;
            return energy;
        };
        const btScalar start = energyOf();
        btScalar most = start, speed = 0;
        for (int step = 0; step < 240; step++)
        {
            world.world.stepSimulation(1 / perSecond, 0);
            most = btMax(most, energyOf());
            speed = btMax(speed, world.MaxSpeed());
        }
        printf("run %d: gains %.2f J, up to %.1f m/s\n", run, double(most - start), double(speed));
        ck_assert_double_lt(double(most - start), 0.2);
        ck_assert_double_lt(double(speed), 12);
    }
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("soft tangles");
    qcAddLoop(tests, what_starts_tangled_comes_apart_and_is_not_thrown, s_sceneCount);
    qcAddLoop(tests, nothing_passes_away_from_a_tangle, s_sceneCount);
    tcase_add_test(tests, the_smaller_part_goes_back_to_the_side_of_the_larger_one);
    tcase_add_test(tests, tangles_stay_where_the_setting_is_off);
    tcase_add_test(tests, the_setting_changes_nothing_where_nothing_is_tangled);
    tcase_add_test(tests, a_tangle_with_a_free_mesh_keeps_momentum);
    tcase_add_loop_test(tests, surfaces_that_touch_at_the_start_come_apart, 0, 2);
    tcase_add_test(tests, cloths_that_cross_along_common_positions_fall_freely_and_come_apart);
    tcase_add_test(tests, cloths_that_move_as_one_keep_spinning);
    tcase_add_test(tests, pinned_cloths_that_cross_are_not_shaken);
    return qcRunCase("soft tangles", tests);
}
