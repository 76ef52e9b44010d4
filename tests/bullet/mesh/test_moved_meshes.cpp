// Meshes whose triangles the application moves pass no other mesh, at any speed and from anywhere.
#include "bullet/mesh/mesh_world.h"
#include "bullet/mesh/moved_mesh.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>

// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/motion_oracle.h"

namespace
{
/// A static mesh whose triangles move, and bodies of a model.
struct MovedWorld : qcMeshWorld
{
    qcMovedMesh mesh;
    btRigidBody* moved;
    const qcModel model;
    std::vector<btRigidBody*> loose;
    qcMotionOracle oracle;

    MovedWorld(const qcModel& made, bool isBullets, const qcModel& ofBodies)
        : mesh(made, isBullets), moved(Add(mesh.shape.get(), 0, btVector3(0, 0, 0))), model(ofBodies)
    {
        oracle.Add([this] { return qcWorldMeshOf(mesh.model, moved->getWorldTransform()); });
    }

    void AddLoose(const btVector3& at)
    {
        const btTransform place(btQuaternion(btVector3(0, 1, 0), at.x()), at);
        loose.push_back(Add(Keep(model.MakeShape()), 1, place));
        oracle.Add(model, loose.back());
    }

    /// Three bodies that lie on a flat mesh, and sleep.
    void LayBodies(btScalar height)
    {
        for (int i = -1; i <= 1; i++)
            AddLoose(btVector3(btScalar(1.3) * btScalar(i), height, btScalar(0.2) * btScalar(i)));
        Step(240);
        ck_assert(!loose.front()->isActive());
        oracle.Count();
    }

    void Move(const qcVertexMotion& motion, int step)
    {
        mesh.Move(motion, step, moved, &world, &contact);
    }

    /// A step in which nothing may pass.
    void StepApart(int number)
    {
        Step();
        ck_assert_msg(oracle.Count() == 0, "step %d: pairs that penetrate", number);
        ck_assert_int_eq(contact.getStatistics().unproven, 0);
        ck_assert_int_eq(contact.getStatistics().status, qc_statusOk);
    }

    double HeightOf(size_t index) const
    {
        return double(loose[index]->getWorldTransform().getOrigin().y());
    }
};

qcModel Plate()
{
    return qcBoxModel(btVector3(btScalar(0.3), btScalar(0.1), btScalar(0.3)), 2);
}

START_TEST(meshes_go_with_terrain_that_rises_at_any_speed)
{
    for (bool isBullets : {false, true})
        for (btScalar rise : {btScalar(0.002), btScalar(0.03), btScalar(0.3)})
        {
            MovedWorld scene(qcFloorModel(3, 20), isBullets, Plate());
            scene.LayBodies(btScalar(0.125));
            const double before = scene.HeightOf(0);
            for (int step = 0; step < 8; step++)
            {
                scene.Move(qcLift(rise), step);
                scene.StepApart(step);
            }
            for (int step = 0; step < 120; step++)
                scene.StepApart(step);
            for (size_t i = 0; i < scene.loose.size(); i++)
                ck_assert_double_eq_tol(scene.HeightOf(i) - before, 8 * double(rise), 0.005);
        }
}
END_TEST

/// A step reads such a compound twice: for its mesh, then for its convex shapes.
static void LiftCompound(bool hasBox)
{
    btCompoundShape compound;
    btBoxShape box(btVector3(1, 1, 1));
    MovedWorld scene(qcFloorModel(3, 20), true, Plate());
    compound.addChildShape(btTransform::getIdentity(), scene.mesh.shape.get());
    if (hasBox)
        compound.addChildShape(btTransform(btQuaternion::getIdentity(), btVector3(0, -4, 0)), &box);
    scene.moved->setCollisionShape(&compound);
    scene.moved->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    scene.AddLoose(btVector3(0, btScalar(0.125), 0));
    scene.Step(120);
    scene.oracle.Count();
    const double before = scene.HeightOf(0);
    const btScalar rise = btScalar(0.15);
    for (int step = 0; step < 8; step++)
    {
        scene.Move(qcLift(rise), step);
        compound.updateChildTransform(0, btTransform::getIdentity());
        scene.world.updateSingleAabb(scene.moved);
        scene.StepApart(step);
    }
    for (int step = 0; step < 120; step++)
        scene.StepApart(step);
    ck_assert_double_eq_tol(scene.HeightOf(0) - before, 8 * double(rise), 0.005);
}

START_TEST(terrain_in_a_kinematic_compound_takes_meshes_along)
{
    LiftCompound(false);
    LiftCompound(true);
}
END_TEST

START_TEST(waves_spikes_and_noise_of_terrain_pass_no_mesh)
{
    const qcModel torus = qcTorusModel(0.35, 0.12, 16, 8);
    for (bool isBullets : {false, true})
        for (const auto& motion : {qcWave(), qcSpike(btScalar(0.8)), qcNoise(btScalar(0.1))})
            for (const qcModel& model : {Plate(), torus})
            {
                MovedWorld scene(qcFloorModel(3, 24), isBullets, model);
                scene.LayBodies(btScalar(0.16));
                for (int step = 0; step < 30; step++)
                {
                    scene.Move(motion, step);
                    scene.StepApart(step);
                }
            }
}
END_TEST

START_TEST(an_arm_that_swings_in_from_afar_passes_no_mesh)
{
    for (bool isBullets : {false, true})
    {
        MovedWorld scene(qcBarModel(), isBullets, Plate());
        scene.world.setGravity(btVector3(0, 0, 0));
        const qcVertexMotion bend = qcBend();
        // Its triangles have moved once when it is far away.
        scene.Step();
        scene.Move(bend, 0);
        scene.Step();
        scene.AddLoose(btVector3(btScalar(1.1), btScalar(0.05), 0));
        scene.oracle.Count();
        for (int step = 1; step < 10; step++)
        {
            scene.Move(bend, step);
            scene.StepApart(step);
        }
        ck_assert_double_gt(double(scene.loose[0]->getWorldTransform().getOrigin().z()), 0.3);
    }
}
END_TEST

START_TEST(a_mesh_that_is_put_elsewhere_leaves_others_where_they_are)
{
    for (bool isBullets : {false, true})
    {
        MovedWorld scene(qcFloorModel(3, 20), isBullets, Plate());
        scene.LayBodies(btScalar(0.125));
        const double before = scene.HeightOf(0);
        // Half of its diagonal is 4.2 m.
        scene.Move(qcLift(5), 0);
        scene.Step();
        ck_assert_double_le(scene.HeightOf(0), before);
    }
}
END_TEST

START_TEST(a_finer_mesh_in_its_place_moves_nothing)
{
    MovedWorld scene(qcFloorModel(3, 20), false, Plate());
    scene.LayBodies(btScalar(0.125));
    const double before = scene.HeightOf(0);
    scene.mesh.model = qcFloorModel(3, 24);
    scene.mesh.Reshape(scene.moved, &scene.world, &scene.contact);
    scene.Step(10);
    ck_assert_double_eq_tol(scene.HeightOf(0), before, 1e-3);
}
END_TEST

START_TEST(terrain_that_has_sunk_holds_what_is_thrown_at_it)
{
    for (bool isBullets : {false, true})
    {
        MovedWorld scene(qcFloorModel(3, 20), isBullets, Plate());
        scene.LayBodies(btScalar(0.125));
        for (int step = 0; step < 4; step++)
        {
            scene.Move(qcLift(btScalar(-0.2)), step);
            scene.StepApart(step);
        }
        for (btRigidBody* body : scene.loose)
            body->setLinearVelocity(btVector3(0, -60, 0));
        for (int step = 0; step < 60; step++)
            scene.StepApart(step);
        ck_assert_double_gt(scene.HeightOf(0), -0.8);
    }
}
END_TEST

START_TEST(a_mesh_that_has_no_room_or_is_locked_is_counted)
{
    for (bool isLocked : {false, true})
    {
        MovedWorld scene(qcFloorModel(3, 20), false, Plate());
        scene.LayBodies(btScalar(0.125));
        qcModel ceiling = qcFloorModel(3, 4);
        ceiling.Move(btTransform(btQuaternion(btVector3(1, 0, 0), SIMD_PI), btVector3(0, btScalar(0.4), 0)));
        if (!isLocked)
            scene.Add(scene.Keep(ceiling.MakeShape()), 0, btVector3(0, 0, 0));
        for (btRigidBody* body : scene.loose)
        {
            body->setLinearFactor(btVector3(1, 1, 1) * (isLocked ? 0 : 1));
            body->setAngularFactor(isLocked ? 0 : 1);
        }
        int unproven = 0;
        for (int step = 0; step < 4; step++)
        {
            scene.Move(qcLift(btScalar(0.1)), step);
            scene.Step();
            unproven += scene.contact.getStatistics().unproven;
        }
        ck_assert_int_gt(unproven, 0);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("moved_meshes", meshes_go_with_terrain_that_rises_at_any_speed,
             terrain_in_a_kinematic_compound_takes_meshes_along, waves_spikes_and_noise_of_terrain_pass_no_mesh,
             an_arm_that_swings_in_from_afar_passes_no_mesh, a_mesh_that_is_put_elsewhere_leaves_others_where_they_are,
             a_finer_mesh_in_its_place_moves_nothing, terrain_that_has_sunk_holds_what_is_thrown_at_it,
             a_mesh_that_has_no_room_or_is_locked_is_counted)
