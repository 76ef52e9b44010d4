// The library on a Bullet task scheduler: a world of soft bodies moves as it does on one thread, in both precisions.
#include "quickcullide/bullet.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <cstring>
#include <vector>

#include "bullet/thread_scheduler.h"

// After the standard headers: check defines a macro named fail.
#include "support/check_ok.h"
#include "support/suite.h"

namespace
{
/// The nodes of a cloth of 1800 faces after it has fallen into folds for some steps.
std::vector<btVector3> Fold()
{
    btSoftBodyRigidBodyCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    qcBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    qcSoftBodySolver softSolver;
    btSoftRigidDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration, &softSolver);
    world.getWorldInfo().m_gravity = world.getGravity();
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(
        world.getWorldInfo(), btVector3(-0.5, 0, 0), btVector3(0.5, 0, btScalar(0.02)),
        btVector3(-0.5, 1, btScalar(0.03)), btVector3(0.5, 1, btScalar(-0.02)), 31, 31, 1 + 2, false);
    // Folded: the upper half comes down through the lower one.
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        btVector3& v = cloth->m_nodes[i].m_v;
        v = btVector3(0, cloth->m_nodes[i].m_x.y() > btScalar(0.5) ? -20 : 0, 0);
    }
    world.addSoftBody(cloth);
    int contacts = 0;
    for (int i = 0; i < 8; i++)
    {
        world.stepSimulation(btScalar(1.0 / 120), 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
        contacts += softSolver.getStatistics().contacts;
    }
    ck_assert_int_gt(contacts, 100);
    std::vector<btVector3> nodes;
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        nodes.push_back(cloth->m_nodes[i].m_x);
    world.removeSoftBody(cloth);
    delete cloth;
    return nodes;
}

START_TEST(a_world_moves_on_a_scheduler_as_it_does_without)
{
    CHECK_OK(qcSetTaskScheduler(nullptr));
    const std::vector<btVector3> expected = Fold();
    qcThreadScheduler scheduler(3);
    // Null for a Bullet without threads.
    btITaskScheduler* others[] = {&scheduler, btGetSequentialTaskScheduler(), btCreateDefaultTaskScheduler()};
    for (btITaskScheduler* other : others)
    {
        CHECK_OK(qcSetTaskScheduler(other));
        ck_assert(Fold() == expected);
    }
    ck_assert_int_gt(scheduler.loops, 8);
    ck_assert_int_eq(scheduler.maxIterations, 3);
    CHECK_OK(qcSetTaskScheduler(nullptr));
    delete others[2];
}
END_TEST

START_TEST(null_takes_the_scheduler_away_and_the_number_of_threads_is_that_of_the_call)
{
    qcThreadScheduler scheduler(2);
    CHECK_OK(qcSetTaskScheduler(&scheduler));
    scheduler.setNumThreads(4);
    Fold();
    ck_assert_int_eq(scheduler.maxIterations, 2);
    CHECK_OK(qcSetTaskScheduler(&scheduler));
    Fold();
    ck_assert_int_eq(scheduler.maxIterations, 4);
    int loops = scheduler.loops;
    CHECK_OK(qcSetTaskScheduler(nullptr));
    Fold();
    ck_assert_int_eq(scheduler.loops, loops);
}
END_TEST

START_TEST(a_scheduler_without_threads_is_refused)
{
    qcThreadScheduler scheduler(2);
    CHECK_OK(qcSetTaskScheduler(&scheduler));
    for (int threads = -1; threads <= 0; threads++)
    {
        qcThreadScheduler none(threads);
        ck_assert_int_eq(qcSetTaskScheduler(&none), qc_statusBadInput);
        ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "workers is 0"));
    }
    Fold();
    ck_assert_int_gt(scheduler.loops, 0);
    CHECK_OK(qcSetTaskScheduler(nullptr));
}
END_TEST
} // namespace

QC_RUN_TESTS("task scheduler", a_world_moves_on_a_scheduler_as_it_does_without,
             null_takes_the_scheduler_away_and_the_number_of_threads_is_that_of_the_call,
             a_scheduler_without_threads_is_refused)
