// Friction of cloth is Coulomb's, at every time step: a strip that hangs over the edge of a table slides off where the
// weight of what hangs exceeds the friction of what lies, and stays otherwise; cloths and rigid bodies slide down a
// cloth, or stay. A conveyor belt carries it.
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>

#include <algorithm>
#include <cmath>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr btScalar s_length = 2, s_halfWidth = btScalar(0.15), s_height = btScalar(0.012);
constexpr int s_nodesAlong = 61, s_nodesAcross = 9;
constexpr double s_seconds = 3;

/// The part of the strip that hangs where its weight and friction are in balance: around the edge, a quarter turn, the
/// pull falls by exp(-friction * angle) (Euler, Eytelwein).
double BalancedPart(double friction)
{
    return friction / (friction + std::exp(-friction * SIMD_HALF_PI));
}

/// A rectangle between two corners, at one height.
btSoftBody* AddCloth(qcSoftWorld* made, const btVector3& lower, const btVector3& upper, int nodesAlong, int nodesAcross,
                     double friction)
{
    const btScalar y = lower.y();
    btSoftBody* cloth = made->AddPatch(lower, btVector3(upper.x(), y, lower.z()), btVector3(lower.x(), y, upper.z()),
                                       upper, nodesAlong, nodesAcross, friction);
    cloth->m_cfg.piterations = 8;
    return cloth;
}

/// A strip along x, whose last `part` is beyond the edge of the table at x = 0.
struct HangingStrip
{
    qcSoftWorld made;
    btSoftBody* strip;
    std::vector<int> end; ///< nodes of the end on the table

    HangingStrip(double part, double friction)
    {
        btRigidBody* table =
            made.AddMesh(qcBoxModel(btVector3(2, btScalar(0.25), 1), 8), 0, btVector3(-2, btScalar(-0.25), 0));
        table->setFriction(1);
        const btScalar beyond = btScalar(part) * s_length, start = beyond - s_length;
        strip = AddCloth(&made, btVector3(start, s_height, -s_halfWidth), btVector3(beyond, s_height, s_halfWidth),
                         s_nodesAlong, s_nodesAcross, friction);
        strip->m_cfg.piterations = 20;
        for (int i = 0; i < strip->m_nodes.size(); i++)
            if (strip->m_nodes[i].m_x.x() < start + btScalar(0.001))
                end.push_back(i);
        ck_assert_uint_eq(end.size(), s_nodesAcross);
    }

    /// Of the end on the table.
    double Place() const
    {
        double sum = 0;
        for (int node : end)
            sum += double(strip->m_nodes[node].m_x.x());
        return sum / double(end.size());
    }

    /// How far the end slides in the second half of the run.
    double Slide(int stepsPerSecond)
    {
        const int steps = int(s_seconds * stepsPerSecond);
        double middle = 0;
        for (int step = 0; step < steps; step++)
        {
            if (step == steps / 2)
                middle = Place();
            made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
            ck_assert_int_eq(made.softSolver.getStatistics().status, qc_statusOk);
        }
        return Place() - middle;
    }
};

START_TEST(a_strip_slides_off_a_table_where_its_weight_exceeds_its_friction)
{
    const int stepsPerSecond = 60 << _i;
    for (double friction : {0.1, 0.3})
    {
        const double stays = HangingStrip(0.8 * BalancedPart(friction), friction).Slide(stepsPerSecond);
        ck_assert_msg(stays < 0.01, "friction %g: slides by %g m", friction, stays);
        const double slides = HangingStrip(1.2 * BalancedPart(friction), friction).Slide(stepsPerSecond);
        ck_assert_msg(slides > 0.5, "friction %g: slides by %g m", friction, slides);
    }
}
END_TEST

/// A pinned cloth on which something may slide. Gravity is tilted instead of it.
struct TiltedCloth
{
    qcSoftWorld made;
    const double friction, tilt;

    /// `slope`: its tangent.
    TiltedCloth(double ofAll, double slope) : friction(ofAll), tilt(std::atan(slope))
    {
        made.meshContact.addTo(&made.world);
        made.SetGravity(btVector3(btScalar(10 * std::sin(tilt)), btScalar(-10 * std::cos(tilt)), 0));
        btSoftBody* lower = AddCentered(btVector3(3, 0, btScalar(0.6)), 61, 13);
        for (int i = 0; i < lower->m_nodes.size(); i++)
            lower->setMass(i, 0);
    }

    /// A rectangle around the y axis; `corner`: that of largest coordinates.
    btSoftBody* AddCentered(const btVector3& corner, int nodesAlong, int nodesAcross)
    {
        return AddCloth(&made, corner * btVector3(-1, 1, -1), corner, nodesAlong, nodesAcross, friction);
    }

    /// By Coulomb's law, of what slides.
    double Expected() const
    {
        return std::max(0.0, 10 * (std::sin(tilt) - friction * std::cos(tilt)));
    }
    /// The mean acceleration in the second half of a second. `speed`: returns that along the slope.
    template <typename Speed> double Acceleration(int stepsPerSecond, const Speed& speed)
    {
        double middle = 0;
        for (int step = 0; step < stepsPerSecond; step++)
        {
            if (step == stepsPerSecond / 2)
                middle = speed();
            made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
        }
        return 2 * (speed() - middle);
    }
};

constexpr double s_friction = 0.3;
constexpr double s_slopes[] = {0.8 * s_friction, 1.3 * s_friction, 2 * s_friction, 4 * s_friction};

void CheckAcceleration(double found, double expected, double slope)
{
    ck_assert_msg(std::fabs(found - expected) < 0.02 + 0.05 * expected, "slope %g: %g m/s2, not %g", slope, found,
                  expected);
}

START_TEST(a_cloth_slides_down_another_one_as_friction_has_it)
{
    const int stepsPerSecond = 60 << _i;
    for (double slope : s_slopes)
    {
        TiltedCloth tilted(s_friction, slope);
        const btSoftBody* cloth = tilted.AddCentered(btVector3(btScalar(0.5), s_height, btScalar(0.3)), 21, 13);
        auto speed = [cloth]
        {
            double sum = 0;
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                sum += double(cloth->m_nodes[i].m_v.x());
            return sum / cloth->m_nodes.size();
        };
        CheckAcceleration(tilted.Acceleration(stepsPerSecond, speed), tilted.Expected(), slope);
    }
}
END_TEST

START_TEST(rigid_bodies_slide_down_a_cloth_as_friction_has_it)
{
    const int stepsPerSecond = 60 << _i;
    const btVector3 half(btScalar(0.3), btScalar(0.1), btScalar(0.2)), place(0, btScalar(0.117), 0);
    for (double slope : s_slopes)
        for (bool isMesh : {false, true})
        {
            TiltedCloth tilted(s_friction, slope);
            btBoxShape box(half);
            btRigidBody* body =
                isMesh ? tilted.made.AddMesh(qcBoxModel(half, 3), 1, place) : tilted.made.AddBody(&box, 1, place);
            body->setFriction(1);
            body->setActivationState(DISABLE_DEACTIVATION);
            auto speed = [body] { return double(body->getLinearVelocity().x()); };
            CheckAcceleration(tilted.Acceleration(stepsPerSecond, speed), tilted.Expected(), slope);
            tilted.made.RemoveAll();
        }
}
END_TEST
/// A cloth of 1 m just above the ground.
btSoftBody* AddSquare(qcSoftWorld* made, double friction)
{
    return AddCloth(made, btVector3(btScalar(-0.5), s_height, btScalar(-0.5)),
                    btVector3(btScalar(0.5), s_height, btScalar(0.5)), 15, 15, friction);
}

/// A cloth on a belt: a box that stays in place and has velocities.
struct Conveyor
{
    qcSoftWorld made;
    btBoxShape shape{btVector3(5, btScalar(0.5), 5)};
    btRigidBody* belt;
    btSoftBody* cloth;
    btVector3 linear, angular;

    /// Bullet finds the velocities of kinematic bodies from their transforms: these get theirs before each step.
    Conveyor(bool isKinematic, const btVector3& moves, const btVector3& turns)
        : belt(made.AddBody(&shape, 0, btVector3(0, btScalar(-0.5), 0))), cloth(AddSquare(&made, 0.8)), linear(moves),
          angular(turns)
    {
        belt->setFriction(btScalar(0.8));
        if (isKinematic)
            belt->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        belt->setActivationState(DISABLE_DEACTIVATION);
        auto set = [](btDynamicsWorld* world, btScalar)
        {
            auto* conveyor = static_cast<Conveyor*>(world->getWorldUserInfo());
            conveyor->belt->setLinearVelocity(conveyor->linear);
            conveyor->belt->setAngularVelocity(conveyor->angular);
        };
        made.world.setInternalTickCallback(set, this, true);
    }
    Conveyor(const Conveyor&) = delete;
    Conveyor& operator=(const Conveyor&) = delete;

    ~Conveyor()
    {
        made.RemoveAll();
    }
};

START_TEST(a_conveyor_belt_carries_cloth)
{
    const bool isKinematic = _i == 1;
    Conveyor moving(isKinematic, btVector3(1, 0, 0), btVector3(0, 0, 0)),
        turning(isKinematic, btVector3(0, 0, 0), btVector3(0, 1, 0));
    for (int step = 0; step < 120; step++)
        for (Conveyor* conveyor : {&moving, &turning})
            conveyor->made.world.stepSimulation(btScalar(1.0 / 60), 0);
    for (int i = 0; i < moving.cloth->m_nodes.size(); i++)
    {
        ck_assert_double_lt(double((moving.cloth->m_nodes[i].m_v - btVector3(1, 0, 0)).length()), 0.05);
        const btSoftBody::Node& node = turning.cloth->m_nodes[i];
        ck_assert_double_lt(double((node.m_v - btVector3(0, 1, 0).cross(node.m_x)).length()), 0.1);
    }
    ck_assert(moving.belt->getWorldTransform().getOrigin() == btVector3(0, btScalar(-0.5), 0));
}
END_TEST
START_TEST(a_kinematic_body_that_moves_over_substeps_carries_cloth_no_further)
{
    // In all substeps it has the velocity of its motion, which it makes in the first. Friction is so large that the
    // cloth sticks.
    qcSoftWorld made;
    btBoxShape shape(btVector3(5, btScalar(0.5), 5));
    btRigidBody* board = made.AddBody(&shape, 0, btVector3(0, btScalar(-0.5), 0));
    board->setFriction(100);
    board->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    board->setActivationState(DISABLE_DEACTIVATION);
    const btSoftBody* cloth = AddSquare(&made, 1);
    // Half a metre a second, four substeps each; it stands for a while, and once more.
    for (int frame = 0; frame < 60; frame++)
    {
        btTransform place = board->getWorldTransform();
        if (frame >= 10 && frame < 50)
            place.getOrigin() += btVector3(btScalar(1.0 / 120), 0, 0);
        board->setWorldTransform(place);
        made.world.stepSimulation(btScalar(1.0 / 60), 4, btScalar(1.0 / 240));
    }
    const double moved = double(board->getWorldTransform().getOrigin().x());
    ck_assert_double_eq_tol(moved, 1.0 / 3, 1e-4);
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        const double start = -0.5 + (i % 15) / 14.0;
        ck_assert_double_eq_tol(double(cloth->m_nodes[i].m_x.x()) - start, moved, 0.03);
    }
    made.RemoveAll();
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("cloth_friction");
    tcase_add_loop_test(tests, a_strip_slides_off_a_table_where_its_weight_exceeds_its_friction, 0, 4);
    tcase_add_loop_test(tests, a_cloth_slides_down_another_one_as_friction_has_it, 0, 3);
    tcase_add_loop_test(tests, rigid_bodies_slide_down_a_cloth_as_friction_has_it, 0, 3);
    tcase_add_loop_test(tests, a_conveyor_belt_carries_cloth, 0, 2);
    tcase_add_test(tests, a_kinematic_body_that_moves_over_substeps_carries_cloth_no_further);
    return qcRunCase("cloth_friction", tests);
}
