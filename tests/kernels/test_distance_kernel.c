// What the kernels of every instruction set call near is apart and within the margin, and what they call apart beyond
// it, and what they drop beyond the reach, by rational arithmetic; nearly all else is told.
#include "kernels/kernel_pairs.h"
#include "support/oracle.h"
#include "support/suite.h"

#include <stdio.h>

//  ---- what becomes of a pair ----------------------------------------------------------------------

typedef enum Verdict
{
    verdict_near,  ///< within the margin
    verdict_apart, ///< beyond the margin
    verdict_left,
    verdict_far ///< beyond the reach
} Verdict;

/// What becomes of the last pair of the batch, wherever it stands. None may be lost or twice there.
static Verdict Judge(const qcTriangleKernels* k, const qcBatch* batch, const qcDistanceThresholds* bound,
                     qcRandom* random)
{
    qcIndexedTriangles a = qcBatch_Side(batch, 0), b = qcBatch_Side(batch, 1);
    qcSlotPair pairs[qc_mostInBatch];
    uint8_t times[qc_mostInBatch] = {0};
    uint32_t last = (uint32_t)batch->count - 1, place = qcRandom_Below(random, (uint32_t)batch->count);
    for (uint32_t i = 0; i < batch->count; i++)
        pairs[i].a = pairs[i].b = i == place ? last : i == last ? place : i;
    qcClassifiedCounts counts = k->classify(&a, &b, bound, pairs, batch->count);
    CHECK_THAT(counts.nearCount + counts.separateCount <= counts.count && counts.count <= batch->count,
               "%s: %zu near, %zu apart, %zu of %zu kept", k->name, counts.nearCount, counts.separateCount,
               counts.count, batch->count);
    Verdict verdict = verdict_far;
    for (size_t i = 0; i < counts.count; i++)
    {
        CHECK_THAT(pairs[i].a == pairs[i].b && pairs[i].a < batch->count && times[pairs[i].a]++ == 0,
                   "%s: pair %zu is twice there or was not given", k->name, i);
        if (pairs[i].a == last)
            verdict = i < counts.nearCount                          ? verdict_near
                      : i < counts.nearCount + counts.separateCount ? verdict_apart
                                                                    : verdict_left;
    }
    return verdict;
}

/// Pairs that are asked about, and what is told of them.
typedef struct Inquiry
{
    qcBatch batch;
    qcRandom random;
    int asked, apart;           ///< of the best kernels
    int told[verdict_far + 1];  ///< of the best kernels, of pairs that are apart
    int toldBy[qc_mostKernels]; ///< of pairs that are apart: near or far
} Inquiry;

/// Asks about the last pair of the batch, of which the oracle knows the distance. `unit`: from the oracle's lengths to
/// those of the batch. Pairs are kept that are within the margin, or within twice as much.
static void Ask(Inquiry* q, qcDistanceThresholds bound, const qcOracleDistance* distance, double unit, double margin,
                const char* what)
{
    double reach = qcRandom_Below(&q->random, 2) == 0 ? margin : 2.0 * margin;
    bool isDisjoint = qcOracleDistance_Compare(distance, 0.0) > 0;
    bound.near = qcRoundDown(margin * unit);
    bound.far = qcRoundUp(margin * unit);
    bound.query = qcRoundUp(reach * unit);
    q->asked++;
    q->apart += isDisjoint;
    FOR_EACH_KERNELS(k)
    {
        Verdict verdict = Judge(k, &q->batch, &bound, &q->random);
        bool isSo = true;
        switch (verdict)
        {
            case verdict_near:
                isSo = isDisjoint && qcOracleDistance_Compare(distance, (double)bound.near / unit) <= 0;
                break;
            case verdict_apart: isSo = qcOracleDistance_Compare(distance, margin) > 0; break;
            case verdict_far: isSo = qcOracleDistance_Compare(distance, (double)bound.query / unit) > 0; break;
            case verdict_left: break;
        }
        CHECK_THAT(isSo, "%s: verdict %d, margin %a, reach %a, distance %a: %s", k->name, (int)verdict, margin, reach,
                   qcOracleDistance_Get(distance), what);
        q->toldBy[kernelIndex] += isDisjoint && verdict != verdict_left;
        q->told[verdict] += isDisjoint && kernelIndex == 0;
    }
}

static void AskPair(Inquiry* q, const qcTrianglePair* pair, const qcOracleDistance* distance, double margin)
{
    qcUnitFrame frame;
    if (!qcUnitFrame_Find(&frame, pair, margin))
        return;
    qcUnitFrame_Push(&frame, pair, &q->batch);
    char text[1024];
    Ask(q, (qcDistanceThresholds){.pointError = 0x1p-24f}, distance, frame.unit, margin,
        qcTrianglePair_Print(pair, text));
}

//  ---- tests ---------------------------------------------------------------------------------------

START_TEST(any_pair_is_told_right)
{
    Inquiry q = {.random = {21}};
    int count = qcGetTestPairCount(6000);
    for (int i = 0; i < count; i++)
    {
        // Slivers, segments, points and what touches among them, of all scales.
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&q.random, &pair);
        qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
        double apart = qcOracleDistance_Get(distance), size = qcTrianglePair_GetLargest(&pair);
        double margin = i % 3 == 0 || apart == 0.0 ? size * ldexp(1.0, -i % 30) : apart;
        if (i % 3 == 2)
            margin *= 1.0 + ldexp(qcRandom_Uniform(&q.random, -1.0, 1.0), -i / 3 % 25);
        if (margin < 1e300)
            AskPair(&q, &pair, distance, margin);
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.asked, count / 2);
    ck_assert_int_gt(q.asked - q.apart, count / 10);
    ck_assert_int_gt(q.told[verdict_near], count / 100);
    ck_assert_int_gt(q.told[verdict_far], count / 100);
}
END_TEST

START_TEST(a_pair_at_the_margin_is_told_right)
{
    Inquiry q = {.random = {22}};
    int count = qcGetTestPairCount(3000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        double apart;
        qcTrianglePair_MakeApart(&q.random, 1 + i % 3, 1 + i / 3 % 3, &pair, &apart);
        for (int moved = 0; moved < 2; moved++)
        {
            qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
            // At it; and on both sides of it, down to where nothing can be told.
            double off = ldexp(1.0, -i % 27);
            AskPair(&q, &pair, distance, apart);
            AskPair(&q, &pair, distance, apart * (1.0 + off));
            AskPair(&q, &pair, distance, apart * (1.0 - off));
            qcOracleDistance_Destroy(distance);
            qcTrianglePair_MoveByUlps(&q.random, &pair);
        }
    }
    ck_assert_int_gt(q.told[verdict_near], q.apart / 20);
    ck_assert_int_gt(q.told[verdict_far], q.apart / 20);
    ck_assert_int_gt(q.told[verdict_left], q.apart / 4);
}
END_TEST

START_TEST(pairs_in_exact_coordinates_are_told_right)
{
    // Nothing but the kernels' own rounding.
    Inquiry q = {.random = {23}};
    for (int i = 0; i < 6000; i++)
    {
        qcTrianglePair pair;
        qcTrianglePair_Make(&q.random, (qcPairKind)(qc_pairCoarseGrid + i % (qc_pairKindCount - qc_pairCoarseGrid)),
                            &pair);
        bool isExact = true;
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
                isExact = isExact && (double)(float)pair.a[c][axis] == pair.a[c][axis] &&
                          (double)(float)pair.b[c][axis] == pair.b[c][axis];
        if (!isExact)
            continue;
        qcBatch_Push(&q.batch, pair.a, pair.b);
        qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
        double apart = qcOracleDistance_Get(distance);
        double margin = apart == 0.0 ? ldexp(1.0, -i % 30) : apart * (i % 2 == 0 ? 1.0 : 1.0005);
        char text[1024];
        Ask(&q, (qcDistanceThresholds){.pointError = 0.0f}, distance, 1.0, margin, qcTrianglePair_Print(&pair, text));
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.asked, 4000);
    ck_assert_int_gt(q.asked - q.apart, 2000);
    ck_assert_int_gt(q.told[verdict_near], 100);
}
END_TEST

START_TEST(errors_of_points_change_nothing)
{
    // All of one triangle is wrong one way and all of the other the other way: together or apart.
    Inquiry q = {.random = {24}};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], back[3][3], n[3], error = ldexp(1.0, -6 - i % 15),
                                                   apart = i % 5 == 0 ? 0.0 : ldexp(1.0, -i % 12 - 2);
        qcMakeOverEachOther(&q.random, i % 2 == 0, apart, a, b, n);
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        double off = i / 4 % 3 == 0 ? 0.0 : qcRandom_Uniform(&q.random, -1.0, 1.0) * (i / 4 % 3 == 1 ? error : 1.0);
        double margin = fmax(qcOracleDistance_Get(distance) + off, 0.0);
        qcDistanceThresholds bound = {.pointError = (float)error};
        // What is mapped from another frame is b.
        if (i / 2 % 2 == 0)
            qcMakeTurn(&q.random, &bound, b, back);
        bool isMapped = bound.isTransformed;
        double by = error - 0x1p-24; // what rounding to float may add
        qcMoveApart(a, b, n, qcRandom_Below(&q.random, 2) == 0 ? by : -by);
        qcBatch_Push(&q.batch, a, isMapped ? back : b);
        char text[64];
        snprintf(text, sizeof text, "pair %d, error %a, apart %a", i, error, apart);
        Ask(&q, bound, distance, 1.0, margin, text);
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.told[verdict_near], q.apart / 20);
    ck_assert_int_gt(q.told[verdict_far], q.apart / 20);
}
END_TEST

START_TEST(nearly_all_that_is_apart_is_told)
{
    Inquiry q = {.random = {25}};
    for (int i = 0; i < 6000; i++)
    {
        // From a tenth of the unit box to a thousandth of it.
        qcTrianglePair pair = {.kind = qc_pairGeneral};
        double size = 0.1 * pow(0.01, qcRandom_Uniform(&q.random, 0.0, 1.0));
        double margin = size * qcRandom_Uniform(&q.random, 0.05, 1.0);
        for (int axis = 0; axis < 3; axis++)
        {
            double centre = qcRandom_Uniform(&q.random, 0.2, 0.8),
                   other = centre + size * qcRandom_Uniform(&q.random, -1.5, 1.5);
            for (int c = 0; c < 3; c++)
            {
                pair.a[c][axis] = centre + qcRandom_Uniform(&q.random, -size, size);
                pair.b[c][axis] = other + qcRandom_Uniform(&q.random, -size, size);
            }
        }
        qcBatch_Push(&q.batch, pair.a, pair.b);
        qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
        char text[1024];
        Ask(&q, (qcDistanceThresholds){.pointError = 0x1p-24f}, distance, 1.0, margin,
            qcTrianglePair_Print(&pair, text));
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.apart, 2000);
    ck_assert_int_gt(q.told[verdict_near], q.apart / 5);
    ck_assert_int_gt(q.told[verdict_far], q.apart / 5);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(q.toldBy[kernelIndex] > q.apart * 95 / 100, "%s tells %d of %d", k->name, q.toldBy[kernelIndex],
               q.apart);
}
END_TEST

START_TEST(where_no_margin_is_told_nothing_is_near)
{
    Inquiry q = {.random = {26}};
    for (int i = 0; i < 1000; i++)
    {
        double a[3][3], b[3][3], n[3];
        qcMakeOverEachOther(&q.random, i % 2 == 0, 0.01, a, b, n);
        qcBatch_Push(&q.batch, a, b);
        qcDistanceThresholds bound = {.pointError = 0x1p-24f,
                                      .query = i % 3 == 0 ? 0.0f : 0.02f,
                                      .near = i % 2 == 0 ? -1.0f : -1e-4f,
                                      .far = 0.0f};
        FOR_EACH_KERNELS(k)
        ck_assert_int_eq(Judge(k, &q.batch, &bound, &q.random), i % 3 == 0 ? verdict_far : verdict_left);
    }
}
END_TEST

START_TEST(what_cannot_be_told_is_left)
{
    double points[][3][3] = {{{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}}, {{0}}};
    Inquiry q = {.random = {27}};
    for (int i = 0; i < 40; i++)
    {
        // All six corners one point; or far apart, with an error that is larger.
        qcBatch_Push(&q.batch, points[0], points[i % 2]);
        const float errors[] = {0.0f, 1e6f, 0x1p-24f, 1e6f};
        float margin = i % 3 == 0 ? 1e30f : 0.5f;
        qcDistanceThresholds bound = {.pointError = errors[i % 4], .query = margin, .near = margin, .far = margin};
        FOR_EACH_KERNELS(k)
        ck_assert_int_eq(Judge(k, &q.batch, &bound, &q.random), verdict_left);
    }
}
END_TEST

QC_RUN_TESTS("surface_near", any_pair_is_told_right, a_pair_at_the_margin_is_told_right,
             pairs_in_exact_coordinates_are_told_right, errors_of_points_change_nothing,
             nearly_all_that_is_apart_is_told, where_no_margin_is_told_nothing_is_near, what_cannot_be_told_is_left)
