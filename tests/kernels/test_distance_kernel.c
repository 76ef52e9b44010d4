// The classes of every instruction set's `classify`, by rational arithmetic: near pairs are disjoint and within the
// margin, separate ones beyond it, dropped ones beyond the query distance; nearly all disjoint pairs are classified.
#include "kernels/kernel_pairs.h"
#include "support/oracle.h"
#include "support/suite.h"

#include <stdio.h>

//  ---- the class of a pair -------------------------------------------------------------------------

typedef enum PairClass
{
    class_near,     ///< within the margin
    class_separate, ///< beyond the margin
    class_undecided,
    class_dropped ///< beyond the query distance
} PairClass;

/// The class of the last pair of the batch, at a random position. No pair may be lost or duplicated.
static PairClass ClassOfLast(const qcTriangleKernels* k, const qcBatch* batch, const qcDistanceThresholds* thresholds,
                             qcRandom* random)
{
    qcIndexedTriangles a = qcBatch_Side(batch, 0), b = qcBatch_Side(batch, 1);
    qcSlotPair pairs[qc_maxBatch];
    uint8_t times[qc_maxBatch] = {0};
    uint32_t last = (uint32_t)batch->count - 1, position = qcRandom_Below(random, (uint32_t)batch->count);
    for (uint32_t i = 0; i < batch->count; i++)
        pairs[i].a = pairs[i].b = i == position ? last : i == last ? position : i;
    qcClassifiedCounts counts = k->classify(&a, &b, thresholds, pairs, batch->count);
    CHECK_THAT(counts.nearCount + counts.separateCount <= counts.count && counts.count <= batch->count,
               "%s: %zu near, %zu separate, %zu of %zu kept", k->name, counts.nearCount, counts.separateCount,
               counts.count, batch->count);
    PairClass pairClass = class_dropped;
    for (size_t i = 0; i < counts.count; i++)
    {
        CHECK_THAT(pairs[i].a == pairs[i].b && pairs[i].a < batch->count && times[pairs[i].a]++ == 0,
                   "%s: pair %zu is doubled or was not given", k->name, i);
        if (pairs[i].a == last)
            pairClass = i < counts.nearCount                          ? class_near
                        : i < counts.nearCount + counts.separateCount ? class_separate
                                                                      : class_undecided;
    }
    return pairClass;
}

/// Counts of pairs and their classes.
typedef struct Counts
{
    qcBatch batch;
    qcRandom random;
    int pairs, disjoint;
    int byClass[class_dropped + 1];  ///< disjoint pairs by class, of the first kernels
    int classifiedBy[qc_maxKernels]; ///< disjoint pairs that are classified, by instruction set
} Counts;

/// Checks the class of the last pair of the batch. `distance`: that of the pair; `unit`: from its lengths to those of
/// the batch. The query distance is the margin, or twice as much.
static void CheckLast(Counts* q, qcDistanceThresholds thresholds, const qcOracleDistance* distance, double unit,
                      double margin, const char* what)
{
    double query = qcRandom_Below(&q->random, 2) == 0 ? margin : 2.0 * margin;
    bool isDisjoint = qcOracleDistance_Compare(distance, 0.0) > 0;
    thresholds.near = qcRoundDown(margin * unit);
    thresholds.far = qcRoundUp(margin * unit);
    thresholds.query = qcRoundUp(query * unit);
    q->pairs++;
    q->disjoint += isDisjoint;
    FOR_EACH_KERNELS(k)
    {
        PairClass pairClass = ClassOfLast(k, &q->batch, &thresholds, &q->random);
        bool holds = true;
        switch (pairClass)
        {
            case class_near:
                holds = isDisjoint && qcOracleDistance_Compare(distance, (double)thresholds.near / unit) <= 0;
                break;
            case class_separate: holds = qcOracleDistance_Compare(distance, margin) > 0; break;
            case class_dropped: holds = qcOracleDistance_Compare(distance, (double)thresholds.query / unit) > 0; break;
            case class_undecided: break;
        }
        CHECK_THAT(holds, "%s: class %d, margin %a, query %a, distance %a: %s", k->name, (int)pairClass, margin, query,
                   qcOracleDistance_Get(distance), what);
        q->classifiedBy[kernelIndex] += isDisjoint && pairClass != class_undecided;
        q->byClass[pairClass] += isDisjoint && kernelIndex == 0;
    }
}

static void CheckPair(Counts* q, const qcTrianglePair* pair, const qcOracleDistance* distance, double margin)
{
    qcUnitFrame frame;
    if (!qcUnitFrame_Find(&frame, pair, margin))
        return;
    qcUnitFrame_Push(&frame, pair, &q->batch);
    char text[1024];
    CheckLast(q, (qcDistanceThresholds){.pointError = 0x1p-24f}, distance, frame.unit, margin,
              qcTrianglePair_Print(pair, text));
}

//  ---- tests ---------------------------------------------------------------------------------------

START_TEST(any_pair_is_classified_right)
{
    Counts q = {.random = {21}};
    int count = qcGetTestPairCount(6000);
    for (int i = 0; i < count; i++)
    {
        // Slivers, segments, points and touching pairs of them, of all scales.
        qcTrianglePair pair;
        qcTrianglePair_MakeAny(&q.random, &pair);
        qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
        double apart = qcOracleDistance_Get(distance), size = qcTrianglePair_GetLargest(&pair);
        double margin = i % 3 == 0 || apart == 0.0 ? size * ldexp(1.0, -i % 30) : apart;
        if (i % 3 == 2)
            margin *= 1.0 + ldexp(qcRandom_Uniform(&q.random, -1.0, 1.0), -i / 3 % 25);
        if (margin < 1e300)
            CheckPair(&q, &pair, distance, margin);
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.pairs, count / 2);
    ck_assert_int_gt(q.pairs - q.disjoint, count / 10);
    ck_assert_int_gt(q.byClass[class_near], count / 100);
    ck_assert_int_gt(q.byClass[class_dropped], count / 100);
}
END_TEST

START_TEST(a_pair_at_the_margin_is_classified_right)
{
    Counts q = {.random = {22}};
    int count = qcGetTestPairCount(3000);
    for (int i = 0; i < count; i++)
    {
        qcTrianglePair pair;
        double apart;
        qcTrianglePair_MakeApart(&q.random, 1 + i % 3, 1 + i / 3 % 3, &pair, &apart);
        for (int moved = 0; moved < 2; moved++)
        {
            qcOracleDistance* distance = qcOracleDistance_Create(pair.a, pair.b);
            // At it; and on both sides of it, so close that no class can be proven.
            double off = ldexp(1.0, -i % 27);
            CheckPair(&q, &pair, distance, apart);
            CheckPair(&q, &pair, distance, apart * (1.0 + off));
            CheckPair(&q, &pair, distance, apart * (1.0 - off));
            qcOracleDistance_Destroy(distance);
            qcTrianglePair_MoveByUlps(&q.random, &pair);
        }
    }
    ck_assert_int_gt(q.byClass[class_near], q.disjoint / 20);
    ck_assert_int_gt(q.byClass[class_dropped], q.disjoint / 20);
    ck_assert_int_gt(q.byClass[class_undecided], q.disjoint / 4);
}
END_TEST

START_TEST(pairs_in_exact_coordinates_are_classified_right)
{
    // Only the kernels' own rounding.
    Counts q = {.random = {23}};
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
        CheckLast(&q, (qcDistanceThresholds){.pointError = 0.0f}, distance, 1.0, margin,
                  qcTrianglePair_Print(&pair, text));
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.pairs, 4000);
    ck_assert_int_gt(q.pairs - q.disjoint, 2000);
    ck_assert_int_gt(q.byClass[class_near], 100);
}
END_TEST

START_TEST(errors_of_points_change_nothing)
{
    // The errors of the two triangles are opposite: towards each other or away from each other.
    Counts q = {.random = {24}};
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], back[3][3], n[3], error = ldexp(1.0, -6 - i % 15),
                                                   apart = i % 5 == 0 ? 0.0 : ldexp(1.0, -i % 12 - 2);
        qcMakeOverEachOther(&q.random, i % 2 == 0, apart, a, b, n);
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        double off = i / 4 % 3 == 0 ? 0.0 : qcRandom_Uniform(&q.random, -1.0, 1.0) * (i / 4 % 3 == 1 ? error : 1.0);
        double margin = fmax(qcOracleDistance_Get(distance) + off, 0.0);
        qcDistanceThresholds thresholds = {.pointError = (float)error};
        // b comes from another frame.
        if (i / 2 % 2 == 0)
            qcMakeTransform(&q.random, &thresholds, b, back);
        bool isMapped = thresholds.isTransformed;
        double by = error - 0x1p-24; // what rounding to float may add
        qcMoveApart(a, b, n, qcRandom_Below(&q.random, 2) == 0 ? by : -by);
        qcBatch_Push(&q.batch, a, isMapped ? back : b);
        char text[64];
        snprintf(text, sizeof text, "pair %d, error %a, apart %a", i, error, apart);
        CheckLast(&q, thresholds, distance, 1.0, margin, text);
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.byClass[class_near], q.disjoint / 20);
    ck_assert_int_gt(q.byClass[class_dropped], q.disjoint / 20);
}
END_TEST

START_TEST(nearly_all_disjoint_pairs_are_classified)
{
    Counts q = {.random = {25}};
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
        CheckLast(&q, (qcDistanceThresholds){.pointError = 0x1p-24f}, distance, 1.0, margin,
                  qcTrianglePair_Print(&pair, text));
        qcOracleDistance_Destroy(distance);
    }
    ck_assert_int_gt(q.disjoint, 2000);
    ck_assert_int_gt(q.byClass[class_near], q.disjoint / 5);
    ck_assert_int_gt(q.byClass[class_dropped], q.disjoint / 5);
    FOR_EACH_KERNELS(k)
    CHECK_THAT(q.classifiedBy[kernelIndex] > q.disjoint * 95 / 100, "%s classifies %d of %d", k->name,
               q.classifiedBy[kernelIndex], q.disjoint);
}
END_TEST

START_TEST(without_a_near_distance_no_pair_is_classified)
{
    Counts q = {.random = {26}};
    for (int i = 0; i < 1000; i++)
    {
        double a[3][3], b[3][3], n[3];
        qcMakeOverEachOther(&q.random, i % 2 == 0, 0.01, a, b, n);
        qcBatch_Push(&q.batch, a, b);
        qcDistanceThresholds thresholds = {.pointError = 0x1p-24f,
                                           .query = i % 3 == 0 ? 0.0f : 0.02f,
                                           .near = i % 2 == 0 ? -1.0f : -1e-4f,
                                           .far = 0.0f};
        FOR_EACH_KERNELS(k)
        ck_assert_int_eq(ClassOfLast(k, &q.batch, &thresholds, &q.random),
                         i % 3 == 0 ? class_dropped : class_undecided);
    }
}
END_TEST

START_TEST(undecidable_pairs_stay_undecided)
{
    double points[][3][3] = {{{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}}, {{0}}};
    Counts q = {.random = {27}};
    for (int i = 0; i < 40; i++)
    {
        // All six corners coincide; or they are far apart, with a larger error.
        qcBatch_Push(&q.batch, points[0], points[i % 2]);
        const float errors[] = {0.0f, 1e6f, 0x1p-24f, 1e6f};
        float margin = i % 3 == 0 ? 1e30f : 0.5f;
        qcDistanceThresholds thresholds = {.pointError = errors[i % 4], .query = margin, .near = margin, .far = margin};
        FOR_EACH_KERNELS(k)
        ck_assert_int_eq(ClassOfLast(k, &q.batch, &thresholds, &q.random), class_undecided);
    }
}
END_TEST

QC_RUN_TESTS("distance_kernel", any_pair_is_classified_right, a_pair_at_the_margin_is_classified_right,
             pairs_in_exact_coordinates_are_classified_right, errors_of_points_change_nothing,
             nearly_all_disjoint_pairs_are_classified, without_a_near_distance_no_pair_is_classified,
             undecidable_pairs_stay_undecided)
