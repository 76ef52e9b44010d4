// Meshes whose triangles the application moves take cloth along and pass none of it, at any speed and from anywhere.
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btBvhTriangleMeshShape.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <functional>
#include <random>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"
#include "bullet/soft_body/soft_models.h"

namespace
{
/// Where a step of the motion has a vertex.
using Motion = std::function<btVector3(const btVector3& start, int step)>;

/// A cloth, and a mesh whose triangles move: a qcMeshShape, which is replaced, or a mesh of Bullet, which is refitted.
struct MovedTriangles : qcSoftWorld
{
    const qcModel first;
    qcModel model; ///< where the triangles are
    bool isBullets;
    std::unique_ptr<btTriangleIndexVertexArray> triangles;
    btRigidBody* body;
    btSoftBody* cloth = nullptr;
    std::unique_ptr<qcMotionOracle> oracle;

    MovedTriangles(const qcModel& made, bool isOfBullet) : first(made), model(made), isBullets(isOfBullet)
    {
        if (isBullets)
        {
            triangles = model.MakeInterface();
            shapes.emplace_back(new btBvhTriangleMeshShape(triangles.get(), true));
            shapes.back()->setMargin(btScalar(0.01));
        }
        body = isBullets ? AddBody(shapes.back().get(), 0, btVector3(0, 0, 0)) : AddMesh(model, 0, btVector3(0, 0, 0));
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
        oracle->Add([this] { return qcWorldMeshOf(model, body->getWorldTransform()); });
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

    /// Gives the body the triangles of `model`.
    void Reshape()
    {
        if (isBullets)
        {
            auto* shape = static_cast<btBvhTriangleMeshShape*>(body->getCollisionShape());
            shape->refitTree(btVector3(-100, -100, -100), btVector3(100, 100, 100));
            shape->recalcLocalAabb();
            softSolver.updateShape(shape);
        }
        else
        {
            // The previous shape is gone when the next step begins.
            std::unique_ptr<btCollisionShape> previous = std::move(shapes.back());
            shapes.pop_back();
            body->setCollisionShape(KeepMesh(model));
        }
        world.updateSingleAabb(body);
    }

    void Move(const Motion& motion, int step)
    {
        for (size_t i = 0; i < model.positions.size(); i += 3)
        {
            const btVector3 moved =
                motion(btVector3(first.positions[i], first.positions[i + 1], first.positions[i + 2]), step);
            for (int axis = 0; axis < 3; axis++)
                model.positions[i + size_t(axis)] = moved[axis];
        }
        Reshape();
    }

    double Height() const
    {
        btVector3 sum(0, 0, 0);
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            sum += cloth->m_nodes[i].m_x;
        return double(sum.y()) / cloth->m_nodes.size();
    }
};

/// Lifts the terrain by a part of a metre a step.
Motion Lift(btScalar rise)
{
    return [rise](const btVector3& start, int step) { return start + btVector3(0, rise * btScalar(step + 1), 0); };
}

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
                scene.Move(Lift(rise), step);
                scene.StepApart(step);
            }
            ck_assert_double_gt(scene.Height() - before, 8 * double(rise) - 0.01);
        }
}
END_TEST

START_TEST(waves_spikes_and_noise_of_terrain_pass_no_cloth)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<btScalar> height(-btScalar(0.1), btScalar(0.1));
    const Motion wave = [](const btVector3& start, int step)
    {
        const btScalar amplitude = btScalar(0.02) * btScalar(std::min(step, 10));
        return start + btVector3(0, amplitude * btSin(3 * start.x() + 2 * btScalar(step)), 0);
    };
    const Motion spike = [](const btVector3& start, int)
    { return start + btVector3(0, std::max(btScalar(0), btScalar(0.8) - start.length()), 0); };
    const Motion noise = [&](const btVector3& start, int) { return start + btVector3(0, height(random), 0); };
    for (bool isBullets : {false, true})
        for (const Motion& motion : {wave, spike, noise})
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

START_TEST(an_arm_that_swings_in_from_afar_passes_no_cloth)
{
    // A bar along x that bends through a hanging cloth: its end moves by half a metre in each step, from half a metre
    // before the cloth.
    const qcModel bar = qcBoxModel(btVector3(btScalar(1.5), btScalar(0.1), btScalar(0.1)), 6);
    for (bool isBullets : {false, true})
    {
        MovedTriangles scene(bar, isBullets);
        const Motion bend = [](const btVector3& start, int step)
        {
            const btScalar place = btScalar(-1.25) + btScalar(0.5) * btScalar(std::min(step, 4));
            return start +
                   btVector3(0, 0, btScalar(-0.75) + (place + btScalar(0.75)) * (start.x() + btScalar(1.5)) / 3);
        };
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
        scene.Move(Lift(btScalar(-0.1)), step);
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
        scene.Move(Lift(btScalar(2.5)), 0);
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
    scene.model = qcFloorModel(1.5, 20);
    scene.Reshape();
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
             waves_spikes_and_noise_of_terrain_pass_no_cloth, an_arm_that_swings_in_from_afar_passes_no_cloth,
             cloth_goes_with_a_mesh_that_moves_and_deforms, a_mesh_that_is_put_elsewhere_leaves_cloth_where_it_is,
             a_finer_mesh_in_its_place_moves_nothing)
