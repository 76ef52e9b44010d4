// The verdicts of `qc-bench stability`, on a scene of two tetrahedra that the test moves.
#include "bench/stability/history.h"

#include "quickcullide/bullet.h"
#include "quickcullide/bullet_positions.h"
#include "support/suite.h"

#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <functional>

namespace
{
constexpr uint32_t s_steps = 400;

const btVector3 s_corners[4] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
const uint32_t s_indices[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};

// The second triangle crosses the first one if it is moved to x = 0.
const btVector3 s_nodes[6] = {{-1, -5, 0}, {1, -5, 0}, {0, -4, 0}, {5, -btScalar(4.5), -1}, {5, -btScalar(4.5), 1},
                              {5, -6, 0}};
const btScalar s_masses[6] = {0, 0, 0, 0, 0, 0};

/// A body of 2 kg, moved by a function, another one and a soft body far from it. Nothing is simulated.
class Scene : public qcStabilityScene
{
  public:
    explicit Scene(std::function<void(Scene*, uint32_t step)> move) : m_move(std::move(move))
    {
        m_world.addRigidBody(&body);
        m_world.addRigidBody(&other);
        soft.appendFace(0, 1, 2);
        soft.appendFace(3, 4, 5);
        m_world.addCollisionObject(&soft);
        m_world.setGravity(btVector3(0, -10, 0));
        Put(&other, btVector3(10, 0, 0));
    }
    ~Scene() override
    {
        m_world.removeCollisionObject(&soft);
        m_world.removeRigidBody(&other);
        m_world.removeRigidBody(&body);
    }
    static void Put(btRigidBody* moved, const btVector3& place)
    {
        moved->setWorldTransform(btTransform(btQuaternion::getIdentity(), place));
    }
    bool Step(std::string*) override
    {
        m_move(this, ++m_step);
        return true;
    }
    btDiscreteDynamicsWorld& World() override
    {
        return m_world;
    }
    const qcSoftBodyStatistics* SoftStatistics() const override
    {
        return hasStatistics ? &statistics : nullptr;
    }

    qcMeshShape shape{s_corners, qcBulletPositions, sizeof(btVector3), 4, s_indices, 4};
    btRigidBody body{2, nullptr, &shape, btVector3(1, 1, 1)}, other{2, nullptr, &shape, btVector3(1, 1, 1)};
    btSoftBodyWorldInfo info;
    btSoftBody soft{&info, 6, s_nodes, s_masses};
    qcSoftBodyStatistics statistics;
    bool hasStatistics = false;
    std::vector<char> memory;

  private:
    std::function<void(Scene*, uint32_t)> m_move;
    uint32_t m_step = 0;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    qcBroadphase m_broadphase;
    btSequentialImpulseConstraintSolver m_solver;
    btDiscreteDynamicsWorld m_world{&m_dispatcher, &m_broadphase, &m_solver, &m_configuration};
};

const qcStabilitySceneDef s_def = {"test", "a test", "", "", 0.01, 1, nullptr};

/// The complaints about a run, joined.
std::string Run(const std::function<void(Scene*, uint32_t)>& move, const qcStabilitySceneDef& def = s_def,
                uint32_t steps = s_steps)
{
    Scene scene(move);
    qcStabilityHistory history(def, s_steps);
    std::string message, complaints;
    for (uint32_t step = 0; step < steps; step++)
    {
        ck_assert(scene.Step(&message));
        ck_assert_msg(history.Take(scene, 1, &message), "%s", message.c_str());
    }
    for (const std::string& complaint : history.Complaints())
        complaints += complaint + "\n";
    return complaints;
}

void CheckStable(const std::string& complaints)
{
    ck_assert_str_eq(complaints.c_str(), "");
}

void CheckComplaint(const std::string& complaints, const char* expected)
{
    ck_assert_msg(complaints.find(expected) != std::string::npos, "'%s' is not in '%s'", expected, complaints.c_str());
    ck_assert_msg(complaints.find('\n') == complaints.size() - 1, "more than one: %s", complaints.c_str());
}
} // namespace

START_TEST(a_scene_at_rest_is_stable)
{
    CheckStable(Run([](Scene*, uint32_t) {}));
}
END_TEST

START_TEST(energy_may_fall_but_not_rise)
{
    CheckStable(Run([](Scene* scene, uint32_t step)
                    { Scene::Put(&scene->body, btVector3(0, 3 - btScalar(0.001) * btScalar(step), 0)); }));
    // Two bodies of 2 kg: by 3 mm, it is 1.5 mm for the whole scene.
    auto lift = [](Scene* scene, uint32_t step)
    { Scene::Put(&scene->body, btVector3(0, step < 300 ? 0 : btScalar(0.003), 0)); };
    CheckComplaint(Run(lift), "energy grew by 0.06 J");
    auto spin = [](Scene* scene, uint32_t step)
    { scene->body.setAngularVelocity(btVector3(0, step < 300 ? btScalar(0) : btScalar(2), 0)); };
    CheckComplaint(Run(spin), "energy grew by 2 J");
}
END_TEST

START_TEST(energy_is_judged_from_rest_on_and_where_nothing_drives_the_scene)
{
    auto early = [](Scene* scene, uint32_t step)
    { Scene::Put(&scene->body, btVector3(0, btScalar(step < 50 ? 0 : 1), 0)); };
    CheckStable(Run(early));
    auto late = [](Scene* scene, uint32_t step)
    { Scene::Put(&scene->body, btVector3(0, btScalar(step < 300 ? 0 : 1), 0)); };
    qcStabilitySceneDef driven = s_def;
    driven.driven = "a crane";
    CheckStable(Run(late, driven));
    qcStabilitySceneDef longer = s_def;
    longer.settledSeconds = 10;
    CheckStable(Run(late, longer));
    CheckComplaint(Run(late), "energy grew by 20 J");
}
END_TEST

START_TEST(a_number_that_is_not_finite_fails)
{
    CheckComplaint(Run([](Scene* scene, uint32_t step)
                       { scene->body.setLinearVelocity(btVector3(step == 200 ? btScalar(NAN) : 0, 0, 0)); }),
                   "not finite from step 200 on");
}
END_TEST

START_TEST(pairs_that_penetrate_at_the_end_fail)
{
    auto meet = [](uint32_t from, uint32_t to)
    {
        return [from, to](Scene* scene, uint32_t step)
        {
            bool meets = step >= from && step < to;
            Scene::Put(&scene->other, btVector3(meets ? btScalar(0.25) : 10, 0, 0));
        };
    };
    CheckStable(Run(meet(100, 200)));
    CheckComplaint(Run(meet(399, 500)), " pairs of triangles penetrate at the end");
}
END_TEST

START_TEST(pairs_of_soft_bodies_that_are_not_reported_fail)
{
    // Two triangles of one soft body cross in steps 100 to 199.
    auto cross = [](int reported)
    {
        return [reported](Scene* scene, uint32_t step)
        {
            btScalar x = step >= 100 && step < 200 ? 0 : 5;
            for (int i = 3; i < 6; i++)
                scene->soft.m_nodes[i].m_x.setX(x);
            scene->hasStatistics = true;
            scene->statistics.remaining = reported;
        };
    };
    CheckComplaint(Run(cross(0)), "step 100: 1 pairs of soft bodies penetrate, the library reports 0");
    CheckStable(Run(cross(1)));
    qcStabilitySceneDef without = s_def;
    without.selfCollision = false;
    CheckStable(Run(cross(0), without));
}
END_TEST

START_TEST(memory_that_grows_all_the_time_fails)
{
    // Half a megabyte a step.
    CheckComplaint(Run([](Scene* scene, uint32_t step) { scene->memory.resize(step << 19, 1); }), "the process grew");
    CheckStable(Run([](Scene* scene, uint32_t) { scene->memory.resize(1 << 28, 1); }));
}
END_TEST

START_TEST(a_run_that_is_cut_is_judged_as_far_as_it_came)
{
    auto lift = [](Scene* scene, uint32_t step)
    { Scene::Put(&scene->body, btVector3(0, btScalar(step < 150 ? 0 : 1), 0)); };
    CheckComplaint(Run(lift, s_def, 200), "energy grew by 20 J");
    CheckStable(Run(lift, s_def, 140));
}
END_TEST

QC_RUN_TESTS("stability verdicts", a_scene_at_rest_is_stable, energy_may_fall_but_not_rise,
             energy_is_judged_from_rest_on_and_where_nothing_drives_the_scene, a_number_that_is_not_finite_fails,
             pairs_that_penetrate_at_the_end_fail, pairs_of_soft_bodies_that_are_not_reported_fail,
             memory_that_grows_all_the_time_fails, a_run_that_is_cut_is_judged_as_far_as_it_came)
