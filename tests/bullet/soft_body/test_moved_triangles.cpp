// Meshes whose triangles the application moves take cloth along and pass none of it, at any speed and from anywhere.
#include "bullet/soft_body/soft_world.h"

#include "bullet/mesh/moved_mesh.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"
#include "support/long_form.h"

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
        RemoveAll();
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

/// Ground that waves in three random directions, goes to and fro, and rises or sinks at first.
class RandomGround
{
  public:
    explicit RandomGround(std::mt19937* random)
    {
        auto between = [random](double low, double high)
        { return btScalar(std::uniform_real_distribution<double>(low, high)(*random)); };
        for (Wave& wave : m_waves)
            wave = {between(0, 0.12), btVector3(between(-4, 4), 0, between(-4, 4)), between(0, 6),
                    between(0, 1) < btScalar(0.3) ? between(0, 2.5) : between(0, 0.4)};
        m_shear = between(0, 0.15);
        m_lift = between(0, 1) < btScalar(0.3) ? between(-0.1, 0.25) : btScalar(0);
    }

    btVector3 operator()(const btVector3& start, int step) const
    {
        const btScalar part = std::min(btScalar(step) / 10, btScalar(1));
        btVector3 moved = start + btVector3(0, m_lift * btScalar(std::min(step, 15)), 0);
        for (const Wave& wave : m_waves)
            moved[1] += part * wave.height * btSin(wave.along.dot(start) + wave.phase + wave.speed * btScalar(step));
        moved[0] += part * m_shear * btSin(3 * start.z() + btScalar(step) / 2);
        return moved;
    }

  private:
    struct Wave
    {
        btScalar height;
        btVector3 along; ///< radians a metre
        btScalar phase, speed;
    };

    Wave m_waves[3];
    btScalar m_shear, m_lift;
};

START_TEST(ground_in_random_motion_makes_nothing_penetrate_that_is_not_counted)
{
    const qcModel models[] = {qcBoxModel(btVector3(btScalar(0.2), btScalar(0.06), btScalar(0.2)), 2),
                              qcTorusModel(0.2, 0.07, 12, 6), qcSphereModel(0.15, 2)};
    int steps = 0, unprovenSteps = 0;
    for (unsigned seed = 0; seed < (qcIsLongForm() ? 300u : 12u); seed++)
    {
        std::mt19937 random(seed);
        MovedTriangles scene(qcFloorModel(1.5, int(8 + random() % 20)), random() % 2 == 0);
        scene.meshContact.addTo(&scene.world);
        scene.LayCloth();
        qcMotionOracle ends;
        ends.Add([&scene] { return qcWorldMeshOf(scene.cloth); });
        ends.Add([&scene] { return qcWorldMeshOf(scene.mesh.model, scene.body->getWorldTransform()); });
        // Each third scene has no bodies.
        for (int i = 0; i < 5 && seed % 3 != 0; i++)
        {
            const qcModel& model = models[random() % 3];
            const btVector3 place(btScalar(random() % 21) / 10 - 1, btScalar(0.4) + btScalar(0.45) * btScalar(i),
                                  btScalar(random() % 21) / 10 - 1);
            const btRigidBody* body = scene.AddMesh(model, 1, place);
            scene.oracle->Add(model, body);
            ends.Add(model, body);
        }
        const RandomGround ground(&random);
        const int pause = int(random() % 3) + 1;
        BothContacts contacts{&scene.softSolver, &scene.meshContact};
        bool isTangled = false;
        for (int step = 0; step < 120; step++)
        {
            if (step > 40 && step % pause == 0)
                scene.mesh.Move(ground, step - 40, scene.body, &scene.world, &contacts);
            scene.Step();
            const qcSoftBodyStatistics& soft = scene.softSolver.getStatistics();
            const int counted = soft.unproven + soft.exempt + scene.meshContact.getStatistics().unproven;
            ck_assert_msg(scene.oracle->Count() == 0 || counted > 0 || isTangled, "seed %u, step %d", seed, step);
            isTangled = ends.CountNow() > 0;
            steps++;
            unprovenSteps += soft.unproven + scene.meshContact.getStatistics().unproven > 0;
        }
    }
    printf("ground in random motion: %d of %d steps have unproven pairs\n", unprovenSteps, steps);
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
             ground_in_random_motion_makes_nothing_penetrate_that_is_not_counted,
             an_arm_that_swings_in_from_afar_passes_no_cloth, cloth_goes_with_a_mesh_that_moves_and_deforms,
             a_mesh_that_is_put_elsewhere_leaves_cloth_where_it_is, a_finer_mesh_in_its_place_moves_nothing)
