// The library's zones in Bullet's profiling: named, balanced and nested in the step, also when a query fails.
#include "quickcullide/bullet_deformable.h"

#include <BulletSoftBody/btDeformableGravityForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_world.h"
// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/mesh_world.h"

namespace
{
std::vector<const char*> s_open;                        ///< zones, outermost first
std::set<std::pair<std::string, std::string>> s_nested; ///< each entered zone, with "" and with each zone around it
bool s_broken;                                          ///< a zone was left more often than entered

bool IsOurs(const std::string& name)
{
    return name.compare(0, 2, "qc") == 0;
}

void Enter(const char* name)
{
    s_nested.emplace(name, "");
    for (const char* around : s_open)
        s_nested.emplace(name, around);
    s_open.push_back(name);
}

void Leave()
{
    s_broken = s_broken || s_open.empty();
    if (!s_open.empty())
        s_open.pop_back();
}

/// Restores Bullet's functions at its end.
struct Recording
{
    btEnterProfileZoneFunc* enter = btGetCurrentEnterProfileZoneFunc();
    btLeaveProfileZoneFunc* leave = btGetCurrentLeaveProfileZoneFunc();

    Recording()
    {
        s_open.clear();
        s_nested.clear();
        s_broken = false;
        btSetCustomEnterProfileZoneFunc(Enter);
        btSetCustomLeaveProfileZoneFunc(Leave);
    }

    ~Recording()
    {
        btSetCustomEnterProfileZoneFunc(enter);
        btSetCustomLeaveProfileZoneFunc(leave);
    }

    static void Check()
    {
        ck_assert(!s_broken && s_open.empty());
    }

    /// Checks that a zone was entered, and within the zone `around`.
    static void CheckZone(const std::string& zone, const std::string& around = "")
    {
        ck_assert_msg(s_nested.count({zone, around}) == 1, "no zone %s in %s", zone.c_str(), around.c_str());
    }

    static void CheckOursAreAmong(const std::set<std::string>& names)
    {
        for (const auto& zone : s_nested)
            ck_assert_msg(!IsOurs(zone.first) || names.count(zone.first) == 1, "%s", zone.first.c_str());
    }
};

START_TEST(a_broadphase_shows_its_search_and_its_pairs_where_something_moves)
{
    qcMeshWorld world;
    btCollisionShape* box = world.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, 1, 1))));
    world.Add(box, 0, btVector3(0, 0, 0));
    world.Add(box, 1, btVector3(0, 3, 0));
    Recording recording;
    world.Step(3);
    Recording::Check();
    Recording::CheckZone("qcBroadphase search", "calculateOverlappingPairs");
    Recording::CheckZone("qcBroadphase pairs", "calculateOverlappingPairs");
    Recording::CheckOursAreAmong({"qcBroadphase search", "qcBroadphase pairs"});
    world.world.removeRigidBody(world.bodies.back().get());
    world.bodies.pop_back();
    world.Step();
    s_nested.clear();
    world.Step();
    Recording::CheckOursAreAmong({});
}
END_TEST

const char* const s_meshZones[] = {"qcMeshContact gather", "qcMeshContact look ahead", "qcMeshContact detect"};

/// Two rings, each through the other: no plane separates them.
void AddRings(qcMeshWorld& world)
{
    btCollisionShape* ring = world.Keep(qcTorusModel(0.5, 0.1, 16, 8).MakeShape());
    world.Add(ring, 1, btVector3(3, 1, 0));
    world.Add(ring, 1, btTransform(btQuaternion(btVector3(1, 0, 0), SIMD_HALF_PI), btVector3(btScalar(3.5), 1, 0)));
}

START_TEST(mesh_contact_shows_its_stages_in_the_batch)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorOurs);
    world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.53), 0));
    AddRings(world);
    Recording recording;
    world.Step(10);
    Recording::Check();
    Recording::CheckZone("qcMeshContact batch", "dispatchAllCollisionPairs");
    for (const char* zone : s_meshZones)
        Recording::CheckZone(zone, "qcMeshContact batch");
    for (const char* stage : {"cull triangles", "sweep triangles", "exact", "manifolds"})
        Recording::CheckZone(std::string("qcScene ") + stage, "qcMeshContact detect");
    Recording::CheckZone("qcMeshContact manifolds", "dispatchAllCollisionPairs");
    Recording::CheckZone("qcMeshContact limit", "internalSingleStepSimulation");
}
END_TEST

START_TEST(a_pair_computed_alone_is_a_query)
{
    qcMeshWorld world;
    btRigidBody* a = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, 0, 0));
    btRigidBody* b = world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.9), 0));
    struct Nothing : btCollisionWorld::ContactResultCallback
    {
        btScalar addSingleResult(btManifoldPoint&, const btCollisionObjectWrapper*, int, int,
                                 const btCollisionObjectWrapper*, int, int) override
        {
            return 0;
        }
    } nothing;
    Recording recording;
    world.world.contactPairTest(a, b, nothing);
    ck_assert(s_open.empty());
    Recording::CheckZone("qcMeshContact query");
}
END_TEST

START_TEST(zones_are_left_when_a_query_of_meshes_fails)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorOurs);
    auto add = [&](btScalar height)
    { return world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, height, 0)); };
    btRigidBody* lower = add(btScalar(0.53));
    add(btScalar(1.55));
    AddRings(world);
    world.Step(3);
    btTransform nowhere = btTransform::getIdentity();
    nowhere.setOrigin(btVector3(0, std::numeric_limits<btScalar>::quiet_NaN(), 0));
    lower->setWorldTransform(nowhere);
    Recording recording;
    bool failed = false;
    for (int i = 0; i < 3; i++)
    {
        world.world.stepSimulation(qcStep, 0);
        failed = failed || world.contact.getStatistics().status != qc_statusOk;
    }
    ck_assert(failed);
    Recording::Check();
    for (const char* zone : s_meshZones)
        Recording::CheckZone(zone, "qcMeshContact batch");
}
END_TEST

btSoftBody* MakeZonesCloth(btSoftBodyWorldInfo& info, btScalar height)
{
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(info, btVector3(-1, height, -1), btVector3(1, height, -1),
                                       btVector3(-1, height, 1), btVector3(1, height, 1), 9, 9, 0, true);
    cloth->getCollisionShape()->setMargin(btScalar(0.05));
    return cloth;
}

void CheckSoftZones()
{
    Recording::Check();
    Recording::CheckZone("qcSoftBodyContact gather", "qcSoftBodyContact resolve");
    Recording::CheckZone("qcSoftBodyContact sweep", "qcSoftBodyContact resolve");
    Recording::CheckZone("qcSoftBodyContact round", "qcSoftBodyContact resolve");
    for (const char* zone : {"detect", "respond", "manifolds"})
        Recording::CheckZone(std::string("qcSoftBodyContact ") + zone, "qcSoftBodyContact round");
    for (const char* stage : {"cull triangles", "sweep triangles", "exact"})
        Recording::CheckZone(std::string("qcScene ") + stage, "qcSoftBodyContact detect");
    Recording::CheckZone("qcSoftBodyContact callbacks");
}

START_TEST(soft_bodies_show_detection_and_response_in_rounds)
{
    qcSoftWorld world;
    auto mesh = qcFloorModel(2, 4).MakeShape();
    btRigidBody floor(0, nullptr, mesh.get());
    world.world.addRigidBody(&floor);
    btSoftBody* cloth = MakeZonesCloth(world.world.getWorldInfo(), btScalar(0.05));
    world.world.addSoftBody(cloth);
    {
        Recording recording;
        for (int i = 0; i < 20; i++)
            world.world.stepSimulation(qcStep, 0);
        ck_assert_int_gt(world.softSolver.getStatistics().contacts, 0);
        CheckSoftZones();
        // A query that fails.
        cloth->m_nodes[5].m_x.setX(std::numeric_limits<btScalar>::quiet_NaN());
        s_nested.clear();
        world.world.stepSimulation(qcStep, 0);
        ck_assert_int_ne(world.softSolver.getStatistics().status, qc_statusOk);
        Recording::Check();
        Recording::CheckZone("qcSoftBodyContact gather");
    }
    world.world.removeSoftBody(cloth);
    delete cloth;
    world.world.removeRigidBody(&floor);
}
END_TEST

START_TEST(the_deformable_world_shows_detection_and_response_in_rounds)
{
    qcDeformableTestWorld<qcDeformableWorld> deformable;
    qcDeformableWorld& world = *deformable.world;
    world.setThreadCount(1);
    world.getWorldInfo().m_gravity = world.getGravity();
    auto mesh = qcFloorModel(2, 4).MakeShape();
    btRigidBody floor(0, nullptr, mesh.get());
    world.addRigidBody(&floor);
    btSoftBody* cloth = MakeZonesCloth(world.getWorldInfo(), btScalar(0.04));
    world.addSoftBody(cloth);
    btDeformableGravityForce gravity(world.getGravity());
    world.addForce(cloth, &gravity);
    {
        Recording recording;
        int contacts = 0;
        for (int i = 0; i < 60; i++)
        {
            world.stepSimulation(btScalar(1.0 / 240), 0);
            contacts += world.getStatistics().contacts;
        }
        ck_assert_int_gt(contacts, 0);
        CheckSoftZones();
    }
    world.removeSoftBody(cloth);
    delete cloth;
    world.removeRigidBody(&floor);
}
END_TEST
} // namespace

QC_RUN_TESTS("profile_zones", a_broadphase_shows_its_search_and_its_pairs_where_something_moves,
             mesh_contact_shows_its_stages_in_the_batch, a_pair_computed_alone_is_a_query,
             zones_are_left_when_a_query_of_meshes_fails, soft_bodies_show_detection_and_response_in_rounds,
             the_deformable_world_shows_detection_and_response_in_rounds)
