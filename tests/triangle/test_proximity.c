// Closest points, distance, normal and depth of two triangles, against examples and rational arithmetic.
// QC_TEST_PAIRS in the environment raises the number of generated pairs.
#include "triangle/exact.h"
#include "triangle/pair_claims.h"
#include "triangle/proximity.h"
#include "support/suite.h"

#include <check.h>
#include <float.h>
#include <math.h>
#include <string.h>

static qcProximity Find(const double a[3][3], const double b[3][3])
{
    qcRelation relation = qcExact_Relate(a, b, NULL);
    qcProximity p;
    qcClosestFeatures features;
    qcProximity_Of(a, b, relation, &p, &features);
    return p;
}

//  ---- by example ----------------------------------------------------------------------------------------

typedef struct Example
{
    const char* name;
    const double (*a)[3];
    double b[3][3];
    double pointA[3], pointB[3], normal[3], distance, depth;
} Example;

static const double s_face[3][3] = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
static const double s_segment[3][3] = {{0, 0, 0}, {8, 0, 0}, {8, 0, 0}};
static const double s_point[3][3] = {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}};

static const Example s_examples[] = {
    {"a_vertex_under_a_face", s_face, {{1, 1, -5}, {9, 1, -9}, {1, 9, -8}}, {1, 1, 0}, {1, 1, -5}, {0, 0, 1}, 5, 0},
    {"a_vertex_beside_an_edge",
     s_face,
     {{4, -3, 4}, {5, -9, 4}, {4, -3, 9}},
     {4, 0, 0},
     {4, -3, 4},
     {0, 0.6, -0.8},
     5,
     0},
    {"skew_segments", s_segment, {{4, -4, 2}, {4, 4, 2}, {4, 4, 2}}, {4, 0, 0}, {4, 0, 2}, {0, 0, -1}, 2, 0},
    {"two_different_points", s_point, {{1, 1, 3}, {1, 1, 3}, {1, 1, 3}}, {1, 1, 0}, {1, 1, 3}, {0, 0, -1}, 3, 0},
    {"disjoint_collinear_segments",
     s_segment,
     {{10, 0, 0}, {12, 0, 0}, {12, 0, 0}},
     {8, 0, 0},
     {10, 0, 0},
     {-1, 0, 0},
     2,
     0},
    {"a_vertex_that_touches_a_face", s_face, {{1, 1, 0}, {1, 1, 3}, {2, 1, 3}}, {1, 1, 0}, {1, 1, 0}, {0, 0, -1}, 0, 0},
    {"a_vertex_through_a_face", s_face, {{1, 1, -1}, {1, 1, 9}, {3, 1, 9}}, {1.1, 1, 0}, {1.1, 1, 0}, {0, 0, -1}, 0, 1},
    {"a_segment_through_a_face", s_face, {{1, 3, 2}, {1, 3, -9}, {1, 3, -9}}, {1, 3, 0}, {1, 3, 0}, {1, 0, 0}, 0, 1},
    {"a_point_in_a_face", s_point, {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}}, {1, 1, 0}, {1, 1, 0}, {0, 0, -1}, 0, 0},
    {"a_face_in_a_face", s_face, {{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, {1.5, 1.5, 0}, {1.5, 1.5, 0}, {0, 0, 1}, 0, 0},
    {"segments_that_cross", s_segment, {{4, 1, 0}, {4, -1, 0}, {4, -1, 0}}, {4, 0, 0}, {4, 0, 0}, {0, 0, -1}, 0, 0},
    {"collinear_segments_that_overlap",
     s_segment,
     {{4, 0, 0}, {9, 0, 0}, {9, 0, 0}},
     {6, 0, 0},
     {6, 0, 0},
     {0, 0, 1},
     0,
     0},
    {"identical_points", s_point, {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}, {1, 1, 0}, {1, 1, 0}, {1, 0, 0}, 0, 0},
};

enum
{
    qc_exampleCount = sizeof s_examples / sizeof s_examples[0]
};

static void CheckNear(const double got[3], const double expected[3], double tolerance, const char* what)
{
    for (int axis = 0; axis < 3; ++axis)
        ck_assert_msg(fabs(got[axis] - expected[axis]) <= tolerance, "%s is (%.17g, %.17g, %.17g)", what, got[0],
                      got[1], got[2]);
}

START_TEST(each_example_has_its_known_proximity)
{
    const Example* e = &s_examples[_i];
    qcProximity p = Find(e->a, e->b);
    CheckNear(p.pointA, e->pointA, 1e-14, "point of A");
    CheckNear(p.pointB, e->pointB, 1e-14, "point of B");
    CheckNear(p.normal, e->normal, 1e-15, "normal");
    ck_assert_double_eq(p.distance, e->distance);
    ck_assert_double_eq_tol(p.depth, e->depth, 1e-14);
}
END_TEST

START_TEST(a_pair_beyond_the_margin_leaves_the_proximity_alone)
{
    const double b[3][3] = {{1, 1, 2}, {2, 1, 2}, {1, 2, 2}};
    qcProximity p = {.distance = -7};
    ck_assert(!qcTrianglesWithin(&s_face[0][0], &b[0][0], 1.75, &p));
    ck_assert_double_eq(p.distance, -7);
    ck_assert(qcTrianglesWithin(&s_face[0][0], &b[0][0], 2, &p));
    ck_assert_double_eq(p.distance, 2);
}
END_TEST

//  ---- generated pairs ---------------------------------------------------------------------------------------

/// A pair of a kind of pairs.h, or a disjoint one for the kind after the last.
static void MakePair(qcRandom* random, int kind, qcTrianglePair* pair)
{
    double distance;
    if (kind == qc_pairKindCount)
        qcTrianglePair_MakeApart(random, 1 + (int)qcRandom_Below(random, 3), 1 + (int)qcRandom_Below(random, 3), pair,
                                 &distance);
    else
        qcTrianglePair_Make(random, (qcPairKind)kind, pair);
    if (kind != qc_pairKindCount && qcRandom_Below(random, 2) == 0)
        qcTrianglePair_Disturb(random, pair);
}

START_TEST(generated_pairs_have_the_distance_and_the_depth_of_the_oracle)
{
    qcRandom random = {1200 + (uint64_t)_i};
    // Fewer of mixed exponents: their integers have a thousand bits and more.
    int count = qcGetTestPairCount(40000) / qc_pairKindCount / (_i == qc_pairMixedExponents ? 20 : 1);
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        MakePair(&random, _i, &pair);
        // Larger ones may have a distance that overflows.
        if (qcTrianglePair_GetExtent(&pair) <= DBL_MAX / 4)
            qcClaim_Proximity(&pair);
    }
}
END_TEST

static void CheckMirror(const double a[3][3], const double b[3][3], double sign)
{
    qcProximity p = Find(a, b), q = Find(b, a);
    double length2 = p.normal[0] * p.normal[0] + p.normal[1] * p.normal[1] + p.normal[2] * p.normal[2];
    ck_assert_double_eq_tol(length2, 1.0, 1e-15);
    for (int axis = 0; axis < 3; axis++)
    {
        ck_assert_double_eq(p.normal[axis], sign * q.normal[axis]);
        ck_assert_double_eq(p.pointA[axis], q.pointB[axis]);
    }
}

START_TEST(equal_triangles_have_opposite_normals_unless_their_corners_have_the_same_order)
{
    // A triangle, a segment, a point.
    static const double triangles[3][3][3] = {{{0.0, 0.0, 0.0}, {1.0, 0.5, 0.25}, {0.0, 2.0, 1.0}},
                                              {{1.0, 2.0, 3.0}, {2.0, 4.0, 6.0}, {1.0, 2.0, 3.0}},
                                              {{1.0, 2.0, 3.0}, {1.0, 2.0, 3.0}, {1.0, 2.0, 3.0}}};
    for (int t = 0; t < 3; t++)
        for (int shift = 0; shift < 3; shift++)
        {
            double other[3][3];
            for (int c = 0; c < 3; c++)
                memcpy(other[c], triangles[t][(c + shift) % 3], sizeof other[c]);
            bool same = memcmp(other, triangles[t], sizeof other) == 0;
            CheckMirror(triangles[t], (const double(*)[3])other, same ? 1.0 : -1.0);
        }
}
END_TEST

START_TEST(exchanging_the_two_gives_the_mirror_image)
{
    qcRandom random = {1300};
    for (int i = 0; i < 20000; ++i)
    {
        qcTrianglePair made;
        const qcTrianglePair* pair = &made;
        MakePair(&random, i % (qc_pairKindCount + 1), &made);
        if (memcmp(made.a, made.b, sizeof made.a) == 0)
            continue;
        qcProximity p = Find(made.a, made.b), q = Find(made.b, made.a);
        QC_CLAIM(pair, p.distance == q.distance && p.depth == q.depth, "distance", q.distance, p.distance);
        for (int axis = 0; axis < 3; ++axis)
        {
            QC_CLAIM(pair, p.pointA[axis] == q.pointB[axis], "point of B", q.pointB[axis], p.pointA[axis]);
            QC_CLAIM(pair, p.pointB[axis] == q.pointA[axis], "point of A", q.pointA[axis], p.pointB[axis]);
            QC_CLAIM(pair, p.normal[axis] == -q.normal[axis], "normal", q.normal[axis], -p.normal[axis]);
        }
    }
}
END_TEST

START_TEST(results_are_as_accurate_far_from_the_origin)
{
    qcRandom random = {1400};
    for (int i = 0; i < 20000; ++i)
    {
        // Multiples of 2^-20 below 8 keep all their bits at 1e7.
        qcTrianglePair near, made;
        const qcTrianglePair* pair = &made;
        for (int j = 0; j < 9; ++j)
        {
            near.a[j / 3][j % 3] = ldexp(qcRandom_Integer(&random, -(1 << 23), 1 << 23), -20);
            near.b[j / 3][j % 3] = ldexp(qcRandom_Integer(&random, -(1 << 23), 1 << 23), -20);
        }
        made = near;
        double offset[3];
        for (int axis = 0; axis < 3; ++axis)
            offset[axis] = qcRandom_Integer(&random, -10000000, 10000000);
        for (int j = 0; j < 9; ++j)
        {
            made.a[j / 3][j % 3] += offset[j % 3];
            made.b[j / 3][j % 3] += offset[j % 3];
        }
        qcProximity p = Find(near.a, near.b), q = Find(made.a, made.b);
        QC_CLAIM(pair, p.distance == q.distance, "distance", q.distance, p.distance);
        QC_CLAIM(pair, p.depth == q.depth, "depth", q.depth, p.depth);
        QC_CLAIM(pair, memcmp(p.normal, q.normal, sizeof p.normal) == 0, "normal", q.normal[0], p.normal[0]);
        for (int axis = 0; axis < 3; ++axis)
            QC_CLAIM(pair, fabs(p.pointA[axis] + offset[axis] - q.pointA[axis]) <= 1e-8, "point of A", q.pointA[axis],
                     p.pointA[axis] + offset[axis]);
    }
}
END_TEST

START_TEST(a_power_of_two_scales_lengths_exactly)
{
    qcRandom random = {1500};
    const int exponents[] = {20, -20, 500, -500, 1000, -960};
    for (int i = 0; i < 20000; ++i)
    {
        qcTrianglePair made;
        const qcTrianglePair* pair = &made;
        qcTrianglePair_Make(&random, qc_pairFloat, &made);
        qcProximity p = Find(made.a, made.b);
        int exponent = exponents[i % 6];
        for (int j = 0; j < 9; ++j)
        {
            made.a[j / 3][j % 3] = ldexp(made.a[j / 3][j % 3], exponent);
            made.b[j / 3][j % 3] = ldexp(made.b[j / 3][j % 3], exponent);
        }
        qcProximity q = Find(made.a, made.b);
        QC_CLAIM(pair, ldexp(p.distance, exponent) == q.distance, "distance", q.distance, ldexp(p.distance, exponent));
        QC_CLAIM(pair, ldexp(p.depth, exponent) == q.depth, "depth", q.depth, ldexp(p.depth, exponent));
        QC_CLAIM(pair, memcmp(p.normal, q.normal, sizeof p.normal) == 0, "normal", q.normal[0], p.normal[0]);
    }
}
END_TEST

START_TEST(a_vertex_over_a_sliver_has_the_exact_distance)
{
    // A sliver 10^-9 wide and 220 long, with a vertex of the other 8 * 10^-12 above it.
    const qcTrianglePair sliver = {{{0x1.637d26db38f6bp+18, -0x1.16e37524d69ep+23, -0x1.1151c8e3dc169p+22},
                                    {0x1.6396d36bba4f4p+18, -0x1.16e41b09b76bap+23, -0x1.1150cc1960f5cp+22},
                                    {0x1.638c751dad755p+18, -0x1.16e3d3f0c4ca5p+23, -0x1.1150fb7f580bdp+22}},
                                   {{0x1.639dbcf51835dp+18, -0x1.16e44a6fae81cp+23, -0x1.1150ac8011918p+22},
                                    {0x1.637443bce4ce3p+18, -0x1.16e32e0be3fccp+23, -0x1.11516a17edea4p+22},
                                    {0x1.637443bce4cep+18, -0x1.16e32e0be3fc9p+23, -0x1.11516a17edea4p+22}},
                                   qc_pairKindCount};
    qcClaim_Proximity(&sliver);
}
END_TEST

START_TEST(triangles_a_hair_apart_have_the_normal_of_their_faces)
{
    const double gap = 0x1p-520, a[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}},
                 b[3][3] = {{0, 0, gap}, {1, 0, gap}, {0, 1, gap}}, up[3] = {0, 0, 1};
    qcProximity proximity = Find(a, b);
    ck_assert(proximity.distance >= 0.0 && proximity.distance <= 1e-12);
    for (int axis = 0; axis < 3; axis++)
        ck_assert_double_eq(fabs(proximity.normal[axis]), up[axis]);
}
END_TEST

START_TEST(points_of_the_largest_triangles_are_finite)
{
    const double max = DBL_MAX;
    const double a[3][3] = {{-max, 0, -max}, {max, 0, -max}, {max, 0, max}};
    const double x[3] = {0.32 * max, max / 16, -0.34 * max};
    const double b[3][3] = {{x[0], x[1], x[2]}, {x[0], x[1], x[2]}, {x[0], x[1], x[2]}};
    qcProximity p = Find(a, b);
    ck_assert_double_eq_tol(p.pointA[0] / max, 0.32, 1e-15);
    ck_assert_double_eq_tol(p.pointA[1] / max, 0, 1e-15);
    ck_assert_double_eq_tol(p.pointA[2] / max, -0.34, 1e-15);
    ck_assert_double_eq_tol(p.distance / max, 1.0 / 16, 1e-15);
    ck_assert_double_eq_tol(p.normal[1], -1, 1e-15);
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("proximity");
    for (int i = 0; i < qc_exampleCount; ++i)
    {
        TCase* example = tcase_create(s_examples[i].name);
        tcase_add_loop_test(example, each_example_has_its_known_proximity, i, i + 1);
        suite_add_tcase(suite, example);
    }
    TCase* tcase = tcase_create("generated");
    tcase_set_timeout(tcase, 0);
    tcase_add_test(tcase, a_pair_beyond_the_margin_leaves_the_proximity_alone);
    tcase_add_loop_test(tcase, generated_pairs_have_the_distance_and_the_depth_of_the_oracle, 0, qc_pairKindCount + 1);
    tcase_add_test(tcase, exchanging_the_two_gives_the_mirror_image);
    tcase_add_test(tcase, equal_triangles_have_opposite_normals_unless_their_corners_have_the_same_order);
    tcase_add_test(tcase, results_are_as_accurate_far_from_the_origin);
    tcase_add_test(tcase, a_vertex_over_a_sliver_has_the_exact_distance);
    tcase_add_test(tcase, triangles_a_hair_apart_have_the_normal_of_their_faces);
    tcase_add_test(tcase, points_of_the_largest_triangles_are_finite);
    tcase_add_test(tcase, a_power_of_two_scales_lengths_exactly);
    suite_add_tcase(suite, tcase);
    return qcRunSuite(suite);
}
