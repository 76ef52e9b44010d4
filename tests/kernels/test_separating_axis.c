// The filter of every instruction set that this CPU has keeps all pairs within the query distance, by rational
// arithmetic, and drops nearly all others; so does the kernel that decides what the filter keeps.
#include "kernels/kernel_pairs.h"
#include "support/oracle.h"
#include "support/suite.h"

//  ---- filter --------------------------------------------------------------------------------------

/// Fails the test unless the `kept` pairs are some of the given ones, each once.
static void CheckSome(const qcTriangleKernels* k, const qcSlotPair* pairs, size_t kept, const qcSlotPair* given,
                      size_t count)
{
    uint8_t times[qc_maxBatch + 1] = {0};
    CHECK_THAT(kept <= count, "%s: %zu of %zu kept", k->name, kept, count);
    for (size_t i = 0; i < kept; i++)
    {
        bool isGiven = false;
        for (size_t at = 0; at < count; at++)
            isGiven = isGiven || (given[at].a == pairs[i].a && given[at].b == pairs[i].b);
        CHECK_THAT(isGiven && times[pairs[i].a]++ == 0, "%s: pair %zu was not given, or is twice there", k->name, i);
    }
}

/// True if the last pair is kept, at a random position: by the filter, which keeps the order, and with no query
/// distance by `relate`, too, to which the filtered pairs are given.
static bool Keeps(const qcTriangleKernels* k, const qcBatch* batch, const qcDistanceThresholds* thresholds,
                  qcRandom* random)
{
    qcIndexedTriangles a = qcBatch_Side(batch, 0), b = qcBatch_Side(batch, 1);
    qcSlotPair pairs[qc_maxBatch + 1], given[qc_maxBatch + 1];
    uint32_t last = (uint32_t)batch->count - 1, position = qcRandom_Below(random, (uint32_t)batch->count);
    for (uint32_t i = 0; i < batch->count; i++)
        given[i].a = given[i].b = i == position ? last : i == last ? position : i;
    memcpy(pairs, given, sizeof given);
    size_t kept = k->filter(&a, &b, thresholds, pairs, batch->count), at = 0;
    CheckSome(k, pairs, kept, given, batch->count);
    for (size_t i = 0; i < kept; i++)
    {
        while (at < batch->count && given[at].a != pairs[i].a)
            at++;
        CHECK_THAT(at < batch->count, "%s: pair %zu is out of order", k->name, i);
        at++;
    }
    if (thresholds->query <= 0.0f)
    {
        memcpy(given, pairs, sizeof given);
        size_t filtered = kept;
        kept = k->relate(&a, &b, thresholds, pairs, kept).count;
        CheckSome(k, pairs, kept, given, filtered);
    }
    bool isKept = false;
    for (size_t i = 0; i < kept; i++)
        isKept = isKept || pairs[i].a == last;
    return isKept;
}

/// Fails the test if a pair within the margin is dropped; returns whether it was within.
static bool CheckKept(const qcTrianglePair* pair, double margin, qcBatch* batch, qcRandom* random)
{
    qcUnitFrame frame;
    qcOracleDistance* distance = qcOracleDistance_Create(pair->a, pair->b);
    bool isWithin = qcOracleDistance_Compare(distance, margin) <= 0;
    qcOracleDistance_Destroy(distance);
    if (!isWithin || !qcUnitFrame_Find(&frame, pair, margin))
        return false;
    qcUnitFrame_Push(&frame, pair, batch);
    qcDistanceThresholds thresholds = {.pointError = 0x1p-24f, .query = qcRoundUp(margin * frame.unit)};
    char text[1024];
    FOR_EACH_KERNELS(k)
    CHECK_THAT(Keeps(k, batch, &thresholds, random), "%s drops %s, margin %a", k->name,
               qcTrianglePair_Print(pair, text), margin);
    return true;
}

START_TEST(the_filter_keeps_pairs_that_meet)
{
    qcRandom random = {9};
    qcBatch batch = {.count = 0};
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

/// True if the last pair is proven to intersect by `relate`, which proves all that findIntersecting proves.
static bool IsProven(const qcTriangleKernels* k, const qcBatch* batch, const qcDistanceThresholds* thresholds)
{
    qcIndexedTriangles a = qcBatch_Side(batch, 0), b = qcBatch_Side(batch, 1);
    qcSlotPair pairs[qc_maxBatch];
    uint8_t times[qc_maxBatch] = {0};
    for (uint32_t i = 0; i < batch->count; i++)
        pairs[i].a = pairs[i].b = i;
    size_t proven = k->findIntersecting(&a, &b, thresholds, pairs, batch->count);
    CHECK_THAT(proven <= batch->count, "%s: %zu of %zu proven", k->name, proven, batch->count);
    bool isProven = false, isRelated = false;
    for (size_t i = 0; i < batch->count; i++)
    {
        CHECK_THAT(pairs[i].a == pairs[i].b && pairs[i].a < batch->count && times[pairs[i].a]++ == 0,
                   "%s: pair %zu is lost or twice there", k->name, i);
        isProven = isProven || (i < proven && pairs[i].a + 1 == batch->count);
    }
    qcRelatedCounts counts = k->relate(&a, &b, thresholds, pairs, batch->count);
    CHECK_THAT(counts.intersectingCount <= counts.count, "%s: %zu of %zu intersect", k->name, counts.intersectingCount,
               counts.count);
    for (size_t i = 0; i < counts.intersectingCount; i++)
        isRelated = isRelated || pairs[i].a + 1 == batch->count;
    CHECK_THAT(isRelated || !isProven, "%s: relate proves less", k->name);
    return isRelated;
}

/// Random triangles, some of which barely touch.
static void MakeNearlyPiercing(qcRandom* random, qcTrianglePair* pair)
{
    for (int c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
        {
            pair->a[c][axis] = qcRandom_Uniform(random, -1.0, 1.0);
            pair->b[c][axis] = qcRandom_Uniform(random, -1.0, 1.0);
        }
    // A corner of B close to a point of A, on either side.
    if (qcRandom_Below(random, 2) == 0)
        return;
    double u = qcRandom_Uniform(random, 0.0, 0.6), v = qcRandom_Uniform(random, 0.0, 0.4);
    double off = qcRandom_Uniform(random, -1.0, 1.0) * (qcRandom_Below(random, 2) == 0 ? 0.1 : 0x1p-22);
    for (int axis = 0; axis < 3; axis++)
        pair->b[0][axis] = pair->a[0][axis] + u * (pair->a[1][axis] - pair->a[0][axis]) +
                           v * (pair->a[2][axis] - pair->a[0][axis]) + off;
}

START_TEST(pairs_proven_to_intersect_do_intersect)
{
    qcRandom random = {19};
    qcBatch batch = {.count = 0};
    int proven = 0, penetrating = 0, count = qcGetTestPairCount(12000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        if (i % 2 == 0)
            qcTrianglePair_MakeAny(&random, &pair);
        else
            MakeNearlyPiercing(&random, &pair);
        bool penetrates = qcOracle_Relate(pair.a, pair.b) == qc_relationPenetrating;
        qcUnitFrame frame;
        if (!qcUnitFrame_Find(&frame, &pair, 0.0))
            continue;
        qcUnitFrame_Push(&frame, &pair, &batch);
        qcDistanceThresholds thresholds = {.pointError = 0x1p-24f, .query = qcRoundUp(0.0)};
        penetrating += penetrates && i % 2 == 1;
        char text[1024];
        FOR_EACH_KERNELS(k)
        {
            bool isProven = IsProven(k, &batch, &thresholds);
            CHECK_THAT(!isProven || penetrates, "%s: %s", k->name, qcTrianglePair_Print(&pair, text));
            proven += isProven && i % 2 == 1 && k == qcTriangleKernels_Get();
        }
    }
    // Nearly all pairs that aren't constructed to be on the border.
    ck_assert_int_gt(penetrating, count / 20);
    ck_assert_int_gt(proven, penetrating * 8 / 10);
}
END_TEST

START_TEST(the_filter_keeps_pairs_exactly_at_the_query_distance)
{
    qcRandom random = {10};
    qcBatch batch = {.count = 0};
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

START_TEST(the_filter_keeps_pairs_that_meet_in_exact_coordinates)
{
    // Only the filter's own rounding.
    qcRandom random = {11};
    qcBatch batch = {.count = 0};
    qcDistanceThresholds thresholds = {.pointError = 0.0f};
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
        qcBatch_Push(&batch, pair.a, pair.b);
        meeting++;
        char text[1024];
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &thresholds, &random), "%s drops %s", k->name, qcTrianglePair_Print(&pair, text));
    }
    ck_assert_int_gt(meeting, 3000);
}
END_TEST

/// The query distance at which the triangles are found; 0 where they touch up to rounding: those are decided without a
/// distance.
static float QueryOf(double a[3][3], double b[3][3], double apart)
{
    if (apart == 0.0)
        return 0.0f;
    qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
    float query = qcRoundUp(qcOracleDistance_Get(distance));
    qcOracleDistance_Destroy(distance);
    return query;
}

START_TEST(the_filter_keeps_pairs_that_only_errors_of_points_separate)
{
    // The errors of the two triangles are opposite.
    qcRandom random = {12};
    qcBatch batch = {.count = 0};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], error = ldexp(1.0, -4 - i % 21),
                                       apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2);
        qcMakeOverEachOther(&random, i % 2 == 0, apart, a, b, n);
        qcDistanceThresholds thresholds = {.pointError = (float)error, .query = QueryOf(a, b, apart)};
        qcMoveApart(a, b, n, (apart == 0.0 ? 0.9999 : 1.0) * error - 0x1p-24); // what rounding to float may add
        qcBatch_Push(&batch, a, b);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &thresholds, &random), "%s: pair %d, error %a, apart %a", k->name, i, error, apart);
    }
}
END_TEST

START_TEST(the_filter_keeps_pairs_of_outliers_that_only_errors_of_points_separate)
{
    // Both triangles far outside the frame, where errors are as many times larger.
    qcRandom random = {14};
    qcBatch batch = {.count = 0};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], error = ldexp(1.0, -4 - i % 7), away = ldexp(1.0, 1 + i % 10),
                                       apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2);
        qcMakeOverEachOther(&random, i % 2 == 0, apart, a, b, n);
        qcDistanceThresholds thresholds = {
            .pointError = (float)(error / away), .hasOutliers = true, .query = QueryOf(a, b, apart)};
        qcMoveApart(a, b, n, (apart == 0.0 ? 0.9999 : 1.0) * error - away * 0x1p-24);
        int axis = i % 3;
        for (int c = 0; c < 3; c++)
        {
            a[c][axis] += i % 5 == 0 ? -away - 1.0 : away;
            b[c][axis] += i % 5 == 0 ? -away - 1.0 : away;
        }
        qcBatch_Push(&batch, a, b);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &thresholds, &random), "%s: pair %d, error %a, apart %a", k->name, i, error, apart);
    }
}
END_TEST

START_TEST(nothing_is_proven_of_outliers_that_are_too_far_away)
{
    qcRandom random = {15};
    qcBatch batch = {.count = 0};
    static const double far[] = {0x1.8p24, 1e20, 3e38, INFINITY};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3];
        qcMakeOverEachOther(&random, i % 2 == 0, 0.1, a, b, n);
        for (uint32_t k = 0; k < 1 + qcRandom_Below(&random, 4); k++)
            (i % 3 == 0 ? a : b)[qcRandom_Below(&random, 3)][qcRandom_Below(&random, 3)] =
                far[i % 4] * (qcRandom_Below(&random, 2) == 0 ? -1.0 : 1.0);
        qcBatch_Push(&batch, a, b);
        qcDistanceThresholds thresholds = {
            .pointError = 0x1p-24f, .hasOutliers = true, .query = i % 2 == 0 ? 0.0f : 0.01f, .near = 1.0f, .far = 1.0f};
        qcIndexedTriangles sides[2] = {qcBatch_Side(&batch, 0), qcBatch_Side(&batch, 1)};
        FOR_EACH_KERNELS(k)
        {
            CHECK_THAT(Keeps(k, &batch, &thresholds, &random), "%s drops pair %d", k->name, i);
            CHECK_THAT(!IsProven(k, &batch, &thresholds), "%s proves that pair %d intersects", k->name, i);
            qcSlotPair pair = {(uint32_t)batch.count - 1, (uint32_t)batch.count - 1};
            qcClassifiedCounts counts = k->classify(&sides[0], &sides[1], &thresholds, &pair, 1);
            CHECK_THAT(counts.count == 1 && counts.nearCount == 0 && counts.separateCount == 0, "%s classifies pair %d",
                       k->name, i);
        }
    }
}
END_TEST

START_TEST(the_filter_keeps_pairs_that_meet_after_a_transform)
{
    // The second side rotated, scaled and moved: errors of its points, and of the transform in floats.
    qcRandom random = {13};
    qcBatch batch = {.count = 0};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], inFrameOfB[3][3], error = ldexp(1.0, -10 - i % 10);
        double apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2);
        qcMakeOverEachOther(&random, i % 2 == 0, apart, a, b, n);
        qcDistanceThresholds thresholds = {.pointError = (float)error};
        qcMakeTransform(&random, &thresholds, b, inFrameOfB);
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        thresholds.query = qcRoundUp(qcOracleDistance_Get(distance));
        qcOracleDistance_Destroy(distance);
        if (apart == 0.0)
            thresholds.query = 0.0f;
        qcMoveApart(a, b, n, (apart == 0.0 ? 0.9999 : 1.0) * error - 0x1p-24); // b is back already
        qcBatch_Push(&batch, a, inFrameOfB);
        FOR_EACH_KERNELS(k)
        CHECK_THAT(Keeps(k, &batch, &thresholds, &random), "%s: pair %d, error %a, apart %a", k->name, i, error, apart);
    }
}
END_TEST

START_TEST(the_filter_keeps_undecidable_pairs)
{
    double points[][3][3] = {{{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}}, {{0}}};
    qcRandom random = {14};
    qcBatch batch = {.count = 0};
    for (int i = 0; i < 40; i++)
    {
        // All six corners coincide; or they are far apart, with a larger query distance or error.
        qcBatch_Push(&batch, points[0], points[i % 2]);
        qcDistanceThresholds thresholds = {.pointError = i % 4 == 1 ? 1e6f : 0x1p-24f,
                                           .query = i % 4 == 3 ? 1e30f : 0.0f};
        FOR_EACH_KERNELS(k)
        ck_assert(Keeps(k, &batch, &thresholds, &random));
    }
}
END_TEST

START_TEST(the_filter_drops_nearly_all_clearly_separate_pairs)
{
    qcRandom random = {15};
    qcBatch batch = {.count = 0};
    int apart = 0, dropped[qc_maxKernels] = {0};
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
        qcBatch_Push(&batch, corners[0], corners[1]);
        qcDistanceThresholds thresholds = {.pointError = 0x1p-24f};
        FOR_EACH_KERNELS(k)
        dropped[kernelIndex] += !Keeps(k, &batch, &thresholds, &random);
    }
    ck_assert_int_gt(apart, 1000);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(dropped[kernelIndex] > apart * 199 / 200, "%s drops %d of %d", k->name, dropped[kernelIndex], apart);
}
END_TEST

START_TEST(the_filter_separates_triangles_in_one_plane)
{
    qcRandom random = {16};
    qcBatch batch = {.count = 0};
    for (int i = 0; i < 500; i++)
    {
        // Side by side in an oblique plane, a tenth of their size apart.
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
        qcBatch_Push(&batch, a, b);
        qcDistanceThresholds thresholds = {.pointError = 0x1p-24f};
        FOR_EACH_KERNELS(k)
        CHECK_THAT(!Keeps(k, &batch, &thresholds, &random), "%s keeps pair %d", k->name, i);
    }
}
END_TEST

QC_RUN_TESTS("separating_axis", pairs_proven_to_intersect_do_intersect, the_filter_keeps_pairs_that_meet,
             the_filter_keeps_pairs_exactly_at_the_query_distance,
             the_filter_keeps_pairs_that_meet_in_exact_coordinates,
             the_filter_keeps_pairs_that_only_errors_of_points_separate,
             the_filter_keeps_pairs_of_outliers_that_only_errors_of_points_separate,
             nothing_is_proven_of_outliers_that_are_too_far_away, the_filter_keeps_pairs_that_meet_after_a_transform,
             the_filter_keeps_undecidable_pairs, the_filter_drops_nearly_all_clearly_separate_pairs,
             the_filter_separates_triangles_in_one_plane)
