// The orientation predicates give the sign of the exact determinant, for any finite coordinates.
#include "triangle/exact.h"
#include "support/oracle.h"
#include "support/pairs.h"
#include "support/suite.h"

#include <float.h>
#include <math.h>
#include <string.h>

static void CheckOrient3d(const double p[4][3])
{
    int expected = qcOracle_Orient3d(p[0], p[1], p[2], p[3]);
    int got = qcOrient3d(p[0], p[1], p[2], p[3], NULL);
    ck_assert_msg(got == expected, "orient3d: %d instead of %d for %a, %a, %a; %a, %a, %a; %a, %a, %a; %a, %a, %a", got,
                  expected, p[0][0], p[0][1], p[0][2], p[1][0], p[1][1], p[1][2], p[2][0], p[2][1], p[2][2], p[3][0],
                  p[3][1], p[3][2]);
}

static void CheckOrient2d(const double p[3][3])
{
    for (int u = 0; u < 3; ++u)
        for (int v = 0; v < 3; ++v)
        {
            int expected = qcOracle_Orient2d(p[0], p[1], p[2], u, v);
            int got = qcOrient2d(p[0], p[1], p[2], u, v, NULL);
            ck_assert_msg(got == expected, "orient2d (%d, %d): %d instead of %d for %a, %a, %a; %a, %a, %a; %a, %a, %a",
                          u, v, got, expected, p[0][0], p[0][1], p[0][2], p[1][0], p[1][1], p[1][2], p[2][0], p[2][1],
                          p[2][2]);
        }
}

static void CopyPoints(double points[4][3], const double (*corners)[3], const double* last)
{
    memcpy(points, corners, 3 * sizeof points[0]);
    memcpy(points[3], last, sizeof points[3]);
}

START_TEST(a_point_on_the_side_of_the_normal_is_positive)
{
    const double a[3] = {1, 1, 1}, b[3] = {2, 1, 1}, c[3] = {1, 2, 1};
    const double above[3] = {1, 1, 2}, below[3] = {5, -7, 0}, within[3] = {8, 9, 1};
    ck_assert_int_eq(qcOrient3d(a, b, c, above, NULL), 1);
    ck_assert_int_eq(qcOrient3d(a, b, c, below, NULL), -1);
    ck_assert_int_eq(qcOrient3d(a, b, c, within, NULL), 0);
    ck_assert_int_eq(qcOracle_Orient3d(a, b, c, above), 1);
    ck_assert_int_eq(qcOracle_Orient3d(a, b, c, below), -1);
    ck_assert_int_eq(qcOracle_Orient3d(a, b, c, within), 0);
}
END_TEST

START_TEST(a_left_turn_is_positive_in_the_named_coordinates)
{
    const double a[3] = {0, 7, 0}, b[3] = {1, -3, 0}, c[3] = {0, 5, 1};
    ck_assert_int_eq(qcOrient2d(a, b, c, 0, 2, NULL), 1);
    ck_assert_int_eq(qcOrient2d(a, b, c, 2, 0, NULL), -1);
    ck_assert_int_eq(qcOrient2d(a, b, c, 1, 1, NULL), 0);
    ck_assert_int_eq(qcOracle_Orient2d(a, b, c, 0, 2), 1);
    ck_assert_int_eq(qcOracle_Orient2d(a, b, c, 2, 0), -1);
    ck_assert_int_eq(qcOracle_Orient2d(a, b, c, 1, 1), 0);
}
END_TEST

START_TEST(one_ulp_off_a_plane_changes_the_sign_at_every_scale)
{
    for (int exponent = -1074; exponent <= 1020; ++exponent)
    {
        const double s = ldexp(1, exponent);
        const double a[3] = {s, s, s}, b[3] = {2 * s, s, 0}, c[3] = {s, 2 * s, 0};
        double d[3] = {0, s, 2 * s}; // in the plane x + y + z = 3 s
        ck_assert_int_eq(qcOrient3d(a, b, c, d, NULL), 0);
        d[2] = nextafter(2 * s, INFINITY);
        ck_assert_int_eq(qcOrient3d(a, b, c, d, NULL), 1);
        d[2] = nextafter(2 * s, 0);
        ck_assert_int_eq(qcOrient3d(a, b, c, d, NULL), -1);
    }
}
END_TEST

START_TEST(one_ulp_off_a_line_changes_the_sign_at_every_scale)
{
    for (int exponent = -1074; exponent <= 1020; ++exponent)
    {
        const double s = ldexp(1, exponent);
        const double a[3] = {0, 0, 0}, b[3] = {s, 2 * s, 0};
        double c[3] = {2 * s, 4 * s, 0};
        ck_assert_int_eq(qcOrient2d(a, b, c, 0, 1, NULL), 0);
        c[1] = nextafter(4 * s, INFINITY);
        ck_assert_int_eq(qcOrient2d(a, b, c, 0, 1, NULL), 1);
        c[1] = nextafter(4 * s, 0);
        ck_assert_int_eq(qcOrient2d(a, b, c, 0, 1, NULL), -1);
    }
}
END_TEST

START_TEST(signs_are_exact_for_the_largest_and_the_smallest_double_in_one_call)
{
    const double large = DBL_MAX, small = 0x1p-1074;
    const double coordinates[] = {-large, -1, -small, 0, small, 0.1, large};
    double p[4][3];
    qcRandom random = {7};
    for (int i = 0; i < 20000; ++i)
    {
        for (int j = 0; j < 12; ++j)
            p[j / 3][j % 3] = coordinates[qcRandom_Below(&random, 7)];
        CheckOrient3d(p);
        CheckOrient2d(p);
    }
}
END_TEST

/// Integers of up to 63 bits times a power of two, many in one plane.
START_TEST(signs_are_exact_for_short_integers_and_slightly_longer_ones)
{
    qcRandom random = {17};
    int zeros = 0;
    for (int i = 0; i < 50000; ++i)
    {
        double p[4][3];
        int bits = 2 + (int)qcRandom_Below(&random, 62), exponent = (int)qcRandom_Integer(&random, -1074, 900);
        for (int j = 0; j < 12; ++j)
        {
            int own = qcRandom_Below(&random, 3) == 0 ? (int)qcRandom_Below(&random, (uint32_t)bits) : bits;
            p[j / 3][j % 3] = trunc(ldexp(qcRandom_Uniform(&random, -1.0, 1.0), own));
        }
        // The last in the plane of the others, within rounding, or next to it.
        double s = (double)qcRandom_Integer(&random, -1, 2), t = (double)qcRandom_Integer(&random, -1, 2);
        for (int axis = 0; axis < 3 && i % 4 != 0; ++axis)
            p[3][axis] = p[0][axis] + s * (p[1][axis] - p[0][axis]) + t * (p[2][axis] - p[0][axis]) +
                         (i % 4 == 1 ? (double)qcRandom_Integer(&random, -1, 1) : 0.0);
        for (int j = 0; j < 12; ++j)
            p[j / 3][j % 3] = ldexp(p[j / 3][j % 3], exponent);
        CheckOrient3d(p);
        CheckOrient2d(p);
        zeros += qcOracle_Orient3d(p[0], p[1], p[2], p[3]) == 0;
    }
    ck_assert_int_gt(zeros, 5000);
}
END_TEST

START_TEST(signs_near_zero_are_exact)
{
    qcRandom random = {11};
    const int count = qcGetTestPairCount(50000);
    int signs[3] = {0, 0, 0};
    for (int i = 0; i < count; ++i)
    {
        qcTrianglePair pair;
        double p[4][3];
        qcTrianglePair_MakeAny(&random, &pair);
        CopyPoints(p, pair.a, pair.b[qcRandom_Below(&random, 3)]);
        CheckOrient3d(p);
        CheckOrient2d(p + 1);
        ++signs[1 + qcOracle_Orient3d(p[0], p[1], p[2], p[3])];
    }
    for (int i = 0; i < 3; ++i)
        ck_assert_int_gt(signs[i], count / 10);
}
END_TEST

START_TEST(exchanging_two_points_changes_the_sign)
{
    qcRandom random = {13};
    for (int i = 0; i < 20000; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        const double *a = pair.a[0], *b = pair.a[1], *c = pair.a[2], *d = pair.b[0];
        int sign = qcOrient3d(a, b, c, d, NULL);
        ck_assert_int_eq(qcOrient3d(b, a, c, d, NULL), -sign);
        ck_assert_int_eq(qcOrient3d(a, c, b, d, NULL), -sign);
        ck_assert_int_eq(qcOrient3d(a, b, d, c, NULL), -sign);
        ck_assert_int_eq(qcOrient3d(d, b, c, a, NULL), -sign);
        ck_assert_int_eq(qcOrient2d(a, c, b, 0, 1, NULL), -qcOrient2d(a, b, c, 0, 1, NULL));
        ck_assert_int_eq(qcOrient2d(a, b, c, 1, 0, NULL), -qcOrient2d(a, b, c, 0, 1, NULL));
    }
}
END_TEST

START_TEST(the_filter_decides_points_in_general_position)
{
    qcRandom random = {17};
    uint64_t undecided = 0;
    for (int i = 0; i < 10000; ++i)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&random, qc_pairGeneral, &pair);
        qcOrient3d(pair.a[0], pair.a[1], pair.a[2], pair.b[0], &undecided);
        qcOrient2d(pair.a[0], pair.a[1], pair.a[2], 0, 1, &undecided);
    }
    ck_assert_uint_eq(undecided, 0);
}
END_TEST

START_TEST(undecided_predicates_are_counted)
{
    const double a[3] = {0, 0, 0}, b[3] = {0.1, 0, 0.1}, c[3] = {0, 0.1, 0.1}, d[3] = {0.1, 0.1, 0.2};
    uint64_t undecided = 5;
    ck_assert_int_eq(qcOrient3d(a, b, c, d, &undecided), 0);
    ck_assert_uint_eq(undecided, 6);
    ck_assert_int_eq(qcOrient2d(a, d, d, 0, 1, &undecided), 0);
    ck_assert_uint_eq(undecided, 7);
}
END_TEST

START_TEST(two_points_in_one_place_need_no_integers)
{
    qcRandom random = {31};
    uint64_t undecided = 0;
    for (int i = 0; i < 600; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        double* points[4] = {pair.a[0], pair.a[1], pair.a[2], pair.b[0]};
        int from = i % 4, to = (from + 1 + i / 4 % 3) % 4;
        memcpy(points[to], points[from], 3 * sizeof(double));
        ck_assert_int_eq(qcOrient3d(points[0], points[1], points[2], points[3], &undecided), 0);
    }
    ck_assert_uint_eq(undecided, 0);
}
END_TEST

START_TEST(points_with_a_common_coordinate_need_no_integers)
{
    qcRandom random = {32};
    uint64_t undecided = 0;
    for (int i = 0; i < 600; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        double* points[4] = {pair.a[0], pair.a[1], pair.a[2], pair.b[0]};
        int axis = i % 3;
        for (int k = 1; k < 4; k++)
            points[k][axis] = points[0][axis];
        ck_assert_int_eq(qcOracle_Orient3d(points[0], points[1], points[2], points[3]), 0);
        ck_assert_int_eq(qcOrient3d(points[0], points[1], points[2], points[3], &undecided), 0);
        ck_assert_int_eq(qcOrient2d(points[0], points[1], points[2], axis, (axis + 1) % 3, &undecided), 0);
    }
    ck_assert_uint_eq(undecided, 0);
}
END_TEST

QC_RUN_TESTS("orientation", a_point_on_the_side_of_the_normal_is_positive,
             a_left_turn_is_positive_in_the_named_coordinates, one_ulp_off_a_plane_changes_the_sign_at_every_scale,
             one_ulp_off_a_line_changes_the_sign_at_every_scale,
             signs_are_exact_for_the_largest_and_the_smallest_double_in_one_call,
             signs_are_exact_for_short_integers_and_slightly_longer_ones, signs_near_zero_are_exact,
             exchanging_two_points_changes_the_sign, the_filter_decides_points_in_general_position,
             undecided_predicates_are_counted, two_points_in_one_place_need_no_integers,
             points_with_a_common_coordinate_need_no_integers)
