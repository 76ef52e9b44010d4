// Soft bodies against qcMeshShape in Bullet's soft-rigid world: they rest on it, push it, and never penetrate it.
#include "quickcullide/bullet.h"

#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <memory>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_shortStep = btScalar(1.0 / 120);

/// A world of meshes and at most one cloth.
struct ClothOverMesh : qcSoftWorld
{
    btSoftBody* cloth = nullptr;

    explicit ClothOverMesh(bool isPlain = false) : qcSoftWorld(nullptr, isPlain)
    {
    }

    ~ClothOverMesh()
    {
        RemoveCloth();
    }

    void RemoveCloth()
    {
        if (cloth != nullptr)
            qcSoftWorld::RemoveCloth();
        cloth = nullptr;
    }

    /// Adds a cloth of one square metre at a height; `fixed`: +1 +2 +4 +8 for its corners.
    void AddCloth(btScalar y, int side, int fixed = 0)
    {
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-0.5, y, -0.5), btVector3(0.5, y, -0.5),
                                               btVector3(-0.5, y, 0.5), btVector3(0.5, y, 0.5), side + 1, side + 1,
                                               fixed, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        cloth->m_cfg.piterations = 6;
        cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
        cloth->m_cfg.kKHR = 1;
        cloth->setTotalMass(btScalar(0.5));
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
    }

    void Step(btScalar timeStep = s_shortStep)
    {
        world.stepSimulation(timeStep, 0);
    }

    /// Steps in which nothing may penetrate.
    void StepApart(int steps, btScalar timeStep = s_shortStep)
    {
        for (int i = 0; i < steps; i++)
        {
            Step(timeStep);
            ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
            ck_assert_int_eq(softSolver.getStatistics().remaining, 0);
        }
    }

    /// The cloth, and the meshes of all bodies.
    std::vector<qcWorldMesh> Soups() const
    {
        std::vector<qcWorldMesh> soups{qcWorldMeshOf(cloth)};
        for (const auto& body : bodies)
            if (const auto* mesh = dynamic_cast<const qcMeshShape*>(body->getCollisionShape()))
                soups.push_back(qcWorldMeshOf(*mesh, body->getWorldTransform()));
        return soups;
    }
};

/// A hill 40 cm high on a square of two metres.
qcModel HillModel(int n)
{
    qcModel model = qcFloorModel(1, n);
    for (size_t i = 0; i < model.positions.size(); i += 3)
    {
        btScalar x = model.positions[i], z = model.positions[i + 2];
        model.positions[i + 1] = btScalar(0.4) * std::exp(-4 * (x * x + z * z));
    }
    return model;
}

START_TEST(a_cloth_comes_to_rest_on_a_mesh_without_penetrating)
{
    ClothOverMesh world;
    qcMeshShape* hill = world.KeepMesh(HillModel(30));
    btRigidBody* body = world.AddBody(hill, 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.6), 14);
    world.StepApart(240);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 100);
    ck_assert_int_eq(world.softSolver.getStatistics().frozenNodes, 0);
    ck_assert(qcSpeedOf(world.cloth) < btScalar(0.01));
    ck_assert_uint_eq(qcCountPenetratingExactly(world.Soups()), 0);
    // On the hill, and not above it: the thickness of both keeps them apart.
    btScalar apart = std::min(btScalar(0.01), btScalar(0.5) / 14) / 2 + hill->getMargin();
    btScalar nearest = BT_LARGE_FLOAT;
    for (int i = 0; i < world.cloth->m_nodes.size(); i++)
    {
        const btVector3& x = world.cloth->m_nodes[i].m_x;
        nearest = std::min(nearest, x.y() - btScalar(0.4) * std::exp(-4 * (x.x() * x.x() + x.z() * x.z())));
    }
    ck_assert(nearest > apart - btScalar(0.005) && nearest < apart + btScalar(0.005));
    ck_assert(body->getWorldTransform().getOrigin().isZero());
}
END_TEST

/// 14 m/s, 23 cm a step.
START_TEST(a_cloth_that_falls_from_ten_metres_is_held_by_a_floor_of_triangles)
{
    ClothOverMesh world;
    world.AddBody(world.KeepMesh(qcFloorModel(2, 8)), 0, btVector3(0, 0, 0));
    world.AddCloth(10, 10);
    int swept = 0;
    for (int i = 0; i < 120; i++)
    {
        world.StepApart(1, btScalar(1.0 / 60));
        swept += world.softSolver.getStatistics().sweptNodes;
        ck_assert(qcLowestNode(world.cloth) > 0);
    }
    ck_assert_int_gt(swept, 50);
    ck_assert(qcLowestNode(world.cloth) < btScalar(0.05));
}
END_TEST

/// Bullet makes a prism 12 cm thick of each triangle and pushes each node out of each by itself, so that the
/// prisms of neighbours push it on. No qcSoftBodySolver, no contact of ours.
START_TEST(bullets_own_algorithm_lets_a_cloth_fall_through_a_fine_mesh)
{
    ClothOverMesh world(true);
    world.AddBody(world.KeepMesh(HillModel(40)), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.6), 24);
    for (int i = 0; i < 120; i++)
        world.Step();
    ck_assert_int_gt(world.world.getWorldInfo().m_sparsesdf.ncells, 0);
    ck_assert(qcLowestNode(world.cloth) < -1);
}
END_TEST

START_TEST(bullet_makes_no_contact_of_its_own)
{
    ClothOverMesh world;
    world.AddBody(world.KeepMesh(HillModel(12)), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.45), 8);
    for (int i = 0; i < 60; i++)
    {
        world.StepApart(1);
        ck_assert_int_eq(world.cloth->m_rcontacts.size(), 0);
    }
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
    ck_assert_int_eq(world.world.getWorldInfo().m_sparsesdf.ncells, 0);
}
END_TEST

START_TEST(other_triangle_meshes_stay_bullets_by_a_setting)
{
    ClothOverMesh world;
    qcModel model = qcFloorModel(2, 4);
    std::unique_ptr<btTriangleIndexVertexArray> triangles = model.MakeInterface();
    btBvhTriangleMeshShape shape(triangles.get(), true);
    btRigidBody* body = world.AddBody(&shape, 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.1), 8);
    qcSoftBodySettings settings;
    settings.bulletNodeContacts = true;
    world.softSolver.setSettings(world.cloth, settings);
    int contacts = 0;
    for (int i = 0; i < 60; i++)
    {
        world.StepApart(1);
        ck_assert_int_eq(world.softSolver.getStatistics().meshes, 0);
        ck_assert_int_eq(world.softSolver.getStatistics().surfaces, 0);
        contacts += world.cloth->m_rcontacts.size();
    }
    ck_assert_int_gt(contacts, 0);
    world.RemoveCloth();
    world.world.removeRigidBody(body);
    world.bodies.clear();
}
END_TEST

START_TEST(momentum_is_kept_between_a_cloth_and_a_free_mesh)
{
    ClothOverMesh world;
    world.SetGravity(btVector3(0, 0, 0));
    qcMeshShape* ball = world.KeepMesh(qcSphereModel(0.2, 2));
    btRigidBody* body = world.AddBody(ball, 2, btVector3(btScalar(0.1), btScalar(-0.3), btScalar(0.05)));
    body->setDamping(0, 0);
    body->setFriction(1);
    body->setLinearVelocity(btVector3(btScalar(0.3), 2, 0));
    body->setAngularVelocity(btVector3(0, 0, 3));
    world.AddCloth(0, 12);
    btVector3 before = qcMomentumOf(world.cloth) + 2 * body->getLinearVelocity();
    world.StepApart(60);
    ck_assert(body->getLinearVelocity().y() < btScalar(1.9));
    ck_assert(body->getAngularVelocity().z() < btScalar(2.9));
    ck_assert(qcMomentumOf(world.cloth).y() > btScalar(0.2));
    btVector3 after = qcMomentumOf(world.cloth) + 2 * body->getLinearVelocity();
    ck_assert((after - before).length() < btScalar(1e-3) * before.length());
}
END_TEST

START_TEST(a_cloth_that_is_held_at_its_corners_catches_a_mesh)
{
    ClothOverMesh world;
    btRigidBody* body = world.AddBody(world.KeepMesh(qcSphereModel(0.15, 2)), btScalar(0.3),
                                      btVector3(0, btScalar(0.4), btScalar(0.02)));
    world.AddCloth(0, 16, 1 + 2 + 4 + 8);
    world.StepApart(360);
    ck_assert(body->getLinearVelocity().length() < btScalar(0.3));
    // In the sagging cloth: above its lowest node.
    ck_assert(body->getWorldTransform().getOrigin().y() > qcLowestNode(world.cloth) + btScalar(0.1));
    ck_assert(body->getWorldTransform().getOrigin().y() > -1);
    ck_assert_uint_eq(qcCountPenetratingExactly(world.Soups()), 0);
}
END_TEST

/// Balls, boxes and rings fall on a cloth on a floor, in steps of 8 cm. Two of Bullet's solvers and one of this
/// library's act independently of each other: the cloth is squeezed, but not cut.
START_TEST(a_cloth_under_a_pile_of_meshes_is_never_penetrated)
{
    ClothOverMesh world;
    world.meshContact.addTo(&world.world);
    world.meshContact.setThreadCount(1);
    world.AddBody(world.KeepMesh(qcFloorModel(2, 8)), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.5), 14);
    const qcModel models[3] = {qcSphereModel(0.12, 1),
                               qcBoxModel(btVector3(btScalar(0.1), btScalar(0.05), btScalar(0.15)), 2),
                               qcTorusModel(0.13, 0.04, 12, 6)};
    for (int i = 0; i < 6; i++)
    {
        btVector3 at(btScalar(0.1) * btScalar(i % 3 - 1), btScalar(0.8) + btScalar(0.3) * btScalar(i),
                     btScalar(0.12) * btScalar(i % 2));
        world.AddBody(world.KeepMesh(models[i % 3]), btScalar(0.3), at);
    }
    for (int i = 0; i < 12; i++)
    {
        world.StepApart(8, btScalar(1.0 / 60));
        ck_assert_uint_eq(qcCountPenetrating({world.Soups()[0]}), 0);
    }
    for (const auto& body : world.bodies)
        ck_assert(body->getWorldTransform().getOrigin().y() > btScalar(-0.01));
    ck_assert(qcLowestNode(world.cloth) > 0);
    ck_assert_uint_eq(qcCountPenetratingExactly(world.Soups()), 0);
}
END_TEST

START_TEST(a_kinematic_mesh_lifts_a_cloth)
{
    ClothOverMesh world;
    btRigidBody* lift = world.AddBody(world.KeepMesh(qcFloorModel(1, 6)), 0, btVector3(0, 0, 0));
    lift->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    lift->setActivationState(DISABLE_DEACTIVATION);
    world.AddCloth(btScalar(0.05), 10);
    world.StepApart(60);
    btScalar y = 0;
    for (int i = 0; i < 120; i++)
    {
        // Up by 2 m/s, 17 mm a step.
        y += btScalar(2.0 / 120);
        lift->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, y, 0)));
        world.StepApart(1);
        ck_assert(qcLowestNode(world.cloth) > y);
    }
    ck_assert(qcLowestNode(world.cloth) < y + btScalar(0.05));
    ck_assert_uint_eq(qcCountPenetratingExactly(world.Soups()), 0);
}
END_TEST

/// A dumbbell of two meshes, one of them turned.
START_TEST(meshes_in_a_compound_hold_a_cloth)
{
    ClothOverMesh world;
    std::unique_ptr<btCompoundShape> compound(new btCompoundShape);
    compound->addChildShape(btTransform(btQuaternion(btVector3(0, 1, 0), 1), btVector3(btScalar(-0.3), 0, 0)),
                            world.KeepMesh(qcSphereModel(0.15, 1)));
    compound->addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3), 0, 0)),
                            world.KeepMesh(qcBoxModel(btVector3(btScalar(0.1), btScalar(0.1), btScalar(0.2)), 3)));
    world.AddBody(compound.get(), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.3), 16);
    world.StepApart(90);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 20);
    ck_assert_int_eq(world.cloth->m_rcontacts.size(), 0);
    ck_assert(qcLowestNode(world.cloth) > -1);
    world.RemoveCloth();
    world.world.removeRigidBody(world.bodies.back().get());
    world.bodies.clear();
}
END_TEST

START_TEST(pairs_that_bullet_filters_out_have_no_contact)
{
    for (int kind = 0; kind < 4; kind++)
    {
        ClothOverMesh world;
        btRigidBody* body = world.AddBody(world.KeepMesh(qcFloorModel(1, 4)), 0, btVector3(0, 0, 0));
        world.AddCloth(btScalar(0.05), 6);
        if (kind == 0)
            world.cloth->m_collisionDisabledObjects.push_back(body);
        else if (kind == 1)
            body->setCollisionFlags(body->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        else if (kind == 2)
            world.cloth->m_cfg.collisions = btSoftBody::fCollision::VF_SS;
        else
            body->getBroadphaseHandle()->m_collisionFilterMask = 0;
        for (int i = 0; i < 60; i++)
        {
            world.Step();
            ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
        }
        ck_assert(qcLowestNode(world.cloth) < -1);
    }
}
END_TEST

START_TEST(contacts_with_a_mesh_stand_in_manifolds)
{
    ClothOverMesh world;
    btRigidBody* body = world.AddBody(world.KeepMesh(qcFloorModel(1, 4)), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.02), 6);
    int seen = 0;
    for (int i = 0; i < 60; i++)
    {
        world.StepApart(1);
        for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
        {
            const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(m);
            if (manifold->getBody1() != body)
                continue;
            ck_assert_ptr_eq(manifold->getBody0(), world.cloth);
            for (int p = 0; p < manifold->getNumContacts(); p++, seen++)
            {
                const btManifoldPoint& point = manifold->getContactPoint(p);
                ck_assert(point.m_normalWorldOnB.y() > btScalar(0.99));
                ck_assert(std::abs(point.getPositionWorldOnB().y()) < btScalar(1e-5));
                ck_assert(point.getDistance() <= 0);
            }
        }
    }
    ck_assert_int_gt(seen, 100);
}
END_TEST

START_TEST(a_mesh_that_sleeps_is_woken_and_moves)
{
    ClothOverMesh world;
    world.SetGravity(btVector3(0, 0, 0));
    btRigidBody* body = world.AddBody(world.KeepMesh(qcSphereModel(0.2, 1)), 1, btVector3(0, 0, 0));
    body->forceActivationState(ISLAND_SLEEPING);
    world.AddCloth(btScalar(0.3), 10);
    world.cloth->setVelocity(btVector3(0, -1, 0));
    world.StepApart(3);
    ck_assert(!body->isActive());
    world.StepApart(57);
    ck_assert(body->isActive());
    ck_assert(body->getLinearVelocity().y() < 0);
}
END_TEST

START_TEST(a_transform_that_is_not_finite_is_refused_and_bullets_positions_remain)
{
    ClothOverMesh world;
    btRigidBody* body = world.AddBody(world.KeepMesh(qcFloorModel(1, 4)), 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.02), 6);
    world.StepApart(10);
    btTransform broken = btTransform::getIdentity();
    broken.setOrigin(btVector3(0, std::numeric_limits<btScalar>::quiet_NaN(), 0));
    world.world.setForceUpdateAllAabbs(false);
    body->setWorldTransform(broken);
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusBadInput);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "not finite"));
    for (int i = 0; i < world.cloth->m_nodes.size(); i++)
        ck_assert(std::isfinite(world.cloth->m_nodes[i].m_x.y()));
    body->setWorldTransform(btTransform::getIdentity());
    world.StepApart(1);
}
END_TEST

START_TEST(meshes_may_change_and_be_removed_between_two_steps)
{
    ClothOverMesh world;
    qcMeshShape* mesh = world.KeepMesh(qcFloorModel(1, 4));
    btRigidBody* body = world.AddBody(mesh, 0, btVector3(0, 0, 0));
    world.AddCloth(btScalar(0.03), 6);
    world.StepApart(30);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
    // Half as wide: the cloth's border hangs over.
    mesh->setLocalScaling(btVector3(btScalar(0.4), 1, btScalar(0.4)));
    world.StepApart(30);
    ck_assert(qcLowestNode(world.cloth) < btScalar(-0.01));
    world.world.removeRigidBody(body);
    world.bodies.clear();
    world.StepApart(60);
    ck_assert_int_eq(world.softSolver.getStatistics().meshes, 0);
    ck_assert(qcLowestNode(world.cloth) < btScalar(-0.5));
}
END_TEST

/// A cloth in the plane of a floor that starts at height 0 of a frame.
static void CheckStaysOn(btCollisionShape* shape, btScalar height, const btTransform& frame)
{
    ClothOverMesh world;
    world.AddCloth(0, 10);
    world.cloth->transform(frame);
    btRigidBody* floor = world.AddBody(shape, 0, btVector3(0, 0, 0));
    floor->setWorldTransform(frame * btTransform(btQuaternion::getIdentity(), btVector3(0, height, 0)));
    floor->setFriction(1);
    world.StepApart(60);
    btScalar lowest = BT_LARGE_FLOAT;
    for (int i = 0; i < world.cloth->m_nodes.size(); i++)
        lowest = std::min(lowest, (frame.inverse() * world.cloth->m_nodes[i].m_x).y());
    ck_assert_double_gt(double(lowest), 0.005);
    ck_assert_double_lt(double(qcSpeedOf(world.cloth)), 0.1);
}

START_TEST(a_cloth_that_is_put_exactly_on_a_floor_stays_on_it)
{
    std::unique_ptr<qcMeshShape> mesh = qcFloorModel(2, 8).MakeShape();
    btBoxShape box(btVector3(2, 1, 2));
    btStaticPlaneShape plane(btVector3(0, 1, 0), 0);
    for (btScalar angle : {btScalar(0), btScalar(0.1)})
    {
        const btTransform frame(btQuaternion(btVector3(1, 0, 0), angle), btVector3(1, 2, btScalar(0.3)));
        CheckStaysOn(mesh.get(), 0, frame);
        CheckStaysOn(&box, -1, frame);
        CheckStaysOn(&plane, 0, frame);
    }
}
END_TEST

START_TEST(a_cloth_falls_in_the_step_in_which_its_floor_stops_holding_it)
{
    std::unique_ptr<qcMeshShape> mesh = qcFloorModel(2, 8).MakeShape();
    for (int way = 0; way < 3; way++)
    {
        ClothOverMesh world;
        world.AddCloth(btScalar(0.1), 10);
        btRigidBody* floor = world.AddBody(mesh.get(), 0, btVector3(0, 0, 0));
        world.StepApart(60);
        ck_assert_double_lt(double(qcSpeedOf(world.cloth)), 0.01);
        if (way == 0)
            floor->setCollisionFlags(floor->getCollisionFlags() | btCollisionObject::CF_NO_CONTACT_RESPONSE);
        else if (way == 1)
            world.cloth->m_cfg.collisions = 0;
        else
            world.cloth->m_collisionDisabledObjects.push_back(floor);
        world.StepApart(1);
        // Free fall gives 0.083 m/s in a step.
        ck_assert_double_gt(double(qcSpeedOf(world.cloth)), 0.08);
    }
}
END_TEST

START_TEST(two_runs_agree_bit_by_bit)
{
    std::vector<btVector3> expected;
    for (int run = 0; run < 2; run++)
    {
        ClothOverMesh world;
        world.AddBody(world.KeepMesh(HillModel(10)), 0, btVector3(0, 0, 0));
        world.AddBody(world.KeepMesh(qcSphereModel(0.1, 1)), btScalar(0.2), btVector3(0, btScalar(0.8), 0));
        world.AddBody(world.KeepMesh(qcSphereModel(0.1, 1)), btScalar(0.2), btVector3(btScalar(0.25), 1, 0));
        world.AddCloth(btScalar(0.5), 10);
        for (int i = 0; i < 100; i++)
            world.Step();
        for (int i = 0; i < world.cloth->m_nodes.size(); i++)
        {
            if (run == 0)
                expected.push_back(world.cloth->m_nodes[i].m_x);
            ck_assert(expected[size_t(i)] == world.cloth->m_nodes[i].m_x);
        }
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST
} // namespace

QC_RUN_TESTS("soft body on mesh", a_cloth_comes_to_rest_on_a_mesh_without_penetrating,
             a_cloth_that_falls_from_ten_metres_is_held_by_a_floor_of_triangles,
             bullets_own_algorithm_lets_a_cloth_fall_through_a_fine_mesh, bullet_makes_no_contact_of_its_own,
             other_triangle_meshes_stay_bullets_by_a_setting, momentum_is_kept_between_a_cloth_and_a_free_mesh,
             a_cloth_that_is_held_at_its_corners_catches_a_mesh, a_cloth_under_a_pile_of_meshes_is_never_penetrated,
             a_kinematic_mesh_lifts_a_cloth, meshes_in_a_compound_hold_a_cloth,
             pairs_that_bullet_filters_out_have_no_contact, contacts_with_a_mesh_stand_in_manifolds,
             a_mesh_that_sleeps_is_woken_and_moves,
             a_transform_that_is_not_finite_is_refused_and_bullets_positions_remain,
             meshes_may_change_and_be_removed_between_two_steps, a_cloth_that_is_put_exactly_on_a_floor_stays_on_it,
             a_cloth_falls_in_the_step_in_which_its_floor_stops_holding_it, two_runs_agree_bit_by_bit)
