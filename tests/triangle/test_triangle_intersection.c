// The relation of two triangles against examples of its definition and against rational arithmetic.
// QC_TEST_PAIRS in the environment raises the number of generated pairs.
#include "triangle/exact.h"
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

//  ---- examples of the definition ----------------------------------------------------------------------

typedef struct Claim
{
    const char* name;
    const double (*a)[3];
    double b[3][3];
    qcRelation relation;
} Claim;

#define DISJOINT qc_relationDisjoint
#define TOUCHING qc_relationTouching
#define PENETRATING qc_relationPenetrating

static const double s_face[3][3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
// A slope: triangles above it overlap its box.
static const double s_slope[3][3] = {{0, 0, 0}, {4, 0, 4}, {0, 4, 4}};
static const double s_segment[3][3] = {{0, 0, 0}, {4, 4, 4}, {4, 4, 4}};
static const double s_point[3][3] = {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}};

static const Claim s_claims[] = {
    {"triangles_far_apart_are_disjoint", s_face, {{9, 9, 9}, {10, 9, 9}, {9, 10, 8}}, DISJOINT},
    {"parallel_triangles_are_disjoint", s_slope, {{0, 0, 1}, {4, 0, 5}, {0, 4, 5}}, DISJOINT},
    {"a_triangle_on_one_side_of_a_plane_is_disjoint", s_slope, {{1, 1, 3}, {2, 1, 4}, {1, 0, 4}}, DISJOINT},
    {"triangles_that_cross_their_common_line_apart_are_disjoint", s_face, {{3, 3, -1}, {3, 3, 1}, {9, 9, 0}}, DISJOINT},
    {"coplanar_triangles_apart_are_disjoint", s_face, {{3, 3, 0}, {5, 3, 0}, {3, 5, 0}}, DISJOINT},
    {"collinear_edges_apart_are_disjoint", s_face, {{5, -1, 0}, {6, -2, 0}, {3, 9, 0}}, DISJOINT},
    {"a_segment_above_a_triangle_is_disjoint", s_slope, {{1, 1, 3}, {2, 1, 4}, {2, 1, 4}}, DISJOINT},
    {"a_segment_that_passes_beside_a_triangle_is_disjoint", s_face, {{3, 3, -1}, {3, 2, 1}, {3, 2, 1}}, DISJOINT},
    {"a_segment_beside_a_triangle_in_its_plane_is_disjoint", s_face, {{1, 4, 0}, {4, 1, 0}, {4, 1, 0}}, DISJOINT},
    {"a_point_above_a_triangle_is_disjoint", s_point, {{0, 0, 1}, {4, 0, -1}, {0, 4, 1}}, DISJOINT},
    {"a_point_beside_a_triangle_in_its_plane_is_disjoint", s_face, {{3, 3, 0}, {3, 3, 0}, {3, 3, 0}}, DISJOINT},
    {"skew_segments_are_disjoint", s_segment, {{1, 2, 3}, {3, 1, 2}, {3, 1, 2}}, DISJOINT},
    {"parallel_segments_are_disjoint", s_segment, {{1, 0, 0}, {4, 3, 3}, {4, 3, 3}}, DISJOINT},
    {"collinear_segments_apart_are_disjoint", s_segment, {{5, 5, 5}, {6, 6, 6}, {6, 6, 6}}, DISJOINT},
    {"coplanar_segments_that_miss_are_disjoint", s_segment, {{3, 3, 1}, {2, 2, 1}, {2, 2, 1}}, DISJOINT},
    {"a_point_beside_a_segment_is_disjoint", s_segment, {{1, 1, 2}, {1, 1, 2}, {1, 1, 2}}, DISJOINT},
    {"a_point_beyond_the_end_of_a_segment_is_disjoint", s_segment, {{5, 5, 5}, {5, 5, 5}, {5, 5, 5}}, DISJOINT},
    {"two_points_are_disjoint", s_point, {{1, 1, 0x1p-1074}, {1, 1, 0x1p-1074}, {1, 1, 0x1p-1074}}, DISJOINT},

    {"a_vertex_on_a_face_is_touching", s_face, {{1, 1, 0}, {1, 1, 3}, {2, 1, 3}}, TOUCHING},
    {"a_vertex_on_an_edge_is_touching", s_face, {{2, 0, 0}, {2, -1, 3}, {3, -1, -3}}, TOUCHING},
    {"a_vertex_on_a_vertex_is_touching", s_face, {{0, 0, 0}, {-1, 0, 2}, {0, -1, -2}}, TOUCHING},
    {"a_vertex_on_an_edge_across_its_plane_is_touching", s_face, {{4, 0, 1}, {4, 0, -1}, {9, 0, 0}}, TOUCHING},
    {"an_edge_in_a_face_is_touching", s_face, {{1, 1, 0}, {2, 1, 0}, {1, 1, 3}}, TOUCHING},
    {"an_edge_across_a_face_in_its_plane_is_touching", s_face, {{-1, 1, 0}, {9, 1, 0}, {1, 1, 3}}, TOUCHING},
    {"edges_that_cross_in_a_point_are_touching", s_face, {{2, 0, 1}, {2, 0, -1}, {2, -3, 0}}, TOUCHING},
    {"a_shared_edge_is_touching", s_face, {{0, 0, 0}, {4, 0, 0}, {0, 0, 4}}, TOUCHING},
    {"a_shared_vertex_is_touching", s_face, {{0, 0, 0}, {-4, 0, 0}, {0, -4, 1}}, TOUCHING},
    {"collinear_edges_that_overlap_are_touching", s_face, {{2, 0, 0}, {9, 0, 0}, {3, -2, 3}}, TOUCHING},
    {"collinear_edges_that_meet_end_to_end_are_touching", s_face, {{4, 0, 0}, {9, 0, 0}, {6, -2, 3}}, TOUCHING},
    {"an_edge_that_passes_through_a_vertex_is_touching", s_face, {{0, 0, 1}, {0, 0, -1}, {-2, 1, 0}}, TOUCHING},
    {"coplanar_triangles_with_a_common_edge_are_touching", s_face, {{0, 0, 0}, {4, 0, 0}, {1, -4, 0}}, TOUCHING},
    {"coplanar_edges_that_overlap_from_outside_are_touching", s_face, {{2, 0, 0}, {9, 0, 0}, {3, -2, 0}}, TOUCHING},
    {"a_coplanar_vertex_on_an_edge_is_touching", s_face, {{2, 2, 0}, {4, 3, 0}, {3, 4, 0}}, TOUCHING},
    {"a_coplanar_vertex_on_a_vertex_is_touching", s_face, {{0, 0, 0}, {-1, 0, 0}, {1, -1, 0}}, TOUCHING},
    {"a_segment_that_ends_on_a_face_is_touching", s_face, {{1, 1, 0}, {1, 1, 3}, {1, 1, 3}}, TOUCHING},
    {"a_segment_along_an_edge_is_touching", s_face, {{-1, 0, 0}, {3, 0, 0}, {3, 0, 0}}, TOUCHING},
    {"a_segment_through_an_edge_is_touching", s_face, {{2, 0, 1}, {2, 0, -1}, {2, 0, -1}}, TOUCHING},
    {"a_segment_through_a_vertex_is_touching", s_face, {{0, 0, 1}, {0, 0, -1}, {0, 0, -1}}, TOUCHING},
    {"a_coplanar_segment_that_ends_on_an_edge_is_touching", s_face, {{2, 2, 0}, {9, 3, 0}, {9, 3, 0}}, TOUCHING},
    {"a_coplanar_segment_past_a_vertex_is_touching", s_face, {{-1, 1, 0}, {1, -1, 0}, {1, -1, 0}}, TOUCHING},
    {"segments_that_share_an_end_are_touching", s_segment, {{4, 4, 4}, {4, 5, 6}, {4, 5, 6}}, TOUCHING},
    {"a_segment_that_ends_inside_another_is_touching", s_segment, {{1, 1, 1}, {1, 2, 0}, {1, 2, 0}}, TOUCHING},
    {"collinear_segments_end_to_end_are_touching", s_segment, {{4, 4, 4}, {5, 5, 5}, {5, 5, 5}}, TOUCHING},
    {"a_point_on_an_edge_of_a_triangle_is_touching", s_face, {{2, 2, 0}, {2, 2, 0}, {2, 2, 0}}, TOUCHING},
    {"a_point_on_a_vertex_of_a_triangle_is_touching", s_face, {{4, 0, 0}, {4, 0, 0}, {4, 0, 0}}, TOUCHING},
    {"a_point_at_the_end_of_a_segment_is_touching", s_segment, {{4, 4, 4}, {4, 4, 4}, {4, 4, 4}}, TOUCHING},

    {"an_edge_through_a_face_penetrates", s_face, {{1, 1, -1}, {1, 1, 2}, {9, 9, 2}}, PENETRATING},
    {"a_triangle_through_an_edge_penetrates", s_face, {{1, 1, 1}, {1, 1, -1}, {1, -9, 0}}, PENETRATING},
    {"a_triangle_through_a_vertex_penetrates", s_face, {{-1, -1, -5}, {-1, -1, 5}, {2, 2, 0}}, PENETRATING},
    {"edges_that_cross_from_within_penetrate", s_face, {{2, 0, 1}, {2, 0, -1}, {2, 3, 0}}, PENETRATING},
    {"a_shared_vertex_does_not_hide_a_penetration", s_face, {{0, 0, 0}, {2, 2, 1}, {2, 2, -1}}, PENETRATING},
    {"identical_triangles_penetrate", s_face, {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, PENETRATING},
    {"coplanar_triangles_that_overlap_penetrate", s_face, {{1, 1, 0}, {5, 1, 0}, {1, 5, 0}}, PENETRATING},
    {"coplanar_triangles_that_form_a_star_penetrate", s_face, {{2, 2, 0}, {-1, 2, 0}, {2, -1, 0}}, PENETRATING},
    {"a_triangle_inside_another_penetrates", s_face, {{1, 1, 0}, {2, 1, 0}, {1, 2, 0}}, PENETRATING},
    {"a_triangle_inside_another_up_to_the_border_penetrates", s_face, {{2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, PENETRATING},
    {"a_triangle_folded_onto_its_neighbour_penetrates", s_face, {{0, 0, 0}, {4, 0, 0}, {3, 3, 0}}, PENETRATING},
    {"a_segment_through_a_face_penetrates", s_face, {{1, 1, 1}, {1, 1, -1}, {1, 1, -1}}, PENETRATING},
    {"a_segment_inside_a_face_penetrates", s_face, {{1, 1, 0}, {2, 1, 0}, {2, 1, 0}}, PENETRATING},
    {"a_segment_between_two_edges_of_a_face_penetrates", s_face, {{2, 0, 0}, {0, 2, 0}, {0, 2, 0}}, PENETRATING},
    {"a_segment_from_a_vertex_into_a_face_penetrates", s_face, {{0, 0, 0}, {1, 1, 0}, {1, 1, 0}}, PENETRATING},
    {"a_segment_across_a_whole_face_penetrates", s_face, {{-5, 1, 0}, {5, 1, 0}, {5, 1, 0}}, PENETRATING},
    {"crossing_segments_penetrate", s_segment, {{1, 3, 2}, {3, 1, 2}, {3, 1, 2}}, PENETRATING},
    {"collinear_segments_that_overlap_penetrate", s_segment, {{2, 2, 2}, {6, 6, 6}, {6, 6, 6}}, PENETRATING},
    {"a_segment_inside_another_penetrates", s_segment, {{0, 0, 0}, {1, 1, 1}, {1, 1, 1}}, PENETRATING},
    {"identical_segments_penetrate", s_segment, {{0, 0, 0}, {4, 4, 4}, {4, 4, 4}}, PENETRATING},
    {"a_flat_triangle_is_the_segment_between_its_far_corners",
     s_segment,
     {{1, 3, 2}, {4, 0, 2}, {3, 1, 2}},
     PENETRATING},
    {"a_point_inside_a_triangle_penetrates", s_face, {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}, PENETRATING},
    {"a_point_inside_a_segment_penetrates", s_segment, {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}}, PENETRATING},
    {"identical_points_penetrate", s_point, {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}, PENETRATING},
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

static void CheckRelation(const qcTrianglePair* pair, qcRelation expected)
{
    const double(*a)[3] = pair->a;
    const double(*b)[3] = pair->b;
    char text[1024];
    qcRelation got = qcExact_Relate(a, b, NULL);
    ck_assert_msg(got == expected, "%s instead of %s for %s", qcRelation_Name(got), qcRelation_Name(expected),
                  qcTrianglePair_Print(pair, text));
    got = qcExact_Relate(b, a, NULL);
    ck_assert_msg(got == expected, "%s instead of %s, exchanged, for %s", qcRelation_Name(got),
                  qcRelation_Name(expected), qcTrianglePair_Print(pair, text));
}

static void CheckRelationInAnyOrder(const qcTrianglePair* pair, qcRelation expected)
{
    for (int orders = 0; orders < qc_orderCount * qc_orderCount; ++orders)
    {
        qcTrianglePair reordered = {.kind = pair->kind};
        Reorder(reordered.a, pair->a, orders / qc_orderCount);
        Reorder(reordered.b, pair->b, orders % qc_orderCount);
        CheckRelation(&reordered, expected);
    }
}

START_TEST(the_claim_holds_for_any_order_of_corners_and_triangles)
{
    const Claim* claim = &s_claims[_i];
    qcTrianglePair pair = {.kind = qc_pairKindCount};
    memcpy(pair.a, claim->a, sizeof pair.a);
    memcpy(pair.b, claim->b, sizeof pair.b);
    CheckRelationInAnyOrder(&pair, claim->relation);
    ck_assert_int_eq(qcRelateTriangles((const double*)claim->a, (const double*)claim->b), claim->relation);
    ck_assert_int_eq(qcRelateTriangles((const double*)claim->b, (const double*)claim->a), claim->relation);
}
END_TEST

START_TEST(the_oracle_agrees_with_the_claim)
{
    const Claim* claim = &s_claims[_i];
    ck_assert_int_eq(qcOracle_Relate(claim->a, claim->b), claim->relation);
    ck_assert_int_eq(qcOracle_Relate(claim->b, claim->a), claim->relation);
}
END_TEST

//  ---- the oracle ----------------------------------------------------------------------------------------

static void MakePair(qcRandom* random, qcPairKind kind, qcTrianglePair* pair)
{
    qcTrianglePair_Make(random, kind, pair);
    if (qcRandom_Below(random, 2) == 0)
        qcTrianglePair_Disturb(random, pair);
}

START_TEST(generated_pairs_have_the_relation_of_the_oracle)
{
    qcRandom random = {100 + (uint64_t)_i};
    for (int i = qcGetTestPairCount(100000) / qc_pairKindCount; i >= 0; --i)
    {
        qcTrianglePair pair;
        MakePair(&random, (qcPairKind)_i, &pair);
        CheckRelation(&pair, qcOracle_Relate(pair.a, pair.b));
    }
}
END_TEST

START_TEST(the_relation_of_generated_pairs_is_independent_of_order)
{
    qcRandom random = {200};
    for (int i = qcGetTestPairCount(100000) / 50; i >= 0; --i)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        CheckRelationInAnyOrder(&pair, qcExact_Relate(pair.a, pair.b, NULL));
    }
}
END_TEST

START_TEST(generated_pairs_are_finite_and_of_every_relation)
{
    qcRandom random = {300};
    const int count = 5000;
    int relations[3] = {0, 0, 0};
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        for (int j = 0; j < 9; ++j)
            ck_assert(isfinite(pair.a[j / 3][j % 3]) && isfinite(pair.b[j / 3][j % 3]));
        ++relations[qcOracle_Relate(pair.a, pair.b)];
    }
    for (int i = 0; i < 3; ++i)
        ck_assert_int_gt(relations[i], count / 5);
}
END_TEST

START_TEST(the_filter_decides_pairs_in_general_position)
{
    qcRandom random = {400};
    uint64_t undecided = 0;
    for (int i = 0; i < 10000; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&random, qc_pairFloat, &pair);
        qcExact_Relate(pair.a, pair.b, &undecided);
    }
    ck_assert_uint_eq(undecided, 0);
}
END_TEST

//  ---- soups -------------------------------------------------------------------------------------------------

typedef struct Count
{
    int touching, penetrating, penetratingNonNeighbours;
} Count;

// Compares every pair of a soup with the oracle, and counts the relations.
static Count CheckSoup(qcSoup* soup)
{
    Count count = {0, 0, 0};
    for (uint32_t a = 0; a < soup->triangleCount; ++a)
        for (uint32_t b = a + 1; b < soup->triangleCount; ++b)
        {
            qcTrianglePair pair = {.kind = qc_pairKindCount};
            qcSoup_GetTriangle(soup, a, pair.a);
            qcSoup_GetTriangle(soup, b, pair.b);
            qcRelation relation = qcOracle_Relate(pair.a, pair.b);
            CheckRelation(&pair, relation);
            count.touching += relation == qc_relationTouching;
            count.penetrating += relation == qc_relationPenetrating;
            count.penetratingNonNeighbours += relation == qc_relationPenetrating && !qcSoup_AreNeighbours(soup, a, b);
        }
    qcSoup_Free(soup);
    return count;
}

START_TEST(equal_triangles_penetrate_in_any_order_of_corners)
{
    qcRandom random = {5};
    for (int i = 0; i < 3000; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        for (int c = 0; c < 3; c++)
            memcpy(pair.b[i % 2 == 0 ? c : 2 - c], pair.a[(c + i) % 3], sizeof pair.a[0]);
        uint64_t undecided = 0;
        ck_assert_int_eq(qcExact_Relate(pair.a, pair.b, &undecided), qc_relationPenetrating);
        ck_assert_uint_eq(undecided, 0);
        // One corner less: a side or a corner of the other, or the same segment.
        memcpy(pair.b[0], pair.b[1], sizeof pair.b[0]);
        ck_assert_int_eq(qcExact_Relate(pair.a, pair.b, NULL), qcOracle_Relate(pair.a, pair.b));
    }
}
END_TEST

START_TEST(triangles_of_a_flat_grid_only_touch)
{
    qcSoup soup = qcSoup_MakeGrid(7);
    qcSoup_Translate(&soup, 0.1, 0.2, 0.3);
    Count count = CheckSoup(&soup);
    ck_assert_int_gt(count.touching, 98);
    ck_assert_int_eq(count.penetrating, 0);
}
END_TEST

START_TEST(triangles_of_a_sphere_only_touch)
{
    qcSoup soup = qcSoup_MakeSphere(2, 0.7);
    ck_assert_uint_eq(soup.vertexCount, 162);
    ck_assert_uint_eq(soup.triangleCount, 320);
    Count count = CheckSoup(&soup);
    // 480 edges; 12 vertices of 5 triangles and 150 of 6 add 5 and 9 pairs each that share no edge.
    ck_assert_int_eq(count.touching, 480 + 12 * 5 + 150 * 9);
    ck_assert_int_eq(count.penetrating, 0);
}
END_TEST

START_TEST(layers_of_thin_sheets_are_disjoint)
{
    qcSoup one = qcSoup_MakeGrid(4);
    qcSoup three = qcSoup_MakeSheets(3, 4, 1e-9);
    Count countOne = CheckSoup(&one), countThree = CheckSoup(&three);
    ck_assert_int_eq(countThree.touching, 3 * countOne.touching);
    ck_assert_int_eq(countThree.penetrating, 0);
}
END_TEST

START_TEST(noise_makes_the_layers_of_a_folded_cloth_penetrate)
{
    qcSoup calm = qcSoup_MakeFoldedCloth(1, 12, 0.05, 0.005);
    qcSoup noisy = qcSoup_MakeFoldedCloth(1, 12, 0.05, 0.05);
    ck_assert_int_eq(CheckSoup(&calm).penetratingNonNeighbours, 0);
    ck_assert_int_gt(CheckSoup(&noisy).penetratingNonNeighbours, 20);
}
END_TEST

START_TEST(pairs_of_random_soups_have_the_relation_of_the_oracle)
{
    qcSoup plain = qcSoup_MakeRandom(1, 150, 0.2);
    qcSoup rounded = qcSoup_MakeRandom(2, 150, 0.2);
    qcSoup degenerate = qcSoup_MakeDegenerate(3, 150, 0.2, 0.5);
    qcSoup_RoundToFloat(&rounded);
    ck_assert_int_gt(CheckSoup(&plain).penetrating, 20);
    ck_assert_int_gt(CheckSoup(&rounded).penetrating, 20);
    ck_assert_int_gt(CheckSoup(&degenerate).penetrating, 20);
}
END_TEST

int main(void)
{
    Suite* suite = suite_create("triangle intersection");
    for (int i = 0; i < qc_claimCount; ++i)
    {
        TCase* claim = tcase_create(s_claims[i].name);
        tcase_add_loop_test(claim, the_claim_holds_for_any_order_of_corners_and_triangles, i, i + 1);
        tcase_add_loop_test(claim, the_oracle_agrees_with_the_claim, i, i + 1);
        suite_add_tcase(suite, claim);
    }
    TCase* tcase = tcase_create("generated");
    tcase_set_timeout(tcase, 0);
    tcase_add_loop_test(tcase, generated_pairs_have_the_relation_of_the_oracle, 0, qc_pairKindCount);
    tcase_add_test(tcase, the_relation_of_generated_pairs_is_independent_of_order);
    tcase_add_test(tcase, generated_pairs_are_finite_and_of_every_relation);
    tcase_add_test(tcase, the_filter_decides_pairs_in_general_position);
    tcase_add_test(tcase, equal_triangles_penetrate_in_any_order_of_corners);
    tcase_add_test(tcase, triangles_of_a_flat_grid_only_touch);
    tcase_add_test(tcase, triangles_of_a_sphere_only_touch);
    tcase_add_test(tcase, layers_of_thin_sheets_are_disjoint);
    tcase_add_test(tcase, noise_makes_the_layers_of_a_folded_cloth_penetrate);
    tcase_add_test(tcase, pairs_of_random_soups_have_the_relation_of_the_oracle);
    suite_add_tcase(suite, tcase);
    return qcRunSuite(suite);
}
