// Objects that the application moves between steps, of all kinds, take a cloth along and never jump past it; what it
// puts elsewhere leaves the cloth alone.
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btSphereShape.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <LinearMath/btDefaultMotionState.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_movedStep = btScalar(1.0 / 60);

btTransform At(btScalar y)
{
    return btTransform(btQuaternion(btVector3(1, 0, 0), btScalar(0.02)),
                       btVector3(btScalar(0.013), y, btScalar(0.007)));
}

/// The kinds of objects that the application moves.
enum Kind
{
    MovedStatic,
    MovedKinematic,
    MotionStateKinematic,
    PlainObject,
    Ghost,
    KindCount
};

/// A cloth at height 0 without gravity, 2 wide, and a plate that the application moves.
struct MovedWorld : qcSoftWorld
{
    btDefaultMotionState state{At(0)};
    std::unique_ptr<btCollisionObject> object;
    btSoftBody* cloth;
    const qcMeshShape* shape;
    qcMotionOracle oracle;
    int m_kind;

    MovedWorld(int kind, const qcModel& model, btScalar y) : m_kind(kind)
    {
        SetGravity(btVector3(0, 0, 0));
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 0, -1), btVector3(1, 0, -1),
                                               btVector3(-1, 0, 1), btVector3(1, 0, 1), 21, 21, 0, true);
        cloth->setTotalMass(1);
        cloth->m_cfg.piterations = 4;
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
        shape = KeepMesh(model);
        if (kind == PlainObject || kind == Ghost)
            object.reset(kind == Ghost ? new btPairCachingGhostObject : new btCollisionObject);
        else
            object.reset(
                new btRigidBody(0, kind == MotionStateKinematic ? &state : nullptr, const_cast<qcMeshShape*>(shape)));
        object->setCollisionShape(const_cast<qcMeshShape*>(shape));
        if (kind == MovedKinematic || kind == MotionStateKinematic)
        {
            object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
            object->setActivationState(DISABLE_DEACTIVATION);
        }
        PutElsewhere(y);
        AddObject();
        oracle.Add([this] { return qcWorldMeshOf(cloth); });
        oracle.Add([this] { return qcWorldMeshOf(*shape, object->getWorldTransform()); });
    }

    ~MovedWorld()
    {
        world.removeCollisionObject(object.get());
    }

    void AddObject()
    {
        if (auto* body = btRigidBody::upcast(object.get()))
            world.addRigidBody(body);
        else
            world.addCollisionObject(object.get());
    }

    void Move(btScalar y)
    {
        state.setWorldTransform(At(y));
        object->setWorldTransform(At(y));
    }

    /// Without a motion: Bullet gives a kinematic body no velocity.
    void PutElsewhere(btScalar y)
    {
        Move(y);
        object->setInterpolationWorldTransform(At(y));
    }

    void Step()
    {
        world.stepSimulation(s_movedStep, 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    }

    /// The height of the node at the cloth's centre.
    btScalar Height() const
    {
        return cloth->m_nodes[21 * 10 + 10].m_x.y();
    }
};

qcModel PlateModel()
{
    return qcFloorModel(0.5, 2);
}
} // namespace

START_TEST(a_plate_that_the_application_moves_takes_a_cloth_along)
{
    for (int start = 0; start < 10; start++)
    {
        btScalar y = btScalar(0.61 + 0.043 * start);
        MovedWorld world(_i, PlateModel(), y);
        for (int step = 0; step < 8; step++)
        {
            world.Move(y -= btScalar(0.4)); // 24 m/s
            world.Step();
            ck_assert_int_eq(world.softSolver.getStatistics().unproven, 0);
            ck_assert_uint_eq(world.oracle.Count(), 0);
        }
        ck_assert_double_lt(double(world.Height()), double(y));
    }
}
END_TEST

START_TEST(a_kinematic_plate_far_from_the_cloth_does_not_jump_over_it)
{
    // Kinds with a velocity of their own.
    for (btScalar height : {btScalar(2), btScalar(20)})
    {
        MovedWorld world(_i, PlateModel(), height);
        world.Step();
        world.oracle.Count();
        world.Move(-height);
        world.Step();
        ck_assert_uint_eq(world.oracle.Count(), 0);
        ck_assert_double_lt(double(world.Height()), double(-height));
    }
}
END_TEST

START_TEST(a_motion_in_several_substeps_does_not_jump_over_the_cloth)
{
    MovedWorld world(_i, PlateModel(), 2);
    world.Step();
    world.oracle.Count();
    // Bullet moves the plate in the first of three substeps, with the velocity of a third of the motion.
    world.Move(-2);
    world.world.stepSimulation(3 * s_movedStep, 3, s_movedStep);
    ck_assert_double_lt(double(world.Height()), -2);
}
END_TEST

START_TEST(a_ball_that_moves_by_more_than_its_size_is_no_less_in_motion)
{
    qcModel ball = qcSphereModel(0.1, 2);
    for (int start = 0; start < 10; start++)
    {
        btScalar y = btScalar(1.31 + 0.047 * start);
        MovedWorld world(_i, ball, y);
        for (int step = 0; step < 6; step++)
        {
            world.Move(y -= btScalar(0.5));
            world.Step();
            // The first motion of an object without a velocity of its own is a jump, above the cloth.
            ck_assert_uint_eq(world.oracle.Count(), 0);
        }
        ck_assert_double_lt(double(world.Height()), -0.5);
    }
}
END_TEST

START_TEST(an_object_that_is_put_elsewhere_sweeps_over_nothing)
{
    MovedWorld world(_i, PlateModel(), 2);
    world.Step();
    world.PutElsewhere(-2);
    world.Step();
    ck_assert_double_eq_tol(double(world.Height()), 0, 1e-3);
    world.PutElsewhere(3);
    world.Step();
    ck_assert_double_eq_tol(double(world.Height()), 0, 1e-3);
}
END_TEST

/// An application may reset the broadphase between two levels of a game.
START_TEST(an_object_that_is_added_again_elsewhere_after_a_reset_sweeps_over_nothing)
{
    const btScalar height = btScalar(0.4); // no more than half its size from the other side
    MovedWorld world(_i, qcFloorModel(0.8, 2), height);
    world.Step();
    world.world.removeSoftBody(world.cloth);
    world.world.removeCollisionObject(world.object.get());
    world.broadphase.resetPool(&world.dispatcher);
    world.PutElsewhere(-height);
    world.world.addSoftBody(world.cloth);
    world.AddObject();
    world.Step();
    ck_assert_double_eq_tol(double(world.Height()), 0, 1e-3);
    world.Move(height);
    world.Step();
    ck_assert_double_gt(double(world.Height()), double(height));
}
END_TEST

/// Puts the body in the world's user data below the cloth.
static void PutBelow(btDynamicsWorld* world, btScalar)
{
    static_cast<btRigidBody*>(world->getWorldUserInfo())->setCenterOfMassTransform(At(-1));
}

START_TEST(a_body_that_the_pre_tick_callback_puts_elsewhere_sweeps_over_nothing)
{
    MovedWorld world(MovedStatic, PlateModel(), 5);
    btRigidBody* ball = world.AddMesh(qcSphereModel(0.1, 2), 1, btVector3(0, 1, 0));
    world.Step();
    world.world.setInternalTickCallback(PutBelow, ball, true);
    world.Step();
    ck_assert_double_eq_tol(double(world.Height()), 0, 1e-3);
    ck_assert_double_eq_tol(double(ball->getWorldTransform().getOrigin().y()), -1, 1e-3);
}
END_TEST

START_TEST(a_body_that_the_tick_callback_puts_elsewhere_sweeps_over_nothing)
{
    MovedWorld world(MovedStatic, PlateModel(), 5);
    btRigidBody* ball = world.AddMesh(qcSphereModel(0.1, 2), 1, btVector3(0, 1, 0));
    world.Step();
    // Bullet calls it before soft bodies make contact.
    world.world.setInternalTickCallback(PutBelow, ball);
    world.Step();
    ck_assert_double_eq_tol(double(world.Height()), 0, 1e-3);
    ck_assert_double_eq_tol(double(ball->getWorldTransform().getOrigin().y()), -1, 1e-3);
}
END_TEST

/// What a callback of the deformable world puts below the cloth, once, and the velocity that it gets.
static btRigidBody* s_putBody;
static btVector3 s_putVelocity;

static void PutOnce(btScalar, btDeformableMultiBodyDynamicsWorld*)
{
    if (s_putBody == nullptr)
        return;
    s_putBody->setCenterOfMassTransform(At(-1));
    s_putBody->setLinearVelocity(s_putVelocity);
    s_putBody = nullptr;
}

START_TEST(a_body_that_the_solver_callback_puts_elsewhere_moves_from_there)
{
    // At rest, and so fast that it passes the cloth from its new place in the same step.
    for (btScalar speed : {btScalar(0), btScalar(120)})
    {
        qcDeformableTestWorld<qcDeformableWorld> world;
        world.world->setGravity(btVector3(0, 0, 0));
        btSoftBody* cloth =
            btSoftBodyHelpers::CreatePatch(world.world->getWorldInfo(), btVector3(-1, 0, -1), btVector3(1, 0, -1),
                                           btVector3(-1, 0, 1), btVector3(1, 0, 1), 21, 21, 0, true);
        cloth->setTotalMass(1);
        world.world->addSoftBody(cloth);
        world.cloths.push_back(cloth);
        btSphereShape shape(btScalar(0.1));
        btRigidBody ball(1, nullptr, &shape, btVector3(btScalar(0.004), btScalar(0.004), btScalar(0.004)));
        ball.setWorldTransform(At(1));
        world.world->addRigidBody(&ball);
        world.world->stepSimulation(s_movedStep, 0);
        s_putBody = &ball;
        s_putVelocity = btVector3(0, speed, 0);
        world.world->setSolverCallback(PutOnce);
        world.world->stepSimulation(s_movedStep, 0);
        const btScalar height = cloth->m_nodes[21 * 10 + 10].m_x.y();
        if (speed > 0)
        {
            ck_assert_double_gt(double(height), 0.1);
            ck_assert_double_lt(double(ball.getWorldTransform().getOrigin().y()), double(height));
        }
        else
            ck_assert_double_eq_tol(double(height), 0, 1e-3);
        world.world->removeRigidBody(&ball);
    }
}
END_TEST

START_TEST(a_cloth_at_rest_that_the_application_moves_stays_at_rest)
{
    qcSoftWorld world;
    world.AddMesh(qcFloorModel(4, 8), 0, btVector3(0, 0, 0));
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(
        world.world.getWorldInfo(), btVector3(-1, btScalar(0.05), -1), btVector3(1, btScalar(0.05), -1),
        btVector3(-1, btScalar(0.05), 1), btVector3(1, btScalar(0.05), 1), 17, 17, 0, true);
    cloth->setTotalMass(1);
    cloth->m_cfg.piterations = 4;
    world.world.addSoftBody(cloth);
    world.cloths.push_back(cloth);
    for (int step = 0; step < 60; step++)
        world.world.stepSimulation(s_movedStep, 0);
    // Along the floor, and into it.
    for (const btVector3& by : {btVector3(btScalar(0.3), 0, 0), btVector3(0, btScalar(-0.3), 0)})
    {
        cloth->translate(by);
        for (int step = 0; step < 5; step++)
            world.world.stepSimulation(s_movedStep, 0);
        ck_assert_double_lt(double(qcSpeedOf(cloth)), 0.01);
        ck_assert_double_gt(double(qcLowestNode(cloth)), 0);
    }
    // The motion along the floor remains.
    ck_assert_double_eq_tol(double(cloth->m_nodes[17 * 8 + 8].m_x.x()), 0.3, 0.01);
}
END_TEST

/// Steps a world with a cloth on hills, moves all there is, and back. `world` has the hills already.
template <class World> void CheckNewOrigin(World* world, btSoftBody* cloth)
{
    for (int step = 0; step < 120; step++)
        world->stepSimulation(s_movedStep, 0);
    for (const btVector3& by : {btVector3(30, 0, 1), btVector3(-30, 0, -1), btVector3(btScalar(0.3), 0, 0)})
    {
        for (int i = 0; i < world->getNumCollisionObjects(); i++)
        {
            btCollisionObject* object = world->getCollisionObjectArray()[i];
            object->getWorldTransform().getOrigin() += by;
            btTransform interpolated = object->getInterpolationWorldTransform();
            interpolated.getOrigin() += by;
            object->setInterpolationWorldTransform(interpolated);
        }
        for (int i = 0; i < world->getNumCollisionObjects(); i++)
            if (world->getCollisionObjectArray()[i]->isKinematicObject())
                world->getCollisionObjectArray()[i]->getWorldTransform().getOrigin() += btVector3(0, btScalar(0.01), 0);
        cloth->translate(by);
        std::vector<btVector3> before;
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            before.push_back(cloth->m_nodes[i].m_x);
        world->stepSimulation(s_movedStep, 0);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            ck_assert_double_lt(double(cloth->m_nodes[i].m_x.distance(before[size_t(i)])), 0.02);
        for (int step = 0; step < 20; step++)
            world->stepSimulation(s_movedStep, 0);
    }
}

START_TEST(a_new_origin_of_the_world_leaves_a_cloth_on_its_ground)
{
    const qcModel hills = qcHillsModel(30, 30);
    auto makeCloth = [](btSoftBodyWorldInfo& info)
    {
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(info, btVector3(-1, 1, -1), btVector3(1, 1, -1),
                                                           btVector3(-1, 1, 1), btVector3(1, 1, 1), 13, 13, 0, true);
        cloth->setTotalMass(1);
        return cloth;
    };
    qcSoftWorld soft;
    soft.AddMesh(hills, 0, btVector3(0, 0, 0));
    soft.cloths.push_back(makeCloth(soft.world.getWorldInfo()));
    soft.world.addSoftBody(soft.cloths[0]);
    // An object that moves by itself, far away.
    btRigidBody* mover = soft.AddMesh(qcFloorModel(1, 1), 0, btVector3(-20, 5, 0));
    mover->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    CheckNewOrigin(&soft.world, soft.cloths[0]);

    auto shape = hills.MakeShape();
    btRigidBody ground(0, nullptr, shape.get());
    btDeformableMassSpringForce springs(30, 1, true);
    btDeformableGravityForce gravity(btVector3(0, -10, 0));
    qcDeformableTestWorld<qcDeformableWorld> deformable;
    deformable.world->addRigidBody(&ground);
    btSoftBody* cloth = makeCloth(deformable.world->getWorldInfo());
    cloth->m_cfg.kDF = btScalar(0.5);
    deformable.world->addSoftBody(cloth);
    deformable.world->addForce(cloth, &springs);
    deformable.world->addForce(cloth, &gravity);
    deformable.cloths.push_back(cloth);
    CheckNewOrigin(deformable.world.get(), cloth);
    deformable.world->removeRigidBody(&ground);
}
END_TEST

/// Removes the body in the world's user data, which no one else then moves.
static void Remove(btDynamicsWorld* world, btScalar)
{
    auto* body = static_cast<btRigidBody*>(world->getWorldUserInfo());
    world->removeRigidBody(body);
    body->translate(btVector3(0, 1, 0));
    world->setInternalTickCallback(nullptr);
}

START_TEST(a_cloth_that_falls_asleep_above_a_mesh_passes_it_neither_then_nor_later)
{
    for (btScalar speed : {btScalar(5), btScalar(10), btScalar(20)})
    {
        qcSoftWorld soft;
        soft.AddMesh(qcFloorModel(4, 8), 0, btVector3(0, 0, 0));
        btSoftBody* cloth =
            btSoftBodyHelpers::CreatePatch(soft.world.getWorldInfo(), btVector3(-1, 1, -1), btVector3(1, 1, -1),
                                           btVector3(-1, 1, 1), btVector3(1, 1, 1), 9, 9, 0, true);
        cloth->setTotalMass(1);
        soft.world.addSoftBody(cloth);
        soft.cloths.push_back(cloth);
        cloth->setVelocity(btVector3(0, -speed, 0));
        while (qcLowestNode(cloth) > speed / 60)
            soft.world.stepSimulation(btScalar(1.0 / 60), 0);
        // Bullet lets it fall asleep in the middle of the step.
        cloth->setActivationState(WANTS_DEACTIVATION);
        soft.world.stepSimulation(btScalar(1.0 / 60), 0);
        const btScalar lowest = qcLowestNode(cloth);
        ck_assert_double_gt(double(lowest), 0);
        for (int step = 0; step < 30; step++)
        {
            ck_assert_int_eq(cloth->getActivationState(), ISLAND_SLEEPING);
            soft.world.stepSimulation(btScalar(1.0 / 60), 0);
        }
        ck_assert(qcLowestNode(cloth) == lowest);
        cloth->activate(true);
        for (int step = 0; step < 60; step++)
        {
            soft.world.stepSimulation(btScalar(1.0 / 60), 0);
            ck_assert_double_gt(double(qcLowestNode(cloth)), 0);
        }
    }
}
END_TEST

START_TEST(a_body_that_the_tick_callback_removes_holds_nothing)
{
    qcSoftWorld world;
    qcModel floor = qcFloorModel(2, 4);
    btRigidBody* body = world.AddMesh(floor, 0, btVector3(0, 0, 0));
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), btVector3(-1, btScalar(0.1), -1),
                                                       btVector3(1, btScalar(0.1), -1), btVector3(-1, btScalar(0.1), 1),
                                                       btVector3(1, btScalar(0.1), 1), 21, 21, 0, true);
    world.world.addSoftBody(cloth);
    world.cloths.push_back(cloth);
    for (int step = 0; step < 40; step++)
        world.world.stepSimulation(s_movedStep, 0);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
    world.world.setInternalTickCallback(Remove, body);
    world.world.stepSimulation(s_movedStep, 0);
    // A removed body may be deleted, too.
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        ck_assert_double_lt(double(cloth->m_nodes[i].m_x.y()), 0.2);
}
END_TEST

/// A box is held by a flag where it has not been before, and thrown at a curtain from there.
START_TEST(a_box_that_is_held_and_then_thrown_is_caught)
{
    const int hold = _i == 0 ? btCollisionObject::CF_KINEMATIC_OBJECT : btCollisionObject::CF_STATIC_OBJECT;
    qcSoftWorld scene;
    scene.SetGravity(btVector3(0, 0, 0));
    btSoftBody* curtain =
        scene.AddPatch(btVector3(2, -2, -2), btVector3(2, 2, -2), btVector3(2, -2, 2), btVector3(2, 2, 2), 17, 17, 0.5);
    for (int i = 0; i < curtain->m_nodes.size(); i++)
        if (btFabs(curtain->m_nodes[i].m_x.y()) > btScalar(1.99))
            curtain->setMass(i, 0);
    btBoxShape shape(btVector3(btScalar(0.4), btScalar(0.4), btScalar(0.4)));
    btRigidBody* box = scene.AddBody(&shape, btScalar(0.2), btVector3(-5, 0, 0));
    box->setActivationState(DISABLE_DEACTIVATION);
    curtain->setActivationState(DISABLE_DEACTIVATION);
    for (int step = 0; step < 9; step++)
    {
        if (step == 4)
        {
            const btTransform at(btQuaternion::getIdentity(), btVector3(btScalar(1.4), 0, 0));
            box->setCollisionFlags(box->getCollisionFlags() | hold);
            box->setWorldTransform(at);
            box->setInterpolationWorldTransform(at);
        }
        scene.world.stepSimulation(s_movedStep, 0);
    }
    box->setCollisionFlags(box->getCollisionFlags() & ~hold);
    box->setLinearVelocity(btVector3(90, 0, 0));
    for (int step = 0; step < 20; step++)
        scene.world.stepSimulation(s_movedStep, 0);
    ck_assert_double_lt(double(box->getWorldTransform().getOrigin().x()), 15); // 31 in free flight
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("moved objects");
    tcase_add_loop_test(tests, a_plate_that_the_application_moves_takes_a_cloth_along, 0, KindCount);
    tcase_add_loop_test(tests, a_kinematic_plate_far_from_the_cloth_does_not_jump_over_it, MovedKinematic,
                        MotionStateKinematic + 1);
    tcase_add_loop_test(tests, a_motion_in_several_substeps_does_not_jump_over_the_cloth, MovedKinematic,
                        MotionStateKinematic + 1);
    tcase_add_loop_test(tests, a_ball_that_moves_by_more_than_its_size_is_no_less_in_motion, 0, KindCount);
    tcase_add_loop_test(tests, an_object_that_is_put_elsewhere_sweeps_over_nothing, 0, KindCount);
    tcase_add_loop_test(tests, an_object_that_is_added_again_elsewhere_after_a_reset_sweeps_over_nothing, 0, KindCount);
    tcase_add_test(tests, a_body_that_the_pre_tick_callback_puts_elsewhere_sweeps_over_nothing);
    tcase_add_test(tests, a_body_that_the_tick_callback_puts_elsewhere_sweeps_over_nothing);
    tcase_add_test(tests, a_body_that_the_solver_callback_puts_elsewhere_moves_from_there);
    tcase_add_test(tests, a_cloth_at_rest_that_the_application_moves_stays_at_rest);
    tcase_add_test(tests, a_new_origin_of_the_world_leaves_a_cloth_on_its_ground);
    tcase_add_test(tests, a_cloth_that_falls_asleep_above_a_mesh_passes_it_neither_then_nor_later);
    tcase_add_test(tests, a_body_that_the_tick_callback_removes_holds_nothing);
    tcase_add_loop_test(tests, a_box_that_is_held_and_then_thrown_is_caught, 0, 2);
    return qcRunCase("moved objects", tests);
}
