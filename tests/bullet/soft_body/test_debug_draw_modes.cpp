// qcDebugDraw: what each mode draws, in the classic and the deformable soft-body worlds, of meshes and with any
// broadphase; and that debugDrawWorld of an application draws it.
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <set>

#include "bullet/debug_recorder.h"
#include "bullet/soft_body/deformable_test_world.h"
#include "bullet/soft_body/soft_models.h"
#include "bullet/soft_body/soft_world.h"
// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/mesh_world.h"

namespace
{
const btVector3 s_redLine(1, 0, 0), s_orange(1, btScalar(0.55), 0), s_cyan(0, btScalar(0.8), 1);

size_t CountLines(const qcDebugRecorder& recorder, const btVector3& color)
{
    return size_t(std::count_if(recorder.lines.begin(), recorder.lines.end(),
                                [&](const qcDebugRecorder::Line& line) { return line.color == color; }));
}

/// A cube that lies on a mesh, after ten steps.
struct CubeOnMesh : qcMeshWorld
{
    btRigidBody* cube;

    CubeOnMesh()
    {
        qcAddFloor(*this, qc_floorOurs);
        cube = Add(Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.52), 0));
        Step(10);
    }
};

START_TEST(the_debug_drawing_of_an_application_shows_it_as_an_action)
{
    CubeOnMesh world;
    qcDebugRecorder recorder;
    recorder.mode = btIDebugDraw::DBG_DrawAabb;
    world.world.setDebugDrawer(&recorder);
    world.world.debugDrawWorld();
    ck_assert_uint_eq(recorder.triangles.size() + recorder.points.size(), 0);
    {
        qcDebugDraw drawing(&world.world);
        drawing.add(&world.contact);
        world.world.addAction(&drawing);
        world.world.debugDrawWorld();
        ck_assert_uint_gt(recorder.triangles.size(), 0);
        for (const qcDebugRecorder::Triangle& triangle : recorder.triangles)
            ck_assert(triangle.color == s_redLine);
        ck_assert_int_eq(recorder.points.size(), qcContactsOf(world.dispatcher).points);
        ck_assert_uint_gt(CountLines(recorder, s_cyan), 0);
        world.world.removeAction(&drawing);
    }
    recorder.Clear();
    world.world.debugDrawWorld();
    ck_assert_uint_eq(recorder.triangles.size(), 0);
}
END_TEST

START_TEST(each_mode_draws_its_own_and_nothing_else)
{
    CubeOnMesh world;
    qcDebugDraw drawing(&world.world, 0);
    drawing.add(&world.contact);
    qcDebugRecorder recorder;
    drawing.debugDraw(&recorder);
    ck_assert_uint_eq(
        recorder.triangles.size() + recorder.points.size() + recorder.lines.size() + recorder.boxes.size(), 0);
    drawing.setModes(qc_drawPcs);
    drawing.debugDraw(&recorder);
    ck_assert_uint_gt(recorder.triangles.size(), 0);
    ck_assert_uint_eq(recorder.points.size() + recorder.lines.size() + recorder.boxes.size(), 0);
    recorder.Clear();
    drawing.setModes(qc_drawContacts);
    drawing.debugDraw(&recorder);
    ck_assert_int_eq(recorder.points.size(), qcContactsOf(world.dispatcher).points);
    ck_assert_uint_eq(recorder.triangles.size() + recorder.lines.size() + recorder.boxes.size(), 0);
    recorder.Clear();
    drawing.setModes(qc_drawManifolds);
    drawing.debugDraw(&recorder);
    // Four points at the corners of the cube's bottom: its sides, not its diagonals.
    ck_assert_uint_eq(CountLines(recorder, s_cyan), 4);
    for (const qcDebugRecorder::Line& line : recorder.lines)
        ck_assert_double_eq_tol(double(line.from.distance(line.to)), 1, 0.05);
    ck_assert_uint_eq(recorder.triangles.size() + recorder.points.size() + recorder.boxes.size(), 0);
    recorder.Clear();
    drawing.setModes(qc_drawBoxes);
    drawing.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.boxes.size(), 2);
    ck_assert_uint_eq(recorder.lines.size(), 1);
    ck_assert_uint_eq(recorder.triangles.size() + recorder.points.size(), 0);
}
END_TEST

/// Centroids of all triangles, to the last bit.
std::set<std::array<btScalar, 3>> CentroidsOf(const btCollisionObject& object)
{
    const auto& mesh = *static_cast<const qcMeshShape*>(object.getCollisionShape());
    const btTransform& place = object.getWorldTransform();
    std::set<std::array<btScalar, 3>> centroids;
    for (uint32_t t = 0; t < mesh.getTriangleCount(); t++)
    {
        const uint32_t* index = mesh.getIndices() + 3 * size_t(t);
        const btVector3* v = mesh.getVertices();
        btVector3 middle = (place * v[index[0]] + place * v[index[1]] + place * v[index[2]]) / 3;
        centroids.insert({middle.x(), middle.y(), middle.z()});
    }
    return centroids;
}

START_TEST(candidate_pairs_of_meshes_join_centroids_from_the_next_step_on)
{
    CubeOnMesh world;
    qcDebugDraw drawing(&world.world, qc_drawCandidates);
    drawing.add(&world.contact);
    qcDebugRecorder recorder;
    drawing.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.lines.size(), 0);
    world.cube->translate(btVector3(btScalar(0.1), 0, 0));
    world.Step();
    drawing.debugDraw(&recorder);
    ck_assert_uint_gt(recorder.lines.size(), 0);
    ck_assert_uint_eq(CountLines(recorder, s_orange), recorder.lines.size());
    std::set<std::array<btScalar, 3>> floor = CentroidsOf(*world.bodies[0]), cube = CentroidsOf(*world.cube);
    for (const qcDebugRecorder::Line& line : recorder.lines)
    {
        ck_assert_uint_eq(floor.count({line.from.x(), line.from.y(), line.from.z()}), 1);
        ck_assert_uint_eq(cube.count({line.to.x(), line.to.y(), line.to.z()}), 1);
    }
    // Not requested any more: the next step reports none.
    drawing.setModes(qc_drawPcs);
    world.cube->translate(btVector3(btScalar(0.1), 0, 0));
    world.Step();
    recorder.Clear();
    world.contact.debugDraw(&recorder, qc_drawCandidates);
    ck_assert_uint_eq(recorder.lines.size(), 0);
}
END_TEST

btSoftBody* MakeCloth(btSoftBodyWorldInfo& info, btScalar height)
{
    btSoftBody* cloth =
        btSoftBodyHelpers::CreatePatch(info, btVector3(-1, height, -1), btVector3(1, height, -1),
                                       btVector3(-1, height, 1), btVector3(1, height, 1), 9, 9, 0, true);
    cloth->getCollisionShape()->setMargin(btScalar(0.05));
    return cloth;
}

/// Checks what was drawn of a cloth that lies on a mesh.
void CheckCloth(const qcDebugRecorder& recorder, const btSoftBody& cloth)
{
    ck_assert_uint_ge(recorder.triangles.size(), size_t(cloth.m_faces.size()) / 2);
    ck_assert_uint_gt(CountLines(recorder, s_orange), 0);
    ck_assert_uint_gt(recorder.points.size(), 0);
    btVector3 lower, upper;
    cloth.getAabb(lower, upper);
    for (const qcDebugRecorder::Line& line : recorder.lines)
        if (line.color == s_orange)
            ck_assert_double_le(double(line.from.distance(line.to)), 1.0);
}

START_TEST(a_soft_body_solver_draws_candidates_and_contacts)
{
    qcSoftWorld world;
    auto mesh = qcFloorModel(2, 8).MakeShape();
    btRigidBody floor(0, nullptr, mesh.get());
    world.world.addRigidBody(&floor);
    btSoftBody* cloth = MakeCloth(world.world.getWorldInfo(), btScalar(0.03));
    world.world.addSoftBody(cloth);
    {
        qcDebugDraw drawing(&world.world, qc_drawEverything);
        drawing.add(&world.softSolver);
        while (world.softSolver.getStatistics().contacts == 0)
            world.world.stepSimulation(qcStep, 0);
        qcDebugRecorder recorder;
        drawing.debugDraw(&recorder);
        CheckCloth(recorder, *cloth);
        ck_assert_uint_eq(recorder.boxes.size(), 2);
        // Planes and zones alone: none of these.
        recorder.Clear();
        drawing.setModes(qc_drawPlanes);
        drawing.debugDraw(&recorder);
        ck_assert_uint_eq(recorder.triangles.size() + recorder.points.size() + recorder.boxes.size(), 0);
        ck_assert_uint_eq(CountLines(recorder, s_orange), 0);
    }
    world.world.removeSoftBody(cloth);
    delete cloth;
    world.world.removeRigidBody(&floor);
}
END_TEST

START_TEST(the_deformable_world_draws_candidates_and_contacts)
{
    qcDeformableTestWorld<qcDeformableWorld> deformable;
    qcDeformableWorld& world = *deformable.world;
    world.getWorldInfo().m_gravity = world.getGravity();
    auto mesh = qcFloorModel(2, 8).MakeShape();
    btRigidBody floor(0, nullptr, mesh.get());
    world.addRigidBody(&floor);
    btSoftBody* cloth = MakeCloth(world.getWorldInfo(), btScalar(0.03));
    world.addSoftBody(cloth);
    btDeformableGravityForce gravity(world.getGravity());
    world.addForce(cloth, &gravity);
    {
        qcDebugDraw drawing(&world, qc_drawEverything);
        drawing.add(&world);
        for (int i = 0; i < 240 && world.getStatistics().contacts == 0; i++)
            world.stepSimulation(btScalar(1.0 / 240), 0);
        qcDebugRecorder recorder;
        drawing.debugDraw(&recorder);
        CheckCloth(recorder, *cloth);
    }
    world.removeSoftBody(cloth);
    delete cloth;
    world.removeRigidBody(&floor);
}
END_TEST

START_TEST(boxes_of_bullets_own_broadphase_are_drawn_too)
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher(&configuration);
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
    btBoxShape box(btVector3(1, 1, 1));
    btStaticPlaneShape ground(btVector3(0, 1, 0), 0);
    btRigidBody a(1, nullptr, &box), b(0, nullptr, &ground);
    world.addRigidBody(&a);
    world.addRigidBody(&b);
    world.stepSimulation(btScalar(1.0 / 60), 0);
    qcDebugDraw drawing(&world, qc_drawBoxes | qc_drawContacts | qc_drawManifolds);
    qcDebugRecorder recorder;
    drawing.debugDraw(&recorder);
    // The plane's box is without bounds.
    ck_assert_uint_eq(recorder.boxes.size(), 1);
    ck_assert_uint_gt(recorder.points.size(), 0);
    world.removeRigidBody(&a);
    world.removeRigidBody(&b);
}
END_TEST
} // namespace

QC_RUN_TESTS("debug_draw_modes", the_debug_drawing_of_an_application_shows_it_as_an_action,
             each_mode_draws_its_own_and_nothing_else, candidate_pairs_of_meshes_join_centroids_from_the_next_step_on,
             a_soft_body_solver_draws_candidates_and_contacts, the_deformable_world_draws_candidates_and_contacts,
             boxes_of_bullets_own_broadphase_are_drawn_too)
