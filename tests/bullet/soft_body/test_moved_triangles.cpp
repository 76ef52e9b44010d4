// Meshes whose triangles the application moves take cloth along and pass none of it, at any speed and from anywhere.
#include "bullet/soft_body/soft_world.h"

#include "bullet/mesh/moved_mesh.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
/// A cloth, and a mesh whose triangles move.
struct MovedTriangles : qcSoftWorld
{
    qcMovedMesh mesh;
    btRigidBody* body;
    btSoftBody* cloth = nullptr;
    std::unique_ptr<qcMotionOracle> oracle;

    MovedTriangles(const qcModel& made, bool isBullets)
        : mesh(made, isBullets), body(AddBody(mesh.shape.get(), 0, btVector3(0, 0, 0)))
    {
    }

    ~MovedTriangles()
    {
        while (!cloths.empty())
            RemoveCloth();
        for (const auto& rigid : bodies)
            world.removeRigidBody(rigid.get());
        bodies.clear();
    }

    /// A square of 2 metres, of 1 kg, that is pinned at the corners of `pinned`.
    void AddCloth(const btVector3& corner, const btVector3& along, const btVector3& across, int pinned)
    {
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), corner, corner + along, corner + across,
                                               corner + along * btScalar(1.01) + across, 25, 25, pinned, true);
        cloth->setTotalMass(1);
        cloth->m_cfg.piterations = 8;
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
        oracle.reset(new qcMotionOracle);
        oracle->Add([this] { return qcWorldMeshOf(cloth); });
        oracle->Add([this] { return qcWorldMeshOf(mesh.model, body->getWorldTransform()); });
    }

    /// A cloth that lies on a flat mesh.
    void LayCloth()
    {
        AddCloth(btVector3(-1, btScalar(0.05), -1), btVector3(2, 0, 0), btVector3(0, btScalar(0.02), 2), 0);
        for (int i = 0; i < 30; i++)
            Step();
    }

    void Step()
    {
        world.stepSimulation(btScalar(1.0 / 60), 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    }

    /// A step in which nothing may pass the cloth.
    void StepApart(int number)
    {
        Step();
        ck_assert_msg(oracle->Count() == 0, "step %d: pairs that penetrate", number);
        ck_assert_int_eq(softSolver.getStatistics().unproven, 0);
        ck_assert_int_eq(softSolver.getStatistics().exempt, 0);
    }

    void Move(const qcVertexMotion& motion, int step)
    {
        mesh.Move(motion, step, body, &world, &softSolver);
    }

    double Height() const
    {
        btVector3 sum(0, 0, 0);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_x;
        return double(sum.y()) / cloth->m_nodes.size();
    }
};

START_TEST(cloth_goes_with_terrain_that_rises_at_any_speed)
{
    for (bool isBullets : {false, true})
        for (btScalar rise : {btScalar(0.002), btScalar(0.03), btScalar(0.3)})
        {
            MovedTriangles scene(qcFloorModel(1.5, 16), isBullets);
            scene.LayCloth();
            const double before = scene.Height();
            for (int step = 0; step < 8; step++)
            {
                scene.Move(qcLift(rise), step);
                scene.StepApart(step);
            }
            ck_assert_double_gt(scene.Height() - before, 8 * double(rise) - 0.01);
        }
}
END_TEST

START_TEST(waves_spikes_and_noise_of_terrain_pass_no_cloth)
{
    for (bool isBullets : {false, true})
        for (const qcVertexMotion& motion : {qcWave(), qcSpike(btScalar(0.8)), qcNoise(btScalar(0.1))})
        {
            MovedTriangles scene(qcFloorModel(1.5, 24), isBullets);
            scene.LayCloth();
            for (int step = 0; step < 30; step++)
            {
                scene.Move(motion, step);
                scene.StepApart(step);
            }
        }
}
END_TEST

/// Reports moved triangles to both kinds of contact.
struct BothContacts
{
    qcSoftBodySolver* soft;
    qcMeshContact* meshes;

    void updateShape(const btCollisionShape* shape)
    {
        soft->updateShape(shape);
        meshes->updateShape(shape);
    }
};

START_TEST(cloth_between_terrain_that_rises_and_a_mesh_passes_neither)
{
    for (bool isBullets : {false, true})
        for (btScalar rise : {btScalar(0.05), btScalar(0.2), btScalar(0.3)})
        {
            MovedTriangles scene(qcFloorModel(1.5, 20), isBullets);
            scene.meshContact.addTo(&scene.world);
            scene.LayCloth();
            const qcModel plate = qcBoxModel(btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.3)), 2);
            const btRigidBody* body = scene.AddMesh(plate, 1, btVector3(0, btScalar(0.2), 0));
            for (int step = 0; step < 60; step++)
                scene.Step();
            scene.oracle->Add(plate, body);
            scene.oracle->Count();
            BothContacts contacts{&scene.softSolver, &scene.meshContact};
            for (int step = 0; step < 12; step++)
            {
                scene.mesh.Move(qcLift(rise), step, scene.body, &scene.world, &contacts);
                scene.StepApart(step);
                ck_assert_int_eq(scene.meshContact.getStatistics().unproven, 0);
            }
        }
}
END_TEST

START_TEST(an_arm_that_swings_in_from_afar_passes_no_cloth)
{
    for (bool isBullets : {false, true})
    {
        MovedTriangles scene(qcBarModel(), isBullets);
        const qcVertexMotion bend = qcBend();
        scene.Move(bend, 0);
        scene.AddCloth(btVector3(-1, -1, 0), btVector3(2, 0, 0), btVector3(0, 2, 0), 4 + 8);
        for (int step = 0; step < 40; step++)
        {
            scene.Move(bend, step);
            scene.StepApart(step);
        }
    }
}
END_TEST

START_TEST(cloth_goes_with_a_mesh_that_moves_and_deforms)
{
    MovedTriangles scene(qcFloorModel(1.5, 16), false);
    scene.LayCloth();
    const double before = scene.Height();
    for (int step = 0; step < 8; step++)
    {
        scene.body->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.2) * btScalar(step + 1), 0)));
        scene.Move(qcLift(btScalar(-0.1)), step);
        scene.StepApart(step);
    }
    ck_assert_double_gt(scene.Height() - before, 0.75);
}
END_TEST

START_TEST(a_mesh_that_is_put_elsewhere_leaves_cloth_where_it_is)
{
    for (bool isBullets : {false, true})
    {
        MovedTriangles scene(qcFloorModel(1.5, 16), isBullets);
        scene.LayCloth();
        const double before = scene.Height();
        // Half of its diagonal is 2.1 m.
        scene.Move(qcLift(btScalar(2.5)), 0);
        scene.Step();
        ck_assert_double_le(scene.Height(), before);
    }
}
END_TEST

START_TEST(a_finer_mesh_in_its_place_moves_nothing)
{
    MovedTriangles scene(qcFloorModel(1.5, 16), false);
    scene.LayCloth();
    const double before = scene.Height();
    scene.mesh.model = qcFloorModel(1.5, 20);
    scene.mesh.Reshape(scene.body, &scene.world, &scene.softSolver);
    for (int step = 0; step < 10; step++)
    {
        scene.Step();
        ck_assert_int_eq(scene.softSolver.getStatistics().remaining, 0);
        ck_assert_double_eq_tol(scene.Height(), before, 0.001);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("moved_triangles", cloth_goes_with_terrain_that_rises_at_any_speed,
             waves_spikes_and_noise_of_terrain_pass_no_cloth,
             cloth_between_terrain_that_rises_and_a_mesh_passes_neither,
             an_arm_that_swings_in_from_afar_passes_no_cloth, cloth_goes_with_a_mesh_that_moves_and_deforms,
             a_mesh_that_is_put_elsewhere_leaves_cloth_where_it_is, a_finer_mesh_in_its_place_moves_nothing)
