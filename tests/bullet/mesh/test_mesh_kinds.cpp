// qcMeshShape in each kind of collision object, in worlds of several kinds, far from the origin, on several threads;
// impulses and lifetime of manifolds.
#include "bullet/mesh/mesh_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

#include <thread>

namespace
{
const btVector3 s_up(0, 1, 0);

double HeightOf(const btCollisionObject* object)
{
    return double(object->getWorldTransform().getOrigin().y());
}

START_TEST(a_kinematic_mesh_carries_a_mesh_up_and_down)
{
    qcMeshWorld world;
    btRigidBody* lift = world.Add(world.Keep(qcFloorModel(4, 8).MakeShape()), 0, btVector3(0, 0, 0));
    world.world.removeRigidBody(lift);
    lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift->setActivationState(DISABLE_DEACTIVATION);
    world.world.addRigidBody(lift);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, s_up * btScalar(0.52));
    btScalar height = 0;
    for (int i = 0; i < 240; i++)
    {
        const btScalar way = i < 120 ? btScalar(0.02) : btScalar(-0.01);
        height += way;
        lift->setWorldTransform(btTransform(btQuaternion::getIdentity(), s_up * height));
        world.Step();
        // The cube follows the lift with a delay of a step. Where the lift turns, it flies on for a while.
        ck_assert_double_gt(HeightOf(cube), double(height) + 0.49);
        if (i < 120)
            ck_assert_double_lt(HeightOf(cube), double(height) + 0.55);
    }
    world.Step(60);
    ck_assert_double_eq_tol(HeightOf(cube), double(height) + 0.51, 0.011);
}
END_TEST

START_TEST(a_ghost_with_a_mesh_finds_the_meshes_that_it_overlaps)
{
    btGhostPairCallback ghostPairs; // used until the world's end
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    world.world.getPairCache()->setInternalGhostPairCallback(&ghostPairs);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape());
    btRigidBody* cube = world.Add(shape, 1, s_up * btScalar(0.51));
    btPairCachingGhostObject ghost;
    ghost.setCollisionShape(shape);
    ghost.setCollisionFlags(ghost.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
    ghost.setWorldTransform(
        btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(1.4), btScalar(0.2))));
    world.world.addCollisionObject(&ghost, btBroadphaseProxy::SensorTrigger, btBroadphaseProxy::AllFilter);
    world.Step(10);
    ck_assert_int_eq(ghost.getNumOverlappingObjects(), 1);
    ck_assert_ptr_eq(ghost.getOverlappingObject(0), cube);
    // The query of a character controller.
    btHashedOverlappingPairCache* pairs = ghost.getOverlappingPairCache();
    world.dispatcher.dispatchAllCollisionPairs(pairs, world.world.getDispatchInfo(), &world.dispatcher);
    btManifoldArray manifolds;
    pairs->getOverlappingPairArray()[0].m_algorithm->getAllContactManifolds(manifolds);
    double deepest = 0;
    for (int m = 0; m < manifolds.size(); m++)
        for (int i = 0; i < manifolds[m]->getNumContacts(); i++)
            deepest = std::min(deepest, double(manifolds[m]->getContactPoint(i).getDistance()));
    ck_assert_double_eq_tol(deepest, -0.13, 5e-3);
    // A ghost has no response.
    ck_assert_double_eq_tol(HeightOf(cube), 0.51, 2e-3);
    world.world.removeCollisionObject(&ghost);
}
END_TEST

START_TEST(links_of_a_multibody_rest_on_a_mesh)
{
    qcMeshContact contact;
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btMultiBodyConstraintSolver solver;
    btMultiBodyDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    contact.addTo(&world);
    auto floor = qcFloorModel(4, 8).MakeShape(), cube = qcCubeModel().MakeShape();
    btRigidBody ground(0, nullptr, floor.get());
    world.addRigidBody(&ground);
    btVector3 inertia;
    cube->calculateLocalInertia(1, inertia);
    // Two cubes side by side, on an axle between them.
    btMultiBody body(1, 1, inertia, false, true);
    const btVector3 half(btScalar(0.6), 0, 0);
    body.setupRevolute(0, 1, inertia, -1, btQuaternion::getIdentity(), btVector3(0, 0, 1), half, half, true);
    body.finalizeMultiDof();
    body.setBasePos(s_up);
    world.addMultiBody(&body);
    btMultiBodyLinkCollider base(&body, -1), link(&body, 0);
    body.setBaseCollider(&base);
    body.getLink(0).m_collider = &link;
    for (btMultiBodyLinkCollider* collider : {&base, &link})
    {
        collider->setCollisionShape(cube.get());
        collider->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), s_up + (collider == &link ? btScalar(2) : btScalar(0)) * half));
        world.addCollisionObject(collider, 1, -1);
    }
    for (int i = 0; i < 240; i++)
        world.stepSimulation(qcStep, 0);
    ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    ck_assert_double_eq_tol(HeightOf(&base), 0.515, 0.01);
    ck_assert_double_eq_tol(HeightOf(&link), 0.515, 0.01);
    world.removeMultiBody(&body);
    world.removeCollisionObject(&base);
    world.removeCollisionObject(&link);
    world.removeRigidBody(&ground);
}
END_TEST

START_TEST(contact_far_from_the_origin_is_as_fine_as_btscalar)
{
    // The resolution there is a 16th of a millimetre in float, a tenth of a nanometre in double.
    const bool wide = sizeof(btScalar) == sizeof(double);
    const btVector3 origin = wide ? btVector3(1e6, 1e6, -1e6) : btVector3(1000, 1000, -1000);
    qcMeshWorld world;
    world.Add(world.Keep(qcFloorModel(4, 8).MakeShape()), 0, origin);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, origin + btVector3(0, btScalar(0.519), 0));
    world.world.performDiscreteCollisionDetection();
    qcWorldContacts contacts = qcContactsOf(world.dispatcher);
    ck_assert_int_eq(contacts.points, 4);
    ck_assert_double_eq_tol(contacts.deepest, -0.001, wide ? 1e-8 : 2e-4);
    world.Step(120);
    ck_assert_double_eq_tol(HeightOf(cube) - double(origin.y()), 0.5195, 1e-3);
}
END_TEST

double ImpulsesOf(btDispatcher& dispatcher)
{
    double sum = 0;
    for (int m = 0; m < dispatcher.getNumManifolds(); m++)
    {
        const btPersistentManifold* manifold = dispatcher.getManifoldByIndexInternal(m);
        for (int i = 0; i < manifold->getNumContacts(); i++)
            sum += double(manifold->getContactPoint(i).m_appliedImpulse);
    }
    return sum;
}

START_TEST(contact_points_found_again_keep_their_impulses)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorStatic);
    world.bodies[0]->setFriction(0);
    btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(-1, btScalar(0.51), 0));
    cube->setActivationState(DISABLE_DEACTIVATION);
    world.Step(10);
    cube->setLinearVelocity(btVector3(btScalar(0.3), 0, 0));
    double before = 0, after = 0;
    uint64_t batches = world.contact.getStatistics().batches;
    for (int step = 0; step < 30; step++)
    {
        world.Step();
        before += ImpulsesOf(world.dispatcher);
        world.world.performDiscreteCollisionDetection();
        after += ImpulsesOf(world.dispatcher);
    }
    ck_assert_uint_ge(world.contact.getStatistics().batches, batches + 30);
    ck_assert_double_eq_tol(before / 30, 10.0 / 60, 0.02); // the cube's weight
    ck_assert_double_gt(after, 0.9 * before);
}
END_TEST

START_TEST(manifolds_end_with_the_meshes)
{
    for (qcFloor floor : {qc_floorStatic, qc_floorPlane})
    {
        qcMeshWorld world;
        qcAddFloor(world, floor);
        btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, s_up * btScalar(0.51));
        for (int round = 0; round < 3; round++)
        {
            world.Step(2);
            ck_assert_int_ge(world.dispatcher.getNumManifolds(), 1);
            world.world.removeRigidBody(cube);
            ck_assert_int_eq(world.dispatcher.getNumManifolds(), 0);
            world.Step(2);
            world.world.addRigidBody(cube);
        }
    }
}
END_TEST

/// Heights of tori that have fallen into a heap.
std::vector<double> Pile()
{
    qcMeshWorld world;
    world.contact.setThreadCount(2);
    qcAddFloor(world, qc_floorStatic);
    btCollisionShape* shape = world.Keep(qcTorusModel(0.4, 0.15, 16, 8).MakeShape());
    for (int i = 0; i < 6; i++)
        world.Add(shape, 1, btVector3(btScalar(0.05 * i), btScalar(0.5 + 0.5 * i), 0));
    world.Step(60);
    std::vector<double> heights;
    for (const auto& body : world.bodies)
        heights.push_back(HeightOf(body.get()));
    return heights;
}

START_TEST(two_worlds_on_two_threads_move_as_one_alone)
{
    const std::vector<double> alone = Pile();
    std::vector<double> results[2][3];
    auto run = [&](int which)
    {
        for (std::vector<double>& result : results[which])
            result = Pile();
    };
    std::thread other(run, 1);
    run(0);
    other.join();
    for (const auto& thread : results)
        for (const std::vector<double>& result : thread)
            ck_assert(result == alone);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_kinds", a_kinematic_mesh_carries_a_mesh_up_and_down,
             a_ghost_with_a_mesh_finds_the_meshes_that_it_overlaps, links_of_a_multibody_rest_on_a_mesh,
             contact_far_from_the_origin_is_as_fine_as_btscalar, contact_points_found_again_keep_their_impulses,
             manifolds_end_with_the_meshes, two_worlds_on_two_threads_move_as_one_alone)
