// Sheets of the deformable world that carry rigid bodies, on anchors or lying on them, over fixed edges: nothing passes
// through, and nothing gains energy.
#include "bullet/soft_body/deformable_test_world.h"

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <random>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_step = btScalar(1.0 / 240);
constexpr btScalar s_stiffness = 40, s_bending = 2, s_sheetMass = btScalar(0.5);
constexpr int s_side = 15; ///< nodes along a side of a sheet

/// What a sheet is pulled over.
enum class Edge
{
    Box,
    Rod,
    Ball
};
const char* const s_edgeNames[] = {"box", "rod", "ball"};

/// Fixed shapes, sheets of 0.5 kg, and loads.
struct LoadedSheetWorld : qcDeformableTestWorld<qcDeformableWorld>
{
    btDeformableMassSpringForce springs;
    btDeformableGravityForce gravity{btVector3(0, btScalar(-9.81), 0)};
    std::vector<std::unique_ptr<btCollisionShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;

    explicit LoadedSheetWorld(btScalar damping) : springs(s_stiffness, damping, true, s_bending)
    {
        const btVector3 g(0, btScalar(-9.81), 0);
        world->setGravity(g);
        world->getWorldInfo().m_gravity = g;
        world->getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(0.25));
        world->getSolverInfo().m_splitImpulse = true;
    }

    ~LoadedSheetWorld()
    {
        // Before their forces.
        for (btSoftBody* sheet : cloths)
        {
            world->removeSoftBody(sheet);
            delete sheet;
        }
        cloths.clear();
        for (const auto& body : bodies)
            world->removeRigidBody(body.get());
    }

    btRigidBody* Add(btCollisionShape* shape, btScalar mass, const btVector3& place)
    {
        shapes.emplace_back(shape);
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shape->calculateLocalInertia(mass, inertia);
        bodies.emplace_back(new btRigidBody(mass, nullptr, shape, inertia));
        bodies.back()->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
        bodies.back()->setActivationState(DISABLE_DEACTIVATION);
        world->addRigidBody(bodies.back().get());
        return bodies.back().get();
    }

    btSoftBody* AddSheet(btScalar half, btScalar height)
    {
        const btVector3 off(btScalar(0.02), height, btScalar(0.01));
        btSoftBody* sheet = btSoftBodyHelpers::CreatePatch(
            world->getWorldInfo(), off + btVector3(-half, 0, -half), off + btVector3(half, 0, -half),
            off + btVector3(-half, 0, half), off + btVector3(half, 0, half), s_side, s_side, 0, true);
        sheet->setTotalMass(s_sheetMass);
        sheet->getCollisionShape()->setMargin(btScalar(0.05));
        sheet->m_cfg.kDF = btScalar(0.5);
        cloths.push_back(sheet);
        world->addSoftBody(sheet);
        world->addForce(sheet, &springs);
        world->addForce(sheet, &gravity);
        return sheet;
    }

    /// Kinetic, of gravity and of springs.
    double Energy() const
    {
        const btVector3 g = world->getGravity();
        double energy = 0;
        for (const auto& body : bodies)
            if (body->getInvMass() > 0)
                energy +=
                    double((body->getLinearVelocity().length2() / 2 - g.dot(body->getWorldTransform().getOrigin())) /
                           body->getInvMass()) +
                    double(body->getAngularVelocity().dot(body->getInvInertiaTensorWorld().inverse() *
                                                          body->getAngularVelocity())) /
                        2;
        for (const btSoftBody* sheet : cloths)
        {
            for (int i = 0; i < sheet->m_nodes.size(); i++)
            {
                const btSoftBody::Node& node = sheet->m_nodes[i];
                if (node.m_im > 0)
                    energy += double((node.m_v.length2() / 2 - g.dot(node.m_x)) / node.m_im);
            }
            for (int i = 0; i < sheet->m_links.size(); i++)
            {
                const btSoftBody::Link& link = sheet->m_links[i];
                const double longer = double(link.m_n[0]->m_x.distance(link.m_n[1]->m_x) - link.m_rl);
                energy += double(link.m_bbending != 0 ? s_bending : s_stiffness) * longer * longer / 2;
            }
        }
        return energy;
    }

    /// Anchored nodes are at their places on their bodies.
    void CheckAnchors() const
    {
        for (const btSoftBody* sheet : cloths)
            for (int i = 0; i < sheet->m_deformableAnchors.size(); i++)
            {
                const btSoftBody::DeformableNodeRigidAnchor& anchor = sheet->m_deformableAnchors[i];
                const btVector3 place = anchor.m_cti.m_colObj->getWorldTransform() * anchor.m_local;
                ck_assert_double_lt(double(anchor.m_node->m_x.distance(place)), 1e-4);
            }
    }

    /// Steps in which nothing may pass through. Returns by how much the energy has exceeded that of the start.
    double Run(int steps, btScalar* speed, btScalar timeStep = s_step)
    {
        const double start = Energy();
        double most = start;
        *speed = 0;
        for (int step = 0; step < steps; step++)
        {
            world->stepSimulation(timeStep, 0);
            ck_assert_int_eq(world->getStatistics().status, qc_statusOk);
            ck_assert_int_eq(world->getStatistics().remaining, 0);
            ck_assert_int_eq(world->getStatistics().unproven, 0);
            most = std::max(most, Energy());
            CheckAnchors();
            for (const btSoftBody* sheet : cloths)
                for (int i = 0; i < sheet->m_nodes.size(); i++)
                    *speed = std::max(*speed, sheet->m_nodes[i].m_v.length());
        }
        return most - start;
    }
};

START_TEST(bodies_on_anchors_pull_a_sheet_over_an_edge_without_passing_through)
{
    for (const Edge edge : {Edge::Box, Edge::Rod, Edge::Ball})
        for (const btScalar mass : {btScalar(0.25), btScalar(4)})
        {
            LoadedSheetWorld anchored(btScalar(0.1));
            const btScalar speedOfFall = edge == Edge::Ball ? 8 : 3;
            if (edge == Edge::Rod)
                anchored.Add(new btCylinderShapeZ(btVector3(btScalar(0.08), btScalar(0.08), btScalar(0.9))), 0,
                             btVector3(0, btScalar(-0.08), 0));
            else if (edge == Edge::Ball)
                anchored.Add(new btSphereShape(btScalar(0.4)), 0, btVector3(0, btScalar(-0.4), 0));
            else
                anchored.Add(new btBoxShape(btVector3(btScalar(0.3), btScalar(0.2), btScalar(0.8))), 0,
                             btVector3(0, btScalar(-0.2), 0));
            btSoftBody* sheet = anchored.AddSheet(btScalar(0.7), btScalar(0.08));
            for (int side = 0; side < 2; side++)
            {
                btRigidBody* weight =
                    anchored.Add(new btBoxShape(btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.5))), mass,
                                 btVector3(btScalar(side == 0 ? -0.76 : 0.8), btScalar(0.08), btScalar(0.01)));
                weight->setLinearVelocity(btVector3(0, -speedOfFall, 0));
                for (int i = 2; i < s_side - 2; i += 2)
                    sheet->appendDeformableAnchor(i * s_side + (side == 0 ? 0 : s_side - 1), weight);
            }
            sheet->setVelocity(btVector3(0, -speedOfFall, 0));
            btScalar speed;
            const double gained = anchored.Run(300, &speed);
            printf("%s, two of %g kg: nodes at up to %.1f m/s, gains %.2f J\n", s_edgeNames[int(edge)], double(mass),
                   double(speed), gained);
            ck_assert_double_lt(double(speed), 17);
            ck_assert_double_lt(gained, 0.1);
        }
}
END_TEST

START_TEST(a_frame_with_a_sheet_on_anchors_lands_on_a_mesh)
{
    for (const btScalar speedOfFrame : {btScalar(3), btScalar(8)})
    {
        LoadedSheetWorld anchored(btScalar(0.1));
        const qcModel model = qcBoxModel(btVector3(btScalar(0.25), btScalar(0.15), btScalar(0.5)), 4);
        anchored.Add(model.MakeShape().release(), 0, btVector3(0, btScalar(-0.15), 0));
        btSoftBody* sheet = anchored.AddSheet(btScalar(0.7), btScalar(0.08));
        auto* ring = new btCompoundShape;
        for (int side = 0; side < 4; side++)
        {
            const btScalar at = side % 2 == 0 ? btScalar(0.8) : btScalar(-0.8);
            anchored.shapes.emplace_back(
                new btBoxShape(side < 2 ? btVector3(btScalar(0.04), btScalar(0.04), btScalar(0.84))
                                        : btVector3(btScalar(0.76), btScalar(0.04), btScalar(0.04))));
            ring->addChildShape(
                btTransform(btQuaternion::getIdentity(), side < 2 ? btVector3(at, 0, 0) : btVector3(0, 0, at)),
                anchored.shapes.back().get());
        }
        btRigidBody* frame = anchored.Add(ring, 4, btVector3(btScalar(0.02), btScalar(0.08), btScalar(0.01)));
        frame->setLinearVelocity(btVector3(0, -speedOfFrame, 0));
        sheet->setVelocity(btVector3(0, -speedOfFrame, 0));
        for (int i = 0; i < s_side; i += 2)
            for (int node : {i, (s_side - 1) * s_side + i, i * s_side, i * s_side + s_side - 1})
                if (!sheet->m_nodes[node].m_battach)
                    sheet->appendDeformableAnchor(node, frame);
        btScalar speed;
        const double gained = anchored.Run(180, &speed);
        printf("frame at %g m/s: nodes at up to %.1f m/s, gains %.2f J\n", double(speedOfFrame), double(speed), gained);
        ck_assert_double_lt(double(speed), 35);
        ck_assert_double_lt(gained, 0.1);
    }
}
END_TEST

START_TEST(momentum_is_kept_where_a_sheet_meets_another_at_its_anchors)
{
    LoadedSheetWorld anchored(btScalar(0.1));
    anchored.world->setGravity(btVector3(0, 0, 0));
    anchored.gravity.m_gravity.setZero();
    btSoftBody* sheet = anchored.AddSheet(btScalar(0.3), 0);
    btRigidBody* bar = anchored.Add(new btBoxShape(btVector3(btScalar(0.03), btScalar(0.03), btScalar(0.3))),
                                    btScalar(0.3), btVector3(btScalar(-0.32), 0, btScalar(0.01)));
    for (int i = 0; i < s_side; i++)
        sheet->appendDeformableAnchor(i * s_side, bar);
    btSoftBody* other = anchored.AddSheet(btScalar(0.2), btScalar(0.2));
    other->translate(btVector3(btScalar(-0.28), 0, 0));
    other->setVelocity(btVector3(0, -4, 0));
    auto momentum = [&]
    { return qcMomentumOf(sheet) + qcMomentumOf(other) + bar->getLinearVelocity() * btScalar(0.3); };
    const btVector3 begin = momentum();
    btScalar speed;
    anchored.Run(60, &speed);
    ck_assert_double_gt(double(-bar->getLinearVelocity().y()), 0.2);
    printf("momentum %.4f of %.4f\n", double(momentum().y()), double(begin.y()));
    ck_assert_double_lt(double((momentum() - begin).length()), 0.02 * double(begin.length()));
}
END_TEST

START_TEST(a_load_that_draws_free_sheets_into_a_gap_gains_no_energy)
{
    for (const int layers : {1, 2})
        for (const bool isBox : {false, true})
            for (const btScalar times : {btScalar(2), btScalar(8)})
            {
                LoadedSheetWorld loaded(3);
                for (const btScalar x : {btScalar(-0.5), btScalar(0.5)})
                    loaded.Add(new btBoxShape(btVector3(btScalar(0.2), btScalar(0.2), 1)), 0,
                               btVector3(x, btScalar(-0.2), 0));
                for (int layer = 0; layer < layers; layer++)
                    loaded.AddSheet(btScalar(0.8), btScalar(0.06) + btScalar(0.08) * btScalar(layer));
                btCollisionShape* shape = nullptr;
                if (isBox)
                    shape = new btBoxShape(btVector3(btScalar(0.15), btScalar(0.1), btScalar(0.15)));
                else
                    shape = new btSphereShape(btScalar(0.15));
                loaded.Add(shape, times * s_sheetMass, btVector3(0, btScalar(0.3 + 0.1 * layers), btScalar(0.02)));
                btScalar speed;
                const double gained = loaded.Run(180, &speed);
                printf("%d sheets, %s of %g times their mass: gains %.2f J\n", layers, isBox ? "box" : "ball",
                       double(times), gained);
                ck_assert_double_lt(gained, 0.1);
            }
}
END_TEST

// Where a box and a ball meet in a hanging sheet, its links are pressed to parts of their lengths.
START_TEST(a_hanging_sheet_that_falling_bodies_crumple_gains_no_energy)
{
    for (int run = 0; run < 6; run++)
    {
        std::minstd_rand random{std::minstd_rand::result_type(run) + 1};
        std::uniform_real_distribution<double> part(-0.02, 0.02);
        LoadedSheetWorld loaded(btScalar(0.3));
        btSoftBody* sheet = loaded.AddSheet(btScalar(1.5), 1);
        sheet->setTotalMass(1);
        for (const int corner : {0, s_side - 1, s_side * (s_side - 1), s_side * s_side - 1})
            sheet->setMass(corner, 0);
        auto near = [&](btScalar x) { return x + btScalar(part(random)); };
        loaded.Add(new btBoxShape(btVector3(btScalar(0.3), btScalar(0.3), btScalar(0.3))), 1,
                   btVector3(near(0), near(btScalar(1.6)), near(0)));
        loaded.Add(new btSphereShape(btScalar(0.3)), 1, btVector3(near(btScalar(0.5)), near(btScalar(2.6)), near(0)));
        btScalar speed;
        const double gained = loaded.Run(200, &speed, btScalar(1.0 / 80));
        printf("run %d: gains %.2f J, at most %.1f m/s\n", run, gained, double(speed));
        ck_assert_double_lt(gained, 0.1);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("loaded_sheets", bodies_on_anchors_pull_a_sheet_over_an_edge_without_passing_through,
             a_frame_with_a_sheet_on_anchors_lands_on_a_mesh,
             momentum_is_kept_where_a_sheet_meets_another_at_its_anchors,
             a_load_that_draws_free_sheets_into_a_gap_gains_no_energy,
             a_hanging_sheet_that_falling_bodies_crumple_gains_no_energy)
