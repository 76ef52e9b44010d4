// Bullet's contact callbacks for soft bodies: each contact of two bodies starts once and ends once.
#include "quickcullide/bullet.h"
#include "quickcullide/bullet_deformable.h"

#include "bullet/mesh/mesh_models.h"
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <functional>
#include <memory>
#include <utility>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
using Bodies = std::pair<const btCollisionObject*, const btCollisionObject*>;

/// The bodies of the callbacks so far, in order, and a function that each call runs at its end.
std::vector<Bodies> s_started, s_ended, s_processed;
std::function<void()> s_afterwards;
size_t s_given, s_givenBack; // user data of points

void Note(std::vector<Bodies>* list, const void* a, const void* b)
{
    Bodies bodies(static_cast<const btCollisionObject*>(a), static_cast<const btCollisionObject*>(b));
    // They must be readable.
    ck_assert_ptr_nonnull(bodies.first->getCollisionShape());
    ck_assert_ptr_nonnull(bodies.second->getCollisionShape());
    list->push_back(bodies);
}

void NoteStarted(btPersistentManifold* const& manifold)
{
    ck_assert_int_gt(manifold->getNumContacts(), 0);
    Note(&s_started, manifold->getBody0(), manifold->getBody1());
    if (s_afterwards)
        s_afterwards();
}

void NoteEnded(btPersistentManifold* const& manifold)
{
    ck_assert_int_eq(manifold->getNumContacts(), 0);
    Note(&s_ended, manifold->getBody0(), manifold->getBody1());
    if (s_afterwards)
        s_afterwards();
}

bool NoteProcessed(btManifoldPoint& point, void* a, void* b)
{
    Note(&s_processed, a, b);
    ck_assert_ptr_null(point.m_userPersistentData);
    point.m_userPersistentData = &s_given;
    s_given++;
    return true;
}

bool NoteDestroyed(void* data)
{
    ck_assert_ptr_eq(data, &s_given);
    s_givenBack++;
    return true;
}

void Listen()
{
    s_started.clear();
    s_ended.clear();
    s_processed.clear();
    s_afterwards = nullptr;
    s_given = s_givenBack = 0;
    gContactStartedCallback = NoteStarted;
    gContactEndedCallback = NoteEnded;
    gContactProcessedCallback = NoteProcessed;
    gContactDestroyedCallback = NoteDestroyed;
}

void Hush()
{
    gContactStartedCallback = nullptr;
    gContactEndedCallback = nullptr;
    gContactProcessedCallback = nullptr;
    gContactDestroyedCallback = nullptr;
}

/// A square plate of two triangles under cloths.
struct CallbackWorld : qcSoftWorld
{
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(2, 1).MakeShape();
    std::unique_ptr<btRigidBody> plate;

    CallbackWorld()
    {
        Listen();
    }

    ~CallbackWorld()
    {
        while (!cloths.empty())
            RemoveCloth();
        RemovePlate();
        // The solver releases user data later.
        gContactStartedCallback = nullptr;
        gContactEndedCallback = nullptr;
        gContactProcessedCallback = nullptr;
    }

    void AddPlate(btScalar y)
    {
        plate = std::make_unique<btRigidBody>(btScalar(0), nullptr, shape.get());
        world.addRigidBody(plate.get());
        PutPlate(y);
    }

    void PutPlate(btScalar y)
    {
        plate->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, y, 0)));
        world.updateSingleAabb(plate.get());
    }

    void RemovePlate()
    {
        if (plate != nullptr)
            world.removeRigidBody(plate.get());
        plate.reset();
    }

    btSoftBody* AddCloth(btScalar y, int fixed = 0, btScalar x = 0)
    {
        btScalar half = fixed != 0 ? btScalar(0.6) : btScalar(0.5);
        btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(x - half, y, -half),
                                                           btVector3(x + half, y, -half), btVector3(x - half, y, half),
                                                           btVector3(x + half, y, half), 5, 5, fixed, true);
        cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
        cloth->setTotalMass(btScalar(0.5));
        world.addSoftBody(cloth);
        cloths.push_back(cloth);
        return cloth;
    }

    void Step(int steps)
    {
        for (int i = 0; i < steps; i++)
            world.stepSimulation(btScalar(1.0 / 120), 0);
        ck_assert_int_eq(softSolver.getStatistics().status, qc_statusOk);
    }
};

START_TEST(a_contact_of_a_cloth_with_a_mesh_starts_once_and_ends_once)
{
    CallbackWorld world;
    world.AddPlate(0);
    const btSoftBody* cloth = world.AddCloth(btScalar(0.1));
    for (size_t times = 1; times <= 3; times++)
    {
        // It falls onto the plate and lies there. The plate is removed, and put under it again.
        world.Step(40);
        ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
        ck_assert_uint_eq(s_started.size(), times);
        ck_assert(s_started.back() == Bodies(cloth, world.plate.get()));
        ck_assert_uint_eq(s_ended.size(), times - 1);
        world.PutPlate(-100);
        world.Step(3);
        ck_assert_uint_eq(s_started.size(), times);
        ck_assert_uint_eq(s_ended.size(), times);
        ck_assert(s_ended.back() == s_started.back());
        world.PutPlate(cloth->m_nodes[0].m_x.y() - btScalar(0.1));
    }
}
END_TEST

START_TEST(contacts_of_two_cloths_start_and_end_alternately_with_the_older_one_first)
{
    CallbackWorld world;
    const btSoftBody *lower = world.AddCloth(0, 1 + 2 + 4 + 8), *upper = world.AddCloth(btScalar(0.1));
    qcSoftBodySettings settings;
    settings.selfCollision = false;
    for (const btSoftBody* cloth : world.cloths)
        world.softSolver.setSettings(cloth, settings);
    for (int i = 0; i < 400; i++)
    {
        // It bounces at first.
        size_t started = s_started.size(), ended = s_ended.size();
        world.Step(1);
        ck_assert_uint_eq(s_started.size(), s_ended.size() + (world.softSolver.getStatistics().contacts > 0));
        ck_assert_uint_le(s_started.size() + s_ended.size(), started + ended + 1);
        for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
        {
            const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(m);
            ck_assert_ptr_eq(manifold->getBody0(), lower);
            ck_assert_ptr_eq(manifold->getBody1(), upper);
            for (int p = 0; p < manifold->getNumContacts(); p++)
            {
                const btManifoldPoint& point = manifold->getContactPoint(p);
                // Towards body 0, which lies below.
                ck_assert(point.m_normalWorldOnB.y() < 0);
                ck_assert(point.getPositionWorldOnA().y() < point.getPositionWorldOnB().y());
            }
        }
    }
    ck_assert_uint_eq(s_started.size(), s_ended.size() + 1);
    world.cloths[1]->translate(btVector3(0, 5, 0));
    world.Step(3);
    ck_assert_uint_eq(s_started.size(), s_ended.size());
    for (const std::vector<Bodies>& told : {s_started, s_ended, s_processed})
        for (const Bodies& bodies : told)
            ck_assert(bodies == Bodies(lower, upper));
}
END_TEST

START_TEST(each_point_is_reported_in_each_step_and_its_user_data_released)
{
    size_t all = 0;
    {
        CallbackWorld world;
        world.AddPlate(0);
        const btSoftBody* cloth = world.AddCloth(btScalar(0.1));
        for (int i = 0; i < 60; i++)
        {
            world.Step(1);
            ck_assert_uint_eq(s_givenBack, all);
            size_t points = 0;
            for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
                points += size_t(world.dispatcher.getManifoldByIndexInternal(m)->getNumContacts());
            all += points;
            ck_assert_uint_eq(points, size_t(world.softSolver.getStatistics().contacts));
            ck_assert_uint_eq(s_processed.size(), all);
        }
        for (const Bodies& bodies : s_processed)
            ck_assert(bodies == Bodies(cloth, world.plate.get()));
        ck_assert_uint_gt(all, 500);
        ck_assert_uint_gt(s_given, s_givenBack);
    }
    // The solver releases those of the last step.
    ck_assert_uint_eq(s_givenBack, all);
}
END_TEST

START_TEST(sleeping_bodies_stay_in_contact)
{
    CallbackWorld world;
    world.AddPlate(0);
    btSoftBody* cloth = world.AddCloth(btScalar(0.1));
    world.Step(60);
    ck_assert_uint_eq(s_started.size(), 1);
    for (int times = 0; times < 2; times++)
    {
        cloth->forceActivationState(DISABLE_SIMULATION);
        world.Step(5);
        ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
        cloth->forceActivationState(ACTIVE_TAG);
        world.Step(5);
        ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
    }
    ck_assert_uint_eq(s_started.size(), 1);
    ck_assert_uint_eq(s_ended.size(), 0);
    cloth->forceActivationState(DISABLE_SIMULATION);
    world.Step(2);
    world.PutPlate(-100);
    world.Step(2);
    ck_assert_uint_eq(s_ended.size(), 1);
}
END_TEST

/// Two cloths beside each other that land on the plate in the same step.
struct Twins : CallbackWorld
{
    Twins()
    {
        AddPlate(0);
        AddCloth(btScalar(0.1), 0, btScalar(-0.7));
        AddCloth(btScalar(0.1), 0, btScalar(0.7));
    }

    void StepUntilStarted()
    {
        for (int i = 0; i < 60 && s_started.empty(); i++)
            Step(1);
    }
};

START_TEST(two_contacts_may_start_and_end_in_one_step)
{
    Twins world;
    world.StepUntilStarted();
    ck_assert_uint_eq(s_started.size(), 2);
    world.Step(40);
    world.PutPlate(-100);
    s_ended.clear();
    world.Step(1);
    ck_assert_uint_eq(s_ended.size(), 2);
}
END_TEST

START_TEST(bodies_may_be_removed_when_a_contact_starts)
{
    for (bool plate : {true, false})
    {
        Twins world;
        const btSoftBody* first = world.cloths[0];
        s_afterwards = [&]
        {
            s_afterwards = nullptr;
            if (plate)
                world.RemovePlate();
            world.RemoveCloth();
            if (plate)
                world.RemoveCloth();
        };
        world.StepUntilStarted();
        // No callback gets points or contacts of removed bodies.
        ck_assert_uint_eq(s_started.size(), 1);
        ck_assert_ptr_eq(s_started[0].first, first);
        ck_assert(plate == s_processed.empty());
        for (const Bodies& bodies : s_processed)
            ck_assert_ptr_eq(bodies.first, first);
        world.Step(20);
        ck_assert_uint_eq(s_started.size(), 1);
        ck_assert_uint_eq(s_ended.size(), 0);
    }
}
END_TEST

START_TEST(bodies_may_be_removed_when_a_contact_ends)
{
    for (bool plate : {true, false})
    {
        Twins world;
        world.Step(40);
        world.PutPlate(-100);
        s_ended.clear();
        s_afterwards = [&]
        {
            s_afterwards = nullptr;
            if (plate)
                world.RemovePlate();
            world.RemoveCloth();
        };
        world.Step(20);
        ck_assert_uint_eq(s_ended.size(), 1);
    }
}
END_TEST

START_TEST(bodies_may_be_added_in_callbacks)
{
    CallbackWorld world;
    world.AddPlate(0);
    world.AddCloth(btScalar(0.1));
    s_afterwards = [&]
    {
        s_afterwards = nullptr;
        world.AddCloth(btScalar(0.4));
    };
    world.Step(120);
    ck_assert_uint_eq(world.cloths.size(), 2);
    ck_assert_uint_ge(s_started.size(), 2);
    ck_assert(s_started.back() == Bodies(world.cloths[0], world.cloths[1]));
}
END_TEST

START_TEST(no_callback_reports_the_end_of_a_contact_with_a_removed_mesh)
{
    CallbackWorld world;
    world.AddCloth(btScalar(0.1));
    world.AddPlate(0);
    world.Step(40);
    ck_assert_uint_eq(s_started.size(), 1);
    world.RemovePlate();
    world.Step(3);
    ck_assert_uint_eq(s_ended.size(), 0);
    // Another cloth, maybe at the same address, is another contact.
    world.AddPlate(world.cloths[0]->m_nodes[0].m_x.y() - btScalar(0.1));
    world.Step(40);
    ck_assert_uint_eq(s_started.size(), 2);
    ck_assert_uint_eq(s_ended.size(), 0);
}
END_TEST

START_TEST(no_callback_reports_the_end_of_contacts_of_a_removed_cloth)
{
    CallbackWorld world;
    world.AddCloth(0, 1 + 2 + 4 + 8);
    world.AddCloth(btScalar(0.1));
    world.AddPlate(btScalar(-0.3));
    world.Step(60);
    ck_assert_uint_gt(s_started.size(), 0);
    size_t ended = s_ended.size();
    world.RemoveCloth();
    world.Step(3);
    ck_assert_uint_eq(s_ended.size(), ended);
}
END_TEST

START_TEST(no_callback_reports_a_plate_removed_in_the_step_that_ends_its_contact)
{
    CallbackWorld world;
    world.AddCloth(btScalar(0.1));
    world.AddPlate(0);
    world.Step(40);
    world.PutPlate(-100);
    world.RemovePlate();
    world.Step(2);
    ck_assert_uint_eq(s_ended.size(), 0);
}
END_TEST
START_TEST(contacts_of_deformable_bodies_start_once_and_end_once)
{
    Listen();
    qcDeformableTestWorld<qcDeformableWorld> deformable;
    qcDeformableWorld& world = *deformable.world;
    world.setThreadCount(1);
    btDeformableGravityForce gravity(world.getGravity());
    std::unique_ptr<qcMeshShape> shape = qcFloorModel(2, 1).MakeShape();
    btRigidBody plate(btScalar(0), nullptr, shape.get());
    world.addRigidBody(&plate);
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(
        world.getWorldInfo(), btVector3(-0.5, btScalar(0.1), -0.5), btVector3(0.5, btScalar(0.1), -0.5),
        btVector3(-0.5, btScalar(0.1), 0.5), btVector3(0.5, btScalar(0.1), 0.5), 5, 5, 0, true);
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD;
    cloth->setTotalMass(btScalar(0.5));
    world.addSoftBody(cloth);
    world.addForce(cloth, &gravity);
    size_t points = 0;
    for (int i = 0; i < 60; i++)
    {
        world.stepSimulation(btScalar(1.0 / 240), 0);
        ck_assert_uint_eq(s_givenBack, points);
        points += size_t(world.getStatistics().contacts);
        ck_assert_uint_eq(s_processed.size(), points);
    }
    ck_assert_uint_eq(s_started.size(), 1);
    ck_assert(s_started[0] == Bodies(cloth, &plate));
    s_afterwards = [&] { world.removeRigidBody(&plate); };
    plate.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, -100, 0)));
    world.updateSingleAabb(&plate);
    for (int i = 0; i < 3; i++)
        world.stepSimulation(btScalar(1.0 / 240), 0);
    ck_assert_uint_eq(s_ended.size(), 1);
    world.removeSoftBody(cloth);
    delete cloth;
    Hush();
}
END_TEST

/// Counts the calls for a body.
struct CountingDispatcher : btCollisionDispatcher
{
    using btCollisionDispatcher::btCollisionDispatcher;
    const btCollisionObject* counted = nullptr;
    int calls = 0;

    bool needsResponse(const btCollisionObject* a, const btCollisionObject* b) override
    {
        calls += counted != nullptr && (a == counted || b == counted);
        return btCollisionDispatcher::needsResponse(a, b);
    }
};

/// Removes a body from its world, once, and moves another.
struct RemoveInAction : btActionInterface
{
    btRigidBody *removed = nullptr, *moved = nullptr;

    void updateAction(btCollisionWorld* world, btScalar) override
    {
        if (removed == nullptr)
            return;
        static_cast<btDynamicsWorld*>(world)->removeRigidBody(removed);
        removed = nullptr;
        moved->setWorldTransform(
            btTransform(btQuaternion::getIdentity(), moved->getWorldTransform().getOrigin() + btVector3(1, 0, 0)));
    }
    void debugDraw(btIDebugDraw*) override
    {
    }
};

// Manifolds of soft bodies stay in the dispatcher until the next step; an action may delete the body, too.
START_TEST(nothing_reads_a_body_on_cloth_after_an_action_has_removed_it)
{
    RemoveInAction action;
    qcMeshContact contact;
    btDeformableGravityForce gravity(btVector3(0, -10, 0)); // outlives the world, which removes it from bodies
    qcDeformableTestWorld<qcDeformableWorld, CountingDispatcher> deformable;
    qcDeformableWorld& world = *deformable.world;
    world.setThreadCount(1);
    world.addAction(&action);
    contact.addTo(&world);
    std::unique_ptr<qcMeshShape> shape = qcBoxModel(btVector3(1, 1, 1) / 5, 1).MakeShape();
    btRigidBody crate(btScalar(0.3), nullptr, shape.get(), btVector3(1, 1, 1));
    btRigidBody other(btScalar(0.3), nullptr, shape.get(), btVector3(1, 1, 1));
    crate.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.35), 0)));
    other.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(3, 0, 0)));
    world.addRigidBody(&crate);
    world.addRigidBody(&other);
    btSoftBody* cloth = btSoftBodyHelpers::CreatePatch(
        world.getWorldInfo(), btVector3(-0.5, btScalar(0.1), -0.5), btVector3(0.5, btScalar(0.1), -0.5),
        btVector3(-0.5, btScalar(0.1), 0.5), btVector3(0.5, btScalar(0.1), 0.5), 5, 5, 15, true);
    cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RD;
    cloth->setTotalMass(btScalar(0.5));
    world.addSoftBody(cloth);
    deformable.cloths.push_back(cloth);
    world.addForce(cloth, &gravity);
    for (int i = 0; i < 60; i++)
        world.stepSimulation(btScalar(1.0 / 240), 0);
    ck_assert_int_gt(world.qcSoftBodyContact::getStatistics().contacts, 0);
    deformable.dispatcher.counted = &crate;
    action.removed = &crate;
    action.moved = &other;
    world.stepSimulation(btScalar(1.0 / 240), 0);
    const int calls = deformable.dispatcher.calls;
    for (int i = 0; i < 3; i++)
        world.stepSimulation(btScalar(1.0 / 240), 0);
    ck_assert_int_eq(calls, 0);
    world.removeRigidBody(&other);
}
END_TEST
} // namespace

QC_RUN_TESTS("contact callbacks of soft bodies", a_contact_of_a_cloth_with_a_mesh_starts_once_and_ends_once,
             contacts_of_two_cloths_start_and_end_alternately_with_the_older_one_first,
             each_point_is_reported_in_each_step_and_its_user_data_released, sleeping_bodies_stay_in_contact,
             two_contacts_may_start_and_end_in_one_step, bodies_may_be_removed_when_a_contact_starts,
             bodies_may_be_removed_when_a_contact_ends, bodies_may_be_added_in_callbacks,
             no_callback_reports_the_end_of_a_contact_with_a_removed_mesh,
             no_callback_reports_the_end_of_contacts_of_a_removed_cloth,
             no_callback_reports_a_plate_removed_in_the_step_that_ends_its_contact,
             contacts_of_deformable_bodies_start_once_and_end_once,
             nothing_reads_a_body_on_cloth_after_an_action_has_removed_it)
