// Soft bodies against Bullet's own shapes: nothing passes at any speed, cloth rests and holds by friction, both sides
// take up momentum, and Bullet's contacts of nodes stay where a setting or the object requires them.
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/shape_scene.h"
#include "support/long_form.h"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <cmath>

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btDeformableMassSpringForce.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/add_loop.h"

namespace
{
const double s_speeds[] = {5, 20, 50};

const char* const s_format = "%s at %g m/s, step %d: %d pairs";

/// Throws the cloth down at the shape, and checks each step.
void CheckThrow(qcShapeScene& scene, double speed, int steps)
{
    scene.cloth->setVelocity(btVector3(0, btScalar(-speed), 0));
    qcMotionOracle oracle;
    scene.Watch(oracle);
    const btScalar energy = scene.Energy();
    int contacts = 0, surfaces = 0;
    for (int step = 0; step < steps; step++)
    {
        scene.Step();
        const qcSoftBodyStatistics& statistics = scene.softSolver.getStatistics();
        contacts += statistics.contacts;
        surfaces += statistics.surfaces;
        ck_assert_int_eq(statistics.unproven, 0);
        ck_assert_int_eq(statistics.remaining, 0);
        size_t inside = oracle.Count();
        ck_assert_msg(inside == 0, s_format, scene.model.name, speed, step, int(inside));
        ck_assert_double_le(double(scene.Energy()), double(energy) + 1e-3 * std::fabs(double(energy)) + 0.05);
        // Bullet's tests of nodes don't run.
        ck_assert_int_eq(scene.cloth->m_rcontacts.size(), 0);
        ck_assert_int_eq(scene.cloth->m_scontacts.size(), 0);
    }
    ck_assert_int_gt(contacts, 100);
    ck_assert_int_gt(surfaces, 0);
}
} // namespace

START_TEST(thrown_cloth_passes_no_shape)
{
    qcShapeScene scene(qcShapeKind(_i / 3));
    CheckThrow(scene, s_speeds[_i % 3], _i % 3 == 0 ? 24 : 12);
}
END_TEST

START_TEST(a_cloth_of_20000_triangles_passes_no_pole_and_no_sphere)
{
    qcShapeScene scene(_i == 0 ? qc_shapeThinCylinder : qc_shapeSphere, 100);
    CheckThrow(scene, 50, 3);
}
END_TEST

START_TEST(thrown_cloth_passes_no_shape_in_the_deformable_world)
{
    qcShapeModel model = qcMakeShape(qcShapeKind(_i));
    btRigidBody body(0, nullptr, model.shape.get());
    btDeformableMassSpringForce springs(10, btScalar(0.05), true);
    btDeformableGravityForce gravity(btVector3(0, -10, 0));
    qcDeformableTestWorld<qcDeformableWorld> test;
    test.world->addRigidBody(&body);
    const btScalar y = model.top + btScalar(0.2);
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(test.world->getWorldInfo(), btVector3(-1, y, -1), btVector3(1, y, -1),
                                       btVector3(-1, y + btScalar(0.05), 1), btVector3(1, y, 1), 25, 25, 0, true);
    cloth->getCollisionShape()->setMargin(btScalar(0.01));
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDN;
    cloth->setTotalMass(1);
    test.world->addSoftBody(cloth);
    test.world->addForce(cloth, &springs);
    test.world->addForce(cloth, &gravity);
    test.cloths.push_back(cloth);
    cloth->setVelocity(btVector3(0, -20, 0));
    qcMotionOracle oracle;
    oracle.Add([cloth] { return qcWorldMeshOf(cloth); });
    oracle.Add(model.model, &body);
    int contacts = 0;
    for (int step = 0; step < 15; step++)
    {
        test.world->stepSimulation(btScalar(1.0 / 60), 0);
        const qcSoftBodyStatistics& statistics = test.world->getStatistics();
        contacts += statistics.contacts;
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.unproven, 0);
        ck_assert_uint_eq(oracle.Count(), 0);
        ck_assert_int_eq(cloth->m_nodeRigidContacts.size(), 0);
    }
    ck_assert_int_gt(contacts, 50);
    test.world->removeRigidBody(&body);
}
END_TEST

START_TEST(cloth_that_hangs_over_a_rim_needs_no_planes)
{
    // A round table of 1.2 m and a cloth of 2 m.
    qcSoftWorld world;
    btCylinderShape shape(btVector3(btScalar(0.6), btScalar(0.05), btScalar(0.6)));
    btRigidBody* table = world.AddBody(&shape, 0, btVector3(0, 0, 0));
    table->setFriction(btScalar(0.6));
    const btScalar y = btScalar(0.1);
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), btVector3(-1, y, -1), btVector3(1, y, -1),
                                       btVector3(-1, y, 1), btVector3(1, y, 1), 61, 61, 0, true);
    cloth->m_cfg.piterations = 8;
    cloth->setTotalMass(1);
    world.world.addSoftBody(cloth);
    world.cloths.push_back(cloth);
    int planes = 0, rounds = 0;
    for (int step = 0; step < 150; step++)
    {
        world.world.stepSimulation(btScalar(1.0 / 120), 0);
        planes += world.softSolver.getStatistics().planes;
        rounds += world.softSolver.getStatistics().rounds;
    }
    ck_assert_int_le(planes, 50);
    ck_assert_int_le(rounds, 180);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 100);
    world.RemoveCloth();
    world.world.removeRigidBody(table);
    world.bodies.clear();
}
END_TEST

START_TEST(thrown_cloth_passes_with_bullets_contacts_of_nodes)
{
    for (qcShapeKind kind : {qc_shapeSphere, qc_shapeBox, qc_shapeThinCapsule})
    {
        qcShapeScene scene(kind);
        scene.UseBulletsContacts();
        scene.cloth->setVelocity(btVector3(0, -20, 0));
        qcMotionOracle oracle;
        scene.Watch(oracle);
        size_t inside = 0;
        for (int step = 0; step < 12; step++)
        {
            scene.Step();
            inside += oracle.Count();
            ck_assert_int_eq(scene.softSolver.getStatistics().surfaces, 0);
        }
        ck_assert_uint_gt(inside, 10);
    }
}
END_TEST

namespace
{
/// The mean kinetic energy of the last second of four, or of eight.
btScalar RestingEnergy(qcShapeScene& scene, bool isOurs)
{
    scene.body->setFriction(btScalar(0.8));
    scene.cloth->m_cfg.kDF = btScalar(0.8);
    scene.cloth->m_cfg.kDP = btScalar(0.005);
    btScalar sum = 0;
    const int steps = qcIsLongForm() ? 480 : 240;
    qcMotionOracle oracle;
    scene.Watch(oracle);
    for (int step = 0; step < steps; step++)
    {
        scene.Step();
        if (isOurs)
            ck_assert_uint_eq(oracle.CountNow(), 0);
        if (step >= steps - 60)
            sum += scene.KineticEnergy() / 60;
    }
    return sum;
}
} // namespace

START_TEST(cloth_rests_on_a_shape_quieter_than_by_bullets_contacts)
{
    const qcShapeKind kinds[] = {qc_shapeSphere,      qc_shapeBox,          qc_shapeTiltedBox,  qc_shapeCapsule,
                                 qc_shapeThinCapsule, qc_shapeThinCylinder, qc_shapeCylinder,   qc_shapeHull,
                                 qc_shapeMultiSphere, qc_shapePlane,        qc_shapeHeightfield};
    qcShapeScene ours(kinds[_i], 20, 1);
    btScalar energy = RestingEnergy(ours, true);
    // In joules, of 1 kg; on many shapes Bullet's cloth slides off, or falls through.
    ck_assert_double_lt(double(energy), 2e-3);
    // A step of Bullet's cloth on the heightfield takes 40 ms.
    if (kinds[_i] != qc_shapeHeightfield || qcIsLongForm())
    {
        qcShapeScene bullets(kinds[_i], 20, 1, 0, true);
        ck_assert_double_le(double(energy), double(RestingEnergy(bullets, false)));
    }
    // It hangs over the shape, not inside.
    ck_assert_double_gt(double(ours.Center().y()), -0.5);
    ck_assert_int_eq(ours.softSolver.getStatistics().zoneNodes, 0);
}
END_TEST

START_TEST(friction_on_a_slope_is_coulombs)
{
    // The friction of both is 0.5: the angle of rest is 26.6 degrees.
    for (double degrees : {25.0, 30.0})
    {
        qcSoftWorld world;
        const btScalar angle = btScalar(degrees) * SIMD_RADS_PER_DEG;
        const btQuaternion slope(btVector3(0, 0, 1), -angle);
        btBoxShape shape(btVector3(6, btScalar(0.2), 3));
        btRigidBody* body = world.AddBody(&shape, 0, btVector3(0, 0, 0));
        body->setWorldTransform(btTransform(slope));
        world.world.updateSingleAabb(body);
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), btVector3(-0.5, 0, -0.5),
                                                           btVector3(0.5, 0, -0.5), btVector3(-0.5, 0, 0.5),
                                                           btVector3(0.5, 0, 0.5), 21, 21, 0, true);
        cloth->transform(btTransform(slope, quatRotate(slope, btVector3(-2, btScalar(0.225), 0))));
        cloth->m_cfg.piterations = 8;
        cloth->setTotalMass(1);
        world.world.addSoftBody(cloth);
        world.cloths.push_back(cloth);
        qcSoftBodySettings settings;
        settings.friction = btScalar(0.5);
        world.softSolver.setSettings(cloth, settings);
        btVector3 start(0, 0, 0);
        for (int step = 0; step < 180; step++)
        {
            world.world.stepSimulation(btScalar(1.0 / 60), 0);
            if (step == 59)
                start = cloth->m_nodes[220].m_x;
        }
        double slid = double((cloth->m_nodes[220].m_x - start).length());
        // From the first second to the third.
        double expected = degrees < 26.6 ? 0 : 4 * 9.8 * double(btSin(angle) - btScalar(0.5) * btCos(angle));
        ck_assert_double_eq_tol(slid, expected, 0.01 + 0.1 * expected);
        world.RemoveCloth();
        world.world.removeRigidBody(body);
        world.bodies.clear();
    }
}
END_TEST

START_TEST(cloth_and_a_free_shape_keep_momentum)
{
    const qcShapeKind kinds[] = {qc_shapeSphere, qc_shapeBox, qc_shapeCapsule, qc_shapeHull, qc_shapeCompound};
    qcShapeScene scene(kinds[_i], 24, 2, 3);
    scene.SetGravity(btVector3(0, 0, 0));
    scene.body->setDamping(0, 0);
    scene.cloth->setVelocity(btVector3(1, -20, 0));
    const btVector3 before = qcMomentumOf(scene.cloth);
    const btScalar energy = scene.KineticEnergy();
    qcMotionOracle oracle;
    scene.Watch(oracle);
    for (int step = 0; step < 20; step++)
    {
        scene.Step();
        ck_assert_uint_eq(oracle.Count(), 0);
        const btVector3 velocity = scene.body->getLinearVelocity();
        btVector3 momentum = qcMomentumOf(scene.cloth) + velocity * 3;
        ck_assert_double_le(double((momentum - before).length()), 2e-3 * double(before.length()));
        ck_assert_double_le(double(scene.KineticEnergy() + velocity.length2() * 3 / 2), 1.001 * double(energy));
    }
    ck_assert_double_lt(double(scene.body->getLinearVelocity().y()), -1);
}
END_TEST

START_TEST(a_ball_in_a_cloth_without_friction_is_not_spun_up)
{
    // Nothing can turn it. Off the middle of a free cloth.
    for (btScalar step : {btScalar(1.0 / 60), btScalar(1.0 / 240)})
        for (btScalar speed : {btScalar(10), btScalar(20)})
        {
            qcSoftWorld made;
            btSphereShape sphere(btScalar(0.25));
            made.SetGravity(btVector3(0, 0, 0));
            btSoftBody* cloth = made.AddPatch(btVector3(-1, 0, -1), btVector3(1, 0, -1), btVector3(-1, 0, 1),
                                              btVector3(1, 0, 1), 21, 21, 0);
            cloth->setTotalMass(1);
            cloth->m_cfg.piterations = 4;
            qcSoftBodySettings settings;
            settings.friction = 0;
            ck_assert_int_eq(made.softSolver.setSettings(cloth, settings), qc_statusOk);
            btRigidBody* ball = made.AddBody(&sphere, 2, btVector3(btScalar(0.3), 1, btScalar(0.05)));
            ball->setFriction(0);
            ball->setActivationState(DISABLE_DEACTIVATION);
            ball->setLinearVelocity(btVector3(0, -speed, 0));
            const double before = double(speed * speed);
            double mostSpin = 0, mostEnergy = 0;
            for (int i = 0; i < int(1 / step); i++)
            {
                made.world.stepSimulation(step, 0);
                const double spin = double(ball->getAngularVelocity().length());
                mostSpin = std::max(mostSpin, spin);
                double energy = double(ball->getLinearVelocity().length2()) +
                                0.5 * double(ball->getLocalInertia().x()) * spin * spin;
                for (int n = 0; n < cloth->m_nodes.size(); n++)
                    energy += 0.5 * double(cloth->m_nodes[n].m_v.length2() / cloth->m_nodes[n].m_im);
                mostEnergy = std::max(mostEnergy, energy / before);
            }
            printf("ball of %g m/s in a cloth, step %.4f s: spin %.1f rad/s, energy %.3f of that before\n",
                   double(speed), double(step), mostSpin, mostEnergy);
            ck_assert_double_lt(mostSpin, 8);
            ck_assert_double_lt(mostEnergy, 1.002);
            ck_assert_double_lt(double(ball->getLinearVelocity().y()), -0.5 * double(speed));
            made.RemoveAll();
        }
}
END_TEST

START_TEST(a_kinematic_shape_takes_cloth_along_at_20_metres_a_second)
{
    const qcShapeKind kinds[] = {qc_shapeBox, qc_shapeThinCylinder, qc_shapeSphere, qc_shapePlane};
    qcShapeScene scene(kinds[_i], 24);
    scene.SetGravity(btVector3(0, 0, 0));
    scene.world.removeRigidBody(scene.body);
    scene.body->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    scene.body->setActivationState(DISABLE_DEACTIVATION);
    scene.world.addRigidBody(scene.body);
    scene.Step();
    qcMotionOracle oracle;
    scene.Watch(oracle);
    for (int step = 0; step < 15; step++)
    {
        btTransform place = scene.body->getWorldTransform();
        place.getOrigin().setY(place.getOrigin().y() + btScalar(1.0 / 3));
        scene.body->setWorldTransform(place);
        scene.Step();
        ck_assert_uint_eq(oracle.Count(), 0);
        ck_assert_int_eq(scene.softSolver.getStatistics().unproven, 0);
    }
    ck_assert_double_gt(double(scene.Center().y()), 2);
}
END_TEST

START_TEST(cloth_slides_along_a_plane_for_any_distance)
{
    // The patch of the plane in the scene follows the cloth.
    for (qcShapeKind kind : {qc_shapePlane, qc_shapeTiltedPlane})
    {
        qcShapeScene scene(kind, 16);
        scene.body->setFriction(0);
        qcSoftBodySettings settings;
        settings.friction = 0;
        scene.softSolver.setSettings(scene.cloth, settings);
        scene.cloth->setVelocity(btVector3(20, -5, 0));
        qcMotionOracle oracle;
        scene.Watch(oracle);
        for (int step = 0; step < 60; step++)
        {
            scene.Step();
            ck_assert_uint_eq(oracle.Count(), 0);
        }
        ck_assert_double_gt(double(scene.Center().x()), 10);
    }
}
END_TEST

START_TEST(bullets_contacts_of_links_of_multibodies_are_on_request)
{
    for (bool isBullets : {false, true})
    {
        qcShapeScene scene(qc_shapePlane, 16);
        btMultiBody multibody(0, 1, btVector3(1, 1, 1), true, false);
        btMultiBodyLinkCollider link(&multibody, -1);
        btBoxShape shape(btVector3(2, btScalar(0.1), 2));
        link.setCollisionShape(&shape);
        link.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.15), 0)));
        multibody.setBaseCollider(&link);
        multibody.finalizeMultiDof();
        scene.world.addCollisionObject(&link);
        if (isBullets)
            scene.UseBulletsContacts();
        int nodes = 0;
        for (int step = 0; step < 60; step++)
        {
            scene.Step();
            nodes += scene.cloth->m_rcontacts.size();
        }
        ck_assert_int_eq(nodes > 100, isBullets);
        ck_assert_int_eq(nodes == 0, !isBullets);
        ck_assert_double_gt(double(qcLowestNode(scene.cloth)), 0.2);
        scene.world.removeCollisionObject(&link);
    }
}
END_TEST

START_TEST(after_a_failed_query_bullets_contacts_hold)
{
    qcShapeScene scene(qc_shapeBox, 16, 1);
    scene.softSolver.setMethod(qc_methodQuick);
    int nodes = 0;
    for (int step = 0; step < 40; step++)
    {
        scene.world.stepSimulation(btScalar(1.0 / 60), 0);
        ck_assert_int_eq(scene.softSolver.getStatistics().status, qc_statusBadInput);
        nodes += scene.cloth->m_rcontacts.size();
    }
    ck_assert_int_gt(nodes, 100);
    scene.softSolver.setMethod(qc_methodAuto);
    scene.Step();
    scene.Step();
    ck_assert_int_eq(scene.cloth->m_rcontacts.size(), 0);
    ck_assert_int_eq(scene.softSolver.getStatistics().surfaces, 1);
}
END_TEST

START_TEST(filters_sensors_and_disabled_pairs_let_cloth_pass)
{
    for (int kind = 0; kind < 4; kind++)
    {
        qcShapeScene scene(qc_shapeSphere, 16);
        if (kind == 0)
            scene.body->setCollisionFlags(scene.body->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        else if (kind == 1)
            scene.cloth->m_collisionDisabledObjects.push_back(scene.body);
        else if (kind == 2)
            scene.body->getBroadphaseHandle()->m_collisionFilterMask = 0;
        else
            scene.cloth->m_cfg.collisions &= ~btSoftBody::fCollision::RVSmask;
        for (int step = 0; step < 90; step++)
        {
            scene.Step();
            ck_assert_int_eq(scene.softSolver.getStatistics().planes, 0);
        }
        ck_assert_double_lt(double(scene.Center().y()), -5);
    }
}
END_TEST

START_TEST(a_changed_shape_is_read_again)
{
    qcShapeScene scene(qc_shapeSphere, 20, 1);
    for (int step = 0; step < 60; step++)
        scene.Step();
    ck_assert_double_lt(double(scene.cloth->m_nodes[220].m_x.y()), 0.55);
    // It grows by a millimetre in each step.
    for (int step = 1; step <= 50; step++)
    {
        scene.model.shape->setLocalScaling(btVector3(1, 1, 1) * (1 + btScalar(step) / 500));
        scene.world.updateSingleAabb(scene.body);
        scene.Step();
    }
    for (int step = 0; step < 60; step++)
        scene.Step();
    ck_assert_double_gt(double(scene.cloth->m_nodes[220].m_x.y()), 0.549);
}
END_TEST

START_TEST(a_terrain_at_the_address_of_a_deleted_one_is_read_anew)
{
    qcSoftWorld soft;
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(soft.world.getWorldInfo(), btVector3(-1, btScalar(0.9), -1),
                                                       btVector3(1, btScalar(0.9), -1), btVector3(-1, btScalar(0.9), 1),
                                                       btVector3(1, btScalar(0.9), 1), 9, 9, 0, true);
    cloth->setTotalMass(1);
    soft.world.addSoftBody(cloth);
    soft.cloths.push_back(cloth);
    alignas(16) unsigned char room[sizeof(btHeightfieldTerrainShape)];
    // Each tile is lower than the one before, and has the same box.
    for (float height : {0.8f, 0.4f, 0.0f})
    {
        const std::vector<float> heights(81, height);
        auto* terrain = new (room) btHeightfieldTerrainShape(9, 9, heights.data(), btScalar(-1), btScalar(1), 1, false);
        terrain->setMargin(btScalar(0.01));
        soft.AddBody(terrain, 0, btVector3(0, 0, 0));
        for (int step = 0; step < 60; step++)
            soft.world.stepSimulation(btScalar(1.0 / 60), 0);
        for (int node = 0; node < cloth->m_nodes.size(); node++)
        {
            ck_assert_double_gt(double(cloth->m_nodes[node].m_x.y()), double(height));
            ck_assert_double_lt(double(cloth->m_nodes[node].m_x.y()), double(height) + 0.1);
        }
        soft.world.removeRigidBody(soft.bodies.back().get());
        soft.bodies.pop_back();
        terrain->~btHeightfieldTerrainShape();
    }
}
END_TEST

START_TEST(cloth_goes_with_triangles_that_move)
{
    // The contact distance is 15 mm.
    for (btScalar rise : {btScalar(0.001), btScalar(0.01)})
    {
        qcShapeScene scene(qc_shapeHeightfield, 20, 1);
        for (int step = 0; step < 60; step++)
            scene.Step();
        const btScalar before = scene.Center().y();
        for (int step = 0; step < 8; step++)
        {
            for (btScalar& height : scene.model.heights)
                height += rise;
            scene.softSolver.updateShape(scene.model.shape.get());
            scene.Step();
            ck_assert_double_gt(double(scene.Center().y() - before), double(rise * btScalar(step + 1)) - 0.01);
        }
        for (int step = 0; step < 60; step++)
            scene.Step();
        ck_assert_double_eq_tol(double(scene.Center().y() - before), 8 * double(rise), 0.004);
    }
}
END_TEST

START_TEST(cloth_anchored_inside_a_shape_hangs_from_it)
{
    qcShapeScene scene(qc_shapeCylinder, 16);
    // The cylinder stands at the cloth's edge, around five of its nodes.
    btTransform place(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI), scene.cloth->m_nodes[8].m_x);
    scene.body->setWorldTransform(place);
    scene.world.updateSingleAabb(scene.body);
    for (int node = 6; node <= 10; node++)
        scene.cloth->appendAnchor(node, scene.body);
    const btVector3 anchor = scene.cloth->m_nodes[8].m_x;
    // Anchors are soft, and the cloth swings: judged is the mean over the last five seconds, 0.095 with Bullet's
    // solver.
    double sum = 0;
    for (int step = 0; step < 600; step++)
    {
        scene.Step();
        ck_assert_int_eq(scene.softSolver.getStatistics().zoneNodes, 0);
        double distance = double((scene.cloth->m_nodes[8].m_x - anchor).length());
        ck_assert_double_lt(distance, 0.2);
        sum += step >= 300 ? distance / 300 : 0;
    }
    ck_assert_double_lt(sum, 0.09);
    ck_assert_double_lt(double(scene.Center().y()), double(anchor.y()) - 0.5);
}
END_TEST

START_TEST(shapes_far_from_soft_bodies_are_not_read)
{
    qcShapeScene scene(qc_shapeSphere, 8);
    btBoxShape shape(btVector3(1, 1, 1));
    for (int i = 0; i < 20; i++)
        scene.AddBody(&shape, 0, btVector3(10 + btScalar(3 * i), 0, 0));
    for (int step = 0; step < 30; step++)
        scene.Step();
    ck_assert_int_eq(scene.softSolver.getStatistics().surfaces, 1);
    ck_assert_int_eq(scene.softSolver.getStatistics().meshes, 0);
}
END_TEST

START_TEST(two_runs_agree_bit_by_bit_for_any_number_of_threads)
{
    for (qcShapeKind kind : {qc_shapeCompound, qc_shapeMultiSphere, qc_shapeTiltedPlane})
    {
        std::vector<btVector3> expected;
        for (unsigned threads : {1u, 1u, 3u})
        {
            qcShapeScene scene(kind, 20);
            scene.softSolver.setThreadCount(threads);
            scene.cloth->setVelocity(btVector3(0, -10, 0));
            for (int step = 0; step < 40; step++)
                scene.Step();
            for (int i = 0; i < scene.cloth->m_nodes.size(); i++)
            {
                if (expected.size() <= size_t(i))
                    expected.push_back(scene.cloth->m_nodes[i].m_x);
                ck_assert(expected[size_t(i)] == scene.cloth->m_nodes[i].m_x);
            }
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("soft shapes");
    qcAddLoop(tests, thrown_cloth_passes_no_shape, 3 * qc_shapeCount);
    tcase_add_loop_test(tests, a_cloth_of_20000_triangles_passes_no_pole_and_no_sphere, 0, 2);
    qcAddLoop(tests, thrown_cloth_passes_no_shape_in_the_deformable_world, qc_shapeCount);
    tcase_add_test(tests, cloth_that_hangs_over_a_rim_needs_no_planes);
    tcase_add_test(tests, thrown_cloth_passes_with_bullets_contacts_of_nodes);
    qcAddLoop(tests, cloth_rests_on_a_shape_quieter_than_by_bullets_contacts, 11);
    tcase_add_test(tests, friction_on_a_slope_is_coulombs);
    qcAddLoop(tests, cloth_and_a_free_shape_keep_momentum, 5);
    qcAddLoop(tests, a_kinematic_shape_takes_cloth_along_at_20_metres_a_second, 4);
    tcase_add_test(tests, a_ball_in_a_cloth_without_friction_is_not_spun_up);
    tcase_add_test(tests, cloth_slides_along_a_plane_for_any_distance);
    tcase_add_test(tests, bullets_contacts_of_links_of_multibodies_are_on_request);
    tcase_add_test(tests, after_a_failed_query_bullets_contacts_hold);
    tcase_add_test(tests, filters_sensors_and_disabled_pairs_let_cloth_pass);
    tcase_add_test(tests, a_changed_shape_is_read_again);
    tcase_add_test(tests, a_terrain_at_the_address_of_a_deleted_one_is_read_anew);
    tcase_add_test(tests, cloth_goes_with_triangles_that_move);
    tcase_add_test(tests, cloth_anchored_inside_a_shape_hangs_from_it);
    tcase_add_test(tests, shapes_far_from_soft_bodies_are_not_read);
    tcase_add_test(tests, two_runs_agree_bit_by_bit_for_any_number_of_threads);
    return qcRunCase("soft shapes", tests);
}
