// Nodes that belong to no face (of ropes, of tetrahedra without faces, cut off) collide with meshes as points.
#include "bullet/mesh/mesh_models.h"
#include "bullet/soft_body/soft_world.h"
#include "bullet/soft_body/tetra_model.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <cstdlib>
#include <memory>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"

namespace
{
/// A floor of triangles at height 0, with a margin of 1 cm.
struct NodesWorld : qcSoftWorld
{
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(4, 8).MakeShape();
    btRigidBody floor{0, nullptr, shape.get()};
    btSoftBody* body = nullptr;

    NodesWorld()
    {
        world.addRigidBody(&floor);
    }

    ~NodesWorld()
    {
        world.removeSoftBody(body);
        delete body;
        world.removeRigidBody(&floor);
    }

    void Add(btSoftBody* added)
    {
        body = added;
        body->setTotalMass(1);
        world.addSoftBody(body);
    }

    /// Steps the world and checks that no node sinks into the floor.
    void Step(int steps, btScalar deepest = btScalar(0.009))
    {
        for (int i = 0; i < steps; i++)
        {
            world.stepSimulation(btScalar(1.0 / 60), 0);
            ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
            ck_assert_double_gt(double(qcLowestNode(body)), double(deepest));
        }
    }
};

START_TEST(a_rope_lies_on_a_mesh)
{
    NodesWorld world;
    world.Add(btSoftBodyHelpers::CreateRope(world.world.getWorldInfo(), btVector3(-1, btScalar(0.5), 0),
                                            btVector3(1, btScalar(0.6), 0), 20, 0));
    world.Step(240);
    ck_assert_double_lt(double(qcLowestNode(world.body)), 0.02);
    ck_assert_double_lt(double(qcSpeedOf(world.body)), 0.01);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
    ck_assert_int_gt(world.dispatcher.getNumManifolds(), 0);
}
END_TEST

START_TEST(tetrahedra_lie_on_a_mesh_with_faces_and_without)
{
    for (bool faces : {false, true})
    {
        NodesWorld world;
        btSoftBody* body =
            qcMakeTetraCube(world.world.getWorldInfo(), btVector3(0, btScalar(0.3), 0), 3, btScalar(0.3), faces);
        body->m_cfg.piterations = 4;
        world.Add(body);
        world.Step(240);
        ck_assert_double_lt(double(qcLowestNode(world.body)), 0.2);
        ck_assert_double_lt(double(qcSpeedOf(world.body)), 0.05);
    }
}
END_TEST

START_TEST(a_node_inside_a_body_of_tetrahedra_is_not_held_by_a_mesh)
{
    NodesWorld world;
    btSoftBody* cube =
        qcMakeTetraCube(world.world.getWorldInfo(), btVector3(0, btScalar(0.05), 0), 3, btScalar(0.3), false);
    btSoftBodyHelpers::generateBoundaryFaces(cube);
    world.Add(cube);
    qcSoftBodySettings settings;
    settings.thickness = btScalar(0.01);
    world.softSolver.setSettings(cube, settings);
    world.Step(60);
    // Pressed below the floor little by little, as under a heavy load.
    const int number = 1 + 4 * 1 + 16 * 1;
    btSoftBody::Node& inner = cube->m_nodes[number];
    const btScalar mass = cube->getMass(number);
    cube->setMass(number, 0);
    for (btScalar y = inner.m_x.y(); y > btScalar(-0.4); y -= btScalar(0.03))
    {
        inner.m_x.setY(y);
        world.world.stepSimulation(btScalar(1.0 / 60), 0);
    }
    ck_assert_double_lt(double(inner.m_x.y()), -0.3);
    cube->setMass(number, mass);
    world.SetGravity(btVector3(0, 10, 0));
    for (int step = 0; step < 120; step++)
        world.world.stepSimulation(btScalar(1.0 / 60), 0);
    ck_assert_double_gt(double(inner.m_x.y()), 5);
}
END_TEST

START_TEST(a_cloth_that_is_cut_and_loses_its_faces_stays_above_a_mesh)
{
    NodesWorld world;
    const btVector3 corner(-1, btScalar(0.3), -1), x(2, 0, 0), z(0, 0, 2);
    world.Add(btSoftBodyHelpers::CreatePatch(world.world.getWorldInfo(), corner, corner + x, corner + z, corner + x + z,
                                             16, 16, 0, true));
    std::srand(1);
    for (int i = 0; i < 60; i++)
    {
        world.Step(2, 0);
        const btSoftBody::Link& link = world.body->m_links[std::rand() % world.body->m_links.size()];
        world.body->cutLink(link.m_n[0], link.m_n[1], btScalar(0.5));
    }
    while (world.body->m_faces.size() > 0)
    {
        world.body->m_faces.resize(world.body->m_faces.size() * 3 / 4);
        world.Step(3, 0);
    }
    world.Step(120, 0);
}
END_TEST

/// The sides of a cut are at one place, and the links that go on around it hold them there.
START_TEST(a_cloth_that_is_cut_on_the_ground_rests)
{
    btBoxShape ground(btVector3(5, btScalar(0.5), 5));
    qcSoftWorld scene;
    scene.AddBody(&ground, 0, btVector3(0, btScalar(-0.5), 0));
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(scene.world.getWorldInfo(), btVector3(-1, btScalar(0.2), -1),
                                                       btVector3(1, btScalar(0.2), -1), btVector3(-1, btScalar(0.2), 1),
                                                       btVector3(1, btScalar(0.2), 1), 21, 21, 0, true);
    cloth->m_cfg.piterations = 4;
    cloth->setTotalMass(btScalar(0.5));
    scene.world.addSoftBody(cloth);
    scene.cloths.push_back(cloth);
    for (int step = 0; step < 360; step++)
    {
        for (int row = 0; step == 120 && row < 20; row++)
            ck_assert(cloth->cutLink(row * 21 + 10, row * 21 + 11, btScalar(0.5)));
        scene.world.stepSimulation(btScalar(1) / 60, 0);
        for (int i = 0; step >= 300 && i < cloth->m_nodes.size(); i++)
            ck_assert_double_lt(double(cloth->m_nodes[i].m_v.length()), 0.1);
    }
}
END_TEST
} // namespace

QC_RUN_TESTS("soft_body_nodes", a_cloth_that_is_cut_on_the_ground_rests, a_rope_lies_on_a_mesh,
             tetrahedra_lie_on_a_mesh_with_faces_and_without, a_node_inside_a_body_of_tetrahedra_is_not_held_by_a_mesh,
             a_cloth_that_is_cut_and_loses_its_faces_stays_above_a_mesh)
