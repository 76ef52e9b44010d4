// Meshes at rest and sliding. The long form prints what btGImpactMeshShape does in equal scenes. The pile of bunnies is
// left out where their file is missing.
#include "bullet/add_loop.h"
#include "bullet/mesh/mesh_world.h"
#include "support/long_form.h"

#ifdef QC_BUNNY
#include "bullet/mesh/mesh_bunny.h"
#endif

namespace
{
START_TEST(a_mesh_cube_rests_on_any_floor)
{
    qcFloor floor = qcFloor(_i);
    qcMeshWorld world;
    btScalar margin = qcAddFloor(world, floor);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(btScalar(0.1), 1, btScalar(0.2)));
    cube->setActivationState(DISABLE_DEACTIVATION);
    double deepest = 0;
    for (int i = 0; i < 180; i++)
    {
        world.Step();
        deepest = std::min(deepest, double(cube->getWorldTransform().getOrigin().y()) - 0.5);
    }
    double rest = 0.5 + 0.01 + double(margin);
    ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), rest, 1e-3);
    ck_assert_double_gt(deepest, -1e-4); // the triangles never touch: only the margins do
    ck_assert_double_lt(world.KineticEnergy(), 1e-6);
    qcWorldContacts contacts = qcContactsOf(world.dispatcher);
    ck_assert_int_eq(contacts.points, 4);
    ck_assert_double_gt(contacts.deepest, -1e-3);
    ck_assert_int_eq(world.contact.getStatistics().batches > 0, floor != qc_floorPlane);
}
END_TEST

START_TEST(a_fast_cube_is_stopped_on_a_plane_not_in_it)
{
    // Up to 8 cm a step, with a threshold of 1.7 cm.
    for (int i = 0; i < 20; i++)
    {
        qcMeshWorld world;
        qcAddFloor(world, qc_floorPlane);
        btRigidBody* cube =
            world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.6 + 0.013 * i), 0));
        cube->setLinearVelocity(btVector3(0, -5, 0));
        for (int step = 0; step < 20; step++)
        {
            world.Step();
            ck_assert_double_gt(double(cube->getWorldTransform().getOrigin().y()), 0.51 - 1e-4);
        }
    }
}
END_TEST

START_TEST(a_resting_cube_falls_asleep_and_costs_nothing)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.6), 0));
    world.Step(240);
    ck_assert(!cube->isActive());
    uint64_t batches = world.contact.getStatistics().batches;
    world.Step(10);
    ck_assert_uint_eq(world.contact.getStatistics().batches, batches);
}
END_TEST

START_TEST(bullets_convex_shapes_rest_on_a_mesh_and_a_mesh_on_them)
{
    qcMeshWorld world;
    world.Add(world.Keep(qcFloorModel(20, 20).MakeShape()), 0, btVector3(0, 0, 0));
    btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
    auto* hull = new btConvexHullShape;
    for (int i = 0; i < 8; i++)
        hull->addPoint(
            btVector3(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(), i & 4 ? half.z() : -half.z()));
    btCollisionShape* convex[] = {new btBoxShape(half), hull, new btCylinderShape(half), new btSphereShape(half.x())};
    btCollisionShape* mesh = world.Keep(qcCubeModel().MakeShape());
    std::vector<btRigidBody*> low, high;
    for (int i = 0; i < 4; i++)
    {
        world.Keep(std::unique_ptr<btCollisionShape>(convex[i]));
        low.push_back(world.Add(convex[i], 1, btVector3(btScalar(3 * i), btScalar(0.6), 0)));
        if (i == 3)
            continue; // nothing rests on a ball
        world.Add(convex[i], 0, btVector3(btScalar(3 * i), btScalar(0.5), 5));
        high.push_back(world.Add(mesh, 1, btVector3(btScalar(3 * i), btScalar(1.6), 5)));
    }
    for (auto& body : world.bodies)
        body->setActivationState(DISABLE_DEACTIVATION);
    low[3]->setRollingFriction(btScalar(0.1));
    world.Step(300);
    ck_assert_double_lt(world.KineticEnergy(), 1e-2);
    ck_assert_double_gt(qcContactsOf(world.dispatcher).deepest, -0.01);
    // A hull has Bullet's margin of 0.04 outside.
    for (btRigidBody* body : low)
        ck_assert_double_eq_tol(double(body->getWorldTransform().getOrigin().y()), 0.51, 0.045);
    for (btRigidBody* body : high)
        ck_assert_double_eq_tol(double(body->getWorldTransform().getOrigin().y()), 1.51, 0.045);
}
END_TEST

/// Steps a world and returns its outcome.
void Report(qcMeshWorld& world, const char* what, double ms)
{
    qcWorldContacts contacts = qcContactsOf(world.dispatcher);
    printf("%s: energy %.2g J, deepest %.4f m, %d points, %.2f ms a step\n", what, world.KineticEnergy(),
           contacts.deepest, contacts.points, ms);
}

struct Outcome
{
    double energy, deepest, ms;
    std::vector<btVector3> places;
};

constexpr int s_binSteps = 1200;

/// Five bodies in a bin, after twenty seconds: one that balances on another may tip over late, here after 12 to 14.
Outcome RunBin(const qcModel& model, bool gimpact)
{
    qcMeshWorld world;
    world.Add(world.StaticMesh(qcBinModel(btScalar(0.9), 4)), 0, btVector3(0, 0, 0));
    btCollisionShape* shape = gimpact ? world.GImpact(model, btScalar(0.01)) : world.Keep(model.MakeShape());
    for (int i = 0; i < 5; i++)
    {
        btVector3 place(btScalar(0.15 * (i % 3) - 0.15), btScalar(0.7 + 1.05 * i), btScalar(0.1 * (i % 2)));
        btRigidBody* body = world.Add(shape, 1, place);
        body->setActivationState(DISABLE_DEACTIVATION);
        body->setRollingFriction(btScalar(0.01));
        body->setSpinningFriction(btScalar(0.01));
    }
    Outcome outcome = {0, 0, 0, {}};
    for (int i = 0; i < s_binSteps; i++)
    {
        world.Step();
        outcome.ms += world.stepMs / s_binSteps;
        if (i > s_binSteps / 2)
            outcome.deepest = std::min(outcome.deepest, qcContactsOf(world.dispatcher).deepest);
    }
    Report(world, gimpact ? "  GImpact" : "  qcMeshShape", outcome.ms);
    outcome.energy = world.KineticEnergy();
    for (auto& body : world.bodies)
        outcome.places.push_back(body->getWorldTransform().getOrigin());
    return outcome;
}

void CheckBin(const qcModel& model, const char* name)
{
    printf("five %s in a bin\n", name);
    if (qcIsLongForm())
        RunBin(model, true);
    Outcome ours = RunBin(model, false);
    ck_assert_double_lt(ours.energy, 1e-2);
    ck_assert_double_gt(ours.deepest, -0.01); // the margin of one
    for (const btVector3& place : ours.places)
        ck_assert(place.y() > btScalar(-0.01) && btFabs(place.x()) < 1 && btFabs(place.z()) < 1);
}

START_TEST(five_meshes_in_a_bin_come_to_rest)
{
    qcModel models[] = {qcSphereModel(0.5, 2), qcCubeModel(2), qcTorusModel(0.4, 0.15, 16, 8)};
    const char* names[] = {"spheres", "cubes", "tori"};
    CheckBin(models[_i], names[_i]);
}
END_TEST

#ifdef QC_BUNNY
START_TEST(five_bunnies_in_a_bin_come_to_rest)
{
    CheckBin(qcBunnyModel(QC_BUNNY), "bunnies");
}
END_TEST
#endif

START_TEST(a_chain_of_tori_never_comes_apart_and_comes_to_rest)
{
    printf("a chain of three tori\n");
    for (int gimpact = qcIsLongForm() ? 1 : 0; gimpact >= 0; gimpact--)
    {
        qcMeshWorld world;
        qcModel model = qcTorusModel(0.5, 0.12, 20, 10);
        btCollisionShape* shape = gimpact ? world.GImpact(model, btScalar(0.01)) : world.Keep(model.MakeShape());
        std::vector<qcPlacedModel> links;
        for (int i = 0; i < 4; i++)
        {
            btQuaternion turn(btVector3(1, 0, 0), i % 2 == 0 ? btScalar(0) : SIMD_HALF_PI);
            btRigidBody* link = world.Add(shape, i == 0 ? 0 : 1, btTransform(turn, btVector3(btScalar(0.7 * i), 0, 0)));
            link->setActivationState(DISABLE_DEACTIVATION);
            link->setDamping(btScalar(0.7), btScalar(0.7));
            links.push_back({&model, link});
        }
        double ms = 0;
        for (int i = 0; i < 600; i++)
        {
            world.Step();
            ms += world.stepMs / 600;
            if (i % 20 == 0 && !gimpact)
                ck_assert_uint_eq(qcCountPenetrating(links), 0);
        }
        Report(world, gimpact ? "  GImpact" : "  qcMeshShape", ms);
        if (gimpact)
            continue;
        ck_assert_double_lt(world.KineticEnergy(), 1e-2);
        // Inside the first ring, which lies flat, hangs the top of the second one's tube, and so on.
        for (int i = 1; i < 4; i++)
            ck_assert_double_eq_tol(double(links[size_t(i)].body->getWorldTransform().getOrigin().y()),
                                    -0.24 - 0.74 * (i - 1), 0.03);
    }
}
END_TEST

START_TEST(a_long_step_throws_no_pile_into_the_air)
{
    // Contact has taken the step's gravity from what rests: limits, which move it a little, don't take it once more.
    int limited = 0;
    for (btScalar step : {btScalar(0.25), btScalar(0.5)})
    {
        qcMeshWorld world;
        world.Add(world.Keep(qcFloorModel(20, 20).MakeShape()), 0, btVector3(0, 0, 0));
        const btVector3 half(btScalar(0.3), btScalar(0.2), btScalar(0.25));
        btCollisionShape* shape = world.Keep(qcBoxModel(half, 2).MakeShape());
        for (int i = 0; i < 2; i++)
            world.Add(shape, 1, btVector3(0, btScalar(0.4 + 0.45 * i), 0))->setActivationState(DISABLE_DEACTIVATION);
        world.Step(200);
        world.world.stepSimulation(step, 0);
        limited += world.contact.getStatistics().limited;
        for (size_t i = 1; i < world.bodies.size(); i++)
            ck_assert_double_lt(double(world.bodies[i]->getLinearVelocity().y()), 0.1);
    }
    ck_assert_int_gt(limited, 0);
}
END_TEST

START_TEST(a_cube_slides_over_inner_edges_as_over_a_plane)
{
    // Along an edge, and across all of them.
    const btVector3 ways[] = {btVector3(3, 0, 0), btVector3(3, 0, btScalar(0.5)), btVector3(2, 0, 2)};
    for (const btVector3& way : ways)
    {
        qcMeshWorld world;
        world.Add(world.StaticMesh(qcFloorModel(8, 20)), 0, btVector3(0, 0, 0))->setFriction(0);
        btRigidBody* cube =
            world.Add(world.Keep(qcCubeModel(3).MakeShape()), 1, btVector3(-6, btScalar(0.511), -way.z() * 3));
        cube->setActivationState(DISABLE_DEACTIVATION);
        cube->setFriction(0);
        world.Step(30);
        cube->setLinearVelocity(way);
        btVector3 start = cube->getWorldTransform().getOrigin();
        for (int i = 0; i < 180; i++)
        {
            world.Step();
            ck_assert_double_lt(double((cube->getLinearVelocity() - way).length()), 0.01 * double(way.length()));
            ck_assert_double_lt(double(cube->getAngularVelocity().length()), 0.01);
            ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), 0.51, 2e-3);
        }
        btVector3 went = cube->getWorldTransform().getOrigin() - start;
        ck_assert_double_eq_tol(double(went.length()), double(way.length()) * 3, 0.03 * double(way.length()));
    }
}
END_TEST

START_TEST(walls_of_a_corner_have_manifolds_of_their_own)
{
    qcMeshWorld world;
    world.Add(world.StaticMesh(qcBinModel(2, 3)), 0, btVector3(0, 0, 0));
    // A cube in the corner of the bin, touching three sides.
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1,
                                  btVector3(btScalar(-1.49), btScalar(0.51), btScalar(-1.49)));
    world.Step(5);
    btManifoldArray manifolds;
    const btBroadphasePairArray& pairs = world.world.getPairCache()->getOverlappingPairArray();
    ck_assert_int_eq(pairs.size(), 1);
    pairs[0].m_algorithm->getAllContactManifolds(manifolds);
    ck_assert_int_eq(manifolds.size(), 3);
    for (int m = 0; m < 3; m++)
    {
        ck_assert_int_eq(manifolds[m]->getNumContacts(), 4);
        for (int i = 0; i < 4; i++)
            ck_assert_double_gt(double(btFabs(manifolds[m]->getContactPoint(i).m_normalWorldOnB[0]) +
                                       btFabs(manifolds[m]->getContactPoint(i).m_normalWorldOnB[1]) +
                                       btFabs(manifolds[m]->getContactPoint(i).m_normalWorldOnB[2])),
                                0.999);
    }
    // Lifted out, no manifold has a point left, and the end was reported.
    cube->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.5), 0)));
    cube->activate();
    world.Step();
    ck_assert_int_eq(qcContactsOf(world.dispatcher).points, 0);
}
END_TEST

START_TEST(compounds_with_mesh_children_rest_on_meshes_and_on_each_other)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* cube = world.Keep(qcCubeModel().MakeShape());
    auto* compound = new btCompoundShape;
    // One shape twice, and once turned in a compound of its own.
    auto* inner = new btCompoundShape;
    inner->addChildShape(btTransform(btQuaternion(btVector3(0, 1, 0), SIMD_HALF_PI), btVector3(0, 0, 0)), cube);
    compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(-1, 0, 0)), cube);
    compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(1, 0, 0)), inner);
    world.Keep(std::unique_ptr<btCollisionShape>(inner));
    world.Keep(std::unique_ptr<btCollisionShape>(compound));
    btRigidBody* low = world.Add(compound, 2, btVector3(0, btScalar(0.6), 0));
    btRigidBody* high = world.Add(
        compound, 2, btTransform(btQuaternion(btVector3(0, 1, 0), btScalar(0.3)), btVector3(0, btScalar(1.7), 0)));
    world.Step(300);
    ck_assert_double_lt(world.KineticEnergy(), 1e-3);
    ck_assert_double_eq_tol(double(low->getWorldTransform().getOrigin().y()), 0.51, 2e-3);
    ck_assert_double_eq_tol(double(high->getWorldTransform().getOrigin().y()), 1.53, 4e-3);
    ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_rest");
    qcAddLoop(tests, a_mesh_cube_rests_on_any_floor, qc_floorCount);
    qcAddLoop(tests, five_meshes_in_a_bin_come_to_rest, 3);
#ifdef QC_BUNNY
    tcase_add_test(tests, five_bunnies_in_a_bin_come_to_rest);
#endif
    tcase_add_test(tests, a_fast_cube_is_stopped_on_a_plane_not_in_it);
    tcase_add_test(tests, a_resting_cube_falls_asleep_and_costs_nothing);
    tcase_add_test(tests, bullets_convex_shapes_rest_on_a_mesh_and_a_mesh_on_them);
    tcase_add_test(tests, a_chain_of_tori_never_comes_apart_and_comes_to_rest);
    tcase_add_test(tests, a_long_step_throws_no_pile_into_the_air);
    tcase_add_test(tests, a_cube_slides_over_inner_edges_as_over_a_plane);
    tcase_add_test(tests, walls_of_a_corner_have_manifolds_of_their_own);
    tcase_add_test(tests, compounds_with_mesh_children_rest_on_meshes_and_on_each_other);
    return qcRunCase("mesh_rest", tests);
}
