// The soft-body solver in Bullet's soft-rigid world: cloth that penetrates without it does not with it, in both
// precisions.
#include "bullet/soft_body/soft_world.h"

#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <btBulletDynamicsCommon.h>

#include <cmath>
#include <limits>
#include <algorithm>
#include <cstring>
#include <vector>

// After the standard headers: check defines a macro named fail.
#include "bullet/soft_body/soft_models.h"
#include "support/devices.h"

namespace
{
/// A world with a floor.
struct World : qcSoftWorld
{
    btStaticPlaneShape floorShape{btVector3(0, 1, 0), 0};
    btRigidBody floor{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &floorShape)};

    explicit World(qcDevice* device = nullptr) : qcSoftWorld(device)
    {
        world.addRigidBody(&floor);
    }

    ~World()
    {
        while (!cloths.empty())
            RemoveCloth();
        world.removeRigidBody(&floor);
    }

    /// A patch of side * side squares with the given corners.
    btSoftBody* AddCloth(const btVector3& a, const btVector3& b, const btVector3& c, const btVector3& d, int side,
                         int group = btBroadphaseProxy::DefaultFilter, int mask = btBroadphaseProxy::AllFilter)
    {
        btSoftBody* cloth =
            btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), a, b, c, d, side + 1, side + 1, 0, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.01));
        cloth->m_cfg.piterations = 6;
        cloth->m_cfg.collisions = btSoftBody::fCollision::SDF_RS | btSoftBody::fCollision::VF_SS;
        cloth->m_cfg.kKHR = 1;
        cloth->setTotalMass(btScalar(0.5));
        world.addSoftBody(cloth, group, mask);
        cloths.push_back(cloth);
        return cloth;
    }

    /// A cloth hanging upright over the floor: it falls into a heap of folds.
    btSoftBody* AddUprightCloth(int side)
    {
        return AddCloth(btVector3(btScalar(-0.5), btScalar(0.05), 0),
                        btVector3(btScalar(0.5), btScalar(0.05), btScalar(0.02)),
                        btVector3(btScalar(-0.5), btScalar(1.05), btScalar(0.03)),
                        btVector3(btScalar(0.5), btScalar(1.05), btScalar(-0.02)), side);
    }

    void Step()
    {
        world.stepSimulation(btScalar(1.0 / 120), 0);
    }
};

size_t CountPenetrating(const World& world)
{
    std::vector<qcWorldMesh> soups;
    for (const btSoftBody* cloth : world.cloths)
        soups.push_back(qcWorldMeshOf(cloth));
    return qcCountPenetrating(soups);
}

/// The maximum of penetrating pairs over the steps.
size_t MaxPenetrating(World& world, int steps)
{
    size_t max = 0;
    for (int i = 0; i < steps; i++)
    {
        world.Step();
        ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
        max = std::max(max, CountPenetrating(world));
        ck_assert_uint_eq(size_t(world.softSolver.getStatistics().remaining), max);
    }
    return max;
}

START_TEST(a_falling_cloth_never_penetrates_itself)
{
    World world;
    world.AddUprightCloth(24);
    ck_assert_uint_eq(MaxPenetrating(world, 150), 0);
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 20);
}
END_TEST

START_TEST(a_body_of_the_reduced_model_is_not_tested_with_itself)
{
    World world;
    world.AddUprightCloth(12)->m_reducedModel = true;
    for (int i = 0; i < 60; i++)
    {
        world.Step();
        const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.contacts + statistics.unproven + statistics.exempt + statistics.remaining, 0);
    }
}
END_TEST

START_TEST(an_uneven_cloth_that_is_not_deformed_is_not_in_contact_with_itself)
{
    World world;
    btSoftBody* cloth =
        world.AddCloth(btVector3(-1, 5, -1), btVector3(1, 5, -1), btVector3(-1, 5, 1), btVector3(1, 5, 1), 20);
    cloth->getCollisionShape()->setMargin(btScalar(0.25));
    // Every fourth column is ten times as narrow as it was.
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        btSoftBody::Node& node = cloth->m_nodes[i];
        if (i % 21 % 4 == 1)
            node.m_x.setX(node.m_x.x() - btScalar(0.09));
        node.m_q = node.m_x;
    }
    cloth->updateConstants();
    for (int i = 0; i < 20; i++)
    {
        world.Step();
        ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
    }
    // A thickness of the user's own is not reduced.
    qcSoftBodySettings settings;
    settings.thickness = btScalar(0.05);
    world.softSolver.setSettings(cloth, settings);
    world.Step();
    ck_assert_int_gt(world.softSolver.getStatistics().contacts, 100);
}
END_TEST

START_TEST(a_falling_cloth_penetrates_itself_without_self_collision)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(24);
    qcSoftBodySettings settings;
    settings.selfCollision = false;
    settings.bulletNodeContacts = true; // contacts with the floor are not counted
    world.softSolver.setSettings(cloth, settings);
    ck_assert(!world.softSolver.getSettings(cloth).selfCollision);
    for (int i = 0; i < 150; i++)
        world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
    ck_assert_uint_gt(CountPenetrating(world), 20);
}
END_TEST

btSoftBody* AddSheet(World& world, btScalar y, btScalar turn, int group, int mask)
{
    btScalar c = std::cos(turn) / 2, s = std::sin(turn) / 2;
    return world.AddCloth(btVector3(-c + s, y, -s - c), btVector3(c + s, y, s - c), btVector3(-c - s, y, -s + c),
                          btVector3(c - s, y, s + c), 14, group, mask);
}

START_TEST(cloths_that_fall_on_each_other_stay_apart)
{
    World world;
    AddSheet(world, btScalar(0.02), 0, 1, -1);
    AddSheet(world, btScalar(0.10), btScalar(0.4), 1, -1);
    AddSheet(world, btScalar(0.20), btScalar(0.9), 1, -1);
    ck_assert_uint_eq(MaxPenetrating(world, 120), 0);
    // The order in which they fell.
    for (int i = 0; i + 1 < 3; i++)
    {
        btVector3 low, high, lowNext, highNext;
        world.cloths[size_t(i)]->getAabb(low, high);
        world.cloths[size_t(i) + 1]->getAabb(lowNext, highNext);
        ck_assert(lowNext.y() > low.y());
    }
}
END_TEST

/// Two sheets land on a box that floats: the upper one presses the lower one on the box, which takes up the momentum.
/// `byNodes`: by Bullet's own contact of nodes with the box.
void LandOnFreeBox(bool byNodes)
{
    World world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.world.getWorldInfo().m_gravity.setZero();
    btBoxShape shape(btVector3(btScalar(0.6), btScalar(0.1), btScalar(0.6)));
    btVector3 inertia;
    shape.calculateLocalInertia(1, inertia);
    btRigidBody box(1, nullptr, &shape, inertia);
    box.setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, 2, 0)));
    box.setActivationState(DISABLE_DEACTIVATION);
    world.world.addRigidBody(&box);
    btSoftBody *lower = AddSheet(world, btScalar(2.13), 0, 1, -1), *upper = AddSheet(world, btScalar(2.2), 0, 1, -1);
    upper->setVelocity(btVector3(0, -1, 0));
    qcSoftBodySettings settings;
    settings.bulletNodeContacts = byNodes;
    for (btSoftBody* sheet : {lower, upper})
        world.softSolver.setSettings(sheet, settings);
    btVector3 before = qcMomentumOf(lower) + qcMomentumOf(upper) + box.getLinearVelocity();
    MaxPenetrating(world, 60);
    btVector3 after = qcMomentumOf(lower) + qcMomentumOf(upper) + box.getLinearVelocity();
    ck_assert(box.getLinearVelocity().y() < btScalar(-0.05));
    ck_assert((after - before).length() < btScalar(1e-3) * before.length());
    world.world.removeRigidBody(&box);
}

START_TEST(layers_that_land_on_a_free_box_keep_momentum)
{
    LandOnFreeBox(false);
    LandOnFreeBox(true);
}
END_TEST

START_TEST(cloths_that_the_broadphase_filters_do_not_touch)
{
    World world;
    AddSheet(world, btScalar(0.02), 0, 1, ~2);
    AddSheet(world, btScalar(0.10), btScalar(0.4), 2, ~1);
    for (int i = 0; i < 120; i++)
    {
        world.Step();
        ck_assert_int_eq(world.softSolver.getStatistics().contacts, 0);
    }
}
END_TEST

START_TEST(self_contacts_stand_in_manifolds_until_the_next_step)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(16);
    qcSoftBodySettings settings;
    settings.bulletNodeContacts = true; // contacts with the floor are not counted
    world.softSolver.setSettings(cloth, settings);
    int seen = 0;
    for (int i = 0; i < 120; i++)
    {
        world.Step();
        int points = 0;
        for (int m = 0; m < world.dispatcher.getNumManifolds(); m++)
        {
            const btPersistentManifold* manifold = world.dispatcher.getManifoldByIndexInternal(m);
            if (manifold->getBody0() != cloth || manifold->getBody1() != cloth)
                continue;
            for (int p = 0; p < manifold->getNumContacts(); p++, points++)
            {
                const btManifoldPoint& point = manifold->getContactPoint(p);
                ck_assert(std::abs(point.m_normalWorldOnB.length() - 1) < btScalar(1e-3));
                ck_assert(point.getDistance() <= 0);
                // The points are at the distance between surfaces plus the thickness.
                btScalar apart = (point.getPositionWorldOnA() - point.getPositionWorldOnB()).length();
                ck_assert(apart <= btScalar(0.01) + btScalar(1e-4));
            }
        }
        ck_assert_int_eq(points, world.softSolver.getStatistics().contacts);
        seen += points;
    }
    ck_assert_int_gt(seen, 100);
    // A body may be removed between two steps.
    world.world.removeSoftBody(cloth);
    world.cloths.clear();
    delete cloth;
    world.Step();
    ck_assert_int_eq(world.dispatcher.getNumManifolds(), 0);
}
END_TEST

START_TEST(a_node_that_is_not_finite_is_named_and_nothing_crashes)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(6);
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
    cloth->m_nodes[5].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
    cloth->m_nodes[5].m_v.setX(std::numeric_limits<btScalar>::quiet_NaN());
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusBadInput);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "of body 0 is not finite"));
}
END_TEST

/// Drops a cloth for some steps, removes the faces of its upper half, and goes on. What is tangled then may not grow.
void CheckTear(int stepsBefore)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(12);
    for (int i = 0; i < stepsBefore; i++)
        world.Step();
    int before = cloth->m_faces.size();
    for (int i = before - 1; i >= before / 2; i--)
    {
        cloth->m_faces.swap(i, cloth->m_faces.size() - 1);
        cloth->m_faces.pop_back();
    }
    // Links without faces are ropes. Those that cross faces are tangled at the start.
    world.Step();
    int tangled = world.softSolver.getStatistics().exempt;
    ck_assert_int_le(tangled, 2);
    for (int i = 0; i < 60; i++)
    {
        ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
        ck_assert_int_le(world.softSolver.getStatistics().remaining, tangled);
        tangled = world.softSolver.getStatistics().remaining;
        world.Step();
    }
}

START_TEST(a_changed_topology_collides)
{
    for (int stepsBefore : {48, 52, 56, 60, 64})
        CheckTear(stepsBefore);
}
END_TEST

START_TEST(faces_with_other_nodes_but_the_same_count_collide)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(12);
    world.Step();
    for (int i = 0; i + 1 < cloth->m_faces.size(); i += 2)
        for (int c = 0; c < 3; c++)
            std::swap(cloth->m_faces[i].m_n[c], cloth->m_faces[i + 1].m_n[c]);
    cloth->m_faces[0].m_n[0] = &cloth->m_nodes[cloth->m_nodes.size() - 1];
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
    ck_assert_uint_eq(size_t(world.softSolver.getStatistics().remaining), CountPenetrating(world));
}
END_TEST

START_TEST(settings_last_until_removal_and_may_be_given_before_the_body_is_added)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(4);
    qcSoftBodySettings settings;
    settings.friction = 7;
    world.softSolver.setSettings(cloth, settings);
    world.Step();
    ck_assert(world.softSolver.getSettings(cloth).friction == 7);
    // An address again, which a body allocated after another was deleted may have: added anew, it is another body.
    world.world.removeSoftBody(cloth);
    world.world.addSoftBody(cloth);
    ck_assert(world.softSolver.getSettings(cloth).friction != 7);
    world.Step();
    ck_assert(world.softSolver.getSettings(cloth).friction != 7);

    world.world.removeSoftBody(cloth);
    world.Step();
    world.softSolver.setSettings(cloth, settings);
    world.world.addSoftBody(cloth);
    world.Step();
    ck_assert(world.softSolver.getSettings(cloth).friction == 7);
}
END_TEST

/// How far a small sheet slides in half a second that is thrown along a floor at 3 m/s.
static btScalar SlideOf(btScalar setting, btScalar kDF, btScalar floorFriction)
{
    World world;
    world.AddMesh(qcFloorModel(8, 4), 0, btVector3(0, 1, 0))->setFriction(floorFriction);
    const btScalar y = btScalar(1.05), h = btScalar(0.25);
    btSoftBody* sheet =
        world.AddCloth(btVector3(-h, y, -h), btVector3(h, y, -h), btVector3(-h, y, h), btVector3(h, y, h), 8);
    sheet->m_cfg.kDF = kDF;
    sheet->setVelocity(btVector3(3, 0, 0));
    qcSoftBodySettings settings;
    settings.friction = setting;
    ck_assert_int_eq(world.softSolver.setSettings(sheet, settings), qc_statusOk);
    for (int step = 0; step < 60; step++)
        world.Step();
    return sheet->m_nodes[40].m_x.x();
}

START_TEST(friction_is_the_setting_or_that_of_bullet_where_the_application_has_set_it)
{
    const btScalar bullets = btScalar(0.2), rough = SlideOf(btScalar(0.3), bullets, btScalar(0.5));
    // By default as 0.3; a setting counts whatever kDF is.
    ck_assert(SlideOf(-1, bullets, btScalar(0.5)) == rough);
    ck_assert(SlideOf(btScalar(0.3), btScalar(0.02), btScalar(0.5)) == rough);
    // kDF counts if the application has set it, times the friction of the floor.
    const btScalar smooth = SlideOf(-1, btScalar(0.02), btScalar(0.5)),
                   half = SlideOf(-1, btScalar(0.8), btScalar(0.5));
    ck_assert_double_gt(double(smooth), 1.4);
    ck_assert_double_lt(double(rough), 1.2);
    ck_assert_double_eq_tol(double(half), double(rough), 0.05);
    ck_assert_double_eq_tol(double(SlideOf(-1, btScalar(0.4), 1)), double(half), 1e-6);
}
END_TEST

START_TEST(settings_that_make_no_sense_are_refused_and_change_nothing)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(4);
    qcSoftBodySettings settings;
    settings.thickness = btScalar(0.02);
    ck_assert_int_eq(world.softSolver.setSettings(cloth, settings), qc_statusOk);
    ck_assert_int_eq(world.softSolver.setSettings(nullptr, settings), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcSoftBodyContact::setSettings: body is null");
    for (btScalar value : {btScalar(-2), btScalar(-0.5), btScalar(NAN), btScalar(INFINITY)})
        for (btScalar qcSoftBodySettings::*field : {&qcSoftBodySettings::thickness, &qcSoftBodySettings::friction})
        {
            qcSoftBodySettings wrong = settings;
            wrong.*field = value;
            ck_assert_int_eq(world.softSolver.setSettings(cloth, wrong), qc_statusBadInput);
            ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "thickness or friction is "));
        }
    world.Step();
    ck_assert(world.softSolver.getSettings(cloth).thickness == settings.thickness);
    ck_assert(world.softSolver.getSettings(cloth).friction == settings.friction);
}
END_TEST

/// A small sheet that falls on a pinned one, whose nodes are all fixed but one corner.
START_TEST(a_face_with_one_free_corner_is_not_thrown_away)
{
    World world;
    btSoftBody* pinned =
        world.AddCloth(btVector3(-1, 1, -1), btVector3(1, 1, -1), btVector3(-1, 1, 1), btVector3(1, 1, 1), 1);
    for (int i = 0; i < 3; i++)
        pinned->setMass(i, 0);
    btScalar y = btScalar(1.03);
    world.AddCloth(btVector3(btScalar(-0.9), y, btScalar(-0.9)), btVector3(btScalar(-0.6), y, btScalar(-0.9)),
                   btVector3(btScalar(-0.9), y, btScalar(-0.6)), btVector3(btScalar(-0.6), y, btScalar(-0.6)), 4);
    int contacts = 0;
    for (int i = 0; i < 60; i++)
    {
        world.Step();
        contacts += world.softSolver.getStatistics().contacts;
        // It hangs from its neighbours by links; falling freely it would be at 5 m/s by now.
        for (int n = 0; n < pinned->m_nodes.size(); n++)
            ck_assert(pinned->m_nodes[n].m_v.length() < 8);
    }
    ck_assert_int_gt(contacts, 0);
}
END_TEST

START_TEST(a_body_that_is_not_simulated_stays_where_it_is_and_holds_others_up)
{
    World world;
    AddSheet(world, btScalar(0.30), 0, 1, -1);
    AddSheet(world, btScalar(0.34), btScalar(0.4), 1, -1);
    btSoftBody* lower = world.cloths[0];
    lower->forceActivationState(DISABLE_SIMULATION);
    std::vector<btVector3> before;
    for (int i = 0; i < lower->m_nodes.size(); i++)
        before.push_back(lower->m_nodes[i].m_x);
    ck_assert_uint_eq(MaxPenetrating(world, 60), 0);
    for (int i = 0; i < lower->m_nodes.size(); i++)
        ck_assert(lower->m_nodes[i].m_x == before[size_t(i)]);
    btVector3 low, high;
    world.cloths[1]->getAabb(low, high);
    ck_assert(high.y() > btScalar(0.30));
}
END_TEST

/// Manifolds whose end Bullet reported, and their bodies.
std::vector<const void*> s_ended;

void NoteOneEnded(btPersistentManifold* const& manifold)
{
    s_ended.push_back(manifold->getBody0());
}

START_TEST(no_callback_reports_the_end_of_contacts_of_a_removed_body)
{
    World world;
    btSoftBody* cloth = world.AddUprightCloth(16);
    for (int i = 0; i < 100 && world.softSolver.getStatistics().contacts == 0; i++)
        world.Step();
    ck_assert_int_gt(world.dispatcher.getNumManifolds(), 0);
    gContactEndedCallback = NoteOneEnded;
    world.Step();
    ck_assert_int_gt(world.dispatcher.getNumManifolds(), 0);
    world.world.removeSoftBody(cloth);
    world.cloths.clear();
    delete cloth;
    s_ended.clear();
    world.Step();
    ck_assert_uint_eq(s_ended.size(), 0);
    gContactEndedCallback = nullptr;
}
END_TEST

START_TEST(two_runs_agree_bit_by_bit_for_any_number_of_threads)
{
    std::vector<btVector3> expected;
    for (unsigned threads = 1; threads <= 3; threads++)
    {
        World world;
        btSoftBody* cloth = world.AddUprightCloth(14);
        world.softSolver.setThreadCount(threads);
        for (int i = 0; i < 100; i++)
            world.Step();
        for (int i = 0; i < cloth->m_nodes.size(); i++)
        {
            if (threads == 1)
                expected.push_back(cloth->m_nodes[i].m_x);
            ck_assert(expected[size_t(i)] == cloth->m_nodes[i].m_x);
        }
    }
}
END_TEST

/// A cloth that falls into folds on another one, for some steps; the positions after each.
std::vector<btVector3> Trail(World& world, qcMethod method, qcMethod answers, const char* device)
{
    world.AddUprightCloth(14);
    AddSheet(world, btScalar(0.02), 0, 1, -1);
    world.softSolver.setMethod(method);
    std::vector<btVector3> trail;
    int contacts = 0;
    for (int step = 0; step < 50; step++)
    {
        world.Step();
        const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
        ck_assert_int_eq(statistics.status, qc_statusOk);
        ck_assert_int_eq(statistics.method, answers);
        ck_assert_str_eq(statistics.device, device);
        ck_assert(statistics.cullMs + statistics.sweepMs + statistics.exactMs + statistics.contactMs <=
                  statistics.detectMs);
        ck_assert_double_gt(statistics.gatherMs, 0);
        contacts += statistics.contacts;
        for (const btSoftBody* cloth : world.cloths)
            for (int i = 0; i < cloth->m_nodes.size(); i++)
                trail.push_back(cloth->m_nodes[i].m_x);
    }
    ck_assert_int_gt(contacts, 500);
    return trail;
}

START_TEST(layers_simulates_what_sweep_does_bit_by_bit)
{
    World plain;
    const std::vector<btVector3> expected = Trail(plain, qc_methodSweep, qc_methodSweep, "none");
    ck_assert_ptr_null(plain.softSolver.getStatistics().fallback);
    QC_FOR_EACH_DEVICE(device)
    {
        qcDeviceInfo info;
        qcDevice_GetInfo(device, &info);
        if (!info.compute)
            continue;
        // One device for both.
        World world(device), other(device);
        other.AddUprightCloth(6);
        other.softSolver.setMethod(qc_methodLayers);
        other.Step();
        const std::vector<btVector3> trail = Trail(world, qc_methodLayers, qc_methodLayers, info.name);
        ck_assert_ptr_null(world.softSolver.getStatistics().fallback);
        ck_assert_uint_eq(trail.size(), expected.size());
        for (size_t i = 0; i < trail.size(); i++)
            ck_assert(trail[i] == expected[i]);
        other.Step();
        ck_assert_int_eq(other.softSolver.getStatistics().method, qc_methodLayers);
    }
}
END_TEST

START_TEST(layers_without_a_device_falls_back_and_reports_it)
{
    World world;
    Trail(world, qc_methodLayers, qc_methodSweep, "none");
    ck_assert_ptr_nonnull(world.softSolver.getStatistics().fallback);
    ck_assert_ptr_nonnull(std::strstr(world.softSolver.getStatistics().fallback, "sweep answered on the CPU"));
}
END_TEST

START_TEST(a_method_without_contacts_leaves_a_step_to_bullet)
{
    World world, plain;
    btSoftBody* cloth = world.AddUprightCloth(6);
    btSoftBody* same = plain.AddUprightCloth(6);
    qcSoftBodySettings settings;
    settings.selfCollision = false;
    settings.bulletNodeContacts = true;
    plain.softSolver.setSettings(same, settings);
    settings.selfCollision = true;
    world.softSolver.setSettings(cloth, settings);
    world.softSolver.setMethod(qc_methodQuick);
    for (int i = 0; i < 60; i++)
    {
        world.Step();
        plain.Step();
        ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusBadInput);
    }
    for (int i = 0; i < cloth->m_nodes.size(); i++)
        ck_assert(cloth->m_nodes[i].m_x == same->m_nodes[i].m_x);
    world.softSolver.setMethod(qc_methodAuto);
    world.Step();
    ck_assert_int_eq(world.softSolver.getStatistics().status, qc_statusOk);
}
END_TEST

START_TEST(all_memory_is_freed)
{
    QC_FOR_EACH_DEVICE(device)
    {
        World world(device);
        world.softSolver.setMethod(qc_methodLayers);
        world.AddUprightCloth(10);
        for (int i = 0; i < 40; i++)
            world.Step();
        ck_assert_uint_gt(qcGetByteCount(), 0);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_cloth_that_is_scaled_in_the_world_has_the_thickness_of_its_new_size)
{
    World world;
    const btScalar y = btScalar(0.1);
    btSoftBody* cloth =
        world.AddCloth(btVector3(-1, y, -1), btVector3(1, y, -1), btVector3(-1, y, 1), btVector3(1, y, 1), 12);
    cloth->getCollisionShape()->setMargin(btScalar(0.2));
    for (int i = 0; i < 60; i++)
        world.Step();
    cloth->scale(btVector3(btScalar(0.2), btScalar(0.2), btScalar(0.2)));
    cloth->translate(btVector3(0, btScalar(0.1), 0));
    for (int i = 0; i < 240; i++)
        world.Step();
    ck_assert_double_lt(double(qcSpeedOf(cloth)), 0.02);
    for (int i = 0; i < cloth->m_nodes.size(); i++)
    {
        ck_assert_double_lt(double(btFabs(cloth->m_nodes[i].m_x.x())), 0.22);
        ck_assert_double_lt(double(cloth->m_nodes[i].m_x.y()), 0.1);
    }
}
END_TEST

/// The highest mean speed of cloths that start closer to each other and to the floor than their thickness, without
/// gravity.
double SpeedOfShortGaps(btScalar step)
{
    World world;
    world.world.setGravity(btVector3(0, 0, 0));
    world.world.getWorldInfo().m_gravity.setZero();
    for (int layer = 1; layer <= 3; layer++)
    {
        btScalar y = btScalar(0.002) * btScalar(layer);
        world.AddCloth(btVector3(-1, y, -1), btVector3(1, y, -1), btVector3(-1, y, 1), btVector3(1, y, 1), 8);
    }
    double fastest = 0;
    for (int i = 0; i < 50; i++)
    {
        world.world.stepSimulation(step, 0);
        for (const btSoftBody* cloth : world.cloths)
            fastest = std::max(fastest, double(qcSpeedOf(cloth)));
    }
    return fastest;
}

START_TEST(cloths_that_start_closer_than_their_thickness_are_thrown_no_faster_in_short_steps)
{
    const double fastest = SpeedOfShortGaps(btScalar(1.0 / 60));
    ck_assert_double_lt(fastest, 0.4);
    for (btScalar step : {btScalar(1.0 / 240), btScalar(1.0 / 1000)})
        ck_assert_double_lt(SpeedOfShortGaps(step), 1.5 * fastest);
}
END_TEST
} // namespace

QC_RUN_TESTS("soft body", a_cloth_that_is_scaled_in_the_world_has_the_thickness_of_its_new_size,
             cloths_that_start_closer_than_their_thickness_are_thrown_no_faster_in_short_steps,
             a_falling_cloth_never_penetrates_itself, a_body_of_the_reduced_model_is_not_tested_with_itself,
             an_uneven_cloth_that_is_not_deformed_is_not_in_contact_with_itself,
             a_falling_cloth_penetrates_itself_without_self_collision, cloths_that_fall_on_each_other_stay_apart,
             cloths_that_the_broadphase_filters_do_not_touch, layers_that_land_on_a_free_box_keep_momentum,
             self_contacts_stand_in_manifolds_until_the_next_step,
             a_node_that_is_not_finite_is_named_and_nothing_crashes, a_changed_topology_collides,
             faces_with_other_nodes_but_the_same_count_collide,
             settings_last_until_removal_and_may_be_given_before_the_body_is_added,
             friction_is_the_setting_or_that_of_bullet_where_the_application_has_set_it,
             settings_that_make_no_sense_are_refused_and_change_nothing, a_face_with_one_free_corner_is_not_thrown_away,
             a_body_that_is_not_simulated_stays_where_it_is_and_holds_others_up,
             no_callback_reports_the_end_of_contacts_of_a_removed_body,
             two_runs_agree_bit_by_bit_for_any_number_of_threads, layers_simulates_what_sweep_does_bit_by_bit,
             layers_without_a_device_falls_back_and_reports_it, a_method_without_contacts_leaves_a_step_to_bullet,
             all_memory_is_freed)
