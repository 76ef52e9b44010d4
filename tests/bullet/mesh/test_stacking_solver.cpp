// The solver for heaps: nothing is pressed into what stands still, no energy is gained, towers don't creep, and where
// nothing stands still or joints hold bodies it is Bullet's solver. Room that was made for contact points lasts.
#include "bullet/mesh/mesh_world.h"

namespace
{
constexpr btScalar s_shortStep = btScalar(1.0 / 240);

/// Boxes of 1 m or less on a plane, by Bullet alone.
struct BoxWorld
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    btDbvtBroadphase broadphase;
    btDiscreteDynamicsWorld world;
    btStaticPlaneShape plane{btVector3(0, 1, 0), 0};
    btRigidBody floor{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane)};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    explicit BoxWorld(btConstraintSolver* solver) : world(&dispatcher, &broadphase, solver, &configuration)
    {
        // Depth adds no speed.
        world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    }
    ~BoxWorld()
    {
        for (auto& body : bodies)
            world.removeRigidBody(body.get());
        if (floor.getBroadphaseHandle() != nullptr)
            world.removeRigidBody(&floor);
    }

    btRigidBody* Add(const btVector3& half, btScalar mass, const btTransform& place)
    {
        return Add(std::unique_ptr<btCollisionShape>(new btBoxShape(half)), mass, place);
    }

    btRigidBody* Add(std::unique_ptr<btCollisionShape> shape, btScalar mass, const btTransform& place)
    {
        shapes.push_back(std::move(shape));
        btVector3 inertia;
        shapes.back()->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shapes.back().get(), inertia);
        info.m_startWorldTransform = place;
        bodies.emplace_back(new btRigidBody(info));
        world.addRigidBody(bodies.back().get());
        return bodies.back().get();
    }

    /// Kinetic and potential.
    double Energy() const
    {
        double energy = 0;
        for (const auto& body : bodies)
        {
            btVector3 spin = body->getInvInertiaTensorWorld().inverse() * body->getAngularVelocity();
            energy += double(
                (body->getLinearVelocity().length2() / body->getInvMass() + body->getAngularVelocity().dot(spin)) / 2);
            energy -= double(body->getGravity().dot(body->getWorldTransform().getOrigin()) / body->getInvMass());
        }
        return energy;
    }
};

/// A thin plate of 1 kg on a plane, and cubes of 1000 kg on it that fall. Returns the least height of the plate ever.
double LowestUnderCubes(btConstraintSolver* solver)
{
    qcMeshWorld world;
    world.world.setConstraintSolver(solver);
    qcAddFloor(world, qc_floorPlane);
    const btScalar margin = btScalar(0.001);
    const btVector3 half(btScalar(0.5), btScalar(0.05), btScalar(0.5));
    btCollisionShape *plate = world.Keep(qcBoxModel(half, 1).MakeShape(margin)),
                     *cube = world.Keep(qcCubeModel().MakeShape(margin));
    const btRigidBody* lowest = world.Add(plate, 1, btVector3(0, btScalar(0.051), 0));
    double least = 1;
    for (int i = 0; i < 3; i++)
        world.Add(cube, 1000, btVector3(0, btScalar(0.603) + btScalar(1.002) * btScalar(i), 0))
            ->setLinearVelocity(btVector3(0, -4, 0));
    for (int step = 0; step < 60; step++)
    {
        world.world.stepSimulation(s_shortStep, 0);
        least = std::min(least, double(lowest->getWorldTransform().getOrigin().y()) - 0.05);
    }
    printf("lowest: %.2f mm\n", 1000 * least);
    return least;
}

START_TEST(a_light_body_under_heavy_ones_is_not_pressed_into_the_floor)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    ck_assert_double_lt(LowestUnderCubes(&sequential), -0.01);
    ck_assert_double_gt(LowestUnderCubes(&stacking), -0.0005);
}
END_TEST

/// Cubes in each other by 4 cm that fall: Bullet pushes them apart by split impulses. Returns the least height ever.
double LowestOfOverlapping(btConstraintSolver* solver)
{
    qcMeshWorld world;
    world.world.setConstraintSolver(solver);
    world.world.getSolverInfo().m_erp2 = btScalar(0.8);
    world.world.getSolverInfo().m_splitImpulsePenetrationThreshold = 0;
    qcAddFloor(world, qc_floorPlane);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape(btScalar(0.02)));
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 3; i++)
    {
        cubes.push_back(world.Add(shape, 10, btVector3(0, btScalar(0.545) + btScalar(0.96) * btScalar(i), 0)));
        cubes.back()->setLinearVelocity(btVector3(0, -6, 0));
    }
    double lowest = 1;
    for (int step = 0; step < 20; step++)
    {
        world.world.stepSimulation(s_shortStep, 0);
        lowest = std::min(lowest, double(cubes[0]->getWorldTransform().getOrigin().y()) - 0.5);
    }
    printf("lowest: %.2f mm\n", 1000 * lowest);
    return lowest;
}

START_TEST(split_impulses_push_nothing_into_a_floor_that_it_reaches_in_the_step)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    // The margin is 20 mm thick.
    ck_assert_double_lt(LowestOfOverlapping(&sequential), 0.01);
    ck_assert_double_gt(LowestOfOverlapping(&stacking), 0.0195);
}
END_TEST

/// Adds a heap of boxes of different masses.
void AddHeap(BoxWorld* boxes, btScalar height)
{
    for (int i = 0; i < 48; i++)
    {
        const btScalar size = btScalar(0.1) + btScalar(0.05) * btScalar(i % 5);
        const btVector3 origin(btScalar(0.9) * btScalar(i % 3), height + btScalar(0.9) * btScalar(i / 6),
                               btScalar(0.9) * btScalar(i / 3 % 2));
        boxes->Add(btVector3(size, size / 2, size), i % 4 == 0 ? btScalar(100) : btScalar(1),
                   btTransform(btQuaternion(btVector3(1, btScalar(i), 2).normalized(), btScalar(i)), origin));
    }
}

/// The largest rise of energy in a step of a heap that falls, without what lifts bodies out of each other.
double LargestRise(btConstraintSolver* solver)
{
    BoxWorld boxes(solver);
    boxes.world.getSolverInfo().m_splitImpulse = false;
    boxes.world.getSolverInfo().m_erp2 = 0;
    boxes.world.addRigidBody(&boxes.floor);
    AddHeap(&boxes, 1);
    double previous = boxes.Energy(), rise = 0;
    for (int step = 0; step < 600; step++)
    {
        boxes.world.stepSimulation(s_shortStep, 0);
        rise = std::max(rise, boxes.Energy() - previous);
        previous = boxes.Energy();
    }
    printf("rise in a step: %.6f J\n", rise);
    return rise;
}

START_TEST(the_energy_of_a_heap_rises_no_more_than_by_bullets_solver)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    ck_assert_double_le(LargestRise(&stacking), LargestRise(&sequential) + 1e-3);
}
END_TEST

START_TEST(a_heap_comes_to_rest)
{
    qcStackingSolver solver;
    BoxWorld boxes(&solver);
    boxes.world.addRigidBody(&boxes.floor);
    AddHeap(&boxes, 1);
    for (int step = 0; step < 1800; step++)
        boxes.world.stepSimulation(s_shortStep, 0);
    for (const auto& body : boxes.bodies)
        ck_assert_double_lt(double(body->getLinearVelocity().length()), 0.05);
}
END_TEST

/// The bodies' transforms after some steps of a heap in the air, whose boxes fly into each other.
std::vector<btTransform> Flight(btConstraintSolver* solver)
{
    BoxWorld boxes(solver);
    AddHeap(&boxes, 0);
    for (const auto& body : boxes.bodies)
        body->setLinearVelocity(body->getWorldTransform().getOrigin() * btScalar(-3));
    for (int step = 0; step < 120; step++)
        boxes.world.stepSimulation(s_shortStep, 0);
    std::vector<btTransform> places;
    for (const auto& body : boxes.bodies)
        places.push_back(body->getWorldTransform());
    return places;
}

START_TEST(bodies_that_nothing_holds_move_as_by_bullets_solver)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    const std::vector<btTransform> expected = Flight(&sequential), found = Flight(&stacking);
    for (size_t i = 0; i < expected.size(); i++)
        ck_assert(expected[i] == found[i]);
}
END_TEST

/// A chain of boxes that hangs by joints, and whose end drags over the floor. Returns the transform of the end.
btTransform Chain(btConstraintSolver* solver)
{
    BoxWorld boxes(solver);
    boxes.world.addRigidBody(&boxes.floor);
    std::vector<std::unique_ptr<btTypedConstraint>> joints;
    const btVector3 half(btScalar(0.1), btScalar(0.1), btScalar(0.1)), end(btScalar(0.15), 0, 0);
    for (int i = 0; i < 6; i++)
    {
        btRigidBody* body =
            boxes.Add(half, 1, btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3) * btScalar(i), 1, 0)));
        joints.emplace_back(i == 0 ? new btPoint2PointConstraint(*body, -end)
                                   : new btPoint2PointConstraint(*boxes.bodies[size_t(i) - 1], *body, end, -end));
        boxes.world.addConstraint(joints.back().get(), true);
    }
    for (int step = 0; step < 400; step++)
        boxes.world.stepSimulation(s_shortStep, 0);
    ck_assert_int_gt(qcContactsOf(boxes.dispatcher).points, 0);
    for (const auto& joint : joints)
        boxes.world.removeConstraint(joint.get());
    return boxes.bodies.back()->getWorldTransform();
}

START_TEST(bodies_with_joints_move_as_by_bullets_solver)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    ck_assert(Chain(&sequential) == Chain(&stacking));
}
END_TEST

// Bullet's solver modes with one and with two directions of friction.
constexpr int s_frictionModes[] = {0, SOLVER_USE_2_FRICTION_DIRECTIONS};

/// How far cubes on each other that never sleep are from where they were put, at most.
double Creep(btConstraintSolver* solver, int mode)
{
    qcMeshWorld world;
    world.world.setConstraintSolver(solver);
    world.world.getSolverInfo().m_solverMode |= mode;
    qcAddFloor(world, qc_floorPlane);
    const btScalar margin = btScalar(0.01);
    btCollisionShape* shape = world.Keep(qcCubeModel().MakeShape(margin));
    std::vector<btRigidBody*> cubes;
    for (int i = 0; i < 6; i++)
    {
        cubes.push_back(world.Add(shape, 1, btVector3(0, btScalar(0.5) + margin + (1 + 2 * margin) * btScalar(i), 0)));
        cubes.back()->setActivationState(DISABLE_DEACTIVATION);
    }
    for (int step = 0; step < 600; step++)
        world.world.stepSimulation(btScalar(1.0 / 60), 0);
    double distance = 0;
    for (const btRigidBody* cube : cubes)
    {
        const btVector3& origin = cube->getWorldTransform().getOrigin();
        distance = std::max(distance, std::hypot(double(origin.x()), double(origin.z())));
    }
    printf("creep: %.2f mm\n", 1000 * distance);
    return distance;
}

START_TEST(a_tower_that_does_not_sleep_stays_upright)
{
    btSequentialImpulseConstraintSolver sequential;
    qcStackingSolver stacking;
    const int mode = s_frictionModes[_i];
    ck_assert_double_lt(Creep(&stacking, mode), std::max(Creep(&sequential, mode), 0.01));
}
END_TEST

/// How far bricks of a pyramid that never sleep are from where they were put after ten seconds, at most.
double PyramidCreep(btConstraintSolver* solver, int mode)
{
    constexpr int rows = 8;
    BoxWorld boxes(solver);
    boxes.world.getSolverInfo().m_solverMode |= mode;
    boxes.world.addRigidBody(&boxes.floor);
    const btVector3 half(btScalar(0.5), btScalar(0.25), btScalar(0.25));
    std::vector<btVector3> places;
    for (int row = 0; row < rows; row++)
        for (int i = 0; i < rows - row; i++)
        {
            places.emplace_back(btScalar(1.1) * (btScalar(i) - btScalar(rows - row) / 2),
                                btScalar(0.5) * (btScalar(row) + btScalar(0.5)), 0);
            boxes.Add(half, 1, btTransform(btQuaternion::getIdentity(), places.back()))
                ->setActivationState(DISABLE_DEACTIVATION);
        }
    for (int step = 0; step < 600; step++)
        boxes.world.stepSimulation(btScalar(1.0 / 60), 0);
    double creep = 0;
    for (size_t i = 0; i < places.size(); i++)
        creep = std::max(creep, double(places[i].distance(boxes.bodies[i]->getWorldTransform().getOrigin())));
    printf("pyramid: %.2f mm\n", 1000 * creep);
    return creep;
}

START_TEST(a_pyramid_that_does_not_sleep_stays_in_place)
{
    qcStackingSolver stacking;
    ck_assert_double_lt(PyramidCreep(&stacking, s_frictionModes[_i]), 0.02);
}
END_TEST

/// The speed of a box of 10 kg after a ball of 1 kg, which lay under it, has struck it at 20 m/s.
double StruckSpeed(btConstraintSolver* solver, btScalar restitution)
{
    BoxWorld boxes(solver);
    boxes.floor.setRestitution(1);
    boxes.world.addRigidBody(&boxes.floor);
    auto at = [](btScalar height) { return btTransform(btQuaternion::getIdentity(), btVector3(0, height, 0)); };
    const btScalar radius = btScalar(0.4), gap = btScalar(0.005), halfHeight = btScalar(0.3);
    btRigidBody* ball = boxes.Add(std::unique_ptr<btCollisionShape>(new btSphereShape(radius)), 1, at(radius + gap));
    btRigidBody* box = boxes.Add(btVector3(radius, halfHeight, radius), 10, at(2 * (radius + gap) + halfHeight));
    for (btRigidBody* body : {ball, box})
        body->setRestitution(btSqrt(restitution));
    ball->setLinearVelocity(btVector3(0, 20, 0));
    boxes.world.stepSimulation(btScalar(1.0 / 60), 0);
    return double(box->getLinearVelocity().y());
}

START_TEST(a_light_body_that_bounces_off_a_heavy_one_throws_it_no_faster_than_by_bullets_solver)
{
    for (btScalar restitution : {btScalar(0), btScalar(0.5), btScalar(1)})
    {
        btSequentialImpulseConstraintSolver sequential;
        qcStackingSolver stacking;
        ck_assert_double_le(StruckSpeed(&stacking, restitution), StruckSpeed(&sequential, restitution) + 0.01);
    }
}
END_TEST

/// A cube on a slab that slides on ice: the two move on as one, and keep their momentum.
START_TEST(friction_keeps_the_momentum_of_bodies_on_ice)
{
    qcStackingSolver solver;
    BoxWorld boxes(&solver);
    boxes.world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    boxes.floor.setFriction(0);
    boxes.world.addRigidBody(&boxes.floor);
    auto at = [](btScalar height) { return btTransform(btQuaternion::getIdentity(), btVector3(0, height, 0)); };
    const btRigidBody* slab = boxes.Add(btVector3(1, btScalar(0.1), 1), 2, at(btScalar(0.1)));
    btRigidBody* cube = boxes.Add(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3)), 1, at(btScalar(0.5)));
    cube->setLinearVelocity(btVector3(btScalar(1.5), 0, 0));
    for (int step = 0; step < 240; step++)
        boxes.world.stepSimulation(s_shortStep, 0);
    printf("slab %.4f m/s, cube %.4f m/s\n", double(slab->getLinearVelocity().x()),
           double(cube->getLinearVelocity().x()));
    ck_assert_double_eq_tol(double(slab->getLinearVelocity().x()), 0.5, 0.01);
    ck_assert_double_eq_tol(double(cube->getLinearVelocity().x()), 0.5, 0.01);
}
END_TEST

/// Shows where the solver's arrays lie.
class OpenSolver : public qcStackingSolver
{
  public:
    /// The addresses of the arrays of contact points, of friction, and of friction about the directions.
    std::vector<const void*> Addresses() const
    {
        std::vector<const void*> addresses;
        for (const btConstraintArray* rows :
             {&m_tmpSolverContactConstraintPool, &m_tmpSolverContactFrictionConstraintPool,
              &m_tmpSolverContactRollingFrictionConstraintPool})
            addresses.push_back(rows->capacity() > 0 ? &(*rows)[0] : nullptr);
        return addresses;
    }
    /// Contact points that the arrays have had at once.
    int Points() const
    {
        return m_points;
    }

  protected:
    btScalar solveGroupCacheFriendlyIterations(btCollisionObject** found, int bodyCount,
                                               btPersistentManifold** manifolds, int manifoldCount,
                                               btTypedConstraint** constraints, int constraintCount,
                                               const btContactSolverInfo& info, btIDebugDraw* drawer) override
    {
        m_points = std::max(m_points, m_tmpSolverContactConstraintPool.size());
        return qcStackingSolver::solveGroupCacheFriendlyIterations(found, bodyCount, manifolds, manifoldCount,
                                                                   constraints, constraintCount, info, drawer);
    }

  private:
    int m_points = 0;
};

/// 100 boxes with all kinds of friction lie down on a plane. Returns where one ends.
btTransform LieDown(OpenSolver* solver)
{
    BoxWorld boxes(solver);
    boxes.world.getSolverInfo().m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    boxes.floor.setRollingFriction(btScalar(0.1));
    boxes.world.addRigidBody(&boxes.floor);
    const btVector3 half(btScalar(0.4), btScalar(0.1), btScalar(0.4));
    for (int i = 0; i < 100; i++)
    {
        btTransform place(btQuaternion::getIdentity(), btVector3(btScalar(i % 10), btScalar(0.1), btScalar(i / 10)));
        boxes.Add(half, 1, place)->setRollingFriction(btScalar(0.1));
    }
    for (int step = 0; step < 10; step++)
        boxes.world.stepSimulation(s_shortStep, 0);
    return boxes.bodies.back()->getWorldTransform();
}

START_TEST(arrays_with_room_for_the_contact_points_of_a_step_do_not_grow_in_it)
{
    OpenSolver plain, reserved, none;
    const btTransform expected = LieDown(&plain);
    ck_assert_int_ge(plain.Points(), 200);
    reserved.reserveContacts(plain.Points());
    const std::vector<const void*> before = reserved.Addresses();
    reserved.reserveContacts(1);
    ck_assert(LieDown(&reserved) == expected);
    ck_assert_int_eq(reserved.Points(), plain.Points());
    ck_assert(reserved.Addresses() == before);
    none.reserveContacts(0);
    none.reserveContacts(-1);
    ck_assert(LieDown(&none) == expected);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("stacking_solver");
    tcase_add_test(tests, a_light_body_under_heavy_ones_is_not_pressed_into_the_floor);
    tcase_add_test(tests, split_impulses_push_nothing_into_a_floor_that_it_reaches_in_the_step);
    tcase_add_test(tests, the_energy_of_a_heap_rises_no_more_than_by_bullets_solver);
    tcase_add_test(tests, a_heap_comes_to_rest);
    tcase_add_loop_test(tests, a_tower_that_does_not_sleep_stays_upright, 0, 2);
    tcase_add_loop_test(tests, a_pyramid_that_does_not_sleep_stays_in_place, 0, 2);
    tcase_add_test(tests, a_light_body_that_bounces_off_a_heavy_one_throws_it_no_faster_than_by_bullets_solver);
    tcase_add_test(tests, friction_keeps_the_momentum_of_bodies_on_ice);
    tcase_add_test(tests, bodies_that_nothing_holds_move_as_by_bullets_solver);
    tcase_add_test(tests, bodies_with_joints_move_as_by_bullets_solver);
    tcase_add_test(tests, arrays_with_room_for_the_contact_points_of_a_step_do_not_grow_in_it);
    return qcRunCase("stacking_solver", tests);
}
