// A program that writes a saved state back, as a rollback does, gets the step that followed it then, up to what
// contacts remember: no body moves from where it was last to its restored place.
#include "bullet/soft_body/soft_world.h"

#include <BulletCollision/CollisionShapes/btBoxShape.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <algorithm>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr btScalar s_restoredStep = btScalar(1) / 60;

/// What a program saves of a rigid and a soft body.
struct State
{
    btTransform transform;
    btVector3 linear, angular;
    std::vector<btVector3> positions, starts, velocities;
};

/// A cloth falls over a box that slides on the ground.
struct RestoredWorld : qcSoftWorld
{
    btBoxShape ground{btVector3(5, btScalar(0.5), 5)};
    btRigidBody* box;
    btSoftBody* cloth;

    RestoredWorld()
    {
        meshContact.addTo(&world);
        AddBody(&ground, 0, btVector3(0, btScalar(-0.5), 0));
        box = AddMesh(qcBoxModel(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)), 1), 1,
                      btVector3(btScalar(0.1), 1, btScalar(0.1)));
        box->setLinearVelocity(btVector3(1, 0, 0));
        box->setActivationState(DISABLE_DEACTIVATION);
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-1, btScalar(1.3), -1),
                                               btVector3(1, btScalar(1.3), -1), btVector3(-1, btScalar(1.3), 1),
                                               btVector3(1, btScalar(1.3), 1), 21, 21, 0, true);
        cloth->m_cfg.piterations = 4;
        cloth->setTotalMass(btScalar(0.5));
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
    }

    void Step(int count)
    {
        for (int i = 0; i < count; i++)
            world.stepSimulation(s_restoredStep, 0);
    }

    State Save() const
    {
        State state{box->getWorldTransform(), box->getLinearVelocity(), box->getAngularVelocity(), {}, {}, {}};
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            state.positions.push_back(cloth->m_nodes[i].m_x);
            state.starts.push_back(cloth->m_nodes[i].m_q);
            state.velocities.push_back(cloth->m_nodes[i].m_v);
        }
        return state;
    }

    void Restore(const State& state)
    {
        box->setWorldTransform(state.transform);
        box->setInterpolationWorldTransform(state.transform);
        box->setLinearVelocity(state.linear);
        box->setInterpolationLinearVelocity(state.linear);
        box->setAngularVelocity(state.angular);
        box->setInterpolationAngularVelocity(state.angular);
        box->clearForces();
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            btSoftBody::Node& node = cloth->m_nodes[i];
            node.m_x = state.positions[size_t(i)];
            node.m_q = state.starts[size_t(i)];
            node.m_v = state.velocities[size_t(i)];
            node.m_f.setZero();
        }
    }
};
} // namespace

START_TEST(a_restored_state_goes_on_as_it_did)
{
    const int undone = _i;
    for (int first = 2; first < 150; first += 12)
    {
        RestoredWorld scene;
        scene.Step(first);
        const State saved = scene.Save();
        scene.Step(1);
        const State next = scene.Save();
        scene.Step(undone - 1);
        scene.Restore(saved);
        scene.Step(1);
        const State again = scene.Save();
        btScalar apart = 0;
        for (size_t i = 0; i < next.positions.size(); i++)
            apart = std::max(apart, (next.positions[i] - again.positions[i]).length());
        ck_assert_double_lt(double(apart), 0.05);
        ck_assert_double_lt(double((next.linear - again.linear).length()), 0.2);
        ck_assert_int_eq(scene.softSolver.getStatistics().remaining, 0);
    }
}
END_TEST

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("restored states");
    for (int undone : {1, 5, 10, 30})
        tcase_add_loop_test(tests, a_restored_state_goes_on_as_it_did, undone, undone + 1);
    return qcRunCase("restored states", tests);
}
