// The filter of every instruction set that the machine has keeps what is within the reach, by rational arithmetic, and
// drops nearly all else.
#include "oracle.h"
#include "pairs.h"
#include "suite.h"
#include "surfaces.h"

#include <math.h>

//  ---- filter --------------------------------------------------------------------------------------

enum
{
    qc_mostInBatch = 48
};

/// Triangles of both sides, side by side: pair i is of triangle i and triangle i.
typedef struct Batch
{
    qcPoint points[2][3 * qc_mostInBatch];
    qcCorners corners[qc_mostInBatch];
    size_t count;
} Batch;

/// The last is the one that is asked about; the others are what was asked before.
static void Push(Batch* batch, double a[3][3], double b[3][3])
{
    if (batch->count == qc_mostInBatch)
        batch->count = 0;
    size_t at = batch->count++;
    for (uint32_t c = 0; c < 3; c++)
    {
        qcPoint *p = &batch->points[0][3 * at + c], *q = &batch->points[1][3 * at + c];
        for (int axis = 0; axis < 3; axis++)
        {
            p->x[axis] = (float)a[c][axis];
            q->x[axis] = (float)b[c][axis];
        }
        p->x[3] = q->x[3] = 0.0f;
        batch->corners[at].vertex[c] = (uint32_t)(3 * at) + c;
    }
}

/// Is the last pair kept, wherever it stands? What is left has to be a part of what was given, in its order.
static bool Keeps(const qcSurfaceKernels* k, const Batch* batch, const qcFilterBound* bound, qcRandom* random)
{
    qcFilterSide a = {batch->corners, batch->points[0]}, b = {batch->corners, batch->points[1]};
    qcPlacePair pairs[qc_mostInBatch + 1], given[qc_mostInBatch + 1];
    uint32_t last = (uint32_t)batch->count - 1, place = qcRandom_Below(random, (uint32_t)batch->count);
    for (uint32_t i = 0; i < batch->count; i++)
        given[i].a = given[i].b = i == place ? last : i == last ? place : i;
    memcpy(pairs, given, sizeof given);
    size_t kept = k->filter(&a, &b, bound, pairs, batch->count), at = 0;
    CHECK_THAT(kept <= batch->count, "%s: %zu of %zu kept", k->name, kept, batch->count);
    bool isKept = false;
    for (size_t i = 0; i < kept; i++)
    {
        while (at < batch->count && (given[at].a != pairs[i].a || given[at].b != pairs[i].b))
            at++;
        CHECK_THAT(at < batch->count, "%s: pair %zu was not given there", k->name, i);
        at++;
        isKept = isKept || pairs[i].a == last;
    }
    return isKept;
}

static float Up(double value)
{
    return nextafterf((float)value, INFINITY);
}

/// Into the unit box, by a power of two: 2^-24 is what that costs at most. False: not to be told by doubles.
static bool FrameOf(const qcTrianglePair* pair, double margin, double* unit, double origin[3])
{
    double widest = margin;
    for (int axis = 0; axis < 3; axis++)
    {
        double low = pair->a[0][axis], high = low;
        for (int c = 0; c < 3; c++)
        {
            low = fmin(low, fmin(pair->a[c][axis], pair->b[c][axis]));
            high = fmax(high, fmax(pair->a[c][axis], pair->b[c][axis]));
        }
        origin[axis] = low;
        widest = fmax(widest, high - low);
    }
    if (widest > 1e280 || widest < 1e-280)
        return false;
    int exponent;
    frexp(widest, &exponent);
    *unit = ldexp(1.0, -exponent);
    return true;
}

static void ToFrame(const double corners[3][3], const double origin[3], double unit, double mapped[3][3])
{
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            mapped[c][axis] = (corners[c][axis] - origin[axis]) * unit;
}

/// Fails the test where a pair within the margin is dropped; says whether it was within.
static bool CheckKept(const qcTrianglePair* pair, double margin, Batch* batch, qcRandom* random)
{
    double unit, origin[3], a[3][3], b[3][3];
    qcOracleDistance* distance = qcOracleDistance_Create(pair->a, pair->b);
    bool isWithin = qcOracleDistance_Compare(distance, margin) <= 0;
    qcOracleDistance_Destroy(distance);
    if (!isWithin || !FrameOf(pair, margin, &unit, origin))
        return false;
    ToFrame(pair->a, origin, unit, a);
    ToFrame(pair->b, origin, unit, b);
    Push(batch, a, b);
    qcFilterBound bound = {.pointError = 0x1p-24f, .reach = Up(margin * unit)};
    char text[1024];
    FOR_EACH_KERNELS(k)
    CHECK_THAT(Keeps(k, batch, &bound, random), "%s drops %s, margin %a", k->name, qcTrianglePair_Print(pair, text),
               margin);
    return true;
}

START_TEST(the_filter_keeps_what_meets)
{
    qcRandom random = {9};
    Batch batch = {.count = 0};
    int within = 0, count = qcGetTestPairCount(9000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&random, &pair);
        within += CheckKept(&pair, 0.0, &batch, &random);
    }
    ck_assert_int_gt(within, count / 5);
}
END_TEST

/// Is the last pair called a sure hit?
static bool IsSure(const qcSurfaceKernels* k, const Batch* batch, const qcFilterBound* bound)
{
    qcFilterSide a = {batch->corners, batch->points[0]}, b = {batch->corners, batch->points[1]};
    qcPlacePair pairs[qc_mostInBatch];
    uint8_t times[qc_mostInBatch] = {0};
    for (uint32_t i = 0; i < batch->count; i++)
        pairs[i].a = pairs[i].b = i;
    size_t sure = k->findPiercing(&a, &b, bound, pairs, batch->count);
    CHECK_THAT(sure <= batch->count, "%s: %zu of %zu sure", k->name, sure, batch->count);
    bool isSure = false;
    for (size_t i = 0; i < batch->count; i++)
    {
        CHECK_THAT(pairs[i].a == pairs[i].b && pairs[i].a < batch->count && times[pairs[i].a]++ == 0,
                   "%s: pair %zu is lost or twice there", k->name, i);
        isSure = isSure || (i < sure && pairs[i].a + 1 == batch->count);
    }
    return isSure;
}

/// Random triangles, some of which only just reach each other.
static void MakeNearlyPiercing(qcRandom* random, qcTrianglePair* pair)
{
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
        {
            pair->a[c][axis] = qcRandom_Uniform(random, -1.0, 1.0);
            pair->b[c][axis] = qcRandom_Uniform(random, -1.0, 1.0);
        }
    // A corner of B close to a point of A, one side or the other.
    if (qcRandom_Below(random, 2) == 0)
        return;
    double u = qcRandom_Uniform(random, 0.0, 0.6), v = qcRandom_Uniform(random, 0.0, 0.4);
    double off = qcRandom_Uniform(random, -1.0, 1.0) * (qcRandom_Below(random, 2) == 0 ? 0.1 : 0x1p-22);
    for (int axis = 0; axis < 3; axis++)
        pair->b[0][axis] = pair->a[0][axis] + u * (pair->a[1][axis] - pair->a[0][axis]) +
                           v * (pair->a[2][axis] - pair->a[0][axis]) + off;
}

START_TEST(a_sure_hit_penetrates)
{
    qcRandom random = {19};
    Batch batch = {.count = 0};
    int sure = 0, penetrating = 0, count = qcGetTestPairCount(12000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        if (i % 2 == 0)
            qcTrianglePair_MakeAny(&random, &pair);
        else
            MakeNearlyPiercing(&random, &pair);
        bool penetrates = qcOracle_Relate(pair.a, pair.b) == qc_relationPenetrating;
        double unit, origin[3], a[3][3], b[3][3];
        if (!FrameOf(&pair, 0.0, &unit, origin))
            continue;
        ToFrame(pair.a, origin, unit, a);
        ToFrame(pair.b, origin, unit, b);
        Push(&batch, a, b);
        qcFilterBound bound = {.pointError = 0x1p-24f, .reach = Up(0.0)};
        penetrating += penetrates && i % 2 == 1;
        char text[1024];
        FOR_EACH_KERNELS(k)
        {
            bool isSure = IsSure(k, &batch, &bound);
            CHECK_THAT(!isSure || penetrates, "%s: %s", k->name, qcTrianglePair_Print(&pair, text));
            sure += isSure && i % 2 == 1 && k == qcSurfaceKernels_Get();
        }
    }
    // Nearly all that aren't built to be on the border.
    ck_assert_int_gt(penetrating, count / 20);
    ck_assert_int_gt(sure, penetrating * 8 / 10);
}
END_TEST

START_TEST(the_filter_keeps_what_is_exactly_the_reach_apart)
{
    qcRandom random = {10};
    Batch batch = {.count = 0};
    int within = 0, count = qcGetTestPairCount(4000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        double distance;
        qcTrianglePair_MakeApart(&random, 1 + i % 3, 1 + i / 3 % 3, &pair, &distance);
        within += CheckKept(&pair, distance, &batch, &random);
        qcTrianglePair_MoveByUlps(&random, &pair);
        CheckKept(&pair, distance, &batch, &random);
    }
    ck_assert_int_gt(within, count / 2);
}
END_TEST

START_TEST(the_filter_keeps_what_meets_in_exact_coordinates)
{
    // Nothing but the filter's own rounding.
    qcRandom random = {11};
    Batch batch = {.count = 0};
    qcFilterBound bound = {.pointError = 0.0f};
    int meeting = 0;
    for (int i = 0; i < 12000; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&random, (qcPairKind)(qc_pairCoarseGrid + i % (qc_pairKindCount - qc_pairCoarseGrid)),
                            &pair);
        bool isExact = true;
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
                isExact = isExact && (double)(float)pair.a[c][axis] == pair.a[c][axis] &&
                          (double)(float)pair.b[c][axis] == pair.b[c][axis];
        if (!isExact || qcOracle_Relate(pair.a, pair.b) == qc_relationDisjoint)
            continue;
        Push(&batch, pair.a, pair.b);
        meeting++;
        char text[1024];
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &bound, &random), "%s drops %s", k->name, qcTrianglePair_Print(&pair, text));
    }
    ck_assert_int_gt(meeting, 3000);
}
END_TEST

static void Cross(const double a[3], const double b[3], double c[3])
{
    for (int i = 0; i < 3; i++)
        c[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static double Dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Two triangles `apart` along n: a vertex over a face, or two edges that cross; the rest of both leans away from the
/// plane between them, if only by a little.
static void MakeOverEachOther(qcRandom* random, bool edges, double apart, double a[3][3], double b[3][3], double n[3])
{
    double u[3], v[3], foot[3];
    for (int i = 0; i < 3; i++)
    {
        u[i] = qcRandom_Uniform(random, -0.4, 0.4);
        v[i] = qcRandom_Uniform(random, -0.4, 0.4);
        foot[i] = qcRandom_Uniform(random, 0.4, 0.6);
    }
    if (qcRandom_Below(random, 2) == 0)
        u[2] = v[2] = 0.0; // n along an axis: as long as the sum of its coordinates
    Cross(u, v, n);
    double length = sqrt(Dot(n, n));
    for (int i = 0; i < 3; i++)
        n[i] /= length;
    for (int c = 0; c < 3; c++)
    {
        double s = qcRandom_Uniform(random, -0.3, 0.3), t = qcRandom_Uniform(random, -0.3, 0.3),
               lean = qcRandom_Uniform(random, 0.0, 0.01);
        for (int i = 0; i < 3; i++)
        {
            // A has the plane through the foot below it, or its edge along u; B its corner above, or its edge along v.
            a[c][i] = foot[i] + (c == 0 ? -u[i] - v[i] : c == 1 ? u[i] - 0.5 * v[i] : v[i]) * 0.5;
            b[c][i] = foot[i] + n[i] * apart;
            if (edges)
            {
                a[c][i] = foot[i] + (c == 0 ? -0.5 * u[i] : c == 1 ? 0.5 * u[i] : s * u[i] + t * v[i] - lean * n[i]);
                b[c][i] += c == 0 ? -0.5 * v[i] : c == 1 ? 0.5 * v[i] : s * v[i] - t * u[i] + lean * n[i];
            }
            else if (c != 0)
                b[c][i] += s * u[i] + t * v[i] + lean * n[i];
        }
    }
}

START_TEST(the_filter_keeps_what_errors_of_points_part)
{
    // All of one triangle is wrong one way and all of the other the other way.
    qcRandom random = {12};
    Batch batch = {.count = 0};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], error = ldexp(1.0, -4 - i % 21),
                                       apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2);
        MakeOverEachOther(&random, i % 2 == 0, apart, a, b, n);
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        qcFilterBound bound = {.pointError = (float)error, .reach = Up(qcOracleDistance_Get(distance))};
        qcOracleDistance_Destroy(distance);
        double by = error - 0x1p-24; // what rounding to float may add
        for (int axis = 0; axis < 3; axis++)
        {
            double move = n[axis] > 0.0 ? by : n[axis] < 0.0 ? -by : 0.0;
            for (int c = 0; c < 3; c++)
            {
                a[c][axis] -= move;
                b[c][axis] += move;
            }
        }
        Push(&batch, a, b);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &bound, &random), "%s: pair %d, error %a, apart %a", k->name, i, error, apart);
    }
}
END_TEST

START_TEST(the_filter_keeps_what_meets_in_the_first_side_s_frame)
{
    // The second side turned, scaled and moved: errors of what is mapped, and of the floats on the way.
    qcRandom random = {13};
    Batch batch = {.count = 0};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], mapped[3][3], error = ldexp(1.0, -10 - i % 10);
        double apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2), scale = exp2(qcRandom_Uniform(&random, -6.0, 6.0));
        MakeOverEachOther(&random, i % 2 == 0, apart, a, b, n);
        qcFilterBound bound = {.mapped = true, .pointError = (float)error};
        // The rotation of a quaternion, its length left in.
        double q[4] = {qcRandom_Uniform(&random, -1, 1), qcRandom_Uniform(&random, -1, 1),
                       qcRandom_Uniform(&random, -1, 1), qcRandom_Uniform(&random, 0.5, 1)};
        double length = Dot(q, q) + q[3] * q[3];
        for (int r = 0; r < 3; r++)
        {
            int s = (r + 1) % 3, t = (r + 2) % 3;
            bound.linear[r][r] = (float)((q[3] * q[3] + q[r] * q[r] - q[s] * q[s] - q[t] * q[t]) / length * scale);
            bound.linear[r][s] = (float)(2.0 * (q[r] * q[s] - q[t] * q[3]) / length * scale);
            bound.linear[r][t] = (float)(2.0 * (q[r] * q[t] + q[s] * q[3]) / length * scale);
            bound.shift[r] = (float)qcRandom_Uniform(&random, -4.0, 4.0);
        }
        // Back into the second side's frame: the transpose, by the square of the scale.
        for (int c = 0; c < 3; c++)
            for (int r = 0; r < 3; r++)
            {
                mapped[c][r] = 0.0;
                for (int s = 0; s < 3; s++)
                    mapped[c][r] += (double)bound.linear[s][r] * (b[c][s] - (double)bound.shift[s]) / (scale * scale);
            }
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        bound.reach = Up(qcOracleDistance_Get(distance));
        qcOracleDistance_Destroy(distance);
        double by = error - 0x1p-24;
        for (int axis = 0; axis < 3; axis++)
            for (int c = 0; c < 3; c++)
                a[c][axis] -= n[axis] > 0.0 ? by : n[axis] < 0.0 ? -by : 0.0;
        Push(&batch, a, mapped);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &bound, &random), "%s: pair %d, error %a, apart %a", k->name, i, error, apart);
    }
}
END_TEST

START_TEST(the_filter_keeps_what_it_cannot_tell)
{
    double points[][3][3] = {{{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}}, {{0}}};
    qcRandom random = {14};
    Batch batch = {.count = 0};
    for (int i = 0; i < 40; i++)
    {
        // All six corners one point; or far apart, with a reach or an error that is larger.
        Push(&batch, points[0], points[i % 2]);
        qcFilterBound bound = {.pointError = i % 4 == 1 ? 1e6f : 0x1p-24f, .reach = i % 4 == 3 ? 1e30f : 0.0f};
        FOR_EACH_KERNELS(k)
        ck_assert(Keeps(k, &batch, &bound, &random));
    }
}
END_TEST

START_TEST(the_filter_drops_nearly_all_that_is_clearly_apart)
{
    qcRandom random = {15};
    Batch batch = {.count = 0};
    int apart = 0, dropped[qc_mostKernels] = {0};
    for (int i = 0; i < 4000; i++)
    {
        double corners[2][3][3];
        for (int t = 0; t < 2; t++)
            for (int axis = 0; axis < 3; axis++)
            {
                double centre = qcRandom_Uniform(&random, 0.4, 0.6);
                for (int c = 0; c < 3; c++)
                    corners[t][c][axis] = centre + qcRandom_Uniform(&random, -0.1, 0.1);
            }
        qcOracleDistance* distance =
            qcOracleDistance_Create((const double(*)[3])corners[0], (const double(*)[3])corners[1]);
        bool isApart = qcOracleDistance_Compare(distance, 1e-3) > 0;
        qcOracleDistance_Destroy(distance);
        if (!isApart)
            continue;
        apart++;
        Push(&batch, corners[0], corners[1]);
        qcFilterBound bound = {.pointError = 0x1p-24f};
        FOR_EACH_KERNELS(k)
        dropped[kernelIndex] += !Keeps(k, &batch, &bound, &random);
    }
    ck_assert_int_gt(apart, 1000);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(dropped[kernelIndex] > apart * 199 / 200, "%s drops %d of %d", k->name, dropped[kernelIndex], apart);
}
END_TEST

START_TEST(the_filter_parts_triangles_in_one_plane)
{
    qcRandom random = {16};
    Batch batch = {.count = 0};
    for (int i = 0; i < 500; i++)
    {
        // Side by side in a plane askew, a tenth of their size apart.
        double a[3][3], b[3][3], slope[2] = {qcRandom_Uniform(&random, -1, 1), qcRandom_Uniform(&random, -1, 1)};
        for (int c = 0; c < 3; c++)
            for (int t = 0; t < 2; t++)
            {
                double* x = t == 0 ? a[c] : b[c];
                x[0] = (t == 0 ? 0.0 : 0.55) + (c == 2 ? qcRandom_Uniform(&random, 0.0, 0.5) : 0.5 * (c == t));
                x[1] = c == 2 ? 1.0 : 0.0;
                if (c == 2)
                    x[0] = t == 0 ? 0.0 : 1.05;
                x[2] = slope[0] * x[0] + slope[1] * x[1];
            }
        Push(&batch, a, b);
        qcFilterBound bound = {.pointError = 0x1p-24f};
        FOR_EACH_KERNELS(k)
        CHECK_THAT(!Keeps(k, &batch, &bound, &random), "%s keeps pair %d", k->name, i);
    }
}
END_TEST

QC_RUN_TESTS("surface_filter", a_sure_hit_penetrates, the_filter_keeps_what_meets,
             the_filter_keeps_what_is_exactly_the_reach_apart, the_filter_keeps_what_meets_in_exact_coordinates,
             the_filter_keeps_what_errors_of_points_part, the_filter_keeps_what_meets_in_the_first_side_s_frame,
             the_filter_keeps_what_it_cannot_tell, the_filter_drops_nearly_all_that_is_clearly_apart,
             the_filter_parts_triangles_in_one_plane)
