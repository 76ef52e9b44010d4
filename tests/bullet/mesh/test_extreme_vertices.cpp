// The extreme vertices of a mesh along a direction, bit for bit those that a pass over all vertices finds.
#include "common/extreme_vertices.h"

#include "bullet/random_numbers.h"

#include <numeric>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
enum Cloud
{
    cloud_random,
    cloud_line, ///< along an axis: each vertex is further than the one before
    cloud_grid, ///< flat: many are equally far
    cloud_ball,
    cloud_point, ///< all are one
    cloud_kinds
};

btVector3 PointOf(int kind, qcRandomNumbers* random, size_t i)
{
    switch (kind)
    {
        case cloud_line: return btVector3(btScalar(i), 0, 0);
        case cloud_grid: return btVector3(btScalar(i % 17), 1, btScalar(i / 17));
        case cloud_ball: return random->Vector(1).normalized();
        case cloud_point: return btVector3(1, -2, 3);
        default: return random->Vector(1);
    }
}

/// Rounded as qcExtremeVertices rounds it.
btScalar Product(const btVector3& a, const btVector3& b)
{
    const btScalar x[qcLaneCount] = {a.x()}, y[qcLaneCount] = {a.y()}, z[qcLaneCount] = {a.z()};
    return qcProducts{x, y, z, b.x(), b.y(), b.z()}.At(0)[0];
}

void CheckDirection(const qcExtremeVertices& vertices, const std::vector<btVector3>& points, const btVector3& direction)
{
    btScalar max = -BT_LARGE_FLOAT;
    for (const btVector3& point : points)
        max = std::max(max, Product(point, direction));
    const btScalar least = max - btScalar(0.1) * direction.length();
    uint32_t first = UINT32_MAX;
    std::vector<uint32_t> above, found;
    for (uint32_t i = 0; i < points.size(); i++)
    {
        const btScalar product = Product(points[i], direction);
        if (product >= max && first == UINT32_MAX)
            first = i;
        if (product >= least)
            above.push_back(i);
    }
    ck_assert(vertices.Max(direction) == max);
    ck_assert_uint_eq(vertices.FindMax(direction), first);
    vertices.AppendAbove(direction, least, &found);
    ck_assert(found == above);
    // All runs together have all vertices.
    std::vector<size_t> runs(vertices.RunCount());
    std::iota(runs.begin(), runs.end(), size_t(0));
    found.clear();
    vertices.AppendAboveInRuns(direction, least, runs, &found);
    ck_assert(found == above || runs.empty());
}

START_TEST(extreme_vertices_are_those_of_all_vertices)
{
    qcRandomNumbers random(7);
    for (size_t count : {1u, 2u, 7u, 8u, 9u, 63u, 64u, 65u, 127u, 128u, 129u, 300u, 1000u, 5000u})
    {
        std::vector<btVector3> points;
        for (size_t i = 0; i < count; i++)
            points.push_back(PointOf(_i, &random, i));
        const qcExtremeVertices vertices(points.data(), count);
        for (int axis = 0; axis < 3; axis++)
            for (int sign = -1; sign <= 1; sign++)
            {
                btVector3 direction(0, 0, 0);
                direction[axis] = btScalar(sign);
                CheckDirection(vertices, points, direction);
            }
        for (int i = 0; i < 100; i++)
            CheckDirection(vertices, points, random.Vector(1));
    }
}
END_TEST
} // namespace

QC_TEST_MAIN()
{
    TCase* tests = qcMakeCase("extreme_vertices");
    tcase_add_loop_test(tests, extreme_vertices_are_those_of_all_vertices, 0, cloud_kinds);
    return qcRunCase("extreme_vertices", tests);
}
