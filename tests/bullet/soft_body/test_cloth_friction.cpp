// Friction of cloth on a mesh is Coulomb's, at every time step: a strip that hangs over the edge of a table slides off
// where the weight of what hangs exceeds the friction of what lies, and stays otherwise.
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
} // namespace

QC_TEST_MAIN()
{
    Suite* suite = suite_create("cloth_friction");
    TCase* tests = tcase_create("cloth_friction");
    tcase_set_timeout(tests, 120); // a bound against hanging, not a claim about speed
    tcase_add_loop_test(tests, a_strip_slides_off_a_table_where_its_weight_exceeds_its_friction, 0, 4);
    suite_add_tcase(suite, tests);
    return qcRunSuite(suite);
}
