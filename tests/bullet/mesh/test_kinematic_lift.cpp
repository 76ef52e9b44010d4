// A mesh that lies on a kinematic one goes down with it, pressed on it by its weight.
#include "bullet/mesh/mesh_world.h"

namespace
{
constexpr btScalar s_liftGravity = 10, s_loadHalf = btScalar(0.3), s_liftHalf = btScalar(0.1);

enum LiftShape
{
    lift_mesh,
    lift_box,
    lift_compoundOfMesh,
    lift_compoundOfBox,
    lift_nestedTiles, ///< a compound of two compounds of 16 boxes each, with trees
    lift_shapes
};

/// A platform at rest for a second, which then goes down, with half of gravity's acceleration up to a speed.
struct Lift : btMotionState
{
    qcMeshWorld made;
    btRigidBody *platform, *load;
    btTransform place = btTransform::getIdentity();
    btScalar speed = 0;

    /// `flags`: the platform's collision flags; `isCompound`: the load is a compound of its mesh.
    explicit Lift(int flags, LiftShape shape = lift_mesh, bool isCompound = false)
    {
        made.world.setGravity(btVector3(0, -s_liftGravity, 0));
        platform = made.Add(MakePlatform(shape), 0, btVector3(0, 0, 0));
        platform->setCollisionFlags(flags);
        platform->setActivationState(DISABLE_DEACTIVATION);
        platform->setMotionState(this);
        platform->setFriction(1);
        btCollisionShape* crate = made.Keep(qcBoxModel(btVector3(s_loadHalf, s_loadHalf, s_loadHalf), 2).MakeShape());
        load = made.Add(isCompound ? MakeCompound({crate}, {btVector3(0, 0, 0)}) : crate, 1,
                        btVector3(0, s_loadHalf + s_liftHalf + btScalar(0.02), 0));
        load->setFriction(btScalar(0.5));
        load->setActivationState(DISABLE_DEACTIVATION);
    }

    btCollisionShape* MakeCompound(const std::vector<btCollisionShape*>& children, const std::vector<btVector3>& places)
    {
        std::unique_ptr<btCompoundShape> compound(new btCompoundShape());
        for (size_t i = 0; i < children.size(); i++)
            compound->addChildShape(btTransform(btQuaternion::getIdentity(), places[i]), children[i]);
        return made.Keep(std::move(compound));
    }

    /// The load stands where four tiles meet, two of each half.
    btCollisionShape* MakeTiles()
    {
        btCollisionShape* tile =
            made.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, s_liftHalf, btScalar(0.5)))));
        std::vector<btVector3> places;
        for (int x = -1; x <= 1; x += 2)
            for (int z = -4; z < 4; z++)
                places.emplace_back(x, 0, btScalar(z) + btScalar(0.5));
        btCollisionShape* half = MakeCompound(std::vector<btCollisionShape*>(places.size(), tile), places);
        return MakeCompound({half, half}, {btVector3(-2, 0, 0), btVector3(2, 0, 0)});
    }

    btCollisionShape* MakePlatform(LiftShape kind)
    {
        if (kind == lift_nestedTiles)
            return MakeTiles();
        const btVector3 half(4, s_liftHalf, 4);
        const bool isMesh = kind == lift_mesh || kind == lift_compoundOfMesh;
        btCollisionShape* shape = isMesh ? made.Keep(qcBoxModel(half, 2).MakeShape())
                                         : made.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(half)));
        return kind == lift_mesh || kind == lift_box ? shape : MakeCompound({shape}, {btVector3(0, 0, 0)});
    }

    void getWorldTransform(btTransform& transform) const override
    {
        transform = place;
    }
    void setWorldTransform(const btTransform& /*transform*/) override
    {
    }

    /// A step at the present speed.
    void Step(btScalar timeStep)
    {
        place.getOrigin() -= btVector3(0, speed * timeStep, 0);
        made.world.stepSimulation(timeStep, 0);
        ck_assert_int_eq(made.contact.getStatistics().status, qc_statusOk);
    }

    /// A second at rest and one in which the platform speeds up.
    void GoDown(btScalar maxSpeed, int stepsPerSecond)
    {
        const btScalar timeStep = btScalar(1) / btScalar(stepsPerSecond);
        for (int step = 0; step < 2 * stepsPerSecond; step++)
        {
            if (step >= stepsPerSecond)
                speed = std::min(maxSpeed, speed + s_liftGravity / 2 * timeStep);
            Step(timeStep);
        }
    }

    /// By its friction the load then slides by 25 mm.
    void Push()
    {
        load->setLinearVelocity(load->getLinearVelocity() + btVector3(btScalar(0.5), 0, 0));
    }

    /// Where the load is, seen from the platform.
    btVector3 Offset() const
    {
        return load->getWorldTransform().getOrigin() - platform->getWorldTransform().getOrigin();
    }

    /// The sum of impulses on the load in the last step.
    btScalar NormalImpulse()
    {
        btScalar sum = 0;
        for (int i = 0; i < made.dispatcher.getNumManifolds(); i++)
        {
            const btPersistentManifold* manifold = made.dispatcher.getManifoldByIndexInternal(i);
            for (int k = 0; k < manifold->getNumContacts(); k++)
                sum += manifold->getContactPoint(k).m_appliedImpulse;
        }
        return sum;
    }
};

// Bodies without mass that are made kinematic have both flags.
constexpr int s_kinematicFlags[] = {btCollisionObject::CF_KINEMATIC_OBJECT,
                                    btCollisionObject::CF_KINEMATIC_OBJECT | btCollisionObject::CF_STATIC_OBJECT};

START_TEST(a_body_on_a_lift_that_goes_down_keeps_its_weight_and_friction)
{
    for (int stepsPerSecond : {30, 60, 120})
        for (btScalar speed : {btScalar(0.5), btScalar(1.5)})
        {
            Lift lift(s_kinematicFlags[_i]);
            const btScalar timeStep = btScalar(1) / btScalar(stepsPerSecond);
            lift.GoDown(speed, stepsPerSecond);
            const btScalar start = lift.Offset().x(), height = lift.Offset().y();
            lift.Push();
            btScalar impulse = 0;
            for (int step = 0; step < stepsPerSecond; step++)
            {
                lift.Step(timeStep);
                impulse += lift.NormalImpulse();
            }
            const double slid = double(lift.Offset().x() - start);
            ck_assert_msg(slid > 0.01 && slid < 0.045, "%d steps a second, %g m/s: slides by %g m", stepsPerSecond,
                          double(speed), slid);
            ck_assert_msg(btFabs(impulse / s_liftGravity - 1) < btScalar(0.03), "%d steps a second, %g m/s: weighs %g",
                          stepsPerSecond, double(speed), double(impulse / s_liftGravity));
            ck_assert_msg(btFabs(lift.Offset().y() - height) < btScalar(0.005), "%d steps a second, %g m/s: %g m high",
                          stepsPerSecond, double(speed), double(lift.Offset().y() - height));
        }
}
END_TEST

/// Four crates on a lift that goes down and up at 4 m/s.
void TowerStands(LiftShape shape, bool isCompound)
{
    Lift lift(s_kinematicFlags[0], shape, isCompound);
    std::vector<btRigidBody*> crates = {lift.load};
    for (int i = 1; i < 4; i++)
    {
        const btVector3 place = lift.load->getWorldTransform().getOrigin() +
                                btVector3(0, 2 * (s_loadHalf + btScalar(0.01)) * btScalar(i), 0);
        crates.push_back(lift.made.Add(lift.load->getCollisionShape(), 1, place));
        crates.back()->setActivationState(DISABLE_DEACTIVATION);
    }
    for (int step = 0; step < 600; step++)
    {
        lift.speed = 4 * btSin(btScalar(step) / 40);
        lift.Step(qcStep);
    }
    for (const btRigidBody* crate : crates)
    {
        const btTransform& place = crate->getWorldTransform();
        ck_assert_double_gt(double(place.getBasis()[1][1]), 0.99);
        ck_assert_double_lt(std::hypot(double(place.getOrigin().x()), double(place.getOrigin().z())), 0.15);
    }
}

START_TEST(a_tower_stands_on_a_lift_that_goes_down_and_up)
{
    TowerStands(LiftShape(_i), false);
}
END_TEST

START_TEST(a_tower_of_compounds_stands_on_a_lift)
{
    TowerStands(LiftShape(_i), true);
}
END_TEST

START_TEST(a_body_on_a_fast_lift_of_any_shape_keeps_its_friction)
{
    for (btScalar speed : {btScalar(1.5), btScalar(3), btScalar(6)})
    {
        Lift lift(s_kinematicFlags[0], LiftShape(_i));
        lift.GoDown(speed, 60);
        const btScalar start = lift.Offset().x();
        lift.Push();
        for (int step = 0; step < 60; step++)
            lift.Step(qcStep);
        const double slid = double(lift.Offset().x() - start);
        ck_assert_msg(slid > 0.01 && slid < 0.06, "%g m/s: slides by %g m", double(speed), slid);
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("kinematic_lift");
    tcase_add_loop_test(tests, a_body_on_a_lift_that_goes_down_keeps_its_weight_and_friction, 0, 2);
    tcase_add_loop_test(tests, a_tower_stands_on_a_lift_that_goes_down_and_up, 0, lift_shapes);
    tcase_add_loop_test(tests, a_tower_of_compounds_stands_on_a_lift, 0, lift_shapes);
    tcase_add_loop_test(tests, a_body_on_a_fast_lift_of_any_shape_keeps_its_friction, 0, lift_shapes);
    return qcRunCase("kinematic_lift", tests);
}
