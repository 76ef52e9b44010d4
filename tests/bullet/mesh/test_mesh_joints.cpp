// Meshes that Bullet's constraints join: limits hold them off walls, and the joints bring them together again.
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/motion_oracle.h"

#include "bullet/add_loop.h"
#include "bullet/random_numbers.h"

namespace
{
constexpr int s_starts = 24, s_longStarts = 400;
// Bullet corrects a joint that has come apart by velocities.
constexpr double s_drift = 1.01;
const btVector3 s_x(1, 0, 0), s_y(0, 1, 0), s_z(0, 0, 1);

/// A mesh that lies along the x axis.
struct Link
{
    qcModel model;
    btScalar length;
};

/// Along the x axis.
qcModel CapsuleModel(double radius, double half)
{
    qcModel model = qcSphereModel(radius, 2);
    for (size_t i = 0; i < model.positions.size(); i += 3)
        model.positions[i] += btScalar(model.positions[i] > 0 ? half : -half);
    return model;
}

const std::vector<Link>& Links()
{
    static const std::vector<Link> links = {
        {CapsuleModel(0.12, 0.15), btScalar(0.54)},
        {qcBoxModel(btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.1)), 2), btScalar(0.4)},
        {qcTorusModel(0.2, 0.06, 16, 8), btScalar(0.52)},
        {qcSphereModel(0.15, 2), btScalar(0.3)}};
    return links;
}

/// A joint, and the place of it in both bodies' frames.
struct Joint
{
    std::unique_ptr<btTypedConstraint> constraint;
    btTransform inA, inB;

    btScalar Gap() const
    {
        return (constraint->getRigidBodyA().getWorldTransform() * inA)
            .getOrigin()
            .distance((constraint->getRigidBodyB().getWorldTransform() * inB).getOrigin());
    }
};

enum JointKind
{
    joint_ball,
    joint_hinge,
    joint_fixed,
    joint_slider,
    joint_cone,
    joint_kinds
};

/// A floor, walls of 2 cm, and bodies with joints. The bodies of one chain may meet each other.
struct JointWorld
{
    qcMeshWorld world;
    qcMotionOracle oracle;
    std::vector<Joint> joints;
    const qcModel floor = qcFloorModel(12, 16), wall = qcBoxModel(btVector3(2, 1, btScalar(0.01)), 4);

    explicit JointWorld(int walls)
    {
        AddFixed(floor, btVector3(0, 0, 0));
        for (int i = 0; i < walls; i++)
            AddFixed(wall, btVector3(0, btScalar(1.1), btScalar(-1.5) - btScalar(i)));
    }
    ~JointWorld()
    {
        for (const Joint& joint : joints)
            world.world.removeConstraint(joint.constraint.get());
    }
    JointWorld(const JointWorld&) = delete;
    JointWorld& operator=(const JointWorld&) = delete;

    void AddFixed(const qcModel& model, const btVector3& place)
    {
        constexpr uint32_t fixed = 1000;
        oracle.Add(model, world.Add(world.Keep(model.MakeShape()), 0, place), fixed);
    }

    btRigidBody* Add(const qcModel& model, btScalar mass, const btTransform& place, uint32_t chain)
    {
        btRigidBody* body = world.Add(world.Keep(model.MakeShape()), mass, place);
        oracle.Add(model, body, chain);
        return body;
    }

    void Join(btRigidBody* a, btRigidBody* b, JointKind kind, const btTransform& place)
    {
        Joint joint;
        joint.inA = a->getWorldTransform().inverse() * place;
        joint.inB = b->getWorldTransform().inverse() * place;
        switch (kind)
        {
            case joint_ball:
                joint.constraint.reset(
                    new btPoint2PointConstraint(*a, *b, joint.inA.getOrigin(), joint.inB.getOrigin()));
                break;
            case joint_hinge:
                joint.constraint.reset(new btHingeConstraint(*a, *b, joint.inA, joint.inB));
                static_cast<btHingeConstraint&>(*joint.constraint).setLimit(-1, 1);
                break;
            case joint_fixed: joint.constraint.reset(new btFixedConstraint(*a, *b, joint.inA, joint.inB)); break;
            case joint_slider:
            {
                auto* slider = new btSliderConstraint(*a, *b, joint.inA, joint.inB, true);
                slider->setLowerLinLimit(0);
                slider->setUpperLinLimit(btScalar(0.2));
                joint.constraint.reset(slider);
                break;
            }
            default: joint.constraint.reset(new btConeTwistConstraint(*a, *b, joint.inA, joint.inB));
        }
        world.world.addConstraint(joint.constraint.get(), true);
        joints.push_back(std::move(joint));
    }

    /// One step, in which no bodies but those of a chain meet, and none is counted as unproven. Returns the number of
    /// limited bodies.
    int StepApart()
    {
        world.Step();
        ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
        ck_assert_uint_eq(oracle.Count(), 0);
        return world.contact.getStatistics().limited;
    }
};

/// Adds bodies side by side along the x axis, each joined to the one before.
void AddChain(JointWorld* made, qcRandomNumbers* random, uint32_t chain, const btVector3& velocity)
{
    btVector3 end(random->Number(-1, 1), btScalar(0.6) + btScalar(0.8) * btScalar(chain), random->Number(0, 2));
    const int count = int(random->Number(2, 8)), kind = int(random->Number(0, joint_kinds));
    btRigidBody* last = nullptr;
    for (int i = 0; i < count; i++)
    {
        const Link& link = Links()[size_t(random->Number(0, 3.999))];
        const btTransform place(btQuaternion::getIdentity(), end + link.length / 2 * s_x);
        btRigidBody* body = made->Add(link.model, random->Number(0.3, 3), place, chain);
        body->setLinearVelocity(velocity + random->Vector(1));
        if (random->Number(0, 3) < 1)
            body->setAngularVelocity(random->Vector(10));
        const bool isOther = random->Number(0, 2) < 1;
        if (last != nullptr)
            made->Join(last, body, JointKind(isOther ? int(random->Number(0, joint_kinds)) : kind),
                       btTransform(btQuaternion::getIdentity(), end));
        last = body;
        end += (link.length + btScalar(0.02)) * s_x;
    }
}

START_TEST(joined_meshes_thrown_at_thin_walls_pass_nothing)
{
    qcRandomNumbers random(unsigned(_i + 1));
    JointWorld made(int(random.Number(0, 3)));
    const btScalar speed = random.Number(0, 2) < 1 ? random.Number(5, 80) : random.Number(0, 3);
    for (uint32_t chain = 1; chain <= 3; chain++)
        AddChain(&made, &random, chain, -speed * s_z);
    ck_assert_uint_eq(made.oracle.CountNow(), 0);
    const double energy = made.world.Energy();
    int limited = 0;
    for (int step = 0; step < 180; step++)
    {
        limited += made.StepApart();
        ck_assert_double_le(made.world.Energy(), energy * s_drift);
    }
    printf("start %d: %zu joints at %.0f m/s, %d bodies limited\n", _i, made.joints.size(), double(speed), limited);
}
END_TEST

enum Exemption
{
    exemption_none,
    exemption_joint,   ///< by the second argument of addConstraint
    exemption_ignored, ///< setIgnoreCollisionCheck
    exemption_kinds
};

START_TEST(a_pendulum_passes_only_the_post_with_which_it_does_not_collide)
{
    const qcModel cube = qcCubeModel();
    const btVector3 pivot(0, 3, 0), side(2, 0, 0);
    qcMeshWorld world;
    btCollisionShape* shape = world.Keep(cube.MakeShape());
    btRigidBody *post = world.Add(shape, 0, pivot - btVector3(0, 2, 0)), *bob = world.Add(shape, 1, pivot + side);
    btPoint2PointConstraint joint(*post, *bob, btVector3(0, 2, 0), -side);
    world.world.addConstraint(&joint, _i == exemption_joint);
    if (_i == exemption_ignored)
        bob->setIgnoreCollisionCheck(post, true);
    btScalar furthest = side.x();
    int limited = 0;
    for (int step = 0; step < 120; step++)
    {
        world.Step();
        limited += world.contact.getStatistics().limited;
        ck_assert_int_eq(world.contact.getStatistics().unproven, 0);
        furthest = std::min(furthest, bob->getWorldTransform().getOrigin().x());
    }
    world.world.removeConstraint(&joint);
    if (_i == exemption_none)
        ck_assert_double_gt(double(furthest), 0);
    else
    {
        ck_assert_double_lt(double(furthest), -1.5);
        ck_assert_int_eq(limited, 0);
    }
}
END_TEST

START_TEST(a_doll_thrown_at_a_wall_comes_to_rest_whole)
{
    const qcModel torso = CapsuleModel(0.12, 0.12), head = qcSphereModel(0.1, 2), arm = CapsuleModel(0.05, 0.12);
    JointWorld made(1);
    auto at = [](double x, double y)
    { return btTransform(btQuaternion::getIdentity(), btVector3(btScalar(x), btScalar(y), 0)); };
    const btTransform upright(btQuaternion(s_z, SIMD_HALF_PI), btVector3(0, 1, 0));
    btRigidBody* middle = made.Add(torso, 3, upright, 1);
    made.Join(middle, made.Add(head, 1, at(0, 1.38), 1), joint_cone, at(0, 1.26));
    for (int side = -1; side <= 1; side += 2)
    {
        btRigidBody *upper = made.Add(arm, 1, at(0.32 * side, 1.1), 1),
                    *fore = made.Add(arm, btScalar(0.7), at(0.68 * side, 1.1), 1);
        made.Join(middle, upper, joint_ball, at(0.14 * side, 1.1));
        made.Join(upper, fore, joint_hinge, at(0.5 * side, 1.1));
    }
    for (const auto& body : made.world.bodies)
        if (!body->isStaticObject())
            body->setLinearVelocity(-50 * s_z);
    int limited = 0;
    for (int step = 0; step < 480; step++)
        limited += made.StepApart();
    ck_assert_int_gt(limited, 0);
    for (const auto& body : made.world.bodies)
        ck_assert(body->isStaticObject() || (!body->isActive() && body->getWorldTransform().getOrigin().z() > -1.5));
    for (const Joint& joint : made.joints)
        ck_assert_double_lt(double(joint.Gap()), 0.02);
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("mesh_joints");
    qcAddLoop(tests, joined_meshes_thrown_at_thin_walls_pass_nothing, qcIsLongForm() ? s_longStarts : s_starts);
    tcase_add_loop_test(tests, a_pendulum_passes_only_the_post_with_which_it_does_not_collide, 0, exemption_kinds);
    tcase_add_test(tests, a_doll_thrown_at_a_wall_comes_to_rest_whole);
    return qcRunCase("mesh_joints", tests);
}
