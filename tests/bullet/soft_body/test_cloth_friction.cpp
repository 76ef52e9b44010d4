// Friction of cloth is Coulomb's, at every time step: a strip that hangs over the edge of a table slides off where the
// weight of what hangs exceeds the friction of what lies, and stays otherwise; a cloth slides down another one, or
// stays.
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

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
        auto at = [](btScalar x, btScalar z) { return btVector3(x, s_height, z); };
        strip = btSoftBodyHelpers::CreatePatch(made.world.getWorldInfo(), at(start, -s_halfWidth),
                                               at(beyond, -s_halfWidth), at(start, s_halfWidth),
                                               at(beyond, s_halfWidth), s_nodesAlong, s_nodesAcross, 0, true);
        strip->getCollisionShape()->setMargin(btScalar(0.01));
        strip->setTotalMass(btScalar(0.3));
        strip->m_cfg.piterations = 20;
        strip->m_cfg.kDF = btScalar(friction);
        made.world.addSoftBody(strip);
        made.cloths.push_back(strip);
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
/// A cloth on a larger one that is pinned. Gravity is tilted instead of both.
struct TiltedCloths
{
    qcSoftWorld made;
    btSoftBody* cloth;

    TiltedCloths(double friction, double slope)
    {
        const double tilt = std::atan(slope);
        made.SetGravity(btVector3(btScalar(10 * std::sin(tilt)), btScalar(-10 * std::cos(tilt)), 0));
        btSoftBody* lower = Add(btVector3(3, 0, btScalar(0.6)), 61, 13, friction);
        for (int i = 0; i < lower->m_nodes.size(); i++)
            lower->setMass(i, 0);
        cloth = Add(btVector3(btScalar(0.5), s_height, btScalar(0.3)), 21, 13, friction);
    }

    /// A rectangle around the y axis; `corner`: that of largest coordinates.
    btSoftBody* Add(const btVector3& corner, int nodesAlong, int nodesAcross, double friction)
    {
        auto at = [&](int x, int z) { return btVector3(btScalar(x), 1, btScalar(z)) * corner; };
        btSoftBody* added = btSoftBodyHelpers::CreatePatch(made.world.getWorldInfo(), at(-1, -1), at(1, -1), at(-1, 1),
                                                           at(1, 1), nodesAlong, nodesAcross, 0, true);
        added->getCollisionShape()->setMargin(btScalar(0.01));
        added->setTotalMass(btScalar(0.3));
        added->m_cfg.piterations = 8;
        added->m_cfg.kDF = btScalar(friction);
        made.world.addSoftBody(added);
        made.cloths.push_back(added);
        return added;
    }

    double Speed() const
    {
        btVector3 sum(0, 0, 0);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_v;
        return double(sum.x()) / cloth->m_nodes.size();
    }

    /// The mean acceleration in the second half of a second.
    double Acceleration(int stepsPerSecond)
    {
        double middle = 0;
        for (int step = 0; step < stepsPerSecond; step++)
        {
            if (step == stepsPerSecond / 2)
                middle = Speed();
            made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
        }
        return 2 * (Speed() - middle);
    }
};

START_TEST(a_cloth_slides_down_another_one_as_friction_has_it)
{
    const int stepsPerSecond = 60 << _i;
    const double friction = 0.3;
    ck_assert_double_lt(std::fabs(TiltedCloths(friction, 0.8 * friction).Acceleration(stepsPerSecond)), 0.02);
    for (double factor : {1.3, 2.0, 4.0})
    {
        const double tilt = std::atan(factor * friction);
        const double expected = 10 * (std::sin(tilt) - friction * std::cos(tilt));
        const double found = TiltedCloths(friction, factor * friction).Acceleration(stepsPerSecond);
        ck_assert_msg(std::fabs(found - expected) < 0.05 * expected, "%g times the friction: %g m/s2, not %g", factor,
                      found, expected);
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    Suite* suite = suite_create("cloth_friction");
    TCase* tests = tcase_create("cloth_friction");
    tcase_set_timeout(tests, 120); // a bound against hanging, not a claim about speed
    tcase_add_loop_test(tests, a_strip_slides_off_a_table_where_its_weight_exceeds_its_friction, 0, 4);
    tcase_add_loop_test(tests, a_cloth_slides_down_another_one_as_friction_has_it, 0, 3);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
