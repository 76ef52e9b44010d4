// Planes between two small meshes, and contact points on both sides of them, beside exact distances of triangles.
#include "bullet/mesh/mesh_models.h"
#include "mesh_contact/planes/plane_contact.h"
#include "mesh_contact/planes/touching_faces.h"
#include "support/suite.h"

#include <check.h>

#include <random>

namespace
{
constexpr int s_runs = 300;

struct Placed
{
    std::unique_ptr<qcMeshShape> shape;
    std::unique_ptr<qcSupportMesh> mesh;
    qcPlacedSupport at;

    Placed(const qcModel& model, const btTransform& transform)
        : shape(model.MakeShape()), mesh(new qcSupportMesh(shape.get())), at{mesh.get(), transform}
    {
    }

    void Corners(uint32_t triangle, double corners[9]) const
    {
        for (uint32_t c = 0; c < 3; c++)
        {
            btVector3 p = at.VertexAt(shape->getIndices()[3 * triangle + c]);
            for (int axis = 0; axis < 3; axis++)
                corners[3 * c + uint32_t(axis)] = double(p[axis]);
        }
    }
};

/// The distance of two meshes by all pairs of triangles; 0: they intersect.
double GapOf(const Placed& a, const Placed& b)
{
    double least = 1e30;
    for (uint32_t i = 0; i < a.shape->getTriangleCount(); i++)
        for (uint32_t j = 0; j < b.shape->getTriangleCount(); j++)
        {
            double p[9], q[9];
            qcProximity proximity;
            a.Corners(i, p);
            b.Corners(j, q);
            if (qcTrianglesWithin(p, q, least, &proximity))
                least = std::min(least, proximity.distance);
        }
    return least;
}

/// The distance of a point from a mesh.
double DistanceFrom(const Placed& mesh, const btVector3& point)
{
    double least = 1e30;
    for (uint32_t i = 0; i < mesh.shape->getTriangleCount(); i++)
    {
        double p[9], q[9];
        qcProximity proximity;
        mesh.Corners(i, p);
        for (int k = 0; k < 9; k++)
            q[k] = double(point[k % 3]);
        if (qcTrianglesWithin(p, q, least, &proximity))
            least = proximity.distance;
    }
    return least;
}

std::mt19937 s_random(7);

btScalar RandomIn(btScalar low, btScalar high)
{
    return std::uniform_real_distribution<btScalar>(low, high)(s_random);
}

btTransform RandomPlace(btScalar extent)
{
    btQuaternion turn(RandomIn(-1, 1), RandomIn(-1, 1), RandomIn(-1, 1), RandomIn(-1, 1));
    return btTransform(turn.normalized(),
                       btVector3(RandomIn(-extent, extent), RandomIn(-extent, extent), RandomIn(-extent, extent)));
}

qcModel Box(btScalar x, btScalar y, btScalar z)
{
    return qcBoxModel(btVector3(x, y, z), 1);
}

START_TEST(the_gap_of_convex_meshes_is_their_distance)
{
    int apart = 0;
    for (int run = 0; run < s_runs; run++)
    {
        Placed a(Box(RandomIn(btScalar(0.1), 1), RandomIn(btScalar(0.1), 1), RandomIn(btScalar(0.1), 1)),
                 RandomPlace(1));
        Placed b(Box(btScalar(0.5), btScalar(0.5), btScalar(0.5)), RandomPlace(2));
        double distance = GapOf(a, b);
        qcSeparation found = qcFindSeparation(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT, 0);
        if (distance > 1e-3)
        {
            apart++;
            ck_assert_double_eq_tol(double(found.gap), distance, 1.1e-3 * distance + 1e-5);
            qcSeparation hulls = qcSeparateHulls(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT);
            ck_assert_double_eq_tol(double(hulls.gap), distance, 1.1e-3 * distance + 1e-5);
        }
        else if (distance == 0)
            ck_assert_double_lt(double(found.gap), 1e-5);
    }
    ck_assert_int_gt(apart, s_runs / 4);
}
END_TEST

START_TEST(no_axis_has_a_gap_beyond_the_distance)
{
    int apart = 0;
    for (int run = 0; run < s_runs / 10; run++)
    {
        Placed a(qcTorusModel(btScalar(0.5), btScalar(0.2), 8, 6), RandomPlace(btScalar(0.8)));
        Placed b(qcTorusModel(btScalar(0.5), btScalar(0.2), 8, 6), RandomPlace(btScalar(0.8)));
        double distance = GapOf(a, b), error = double(qcGapError(a.at, b.at));
        btVector3 axis = RandomPlace(1).getBasis()[0];
        ck_assert_double_le(double(qcGapAlong(a.at, b.at, axis)), distance + error);
        qcSeparation found = qcFindSeparation(a.at, b.at, axis, BT_LARGE_FLOAT, 0);
        ck_assert_double_le(double(found.gap), distance + error);
        apart += double(found.gap) > error;
    }
    ck_assert_int_gt(apart, 3);
}
END_TEST

/// A tetrahedron between an edge along x at height 0 and an edge along z at height `top`, moved by `aside`.
qcModel Tetrahedron(double top, double aside)
{
    qcModel model;
    model.Add(-1.0, 0.0, 0.0);
    model.Add(1.0, 0.0, 0.0);
    model.Add(aside, top, -1);
    model.Add(aside, top, 1);
    for (uint32_t i = 0; i < 4; i++)
        model.Add(i, (i + 1) % 4, (i + 2) % 4);
    return model;
}

START_TEST(bodies_that_meet_at_two_edges_have_a_plane_between_them)
{
    for (int run = 0; run < s_runs; run++)
    {
        // The edges cross at the origin. The meshes' own origins are elsewhere.
        btTransform place = RandomPlace(1);
        btVector3 aside(RandomIn(-1, 1), 2, RandomIn(-1, 1));
        qcModel low = Tetrahedron(-1, double(RandomIn(-1, 1))), high = Tetrahedron(1, double(RandomIn(-1, 1)));
        high.Move(btTransform(btQuaternion(btVector3(0, 1, 0), RandomIn(btScalar(0.8), btScalar(2.2)))));
        high.Move(btTransform(btQuaternion::getIdentity(), -aside));
        Placed a(low, place);
        Placed b(high, place * btTransform(btQuaternion::getIdentity(), aside));
        qcSeparation found = qcFindSeparation(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT, 0);
        ck_assert_double_gt(double(found.gap), -1e-4);
        ck_assert_double_gt(double(found.axis.dot(place.getBasis().getColumn(1))), 0.9);
    }
}
END_TEST

START_TEST(points_of_cubes_on_each_other_are_the_corners_of_the_common_area)
{
    const btVector3 half(btScalar(0.5), btScalar(0.5), btScalar(0.5));
    // Sides of one square, of 4 and of 400: few triangles next to a plane are compared all, many are sorted.
    for (auto [cellsA, cellsB] : {std::make_pair(1, 1), {2, 20}, {20, 2}, {20, 20}})
    {
        Placed a(qcBoxModel(half, cellsA), btTransform::getIdentity());
        Placed b(qcBoxModel(half, cellsB),
                 btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.3), btScalar(1.003), btScalar(0.2))));
        qcSeparation found = qcFindSeparation(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT, btScalar(1e-4));
        ck_assert_double_eq_tol(double(found.axis.y()), 1, 1e-5);
        std::vector<qcMeshPoint> points;
        qcPlaneContact contact;
        ck_assert(contact.Find(a.at, b.at, found, btScalar(0.01), true, &points));
        bool corners[2][2] = {};
        size_t verticesOfA = 0;
        for (const qcMeshPoint& point : points)
        {
            ck_assert_double_eq_tol(double(point.distance), 0.003, 1e-5);
            ck_assert_double_eq_tol(double(point.normal.y()), -1, 1e-5);
            ck_assert_double_eq_tol(double(point.onA.y()), 0.5, 1e-5);
            for (int x : {0, 1})
                for (int z : {0, 1})
                    if (btFabs(point.onA.x() - btScalar(x == 0 ? -0.2 : 0.5)) < btScalar(1e-4) &&
                        btFabs(point.onA.z() - btScalar(z == 0 ? -0.3 : 0.5)) < btScalar(1e-4))
                        corners[x][z] = true;
            auto isOnGrid = [cellsA = cellsA](btScalar x)
            { return btFabs(x * btScalar(cellsA) - std::round(x * btScalar(cellsA))) < btScalar(1e-3); };
            verticesOfA += isOnGrid(point.onA.x() + btScalar(0.5)) && isOnGrid(point.onA.z() + btScalar(0.5));
        }
        ck_assert(corners[0][0] && corners[0][1] && corners[1][0] && corners[1][1]);
        // Those that lie over the other cube: 0.7 by 0.8 of the side.
        ck_assert_uint_ge(verticesOfA, size_t(0.7 * cellsA) * size_t(0.8 * cellsA));
        // Too far apart.
        points.clear();
        ck_assert(!contact.Find(a.at, b.at, found, btScalar(0.002), false, &points));
        ck_assert(points.empty());
    }
}
END_TEST

START_TEST(corners_over_two_layers_have_points_on_the_nearer_one)
{
    // A box in a box, whose tops are 5 mm apart, and a cube 3 mm above both.
    qcModel layers = Box(btScalar(0.5), btScalar(0.5), btScalar(0.5)),
            inner = Box(btScalar(0.4), btScalar(0.495), btScalar(0.4));
    uint32_t first = uint32_t(layers.positions.size() / 3);
    layers.positions.insert(layers.positions.end(), inner.positions.begin(), inner.positions.end());
    for (uint32_t index : inner.indices)
        layers.indices.push_back(first + index);
    Placed below(layers, btTransform::getIdentity());
    Placed above(Box(btScalar(0.2), btScalar(0.2), btScalar(0.2)),
                 btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.05), btScalar(0.703), btScalar(0.02))));
    for (int way = 0; way < 2; way++)
    {
        const qcPlacedSupport &a = way == 0 ? below.at : above.at, &b = way == 0 ? above.at : below.at;
        qcSeparation found = qcFindSeparation(a, b, btVector3(0, 0, 0), BT_LARGE_FLOAT, btScalar(1e-4));
        std::vector<qcMeshPoint> points;
        qcPlaneContact contact;
        ck_assert(contact.Find(a, b, found, btScalar(0.01), false, &points));
        ck_assert_uint_ge(points.size(), 4);
        for (const qcMeshPoint& point : points)
            ck_assert_double_eq_tol(double(point.distance), 0.003, 1e-5);
    }
}
END_TEST

START_TEST(points_lie_on_both_meshes_and_one_is_where_they_are_nearest)
{
    int found = 0, unknown = 0;
    qcPlaneContact contact;
    for (int run = 0; run < s_runs; run++)
    {
        Placed a(Box(btScalar(0.5), btScalar(0.5), btScalar(0.5)), RandomPlace(btScalar(0.1)));
        Placed b(Box(RandomIn(btScalar(0.1), 1), RandomIn(btScalar(0.1), 1), RandomIn(btScalar(0.1), 1)),
                 RandomPlace(2));
        double distance = GapOf(a, b);
        qcSeparation separation = qcFindSeparation(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT, 0);
        if (distance < 1e-3)
            continue;
        std::vector<qcMeshPoint> points;
        // The closest points may lie on two triangles of one face: not known.
        if (!contact.Find(a.at, b.at, separation, separation.gap + btScalar(0.05), true, &points))
        {
            unknown++;
            continue;
        }
        found++;
        double nearest = 1e30;
        for (const qcMeshPoint& point : points)
        {
            ck_assert_double_lt(DistanceFrom(a, point.onA), 1e-4);
            ck_assert_double_lt(DistanceFrom(b, point.onB), 1e-4);
            nearest = std::min(nearest, double(point.distance));
        }
        ck_assert_double_eq_tol(nearest, distance, 2e-3 * distance + 1e-4);
    }
    ck_assert_int_gt(found, s_runs / 4);
    ck_assert_int_lt(10 * unknown, found);
}
END_TEST

/// Two boxes that have been cut from one at a random place, the second one moved along x and y.
struct CutBox
{
    btTransform place = RandomPlace(3);
    Placed a, b;

    CutBox(const btVector3& half, btScalar x, btScalar y)
        : a(Box(half.x(), half.y(), half.z()), place),
          b(Box(btScalar(0.3), half.y(), half.z()),
            place * btTransform(btQuaternion::getIdentity(), btVector3(half.x() + btScalar(0.3) + x, y, 0)))
    {
    }
};

btVector3 RandomHalf()
{
    return btVector3(RandomIn(btScalar(0.2), 1), RandomIn(btScalar(0.2), 1), RandomIn(btScalar(0.2), 1));
}

START_TEST(boxes_cut_from_one_touch_at_corners_of_the_cut)
{
    for (int run = 0; run < s_runs; run++)
    {
        btVector3 half = RandomHalf();
        CutBox cut(half, 0, 0);
        double error = double(qcGapError(cut.a.at, cut.b.at));
        qcSeparation found;
        ck_assert(qcFindTouchingFaces(cut.a.at, cut.b.at, &found));
        ck_assert_double_le(double(btFabs(found.gap)), error);
        ck_assert_double_gt(double(found.axis.dot(cut.place.getBasis().getColumn(0))), 0.9999);
        ck_assert(qcTouchAlong(cut.a.at, cut.b.at, found.axis));
        std::vector<qcMeshPoint> points;
        qcPlaneContact::AddTouching(cut.a.at, cut.b.at, found, &points);
        ck_assert_uint_eq(points.size(), 3);
        for (const qcMeshPoint& point : points)
        {
            ck_assert_double_lt(DistanceFrom(cut.a, point.onA), 1e-5);
            ck_assert_double_lt(DistanceFrom(cut.b, point.onB), 1e-5);
            ck_assert_double_lt(double(btFabs(point.distance)), 1e-5);
            ck_assert_double_lt(double(point.normal.dot(found.axis)), -0.9999);
        }
        // Half of the cut's area: three corners of a rectangle.
        btVector3 area = (points[1].onA - points[0].onA).cross(points[2].onA - points[0].onA);
        ck_assert_double_eq_tol(double(area.length()), double(4 * half.y() * half.z()), 1e-3);
    }
}
END_TEST

START_TEST(boxes_that_are_apart_overlap_or_have_no_common_corners_do_not_touch)
{
    const btScalar moves[][2] = {
        {btScalar(0.001), 0}, {btScalar(-0.001), 0}, {0, btScalar(0.1)}, {0, 5}, {btScalar(0.001), btScalar(0.1)}};
    for (int run = 0; run < s_runs; run++)
        for (const btScalar* move : moves)
        {
            CutBox cut(RandomHalf(), move[0], move[1]);
            qcSeparation found;
            ck_assert(!qcFindTouchingFaces(cut.a.at, cut.b.at, &found));
            ck_assert(!qcTouchAlong(cut.a.at, cut.b.at, cut.place.getBasis().getColumn(0)));
        }
}
END_TEST

START_TEST(a_body_in_the_mouth_of_another_has_no_points_in_the_air)
{
    // A U of three boxes, 1 m wide inside; a small cube in its mouth touches nothing.
    qcModel u = Box(1, btScalar(0.1), btScalar(0.3));
    for (int side : {-1, 1})
    {
        qcModel wall = Box(btScalar(0.1), btScalar(0.5), btScalar(0.3));
        wall.Move(
            btTransform(btQuaternion::getIdentity(), btVector3(btScalar(0.9) * btScalar(side), btScalar(0.6), 0)));
        uint32_t first = uint32_t(u.positions.size() / 3);
        u.positions.insert(u.positions.end(), wall.positions.begin(), wall.positions.end());
        for (uint32_t index : wall.indices)
            u.indices.push_back(first + index);
    }
    Placed a(u, btTransform::getIdentity());
    Placed b(Box(btScalar(0.1), btScalar(0.1), btScalar(0.1)),
             btTransform(btQuaternion(btVector3(0, 0, 1), btScalar(0.3)), btVector3(0, btScalar(1.25), 0)));
    qcSeparation found = qcFindSeparation(a.at, b.at, btVector3(0, 0, 0), BT_LARGE_FLOAT, btScalar(1e-4));
    ck_assert_double_gt(double(found.gap), 0);
    std::vector<qcMeshPoint> points;
    qcPlaneContact contact;
    ck_assert(!contact.Find(a.at, b.at, found, found.gap + btScalar(0.02), true, &points));
    ck_assert(points.empty());
}
END_TEST

START_TEST(all_edges_in_an_interval_are_found_once_with_their_corners)
{
    auto randomPoint = [](btScalar extent) { return qcFlat{RandomIn(0, extent), RandomIn(0, extent), RandomIn(0, 1)}; };
    qcFlatSimplices<2> edges;
    for (uint32_t run = 0; run < s_runs; run++)
    {
        std::vector<std::pair<qcFlat, qcFlat>> all;
        edges.Clear();
        for (uint32_t i = 0; i < run; i++)
        {
            // Every fourth one is long.
            qcFlat from = randomPoint(1), to = randomPoint(1);
            if (i % 4 != 0)
                to = {from.u + to.u / 20, from.v + to.v / 20, to.height};
            edges.Add({from, to}, 1000 + i);
            all.emplace_back(from, to);
            ck_assert(edges.CornerAt(i, 1).height == to.height);
        }
        edges.Sort();
        const btScalar low = RandomIn(0, 1), high = low + RandomIn(0, btScalar(0.1));
        std::vector<int> found(run);
        auto [block, end] = edges.FindBlocks(low, high);
        const size_t blocks = end - block;
        for (; block < end; block++)
            for (size_t lane = 0; lane < qcLaneCount && block * qcLaneCount + lane < run; lane++)
            {
                const uint32_t number = edges.NumberAt(block, lane);
                const auto& corners = edges.At(block);
                found[number]++;
                ck_assert_uint_eq(edges.TriangleOf(number), 1000 + number);
                ck_assert(corners.u[0][lane] == all[number].first.u && corners.v[1][lane] == all[number].second.v &&
                          corners.height[0][lane] == all[number].first.height);
            }
        for (uint32_t i = 0; i < run; i++)
        {
            auto [from, to] = std::minmax(all[i].first.u, all[i].second.u);
            ck_assert_int_le(found[i], 1);
            ck_assert(found[i] == 1 || from > high || to < low);
        }
        // Where edges are sorted, some are left out.
        ck_assert(run < 200 || low < btScalar(0.5) || blocks * qcLaneCount < run);
    }
}
END_TEST

START_TEST(faces_are_the_largest_sets_of_parallel_triangles)
{
    // A cut body has a few large flat faces and a skin of many directions.
    qcModel model = qcSphereModel(0.5, 4);
    model.Append(qcBoxModel(btVector3(1, btScalar(0.3), btScalar(0.6)), 12));
    Placed placed(model, btTransform::getIdentity());
    const qcSupportMesh& mesh = *placed.mesh;
    std::vector<std::pair<btVector3, btVector3>> sums; // the first normal of a face, and the sum of its areas
    for (uint32_t t = 0; t < mesh.Triangles().count; t++)
    {
        const uint32_t* index = mesh.Triangles().indices + 3 * size_t(t);
        const btVector3* points = mesh.Triangles().points;
        btVector3 cross = (points[index[1]] - points[index[0]]).cross(points[index[2]] - points[index[0]]);
        auto same =
            std::find_if(sums.rbegin(), sums.rend(),
                         [&](const auto& face) { return face.first.dot(mesh.Normals()[t]) > btScalar(0.99999); });
        if (same != sums.rend())
            same->second += cross;
        else
            sums.emplace_back(mesh.Normals()[t], cross);
    }
    std::stable_sort(sums.begin(), sums.end(),
                     [](const auto& a, const auto& b) { return a.second.length2() > b.second.length2(); });
    ck_assert_uint_gt(sums.size(), mesh.Faces().size());
    for (size_t i = 0; i < mesh.Faces().size(); i++)
        ck_assert(mesh.Faces()[i].normal == sums[i].second.normalized());
}
END_TEST
} // namespace

QC_RUN_TESTS("separating planes", the_gap_of_convex_meshes_is_their_distance, no_axis_has_a_gap_beyond_the_distance,
             bodies_that_meet_at_two_edges_have_a_plane_between_them,
             points_of_cubes_on_each_other_are_the_corners_of_the_common_area,
             corners_over_two_layers_have_points_on_the_nearer_one,
             points_lie_on_both_meshes_and_one_is_where_they_are_nearest,
             boxes_cut_from_one_touch_at_corners_of_the_cut,
             boxes_that_are_apart_overlap_or_have_no_common_corners_do_not_touch,
             a_body_in_the_mouth_of_another_has_no_points_in_the_air,
             all_edges_in_an_interval_are_found_once_with_their_corners,
             faces_are_the_largest_sets_of_parallel_triangles)
