// Cloth between rigid bodies that are far heavier than it: it keeps its thickness, and its friction is Coulomb's.
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>
#include <cmath>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr btScalar s_thickness = btScalar(0.01), s_meshMargin = btScalar(0.001);

/// A cloth between opposite corners of a rectangle whose edges are along `u` and `v`.
btSoftBody* AddPressedCloth(qcSoftWorld* made, const btVector3& corner, const btVector3& u, const btVector3& v,
                            int nodesAlong, int nodesAcross, double friction)
{
    btSoftBody* cloth =
        made->AddPatch(corner, corner + u, corner + v, corner + u + v, nodesAlong, nodesAcross, friction);
    cloth->m_cfg.piterations = 20;
    return cloth;
}

/// A box, or a mesh of that form. A mass of 0: static.
btRigidBody* AddBox(qcSoftWorld* made, bool isMesh, const btVector3& half, double mass, const btVector3& place)
{
    btCollisionShape* shape;
    if (isMesh)
    {
        shape = made->KeepMesh(qcBoxModel(half, 4));
        shape->setMargin(s_meshMargin);
    }
    else
    {
        made->shapes.emplace_back(new btBoxShape(half));
        shape = made->shapes.back().get();
    }
    btRigidBody* body = made->AddBody(shape, btScalar(mass), place);
    body->setFriction(1);
    body->setActivationState(DISABLE_DEACTIVATION);
    return body;
}

/// How near cloth comes to a body, as it is documented: half of its thickness and the margin, at most the thickness.
double ContactDistance(bool isMesh)
{
    return double(s_thickness / 2 + (isMesh ? s_meshMargin : s_thickness));
}

/// A box on layers of cloth on a table.
struct Pile
{
    qcSoftWorld made;
    btRigidBody *table = nullptr, *box = nullptr;
    const double layersHeight; ///< of the layers, if each keeps its thickness

    Pile(bool isMesh, int layers, int nodes, double mass)
        : layersHeight(2 * ContactDistance(isMesh) + (layers - 1) * double(s_thickness))
    {
        made.meshContact.addTo(&made.world);
        table = AddBox(&made, isMesh, btVector3(2, btScalar(0.5), 2), 0, btVector3(0, btScalar(-0.5), 0));
        for (int layer = 0; layer < layers; layer++)
        {
            const btScalar height = btScalar(ContactDistance(isMesh)) + btScalar(layer) * s_thickness;
            AddPressedCloth(&made, btVector3(btScalar(-0.5), height + btScalar(1e-4), btScalar(-0.5)),
                            btVector3(1, 0, 0), btVector3(0, 0, 1), nodes, nodes, 0.5);
        }
        box = AddBox(&made, isMesh, btVector3(btScalar(0.2), btScalar(0.1), btScalar(0.2)), mass,
                     btVector3(btScalar(0.013), btScalar(layersHeight + 0.101), btScalar(0.007)));
    }

    /// How high the lower side of the box is over the table.
    double Height() const
    {
        return double(box->getWorldTransform().getOrigin().y()) - 0.1;
    }
};

START_TEST(cloth_under_a_body_of_any_mass_keeps_its_thickness)
{
    const bool isMesh = _i % 2 != 0;
    const int stepsPerSecond = _i / 2 == 0 ? 60 : 240;
    for (double mass : {0.1, 10.0, 100.0})
    {
        Pile pile(isMesh, 1, 21, mass);
        for (int step = 0; step < stepsPerSecond; step++)
        {
            pile.made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
            const qcSoftBodyStatistics& statistics = pile.made.softSolver.getStatistics();
            ck_assert_int_eq(statistics.status, qc_statusOk);
            ck_assert_int_eq(statistics.unproven, 0);
            // Contact alone carries the body.
            if (step > stepsPerSecond / 2)
                ck_assert_int_eq(statistics.planes + statistics.zoneNodes, 0);
        }
        ck_assert_msg(std::fabs(pile.Height() - pile.layersHeight) < 0.01 * pile.layersHeight,
                      "mass %g: %g m over the table, not %g", mass, pile.Height(), pile.layersHeight);
        pile.made.RemoveAll();
    }
}
END_TEST

START_TEST(layers_under_a_body_of_any_mass_keep_their_thickness)
{
    for (double mass : {0.1, 10.0, 100.0})
    {
        Pile pile(false, 3, 15, mass);
        for (int step = 0; step < 240; step++)
            pile.made.world.stepSimulation(btScalar(1.0 / 240), 0);
        ck_assert_int_eq(pile.made.softSolver.getStatistics().planes, 0);
        ck_assert_msg(std::fabs(pile.Height() - pile.layersHeight) < 0.02 * pile.layersHeight,
                      "mass %g: %g m over the table, not %g", mass, pile.Height(), pile.layersHeight);
        pile.made.RemoveAll();
    }
}
END_TEST

START_TEST(deformable_cloth_under_a_body_of_any_mass_keeps_its_thickness)
{
    for (double mass : {1.0, 100.0})
    {
        const btVector3 gravity(0, -10, 0), half(btScalar(0.2), btScalar(0.1), btScalar(0.2));
        const btScalar distance = btScalar(ContactDistance(false));
        btBoxShape tableShape(btVector3(2, btScalar(0.5), 2)), boxShape(half);
        btVector3 inertia;
        boxShape.calculateLocalInertia(btScalar(mass), inertia);
        btRigidBody table(0, nullptr, &tableShape), box(btScalar(mass), nullptr, &boxShape, inertia);
        table.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(-0.5), 0)));
        box.setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(0, half.y() + 2 * distance + btScalar(1e-3), 0)));
        box.setActivationState(DISABLE_DEACTIVATION);
        btDeformableMassSpringForce springs(30, 1, true);
        btDeformableGravityForce weight(gravity);
        qcDeformableTestWorld<qcDeformableWorld> made;
        made.world->setThreadCount(1);
        made.world->setGravity(gravity);
        made.world->getWorldInfo().m_gravity = gravity;
        made.world->addRigidBody(&table);
        made.world->addRigidBody(&box);
        const btVector3 corner(btScalar(-0.5), distance + btScalar(1e-4), btScalar(-0.5)), u(1, 0, 0), v(0, 0, 1);
        made.cloths.push_back(btSoftBodyHelpers::CreatePatch(made.world->getWorldInfo(), corner, corner + u, corner + v,
                                                             corner + u + v, 21, 21, 0, true));
        btSoftBody* cloth = made.cloths.back();
        cloth->getCollisionShape()->setMargin(s_thickness);
        cloth->setTotalMass(btScalar(0.3));
        cloth->m_cfg.collisions =
            btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
        made.world->addSoftBody(cloth);
        made.world->addForce(cloth, &springs);
        made.world->addForce(cloth, &weight);
        for (int step = 0; step < 120; step++)
        {
            made.world->stepSimulation(btScalar(1.0 / 120), 0);
            ck_assert_int_eq(made.world->getStatistics().status, qc_statusOk);
        }
        const double height = double(box.getWorldTransform().getOrigin().y() - half.y());
        ck_assert_msg(std::fabs(height - 2 * double(distance)) < 0.02 * height, "mass %g: %g m over the table", mass,
                      height);
        made.world->removeRigidBody(&box);
        made.world->removeRigidBody(&table);
    }
}
END_TEST

START_TEST(a_tilted_body_of_any_mass_throws_no_node_of_the_cloth_under_it)
{
    for (double mass : {1.0, 1000.0})
    {
        Pile pile(false, 1, 21, mass);
        pile.made.cloths[0]->m_cfg.kDF = btScalar(0.1);
        btTransform tilted = pile.box->getWorldTransform();
        tilted.setRotation(btQuaternion(btVector3(0, 0, 1), btScalar(0.01)));
        tilted.getOrigin() += btVector3(0, btScalar(0.002), 0);
        pile.box->setWorldTransform(tilted);
        double fastest = 0;
        for (int step = 0; step < 60; step++)
        {
            pile.made.world.stepSimulation(btScalar(1.0 / 60), 0);
            for (int i = 0; i < pile.made.cloths[0]->m_nodes.size(); i++)
                fastest = std::max(fastest, double(pile.made.cloths[0]->m_nodes[i].m_v.length()));
        }
        ck_assert_msg(fastest < 1, "mass %g: a node at %g m/s", mass, fastest);
        ck_assert_double_eq_tol(pile.Height(), pile.layersHeight, 0.01 * pile.layersHeight);
        pile.made.RemoveAll();
    }
}
END_TEST

/// Nodes of the rim of a square cloth stay where they are.
void PinRim(btSoftBody* cloth, int nodes)
{
    for (int i = 0; i < nodes; i++)
        for (int rim : {i, i * nodes, (nodes - 1) * nodes + i, i * nodes + nodes - 1})
            cloth->setMass(rim, 0);
}

START_TEST(a_body_goes_with_the_cloth_under_it_and_not_with_what_is_below)
{
    const btScalar speed = 2, timeStep = btScalar(1.0 / 240);
    const double friction = 0.5, gravity = 10;
    for (bool isCloth : {false, true})
    {
        Pile pile(false, 1, 21, 0.5);
        btSoftBody* cloth = pile.made.cloths[0];
        PinRim(cloth, 21);
        pile.table->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
        for (int step = 0; step < 30; step++)
            pile.made.world.stepSimulation(timeStep, 0);
        const btVector3 start = pile.box->getWorldTransform().getOrigin();
        const int steps = 48;
        for (int step = 0; step < steps; step++)
        {
            const btVector3 motion(speed * timeStep, 0, 0);
            for (int i = 0; i < cloth->m_nodes.size() && isCloth; i++)
                cloth->m_nodes[i].m_x += cloth->m_nodes[i].m_im > 0 ? btVector3(0, 0, 0) : motion;
            btTransform moved = pile.table->getWorldTransform();
            moved.getOrigin() += isCloth ? btVector3(0, 0, 0) : motion;
            pile.table->setWorldTransform(moved);
            pile.made.world.stepSimulation(timeStep, 0);
        }
        const double time = double(steps * timeStep), reached = friction * gravity * time;
        const double found = double(pile.box->getLinearVelocity().x());
        const double aside = double((pile.box->getWorldTransform().getOrigin() - start).x());
        if (isCloth)
            ck_assert_msg(found > 0.6 * reached && found < 1.1 * reached, "%g m/s, not %g", found, reached);
        else
            ck_assert_msg(std::fabs(aside) < 0.02, "moves by %g m", aside);
        pile.made.RemoveAll();
    }
}
END_TEST

/// A strip that hangs between two bodies, which are pressed together.
struct Grip
{
    qcSoftWorld made;
    const btSoftBody* strip;
    btRigidBody* jaws[2];
    const double force; ///< on each

    /// `hold`: the friction of both, as a multiple of the strip's weight.
    Grip(bool isMesh, double friction, double mass, double hold) : force(hold * 3 / (2 * friction))
    {
        made.meshContact.addTo(&made.world);
        made.SetGravity(btVector3(0, -10, 0));
        strip = AddPressedCloth(&made, btVector3(btScalar(-0.2), 0, 0), btVector3(btScalar(0.4), 0, 0),
                                btVector3(0, -1, 0), 13, 31, friction);
        for (int side : {0, 1})
        {
            const btScalar aside = btScalar(0.05 + ContactDistance(isMesh) - 1e-4) * btScalar(2 * side - 1);
            jaws[side] = AddBox(&made, isMesh, btVector3(btScalar(0.25), btScalar(0.1), btScalar(0.05)), mass,
                                btVector3(0, btScalar(-0.15), aside));
            jaws[side]->setGravity(btVector3(0, 0, 0));
            jaws[side]->setLinearFactor(btVector3(0, 0, 1));
            jaws[side]->setAngularFactor(btScalar(0));
        }
    }

    void Step(int stepsPerSecond)
    {
        jaws[0]->applyCentralForce(btVector3(0, 0, btScalar(force)));
        jaws[1]->applyCentralForce(btVector3(0, 0, btScalar(-force)));
        made.world.stepSimulation(btScalar(1.0 / stepsPerSecond), 0);
        ck_assert_int_eq(made.softSolver.getStatistics().status, qc_statusOk);
    }

    /// Means of the strip.
    double Height() const
    {
        double sum = 0;
        for (int i = 0; i < strip->m_nodes.size(); i++)
            sum += double(strip->m_nodes[i].m_x.y());
        return sum / strip->m_nodes.size();
    }
    double Speed() const
    {
        double sum = 0;
        for (int i = 0; i < strip->m_nodes.size(); i++)
            sum += double(strip->m_nodes[i].m_v.y());
        return sum / strip->m_nodes.size();
    }
};

START_TEST(a_strip_stays_between_bodies_that_press_on_it)
{
    const int stepsPerSecond = 60 << _i;
    for (double friction : {0.3, 0.8})
        for (double mass : {0.2, 2.0})
            for (double hold : {2.0, 5.0})
            {
                Grip grip(false, friction, mass, hold);
                double middle = 0;
                for (int step = 0; step < stepsPerSecond; step++)
                {
                    middle = step == stepsPerSecond / 2 ? grip.Height() : middle;
                    grip.Step(stepsPerSecond);
                }
                // It falls for two steps, until the bodies have moved up to it.
                ck_assert_msg(grip.Height() > -0.6 && std::fabs(grip.Height() - middle) < 0.02,
                              "friction %g, mass %g, hold %g: %g m, %g m before", friction, mass, hold, grip.Height(),
                              middle);
                grip.made.RemoveAll();
            }
}
END_TEST

START_TEST(a_strip_between_bodies_slides_as_friction_has_it)
{
    // A quarter of a second: then it is out.
    const int stepsPerSecond = 240;
    for (double friction : {0.3, 0.8})
        for (double hold : {0.5, 0.8, 1.2})
        {
            Grip grip(_i != 0, friction, 0.2, hold);
            double early = 0;
            for (int step = 0; step < stepsPerSecond / 4; step++)
            {
                // The bodies have moved up to the strip.
                if (step == stepsPerSecond / 12)
                    early = grip.Speed();
                grip.Step(stepsPerSecond);
            }
            const double found = 6 * (grip.Speed() - early), expected = -10 * std::max(0.0, 1 - hold);
            ck_assert_msg(std::fabs(found - expected) < 0.5, "friction %g, hold %g: %g m/s2, not %g", friction, hold,
                          found, expected);
            grip.made.RemoveAll();
        }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("pressed_cloth");
    tcase_add_loop_test(tests, cloth_under_a_body_of_any_mass_keeps_its_thickness, 0, 4);
    tcase_add_test(tests, layers_under_a_body_of_any_mass_keep_their_thickness);
    tcase_add_test(tests, a_tilted_body_of_any_mass_throws_no_node_of_the_cloth_under_it);
    tcase_add_test(tests, a_body_goes_with_the_cloth_under_it_and_not_with_what_is_below);
    tcase_add_test(tests, deformable_cloth_under_a_body_of_any_mass_keeps_its_thickness);
    tcase_add_loop_test(tests, a_strip_stays_between_bodies_that_press_on_it, 0, 3);
    tcase_add_loop_test(tests, a_strip_between_bodies_slides_as_friction_has_it, 0, 2);
    return qcRunCase("pressed_cloth", tests);
}
