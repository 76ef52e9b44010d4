// The points of a pair that are kept for Bullet's manifold: the deepest one, and those that carry the body.
#include "mesh_contact/points/contact_reduction.h"
#include "support/suite.h"

#include <algorithm>

namespace
{
constexpr qcReductionDef s_def{btScalar(0.02), btScalar(0.01)};

/// A point on a floor, under a body.
qcMeshPoint PointAt(btScalar x, btScalar z, btScalar distance)
{
    qcMeshPoint point;
    point.onB = btVector3(x, 0, z);
    point.onA = btVector3(x, distance, z);
    point.normal = btVector3(0, 1, 0);
    point.distance = distance;
    return point;
}

/// The corners of a square of 1 m that hover by a millimetre, and a point in its middle.
std::vector<qcMeshPoint> SquareWithMiddle(btScalar middle)
{
    std::vector<qcMeshPoint> points = {PointAt(0, 0, middle)};
    for (btScalar x : {btScalar(-0.5), btScalar(0.5)})
        for (btScalar z : {btScalar(-0.5), btScalar(0.5)})
            points.push_back(PointAt(x, z, btScalar(0.001)));
    return points;
}

int CountCorners(const qcPointGroup& group)
{
    return int(std::count_if(group.points, group.points + group.count,
                             [](const qcMeshPoint* point) { return btFabs(point->onB.x()) > btScalar(0.4); }));
}
} // namespace

START_TEST(four_corners_carry_a_body_and_not_three_and_a_middle_that_is_hardly_deeper)
{
    std::vector<qcMeshPoint> points = SquareWithMiddle(0);
    qcPointGroup group;
    ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
    ck_assert_int_eq(group.count, 4);
    ck_assert_int_eq(CountCorners(group), 4);
}
END_TEST

START_TEST(a_deep_point_is_kept_wherever_it_is)
{
    std::vector<qcMeshPoint> points = SquareWithMiddle(btScalar(-0.01));
    qcPointGroup group;
    ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
    ck_assert_int_eq(group.count, 4);
    ck_assert_int_eq(CountCorners(group), 3);
    ck_assert_double_eq_tol(double(group.points[0]->distance), -0.01, 1e-6);
}
END_TEST

START_TEST(the_first_point_that_a_fast_body_reaches_is_kept)
{
    // The foot of a ball that falls by 0.1 in the step, between rings of points that it reaches, too.
    std::vector<qcMeshPoint> points;
    for (btScalar ring : {btScalar(0.2), btScalar(0.1), btScalar(0)})
        for (int quarter = 0; quarter < 4; quarter++)
        {
            btScalar angle = SIMD_HALF_PI * btScalar(quarter);
            points.push_back(PointAt(ring * btCos(angle), ring * btSin(angle), btScalar(0.05) + ring * ring));
        }
    for (qcMeshPoint& point : points)
        point.endDistance = point.distance - btScalar(0.1);
    qcPointGroup group;
    ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
    ck_assert_double_eq_tol(double(group.points[0]->distance), 0.05, 1e-6);
}
END_TEST

START_TEST(a_wide_point_at_the_contact_distance_does_not_replace_one_that_carries)
{
    // Three points carry; a fourth one is near them, another one far away, but hardly in contact.
    std::vector<qcMeshPoint> points = {PointAt(0, 0, 0), PointAt(1, 0, 0), PointAt(0, 1, 0), PointAt(1, 1, 0),
                                       PointAt(-5, -5, btScalar(0.0199))};
    qcPointGroup group;
    ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
    ck_assert_int_eq(group.count, 4);
    for (int i = 0; i < group.count; i++)
        ck_assert_double_eq(double(group.points[i]->distance), 0);
}
END_TEST

START_TEST(points_of_the_previous_step_are_preferred_to_equal_ones)
{
    // A ring of 16 equal points, four of which are known.
    for (int shift = 0; shift < 4; shift++)
    {
        std::vector<qcMeshPoint> points;
        for (int i = 0; i < 16; i++)
        {
            btScalar angle = SIMD_2_PI * btScalar(i) / 16;
            points.push_back(PointAt(btCos(angle), btSin(angle), 0));
            points.back().isKnown = i % 4 == shift;
        }
        qcPointGroup group;
        ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
        ck_assert_int_eq(group.count, 4);
        for (int i = 0; i < 4; i++)
            ck_assert(group.points[i]->isKnown);
    }
}
END_TEST

START_TEST(of_two_points_that_a_fast_body_reaches_the_nearer_one_is_kept)
{
    // Too close to each other for both. The nearer one is within the contact distance.
    std::vector<qcMeshPoint> points = {PointAt(0, 0, btScalar(0.035)), PointAt(btScalar(0.005), 0, btScalar(0.019))};
    for (qcMeshPoint& point : points)
        point.endDistance = point.distance - btScalar(0.03);
    qcPointGroup group;
    ck_assert_int_eq(qcGroupPoints(points, s_def, &group), 1);
    ck_assert_int_eq(group.count, 1);
    ck_assert_double_eq_tol(double(group.points[0]->distance), 0.019, 1e-6);
}
END_TEST

START_TEST(a_fast_body_is_stopped_at_all_points_that_it_reaches)
{
    for (btScalar closing : {btScalar(0.004), btScalar(0.02)})
        for (bool keepsReached : {false, true})
        {
            std::vector<qcMeshPoint> points;
            for (int i = 0; i < 12; i++)
            {
                btScalar angle = SIMD_2_PI * btScalar(i) / 12;
                points.push_back(PointAt(btCos(angle), btSin(angle), btScalar(0.03)));
                points.back().endDistance = points.back().distance - closing;
            }
            qcReductionDef def = s_def;
            def.maxGroups = 4;
            def.keepsReached = keepsReached;
            qcPointGroup groups[4];
            const int count = qcGroupPoints(points, def, groups);
            const bool all = keepsReached && 2 * closing > points[0].distance;
            ck_assert_int_eq(count, all ? 3 : 1);
            std::vector<const qcMeshPoint*> kept;
            for (int g = 0; g < count; g++)
                kept.insert(kept.end(), groups[g].points, groups[g].points + groups[g].count);
            std::sort(kept.begin(), kept.end());
            ck_assert(std::unique(kept.begin(), kept.end()) == kept.end());
            ck_assert_uint_eq(kept.size(), all ? points.size() : 4);
        }
}
END_TEST

QC_RUN_TESTS("contact reduction", four_corners_carry_a_body_and_not_three_and_a_middle_that_is_hardly_deeper,
             a_deep_point_is_kept_wherever_it_is, the_first_point_that_a_fast_body_reaches_is_kept,
             a_wide_point_at_the_contact_distance_does_not_replace_one_that_carries,
             points_of_the_previous_step_are_preferred_to_equal_ones,
             of_two_points_that_a_fast_body_reaches_the_nearer_one_is_kept,
             a_fast_body_is_stopped_at_all_points_that_it_reaches)
