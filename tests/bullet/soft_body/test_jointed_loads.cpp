// Bodies of tetrahedra with bodies that are anchored to them, and with links of multibodies that carry or press them,
// in the deformable world: nothing gains energy, and both sides bear each other.
#include "bullet/soft_body/load_world.h"
#include "bullet/soft_body/multibody_world.h"

#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>

namespace
{
enum class Load
{
    rigid,
    base, ///< of a multibody
    link  ///< that slides upright
};

/// A soft cube of Neo-Hookean material in a world of explicit forces.
struct SoftCubeWorld : qcLoadWorld
{
    std::unique_ptr<btDeformableNeoHookeanForce> elasticity;
    btSoftBody* cube;

    /// `size`: of the cube, whose lowest point is at this height.
    SoftCubeWorld(const btVector3& g, double rate, btScalar size, int cells, btScalar height, btScalar mass)
        : qcLoadWorld(g, false), elasticity(new btDeformableNeoHookeanForce(2000, 4000, btScalar(0.05)))
    {
        step = btScalar(1 / rate);
        cube = qcAsTetraBody(qcMakeTetraCube(world->getWorldInfo(), btVector3(-size / 2, height, -size / 2), cells,
                                             size / btScalar(cells), false));
        cube->setTotalMass(mass);
        cube->m_cfg.kDF = btScalar(0.5);
        cloths.push_back(cube);
        world->addSoftBody(cube);
        world->addForce(cube, &gravity);
        world->addForce(cube, elasticity.get());
    }

    ~SoftCubeWorld()
    {
        // Before its force.
        world->removeSoftBody(cube);
        delete cube;
        cloths.clear();
    }

    SoftCubeWorld(const SoftCubeWorld&) = delete;
    SoftCubeWorld& operator=(const SoftCubeWorld&) = delete;

    /// Anchors the nodes at the cube's top.
    template <typename Object> void AnchorTop(Object* object)
    {
        btScalar top = -BT_LARGE_FLOAT;
        for (int i = 0; i < cube->m_nodes.size(); i++)
            top = std::max(top, cube->m_nodes[i].m_x.y());
        for (int i = 0; i < cube->m_nodes.size(); i++)
            if (cube->m_nodes[i].m_x.y() > top - btScalar(0.01))
                cube->appendDeformableAnchor(i, object);
    }
};

/// A multibody whose links slide along an axis each, some by motors. It doesn't sleep.
struct Slides
{
    btMultiBodyDynamicsWorld& world;
    qcRobot robot;
    std::vector<std::unique_ptr<btMultiBodyJointMotor>> motors;

    Slides(btMultiBodyDynamicsWorld& in, int links, btScalar baseMass, const btVector3& half, const btVector3& place)
        : world(in), robot(in, links, baseMass, half, baseMass == 0)
    {
        robot.Body().setBasePos(place);
        robot.Body().setCanSleep(false);
    }

    ~Slides()
    {
        for (const auto& motor : motors)
            world.removeMultiBodyConstraint(motor.get());
    }

    Slides(const Slides&) = delete;
    Slides& operator=(const Slides&) = delete;

    void SetLink(int link, btScalar mass, const btVector3& half, const btVector3& axis, const btVector3& fromBase)
    {
        robot.Body().setupPrismatic(link, mass, qcRobot::InertiaOf(mass, half), -1, btQuaternion::getIdentity(), axis,
                                    fromBase, btVector3(0, 0, 0), true);
    }

    btMultiBodyLinkCollider* AddBox(int link, const btVector3& half)
    {
        btMultiBodyLinkCollider* collider = robot.AddBox(link, half);
        collider->setFriction(1);
        return collider;
    }

    btMultiBodyJointMotor* AddMotor(int link, btScalar maxImpulse)
    {
        motors.emplace_back(new btMultiBodyJointMotor(&robot.Body(), link, 0, maxImpulse));
        motors.back()->finalizeMultiDof();
        world.addMultiBodyConstraint(motors.back().get());
        return motors.back().get();
    }
};

START_TEST(a_load_anchored_to_a_cube_comes_to_rest)
{
    const btVector3 half(btScalar(0.4), btScalar(0.05), btScalar(0.4));
    for (const Load load : {Load::rigid, Load::base, Load::link})
        for (const double rate : {120.0, 240.0})
        {
            SoftCubeWorld world(btVector3(0, -10, 0), rate, btScalar(0.6), 2, btScalar(0.3), 1);
            const btVector3 place(0, btScalar(0.98), 0);
            std::unique_ptr<Slides> slides;
            const btCollisionObject* object;
            if (load == Load::rigid)
            {
                btVector3 inertia;
                world.boxShape.setLocalScaling(half / btVector3(btScalar(0.4), btScalar(0.2), btScalar(0.4)));
                btRigidBody* box = world.AddBox(place.y(), 2);
                world.AnchorTop(box);
                object = box;
            }
            else
            {
                const bool isLink = load == Load::link;
                slides = std::make_unique<Slides>(*world.world, isLink, btScalar(isLink ? 0 : 2), half, place);
                if (isLink)
                    slides->SetLink(0, 2, half, btVector3(0, 1, 0), btVector3(0, 0, 0));
                slides->robot.Finish();
                btMultiBodyLinkCollider* collider = slides->AddBox(isLink ? 0 : -1, half);
                world.AnchorTop(collider);
                object = collider;
            }
            double highest = 0;
            for (int i = 0; i < int(4 * rate); i++)
            {
                world.Step(1);
                highest = std::max(highest, double(object->getWorldTransform().getOrigin().y()));
            }
            const double height = double(object->getWorldTransform().getOrigin().y());
            printf("load %d anchored to a cube, %g steps/s: highest %.3f, at rest %.3f, %.4f m/s\n", int(load), rate,
                   highest, height, double(qcSpeedOf(world.cube)));
            ck_assert_double_lt(highest, 0.985);
            ck_assert_double_gt(height, 0.65);
            ck_assert_double_lt(height, 0.72);
            ck_assert_double_lt(double(qcSpeedOf(world.cube)), 0.02);
            ck_assert_double_gt(qcSmallestVolume(world.cube), 0.8);
        }
}
END_TEST

START_TEST(a_tray_of_a_multibody_carries_a_cube)
{
    for (const double rate : {60.0, 120.0})
    {
        SoftCubeWorld world(btVector3(0, -10, 0), rate, btScalar(0.5), 4, btScalar(0.58), 1);
        const btVector3 half(btScalar(0.6), btScalar(0.05), btScalar(0.6));
        Slides tray(*world.world, 1, 0, half, btVector3(0, btScalar(0.5), 0));
        tray.SetLink(0, 20, half, btVector3(0, 1, 0), btVector3(0, 0, 0));
        tray.robot.Finish();
        const btMultiBodyLinkCollider* plate = tray.AddBox(0, half);
        btMultiBodyJointMotor* motor = tray.AddMotor(0, btScalar(1000 / rate));
        world.Step(int(1.5 * rate));
        motor->setVelocityTarget(btScalar(0.3));
        world.Step(int(1.5 * rate));
        printf("cube on a tray, %g steps/s: %.1f %% of its smallest volume, %.3f m/s\n", rate,
               100 * qcSmallestVolume(world.cube), double(qcSpeedOf(world.cube)));
        ck_assert_double_gt(qcSmallestVolume(world.cube), 0.95);
        ck_assert_double_lt(double(qcSpeedOf(world.cube)), 0.35);
        ck_assert_double_gt(double(plate->getWorldTransform().getOrigin().y()), 0.85);
        for (int i = 0; i < world.cube->m_nodes.size(); i++)
            ck_assert_double_gt(double(world.cube->m_nodes[i].m_x.y()),
                                double(plate->getWorldTransform().getOrigin().y()) + 0.05);
    }
}
END_TEST

START_TEST(fingers_of_a_multibody_hold_a_cube)
{
    for (const btScalar force : {btScalar(10), btScalar(40)})
    {
        const double rate = 120;
        SoftCubeWorld world(btVector3(0, -10, 0), rate, btScalar(0.3), 3, btScalar(0.02), btScalar(0.5));
        const btVector3 half(btScalar(0.03), btScalar(0.12), btScalar(0.12));
        Slides gripper(*world.world, 2, 0, half, btVector3(0, btScalar(0.2), 0));
        for (int i = 0; i < 2; i++)
            gripper.SetLink(i, 1, half, btVector3(btScalar(i == 0 ? 1 : -1), 0, 0),
                            btVector3(btScalar(i == 0 ? -0.3 : 0.3), 0, 0));
        gripper.robot.Finish();
        const btMultiBodyLinkCollider* fingers[2];
        for (int i = 0; i < 2; i++)
        {
            fingers[i] = gripper.AddBox(i, half);
            gripper.AddMotor(i, btScalar(force / rate))->setVelocityTarget(btScalar(0.3));
        }
        world.Step(int(rate));
        // The floor goes, and the fingers alone hold the cube.
        world.floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -5, 0)));
        world.Step(int(2 * rate));
        const double distance =
            double(fingers[1]->getWorldTransform().getOrigin().x() - fingers[0]->getWorldTransform().getOrigin().x());
        printf(
            "cube of 0.3 m between fingers with %g N: %.3f m between their centres, %.1f %% of its smallest volume\n",
            double(force), distance, 100 * qcSmallestVolume(world.cube));
        ck_assert_double_gt(distance, 0.3);
        ck_assert_double_lt(distance, 0.4);
        ck_assert_double_gt(qcSmallestVolume(world.cube), 0.8);
        ck_assert_double_gt(double(world.cube->m_nodes[0].m_x.y()), -0.1);
        ck_assert_double_lt(double(qcSpeedOf(world.cube)), 0.1);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("jointed_loads", a_load_anchored_to_a_cube_comes_to_rest, a_tray_of_a_multibody_carries_a_cube,
             fingers_of_a_multibody_hold_a_cube)
