// Contact of meshes in Bullet worlds: queries, points, statistics, and changes between steps.
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>

#include "bullet/mesh/mesh_world.h"
#include "support/soups.h"

namespace
{
/// Collects the results of contactTest and contactPairTest.
struct Gatherer : btCollisionWorld::ContactResultCallback
{
    int points = 0;
    double deepest = 1e9;
    btVector3 towardsFirst{0, 0, 0}; ///< normal of the deepest point, as it pushes the first body
    const btCollisionObject* first = nullptr;

    btScalar addSingleResult(btManifoldPoint& point, const btCollisionObjectWrapper* body0, int, int,
                             const btCollisionObjectWrapper*, int, int) override
    {
        points++;
        if (double(point.getDistance()) < deepest)
        {
            deepest = double(point.getDistance());
            bool same = body0->getCollisionObject() == first;
            towardsFirst = same ? point.m_normalWorldOnB : -point.m_normalWorldOnB;
        }
        return 0;
    }
};

START_TEST(contact_tests_use_present_transforms)
{
    qcMeshWorld world;
    btRigidBody* floor = world.Add(world.StaticMesh(qcFloorModel(4, 8)), 0, btVector3(0, 0, 0));
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* low = world.Add(shape, 1, btVector3(0, btScalar(0.51), 0));
    btRigidBody* high = world.Add(shape, 1, btVector3(0, btScalar(1.53), 0));
    world.Step();
    uint64_t batches = world.contact.getStatistics().batches;
    // Moved by hand: 2 mm into each other, 3 cm beyond both margins, apart.
    const double gaps[] = {0.018, -0.03, 0.5};
    for (double gap : gaps)
    {
        btTransform place = low->getWorldTransform();
        place.getOrigin() += btVector3(btScalar(0.1), btScalar(1 + gap), btScalar(0.2));
        high->setWorldTransform(place);
        btRigidBody* orders[2][2] = {{low, high}, {high, low}};
        for (auto& order : orders)
        {
            Gatherer gatherer;
            gatherer.first = high;
            world.world.contactPairTest(order[0], order[1], gatherer);
            ck_assert_int_eq(gatherer.points > 0, gap < 0.1);
            if (gap > 0.1)
                continue;
            ck_assert_double_eq_tol(gatherer.deepest, gap - 0.02, 1e-3);
            ck_assert_double_gt(double(gatherer.towardsFirst.y()), 0.99);
        }
    }
    Gatherer far;
    far.first = high;
    far.m_closestDistanceThreshold = 1;
    world.world.contactPairTest(low, high, far);
    ck_assert_double_eq_tol(far.deepest, 0.48, 1e-3);
    Gatherer all;
    all.first = low;
    world.world.contactTest(low, all);
    ck_assert_int_ge(all.points, 4);
    ck_assert_double_eq_tol(all.deepest, double(low->getWorldTransform().getOrigin().y()) - 0.51, 1e-3);
    ck_assert_double_gt(double(all.towardsFirst.y()), 0.99);
    // Pairs with a convex shape are Bullet's.
    btBoxShape box(btVector3(1, 1, 1));
    btCollisionObject convex;
    convex.setCollisionShape(&box);
    convex.setWorldTransform(btTransform(btQuaternion::getIdentity(),
                                         low->getWorldTransform().getOrigin() + btVector3(0, btScalar(1.5), 0)));
    Gatherer touching;
    world.world.contactPairTest(&convex, low, touching);
    ck_assert_double_eq_tol(touching.deepest, -0.01, 1e-3);
    // An object in no world.
    btCollisionObject probe;
    probe.setCollisionShape(shape);
    probe.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(3, btScalar(0.5), 3)));
    Gatherer found;
    found.first = &probe;
    world.world.contactPairTest(&probe, floor, found);
    ck_assert_double_eq_tol(found.deepest, -0.01, 1e-3);
    ck_assert_uint_eq(world.contact.getStatistics().batches, batches);
    ck_assert_int_eq(world.contact.getStatistics().status, qc_statusOk);
}
END_TEST

/// Distance of a point from the box around a triangle.
double DistanceFromBox(const qcModel& model, uint32_t triangle, const btVector3& point)
{
    btVector3 lower = model.Corner(triangle, 0), upper = lower, nearest = point;
    for (uint32_t c = 1; c < 3; c++)
    {
        lower.setMin(model.Corner(triangle, c));
        upper.setMax(model.Corner(triangle, c));
    }
    nearest.setMax(lower);
    nearest.setMin(upper);
    return double((point - nearest).length());
}

START_TEST(normals_point_from_the_second_body_to_the_first)
{
    // The floor before and after the cube, and above it.
    for (int order = 0; order < 2; order++)
        for (int plane = 0; plane < 2; plane++)
        {
            qcMeshWorld world;
            if (order == 0)
                qcAddFloor(world, plane ? qc_floorPlane : qc_floorStatic);
            qcModel model = qcCubeModel();
            btRigidBody* cube = world.Add(world.Keep(model.MakeShape()), 1, btVector3(0, btScalar(0.51), 0));
            if (order == 1)
                qcAddFloor(world, plane ? qc_floorPlane : qc_floorStatic);
            world.Step(2);
            ck_assert_int_eq(world.dispatcher.getNumManifolds(), 1);
            const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(0);
            ck_assert_int_eq(manifold->getNumContacts(), 4);
            for (int i = 0; i < 4; i++)
            {
                const btManifoldPoint& point = manifold->getContactPoint(i);
                double up = manifold->getBody0()->isStaticObject() ? -1 : 1;
                ck_assert_double_eq_tol(double(point.m_normalWorldOnB.y()), up, 1e-3);
                btVector3 gap = point.m_positionWorldOnA - point.m_positionWorldOnB;
                ck_assert_double_eq_tol(double(gap.dot(point.m_normalWorldOnB)), double(point.getDistance()), 1e-5);
                ck_assert_int_eq(point.getLifeTime(), 2);
                // The point lies on the margin of the reported triangle.
                bool cubeFirst = !manifold->getBody0()->isStaticObject();
                int triangle = cubeFirst ? point.m_index0 : point.m_index1;
                btVector3 onCube = cubeFirst ? point.m_positionWorldOnA : point.m_positionWorldOnB;
                ck_assert_int_ge(triangle, 0);
                ck_assert_double_lt(
                    DistanceFromBox(model, uint32_t(triangle), cube->getWorldTransform().invXform(onCube)), 0.0101);
            }
        }
}
END_TEST

START_TEST(children_of_a_compound_have_no_contact_with_each_other)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorOurs);
    btCollisionShape* cube = world.Keep(qcCubeModel().MakeShape());
    auto* compound = new btCompoundShape;
    for (int i = 0; i < 3; i++)
        compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.4 * i), 0, 0)), cube);
    world.Keep(std::unique_ptr<btCollisionShape>(compound));
    btRigidBody* first = world.Add(compound, 1, btVector3(0, btScalar(0.51), 0));
    btRigidBody* second = world.Add(compound, 1, btVector3(0, btScalar(0.51), 2));
    world.Step(5);
    // Each of the six cubes with the floor.
    ck_assert_int_eq(world.contact.getStatistics().bodies, 7);
    ck_assert_int_eq(world.contact.getStatistics().manifolds, 6);
    // Two compounds have contact.
    second->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(1.515), 0)));
    second->activate();
    first->activate();
    world.Step();
    ck_assert_int_gt(world.contact.getStatistics().manifolds, 3 + 3);
}
END_TEST

/// A cube on a corner, `depth` below height 0, somewhere over tiles.
btTransform CornerPlace(const qcModel& cube, qcRandom* random, btScalar depth)
{
    btScalar any[5];
    for (btScalar& x : any)
        x = btScalar(qcRandom_Uniform(random, -1, 1));
    btTransform place(btQuaternion(any[0], any[1], any[2]), btVector3(any[3], 0, any[4]));
    btScalar lowest = 0;
    for (uint32_t i = 0; i < 3 * cube.TriangleCount(); i++)
        lowest = std::min(lowest, (place * cube.Corner(i / 3, i % 3)).y());
    place.getOrigin().setY(-lowest - depth);
    return place;
}

START_TEST(the_deepest_point_is_in_a_manifold_whatever_lies_beside_it)
{
    // A Bullet manifold replaces a point by another one that is near it on its first body.
    const btScalar margin = btScalar(0.001);
    qcModel cube = qcCubeModel(1), floor = qcFloorModel(4, 40);
    for (uint64_t seed = 0; seed < 200; seed++)
    {
        qcRandom random = {seed};
        qcMeshWorld world;
        btCollisionShape *cubeShape = world.Keep(cube.MakeShape(margin)),
                         *floorShape = world.Keep(floor.MakeShape(margin));
        btScalar depth = btScalar(qcRandom_Uniform(&random, 0.002, 0.015));
        btTransform place = CornerPlace(cube, &random, depth);
        for (int i = 0; i < 2; i++)
            if ((i == 0) == (seed % 2 == 0))
                world.Add(floorShape, 0, btVector3(0, 0, 0));
            else
                world.Add(cubeShape, 1, place);
        world.world.performDiscreteCollisionDetection();
        double deepest = qcContactsOf(world.dispatcher).deepest, expected = -double(depth + 2 * margin);
        if (!(std::abs(deepest - expected) <= 1e-5))
            ck_abort_msg("seed %d: %g deep, not %g", int(seed), -deepest, -expected);
    }
}
END_TEST

START_TEST(a_crate_put_into_one_of_equal_height_is_pushed_out_sideways)
{
    // All triangles of the two touch or lie in one plane.
    qcMeshWorld world;
    world.Add(world.Keep(std::unique_ptr<btCollisionShape>(new btStaticPlaneShape(btVector3(0, 1, 0), 0))), 0,
              btVector3(0, 0, 0));
    qcModel cube = qcCubeModel(1);
    btCollisionShape* shape = world.Keep(cube.MakeShape());
    const btScalar height = btScalar(0.51);
    world.Add(shape, 0, btVector3(0, height, 0));
    btRigidBody* body = world.Add(shape, 1, btVector3(btScalar(0.95), height, 0));
    for (int step = 0; step < 120; step++)
    {
        world.Step(1);
        const btVector3& place = body->getWorldTransform().getOrigin();
        ck_assert_double_eq_tol(double(place.y()), double(height), 0.01);
        ck_assert_double_eq_tol(double(place.z()), 0, 0.01);
    }
    ck_assert_double_eq_tol(double(body->getWorldTransform().getOrigin().x()), 1.02, 5e-3);
}
END_TEST

START_TEST(gimpact_pairs_can_be_taken_over)
{
    qcMeshWorld world;
    world.contact.takeOverGImpact();
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.GImpact(qcCubeModel(), btScalar(0.01));
    for (int i = 0; i < 3; i++)
        world.Add(shape, 1, btVector3(btScalar(0.05 * i), btScalar(0.6 + 1.1 * i), 0));
    world.Step(240);
    ck_assert_uint_gt(world.contact.getStatistics().batches, 5);
    for (int i = 0; i < 3; i++)
        ck_assert_double_eq_tol(double(world.bodies[size_t(1 + i)]->getWorldTransform().getOrigin().y()),
                                0.51 + 1.02 * i, 3e-3);
    Gatherer gatherer;
    gatherer.first = world.bodies[2].get();
    world.world.contactPairTest(world.bodies[1].get(), world.bodies[2].get(), gatherer);
    ck_assert_int_ge(gatherer.points, 4);
    ck_assert_double_eq_tol(gatherer.deepest, 0, 1e-3);
}
END_TEST

START_TEST(one_query_a_step_covers_all_pairs)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcCubeModel(1).MakeShape());
    for (int i = 0; i < 40; i++)
        world.Add(shape, 1, btVector3(btScalar(i % 5) - 2, btScalar(0.6 + 1.05 * (i / 5)), 0))
            ->setActivationState(DISABLE_DEACTIVATION);
    for (int i = 1; i <= 30; i++)
    {
        world.Step();
        ck_assert_uint_le(world.contact.getStatistics().batches, uint64_t(i));
    }
    ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
    ck_assert_int_eq(world.contact.getStatistics().bodies, 41);
}
END_TEST

START_TEST(a_body_replaced_by_pieces_between_two_steps_costs_one_query)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, 2, 0));
    world.Step(20);
    btVector3 center = world.bodies.back()->getWorldTransform().getOrigin();
    world.world.removeRigidBody(world.bodies.back().get());
    world.bodies.pop_back();
    world.shapes.pop_back(); // shapes of the pieces may get its address
    btVector3 half(btScalar(0.09), btScalar(0.09), btScalar(0.09));
    for (int i = 0; i < 64; i++)
    {
        btVector3 place = btVector3(btScalar(i % 4), btScalar(i / 4 % 4), btScalar(i / 16)) * btScalar(0.2);
        btCollisionShape* shape = world.Keep(qcBoxModel(half, 1).MakeShape());
        world.Add(shape, btScalar(0.008), center + place)->setActivationState(DISABLE_DEACTIVATION);
    }
    uint64_t batches = world.contact.getStatistics().batches;
    world.Step();
    ck_assert_uint_eq(world.contact.getStatistics().batches, batches + 1);
    ck_assert_int_eq(world.contact.getStatistics().bodies, 64); // the floor is too far
    // Each of the 144 inner faces has contact.
    ck_assert_int_ge(world.dispatcher.getNumManifolds(), 144);
    world.Step(60);
    for (size_t i = 1; i < world.bodies.size(); i++)
        ck_assert_double_gt(double(world.bodies[i]->getWorldTransform().getOrigin().y()), 0.05);
}
END_TEST

START_TEST(a_shape_may_be_scaled_while_it_rests)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, btScalar(0.6), 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    world.Step(60);
    shape->setLocalScaling(btVector3(2, btScalar(0.5), 2));
    world.Step(120);
    ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), 0.26, 1e-3);
}
END_TEST

START_TEST(margins_may_change_while_bodies_rest)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = world.Add(shape, 1, btVector3(0, btScalar(0.51), 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    world.Step(60);
    shape->setMargin(btScalar(0.1));
    world.Step(120);
    ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), 0.6, 1e-3);
    // The query for all pairs has the new margin: no pair is queried by itself.
    ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
}
END_TEST

START_TEST(bodies_rest_at_the_sum_of_different_margins)
{
    for (int way = 0; way < 4; way++)
    {
        // The thick one is the cube or the floor, and the first or the second in the world.
        const btScalar margins[2] = {way % 2 == 0 ? btScalar(0.2) : btScalar(0.01),
                                     way % 2 == 0 ? btScalar(0.01) : btScalar(0.2)};
        qcMeshWorld world;
        btCollisionShape *cubeShape = world.Keep(qcCubeModel().MakeShape(margins[0])),
                         *floorShape = world.Keep(qcFloorModel(4, 40).MakeShape(margins[1]));
        btRigidBody *cube = nullptr, *floor = nullptr;
        for (int i = 0; i < 2; i++)
            if (i == way / 2)
                cube = world.Add(cubeShape, 1, btVector3(0, btScalar(0.72), 0));
            else
                floor = world.Add(floorShape, 0, btVector3(0, 0, 0));
        cube->setActivationState(DISABLE_DEACTIVATION);
        btScalar lowest = 1;
        for (int step = 0; step < 60; step++)
        {
            world.Step();
            lowest = std::min(lowest, cube->getWorldTransform().getOrigin().y());
        }
        double rest = 0.5 + 0.21 + double(floor->getWorldTransform().getOrigin().y());
        ck_assert_double_eq_tol(double(cube->getWorldTransform().getOrigin().y()), rest, 1e-3);
        ck_assert_double_gt(double(lowest), rest - 2e-3);
        ck_assert_uint_eq(world.contact.getStatistics().queries, 0);
    }
}
END_TEST

/// The lowest height of a cloth's node, ever, while it falls on a floor at height 0.
double LowestNode(btCollisionShape* floor)
{
    qcMeshContact contact;
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    contact.addTo(&world);
    world.getWorldInfo().m_gravity = world.getGravity();
    btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(0, nullptr, floor));
    world.addRigidBody(&body);
    btScalar h = btScalar(0.8), y = btScalar(0.3);
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-h, y, -h), btVector3(h, y, -h),
                                                       btVector3(-h, y, h), btVector3(h, y, h), 20, 20, 0, true);
    cloth->getCollisionShape()->setMargin(btScalar(0.1));
    cloth->setTotalMass(btScalar(0.5));
    world.addSoftBody(cloth);
    double lowest = 1e9;
    for (int i = 0; i < 120; i++)
    {
        world.stepSimulation(qcStep / 2, 0);
        for (int n = 0; n < cloth->m_nodes.size(); n++)
            lowest = std::min(lowest, double(cloth->m_nodes[n].m_x.y()));
    }
    world.removeSoftBody(cloth);
    delete cloth;
    world.removeRigidBody(&body);
    return lowest;
}

START_TEST(a_soft_body_lies_on_a_mesh_as_on_bullets_static_mesh)
{
    // Large triangles: Bullet's signed distances have cells of 0.25.
    qcModel model = qcFloorModel(2, 2);
    auto ours = model.MakeShape(0);
    auto mesh = model.MakeInterface();
    btBvhTriangleMeshShape bullets(mesh.get(), true);
    double expected = LowestNode(&bullets);
    ck_assert_double_gt(expected, -0.1);
    ck_assert_double_eq_tol(LowestNode(ours.get()), expected, 0.01);
}
END_TEST

START_TEST(the_same_calls_give_the_same_trajectories)
{
    std::vector<btVector3> places[2];
    for (auto& out : places)
    {
        qcMeshWorld world;
        world.Add(world.StaticMesh(qcBinModel(btScalar(0.9), 4)), 0, btVector3(0, 0, 0));
        btCollisionShape* shape = world.Keep(qcTorusModel(0.4, 0.15, 16, 8).MakeShape());
        for (int i = 0; i < 6; i++)
        {
            world.Add(shape, 1, btVector3(btScalar(0.1 * i), btScalar(0.7 + 0.5 * i), 0));
            world.Step(20);
            if (i == 3)
            {
                world.world.removeRigidBody(world.bodies[2].get());
                world.bodies.erase(world.bodies.begin() + 2);
            }
        }
        world.Step(60);
        for (auto& body : world.bodies)
            out.push_back(body->getWorldTransform().getOrigin());
    }
    ck_assert_uint_eq(places[0].size(), 6);
    for (size_t i = 0; i < places[0].size(); i++)
        for (int axis = 0; axis < 3; axis++)
            ck_assert(places[0][i][axis] == places[1][i][axis]);
}
END_TEST

START_TEST(methods_that_miss_pairs_are_refused)
{
    qcMeshContact contact;
    ck_assert_int_eq(contact.setMethod(qc_methodQuick), qc_statusBadInput);
    ck_assert_int_eq(contact.setMethod(qc_methodCullide), qc_statusBadInput);
    ck_assert_int_eq(contact.setMethod(qcMethod(7)), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshContact::setMethod: unknown method 7");
    ck_assert_int_eq(contact.setMethod(qc_methodSweep), qc_statusOk);
}
END_TEST

START_TEST(contact_is_added_once_to_a_world_that_can_have_it)
{
    qcMeshContact contact;
    ck_assert_int_eq(contact.addTo(nullptr), qc_statusBadInput);
    ck_assert_int_eq(contact.takeOverGImpact(), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshContact::takeOverGImpact: it has no world yet");
    btDefaultCollisionConfiguration configuration;
    qcBroadphase broadphase;
    btCollisionWorld undispatched(nullptr, &broadphase, &configuration);
    ck_assert_int_eq(contact.addTo(&undispatched), qc_statusBadInput);
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase other;
    btCollisionWorld world(&dispatcher, &other, &configuration);
    ck_assert_int_eq(contact.addTo(&world), qc_statusOk);
    ck_assert_int_eq(contact.takeOverGImpact(), qc_statusOk);
    ck_assert_int_eq(contact.addTo(&world), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshContact::addTo: it has a world already");
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_contact", contact_tests_use_present_transforms, normals_point_from_the_second_body_to_the_first,
             children_of_a_compound_have_no_contact_with_each_other,
             the_deepest_point_is_in_a_manifold_whatever_lies_beside_it,
             a_crate_put_into_one_of_equal_height_is_pushed_out_sideways, gimpact_pairs_can_be_taken_over,
             one_query_a_step_covers_all_pairs, a_body_replaced_by_pieces_between_two_steps_costs_one_query,
             a_shape_may_be_scaled_while_it_rests, margins_may_change_while_bodies_rest,
             bodies_rest_at_the_sum_of_different_margins, a_soft_body_lies_on_a_mesh_as_on_bullets_static_mesh,
             the_same_calls_give_the_same_trajectories, methods_that_miss_pairs_are_refused,
             contact_is_added_once_to_a_world_that_can_have_it)
