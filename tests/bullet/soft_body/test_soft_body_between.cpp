// A cloth between meshes that are thrown at each other: soft bodies and rigid meshes move each other's bodies, and yet
// no two of them pass.
#include "quickcullide/bullet_deformable.h"

#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <LinearMath/btDefaultMotionState.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
constexpr btScalar s_step = btScalar(1.0 / 60);
constexpr int s_starts = 10;

btScalar Jitter(int start, int which)
{
    return btScalar(0.0137) * btScalar((start * 7 + which * 5) % 11) - btScalar(0.07);
}

/// Either world of soft bodies, without gravity, with contact of meshes.
struct BetweenWorld
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btDeformableBodySolver deformableSolver;
    btDeformableMultiBodyConstraintSolver deformableConstraints;
    btSequentialImpulseConstraintSolver constraints;
    qcSoftBodySolver softSolver;
    qcMeshContact contact;
    std::unique_ptr<btDiscreteDynamicsWorld> world;
    btSoftBodyWorldInfo* info;
    const qcSoftBodyContact* soft;
    std::vector<std::unique_ptr<qcMeshShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    btSoftBody* cloth = nullptr;
    bool isDeformable;
    qcMotionOracle oracle;

    explicit BetweenWorld(bool deformable) : isDeformable(deformable)
    {
        if (deformable)
        {
            deformableConstraints.setDeformableSolver(&deformableSolver);
            auto* made = new qcDeformableWorld(&dispatcher, &broadphase, &deformableConstraints, &configuration,
                                               &deformableSolver);
            world.reset(made);
            info = &made->getWorldInfo();
            soft = made;
            made->setThreadCount(1);
        }
        else
        {
            auto* made =
                new btSoftRigidDynamicsWorld(&dispatcher, &broadphase, &constraints, &configuration, &softSolver);
            world.reset(made);
            info = &made->getWorldInfo();
            soft = &softSolver;
            softSolver.setThreadCount(1);
        }
        contact.setThreadCount(1);
        contact.addTo(world.get());
        SetGravity(btVector3(0, 0, 0));
    }

    ~BetweenWorld()
    {
        for (const auto& body : bodies)
            world->removeRigidBody(body.get());
        RemoveCloth();
        delete cloth;
    }

    void SetGravity(const btVector3& gravity)
    {
        world->setGravity(gravity);
        info->m_gravity = gravity;
    }

    /// A static sheet of 4 m at a height.
    void AddFloor(btScalar y)
    {
        btTransform place = btTransform::getIdentity();
        place.setOrigin(btVector3(0, y, 0));
        AddMesh(qcFloorModel(2, 4), place, 0, 0);
    }

    void RemoveCloth()
    {
        if (isDeformable)
            static_cast<qcDeformableWorld*>(world.get())->removeSoftBody(cloth);
        else
            static_cast<btSoftRigidDynamicsWorld*>(world.get())->removeSoftBody(cloth);
    }

    /// A square at height 0.
    void AddCloth(btScalar half, int nodes)
    {
        cloth =
            btSoftBodyHelpers::CreatePatch(*info, btVector3(-half, 0, -half), btVector3(half, 0, -half),
                                           btVector3(-half, 0, half), btVector3(half, 0, half), nodes, nodes, 0, true);
        cloth->setTotalMass(btScalar(0.3));
        cloth->m_cfg.piterations = 4;
        if (isDeformable)
        {
            cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD;
            static_cast<qcDeformableWorld*>(world.get())->addSoftBody(cloth);
        }
        else
            static_cast<btSoftRigidDynamicsWorld*>(world.get())->addSoftBody(cloth);
        oracle.Add([this] { return qcWorldMeshOf(cloth); });
    }

    btRigidBody* AddMesh(const qcModel& model, const btTransform& at, btScalar mass, btScalar speed)
    {
        shapes.push_back(model.MakeShape());
        btVector3 inertia(0, 0, 0);
        if (mass > 0)
            shapes.back()->calculateLocalInertia(mass, inertia);
        btRigidBody::btRigidBodyConstructionInfo bodyInfo(mass, nullptr, shapes.back().get(), inertia);
        bodyInfo.m_startWorldTransform = at;
        bodies.emplace_back(new btRigidBody(bodyInfo));
        bodies.back()->setLinearVelocity(btVector3(0, speed, 0));
        world->addRigidBody(bodies.back().get());
        const qcMeshShape* shape = shapes.back().get();
        const btRigidBody* body = bodies.back().get();
        oracle.Add([shape, body] { return qcWorldMeshOf(*shape, body->getWorldTransform()); });
        return bodies.back().get();
    }

    void Step()
    {
        world->stepSimulation(s_step, 0);
        ck_assert_int_eq(soft->getStatistics().status, qc_statusOk);
        ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    }

    /// A step in which nothing passes.
    void StepApart()
    {
        Step();
        ck_assert_int_eq(soft->getStatistics().unproven, 0);
        ck_assert_int_eq(contact.getStatistics().unproven, 0);
        ck_assert_uint_eq(oracle.Count(), 0);
    }
};

btTransform Place(int start, btScalar y)
{
    btVector3 axis(1, btScalar(0.2), btScalar(0.4));
    return btTransform(btQuaternion(axis.normalized(), 3 * Jitter(start, y > 0)),
                       btVector3(Jitter(start, 2 + (y > 0)), y, Jitter(start, 4 + (y > 0))));
}

/// Throws two meshes at each other, with a cloth between them.
void Throw(bool deformable, const qcModel& model, int start)
{
    BetweenWorld world(deformable);
    world.AddCloth(btScalar(0.6), 13);
    world.AddMesh(model, Place(start, btScalar(-0.9) + Jitter(start, 1)), 1, 30);
    world.AddMesh(model, Place(start, btScalar(0.9) + Jitter(start, 3)), 1, -30);
    for (int step = 0; step < 20; step++)
        world.StepApart();
}
} // namespace

START_TEST(nothing_passes_where_two_thin_sheets_hit_a_cloth_from_both_sides)
{
    for (int start = 0; start < s_starts; start++)
        Throw(_i == 1, qcFloorModel(0.3, 1), start);
}
END_TEST

START_TEST(nothing_passes_where_two_cubes_hit_a_cloth_from_both_sides)
{
    for (int start = 0; start < s_starts; start++)
        Throw(_i == 1, qcBoxModel(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 2), start);
}
END_TEST

/// Throws a heavy cloth at a sheet that rests close to another one, of this mass.
static void ThrowCloth(bool deformable, btScalar mass, int start)
{
    BetweenWorld world(deformable);
    world.AddCloth(btScalar(0.6), 13);
    world.cloth->setTotalMass(20);
    world.cloth->setVelocity(btVector3(0, -30, 0));
    btRigidBody* near = world.AddMesh(qcFloorModel(0.3, 1), Place(start, btScalar(-0.5)), 1, 0);
    btTransform below = near->getWorldTransform();
    below.getOrigin() -= btVector3(0, btScalar(0.05), 0);
    world.AddMesh(qcFloorModel(0.3, 1), below, mass, 0);
    for (int step = 0; step < 12; step++)
        world.StepApart();
}

START_TEST(a_heavy_cloth_does_not_push_a_sheet_through_a_sheet)
{
    for (int start = 0; start < s_starts; start++)
        ThrowCloth(_i == 1, 1, start);
}
END_TEST

START_TEST(a_heavy_cloth_does_not_pass_a_sheet_that_another_one_stops)
{
    for (int start = 0; start < s_starts; start++)
        ThrowCloth(_i == 1, 0, start);
}
END_TEST

START_TEST(a_cloth_on_a_floor_is_not_pierced_by_stacked_sheets_that_are_hit)
{
    for (int start = 0; start < s_starts; start++)
    {
        BetweenWorld world(_i == 1);
        world.AddCloth(btScalar(0.6), 13);
        world.AddFloor(btScalar(-0.02));
        for (int i = 0; i < 3; i++)
        {
            btScalar y = btScalar(0.04 + 0.3 * i) + Jitter(start, i) / 10 + btScalar(0.007);
            btTransform at(btQuaternion(btVector3(1, 0, btScalar(0.3)).normalized(), Jitter(start, 3 + i) / 4),
                           btVector3(Jitter(start, 6), y, Jitter(start, 7)));
            world.AddMesh(qcFloorModel(0.2, 1), at, 1, i > 0 ? btScalar(-60) : btScalar(-5));
        }
        for (int step = 0; step < 12; step++)
            world.StepApart();
    }
}
END_TEST

START_TEST(a_cloth_that_a_mesh_carries_along_does_not_pass_the_floor_that_it_meets_there)
{
    for (int start = 0; start < s_starts; start++)
    {
        BetweenWorld world(_i == 1);
        world.AddCloth(btScalar(0.6), 13);
        // Further from the cloth than it moves by itself.
        world.AddFloor(btScalar(-0.5));
        world.AddMesh(qcSphereModel(0.15, 2), Place(start, btScalar(0.2)), 50, -60);
        for (int step = 0; step < 8; step++)
            world.StepApart();
    }
}
END_TEST

START_TEST(pieces_that_lie_close_do_not_pass_the_cloth_on_which_they_fall)
{
    BetweenWorld world(_i == 1);
    world.SetGravity(btVector3(0, btScalar(-9.81), 0));
    world.AddCloth(1, 25);
    world.cloth->setTotalMass(1);
    world.cloth->getCollisionShape()->setMargin(btScalar(0.02));
    for (int node : {0, 24, 600, 624})
        world.cloth->setMass(node, 0);
    for (int i = 0; i < 27; i++)
    {
        const btVector3 place(btScalar(0.12 * (i % 3 - 1)), btScalar(0.4 + 0.12 * (i / 9)),
                              btScalar(0.12 * (i / 3 % 3 - 1)));
        btRigidBody* piece = world.AddMesh(qcBoxModel(btVector3(1, 1, 1) * btScalar(0.05994), 1),
                                           btTransform(btQuaternion::getIdentity(), place), btScalar(0.1), 0);
        piece->setLinearVelocity(btVector3(Jitter(i, 0), Jitter(i, 1), Jitter(i, 2)) * 6);
    }
    for (int step = 0; step < 120; step++)
        world.StepApart();
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("between meshes");
    tcase_add_loop_test(tests, nothing_passes_where_two_thin_sheets_hit_a_cloth_from_both_sides, 0, 2);
    tcase_add_loop_test(tests, nothing_passes_where_two_cubes_hit_a_cloth_from_both_sides, 0, 2);
    tcase_add_loop_test(tests, a_heavy_cloth_does_not_push_a_sheet_through_a_sheet, 0, 2);
    tcase_add_loop_test(tests, a_heavy_cloth_does_not_pass_a_sheet_that_another_one_stops, 0, 2);
    tcase_add_loop_test(tests, a_cloth_on_a_floor_is_not_pierced_by_stacked_sheets_that_are_hit, 0, 2);
    tcase_add_loop_test(tests, a_cloth_that_a_mesh_carries_along_does_not_pass_the_floor_that_it_meets_there, 0, 2);
    tcase_add_loop_test(tests, pieces_that_lie_close_do_not_pass_the_cloth_on_which_they_fall, 0, 2);
    return qcRunCase("between meshes", tests);
}
