// The distance test of two triangles against examples and rational arithmetic, at the margin and next to it.
// QC_TEST_PAIRS in the environment raises the number of generated pairs.
#include "triangle/exact.h"
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"

#include <check.h>
#include <float.h>
#include <math.h>
#include <string.h>

static double Below(double x)
{
    return nextafter(x, 0);
}

static double Above(double x)
{
    return nextafter(x, INFINITY);
}

/// Checks both orders of the two. `expected` may be null: then any relation but disjoint is within.
static void CheckWithin(const qcTrianglePair* pair, double margin, bool within, const qcRelation* expected)
{
    for (int exchanged = 0; exchanged < 2; ++exchanged)
    {
        qcRelation got = qcExact_Within(exchanged ? pair->b : pair->a, exchanged ? pair->a : pair->b, margin, NULL);
        char text[1024];
        // No assertion for each: passing ones write to a file.
        if ((got != qc_relationDisjoint) != within || (expected != NULL && got != *expected))
            ck_abort_msg("%s at margin %a, exchanged %d, for %s", qcRelation_Name(got), margin, exchanged,
                         qcTrianglePair_Print(pair, text));
    }
}

//  ---- by example ----------------------------------------------------------------------------------------

typedef struct Claim
{
    const char* name;
    const double (*a)[3];
    double b[3][3];
    double distance;
} Claim;

static const double s_face[3][3] = {{0, 0, 0}, {8, 0, 0}, {0, 8, 0}};
static const double s_segment[3][3] = {{0, 0, 0}, {8, 0, 0}, {8, 0, 0}};
static const double s_point[3][3] = {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}};

static const Claim s_claims[] = {
    {"parallel_faces_have_the_distance_of_their_planes", s_face, {{1, 1, 2}, {2, 1, 2}, {1, 2, 2}}, 2},
    {"parallel_faces_whose_projections_overlap_without_a_vertex_inside",
     s_face,
     {{-1, 2, 3}, {-1, 1, 3}, {9, 1, 3}},
     3},
    {"a_vertex_over_a_face", s_face, {{1, 1, -5}, {9, 1, -9}, {1, 9, -8}}, 5},
    {"a_vertex_over_an_edge", s_face, {{4, -3, 4}, {5, -9, 4}, {4, -3, 9}}, 5},
    {"a_vertex_over_a_vertex", s_face, {{-1, -2, 2}, {-1, -9, 9}, {-9, -2, 3}}, 3},
    {"the_plane_is_nearer_than_the_face", s_face, {{-4, 2, 3}, {-9, 2, 3}, {-9, 4, 9}}, 5},
    {"crossing_edges", s_face, {{4, -4, 2}, {4, 4, 2}, {4, 0, 9}}, 2},
    {"parallel_edges", s_face, {{1, -3, 4}, {7, -3, 4}, {3, -9, 9}}, 5},
    {"parallel_edges_one_beyond_the_other", s_face, {{10, -3, 6}, {11, -3, 6}, {14, -9, 9}}, 7},
    {"coplanar_faces_edge_to_vertex", s_face, {{-2, 3, 0}, {-3, 1, 0}, {-4, 6, 0}}, 2},
    {"coplanar_faces_vertex_to_vertex", s_face, {{-3, -4, 0}, {-5, -4, 0}, {-3, -9, 0}}, 5},
    {"a_segment_over_a_face", s_face, {{-3, 1, 7}, {9, 3, 7}, {9, 3, 7}}, 7},
    {"a_segment_that_ends_over_a_face", s_face, {{1, 1, 7}, {9, 3, 8}, {9, 3, 8}}, 7},
    {"a_point_over_a_face", s_face, {{1, 1, 7}, {1, 1, 7}, {1, 1, 7}}, 7},
    {"a_point_beside_a_face", s_face, {{-3, 1, 4}, {-3, 1, 4}, {-3, 1, 4}}, 5},
    {"skew_segments", s_segment, {{4, -4, 2}, {4, 4, 2}, {4, 1, 2}}, 2},
    {"parallel_segments", s_segment, {{4, 4, 3}, {2, 4, 3}, {3, 4, 3}}, 5},
    {"collinear_segments", s_segment, {{10, 0, 0}, {12, 0, 0}, {11, 0, 0}}, 2},
    {"a_point_beside_a_segment", s_segment, {{1, 5, 12}, {1, 5, 12}, {1, 5, 12}}, 13},
    {"a_point_beyond_a_segment", s_segment, {{10, 3, 6}, {10, 3, 6}, {10, 3, 6}}, 7},
    {"two_points", s_point, {{3, 4, 6}, {3, 4, 6}, {3, 4, 6}}, 7},
    {"two_points_at_the_smallest_distance",
     s_point,
     {{1, 1, 0x1p-1074}, {1, 1, 0x1p-1074}, {1, 1, 0x1p-1074}},
     0x1p-1074},
    {"triangles_that_meet_are_within_any_margin", s_face, {{1, 1, -1}, {1, 1, 1}, {2, 1, 1}}, 0},
};

enum
{
    qc_claimCount = sizeof s_claims / sizeof s_claims[0],
    qc_orderCount = 6
};

static void Reorder(double out[3][3], const double (*corners)[3], int order)
{
    static const int orders[qc_orderCount][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}, {1, 0, 2}, {0, 2, 1}};
    for (int i = 0; i < 3; ++i)
        memcpy(out[i], corners[orders[order][i]], sizeof out[i]);
}

START_TEST(the_claim_holds_for_any_order_of_corners_and_triangles)
{
    const Claim* claim = &s_claims[_i];
    const double distance = claim->distance;
    const qcRelation near = qc_relationNear, disjoint = qc_relationDisjoint;
    for (int orders = 0; orders < qc_orderCount * qc_orderCount; ++orders)
    {
        qcTrianglePair pair = {.kind = qc_pairKindCount};
        Reorder(pair.a, claim->a, orders / qc_orderCount);
        Reorder(pair.b, claim->b, orders % qc_orderCount);
        CheckWithin(&pair, distance, true, distance > 0 ? &near : NULL);
        CheckWithin(&pair, Above(distance), true, distance > 0 ? &near : NULL);
        CheckWithin(&pair, DBL_MAX, true, distance > 0 ? &near : NULL);
        if (distance > 0)
        {
            CheckWithin(&pair, Below(distance), false, &disjoint);
            CheckWithin(&pair, 0, false, &disjoint);
        }
    }
}
END_TEST

START_TEST(the_oracle_agrees_with_the_claim)
{
    const Claim* claim = &s_claims[_i];
    qcOracleDistance* exact = qcOracleDistance_Create(claim->a, claim->b);
    ck_assert_int_eq(qcOracleDistance_Compare(exact, claim->distance), 0);
    ck_assert_int_eq(qcOracleDistance_Compare(exact, Above(claim->distance)), -1);
    ck_assert_double_eq(qcOracleDistance_Get(exact), claim->distance);
    qcOracleDistance_Destroy(exact);
}
END_TEST

START_TEST(no_pair_is_within_a_margin_that_is_nan_or_negative)
{
    const double* p = &s_face[0][0];
    ck_assert(qcTrianglesWithin(p, p, 0, NULL));
    ck_assert(!qcTrianglesWithin(p, p, -1, NULL));
    ck_assert(!qcTrianglesWithin(p, p, NAN, NULL));
}
END_TEST

START_TEST(every_pair_is_within_an_infinite_margin)
{
    double b[3][3] = {{-DBL_MAX, DBL_MAX, -DBL_MAX}, {-DBL_MAX, DBL_MAX, 0}, {-DBL_MAX, 0, 0}};
    const double a[3][3] = {{DBL_MAX, -DBL_MAX, DBL_MAX}, {DBL_MAX, -DBL_MAX, 0}, {DBL_MAX, 0, 0}};
    ck_assert(qcTrianglesWithin(&a[0][0], &b[0][0], INFINITY, NULL));
    // Their distance is twice that.
    ck_assert(!qcTrianglesWithin(&a[0][0], &b[0][0], DBL_MAX, NULL));
}
END_TEST

//  ---- exactly at the margin -------------------------------------------------------------------------------

START_TEST(pairs_exactly_at_the_margin_are_within_and_below_it_are_not)
{
    qcRandom random = {600 + (uint64_t)_i};
    const qcRelation near = qc_relationNear, disjoint = qc_relationDisjoint;
    for (int i = qcGetTestPairCount(63000) / 9; i >= 0; --i)
    {
        qcTrianglePair pair;
        double distance;
        qcTrianglePair_MakeApart(&random, 1 + _i / 3, 1 + _i % 3, &pair, &distance);
        CheckWithin(&pair, distance, true, &near);
        CheckWithin(&pair, Below(distance), false, &disjoint);
        CheckWithin(&pair, Above(distance), true, &near);
    }
}
END_TEST

START_TEST(pairs_generated_at_a_distance_have_it_for_the_oracle)
{
    qcRandom random = {700};
    for (int i = 0; i < 3000; ++i)
    {
        qcTrianglePair pair;
        double distance;
        char text[1024];
        qcTrianglePair_MakeApart(&random, 1 + i % 3, 1 + i / 3 % 3, &pair, &distance);
        qcOracleDistance* exact = qcOracleDistance_Create(pair.a, pair.b);
        if (qcOracleDistance_Compare(exact, distance) != 0)
            ck_abort_msg("not at distance %a: %s", distance, qcTrianglePair_Print(&pair, text));
        qcOracleDistance_Destroy(exact);
    }
}
END_TEST

START_TEST(pairs_exactly_at_the_margin_are_decided_in_integers)
{
    qcRandom random = {800};
    uint64_t undecided = 0;
    for (int i = 0; i < 1000; ++i)
    {
        qcTrianglePair pair;
        double distance;
        qcTrianglePair_MakeApart(&random, 1 + i % 3, 1 + i / 3 % 3, &pair, &distance);
        qcExact_Within(pair.a, pair.b, distance, &undecided);
    }
    ck_assert_uint_ge(undecided, 1000);
}
END_TEST

//  ---- the oracle --------------------------------------------------------------------------------------------

/// A margin near the exact distance, of the size of the pair, or the smallest double.
static double SomeMargin(qcRandom* random, const qcTrianglePair* pair, double distance)
{
    switch (qcRandom_Below(random, 16))
    {
        case 0: return 0x1p-1074;
        case 1:
        case 2: return qcTrianglePair_GetLargest(pair) * qcRandom_Uniform(random, 0, 2);
        case 3:
        case 4:
        case 5: return distance * qcRandom_Uniform(random, 0, 3);
        default: return distance * (1 + qcRandom_Integer(random, -40, 40) * 0x1p-48);
    }
}

static void CheckAgainstOracle(qcRandom* random, const qcTrianglePair* pair)
{
    qcOracleDistance* exact = qcOracleDistance_Create(pair->a, pair->b);
    double distance = qcOracleDistance_Get(exact);
    const double margins[] = {distance, Below(distance), Above(distance), SomeMargin(random, pair, distance), 0};
    for (size_t m = 0; m < sizeof margins / sizeof margins[0]; ++m)
        if (isfinite(margins[m]))
            CheckWithin(pair, margins[m], qcOracleDistance_Compare(exact, margins[m]) <= 0, NULL);
    // The oracles of relation and distance are independent.
    qcRelation relation = qcOracle_Relate(pair->a, pair->b);
    if ((qcOracleDistance_Compare(exact, 0) == 0) != (relation != qc_relationDisjoint))
        ck_abort_msg("the oracles disagree: %s", qcRelation_Name(relation));
    if (relation != qc_relationDisjoint)
        CheckWithin(pair, qcTrianglePair_GetLargest(pair), true, &relation);
    qcOracleDistance_Destroy(exact);
}

START_TEST(generated_pairs_are_within_exactly_the_margins_of_the_oracle)
{
    qcRandom random = {900 + (uint64_t)_i};
    // Fewer of mixed exponents: their integers have a thousand bits and more.
    int count = qcGetTestPairCount(27000) / qc_pairKindCount / (_i == qc_pairMixedExponents ? 10 : 1);
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&random, (qcPairKind)_i, &pair);
        if (qcRandom_Below(&random, 2) == 0)
            qcTrianglePair_Disturb(&random, &pair);
        CheckAgainstOracle(&random, &pair);
    }
}
END_TEST

START_TEST(pairs_ulps_beside_the_margin_agree_with_the_oracle)
{
    qcRandom random = {1000};
    for (int i = qcGetTestPairCount(15000); i >= 0; --i)
    {
        qcTrianglePair pair;
        double distance;
        qcTrianglePair_MakeApart(&random, 1 + i % 3, 1 + i / 3 % 3, &pair, &distance);
        qcTrianglePair_MoveByUlps(&random, &pair);
        qcOracleDistance* exact = qcOracleDistance_Create(pair.a, pair.b);
        CheckWithin(&pair, distance, qcOracleDistance_Compare(exact, distance) <= 0, NULL);
        qcOracleDistance_Destroy(exact);
    }
}
END_TEST

START_TEST(the_filter_decides_pairs_in_general_position)
{
    qcRandom random = {1100};
    uint64_t undecided = 0;
    for (int i = 0; i < 10000; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&random, qc_pairFloat, &pair);
        qcExact_Within(pair.a, pair.b, qcRandom_Uniform(&random, 0, 0.5), &undecided);
    }
    ck_assert_uint_eq(undecided, 0);
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("triangle distance");
    for (int i = 0; i < qc_claimCount; ++i)
    {
        TCase* claim = tcase_create(s_claims[i].name);
        tcase_add_loop_test(claim, the_claim_holds_for_any_order_of_corners_and_triangles, i, i + 1);
        tcase_add_loop_test(claim, the_oracle_agrees_with_the_claim, i, i + 1);
        suite_add_tcase(suite, claim);
    }
    TCase* tcase = tcase_create("generated");
    tcase_set_timeout(tcase, 0);
    tcase_add_test(tcase, no_pair_is_within_a_margin_that_is_nan_or_negative);
    tcase_add_test(tcase, every_pair_is_within_an_infinite_margin);
    tcase_add_loop_test(tcase, pairs_exactly_at_the_margin_are_within_and_below_it_are_not, 0, 9);
    tcase_add_test(tcase, pairs_generated_at_a_distance_have_it_for_the_oracle);
    tcase_add_test(tcase, pairs_exactly_at_the_margin_are_decided_in_integers);
    tcase_add_loop_test(tcase, generated_pairs_are_within_exactly_the_margins_of_the_oracle, 0, qc_pairKindCount);
    tcase_add_test(tcase, pairs_ulps_beside_the_margin_agree_with_the_oracle);
    tcase_add_test(tcase, the_filter_decides_pairs_in_general_position);
    suite_add_tcase(suite, tcase);
    return qcRunSuite(suite);
}
