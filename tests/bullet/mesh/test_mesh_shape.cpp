// qcMeshShape by itself: Bullet's interface of a shape, compared with brute force, btBvhTriangleMeshShape and formulas.
#include "quickcullide/bullet.h"

#include "bullet/mesh/soup_model.h"

#include <BulletCollision/NarrowPhaseCollision/btRaycastCallback.h>
#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <limits>
#include <set>
#include <thread>
#include <cstring>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
btVector3 RandomPoint(qcRandom* random, double low, double high)
{
    double x = qcRandom_Uniform(random, low, high), y = qcRandom_Uniform(random, low, high);
    return btVector3(btScalar(x), btScalar(y), btScalar(qcRandom_Uniform(random, low, high)));
}

/// Collects reported triangles. Wrong corners and duplicates are failures.
struct Collector : btTriangleCallback
{
    const qcModel* model;
    std::set<int> triangles;

    explicit Collector(const qcModel* expected) : model(expected)
    {
    }

    void processTriangle(btVector3* corners, int part, int triangle) override
    {
        ck_assert_int_eq(part, 0);
        ck_assert(triangles.insert(triangle).second);
        for (uint32_t c = 0; c < 3; c++)
            ck_assert(corners[c] == model->Corner(uint32_t(triangle), c));
    }
};

bool BoxMeets(const qcModel& model, uint32_t triangle, const btVector3& lower, const btVector3& upper)
{
    btVector3 low = model.Corner(triangle, 0), high = low;
    for (uint32_t c = 1; c < 3; c++)
    {
        low.setMin(model.Corner(triangle, c));
        high.setMax(model.Corner(triangle, c));
    }
    return TestAabbAgainstAabb2(low, high, lower, upper);
}

START_TEST(a_box_query_reports_exactly_the_triangles_whose_boxes_overlap_it)
{
    const uint32_t counts[] = {0, 1, 7, 8, 9, 63, 64, 65, 513, 3000};
    qcRandom random = {1};
    for (uint32_t count : counts)
    {
        qcModel model = qcModelOf(qcSoup_MakeDegenerate(count, count, 0.1, 0.2));
        auto shape = model.MakeShape();
        for (int i = 0; i < 40; i++)
        {
            btVector3 lower = RandomPoint(&random, -0.2, 1.2), upper = RandomPoint(&random, -0.2, 1.2);
            lower.setMin(upper);
            upper = lower + RandomPoint(&random, 0, i < 20 ? 0.1 : 1);
            if (count > 0 && i == 0)
                lower = upper = model.Corner(count / 2, 1); // a point that touches
            if (i == 1)
            {
                upper = btVector3(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
                lower = -upper;
            }
            Collector collector(&model);
            shape->processAllTriangles(&collector, lower, upper);
            std::set<int> expected;
            for (uint32_t t = 0; t < count; t++)
                if (BoxMeets(model, t, lower, upper))
                    expected.insert(int(t));
            ck_assert(collector.triangles == expected);
        }
    }
}
END_TEST

START_TEST(every_triangle_with_a_point_below_a_plane_is_reported)
{
    qcModel model = qcModelOf(qcSoup_MakeRandom(3, 700, 0.1));
    auto shape = model.MakeShape();
    qcRandom random = {3};
    size_t left = 0;
    for (int i = 0; i < 50; i++)
    {
        btVector3 normal = RandomPoint(&random, -1, 1).normalized();
        btScalar distance = normal.dot(RandomPoint(&random, 0, 1));
        Collector collector(&model);
        shape->processTrianglesBelow(&collector, normal, distance);
        left += 700 - collector.triangles.size();
        for (uint32_t t = 0; t < 700; t++)
            for (uint32_t c = 0; c < 3; c++)
                if (normal.dot(model.Corner(t, c)) < distance - btScalar(1e-6))
                    ck_assert(collector.triangles.count(int(t)) == 1);
    }
    ck_assert_uint_gt(left, 50 * 100); // few others are visited
}
END_TEST

/// A model as a qcMeshShape and as a btBvhTriangleMeshShape, each in a world of its own, at equal transforms.
struct TwoWorlds
{
    struct World
    {
        btDefaultCollisionConfiguration configuration;
        btCollisionDispatcher dispatcher{&configuration};
        btDbvtBroadphase broadphase;
        btCollisionWorld world{&dispatcher, &broadphase, &configuration};
        btCollisionObject object;
    };

    qcModel model;
    std::unique_ptr<qcMeshShape> ours;
    std::unique_ptr<btTriangleIndexVertexArray> mesh;
    std::unique_ptr<btBvhTriangleMeshShape> bullets;
    World a, b;

    TwoWorlds(const qcModel& given, const btTransform& transform) : model(given)
    {
        ours = model.MakeShape(0);
        mesh = model.MakeInterface();
        bullets.reset(new btBvhTriangleMeshShape(mesh.get(), true));
        a.object.setCollisionShape(ours.get());
        b.object.setCollisionShape(bullets.get());
        for (World* world : {&a, &b})
        {
            world->object.setWorldTransform(transform);
            world->world.addCollisionObject(&world->object);
        }
    }

    ~TwoWorlds()
    {
        a.world.removeCollisionObject(&a.object);
        b.world.removeCollisionObject(&b.object);
    }
};

btTransform SomePlace()
{
    return btTransform(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(0.7)),
                       btVector3(btScalar(0.3), btScalar(-0.2), btScalar(0.5)));
}

/// All hits of a ray, sorted.
std::vector<std::pair<btScalar, int>> HitsOf(TwoWorlds::World& world, const btVector3& from, const btVector3& to)
{
    struct Callback : btCollisionWorld::RayResultCallback
    {
        std::vector<std::pair<btScalar, int>> hits;

        btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool) override
        {
            hits.emplace_back(result.m_hitFraction, result.m_localShapeInfo->m_triangleIndex);
            return m_closestHitFraction;
        }
    } callback;
    world.world.rayTest(from, to, callback);
    std::sort(callback.hits.begin(), callback.hits.end());
    return callback.hits;
}

START_TEST(rays_hit_what_they_hit_in_bullets_static_mesh)
{
    size_t hitCount = 0;
    for (int which = 0; which < 2; which++)
    {
        TwoWorlds worlds(which == 0 ? qcModelOf(qcSoup_MakeRandom(5, 2000, 0.3)) : qcSphereModel(0.5, 4), SomePlace());
        qcRandom random = {5};
        for (int i = 0; i < 500; i++)
        {
            btVector3 from = RandomPoint(&random, -2, 2), to = RandomPoint(&random, -2, 2);
            if (i % 5 == 0) // along an axis: a division by zero in a slab
            {
                to = from;
                to[i % 3] += 4;
            }
            auto hits = HitsOf(worlds.a, from, to), expected = HitsOf(worlds.b, from, to);
            ck_assert(hits == expected);
            hitCount += hits.size();
            btCollisionWorld::ClosestRayResultCallback closest(from, to), expectedClosest(from, to);
            worlds.a.world.rayTest(from, to, closest);
            worlds.b.world.rayTest(from, to, expectedClosest);
            ck_assert(closest.m_closestHitFraction == expectedClosest.m_closestHitFraction);
            ck_assert(hits.empty() || closest.m_closestHitFraction == hits[0].first);
        }
    }
    ck_assert_uint_gt(hitCount, 1000);
}
END_TEST

START_TEST(swept_shapes_hit_what_they_hit_in_bullets_static_mesh)
{
    TwoWorlds worlds(qcSphereModel(0.5, 3), SomePlace());
    qcRandom random = {7};
    btBoxShape box(btVector3(btScalar(0.1), btScalar(0.2), btScalar(0.15)));
    btSphereShape sphere(btScalar(0.2));
    int hits = 0;
    for (int i = 0; i < 200; i++)
    {
        btConvexShape* cast = i % 2 == 0 ? static_cast<btConvexShape*>(&box) : &sphere;
        btTransform from(btQuaternion(btScalar(i), 1, 2), RandomPoint(&random, -2, 2)), to = from;
        to.setOrigin(RandomPoint(&random, -1, 1));
        if (i % 4 == 0)
            to.setRotation(btQuaternion(2, btScalar(i), 1));
        btCollisionWorld::ClosestConvexResultCallback hit(from.getOrigin(), to.getOrigin()),
            expected(from.getOrigin(), to.getOrigin());
        worlds.a.world.convexSweepTest(cast, from, to, hit);
        worlds.b.world.convexSweepTest(cast, from, to, expected);
        // The order of triangles differs, and the iteration has a tolerance of 1e-3 of the way.
        ck_assert_double_eq_tol(double(hit.m_closestHitFraction), double(expected.m_closestHitFraction), 2e-3);
        hits += expected.hasHit();
    }
    ck_assert_int_gt(hits, 50);
}
END_TEST

/// Counts the triangles that a sweep receives.
struct CountingCast : btTriangleConvexcastCallback
{
    using btTriangleConvexcastCallback::btTriangleConvexcastCallback;
    int count = 0;

    void processTriangle(btVector3*, int, int) override
    {
        count++;
    }
    btScalar reportHit(const btVector3&, const btVector3&, btScalar, int, int) override
    {
        return 1;
    }
};

START_TEST(a_long_sweep_receives_the_triangles_along_its_way_only)
{
    // A terrain of 60 m: the box around the diagonal holds all of it.
    constexpr int cells = 120;
    std::vector<btVector3> points;
    std::vector<uint32_t> indices;
    for (int z = 0; z <= cells; z++)
        for (int x = 0; x <= cells; x++)
            points.emplace_back(btScalar(x) / 2, btSin(btScalar(x)) / 4, btScalar(z) / 2);
    for (uint32_t z = 0; z < cells; z++)
        for (uint32_t x = 0; x < cells; x++)
        {
            uint32_t a = z * (cells + 1) + x, b = a + cells + 1;
            indices.insert(indices.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    qcMeshShape shape(points.data(), qcBulletPositions, sizeof(btVector3), uint32_t(points.size()), indices.data(),
                      uint32_t(indices.size() / 3));
    btSphereShape ball(btScalar(0.2));
    btTransform place = SomePlace(), from = place, to = place;
    from.setOrigin(place * btVector3(0, 1, 0));
    to.setOrigin(place * btVector3(60, btScalar(-0.5), 60));
    CountingCast cast(&ball, from, to, place, 0);
    cast.m_hitFraction = 1;
    shape.processAllTriangles(&cast, btVector3(-1, -1, -1), btVector3(61, 2, 61));
    int along = cast.count;
    ck_assert_int_gt(along, cells);
    ck_assert_int_lt(along, 4 * cells);
    // What lies behind a hit is not visited.
    cast.count = 0;
    cast.m_hitFraction = btScalar(0.1);
    shape.processAllTriangles(&cast, btVector3(-1, -1, -1), btVector3(61, 2, 61));
    ck_assert_int_lt(cast.count, along / 4);
}
END_TEST

START_TEST(the_aabb_contains_every_vertex_and_the_margin)
{
    qcModel model = qcModelOf(qcSoup_MakeRandom(9, 300, 0.3));
    auto shape = model.MakeShape(btScalar(0.05));
    btVector3 lower, upper, low = model.Corner(0, 0), high = low;
    shape->getAabb(SomePlace(), lower, upper);
    btVector3 margin(btScalar(0.0499), btScalar(0.0499), btScalar(0.0499));
    for (uint32_t t = 0; t < 300; t++)
        for (uint32_t c = 0; c < 3; c++)
        {
            btVector3 p = SomePlace() * model.Corner(t, c);
            ck_assert(TestAabbAgainstAabb2(p - margin, p + margin, lower, upper));
            for (int axis = 0; axis < 3; axis++)
                ck_assert(p[axis] - margin[axis] >= lower[axis] && p[axis] + margin[axis] <= upper[axis]);
            low.setMin(model.Corner(t, c));
            high.setMax(model.Corner(t, c));
        }
    shape->getAabb(btTransform::getIdentity(), lower, upper);
    ck_assert_double_lt(double((low - lower).length()), 0.0867); // 0.05 in each axis
    ck_assert_double_lt(double((upper - high).length()), 0.0867);
}
END_TEST

void CheckVector(const btVector3& v, double x, double y, double z, double tolerance)
{
    ck_assert_double_eq_tol(double(v.x()), x, tolerance);
    ck_assert_double_eq_tol(double(v.y()), y, tolerance);
    ck_assert_double_eq_tol(double(v.z()), z, tolerance);
}

START_TEST(a_mesh_of_a_box_has_the_mass_properties_of_a_box)
{
    btVector3 half(btScalar(0.5), 1, btScalar(1.5));
    auto shape = qcBoxModel(half, 3).MakeShape();
    qcMassProperties mass = shape->getMassProperties();
    ck_assert(mass.closed);
    ck_assert_double_eq_tol(double(mass.volume), 6, 1e-5);
    ck_assert_double_eq_tol(double(mass.area), 22, 1e-5);
    CheckVector(mass.center, 0, 0, 0, 1e-6);
    btVector3 inertia, expected;
    shape->calculateLocalInertia(3, inertia);
    btBoxShape(half).calculateLocalInertia(3, expected);
    CheckVector(inertia, double(expected.x()), double(expected.y()), double(expected.z()), 1e-5);
}
END_TEST

START_TEST(a_fine_mesh_of_a_sphere_has_the_mass_properties_of_a_sphere)
{
    auto shape = qcSphereModel(2, 5).MakeShape();
    qcMassProperties mass = shape->getMassProperties();
    ck_assert(mass.closed);
    double volume = 4.0 / 3 * qcPi * 8;
    ck_assert_double_eq_tol(double(mass.volume), volume, 0.005 * volume);
    CheckVector(mass.principalInertia, 1.6, 1.6, 1.6, 0.008);
}
END_TEST

START_TEST(principal_axes_of_a_turned_and_moved_box_are_its_sides)
{
    btVector3 half(btScalar(0.5), 1, btScalar(1.5));
    qcModel model = qcBoxModel(half, 2);
    btTransform place(btQuaternion(btVector3(3, 1, 2).normalized(), btScalar(1.1)), btVector3(4, -5, 6));
    model.Move(place);
    qcMassProperties mass = model.MakeShape()->getMassProperties();
    CheckVector(mass.center, 4, -5, 6, 1e-4);
    // A box of mass 1, sides 1, 2, 3: (b^2 + c^2) / 12.
    double moments[3] = {double(mass.principalInertia.x()), double(mass.principalInertia.y()),
                         double(mass.principalInertia.z())};
    std::sort(moments, moments + 3);
    const double expected[3] = {5.0 / 12, 10.0 / 12, 13.0 / 12};
    for (int i = 0; i < 3; i++)
        ck_assert_double_eq_tol(moments[i], expected[i], 1e-4);
    ck_assert_double_eq_tol(double(mass.principalFrame.getBasis().determinant()), 1, 1e-5);
    // Moved back, the mesh has a diagonal tensor about its origin.
    model.Move(mass.principalFrame.inverse());
    qcMassProperties back = model.MakeShape()->getMassProperties();
    CheckVector(back.center, 0, 0, 0, 1e-5);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            ck_assert_double_eq_tol(double(back.inertia[i][j]), i == j ? double(mass.principalInertia[i]) : 0, 1e-4);
}
END_TEST

START_TEST(a_mesh_turned_inside_out_has_the_same_mass_properties)
{
    qcModel model = qcTorusModel(1, 0.4, 40, 30);
    qcMassProperties mass = model.MakeShape()->getMassProperties();
    for (size_t t = 0; t < model.indices.size(); t += 3)
        std::swap(model.indices[t], model.indices[t + 1]);
    qcMassProperties turned = model.MakeShape()->getMassProperties();
    ck_assert(mass.closed && turned.closed);
    double volume = 2 * qcPi * qcPi * 0.16;
    ck_assert_double_eq_tol(double(mass.volume), volume, 0.02 * volume);
    ck_assert_double_eq_tol(double(turned.volume), double(mass.volume), 1e-5);
    CheckVector(turned.principalInertia, double(mass.principalInertia.x()), double(mass.principalInertia.y()),
                double(mass.principalInertia.z()), 1e-5);
}
END_TEST

START_TEST(an_open_mesh_has_the_mass_properties_of_a_shell)
{
    qcModel sheet = qcFloorModel(1, 4); // a square of side 2: m (a^2) / 12 in its plane, twice that across
    qcMassProperties mass = sheet.MakeShape()->getMassProperties();
    ck_assert(!mass.closed);
    ck_assert(mass.volume == 0);
    ck_assert_double_eq_tol(double(mass.area), 4, 1e-5);
    CheckVector(mass.principalInertia, 1.0 / 3, 2.0 / 3, 1.0 / 3, 1e-5);
    // Closed, but without an inside: both sides of the sheet.
    size_t count = sheet.indices.size();
    for (size_t i = 0; i < count; i += 3)
        sheet.Add(sheet.indices[i], sheet.indices[i + 2], sheet.indices[i + 1]);
    mass = sheet.MakeShape()->getMassProperties();
    ck_assert(!mass.closed);
    CheckVector(mass.principalInertia, 1.0 / 3, 2.0 / 3, 1.0 / 3, 1e-5);
    // A box without one of its triangles.
    qcModel box = qcBoxModel(btVector3(1, 1, 1), 2);
    ck_assert(box.MakeShape()->getMassProperties().closed);
    box.indices.resize(box.indices.size() - 3);
    ck_assert(!box.MakeShape()->getMassProperties().closed);
}
END_TEST

START_TEST(a_scaled_shape_is_the_shape_of_the_scaled_mesh)
{
    qcModel model = qcSphereModel(0.5, 2);
    auto shape = model.MakeShape();
    uint64_t revision = shape->getRevision();
    shape->setLocalScaling(btVector3(7, 7, 7));
    shape->setLocalScaling(btVector3(1, 2, 3));
    ck_assert(shape->getLocalScaling() == btVector3(1, 2, 3));
    ck_assert(shape->getRevision() != revision);
    for (size_t i = 0; i < model.positions.size(); i++)
        model.positions[i] *= btScalar(1 + i % 3);
    Collector all(&model);
    btVector3 far(10, 10, 10);
    shape->processAllTriangles(&all, -far, far);
    ck_assert_uint_eq(all.triangles.size(), model.TriangleCount());
    auto expected = model.MakeShape();
    btVector3 lower, upper, expectedLower, expectedUpper;
    shape->getAabb(SomePlace(), lower, upper);
    expected->getAabb(SomePlace(), expectedLower, expectedUpper);
    ck_assert(lower == expectedLower && upper == expectedUpper);
    btVector3 inertia, expectedInertia;
    shape->calculateLocalInertia(2, inertia);
    expected->calculateLocalInertia(2, expectedInertia);
    ck_assert(inertia == expectedInertia);
}
END_TEST

START_TEST(scalings_and_margins_that_are_not_finite_are_refused_and_change_nothing)
{
    const qcModel model = qcBoxModel(btVector3(1, 2, 3), 1);
    const btScalar infinity = std::numeric_limits<btScalar>::infinity(),
                   nan = std::numeric_limits<btScalar>::quiet_NaN(), huge = std::numeric_limits<btScalar>::max();
    for (const btVector3& scaling : {btVector3(nan, 1, 1), btVector3(1, infinity, 1), btVector3(1, 1, huge)})
    {
        auto shape = model.MakeShape();
        shape->setLocalScaling(btVector3(1, 2, 1));
        const uint64_t revision = shape->getRevision();
        shape->setLocalScaling(scaling);
        ck_assert_int_eq(shape->getStatus(), qc_statusBadInput);
        ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "qcMeshShape::setLocalScaling: "));
        ck_assert(shape->getLocalScaling() == btVector3(1, 2, 1) && shape->getRevision() == revision);
        btVector3 lower, upper;
        shape->getAabb(btTransform::getIdentity(), lower, upper);
        const btScalar margin = shape->getMargin();
        ck_assert(upper == btVector3(1 + margin, 4 + margin, 3 + margin));
    }
    for (const btScalar wrong : {nan, infinity, btScalar(-0.1)})
    {
        auto shape = model.MakeShape();
        btCollisionShape* const base = shape.get();
        base->setMargin(btScalar(0.25));
        ck_assert_int_eq(shape->getStatus(), qc_statusOk);
        base->setMargin(wrong);
        ck_assert_int_eq(shape->getStatus(), qc_statusBadInput);
        ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "qcMeshShape::setMargin: "));
        ck_assert(shape->getMargin() == btScalar(0.25));
    }
}
END_TEST

START_TEST(arrays_that_can_not_be_read_are_refused)
{
    const btVector3 corners[3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint32_t indices[3] = {0, 1, 2};
    auto statusOf = [](const void* positions, size_t stride, const uint32_t* triangle)
    {
        qcMeshShape shape(positions, qcBulletPositions, stride, 3, triangle, 1);
        ck_assert_uint_eq(shape.getTriangleCount(), shape.getStatus() == qc_statusOk ? 1 : 0);
        return shape.getStatus();
    };
    ck_assert_int_eq(statusOf(corners, sizeof corners[0], indices), qc_statusOk);
    ck_assert_int_eq(statusOf(nullptr, sizeof corners[0], indices), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshShape: positions is null for 3 vertices");
    ck_assert_int_eq(statusOf(corners, sizeof corners[0], nullptr), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshShape: indices is null for 1 triangles");
    ck_assert_int_eq(statusOf(corners, 3 * sizeof(btScalar) - 1, indices), qc_statusBadInput);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "qcMeshShape: stride is "));
    ck_assert_int_eq(qcMeshShape(nullptr, qcBulletPositions, 0, 0, nullptr, 0).getStatus(), qc_statusOk);
    const btStridingMeshInterface* none = nullptr;
    ck_assert_int_eq(qcMeshShape(none).getStatus(), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshShape: mesh is null");
}
END_TEST

START_TEST(invalid_meshes_are_refused_and_empty)
{
    qcModel model = qcBoxModel(btVector3(1, 1, 1), 1);
    ck_assert_int_eq(model.MakeShape()->getStatus(), qc_statusOk);
    qcModel bad = model;
    bad.indices[5] = uint32_t(bad.positions.size() / 3);
    ck_assert_int_eq(bad.MakeShape()->getStatus(), qc_statusBadInput);
    ck_assert_ptr_nonnull(std::strstr(qcLastMessage(), "qcMeshShape: index 2 of triangle 1 is "));
    bad = model;
    bad.positions[7] = std::numeric_limits<btScalar>::quiet_NaN();
    auto shape = bad.MakeShape();
    ck_assert_int_eq(shape->getStatus(), qc_statusBadInput);
    ck_assert_str_eq(qcLastMessage(), "qcMeshShape: the position of vertex 2 is not finite");
    ck_assert_uint_eq(shape->getTriangleCount(), 0);
    Collector none(&model);
    btVector3 far(10, 10, 10), inertia;
    shape->processAllTriangles(&none, -far, far);
    shape->calculateLocalInertia(1, inertia);
    ck_assert(none.triangles.empty());
    ck_assert(inertia == btVector3(0, 0, 0));
}
END_TEST

START_TEST(positions_come_in_both_precisions_with_any_stride)
{
    qcModel model = qcSphereModel(1, 1);
    size_t count = model.positions.size() / 3;
    std::vector<char> narrow(count * 13 + 1), wide(count * 27 + 1);
    for (size_t v = 0; v < count; v++)
        for (size_t axis = 0; axis < 3; axis++)
        {
            // Deliberately unaligned.
            float f = float(model.positions[3 * v + axis]);
            double d = double(model.positions[3 * v + axis]);
            memcpy(&narrow[1 + 13 * v + 4 * axis], &f, 4);
            memcpy(&wide[1 + 27 * v + 8 * axis], &d, 8);
        }
    qcMeshShape a(&narrow[1], qc_positionF32, 13, uint32_t(count), model.indices.data(), model.TriangleCount());
    qcMeshShape b(&wide[1], qc_positionF64, 27, uint32_t(count), model.indices.data(), model.TriangleCount());
    for (size_t v = 0; v < count; v++)
        for (int axis = 0; axis < 3; axis++)
        {
            ck_assert(a.getVertices()[v][axis] == btScalar(float(model.positions[3 * v + size_t(axis)])));
            ck_assert(b.getVertices()[v][axis] == model.positions[3 * v + size_t(axis)]);
        }
}
END_TEST

START_TEST(a_mesh_interface_of_bullets_makes_the_same_shape)
{
    qcModel model = qcTorusModel(1, 0.3, 9, 7);
    auto mesh = model.MakeInterface();
    mesh->setScaling(btVector3(2, 2, 2));
    qcMeshShape shape(mesh.get());
    for (btScalar& x : model.positions)
        x *= 2;
    Collector all(&model);
    btVector3 far(10, 10, 10);
    shape.processAllTriangles(&all, -far, far);
    ck_assert_uint_eq(all.triangles.size(), model.TriangleCount());
}
END_TEST

START_TEST(the_margin_is_a_centimetre_or_a_quarter_of_an_edge)
{
    qcModel models[] = {qcFloorModel(1, 1), qcFloorModel(1, 200)}; // edges of 1 and, some of them, of its diagonal
    const double expected[] = {0.01, 0.01 * (2 + std::sqrt(2.0)) / 3 / 4};
    for (int i = 0; i < 2; i++)
    {
        qcModel& model = models[i];
        qcMeshShape shape(model.positions.data(), sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32,
                          0, uint32_t(model.positions.size() / 3), model.indices.data(), model.TriangleCount());
        ck_assert_double_eq_tol(double(shape.getMargin()), expected[i], 1e-6);
    }
}
END_TEST

START_TEST(the_first_queries_may_run_on_several_threads_at_once)
{
    qcModel model = qcSphereModel(1, 4);
    auto shape = model.MakeShape();
    std::vector<std::thread> threads;
    std::vector<std::unique_ptr<Collector>> collectors;
    for (int i = 0; i < 4; i++)
        collectors.emplace_back(new Collector(&model));
    btVector3 lower(0, -2, -2), upper(2, 2, 2);
    for (auto& collector : collectors)
        threads.emplace_back([&, to = collector.get()] { shape->processAllTriangles(to, lower, upper); });
    for (std::thread& thread : threads)
        thread.join();
    ck_assert_uint_gt(collectors[0]->triangles.size(), 1000);
    for (auto& collector : collectors)
        ck_assert(collector->triangles == collectors[0]->triangles);
}
END_TEST
} // namespace

QC_RUN_TESTS("mesh_shape", a_box_query_reports_exactly_the_triangles_whose_boxes_overlap_it,
             every_triangle_with_a_point_below_a_plane_is_reported, rays_hit_what_they_hit_in_bullets_static_mesh,
             swept_shapes_hit_what_they_hit_in_bullets_static_mesh,
             a_long_sweep_receives_the_triangles_along_its_way_only, the_aabb_contains_every_vertex_and_the_margin,
             a_mesh_of_a_box_has_the_mass_properties_of_a_box,
             a_fine_mesh_of_a_sphere_has_the_mass_properties_of_a_sphere,
             principal_axes_of_a_turned_and_moved_box_are_its_sides,
             a_mesh_turned_inside_out_has_the_same_mass_properties, an_open_mesh_has_the_mass_properties_of_a_shell,
             a_scaled_shape_is_the_shape_of_the_scaled_mesh,
             scalings_and_margins_that_are_not_finite_are_refused_and_change_nothing,
             arrays_that_can_not_be_read_are_refused, invalid_meshes_are_refused_and_empty,
             positions_come_in_both_precisions_with_any_stride, a_mesh_interface_of_bullets_makes_the_same_shape,
             the_margin_is_a_centimetre_or_a_quarter_of_an_edge, the_first_queries_may_run_on_several_threads_at_once)
