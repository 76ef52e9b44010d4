// Sheets that carry bodies of up to ten times their mass: they hardly stretch, the bodies come to rest on them, and no
// step gives a body more energy than it brought. Cloth that lies on a body is not pulled straight.
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr int s_side = 17;
constexpr btScalar s_radius = btScalar(0.3), s_gravity = btScalar(9.8);

/// The root of the mean square.
double NodeSpeed(const btSoftBody* cloth)
{
    double sum = 0;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        sum += double(cloth->m_nodes[i].m_v.length2());
    return std::sqrt(sum / cloth->m_nodes.size());
}

/// What holds the border of a sheet.
enum class Hold
{
    pins,
    anchors
};

/// A ball over a sheet of 2 kg and 3 by 3 m at height 0, whose border is held.
struct Sheet
{
    qcSoftWorld made;
    btSphereShape sphere{s_radius};
    btSoftBody* cloth;
    btRigidBody* ball;

    Sheet(double mass, double height, Hold hold = Hold::pins)
    {
        made.SetGravity(btVector3(0, -s_gravity, 0));
        cloth = made.AddPatch(btVector3(btScalar(-1.5), 0, btScalar(-1.5)), btVector3(btScalar(1.5), 0, btScalar(-1.5)),
                              btVector3(btScalar(-1.5), 0, btScalar(1.5)), btVector3(btScalar(1.5), 0, btScalar(1.5)),
                              s_side, s_side, 0);
        cloth->setTotalMass(2);
        cloth->m_cfg.piterations = 10;
        btRigidBody* frame = hold == Hold::anchors ? made.AddBody(&sphere, 0, btVector3(0, 50, 0)) : nullptr;
        for (int i = 0; i < s_side * s_side; i++)
            if (IsBorder(i) && frame != nullptr)
                cloth->appendAnchor(i, frame, true);
            else if (IsBorder(i))
                cloth->setMass(i, 0);
        ball = made.AddBody(&sphere, btScalar(mass),
                            btVector3(btScalar(0.02), s_radius + btScalar(height), btScalar(0.01)));
        ball->setActivationState(DISABLE_DEACTIVATION);
    }

    static bool IsBorder(int node)
    {
        const int row = node / s_side, column = node % s_side;
        return row == 0 || column == 0 || row == s_side - 1 || column == s_side - 1;
    }

    void Step(int stepsPerSecond)
    {
        made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
        ck_assert_int_eq(made.softSolver.getStatistics().status, qc_statusOk);
    }

    double Height() const
    {
        return double(ball->getWorldTransform().getOrigin().y());
    }

    /// The largest length of a link, as a multiple of that at rest.
    double Stretch() const
    {
        double largest = 0;
        for (int i = 0; i < cloth->m_links.size(); i++)
        {
            const btSoftBody::Link& link = cloth->m_links[i];
            largest = std::max(largest, double((link.m_n[0]->m_x - link.m_n[1]->m_x).length() / link.m_rl));
        }
        return largest;
    }
};
} // namespace

START_TEST(a_sheet_carries_ten_times_its_mass)
{
    const int stepsPerSecond = _i % 2 == 0 ? 60 : 240;
    const Hold hold = _i < 2 ? Hold::pins : Hold::anchors;
    for (double mass : {0.5, 2.0, 20.0})
    {
        Sheet sheet(mass, 0.05, hold);
        double stretch = 0, speed = 0, lowest = 1, highest = -9;
        for (int step = 0; step < 5 * stepsPerSecond; step++)
        {
            sheet.Step(stepsPerSecond);
            if (step < 4 * stepsPerSecond)
                continue;
            stretch = std::max(stretch, sheet.Stretch());
            speed = std::max(speed, NodeSpeed(sheet.cloth));
            lowest = std::min(lowest, sheet.Height());
            highest = std::max(highest, sheet.Height());
        }
        printf("%g kg, %s, %d steps a second: stretch %.2f, ball at %.3f to %.3f m, nodes at up to %.2f m/s\n", mass,
               hold == Hold::pins ? "pinned" : "anchored", stepsPerSecond, stretch, lowest, highest, speed);
        ck_assert_double_lt(stretch, 1.25);
        ck_assert_double_gt(lowest, -0.6);
        ck_assert_double_lt(highest - lowest, 0.06);
        ck_assert_double_lt(speed, 0.3);
        sheet.made.RemoveAll();
    }
}
END_TEST

START_TEST(a_ball_rises_no_higher_than_it_fell_from)
{
    const int stepsPerSecond[] = {60, 240, 1000};
    for (double mass : {2.0, 20.0})
    {
        Sheet sheet(mass, 0.3);
        const double start = sheet.Height();
        double lowest = start, highest = -9;
        for (int step = 0; step < 3 * stepsPerSecond[_i] / 2; step++)
        {
            sheet.Step(stepsPerSecond[_i]);
            lowest = std::min(lowest, sheet.Height());
            if (sheet.Height() > lowest + 0.01)
                highest = std::max(highest, sheet.Height());
        }
        printf("%g kg, %d steps a second: down from %.2f to %.2f m, then up to %.2f m\n", mass, stepsPerSecond[_i],
               start, lowest, highest);
        ck_assert_double_lt(highest, start - 0.1);
        sheet.made.RemoveAll();
    }
}
END_TEST

START_TEST(a_sheet_that_is_lifted_lifts_what_it_carries)
{
    Sheet sheet(10, 0.05);
    double before = 0;
    for (int step = 0; step < 300; step++)
    {
        // At rest first.
        for (int i = 0; step >= 180 && i < s_side * s_side; i++)
            if (Sheet::IsBorder(i))
                sheet.cloth->m_nodes[i].m_x.setY(sheet.cloth->m_nodes[i].m_x.y() + btScalar(1.0 / 60));
        sheet.Step(60);
        before = step < 180 ? sheet.Height() : before;
    }
    printf("lifted by 2 m: the ball by %.2f m, stretch %.2f\n", sheet.Height() - before, sheet.Stretch());
    ck_assert_double_eq_tol(sheet.Height() - before, 2, 0.2);
    ck_assert_double_lt(sheet.Stretch(), 1.3);
    sheet.made.RemoveAll();
}
END_TEST

START_TEST(a_box_on_a_taut_sheet_slides_as_far_as_its_friction_lets_it)
{
    // It falls 13 cm into the sheet on its way, at 2 m/s. On a floor friction of 0.3 would stop it after 0.7 m.
    constexpr int side = 21, starts = 3;
    const int stepsPerSecond = _i == 0 ? 60 : 240;
    for (double friction : {0.05, 0.3})
    {
        double way = 0, fastest = 0;
        for (int start = 0; start < starts; start++)
        {
            qcSoftWorld made;
            btBoxShape shape(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)));
            made.SetGravity(btVector3(0, -s_gravity, 0));
            btSoftBody* cloth = made.AddPatch(btVector3(-2, 0, -2), btVector3(2, 0, -2), btVector3(-2, 0, 2),
                                              btVector3(2, 0, 2), side, side, 1);
            cloth->m_cfg.piterations = 10;
            cloth->m_cfg.kDF = 1;
            for (int i = 0; i < side * side; i++)
                if (i / side == 0 || i % side == 0 || i / side == side - 1 || i % side == side - 1)
                    cloth->setMass(i, 0);
            for (int i = 0; i < cloth->m_links.size(); i++)
                cloth->m_links[i].m_rl *= btScalar(0.97);
            cloth->updateLinkConstants();
            btRigidBody* box = made.AddBody(&shape, btScalar(0.5), btVector3(btScalar(-1.2), btScalar(0.23), 0));
            box->setFriction(btScalar(friction));
            box->setActivationState(DISABLE_DEACTIVATION);
            box->setLinearVelocity(btVector3(btScalar(1.95 + 0.05 * start), 0, 0));
            for (int step = 0; step < 3 * stepsPerSecond / 2; step++)
            {
                made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
                fastest = std::max(fastest, double(box->getLinearVelocity().length()));
            }
            way += double(box->getWorldTransform().getOrigin().x() + btScalar(1.2)) / starts;
            made.RemoveAll();
        }
        printf("friction %.2f, %d steps a second: a box slides %.2f m, at up to %.1f m/s\n", friction, stepsPerSecond,
               way, fastest);
        ck_assert_double_gt(way, friction < 0.1 ? 1.2 : 0.6);
        ck_assert_double_lt(way, friction < 0.1 ? 2.9 : 1.7);
        ck_assert_double_lt(fastest, 4);
    }
}
END_TEST

START_TEST(bodies_that_share_a_sheet_come_to_rest)
{
    // Each moves the sheet under the others.
    const int stepsPerSecond = _i == 0 ? 60 : 240;
    Sheet sheet(2, 0.1);
    btBoxShape cube(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)));
    btBoxShape plate(btVector3(btScalar(0.3), btScalar(0.06), btScalar(0.3)));
    const btScalar masses[] = {btScalar(0.1), 20, 1, 5};
    std::vector<btRigidBody*> bodies = {sheet.ball};
    for (int i = 0; i < 4; i++)
    {
        const btScalar x = btScalar(i % 2 == 0 ? -0.7 : 0.7), z = btScalar(i / 2 == 0 ? -0.65 : 0.7);
        btCollisionShape* shape = i % 3 == 0 ? &cube : &plate;
        bodies.push_back(sheet.made.AddBody(shape, masses[i], btVector3(x, btScalar(0.3 + 0.05 * i), z)));
        bodies.back()->setActivationState(DISABLE_DEACTIVATION);
    }
    double lowest = 1, speed = 0, spin = 0, stretch = 0;
    for (int step = 0; step < 6 * stepsPerSecond; step++)
    {
        sheet.Step(stepsPerSecond);
        if (step < 2 * stepsPerSecond)
            continue;
        stretch = std::max(stretch, sheet.Stretch());
        for (const btRigidBody* body : bodies)
        {
            lowest = std::min(lowest, double(body->getWorldTransform().getOrigin().y()));
            speed = std::max(speed, double(body->getLinearVelocity().length()));
            spin = std::max(spin, double(body->getAngularVelocity().length()));
        }
    }
    printf("5 bodies, %d steps a second: at least at %.2f m, at up to %.2f m/s and %.1f/s, stretch %.2f\n",
           stepsPerSecond, lowest, speed, spin, stretch);
    ck_assert_double_gt(lowest, -0.8);
    ck_assert_double_lt(speed, 1.6);
    ck_assert_double_lt(spin, 6);
    ck_assert_double_lt(stretch, 1.6);
    sheet.made.RemoveAll();
}
END_TEST

// What touches the curtain gently strains nothing, so that no spring is its own.
START_TEST(a_sheet_carries_a_ball_while_many_touch_a_curtain)
{
    qcSoftWorld made;
    const btScalar half = btScalar(1.2);
    btSoftBody* curtain =
        made.AddPatch(btVector3(5, 2, -2), btVector3(5, 2, 2), btVector3(5, 0, -2), btVector3(5, 0, 2), 33, 17, 0);
    for (int i = 0; i < 33; i++)
        curtain->setMass(i, 0);
    for (int i = 0; i < 32; i++)
    {
        const btVector3 place(btScalar(4.88), btScalar(0.7 + i / 16 * 0.5), btScalar(-1.8 + i % 16 * 0.24));
        made.shapes.emplace_back(new btSphereShape(btScalar(0.1)));
        btRigidBody* ball = made.AddBody(made.shapes.back().get(), btScalar(0.01), place);
        ball->setGravity(btVector3(0, 0, 0));
        ball->setLinearVelocity(btVector3(btScalar(0.05), 0, 0));
    }
    btSoftBody* sheet = made.AddPatch(btVector3(-half, 0, -half), btVector3(half, 0, -half), btVector3(-half, 0, half),
                                      btVector3(half, 0, half), 9, 9, 0);
    for (const int corner : {0, 8, 72, 80})
        sheet->setMass(corner, 0);
    made.shapes.emplace_back(new btSphereShape(s_radius));
    btRigidBody* load = made.AddBody(made.shapes.back().get(), 5, btVector3(0, s_radius + btScalar(0.02), 0));
    for (int step = 0; step < 60; step++)
    {
        made.world.stepSimulation(btScalar(1.0 / 60), 0);
        ck_assert_int_eq(made.softSolver.getStatistics().status, qc_statusOk);
    }
    ck_assert_double_gt(double(load->getWorldTransform().getOrigin().y()), -2);
}
END_TEST

START_TEST(cloth_that_lies_on_a_body_hangs_from_its_edges)
{
    // The body carries the cloth: free, and held at two corners.
    for (int held : {0, 2})
    {
        qcSoftWorld made;
        btBoxShape shape(btVector3(btScalar(0.4), btScalar(0.2), btScalar(0.4)));
        btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
        made.SetGravity(btVector3(0, -s_gravity, 0));
        made.AddBody(&plane, 0, btVector3(0, 0, 0));
        btRigidBody* box = made.AddBody(&shape, 2, btVector3(0, btScalar(0.2), 0));
        const btScalar half = btScalar(0.6), height = btScalar(0.43);
        btSoftBody* cloth = made.AddPatch(btVector3(-half, height, -half), btVector3(half, height, -half),
                                          btVector3(-half, height, half), btVector3(half, height, half), 21, 21, 0.5);
        cloth->m_cfg.piterations = 4;
        cloth->m_cfg.kDP = btScalar(0.01);
        for (int corner = 0; corner < held; corner++)
            cloth->setMass(20 * corner, 0);
        double highest = 0, speed = 0;
        for (int step = 0; step < 240; step++)
        {
            made.world.stepSimulation(btScalar(1.0 / 60), 0);
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                highest = std::max(highest, double(cloth->m_nodes[i].m_x.y()));
            speed = step < 180 ? 0 : std::max(speed, NodeSpeed(cloth));
        }
        printf("cloth on a box, %d corners held: up to %.3f m, nodes at up to %.3f m/s, box at %.4f\n", held, highest,
               speed, double(box->getLinearVelocity().length()));
        ck_assert_double_lt(highest, double(height) + 0.02);
        ck_assert_double_lt(speed, 0.05);
        ck_assert_double_lt(double(box->getLinearVelocity().length()), 0.02);
        made.RemoveAll();
    }
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("carrying cloth");
    tcase_add_loop_test(tests, a_sheet_carries_ten_times_its_mass, 0, 4);
    tcase_add_loop_test(tests, a_ball_rises_no_higher_than_it_fell_from, 0, 3);
    tcase_add_test(tests, a_sheet_that_is_lifted_lifts_what_it_carries);
    tcase_add_loop_test(tests, a_box_on_a_taut_sheet_slides_as_far_as_its_friction_lets_it, 0, 2);
    tcase_add_loop_test(tests, bodies_that_share_a_sheet_come_to_rest, 0, 2);
    tcase_add_test(tests, a_sheet_carries_a_ball_while_many_touch_a_curtain);
    tcase_add_test(tests, cloth_that_lies_on_a_body_hangs_from_its_edges);
    return qcRunCase("carrying cloth", tests);
}
