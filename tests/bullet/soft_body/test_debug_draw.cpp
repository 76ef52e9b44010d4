// Debug drawing: Bullet's own debugDrawWorld of our shapes and manifolds, and debugDraw of our classes.
#include <BulletSoftBody/btSoftBodyHelpers.h>

#include <set>

#include "bullet/debug_recorder.h"
#include "bullet/soft_body/soft_models.h"
#include "bullet/soft_body/soft_world.h"
#include "bullet/soft_body/tangled_scenes.h"
// After the standard headers: check defines a macro named fail.
#include "bullet/mesh/mesh_world.h"

namespace
{
const btVector3 s_red(1, 0, 0), s_yellow(1, 1, 0), s_magenta(1, 0, 1);

/// Corners as numbers, to be compared to the last bit.
typedef std::array<btScalar, 9> Corners;

Corners CornersOf(const btVector3& a, const btVector3& b, const btVector3& c)
{
    return {a.x(), a.y(), a.z(), b.x(), b.y(), b.z(), c.x(), c.y(), c.z()};
}

/// The triangles of a mesh in world space.
std::vector<Corners> TrianglesOf(const qcMeshShape& mesh, const btTransform& place)
{
    std::vector<Corners> triangles;
    const uint32_t* index = mesh.getIndices();
    for (uint32_t t = 0; t < mesh.getTriangleCount(); t++, index += 3)
        triangles.push_back(CornersOf(place * mesh.getVertices()[index[0]], place * mesh.getVertices()[index[1]],
                                      place * mesh.getVertices()[index[2]]));
    return triangles;
}

std::vector<Corners> FacesOf(const btSoftBody* body)
{
    std::vector<Corners> triangles;
    for (int i = 0; i < body->m_faces.size(); i++)
    {
        btSoftBody::Node* const* n = body->m_faces[i].m_n;
        triangles.push_back(CornersOf(n[0]->m_x, n[1]->m_x, n[2]->m_x));
    }
    return triangles;
}

/// The count of recorded triangles among these. All must be red.
size_t CountDrawn(const qcDebugRecorder& recorder, const std::vector<Corners>& triangles)
{
    std::set<Corners> all(triangles.begin(), triangles.end());
    size_t count = 0;
    for (const qcDebugRecorder::Triangle& drawn : recorder.triangles)
    {
        ck_assert(drawn.color == s_red);
        count += all.count(CornersOf(drawn.corners[0], drawn.corners[1], drawn.corners[2]));
    }
    return count;
}

START_TEST(bullet_draws_each_triangle_of_a_mesh_and_its_box)
{
    qcMeshWorld world;
    btCollisionShape* shape = world.Keep(qcTorusModel(1, 0.3, 8, 6).MakeShape());
    shape->setLocalScaling(btVector3(1, 2, 3));
    btTransform place(btQuaternion(1, 2, 3, 4).normalized(), btVector3(4, 5, 6));
    world.Add(shape, 1, place);
    auto* compound = new btCompoundShape;
    world.Keep(std::unique_ptr<btCollisionShape>(compound));
    btTransform aside(btQuaternion(0, 0, 1, 2).normalized(), btVector3(1, 0, 0)),
        far(place.getBasis(), -btVector3(9, 9, 9));
    btCollisionShape* child = world.Keep(qcCubeModel().MakeShape());
    compound->addChildShape(aside, child);
    world.Add(compound, 1, far);
    qcDebugRecorder recorder;
    recorder.mode = btIDebugDraw::DBG_DrawWireframe | btIDebugDraw::DBG_DrawAabb;
    world.world.setDebugDrawer(&recorder);
    world.world.debugDrawWorld();
    std::vector<Corners> expected = TrianglesOf(*static_cast<qcMeshShape*>(shape), place);
    for (const Corners& corners : TrianglesOf(*static_cast<qcMeshShape*>(child), far * aside))
        expected.push_back(corners);
    ck_assert_uint_eq(recorder.triangles.size(), expected.size());
    std::vector<Corners> drawn;
    for (const qcDebugRecorder::Triangle& triangle : recorder.triangles)
        drawn.push_back(CornersOf(triangle.corners[0], triangle.corners[1], triangle.corners[2]));
    std::sort(expected.begin(), expected.end());
    std::sort(drawn.begin(), drawn.end());
    ck_assert(drawn == expected);
    ck_assert_uint_eq(recorder.boxes.size(), 2);
    btVector3 lower, upper, threshold(1, 1, 1);
    threshold *= gContactBreakingThreshold;
    shape->getAabb(place, lower, upper);
    ck_assert(recorder.boxes[0].lower == lower - threshold && recorder.boxes[0].upper == upper + threshold);
}
END_TEST

START_TEST(bullet_draws_the_contact_points_of_meshes_on_the_mesh_below)
{
    qcMeshWorld world;
    btScalar margin = qcAddFloor(world, qc_floorOurs);
    world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.52), 0));
    qcDebugRecorder recorder;
    recorder.mode = btIDebugDraw::DBG_DrawContactPoints;
    world.world.setDebugDrawer(&recorder);
    world.Step(10);
    world.world.debugDrawWorld();
    ck_assert_int_ge(recorder.points.size(), 4);
    ck_assert_int_eq(recorder.points.size(), qcContactsOf(world.dispatcher).points);
    for (const qcDebugRecorder::Point& point : recorder.points)
    {
        // The point lies on the surface of one mesh enlarged by its margin, with the normal towards the other.
        ck_assert_double_eq_tol(std::fabs(double(point.normal.y())), 1, 1e-4);
        ck_assert_double_eq_tol(double(point.onB.y()), double(margin), 2e-3);
        ck_assert_double_le(std::fabs(double(point.onB.x())), 0.5001);
        ck_assert_double_le(std::fabs(double(point.onB.z())), 0.5001);
    }
}
END_TEST

START_TEST(a_broadphase_draws_its_boxes_and_a_line_for_each_pair)
{
    qcMeshWorld world;
    btCollisionShape* box = world.Keep(std::unique_ptr<btCollisionShape>(new btBoxShape(btVector3(1, 1, 1))));
    for (btScalar x : {btScalar(0), btScalar(1.5), btScalar(9)})
        world.Add(box, 1, btVector3(x, 0, 0));
    world.world.performDiscreteCollisionDetection();
    qcDebugRecorder recorder;
    world.broadphase.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.boxes.size(), 3);
    for (size_t i = 0; i < 3; i++)
    {
        btVector3 lower, upper;
        world.broadphase.getAabb(world.bodies[i]->getBroadphaseHandle(), lower, upper);
        ck_assert(recorder.boxes[i].lower == lower && recorder.boxes[i].upper == upper);
        ck_assert(recorder.boxes[i].color == recorder.getDefaultColors().m_aabb);
    }
    ck_assert_uint_eq(recorder.lines.size(), 1);
    ck_assert(recorder.lines[0].color == recorder.getDefaultColors().m_contactPoint);
    ck_assert_double_eq_tol(double(recorder.lines[0].from.distance(recorder.lines[0].to)), 1.5, 1e-6);
    ck_assert_int_eq(recorder.flushes, 1);
    // Bounds that are not finite have no lines.
    const btScalar infinity = std::numeric_limits<btScalar>::infinity();
    btBroadphaseProxy* proxy = world.bodies[0]->getBroadphaseHandle();
    world.broadphase.setAabb(proxy, -btVector3(infinity, 1, 1), btVector3(infinity, 1, 1), &world.dispatcher);
    recorder.Clear();
    world.broadphase.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.boxes.size(), 2);
    ck_assert_uint_eq(recorder.lines.size(), 0);
}
END_TEST

/// Triangles of two models, by number, that come within a distance: by brute force.
std::set<std::pair<uint32_t, uint32_t>> NearTriangles(qcModel models[2], double distance)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    ck_assert_int_eq(qcScene_Create(&sceneDef, &scene), qc_statusOk);
    for (int i = 0; i < 2; i++)
    {
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = models[i].positions.data();
        def.positionType = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;
        def.vertexCount = uint32_t(models[i].positions.size() / 3);
        def.indices = models[i].indices.data();
        def.triangleCount = models[i].TriangleCount();
        def.selfCollision = false;
        qcBodyId id;
        ck_assert_int_eq(qcScene_AddBody(scene, &def, &id), qc_statusOk);
        ck_assert_uint_eq(id.slot, uint32_t(i));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodBrute;
    def.margin = distance;
    const qcResult* result = nullptr;
    ck_assert_int_eq(qcScene_Detect(scene, &def, &result), qc_statusOk);
    std::set<std::pair<uint32_t, uint32_t>> near;
    for (size_t i = 0; i < result->pairCount; i++)
    {
        near.emplace(0, result->pairs[i].triangleA);
        near.emplace(1, result->pairs[i].triangleB);
    }
    qcScene_Destroy(scene);
    return near;
}

START_TEST(candidate_triangles_of_meshes_are_drawn_in_red_where_the_bodies_are)
{
    for (int floor = 0; floor < qc_floorPlane; floor++)
    {
        qcMeshWorld world;
        btScalar margin = qcAddFloor(world, qcFloor(floor));
        btRigidBody* cube = world.Add(world.Keep(qcCubeModel().MakeShape()), 1,
                                      btVector3(btScalar(0.3), btScalar(0.51) + margin, btScalar(0.3)));
        world.world.performDiscreteCollisionDetection();
        qcDebugRecorder recorder;
        world.contact.debugDraw(&recorder);
        ck_assert_int_eq(recorder.flushes, 1);
        std::vector<Corners> cubes =
            TrianglesOf(*static_cast<qcMeshShape*>(cube->getCollisionShape()), cube->getWorldTransform());
        size_t ofCube = CountDrawn(recorder, cubes), ofFloor = recorder.triangles.size() - ofCube;
        // Triangles within the margins are candidates, triangles far from the other body are not. The cube's are its
        // bottom and the sides that meet it.
        qcModel models[2] = {qcCubeModel(), qcFloorModel(4, 8)};
        models[0].Move(cube->getWorldTransform());
        std::set<std::pair<uint32_t, uint32_t>> near = NearTriangles(models, double(margin) + 0.011);
        for (const auto& [body, triangle] : near)
            if (body == 0)
                ck_assert_uint_eq(CountDrawn(recorder, {cubes[triangle]}), 1);
        ck_assert_uint_ge(ofCube, 8);
        ck_assert_uint_ge(ofFloor, 2);
        ck_assert_uint_le(ofFloor, 8);
        for (const qcDebugRecorder::Triangle& drawn : recorder.triangles)
        {
            btVector3 lower = drawn.corners[0], upper = lower;
            for (const btVector3& corner : drawn.corners)
            {
                lower.setMin(corner);
                upper.setMax(corner);
            }
            ck_assert_double_le(double(lower.y()), 0.1);
            ck_assert(TestAabbAgainstAabb2(lower, upper, btVector3(btScalar(-0.3), -1, btScalar(-0.3)),
                                           btVector3(btScalar(0.9), 1, btScalar(0.9))));
        }
        // Drawn where the body is now; the triangles are those of the same batch.
        btTransform away(btQuaternion(0, 1, 1, 1).normalized(), btVector3(1, 2, 3));
        cube->setWorldTransform(away);
        size_t before = recorder.triangles.size();
        recorder.Clear();
        world.contact.debugDraw(&recorder);
        ck_assert_uint_eq(recorder.triangles.size(), before);
        ck_assert_uint_eq(
            CountDrawn(recorder, TrianglesOf(*static_cast<qcMeshShape*>(cube->getCollisionShape()), away)), ofCube);
    }
}
END_TEST

START_TEST(meshes_that_left_or_changed_are_not_drawn)
{
    qcMeshWorld world;
    qcAddFloor(world, qc_floorOurs);
    world.Add(world.Keep(qcCubeModel().MakeShape()), 1, btVector3(0, btScalar(0.52), 0));
    qcDebugRecorder recorder;
    world.contact.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.triangles.size(), 0); // no batch yet
    world.Step();
    world.contact.debugDraw(&recorder);
    size_t all = recorder.triangles.size();
    ck_assert_uint_gt(all, 0);
    world.bodies[0]->getCollisionShape()->setLocalScaling(btVector3(2, 1, 2));
    recorder.Clear();
    world.contact.debugDraw(&recorder);
    size_t ofCube = CountDrawn(recorder, TrianglesOf(*static_cast<qcMeshShape*>(world.shapes.back().get()),
                                                     world.bodies[1]->getWorldTransform()));
    ck_assert_uint_gt(ofCube, 0);
    ck_assert_uint_eq(recorder.triangles.size(), ofCube);
    world.world.removeRigidBody(world.bodies[1].get());
    world.bodies.pop_back();
    world.shapes.pop_back();
    recorder.Clear();
    world.contact.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.triangles.size(), 0);
}
END_TEST

/// A cloth that lies on a mesh.
struct ClothOnMesh : qcSoftWorld
{
    std::unique_ptr<qcMeshShape> mesh = qcFloorModel(2, 16).MakeShape();
    btRigidBody floor{0, nullptr, mesh.get()};
    btSoftBody* cloth;

    ClothOnMesh()
    {
        const btScalar y = btScalar(0.03), h = btScalar(0.5);
        world.addRigidBody(&floor);
        cloth = btSoftBodyHelpers::CreatePatch(world.getWorldInfo(), btVector3(-h, y, -h), btVector3(h, y, -h),
                                               btVector3(-h, y, h), btVector3(h, y, h), 9, 9, 0, true);
        cloth->getCollisionShape()->setMargin(btScalar(0.02));
        world.addSoftBody(cloth);
    }

    ~ClothOnMesh()
    {
        RemoveCloth();
        world.removeRigidBody(&floor);
    }

    void RemoveCloth()
    {
        if (cloth == nullptr)
            return;
        world.removeSoftBody(cloth);
        delete cloth;
        cloth = nullptr;
    }

    void StepToContact()
    {
        do
            world.stepSimulation(qcStep, 0);
        while (softSolver.getStatistics().contacts == 0);
    }
};

START_TEST(candidate_triangles_of_cloth_and_mesh_are_drawn_in_red)
{
    ClothOnMesh world;
    qcDebugRecorder recorder;
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.triangles.size(), 0);
    for (int i = 0; i < 5; i++)
        world.StepToContact();
    world.softSolver.debugDraw(&recorder);
    ck_assert_int_eq(recorder.flushes, 1);
    size_t ofCloth = CountDrawn(recorder, FacesOf(world.cloth));
    size_t ofMesh = CountDrawn(recorder, TrianglesOf(*world.mesh, world.floor.getWorldTransform()));
    ck_assert_uint_eq(ofCloth + ofMesh, recorder.triangles.size());
    ck_assert_uint_eq(recorder.lines.size(), 0);
    // All faces of the cloth lie on the mesh, over 4 by 4 of its 16 by 16 squares; one more row of squares is within
    // the contact distance.
    ck_assert_uint_eq(ofCloth, size_t(world.cloth->m_faces.size()));
    ck_assert_uint_ge(ofMesh, 32);
    ck_assert_uint_le(ofMesh, 72);
}
END_TEST

START_TEST(bullet_draws_the_contact_points_of_cloth_on_the_mesh)
{
    ClothOnMesh world;
    qcDebugRecorder recorder;
    recorder.mode = btIDebugDraw::DBG_DrawContactPoints;
    world.world.setDebugDrawer(&recorder);
    world.StepToContact();
    world.world.debugDrawWorld();
    ck_assert_int_gt(recorder.points.size(), 0);
    ck_assert_int_eq(recorder.points.size(), qcContactsOf(world.dispatcher).points);
    for (const qcDebugRecorder::Point& point : recorder.points)
    {
        ck_assert_double_eq_tol(double(point.onB.y()), 0, 1e-5);
        ck_assert_double_eq_tol(double(point.normal.y()), 1, 1e-4);
        ck_assert_double_le(std::fabs(double(point.onB.x())), 0.51);
    }
}
END_TEST

/// A rope of seven nodes just above a floor, drawn after the first step in which it is in contact; without links its
/// nodes are single.
static qcDebugRecorder DrawRope(bool links, std::vector<btVector3>* nodes)
{
    qcSoftWorld world;
    auto mesh = qcFloorModel(2, 4).MakeShape();
    btRigidBody floor(0, nullptr, mesh.get());
    world.world.addRigidBody(&floor);
    btSoftBody* rope = btSoftBodyHelpers::CreateRope(world.world.getWorldInfo(), btVector3(-1, btScalar(0.02), 0),
                                                     btVector3(1, btScalar(0.02), 0), 5, 0);
    if (!links)
        rope->m_links.clear();
    world.world.addSoftBody(rope);
    int contacts = 0;
    for (int i = 0; i < 30 && contacts == 0; i++)
    {
        world.world.stepSimulation(qcStep, 0);
        contacts = world.softSolver.getStatistics().contacts;
    }
    ck_assert_int_gt(contacts, 0);
    qcDebugRecorder recorder;
    world.softSolver.debugDraw(&recorder);
    for (int i = 0; i < rope->m_nodes.size(); i++)
        nodes->push_back(rope->m_nodes[i].m_x);
    world.world.removeSoftBody(rope);
    delete rope;
    world.world.removeRigidBody(&floor);
    ck_assert_uint_gt(recorder.triangles.size(), 0);
    for (const qcDebugRecorder::Line& line : recorder.lines)
        ck_assert(line.color == s_red);
    return recorder;
}

START_TEST(a_single_node_is_drawn_as_a_cross)
{
    std::vector<btVector3> nodes;
    qcDebugRecorder recorder = DrawRope(false, &nodes);
    ck_assert_uint_eq(recorder.lines.size(), 3 * nodes.size());
    for (size_t i = 0; i < recorder.lines.size(); i++)
    {
        btVector3 middle = (recorder.lines[i].from + recorder.lines[i].to) / 2;
        ck_assert_double_lt(double(middle.distance(nodes[i / 3])), 1e-6);
    }
}
END_TEST

START_TEST(a_rope_is_drawn_as_its_links)
{
    std::vector<btVector3> nodes;
    qcDebugRecorder recorder = DrawRope(true, &nodes);
    ck_assert_uint_eq(recorder.lines.size(), nodes.size() - 1);
    for (size_t i = 0; i < recorder.lines.size(); i++)
    {
        ck_assert(recorder.lines[i].from == nodes[i]);
        ck_assert(recorder.lines[i].to == nodes[i + 1]);
    }
}
END_TEST

START_TEST(soft_bodies_and_meshes_that_left_are_not_drawn)
{
    ClothOnMesh world;
    world.StepToContact();
    qcDebugRecorder recorder;
    auto replacement = qcFloorModel(2, 2).MakeShape();
    world.floor.setCollisionShape(replacement.get());
    world.mesh.reset();
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_gt(recorder.triangles.size(), 0);
    ck_assert_uint_eq(CountDrawn(recorder, FacesOf(world.cloth)), recorder.triangles.size());
    world.RemoveCloth();
    recorder.Clear();
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.triangles.size(), 0);
    world.mesh = std::move(replacement);
}
END_TEST

std::vector<qcDebugRecorder::Line> LinesOf(const qcDebugRecorder& recorder, const btVector3& color)
{
    std::vector<qcDebugRecorder::Line> lines;
    std::copy_if(recorder.lines.begin(), recorder.lines.end(), std::back_inserter(lines),
                 [&](const qcDebugRecorder::Line& line) { return line.color == color; });
    return lines;
}

START_TEST(planes_are_drawn_as_yellow_squares_with_normals_and_zone_nodes_as_magenta_crosses)
{
    qcTangledWorld world;
    qcMakeTouching(&world);
    qcDebugRecorder recorder;
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.lines.size(), 0);
    world.Step();
    const qcSoftBodyStatistics& statistics = world.softSolver.getStatistics();
    ck_assert_int_gt(statistics.planes, 10);
    ck_assert_int_gt(statistics.zoneNodes, 10);
    world.softSolver.debugDraw(&recorder);
    ck_assert_int_eq(recorder.flushes, 1);
    std::vector<qcDebugRecorder::Line> planes = LinesOf(recorder, s_yellow), zones = LinesOf(recorder, s_magenta);
    ck_assert_uint_eq(planes.size(), 5 * size_t(statistics.planes));
    ck_assert_uint_eq(zones.size(), 3 * size_t(statistics.zoneNodes));
    const double thickness = 0.01;
    for (size_t i = 0; i < planes.size(); i += 5)
    {
        btVector3 center = planes[i + 4].from, normal = planes[i + 4].to - center;
        // The cloths touch along the x axis.
        ck_assert_double_le(std::fabs(double(center.x())), 0.51);
        ck_assert_double_le(std::hypot(double(center.y()), double(center.z())), 0.01);
        ck_assert_double_eq_tol(double(normal.length()), thickness, 1e-6);
        for (size_t side = i; side < i + 4; side++)
        {
            ck_assert(planes[side].to == planes[side + 1 < i + 4 ? side + 1 : i].from);
            ck_assert_double_eq_tol(double(planes[side].to.distance(planes[side].from)), thickness, 1e-6);
            ck_assert_double_eq_tol(double(normal.dot(planes[side].from - center)), 0, 1e-8);
        }
    }
    std::vector<btVector3> nodes;
    for (const btSoftBody* cloth : world.cloths)
        for (int i = 0; i < cloth->m_nodes.size(); i++)
            nodes.push_back(cloth->m_nodes[i].m_x);
    for (const qcDebugRecorder::Line& line : zones)
    {
        btVector3 center = (line.from + line.to) / 2;
        ck_assert(std::any_of(nodes.begin(), nodes.end(),
                              [&](const btVector3& node) { return node.distance(center) < btScalar(1e-6); }));
    }
    // A body that has left takes its planes along.
    world.RemoveCloth();
    recorder.Clear();
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_eq(LinesOf(recorder, s_yellow).size(), 0);
    // A step without planes has none.
    world.Step();
    recorder.Clear();
    world.softSolver.debugDraw(&recorder);
    ck_assert_uint_eq(recorder.lines.size(), 0);
}
END_TEST

START_TEST(drawing_changes_nothing_in_the_simulation)
{
    ClothOnMesh drawn, plain;
    qcMeshWorld drawnMeshes, plainMeshes;
    for (qcMeshWorld* world : {&drawnMeshes, &plainMeshes})
    {
        qcAddFloor(*world, qc_floorOurs);
        for (int i = 0; i < 3; i++)
            world->Add(world->Keep(qcCubeModel().MakeShape()), 1,
                       btVector3(0, btScalar(0.6 + 1.1 * i), btScalar(0.1 * i)));
    }
    qcDebugRecorder recorder;
    for (int i = 0; i < 60; i++)
    {
        for (ClothOnMesh* world : {&drawn, &plain})
            world->world.stepSimulation(qcStep, 0);
        drawnMeshes.Step();
        plainMeshes.Step();
        drawn.softSolver.debugDraw(&recorder);
        drawn.broadphase.debugDraw(&recorder);
        drawnMeshes.contact.debugDraw(&recorder);
        drawnMeshes.broadphase.debugDraw(&recorder);
    }
    ck_assert_uint_gt(recorder.triangles.size(), 1000);
    for (size_t i = 0; i < drawnMeshes.bodies.size(); i++)
        ck_assert(drawnMeshes.bodies[i]->getWorldTransform() == plainMeshes.bodies[i]->getWorldTransform());
    for (int i = 0; i < drawn.cloth->m_nodes.size(); i++)
        ck_assert(drawn.cloth->m_nodes[i].m_x == plain.cloth->m_nodes[i].m_x);
    ck_assert_uint_eq(drawnMeshes.contact.getStatistics().batches, plainMeshes.contact.getStatistics().batches);
}
END_TEST
} // namespace

QC_RUN_TESTS("debug_draw", bullet_draws_each_triangle_of_a_mesh_and_its_box,
             bullet_draws_the_contact_points_of_meshes_on_the_mesh_below,
             a_broadphase_draws_its_boxes_and_a_line_for_each_pair,
             candidate_triangles_of_meshes_are_drawn_in_red_where_the_bodies_are,
             meshes_that_left_or_changed_are_not_drawn, candidate_triangles_of_cloth_and_mesh_are_drawn_in_red,
             bullet_draws_the_contact_points_of_cloth_on_the_mesh, a_single_node_is_drawn_as_a_cross,
             a_rope_is_drawn_as_its_links, soft_bodies_and_meshes_that_left_are_not_drawn,
             planes_are_drawn_as_yellow_squares_with_normals_and_zone_nodes_as_magenta_crosses,
             drawing_changes_nothing_in_the_simulation)
