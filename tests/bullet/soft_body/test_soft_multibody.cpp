// Links of multibodies (btMultiBody) and cloth, in Bullet's classic and in its deformable world: nothing passes,
// contact moves both, by mass, and joints stay joints.
#include "bullet/random_numbers.h"
#include "bullet/soft_body/multibody_world.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

#include <cmath>

#include "support/long_form.h"

namespace
{
const btVector3 s_gravity(0, -10, 0), s_none(0, 0, 0);
const btQuaternion s_upright = btQuaternion::getIdentity();

/// One link of 1 kg that slides up and down at a joint, over the origin.
void SetUpSlider(qcRobot& robot, const btVector3& half)
{
    robot.Body().setBasePos(btVector3(btScalar(0.03), 3, btScalar(0.02)));
    robot.Body().setupPrismatic(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, btVector3(0, 1, 0),
                                btVector3(0, -2, 0), s_none, false);
    robot.Finish();
    robot.AddBox(0, half);
}

/// A chain of three boxes of 0.5 kg, with a spherical and a hinge joint, that lies along x.
const btVector3 s_chainHalf(btScalar(0.15), btScalar(0.05), btScalar(0.1));
void SetUpChain(qcRobot& robot, const btVector3& at)
{
    const btVector3 half(btScalar(0.2), 0, 0), inertia = qcRobot::InertiaOf(btScalar(0.5), s_chainHalf);
    robot.Body().setBasePos(at - 2 * half);
    robot.Body().setupSpherical(0, btScalar(0.5), inertia, -1, s_upright, half, half, true);
    robot.Body().setupRevolute(1, btScalar(0.5), inertia, 0, s_upright, btVector3(0, 0, 1), half, half, true);
    robot.Finish();
    for (int link = -1; link < 2; link++)
        robot.AddBox(link, s_chainHalf);
}

btScalar ClothEnergy(const btSoftBody* cloth, const btVector3& gravity)
{
    btScalar sum = 0;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        if (cloth->m_nodes[i].m_im > 0)
            sum += (cloth->m_nodes[i].m_v.length2() / 2 - gravity.dot(cloth->m_nodes[i].m_x)) / cloth->m_nodes[i].m_im;
    return sum;
}

btScalar HighestNode(const btSoftBody* cloth)
{
    btScalar highest = -BT_LARGE_FLOAT;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        highest = btMax(highest, cloth->m_nodes[i].m_x.y());
    return highest;
}
} // namespace

START_TEST(a_link_passes_no_cloth)
{
    // A plate, flat and on edge: Bullet's own contact tests nodes alone, and lets the second one through at any speed.
    const btVector3 halves[] = {btVector3(btScalar(0.3), btScalar(0.01), btScalar(0.3)),
                                btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.01))};
    for (const btVector3& half : halves)
        for (btScalar speed : {btScalar(1), btScalar(10), btScalar(30)})
        {
            std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
            const btSoftBody* cloth = world->AddCloth(0, true);
            qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
            SetUpSlider(robot, half);
            robot.Body().setJointVel(0, -speed);
            qcMotionOracle oracle;
            oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
            robot.Watch(oracle);
            btScalar lowest = 0, fastest = 0;
            for (btScalar time = 0; time < 2; time += world->TimeStep())
            {
                world->StepApart(oracle);
                lowest = btMin(lowest, robot.Body().getJointPos(0));
                fastest = btMax(fastest, robot.Body().getJointVel(0));
            }
            // It has met the cloth, and is thrown back no faster than it came.
            ck_assert_double_lt(double(lowest), -1);
            ck_assert_double_gt(double(fastest), 0);
            ck_assert_double_lt(double(fastest), double(btSqrt(speed * speed + 2 * 10 * 6)));
        }
}
END_TEST

START_TEST(nor_does_a_body_that_its_factors_guide)
{
    // Folds stand beside its faces: to give way along their normals it would have to move far up or down.
    const btVector3 half(btScalar(0.3), btScalar(0.3), btScalar(0.01));
    for (btScalar speed : {btScalar(1), btScalar(20), btScalar(40)})
    {
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
        const btSoftBody* cloth = world->AddCloth(0, true, 20);
        btBoxShape shape(half);
        shape.setMargin(btScalar(0.005));
        const qcModel model = qcBoxModel(half, 1);
        btRigidBody body(1, nullptr, &shape, qcRobot::InertiaOf(1, half));
        body.setWorldTransform(btTransform(s_upright, btVector3(btScalar(0.03), 1, btScalar(0.02))));
        body.setInterpolationWorldTransform(body.getWorldTransform());
        body.setLinearFactor(btVector3(0, 1, 0));
        body.setAngularFactor(btVector3(0, 0, 0));
        body.setActivationState(DISABLE_DEACTIVATION);
        world->World().addRigidBody(&body);
        body.setLinearVelocity(btVector3(0, -speed, 0));
        qcMotionOracle oracle;
        oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
        oracle.Add(model, &body);
        for (btScalar time = 0; time < 2; time += world->TimeStep())
        {
            world->Step();
            ck_assert_uint_eq(oracle.Count(), 0);
            ck_assert_double_lt(double(body.getLinearVelocity().length()), 60);
        }
        world->World().removeRigidBody(&body);
    }
}
END_TEST

START_TEST(a_driven_arm_sweeps_a_cloth_aside)
{
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    const btSoftBody* cloth = world->AddCloth(0, true);
    const btVector3 half(btScalar(0.4), btScalar(0.02), btScalar(0.01));
    qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
    robot.Body().setBasePos(btVector3(0, btScalar(0.25), 0));
    robot.Body().setupRevolute(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, btVector3(0, 0, 1), s_none,
                               btVector3(btScalar(0.4), 0, 0), false);
    robot.Finish();
    robot.AddBox(0, half);
    robot.Body().setJointPos(0, 1);
    robot.Place();
    btMultiBodyJointMotor motor(&robot.Body(), 0, -8, 50);
    motor.finalizeMultiDof();
    world->World().addMultiBodyConstraint(&motor);
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    robot.Watch(oracle);
    int contacts = 0;
    for (btScalar time = 0; time < 2; time += world->TimeStep())
    {
        world->Step();
        ck_assert_uint_eq(oracle.Count(), 0);
        contacts += world->Contact().getStatistics().contacts != 0;
        ck_assert_double_lt(double(btFabs(robot.Body().getJointVel(0))), 20);
    }
    ck_assert_int_gt(contacts, 20);
    world->World().removeMultiBodyConstraint(&motor);
}
END_TEST

START_TEST(contact_keeps_the_momentum_of_cloth_and_links)
{
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
    btSoftBody* cloth = world->AddCloth(0, false);
    qcRobot robot(*world, 2, btScalar(0.5), s_chainHalf, false);
    SetUpChain(robot, btVector3(btScalar(0.1), btScalar(0.3), btScalar(0.2)));
    robot.Body().setBaseVel(btVector3(btScalar(0.5), -4, 1));
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    robot.Watch(oracle);
    const btVector3 momentum = robot.Momentum();
    btScalar energy = robot.Energy(s_none);
    ck_assert_double_eq_tol(double(momentum.y()), -6, 1e-4);
    // Bullet's own integration of joints that turn, without contact, changes it by more than contact does: short steps.
    for (int step = 0; step < 480; step++)
    {
        world->World().stepSimulation(btScalar(1.0 / 480), 0);
        ck_assert_uint_eq(oracle.Count(), 0);
        ck_assert_double_lt(double((robot.Momentum() + qcMomentumOf(cloth) - momentum).length()), 0.1);
        ck_assert_double_lt(double(robot.Energy(s_none) + ClothEnergy(cloth, s_none)), 1.01 * double(energy));
    }
    // The cloth has taken a good part.
    ck_assert_double_lt(double(qcMomentumOf(cloth).y()), -1);
}
END_TEST

START_TEST(a_cloth_catches_a_chain_of_links)
{
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    const btSoftBody* cloth = world->AddCloth(0, true);
    qcRobot robot(*world, 2, btScalar(0.5), s_chainHalf, false);
    SetUpChain(robot, btVector3(0, btScalar(0.5), 0));
    robot.Body().setLinearDamping(btScalar(0.04));
    robot.Body().setAngularDamping(btScalar(0.04));
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    robot.Watch(oracle);
    btScalar last = robot.Energy(s_gravity) + ClothEnergy(cloth, s_gravity);
    for (btScalar time = 0; time < 5; time += world->TimeStep())
    {
        world->Step();
        ck_assert_uint_eq(oracle.Count(), 0);
    }
    ck_assert_double_lt(double(robot.Energy(s_gravity) + ClothEnergy(cloth, s_gravity)), double(last));
    // In the hollow that it has made.
    const btScalar lowest = qcLowestNode(cloth), height = robot.Body().getBasePos().y();
    ck_assert_double_lt(double(lowest), -0.1);
    ck_assert_double_gt(double(height), double(lowest));
    ck_assert_double_lt(double(btFabs(robot.Body().getBasePos().x())), 1);
    // The springs of the deformable world still swing.
    ck_assert_double_lt(double(robot.Momentum().length()), _i != 0 ? 3 : 0.3);
}
END_TEST

START_TEST(links_that_the_application_moves_move_cloth_without_a_world_that_steps_them)
{
    // 5 cm in each step, and 4 cm thick: more than half its size. The cloth sleeps until then.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
    btSoftBody* cloth = world->AddCloth(0, false);
    cloth->forceActivationState(ISLAND_SLEEPING);
    const btVector3 half(btScalar(0.02), btScalar(0.02), btScalar(0.02));
    qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
    robot.Body().setupPrismatic(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, btVector3(0, 1, 0), s_none, s_none,
                                false);
    robot.Finish(false);
    robot.AddBox(0, half);
    qcMotionOracle oracle;
    btScalar height = btScalar(0.5);
    for (int step = 0; step < 30; step++)
    {
        robot.Body().setJointPos(0, height);
        robot.Place();
        if (step == 0)
        {
            oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
            robot.Watch(oracle);
        }
        world->Step();
        ck_assert_uint_eq(oracle.Count(), 0);
        ck_assert_double_eq_tol(double(robot.Body().getJointPos(0)), double(height), 1e-6);
        height -= btScalar(0.05);
    }
    ck_assert_double_lt(double(qcLowestNode(cloth)), -0.9);
}
END_TEST

namespace
{
/// Two fingers that slide along x, on a bar that is lifted. Motors drive all three joints.
struct Gripper
{
    qcRobot robot;
    btMultiBodyJointMotor lift{&robot.Body(), 0, 0, 500},
        fingers[2] = {{&robot.Body(), 1, 0, 30}, {&robot.Body(), 2, 0, 30}};

    Gripper(qcMultiBodyWorld& world, const btVector3& at) : robot(world, 3, 0, btVector3(1, 1, 1), true)
    {
        const btVector3 half(btScalar(0.02), btScalar(0.1), btScalar(0.05));
        const btVector3 inertia = qcRobot::InertiaOf(btScalar(0.3), half);
        robot.Body().setBasePos(at);
        robot.Body().setupPrismatic(0, 1, inertia, -1, s_upright, btVector3(0, 1, 0), s_none, s_none, true);
        for (int i = 0; i < 2; i++)
        {
            const btScalar side = i == 0 ? btScalar(-1) : btScalar(1);
            robot.Body().setupPrismatic(i + 1, btScalar(0.3), inertia, 0, s_upright, btVector3(-side, 0, 0),
                                        btVector3(btScalar(0.3) * side, btScalar(-1.15), 0), s_none, true);
        }
        robot.Finish();
        // A joint whose link has no collider is in no island: Bullet leaves its motor out.
        robot.AddBox(0, btVector3(btScalar(0.3), btScalar(0.02), btScalar(0.02)));
        for (int link = 1; link < 3; link++)
            robot.AddBox(link, half)->setFriction(1);
        ForEachMotor([&world](btMultiBodyJointMotor& motor)
                     { motor.finalizeMultiDof(), world.World().addMultiBodyConstraint(&motor); });
    }

    template <typename Function> void ForEachMotor(Function function)
    {
        function(lift);
        function(fingers[0]);
        function(fingers[1]);
    }
};
} // namespace

/// `boardAside`: the place of the board, in x.
static void LiftFromBoard(bool isDeformable, btScalar boardAside, btScalar pressSpeed, btScalar liftSpeed)
{
    // The board, of 4 cm, leaves the cloth no room. Gaps in the grip are as small as the rounding of positions.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(isDeformable, s_gravity);
    btSoftBody* cloth = world->AddCloth(0, false);
    qcSoftBodySettings settings = world->Contact().getSettings(cloth);
    settings.friction = 1;
    ck_assert_int_eq(world->Contact().setSettings(cloth, settings), qc_statusOk);
    const qcFixedBox floor(*world, btVector3(5, 1, 5), btVector3(0, btScalar(-1.6), 0));
    const qcFixedBox board(*world, btVector3(btScalar(0.02), btScalar(0.3), btScalar(0.3)),
                           btVector3(boardAside, btScalar(-0.35), 0));
    Gripper gripper(*world, btVector3(0, 1, 0));
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    gripper.robot.Watch(oracle, btScalar(1e-6));
    for (btScalar time = 0; time < 5; time += world->TimeStep())
    {
        for (btMultiBodyJointMotor& finger : gripper.fingers)
            finger.setVelocityTarget(time > 1 ? pressSpeed : btScalar(0));
        gripper.lift.setVelocityTarget(time > 3 ? liftSpeed : btScalar(0));
        world->StepApart(oracle);
    }
    ck_assert_msg(HighestNode(cloth) > btScalar(0.4), "board at %g, speeds %g and %g: %g m", double(boardAside),
                  double(pressSpeed), double(liftSpeed), double(HighestNode(cloth)));
    gripper.ForEachMotor([&world](btMultiBodyJointMotor& motor) { world->World().removeMultiBodyConstraint(&motor); });
}

START_TEST(fingers_lift_a_cloth_that_they_press_against_a_board)
{
    for (int i : {0, 1, 5})
        LiftFromBoard(_i != 0, btScalar(i - 3) / 300, btScalar(0.3) + btScalar(i % 3 - 1) / 25,
                      btScalar(0.4) + btScalar(i % 2) / 20);
}
END_TEST

/// An arm of three links with strong motors, over the origin. The links are boxes of Bullet's, or meshes.
class RandomArm
{
  public:
    RandomArm(qcMultiBodyWorld& world, qcRandomNumbers& random, bool hasMeshes = false)
        : m_world(world.World()), m_robot(world, 3, 0, btVector3(1, 1, 1), true)
    {
        const btVector3 half(btScalar(0.15), btScalar(0.03), btScalar(0.02)), end(btScalar(0.15), 0, 0);
        m_robot.Body().setBasePos(btVector3(0, btScalar(0.35), 0));
        for (int link = 0; link < 3; link++)
        {
            const btVector3 axis = random.Vector(1);
            m_robot.Body().setupRevolute(link, btScalar(0.5), qcRobot::InertiaOf(btScalar(0.5), half), link - 1,
                                         s_upright, axis.normalized(), link == 0 ? s_none : end, end, true);
        }
        m_robot.Finish();
        // A static base takes nothing from its arm.
        m_robot.AddBox(-1, btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.05)))
            ->setCollisionFlags(btCollisionObject::CF_STATIC_OBJECT);
        if (hasMeshes)
            m_mesh = qcBoxModel(half, 2).MakeShape();
        for (int link = 0; link < 3; link++)
        {
            btMultiBodyLinkCollider* collider = m_robot.AddBox(link, half);
            if (hasMeshes)
                collider->setCollisionShape(m_mesh.get());
        }
        for (int link = 0; link < 3; link++)
        {
            m_motors.emplace_back(new btMultiBodyJointMotor(&m_robot.Body(), link, 0, 20));
            m_motors.back()->finalizeMultiDof();
            m_world.addMultiBodyConstraint(m_motors.back().get());
        }
    }
    ~RandomArm()
    {
        for (const std::unique_ptr<btMultiBodyJointMotor>& motor : m_motors)
            m_world.removeMultiBodyConstraint(motor.get());
    }
    RandomArm(const RandomArm&) = delete;
    RandomArm& operator=(const RandomArm&) = delete;

    qcRobot& Robot()
    {
        return m_robot;
    }
    /// New speeds, up to `speed`, every 0.3 s.
    void Drive(btScalar time, double speed, qcRandomNumbers& random)
    {
        for (size_t i = 0; i < m_motors.size() && time >= m_next; i++)
            m_motors[i]->setVelocityTarget(random.Number(-speed, speed));
        m_next += time >= m_next ? btScalar(0.3) : btScalar(0);
    }

  private:
    btMultiBodyDynamicsWorld& m_world;
    std::unique_ptr<qcMeshShape> m_mesh;
    qcRobot m_robot;
    std::vector<std::unique_ptr<btMultiBodyJointMotor>> m_motors;
    btScalar m_next = 0;
};

START_TEST(random_arms_that_strike_a_cloth_on_the_floor_pass_nothing)
{
    // Strong motors press links of all directions on cloth that lies on a floor: often there is no room.
    int steps = 0, stopped = 0;
    for (unsigned start = 1; start <= (qcIsLongForm() ? 100u : 3u); start++)
    {
        qcRandomNumbers random(start);
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
        const btSoftBody* cloth = world->AddCloth(btScalar(0.05), false);
        const qcFixedBox floor(*world, btVector3(5, 1, 5), btVector3(0, -1, 0));
        RandomArm arm(*world, random);
        qcMotionOracle oracle;
        oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
        arm.Robot().Watch(oracle, btScalar(1e-6));
        for (btScalar time = 0; time < 3; time += world->TimeStep())
        {
            arm.Drive(time, 12, random);
            world->StepApart(oracle);
            steps++;
            stopped += arm.Robot().Body().getJointVel(0) == 0;
        }
    }
    // The last resort, that a multibody returns to the start of the step, is seldom needed.
    ck_assert_int_lt(100 * stopped, steps);
}
END_TEST

START_TEST(random_arms_between_a_cloth_and_a_thin_mesh_pass_neither)
{
    const qcModel plate = qcBoxModel(btVector3(2, btScalar(0.4), btScalar(0.01)), 4);
    const std::unique_ptr<qcMeshShape> shape = plate.MakeShape();
    for (unsigned start = 1; start <= (qcIsLongForm() ? 100u : 3u); start++)
    {
        qcRandomNumbers random(start);
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
        qcMeshContact meshes;
        meshes.addTo(&world->World());
        const btSoftBody* cloth = world->AddCloth(btScalar(0.05), false);
        const qcFixedBox floor(*world, btVector3(5, 1, 5), btVector3(0, -1, 0));
        btRigidBody wall(0, nullptr, shape.get());
        wall.setWorldTransform(btTransform(s_upright, btVector3(0, btScalar(0.55), btScalar(0.3))));
        world->World().addRigidBody(&wall);
        {
            RandomArm arm(*world, random, true);
            qcMotionOracle withCloth, withWall;
            withCloth.Add([cloth] { return qcWorldMeshOf(cloth); });
            arm.Robot().Watch(withCloth, btScalar(1e-6));
            withWall.Add(plate, &wall);
            arm.Robot().Watch(withWall, btScalar(1e-6));
            for (btScalar time = 0; time < 3; time += world->TimeStep())
            {
                arm.Drive(time, 40, random);
                world->StepApart(withCloth);
                ck_assert_uint_eq(withWall.Count(), 0);
                ck_assert_int_eq(meshes.getStatistics().unproven, 0);
            }
        }
        world->World().removeRigidBody(&wall);
    }
}
END_TEST

/// What a heavy cloth pushes at a thin mesh.
enum Pushed
{
    pushed_link,
    pushed_linkWithMesh,
    pushed_body,
    pushed_kinds
};

START_TEST(a_heavy_cloth_pushes_what_rests_through_no_mesh)
{
    const qcModel plate = qcBoxModel(btVector3(2, btScalar(0.01), 2), 4);
    const btVector3 half(btScalar(0.3), btScalar(0.03), btScalar(0.3));
    const std::unique_ptr<qcMeshShape> shape = plate.MakeShape(), mesh = qcBoxModel(half, 2).MakeShape();
    btBoxShape box(half);
    for (int kind = 0; kind < pushed_kinds; kind++)
    {
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
        qcMeshContact meshes;
        meshes.addTo(&world->World());
        btRigidBody wall(0, nullptr, shape.get()),
            body(btScalar(0.5), nullptr, &box, qcRobot::InertiaOf(btScalar(0.5), half));
        wall.setWorldTransform(btTransform(s_upright, btVector3(0, btScalar(-0.15), 0)));
        world->World().addRigidBody(&wall);
        btSoftBody* cloth = world->AddCloth(btScalar(0.3), false);
        cloth->setTotalMass(50);
        cloth->setVelocity(btVector3(0, -20, 0));
        {
            qcRobot robot(*world, 0, btScalar(0.5), half, false);
            robot.Finish();
            const btCollisionObject* pushed = &body;
            if (kind == pushed_body)
                world->World().addRigidBody(&body);
            else
            {
                btMultiBodyLinkCollider* link = robot.AddBox(-1, half);
                if (kind == pushed_linkWithMesh)
                    link->setCollisionShape(mesh.get());
                pushed = link;
            }
            int limited = 0;
            for (int step = 0; step < 20; step++)
            {
                world->Step();
                limited += meshes.getStatistics().limited;
                ck_assert_int_eq(meshes.getStatistics().unproven, 0);
                ck_assert_double_gt(double(pushed->getWorldTransform().getOrigin().y()), -0.15);
            }
            ck_assert_int_gt(limited, 0);
        }
        if (kind == pushed_body)
            world->World().removeRigidBody(&body);
        world->World().removeRigidBody(&wall);
    }
}
END_TEST

START_TEST(a_velocity_that_a_tick_callback_sets_leads_from_where_the_body_is)
{
    const btVector3 half(btScalar(0.1), btScalar(0.03), btScalar(0.1));
    const std::unique_ptr<qcMeshShape> shape = qcBoxModel(btVector3(2, btScalar(0.01), 2), 4).MakeShape();
    btBoxShape box(half);
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
    qcMeshContact meshes;
    meshes.addTo(&world->World());
    btRigidBody plate(0, nullptr, shape.get()), body(1, nullptr, &box, qcRobot::InertiaOf(1, half));
    body.setWorldTransform(btTransform(s_upright, btVector3(0, btScalar(0.2), 0)));
    world->World().addRigidBody(&plate);
    world->World().addRigidBody(&body);
    world->AddCloth(5, false);
    auto launch = [](btDynamicsWorld* of, btScalar)
    { static_cast<btRigidBody*>(of->getWorldUserInfo())->setLinearVelocity(btVector3(0, 60, 0)); };
    world->World().setInternalTickCallback(launch, &body);
    btScalar last = body.getWorldTransform().getOrigin().y();
    for (int step = 0; step < 4; step++)
    {
        world->Step();
        ck_assert_double_ge(double(body.getWorldTransform().getOrigin().y()), double(last) - 1e-6);
        last = body.getWorldTransform().getOrigin().y();
    }
    ck_assert_double_gt(double(last), 1);
    world->World().removeRigidBody(&body);
    world->World().removeRigidBody(&plate);
}
END_TEST

/// Replaces a robot by a mesh in the third step.
class Explosion : public btActionInterface
{
  public:
    Explosion(qcMultiBodyWorld& world, std::unique_ptr<qcRobot>& robot, btRigidBody& debris)
        : m_world(world.World()), m_robot(robot), m_debris(debris)
    {
        m_world.addAction(this);
    }
    ~Explosion() override
    {
        m_world.removeAction(this);
    }
    Explosion(const Explosion&) = delete;
    Explosion& operator=(const Explosion&) = delete;

    void updateAction(btCollisionWorld*, btScalar) override
    {
        if (++m_steps != 3)
            return;
        m_robot.reset();
        m_world.addRigidBody(&m_debris);
    }
    void debugDraw(btIDebugDraw*) override
    {
    }

  private:
    btMultiBodyDynamicsWorld& m_world;
    std::unique_ptr<qcRobot>& m_robot;
    btRigidBody& m_debris;
    int m_steps = 0;
};

START_TEST(a_robot_that_an_action_deletes_is_forgotten)
{
    const std::unique_ptr<qcMeshShape> shape = qcBoxModel(btVector3(2, btScalar(0.01), 2), 4).MakeShape();
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    btRigidBody wall(0, nullptr, shape.get()), debris(1, nullptr, shape.get(), btVector3(1, 1, 1));
    wall.setWorldTransform(btTransform(s_upright, btVector3(0, btScalar(-0.15), 0)));
    debris.setWorldTransform(btTransform(s_upright, btVector3(9, 9, 0)));
    std::unique_ptr<qcRobot> robot = std::make_unique<qcRobot>(*world, 2, btScalar(0.5), s_chainHalf, false);
    SetUpChain(*robot, btVector3(9, 0, 0));
    {
        Explosion explosion(*world, robot, debris);
        qcMeshContact meshes;
        meshes.addTo(&world->World());
        world->World().addRigidBody(&wall);
        world->AddCloth(btScalar(0.3), false);
        for (int step = 0; step < 6; step++)
            world->Step();
        ck_assert_ptr_null(robot.get());
    }
    world->World().removeRigidBody(&debris);
    world->World().removeRigidBody(&wall);
}
END_TEST

START_TEST(a_wedge_that_leaves_cloth_no_room_jams)
{
    // It slides along a floor that it is 1 cm deep in, and that only the cloth collides with. Its lower side rises by
    // two degrees: it would have to give way 29 times as far as the cloth needs.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    const btSoftBody* cloth = world->AddCloth(btScalar(0.02), false);
    const qcFixedBox floor(*world, btVector3(5, 1, 5), btVector3(0, -1, 0));
    const btVector3 half(btScalar(0.6), btScalar(0.02), btScalar(0.2));
    const btScalar force = 20, tilt = btScalar(2 * SIMD_RADS_PER_DEG), rise = half.x() * btSin(tilt);
    qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
    robot.Body().setBasePos(btVector3(btScalar(-1.7), btScalar(0.01) + rise, 0));
    const btQuaternion tilted(btVector3(0, 0, 1), -tilt);
    robot.Body().setupPrismatic(0, 1, qcRobot::InertiaOf(1, half), -1, tilted, quatRotate(tilted, btVector3(1, 0, 0)),
                                s_none, s_none, false);
    robot.Finish();
    robot.AddBox(0, half)->setIgnoreCollisionCheck(floor.Body(), true);
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    robot.Watch(oracle, btScalar(1e-6));
    for (btScalar time = 0; time < 2; time += world->TimeStep())
    {
        robot.Body().addLinkForce(0, btVector3(force, 0, 0));
        world->StepApart(oracle);
    }
    const btScalar way = robot.Body().getJointPos(0), speed = robot.Body().getJointVel(0);
    ck_assert_double_gt(double(way), 0.5);
    ck_assert_double_lt(double(speed * speed / 2), double(force * way));
}
END_TEST

START_TEST(a_slider_that_presses_cloth_on_a_floor_is_not_thrown_back)
{
    // It slides down a steep way: friction moves it along that, too.
    for (btScalar degrees : {btScalar(5), btScalar(10), btScalar(20), btScalar(45)})
    {
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
        btSoftBody* cloth = world->AddCloth(btScalar(0.012), false);
        const qcFixedBox floor(*world, btVector3(5, 1, 5), btVector3(0, -1, 0));
        qcSoftBodySettings settings = world->Contact().getSettings(cloth);
        settings.friction = 1;
        ck_assert_int_eq(world->Contact().setSettings(cloth, settings), qc_statusOk);
        const btScalar angle = degrees * SIMD_RADS_PER_DEG;
        const btVector3 half(btScalar(0.1), btScalar(0.1), btScalar(0.1)), way(btCos(angle), -btSin(angle), 0);
        qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
        robot.Body().setBasePos(btVector3(0, btScalar(0.15), 0) - way * btScalar(0.2));
        robot.Body().setupPrismatic(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, way, s_none, s_none, false);
        robot.Finish();
        btMultiBodyLinkCollider* slider = robot.AddBox(0, half);
        slider->setIgnoreCollisionCheck(floor.Body(), true);
        slider->setFriction(1);
        robot.Body().setJointVel(0, 1);
        qcMotionOracle oracle;
        oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
        robot.Watch(oracle, btScalar(1e-6));
        const btScalar energy = robot.Energy(s_gravity);
        for (btScalar time = 0; time < 2; time += world->TimeStep())
        {
            world->StepApart(oracle);
            // Bullet's step alone adds up to 0.09 J while it slides freely.
            ck_assert_double_lt(double(robot.Energy(s_gravity)), double(energy) + 0.2);
        }
    }
}
END_TEST

START_TEST(links_that_pushes_swing_into_another_cloth_do_not_pass_it)
{
    // A see-saw: a fast cloth strikes one end from above, the other end swings up through a second, flat one.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
    btSoftBody *thrown = world->AddCloth(btScalar(0.5), false), *flat = world->AddCloth(btScalar(0.06), false);
    thrown->translate(btVector3(btScalar(1.6), 0, 0));
    flat->translate(btVector3(btScalar(-1.6), 0, 0));
    thrown->setTotalMass(20);
    thrown->setVelocity(btVector3(0, -60, 0));
    const btVector3 half(btScalar(0.2), btScalar(0.02), btScalar(0.2)), arm(btScalar(0.8), 0, 0);
    qcRobot robot(*world, 2, 0, btVector3(1, 1, 1), true);
    const btVector3 inertia = qcRobot::InertiaOf(1, half);
    robot.Body().setupRevolute(0, 1, inertia, -1, s_upright, btVector3(0, 0, 1), s_none, arm, true);
    robot.Body().setupFixed(1, 1, inertia, 0, s_upright, -arm, -arm);
    robot.Finish();
    robot.AddBox(0, half);
    robot.AddBox(1, half);
    qcMotionOracle oracle;
    for (const btSoftBody* cloth : {thrown, flat})
        oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    robot.Watch(oracle);
    btScalar most = 0;
    for (btScalar time = 0; time < btScalar(0.2); time += world->TimeStep())
    {
        world->StepApart(oracle);
        most = btMax(most, btFabs(robot.Body().getJointPos(0)));
    }
    ck_assert_double_gt(double(most), 0.2);
}
END_TEST

START_TEST(boxes_that_are_fixed_to_each_other_are_as_heavy_as_one)
{
    // A push on one of them moves all: the cloth gets as much of their momentum as from one box of the same size.
    btScalar momenta[2];
    for (int count : {1, 5})
    {
        std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
        const btSoftBody* cloth = world->AddCloth(0, false);
        const btScalar length = btScalar(0.25) / btScalar(count);
        const btVector3 half(length, btScalar(0.05), btScalar(0.2)), next(2 * length, 0, 0);
        const btScalar mass = 1 / btScalar(count);
        qcRobot robot(*world, count - 1, mass, half, false);
        robot.Body().setBasePos(btVector3(length - btScalar(0.25), btScalar(0.2), 0));
        for (int link = 0; link + 1 < count; link++)
            robot.Body().setupFixed(link, mass, qcRobot::InertiaOf(mass, half), link - 1, s_upright, next, s_none);
        robot.Finish();
        for (int link = -1; link + 1 < count; link++)
            robot.AddBox(link, half);
        robot.Body().setBaseVel(btVector3(0, -4, 0));
        for (btScalar time = 0; time < btScalar(0.3); time += world->TimeStep())
            world->Step();
        momenta[count == 1 ? 0 : 1] = qcMomentumOf(cloth).y();
    }
    ck_assert_double_lt(double(momenta[0]), -0.5);
    ck_assert_double_eq_tol(double(momenta[1]), double(momenta[0]), 0.1);
}
END_TEST

START_TEST(contact_does_not_move_joints_that_are_kinematic)
{
    // The application drives the first joint; a plate hangs from it by a spring-less hinge.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    world->AddCloth(0, true);
    const btVector3 half(btScalar(0.3), btScalar(0.02), btScalar(0.3)), inertia = qcRobot::InertiaOf(1, half);
    qcRobot robot(*world, 2, 0, btVector3(1, 1, 1), true);
    robot.Body().setBasePos(btVector3(0, btScalar(0.2), 0));
    robot.Body().setupPrismatic(0, 1, inertia, -1, s_upright, btVector3(0, 1, 0), s_none, s_none, true);
    robot.Body().setupRevolute(1, 1, inertia, 0, s_upright, btVector3(0, 0, 1), s_none, btVector3(btScalar(0.3), 0, 0),
                               true);
    robot.Finish();
    robot.AddBox(0, btVector3(btScalar(0.02), btScalar(0.02), btScalar(0.02)));
    robot.AddBox(1, half);
    robot.Body().setLinkDynamicType(0, btCollisionObject::CF_KINEMATIC_OBJECT);
    btScalar height = 0;
    for (btScalar time = 0; time < 1; time += world->TimeStep())
    {
        height -= world->TimeStep();
        robot.Body().setJointPos(0, height);
        robot.Place();
        world->Step();
        ck_assert_double_eq_tol(double(robot.Body().getJointPos(0)), double(height), 1e-6);
    }
    // The cloth has turned the plate up.
    ck_assert_double_gt(double(robot.Body().getJointPos(1)), 0.1);
}
END_TEST

START_TEST(a_collider_that_its_multibody_does_not_move_stands_still)
{
    // The base has another one, or none.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    const btVector3 half(btScalar(0.2), btScalar(0.02), btScalar(0.2));
    qcRobot robot(*world, 0, 1, half, false);
    robot.Finish();
    const btMultiBodyLinkCollider* left = robot.AddBox(-1, half);
    robot.Body().setBaseCollider(nullptr);
    const btVector3 place = left->getWorldTransform().getOrigin();
    const btSoftBody* cloth = world->AddCloth(btScalar(0.1), false);
    for (btScalar time = 0; time < btScalar(0.5); time += world->TimeStep())
        world->Step();
    ck_assert(left->getWorldTransform().getOrigin() == place);
    ck_assert_double_gt(double(HighestNode(cloth)), 0.02);
}
END_TEST

START_TEST(cloth_that_strikes_one_side_turns_a_planar_joint)
{
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_none);
    const btVector3 half(btScalar(0.3), btScalar(0.02), btScalar(0.3));
    qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
    robot.Body().setBasePos(btVector3(1, 0, 0));
    robot.Body().setupPlanar(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, btVector3(0, 0, 1), s_none, true);
    robot.Finish();
    robot.AddBox(0, half);
    world->AddCloth(btScalar(0.1), false)->setVelocity(btVector3(0, -3, 0));
    for (btScalar time = 0; time < btScalar(0.3); time += world->TimeStep())
        world->Step();
    const btScalar* planar = robot.Body().getJointPosMultiDof(0);
    ck_assert_double_gt(double(planar[0]), 0.1);
    ck_assert_double_lt(double(robot.Body().getLink(0).m_cachedWorldTransform.getOrigin().y()), -0.05);
}
END_TEST

START_TEST(cloth_wakes_a_multibody_that_sleeps)
{
    // A flap that turns about its middle, at an edge of the cloth: nothing but that turns it.
    std::unique_ptr<qcMultiBodyWorld> world = qcMakeMultiBodyWorld(_i != 0, s_gravity);
    const btVector3 half(btScalar(0.3), btScalar(0.02), btScalar(0.3));
    qcRobot robot(*world, 1, 0, btVector3(1, 1, 1), true);
    robot.Body().setBasePos(btVector3(1, 0, 0));
    robot.Body().setupRevolute(0, 1, qcRobot::InertiaOf(1, half), -1, s_upright, btVector3(0, 0, 1), s_none, s_none,
                               false);
    robot.Finish();
    const btMultiBodyLinkCollider* flap = robot.AddBox(0, half);
    robot.Body().setSleepTimeout(btScalar(0.2));
    for (int step = 0; step < 600 && flap->isActive(); step++)
        world->Step();
    ck_assert(!flap->isActive() && !robot.Body().isAwake());
    world->AddCloth(btScalar(0.1), false);
    btScalar angle = 0;
    for (btScalar time = 0; time < 1; time += world->TimeStep())
    {
        world->Step();
        angle = btMax(angle, robot.Body().getJointPos(0));
    }
    ck_assert_double_gt(double(angle), 0.2);
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("soft_multibody");
    const TTest* const all[] = {a_link_passes_no_cloth,
                                nor_does_a_body_that_its_factors_guide,
                                a_driven_arm_sweeps_a_cloth_aside,
                                contact_keeps_the_momentum_of_cloth_and_links,
                                a_cloth_catches_a_chain_of_links,
                                links_that_the_application_moves_move_cloth_without_a_world_that_steps_them,
                                fingers_lift_a_cloth_that_they_press_against_a_board,
                                random_arms_that_strike_a_cloth_on_the_floor_pass_nothing,
                                random_arms_between_a_cloth_and_a_thin_mesh_pass_neither,
                                a_heavy_cloth_pushes_what_rests_through_no_mesh,
                                a_velocity_that_a_tick_callback_sets_leads_from_where_the_body_is,
                                a_robot_that_an_action_deletes_is_forgotten,
                                a_wedge_that_leaves_cloth_no_room_jams,
                                a_slider_that_presses_cloth_on_a_floor_is_not_thrown_back,
                                links_that_pushes_swing_into_another_cloth_do_not_pass_it,
                                boxes_that_are_fixed_to_each_other_are_as_heavy_as_one,
                                contact_does_not_move_joints_that_are_kinematic,
                                a_collider_that_its_multibody_does_not_move_stands_still,
                                cloth_that_strikes_one_side_turns_a_planar_joint,
                                cloth_wakes_a_multibody_that_sleeps};
    // Each in the classic world, and in the deformable one.
    for (const TTest* test : all)
        tcase_add_loop_test(tests, test, 0, 2);
    return qcRunCase("soft_multibody", tests);
}
