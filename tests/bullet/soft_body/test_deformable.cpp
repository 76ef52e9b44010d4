// The deformable world with this library's contact: folds come to rest untangled, and Bullet makes no contact of its
// own.
#include "quickcullide/bullet_deformable.h"

#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionDispatch/btGhostObject.h>
#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_deformableStep = btScalar(1.0 / 240);

/// A floor, and cloths of masses and springs. `DeformableWorld` is Bullet's world or ours.
template <class DeformableWorld> struct World : qcDeformableTestWorld<DeformableWorld>
{
    using qcDeformableTestWorld<DeformableWorld>::world;
    using qcDeformableTestWorld<DeformableWorld>::cloths;
    btBoxShape floorShape{btVector3(5, 1, 5)};
    btRigidBody floor{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floorShape)};
    btDeformableMassSpringForce springs{10, btScalar(0.05), true};
    btDeformableGravityForce gravity;

    explicit World(const btVector3& g = btVector3(0, -10, 0)) : gravity(g)
    {
        world->setGravity(g);
        world->getWorldInfo().m_gravity = g;
        world->getWorldInfo().m_sparsesdf.setDefaultVoxelsz(btScalar(0.25));
        floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -1, 0)));
        floor.setFriction(1);
        world->addRigidBody(&floor);
    }

    ~World()
    {
        for (btSoftBody* cloth : cloths)
        {
            world->removeSoftBody(cloth);
            delete cloth;
        }
        cloths.clear();
        world->removeRigidBody(&floor);
    }

    btSoftBody* AddCloth(const btVector3& a, const btVector3& b, const btVector3& c, const btVector3& d, int side)
    {
        btSoftBody* cloth =
            btSoftBodyHelpers::CreatePatch(world->getWorldInfo(), a, b, c, d, side + 1, side + 1, 0, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        cloth->m_cfg.kKHR = cloth->m_cfg.kCHR = cloth->m_cfg.kDF = 1;
        cloth->m_cfg.collisions =
            btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN | btSoftBody::fCollision::VF_DD;
        cloth->setTotalMass(btScalar(0.5));
        cloth->setSelfCollision(true);
        world->addSoftBody(cloth);
        world->addForce(cloth, &springs);
        world->addForce(cloth, &gravity);
        cloths.push_back(cloth);
        return cloth;
    }

    btSoftBody* AddUprightCloth(int side)
    {
        return AddCloth(btVector3(btScalar(-0.5), btScalar(0.05), 0),
                        btVector3(btScalar(0.5), btScalar(0.05), btScalar(0.02)),
                        btVector3(btScalar(-0.5), btScalar(1.05), btScalar(0.03)),
                        btVector3(btScalar(0.5), btScalar(1.05), btScalar(-0.02)), side);
    }

    btSoftBody* AddSheet(btScalar y, btScalar turn, int side)
    {
        btScalar c = std::cos(turn) / 2, s = std::sin(turn) / 2;
        return AddCloth(btVector3(-c + s, y, -s - c), btVector3(c + s, y, s - c), btVector3(-c - s, y, -s + c),
                        btVector3(c - s, y, s + c), side);
    }

    void Step(int steps = 1)
    {
        for (int i = 0; i < steps; i++)
            world->stepSimulation(s_deformableStep, 0);
    }

    /// Steps in which nothing may penetrate.
    void StepApart(int steps)
    {
        for (int i = 0; i < steps; i++)
        {
            Step();
            ck_assert_int_eq(world->getStatistics().status, qc_statusOk);
            ck_assert_int_eq(world->getStatistics().remaining, 0);
        }
    }

    std::vector<qcWorldMesh> Soups() const
    {
        std::vector<qcWorldMesh> soups;
        for (const btSoftBody* cloth : cloths)
            soups.push_back(qcWorldMeshOf(cloth));
        return soups;
    }
};

using Ours = World<qcDeformableWorld>;
using Bullets = World<btDeformableMultiBodyDynamicsWorld>;

START_TEST(a_folded_deformable_cloth_comes_to_rest_untangled)
{
    Ours world;
    btSoftBody* cloth = world.AddUprightCloth(14);
    for (int i = 0; i < 600; i++)
    {
        world.StepApart(1);
        // The layers do not press the lowest one into the floor.
        ck_assert(qcLowestNode(cloth) > btScalar(0.002));
    }
    ck_assert_int_gt(world.world->getStatistics().contacts, 200);
    ck_assert(qcSpeedOf(cloth) < btScalar(0.05));
    ck_assert_uint_eq(qcCountPenetratingExactly(world.Soups()), 0);
}
END_TEST

START_TEST(the_same_cloth_tangles_without_self_collision)
{
    Ours world;
    btSoftBody* cloth = world.AddUprightCloth(14);
    qcSoftBodySettings settings;
    settings.selfCollision = false;
    settings.bulletNodeContacts = true; // contacts with the floor are not counted
    world.world->setSettings(cloth, settings);
    world.Step(200);
    ck_assert_int_eq(world.world->getStatistics().contacts, 0);
    ck_assert_uint_gt(qcCountPenetrating(world.Soups()), 20);
}
END_TEST

/// VF_DD finds contacts and leaves the cloth tangled: the constraints between faces and nodes, which the implicit solve
/// would satisfy, are never made.
START_TEST(bullets_own_self_collision_tangles_and_makes_no_constraints)
{
    Bullets world;
    btSoftBody* cloth = world.AddUprightCloth(14);
    int contacts = 0;
    size_t penetrating = 0;
    for (int i = 0; i < 25; i++)
    {
        world.Step(10);
        contacts += cloth->m_faceNodeContacts.size();
        penetrating = std::max(penetrating, qcCountPenetrating(world.Soups()));
        const btDeformableContactProjection& projection = world.deformableSolver.m_objective->m_projection;
        ck_assert_int_eq(projection.m_deformableConstraints.size(), 1);
        ck_assert_int_eq(projection.m_deformableConstraints[0].size(), 0);
    }
    ck_assert_int_gt(contacts, 1000);
    ck_assert_uint_gt(penetrating, 0);
}
END_TEST

START_TEST(bullet_makes_no_contact_of_its_own)
{
    Ours world;
    world.AddUprightCloth(12);
    world.AddSheet(btScalar(0.02), 0, 8);
    for (int i = 0; i < 200; i++)
    {
        world.StepApart(1);
        for (const btSoftBody* cloth : world.cloths)
        {
            ck_assert_int_eq(cloth->m_faceNodeContacts.size(), 0);
            ck_assert_int_eq(cloth->m_faceNodeContactsCCD.size(), 0);
            ck_assert_int_eq(cloth->m_scontacts.size(), 0);
        }
    }
    ck_assert_int_gt(world.world->getStatistics().contacts, 0);
}
END_TEST

START_TEST(without_contact_a_step_is_bullets)
{
    Ours world;
    Bullets same;
    btSoftBody *cloth = world.AddSheet(1, 0, 6), *other = same.AddSheet(1, 0, 6);
    for (int i = 0; i < 60; i++)
    {
        world.StepApart(1);
        same.Step();
        for (int n = 0; n < cloth->m_nodes.size(); n++)
            ck_assert(cloth->m_nodes[n].m_x == other->m_nodes[n].m_x && cloth->m_nodes[n].m_v == other->m_nodes[n].m_v);
    }
}
END_TEST

START_TEST(sheets_fall_on_each_other_and_stay_apart)
{
    Ours world;
    world.AddSheet(btScalar(0.02), 0, 8);
    world.AddSheet(btScalar(0.06), btScalar(0.4), 8);
    world.AddSheet(btScalar(0.10), btScalar(0.9), 8);
    world.StepApart(180);
    ck_assert_uint_eq(qcCountPenetratingExactly({qcWorldMeshOf(world.cloths[1]), qcWorldMeshOf(world.cloths[0]),
                                                 qcWorldMeshOf(world.cloths[2])}),
                      0);
    ck_assert(qcLowestNode(world.cloths[2]) > qcLowestNode(world.cloths[0]));
}
END_TEST

START_TEST(momentum_is_kept_between_two_cloths)
{
    Ours world(btVector3(0, 0, 0));
    btSoftBody *lower = world.AddSheet(btScalar(0.5), 0, 8), *upper = world.AddSheet(btScalar(0.55), btScalar(0.5), 9);
    upper->setVelocity(btVector3(btScalar(0.2), -1, 0));
    btVector3 before = qcMomentumOf(lower) + qcMomentumOf(upper);
    world.StepApart(40);
    ck_assert(qcMomentumOf(lower).y() < btScalar(-0.1));
    btVector3 after = qcMomentumOf(lower) + qcMomentumOf(upper);
    ck_assert((after - before).length() < btScalar(1e-3) * before.length());
}
END_TEST

START_TEST(a_deformable_cloth_rests_on_a_mesh_and_pushes_one)
{
    Ours world;
    std::unique_ptr<qcMeshShape> ball = qcSphereModel(0.2, 2).MakeShape(), dice;
    dice = qcBoxModel(btVector3(btScalar(0.05), btScalar(0.05), btScalar(0.05)), 2).MakeShape();
    btRigidBody fixed(0, nullptr, ball.get());
    fixed.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.3), 0)));
    btVector3 inertia;
    dice->calculateLocalInertia(btScalar(0.1), inertia);
    btRigidBody loose(btScalar(0.1), nullptr, dice.get(), inertia);
    loose.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.02), btScalar(0.7), 0)));
    world.world->addRigidBody(&fixed);
    world.world->addRigidBody(&loose);
    btSoftBody* cloth = world.AddSheet(btScalar(0.55), 0, 12);
    world.StepApart(200);
    ck_assert_int_eq(world.world->getStatistics().meshes, 2);
    ck_assert_int_gt(world.world->getStatistics().contacts, 50);
    // The die lies on the cloth, over the ball or where it slid to, and not inside.
    ck_assert(loose.getWorldTransform().getOrigin().y() > 0);
    ck_assert_uint_eq(qcCountPenetratingExactly({qcWorldMeshOf(cloth), qcWorldMeshOf(*ball, fixed.getWorldTransform()),
                                                 qcWorldMeshOf(*dice, loose.getWorldTransform())}),
                      0);
    world.world->removeRigidBody(&loose);
    world.world->removeRigidBody(&fixed);
}
END_TEST

/// An anchor in the middle of a sphere, which holds its node.
void CheckAnchor(bool bulletNodeContacts)
{
    Ours world;
    btSoftBody* cloth = world.AddUprightCloth(12);
    qcSoftBodySettings settings;
    settings.bulletNodeContacts = bulletNodeContacts;
    world.world->setSettings(cloth, settings);
    btSphereShape shape(btScalar(0.02));
    btRigidBody nail(0, nullptr, &shape);
    nail.setWorldTransform(btTransform(btQuaternion::getIdentity(), cloth->m_nodes[0].m_x));
    world.world->addRigidBody(&nail);
    btVector3 before = cloth->m_nodes[0].m_x;
    cloth->appendDeformableAnchor(0, &nail);
    int contacts = 0;
    for (int i = 0; i < 200; i++)
    {
        world.Step();
        contacts += world.world->getStatistics().contacts;
        ck_assert((cloth->m_nodes[0].m_x - before).length() < btScalar(1e-5));
        ck_assert_int_eq(world.world->getStatistics().zoneNodes, 0);
    }
    ck_assert_int_gt(contacts, 0);
    world.world->removeRigidBody(&nail);
}

START_TEST(an_anchored_node_stays_at_its_anchor)
{
    CheckAnchor(true);
    CheckAnchor(false);
}
END_TEST

START_TEST(contacts_stand_in_manifolds_until_the_next_step)
{
    Ours world;
    btSoftBody* cloth = world.AddUprightCloth(12);
    qcSoftBodySettings settings;
    settings.bulletNodeContacts = true; // contacts with the floor are not counted
    world.world->setSettings(cloth, settings);
    int seen = 0;
    for (int i = 0; i < 200; i++)
    {
        world.StepApart(1);
        int points = 0;
        for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
        {
            const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(m);
            if (manifold->getBody0() == cloth && manifold->getBody1() == cloth)
                points += manifold->getNumContacts();
        }
        ck_assert_int_eq(points, world.world->getStatistics().contacts);
        seen += points;
    }
    ck_assert_int_gt(seen, 100);
    world.world->removeSoftBody(cloth);
    world.cloths.clear();
    delete cloth;
    world.Step();
    ck_assert_int_eq(world.dispatcher.getNumManifolds(), 0);
}
END_TEST

START_TEST(a_node_that_is_not_finite_is_named_and_nothing_crashes)
{
    Ours world;
    btSoftBody* cloth = world.AddUprightCloth(6);
    world.StepApart(1);
    cloth->m_nodes[5].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
    world.Step();
    ck_assert_int_eq(world.world->getStatistics().status, qc_statusBadInput);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "of body 0 is not finite"));
}
END_TEST

/// Bullet's own repulsion draws its order from a seed that the worlds of a process share.
START_TEST(two_runs_agree_bit_by_bit)
{
    std::vector<btVector3> expected;
    for (int run = 0; run < 2; run++)
    {
        Ours world;
        btSoftBody* cloth = world.AddUprightCloth(12);
        world.Step(120);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            if (run == 0)
                expected.push_back(cloth->m_nodes[i].m_x);
            ck_assert(expected[size_t(i)] == cloth->m_nodes[i].m_x);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_sheet_at_rest_that_the_application_moves_into_the_floor_stays_at_rest)
{
    World<qcDeformableWorld> world;
    btSoftBody* sheet = world.AddSheet(btScalar(0.03), 0, 10);
    world.StepApart(120);
    sheet->translate(btVector3(0, btScalar(-0.3), 0));
    world.StepApart(20);
    ck_assert_double_lt(double(qcSpeedOf(sheet)), 0.01);
    ck_assert_double_gt(double(qcLowestNode(sheet)), 0);
}
END_TEST

/// Moves a kinematic plate with these further flags up through a sheet that sleeps, by its transform or by its
/// triangles, and calls step(world, sheet) at each place. Returns the height of the sheet's middle.
template <typename Function> static double MovePlateThroughSleeper(int flags, bool byTriangles, Function step)
{
    World<qcDeformableWorld> world(btVector3(0, 0, 0));
    btSoftBody* sheet = world.AddSheet(btScalar(0.5), 0, 10);
    world.StepApart(600);
    ck_assert(!sheet->isActive());
    const qcModel model = qcFloorModel(0.3, 2);
    std::vector<std::unique_ptr<qcMeshShape>> shapes;
    shapes.push_back(model.MakeShape());
    btRigidBody plate(0, nullptr, shapes[0].get());
    plate.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT | flags);
    plate.setActivationState(DISABLE_DEACTIVATION);
    world.world->addRigidBody(&plate);
    for (btScalar y : {btScalar(0.2), btScalar(0.35), btScalar(0.55), btScalar(0.75)})
    {
        const btTransform place(btQuaternion::getIdentity(), btVector3(0, y, 0));
        if (byTriangles)
        {
            qcModel moved = model;
            moved.Move(place);
            shapes.push_back(moved.MakeShape());
            plate.setCollisionShape(shapes.back().get());
        }
        else
            plate.setWorldTransform(place);
        step(world, sheet);
    }
    world.world->removeRigidBody(&plate);
    return double(sheet->m_nodes[11 * 5 + 5].m_x.y());
}

START_TEST(a_moving_plate_wakes_a_sleeping_sheet_and_takes_it_along)
{
    for (bool byTriangles : {false, true})
    {
        double height = MovePlateThroughSleeper(0, byTriangles,
                                                [](World<qcDeformableWorld>& world, btSoftBody*)
                                                {
                                                    world.StepApart(1);
                                                    ck_assert_int_eq(world.world->getStatistics().unproven, 0);
                                                });
        ck_assert_double_gt(height, 0.75);
    }
}
END_TEST

START_TEST(a_plate_without_response_does_not_wake_a_sleeping_sheet)
{
    for (bool byTriangles : {false, true})
        MovePlateThroughSleeper(btCollisionObject::CF_NO_CONTACT_RESPONSE, byTriangles,
                                [](World<qcDeformableWorld>& world, btSoftBody* sheet)
                                {
                                    world.Step();
                                    ck_assert(!sheet->isActive());
                                });
}
END_TEST

/// Positions of the nodes of two sheets after they have fallen on each other, with a sensor around them or without.
std::vector<btVector3> FallThroughSensor(bool hasSensor)
{
    World<qcDeformableWorld> world;
    world.AddSheet(btScalar(0.1), 0, 8);
    world.AddSheet(btScalar(0.2), btScalar(0.3), 8);
    btBoxShape shape(btVector3(1, 1, 1));
    btPairCachingGhostObject sensor;
    sensor.setCollisionShape(&shape);
    sensor.setCollisionFlags(sensor.getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
    if (hasSensor)
        world.world->addCollisionObject(&sensor);
    world.StepApart(120);
    if (hasSensor)
        world.world->removeCollisionObject(&sensor);
    std::vector<btVector3> positions;
    for (const btSoftBody* sheet : world.cloths)
        for (int i = 0; i < sheet->m_nodes.size(); i++)
            positions.push_back(sheet->m_nodes[i].m_x);
    return positions;
}

START_TEST(a_sensor_changes_nothing)
{
    const std::vector<btVector3> without = FallThroughSensor(false), with = FallThroughSensor(true);
    ck_assert_uint_eq(with.size(), without.size());
    for (size_t i = 0; i < with.size(); i++)
        ck_assert(with[i] == without[i]);
}
END_TEST

START_TEST(sheets_that_start_closer_than_their_thickness_are_not_thrown)
{
    for (btScalar step : {btScalar(1.0 / 60), btScalar(1.0 / 240), btScalar(1.0 / 1000)})
    {
        // Without forces: what moves is thrown.
        World<qcDeformableWorld> world;
        for (int layer = 0; layer < 4; layer++)
        {
            btSoftBody* sheet = world.AddSheet(btScalar(0.002) * btScalar(layer + 1), 0, 10);
            world.world->removeForce(sheet, &world.springs);
            world.world->removeForce(sheet, &world.gravity);
        }
        for (int i = 0; i < 100; i++)
        {
            world.world->stepSimulation(step, 0);
            ck_assert_int_eq(world.world->getStatistics().remaining, 0);
            for (const btSoftBody* sheet : world.cloths)
                ck_assert_double_lt(double(qcSpeedOf(sheet)), 0.01);
        }
        ck_assert_double_gt(double(qcLowestNode(world.cloths[3])), 0.03);
    }
}
END_TEST

/// A ball of four times the mass of a cloth that is pinned at its corners, and falls on it.
struct PinnedWorld : World<qcDeformableWorld>
{
    static constexpr btScalar stiffness = 40, bending = 2, ballMass = 2;
    btDeformableMassSpringForce damped;
    btSoftBody* cloth;
    btSphereShape shape{btScalar(0.3)};
    std::unique_ptr<btRigidBody> ball;

    explicit PinnedWorld(btScalar damping) : damped(stiffness, damping, true, bending)
    {
        floor.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -20, 0)));
        cloth = btSoftBodyHelpers::CreatePatch(world->getWorldInfo(), btVector3(-1, 0, -1), btVector3(1, 0, -1),
                                               btVector3(-1, 0, 1), btVector3(1, 0, 1), 13, 13, 15, true);
        cloth->setTotalMass(ballMass / 4);
        cloth->getCollisionShape()->setMargin(btScalar(0.05));
        world->addSoftBody(cloth);
        world->addForce(cloth, &damped);
        world->addForce(cloth, &gravity);
        cloths.push_back(cloth);
        btVector3 inertia;
        shape.calculateLocalInertia(ballMass, inertia);
        ball.reset(new btRigidBody(btRigidBody::btRigidBodyConstructionInfo(ballMass, nullptr, &shape, inertia)));
        ball->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.02), 1, btScalar(0.01))));
        world->addRigidBody(ball.get());
    }
    ~PinnedWorld()
    {
        world->removeRigidBody(ball.get());
        // The world looks at the body's forces, and these springs end before it.
        world->removeSoftBody(cloth);
        delete cloth;
        cloths.clear();
    }

    /// Kinetic, of gravity and of springs.
    double Energy() const
    {
        const btVector3 g = world->getGravity();
        const btTransform& place = ball->getWorldTransform();
        double energy = double(ballMass) * double(ball->getLinearVelocity().length2() / 2 - g.dot(place.getOrigin()));
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            const btSoftBody::Node& node = cloth->m_nodes[i];
            if (node.m_im > 0)
                energy += double((node.m_v.length2() / 2 - g.dot(node.m_x)) / node.m_im);
        }
        for (int i = 0; i < cloth->m_links.size(); i++)
        {
            const btSoftBody::Link& link = cloth->m_links[i];
            const double longer = double(link.m_n[0]->m_x.distance(link.m_n[1]->m_x) - link.m_rl);
            energy += double(link.m_bbending != 0 ? bending : stiffness) * longer * longer / 2;
        }
        return energy;
    }
};

START_TEST(a_load_on_a_pinned_sheet_gains_no_energy)
{
    for (btScalar damping : {btScalar(0.5), btScalar(3)})
    {
        PinnedWorld pinned(damping);
        const double start = pinned.Energy();
        double most = start;
        for (int step = 0; step < 480; step++)
        {
            pinned.StepApart(1);
            most = std::max(most, pinned.Energy());
        }
        printf("damping %g: gains %.2f J\n", double(damping), most - start);
        ck_assert_double_lt(most, start + 0.5);
        // Contact alone has it sink by 2 to 4 m.
        ck_assert_double_gt(double(pinned.ball->getWorldTransform().getOrigin().y()), -1.7);
    }
}
END_TEST

START_TEST(a_sheet_at_rest_falls_asleep_where_it_lies_and_wakes)
{
    World<qcDeformableWorld> world;
    btSoftBody* sheet = world.AddSheet(btScalar(0.03), 0, 10);
    world.StepApart(240);
    const btScalar lowest = qcLowestNode(sheet);
    // Bullet's bodies sleep after two seconds at rest.
    world.StepApart(480);
    ck_assert(!sheet->isActive());
    ck_assert_double_eq_tol(double(qcLowestNode(sheet)), double(lowest), 1e-6);
    world.AddSheet(btScalar(0.1), btScalar(0.3), 10);
    world.StepApart(30);
    ck_assert(sheet->isActive());
}
END_TEST
} // namespace

QC_RUN_TESTS("deformable", a_folded_deformable_cloth_comes_to_rest_untangled,
             the_same_cloth_tangles_without_self_collision, bullets_own_self_collision_tangles_and_makes_no_constraints,
             bullet_makes_no_contact_of_its_own, without_contact_a_step_is_bullets,
             sheets_fall_on_each_other_and_stay_apart, momentum_is_kept_between_two_cloths,
             a_deformable_cloth_rests_on_a_mesh_and_pushes_one, an_anchored_node_stays_at_its_anchor,
             contacts_stand_in_manifolds_until_the_next_step, a_node_that_is_not_finite_is_named_and_nothing_crashes,
             two_runs_agree_bit_by_bit, a_sheet_at_rest_that_the_application_moves_into_the_floor_stays_at_rest,
             a_moving_plate_wakes_a_sleeping_sheet_and_takes_it_along,
             a_plate_without_response_does_not_wake_a_sleeping_sheet, a_sensor_changes_nothing,
             sheets_that_start_closer_than_their_thickness_are_not_thrown, a_load_on_a_pinned_sheet_gains_no_energy,
             a_sheet_at_rest_falls_asleep_where_it_lies_and_wakes)
