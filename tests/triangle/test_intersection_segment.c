// The ends of the intersection segment of two triangles, against the corners of the exact intersection. QC_TEST_PAIRS
// in the environment raises the number of generated pairs.
#include "triangle/exact.h"
#include "triangle/pair_claims.h"
#include "support/suite.h"

#include <check.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

//  ---- by example ------------------------------------------------------------------------------------------

static void CheckEnds(const double a[3][3], const double b[3][3], const double p[3], const double q[3])
{
    for (int exchanged = 0; exchanged < 2; ++exchanged)
    {
        qcSegment s;
        qcExact_Segment(exchanged ? b : a, exchanged ? a : b, &s);
        const double rounding = 0x1p-48; // the coordinates are below 4, in general position
        ck_assert_msg((qcAreNear(s.p, p, rounding) && qcAreNear(s.q, q, rounding)) ||
                          (qcAreNear(s.p, q, rounding) && qcAreNear(s.q, p, rounding)),
                      "(%g, %g, %g) (%g, %g, %g)", s.p[0], s.p[1], s.p[2], s.q[0], s.q[1], s.q[2]);
    }
}

static const double s_face[3][3] = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
static const double s_diagonal[3][3] = {{0, 0, 0}, {4, 4, 4}, {4, 4, 4}};

START_TEST(triangles_that_cross_share_the_overlap_of_two_intervals)
{
    const double b[3][3] = {{1, 1, -1}, {1, 1, 2}, {9, 9, 2}};
    CheckEnds(s_face, b, (double[]){1, 1, 0}, (double[]){2, 2, 0});
}
END_TEST

START_TEST(identical_triangles_give_their_longest_edge)
{
    CheckEnds(s_face, s_face, (double[]){4, 0, 0}, (double[]){0, 4, 0});
}
END_TEST

START_TEST(a_coplanar_triangle_inside_gives_its_longest_edge)
{
    const double b[3][3] = {{1, 1, 0}, {2, 1, 0}, {1, 2, 0}};
    CheckEnds(s_face, b, (double[]){2, 1, 0}, (double[]){1, 2, 0});
}
END_TEST

START_TEST(coplanar_triangles_give_the_farthest_corners_of_their_overlap)
{
    // The overlap has the corners (1, 0) (8/3, 0) (2, 2) (1, 3), all of them crossings of edges.
    const double b[3][3] = {{1, -1, 0}, {3, -1, 0}, {1, 5, 0}};
    CheckEnds(s_face, b, (double[]){1, 3, 0}, (double[]){8.0 / 3, 0, 0});
}
END_TEST

START_TEST(a_segment_across_a_face_gives_the_part_inside)
{
    const double b[3][3] = {{-5, 1, 0}, {5, 1, 0}, {5, 1, 0}};
    CheckEnds(s_face, b, (double[]){0, 1, 0}, (double[]){3, 1, 0});
}
END_TEST

START_TEST(a_segment_through_a_face_gives_one_point_twice)
{
    const double b[3][3] = {{1, 1, 1}, {1, 1, -1}, {1, 1, -1}};
    CheckEnds(s_face, b, (double[]){1, 1, 0}, (double[]){1, 1, 0});
}
END_TEST

START_TEST(crossing_segments_give_one_point_twice)
{
    const double b[3][3] = {{1, 3, 2}, {3, 1, 2}, {3, 1, 2}};
    CheckEnds(s_diagonal, b, (double[]){2, 2, 2}, (double[]){2, 2, 2});
}
END_TEST

START_TEST(collinear_segments_give_their_overlap)
{
    const double b[3][3] = {{6, 6, 6}, {2, 2, 2}, {2, 2, 2}};
    CheckEnds(s_diagonal, b, (double[]){2, 2, 2}, (double[]){4, 4, 4});
}
END_TEST

START_TEST(a_point_gives_itself_twice)
{
    const double b[3][3] = {{1, 1, 0}, {1, 1, 0}, {1, 1, 0}};
    CheckEnds(s_face, b, b[0], b[0]);
    CheckEnds(b, b, b[0], b[0]);
}
END_TEST

//  ---- against the oracle ----------------------------------------------------------------------------------

START_TEST(ends_are_the_farthest_corners_of_the_exact_intersection)
{
    qcRandom random = {500 + (uint64_t)_i};
    int penetrating = 0;
    const int count = qcGetTestPairCount(50000) / qc_pairKindCount;
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        qcOracleAnswer exact;
        qcTrianglePair_Make(&random, (qcPairKind)_i, &pair);
        if (i % 2 == 0)
            qcTrianglePair_Disturb(&random, &pair);
        qcOracle_Intersect(pair.a, pair.b, &exact);
        if (exact.relation != qc_relationPenetrating)
            continue;
        ++penetrating;
        qcClaim_Segment(&pair, &exact);
    }
    ck_assert_int_gt(penetrating, count / 20);
}
END_TEST

int main(void)
{
    TCase* tcase = qcMakeCase("intersection segment");
    tcase_add_test(tcase, triangles_that_cross_share_the_overlap_of_two_intervals);
    tcase_add_test(tcase, identical_triangles_give_their_longest_edge);
    tcase_add_test(tcase, a_coplanar_triangle_inside_gives_its_longest_edge);
    tcase_add_test(tcase, coplanar_triangles_give_the_farthest_corners_of_their_overlap);
    tcase_add_test(tcase, a_segment_across_a_face_gives_the_part_inside);
    tcase_add_test(tcase, a_segment_through_a_face_gives_one_point_twice);
    tcase_add_test(tcase, crossing_segments_give_one_point_twice);
    tcase_add_test(tcase, collinear_segments_give_their_overlap);
    tcase_add_test(tcase, a_point_gives_itself_twice);
    tcase_add_loop_test(tcase, ends_are_the_farthest_corners_of_the_exact_intersection, 0, qc_pairKindCount);
    return qcRunCase("intersection segment", tcase);
}
