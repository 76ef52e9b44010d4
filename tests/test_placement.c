// Where rigid bodies are, and what goes from one's coordinates to another's: against long double, and against vertices
// as qcBody_GetVertex rounds them.
#include "placement.h"

#include "status.h"
#include "suite.h"
#include "surfaces.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

//  ---- transforms ----------------------------------------------------------------------------------

typedef enum Shape
{
    shapeTurned,
    shapeScaled,  ///< along its own axes
    shapeSheared, ///< by small integers, exactly
    shapeMirrored,
    shapePlate,  ///< flattened in one direction, down to a share
    shapeNeedle, ///< in two
    shapeCount
} Shape;

static void Multiply(const double a[9], const double b[9], double product[9])
{
    for (int i = 0; i < 9; i++)
        product[i] = a[i / 3 * 3] * b[i % 3] + a[i / 3 * 3 + 1] * b[i % 3 + 3] + a[i / 3 * 3 + 2] * b[i % 3 + 6];
}

static void MakeRotation(qcRandom* random, double m[9])
{
    double q[4], length = 0.0;
    for (int i = 0; i < 4; i++)
    {
        q[i] = qcRandom_Uniform(random, -1.0, 1.0);
        length += q[i] * q[i];
    }
    double s = 2.0 / length, x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1.0 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
                         s * (x * y + z * w), 1.0 - s * (x * x + z * z), s * (y * z - x * w),
                         s * (x * z - y * w), s * (y * z + x * w), 1.0 - s * (x * x + y * y)};
    memcpy(m, r, sizeof r);
}

static void MakeLinear(qcRandom* random, Shape shape, double share, double scale, double m[9])
{
    double left[9], right[9], half[9], middle[9] = {0.0};
    MakeRotation(random, left);
    MakeRotation(random, right);
    for (int k = 0; k < 3; k++)
    {
        bool flat = (shape == shapePlate && k == 0) || (shape == shapeNeedle && k != 0);
        middle[4 * k] = flat ? share : shape == shapeTurned ? 1.0 : qcRandom_Uniform(random, 0.2, 2.0);
    }
    middle[0] = shape == shapeMirrored ? -middle[0] : middle[0];
    Multiply(left, middle, half);
    Multiply(half, right, m);
    for (int i = 0; i < 9 && (shape == shapeScaled || shape == shapeSheared); i++)
        m[i] = shape == shapeScaled ? middle[i]
               : i % 4 == 0         ? 1.0
               : i % 3 > i / 3      ? qcRandom_Integer(random, -3, 3)
                                    : 0.0;
    for (int i = 0; i < 9; i++)
        m[i] *= scale;
}

/// Of any shape; 2^-k as large.
static void MakeAnyLinear(qcRandom* random, int leastExponent, int mostExponent, double m[9])
{
    double share = exp2(-qcRandom_Uniform(random, 0.0, 11.0));
    double scale = ldexp(1.0, (int)qcRandom_Integer(random, leastExponent, mostExponent));
    MakeLinear(random, (Shape)qcRandom_Below(random, shapeCount), share, scale, m);
}

static void GetWorld(const qcTransform* transform, const double x[3], double world[3])
{
    double local[3] = {x[0], x[1], x[2]};
    qcBody body = {.local = local, .transform = *transform};
    qcBody_GetVertex(&body, 0, world);
}

//  ---- what is true --------------------------------------------------------------------------------

static long double RowSum(const long double m[9])
{
    long double largest = 0.0L;
    for (int i = 0; i < 3; i++)
        largest = fmaxl(largest, fabsl(m[3 * i]) + fabsl(m[3 * i + 1]) + fabsl(m[3 * i + 2]));
    return largest;
}

/// The condition number by row sums, or infinity where even long double finds no inverse: its product with the matrix is
/// looked at.
static long double InvertWell(const double m[9], long double inverse[9])
{
    long double wide[9], rest[9];
    for (int i = 0; i < 9; i++)
        wide[i] = m[i];
    for (int i = 0; i < 9; i++)
    {
        int r = (i % 3 + 1) % 3, s = (i % 3 + 2) % 3, u = (i / 3 + 1) % 3, v = (i / 3 + 2) % 3;
        inverse[i] = wide[3 * r + u] * wide[3 * s + v] - wide[3 * r + v] * wide[3 * s + u];
    }
    long double determinant = wide[0] * inverse[0] + wide[1] * inverse[3] + wide[2] * inverse[6];
    if (determinant == 0.0L)
        return INFINITY;
    for (int i = 0; i < 9; i++)
        inverse[i] /= determinant;
    for (int i = 0; i < 9; i++)
    {
        rest[i] = i % 4 == 0 ? -1.0L : 0.0L;
        for (int k = 0; k < 3; k++)
            rest[i] += wide[i / 3 * 3 + k] * inverse[3 * k + i % 3];
    }
    return RowSum(rest) < 0.01L ? RowSum(wide) * RowSum(inverse) : INFINITY;
}

START_TEST(a_transform_is_invertible_up_to_a_condition_number_of_4096)
{
    qcRandom random = {1};
    size_t count[2] = {0, 0};
    for (int i = 0; i < 200000; i++)
    {
        qcTransform t = qcIdentityTransform();
        double share = exp2(-qcRandom_Uniform(&random, 0.0, i % 2 == 0 ? 16.0 : 70.0));
        MakeLinear(&random, (Shape)qcRandom_Below(&random, shapeCount), share, 1.0, t.linear);
        for (int k = 0; k < 9 && i % 16 == 0; k++)
            t.linear[k] = qcRandom_Integer(&random, -1, 1);
        long double inverse[9], condition = InvertWell(t.linear, inverse);
        int exponent = (int)qcRandom_Integer(&random, -190, 190);
        for (int k = 0; k < 9; k++)
            t.linear[k] = ldexp(t.linear[k], exponent);
        bool invertible = qcTransform_IsInvertible(&t);
        CHECK_THAT(invertible || condition > 4095.9L, "refused: condition %Lg, share %g", condition, share);
        CHECK_THAT(!invertible || condition < 4096.1L, "accepted: condition %Lg, share %g", condition, share);
        count[invertible]++;
    }
    ck_assert(count[0] > 20000 && count[1] > 20000);
}
END_TEST

START_TEST(what_has_no_inverse_in_double_is_not_invertible)
{
    const double scales[] = {0.0, 1e-300, 1e-61, 1e61, 1e300, DBL_MAX};
    for (size_t i = 0; i < sizeof scales / sizeof scales[0]; i++)
    {
        qcTransform t = qcIdentityTransform();
        for (int k = 0; k < 3; k++)
            t.linear[4 * k] = scales[i];
        CHECK_THAT(!qcTransform_IsInvertible(&t), "a scale of %g", scales[i]);
    }
    for (int flat = 1; flat < 8; flat++)
    {
        qcTransform t = qcIdentityTransform();
        for (int k = 0; k < 3; k++)
            t.linear[4 * k] = (flat >> k & 1) != 0 ? 0.0 : 1.0;
        CHECK_THAT(!qcTransform_IsInvertible(&t), "flat along axes %d", flat);
    }
}
END_TEST

//  ---- from one to another -------------------------------------------------------------------------

/// Two bodies that meet at points `x[0]` and `x[1]` of theirs, with boxes around them.
typedef struct Meeting
{
    qcPlacement placement[2];
    double x[2][3];
    double apart; ///< the greatest difference of a coordinate of the two points in the world
} Meeting;

static double FindApart(const qcTransform* transform, const double x[3], const double world[3])
{
    double at[3], apart = 0.0;
    GetWorld(transform, x, at);
    for (int axis = 0; axis < 3; axis++)
        apart = fmax(apart, fabs(at[axis] - world[axis]));
    return apart;
}

/// Another point that goes to the same point of the world, or one nearly so.
static void MoveWithin(qcRandom* random, Meeting* m, const long double inverse[9], const double world[3])
{
    const qcTransform* t = &m->placement[0].transform;
    for (int attempt = 0; attempt < 12; attempt++)
    {
        long double step[3];
        double x[3];
        for (int axis = 0; axis < 3; axis++)
        {
            double size = fabs(t->translation[axis]) + fabs(world[axis]);
            step[axis] = (long double)(size * 0x1p-53 * qcRandom_Uniform(random, -1.0, 1.0));
        }
        for (int i = 0; i < 3; i++)
            x[i] = (double)(m->x[0][i] + inverse[3 * i] * step[0] + inverse[3 * i + 1] * step[1] +
                            inverse[3 * i + 2] * step[2]);
        double apart = FindApart(t, x, world);
        if (apart > m->apart || (apart == m->apart && attempt > 8))
            continue;
        m->apart = apart;
        memcpy(m->x[0], x, sizeof x);
    }
}

static void MakeBox(qcRandom* random, const double x[3], double size, qcPlacement* placement)
{
    bool tight = qcRandom_Below(random, 2) == 0;
    for (int axis = 0; axis < 3; axis++)
    {
        placement->lower[axis] = tight ? x[axis] : x[axis] - qcRandom_Uniform(random, 0.0, size);
        placement->upper[axis] = tight ? x[axis] : x[axis] + qcRandom_Uniform(random, 0.0, size);
    }
}

/// False: no meeting was found, as the first is not invertible.
static bool Meet(qcRandom* random, Meeting* m)
{
    int range = (int)qcRandom_Below(random, 3) * 60;
    double size = ldexp(1.0, (int)qcRandom_Integer(random, -range, range)), world[3], scale[2];
    double away = qcRandom_Below(random, 3) == 0 ? 0.0 : pow(10.0, qcRandom_Integer(random, 0, 12));
    for (int side = 0; side < 2; side++)
    {
        qcTransform* t = &m->placement[side].transform;
        *t = qcIdentityTransform();
        if (qcRandom_Below(random, 6) != 0)
            MakeAnyLinear(random, -range, range, t->linear);
        scale[side] = fabs(t->linear[0]) + fabs(t->linear[1]) + fabs(t->linear[2]);
        for (int axis = 0; axis < 3; axis++)
            t->translation[axis] = size * (side == 0 ? away * qcRandom_Uniform(random, -1.0, 1.0)
                                                     : m->placement[0].transform.translation[axis]) +
                                   size * qcRandom_Uniform(random, -1.0, 1.0);
        // Coordinates of a body's own may be far from their origin too.
        double local = size / scale[side] * (qcRandom_Below(random, 3) == 0 ? 1e3 : 1.0);
        for (int axis = 0; axis < 3; axis++)
            m->x[side][axis] = qcRandom_Below(random, 8) == 0 ? 0.0 : local * qcRandom_Uniform(random, -1.0, 1.0);
    }
    qcTransform* a = &m->placement[0].transform;
    long double inverse[9];
    InvertWell(a->linear, inverse);
    if (!qcTransform_IsInvertible(a))
        return false;
    // The second is moved so that they meet; what it takes the point to then is where the first's is looked for.
    double to[3];
    GetWorld(a, m->x[0], to);
    GetWorld(&m->placement[1].transform, m->x[1], world);
    for (int axis = 0; axis < 3; axis++)
        m->placement[1].transform.translation[axis] += to[axis] - world[axis];
    GetWorld(&m->placement[1].transform, m->x[1], world);
    for (int i = 0; i < 3; i++)
    {
        long double x = 0.0L;
        for (int k = 0; k < 3; k++)
            x += inverse[3 * i + k] * ((long double)world[k] - (long double)a->translation[k]);
        m->x[0][i] = (double)x;
    }
    m->apart = FindApart(a, m->x[0], world);
    MoveWithin(random, m, inverse, world);
    for (int side = 0; side < 2; side++)
        MakeBox(random, m->x[side], size / scale[side], &m->placement[side]);
    return true;
}

START_TEST(points_that_meet_in_the_world_meet_in_coordinates_of_either)
{
    qcRandom random = {2};
    size_t same = 0;
    double worst = 0.0, worstFar = 0.0;
    for (int i = 0; i < 100000; i++)
    {
        Meeting m;
        if (!Meet(&random, &m))
            continue;
        same += m.apart == 0.0;
        qcRelativePlacement r = qcRelativePlacement_Find(&m.placement[0], &m.placement[1]);
        for (int axis = 0; axis < 3; axis++)
        {
            long double at = (long double)r.shift[axis] - (long double)m.x[0][axis];
            for (int k = 0; k < 3; k++)
                at += (long double)r.linear[axis][k] * (long double)m.x[1][k];
            double off = (double)fabsl(at);
            CHECK_THAT(off <= r.error[axis] + r.reach[axis] * m.apart, "meeting %d: %a off, %a allowed", i, off,
                       r.error[axis]);
            if (m.apart == 0.0 && r.error[axis] > 0.0)
                worst = fmax(worst, off / r.error[axis]);
            else if (r.error[axis] > 0.0)
                worstFar = fmax(worstFar, off / (r.error[axis] + r.reach[axis] * m.apart));
        }
    }
    printf("same %zu worst 2^%g %g\n", same, log2(worst), log2(worstFar));
    ck_assert_uint_gt(same, 10000);
    // Nor is the bound out of proportion.
    ck_assert(worst > 0x1p-12);
}
END_TEST

START_TEST(reach_and_stretch_are_those_of_the_inverse)
{
    qcRandom random = {3};
    double over = 0.0, under = 0.0;
    for (int i = 0; i < 30000; i++)
    {
        qcPlacement a = {.transform = qcIdentityTransform()}, b = a;
        MakeAnyLinear(&random, -100, 100, a.transform.linear);
        MakeAnyLinear(&random, -100, 100, b.transform.linear);
        long double inverse[9];
        if (!isfinite(InvertWell(a.transform.linear, inverse)) || !qcTransform_IsInvertible(&a.transform))
            continue;
        qcRelativePlacement r = qcRelativePlacement_Find(&a, &b);
        // The longest image of a vector of length 1, by iteration.
        long double v[3] = {0.57L, 0.61L, 0.55L}, stretch = 0.0L;
        for (int step = 0; step < 30; step++)
        {
            long double w[3] = {0}, u[3] = {0}, length = hypotl(v[0], hypotl(v[1], v[2]));
            for (int k = 0; k < 9; k++)
                w[k / 3] += inverse[k] * v[k % 3] / length;
            for (int k = 0; k < 9; k++)
                u[k % 3] += inverse[k] * w[k / 3];
            stretch = fmaxl(stretch, hypotl(w[0], hypotl(w[1], w[2])));
            memcpy(v, u, sizeof v);
        }
        under = fmax(under, (double)(stretch / (long double)r.stretch) - 1.0);
        CHECK_THAT((double)stretch <= r.stretch, "transform %d: vectors grow %La times, not %a", i, stretch, r.stretch);
        CHECK_THAT((double)stretch > 0.57 * r.stretch, "transform %d: vectors grow only %La times", i, stretch);
        for (int axis = 0; axis < 3; axis++)
        {
            const long double* row = inverse + 3 * axis;
            long double reach = fabsl(row[0]) + fabsl(row[1]) + fabsl(row[2]);
            double off = fabs((double)(reach / (long double)r.reach[axis]) - 1.0);
            over = fmax(over, off);
            CHECK_THAT(off < 1e-9, "transform %d: reach wrong by %g", i, off);
        }
    }
    printf("reach off %g stretch under %g\n", over, under);
}
END_TEST

QC_RUN_TESTS("placement", a_transform_is_invertible_up_to_a_condition_number_of_4096,
             what_has_no_inverse_in_double_is_not_invertible,
             points_that_meet_in_the_world_meet_in_coordinates_of_either, reach_and_stretch_are_those_of_the_inverse)
