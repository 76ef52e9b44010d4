// QC_RECORD in a world of cloth and meshes: each file replays clean, and the world moves as it does without.
#include "bullet/mesh/mesh_models.h"
#include "quickcullide/bullet.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "support/run_program.h"
// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
/// A cloth falls on meshes that fall on a floor. The last positions of the cloth's nodes.
std::vector<btVector3> RunWorld()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    qcMeshContact meshContact;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
    meshContact.addTo(&world);
    world.getWorldInfo().m_gravity = world.getGravity();
    std::vector<std::unique_ptr<qcMeshShape>> shapes;
    std::vector<std::unique_ptr<btRigidBody>> bodies;
    for (int i = 0; i < 4; i++)
    {
        qcModel model = i == 0 ? qcBoxModel(btVector3(3, btScalar(0.5), 3), 4) : qcSphereModel(btScalar(0.4), 2);
        shapes.push_back(model.MakeShape());
        btVector3 inertia(0, 0, 0);
        if (i > 0)
            shapes.back()->calculateLocalInertia(1, inertia);
        btRigidBody::btRigidBodyConstructionInfo info(btScalar(i > 0), nullptr, shapes.back().get(), inertia);
        info.m_startWorldTransform.setIdentity();
        info.m_startWorldTransform.setOrigin(
            btVector3(btScalar(0.3) * btScalar(i), btScalar(0.9) * btScalar(i), btScalar(0.1) * btScalar(i)));
        bodies.emplace_back(new btRigidBody(info));
        world.addRigidBody(bodies.back().get());
    }
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, 4, -1), btVector3(1, 4, -1),
                                                       btVector3(-1, 4, 1), btVector3(1, 4, 1), 12, 12, 0, true);
    cloth->m_cfg.piterations = 4;
    cloth->setTotalMass(1);
    world.addSoftBody(cloth);
    for (int i = 0; i < 60; i++)
        world.stepSimulation(btScalar(1.0 / 60), 0);
    ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    std::vector<btVector3> positions;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        positions.push_back(cloth->m_nodes[i].m_x);
    world.removeSoftBody(cloth);
    delete cloth;
    for (auto& body : bodies)
        world.removeRigidBody(body.get());
    return positions;
}
} // namespace

START_TEST(every_file_of_a_world_replays_clean_and_the_world_is_the_same)
{
    EnterFolder();
    std::vector<btVector3> plain = RunWorld();
    ck_assert_int_eq(setenv("QC_RECORD", "a", 1), 0);
    std::vector<btVector3> recorded = RunWorld();
    ck_assert_int_eq(unsetenv("QC_RECORD"), 0);
    for (size_t i = 0; i < plain.size(); i++)
        ck_assert(plain[i].x() == recorded[i].x() && plain[i].y() == recorded[i].y() &&
                  plain[i].z() == recorded[i].z());
    // The broadphase, the scene of the cloth, and those of the meshes' contact.
    size_t files = CountEntries(), results = 0, contacts = 0;
    ck_assert_uint_ge(files, 3);
    for (size_t i = 1; i <= files; i++)
    {
        int status = Run(QC_REPLAY_PROGRAM " --each a.%zu.qcr", i);
        ck_assert_msg(status == 0, "%s%s", GetOutput(), GetErrors());
        const char* same = std::strstr(GetOutput(), " results are the recorded ones, 0 differ");
        results += same != nullptr;
        ck_assert_ptr_null(std::strstr(GetOutput(), "not compared"));
        ck_assert_int_eq(Run(QC_REPLAY_PROGRAM " --list a.%zu.qcr", i), 0);
        contacts += std::strstr(GetOutput(), "set vertices") != nullptr;
    }
    ck_assert_uint_ge(results, 3);
    ck_assert_uint_ge(contacts, 1);
    LeaveFolder();
}
END_TEST

QC_RUN_TESTS("recorded_world", every_file_of_a_world_replays_clean_and_the_world_is_the_same)
