// Planes of clusters, with every instruction set that this CPU has: no pair within the query distance is left out, by
// rational arithmetic, and most separate ones are.
#include "kernels/kernel_pairs.h"
#include "support/oracle.h"
#include "support/suite.h"

enum
{
    qc_side = qc_clusterSize * qc_clusterSize
};

/// Two BVHs of one leaf node each, whose boxes all overlap. Pair i of a batch is triangle i of each first cluster.
typedef struct Search
{
    qcPoint points[2][3 * qc_side];
    qcCorners corners[qc_side];
    qcBox8 boxes[qc_clusterSize + 1]; ///< of clusters, then of the node
    qcPlaneCache cache;
    uint64_t key;
} Search;

static void Begin(Search* s)
{
    memset(s, 0, sizeof *s);
    memset(s->cache.keys, 0xff, sizeof s->cache.keys);
    memset(s->cache.boxKeys, 0xff, sizeof s->cache.boxKeys);
    for (uint32_t i = 0; i < qc_side; i++)
        for (uint32_t c = 0; c < 3; c++)
            s->corners[i].vertex[c] = 3 * i + c;
    for (size_t i = 0; i <= qc_clusterSize; i++)
        for (int axis = 0; axis < 3; axis++)
            for (int end = 0; end < 2 * qc_boxLanes; end++)
                s->boxes[i].ends[axis][end] = INT16_MIN;
}

static void Put(Search* s, int side, uint32_t slot, double corners[3][3])
{
    for (uint32_t c = 0; c < 3; c++)
        for (int axis = 0; axis < 3; axis++)
            s->points[side][3 * slot + c].x[axis] = (float)corners[c][axis];
}

/// Whether each pair of slots is collected: [slot of a][slot of b]. With `isTransformed` by the kernel for two
/// lattices, whose transform of boxes makes them overlap everything.
static void Collect(Search* s, const qcTriangleKernels* k, const qcDistanceThresholds* thresholds,
                    uint8_t found[qc_side][qc_side])
{
    static qcSlotPair pairs[qc_maxCollected];
    qcBvhBoxes boxes = {s->boxes, s->boxes + qc_clusterSize};
    qcTransformedBvh b = {.boxes = boxes, .triangles = {s->corners, s->points[1]}};
    for (int axis = 0; axis < 3; axis++)
        b.levels.grow[axis] = b.points.grow[axis] = INFINITY;
    s->key += UINT64_C(1) << 32;
    const qcPlaneTest test = {.sides = {{s->corners, s->points[0]}, {s->corners, s->points[1]}},
                              .thresholds = thresholds,
                              .key = s->key,
                              .cache = &s->cache};
    qcBox8 transformed;
    k->transformBoxes(boxes.nodes, &b.levels, &transformed);
    uint64_t clusters = k->findOverlaps(boxes.nodes, &transformed);
    qcSlotPair* end = thresholds->isTransformed ? k->collectTransformedPairs(&boxes, 0, &b, 0, clusters, &test, pairs)
                                                : k->collectPairs(&boxes, 0, &boxes, 0, NULL, NULL, 0, &test, pairs);
    memset(found, 0, qc_side * qc_side);
    for (const qcSlotPair* pair = pairs; pair < end; pair++)
        CHECK_THAT(pair->a < qc_side && pair->b < qc_side && found[pair->a][pair->b]++ == 0,
                   "%s: pair %u %u is twice there, or not one", k->name, pair->a, pair->b);
}

/// Triangles of pairs that kinds of pairs give, at the same slots of both sides; each is compared with all others.
START_TEST(planes_keep_all_pairs_that_meet)
{
    static Search s;
    static uint8_t found[qc_side][qc_side];
    qcRandom random = {21};
    int meeting = 0, apart = 0, kept = 0, rounds = qcGetTestPairCount(9000) / 200;
    for (int round = 0; round < rounds; round++)
    {
        static double a[qc_side][3][3], b[qc_side][3][3];
        Begin(&s);
        for (uint32_t i = 0; i < qc_side; i++)
        {
            qcTrianglePair pair;
            qcUnitFrame frame;
            do
                qcTrianglePair_MakeAny(&random, &pair);
            while (!qcUnitFrame_Find(&frame, &pair, 0.0));
            qcUnitFrame_Transform(&frame, (const double(*)[3])pair.a, a[i]);
            qcUnitFrame_Transform(&frame, (const double(*)[3])pair.b, b[i]);
            for (int at = 0; at < 9; at++)
            {
                a[i][at / 3][at % 3] = (float)a[i][at / 3][at % 3];
                b[i][at / 3][at % 3] = (float)b[i][at / 3][at % 3];
            }
            Put(&s, 0, i, a[i]);
            Put(&s, 1, i, b[i]);
        }
        // In exact coordinates: only the kernels' own rounding.
        qcDistanceThresholds thresholds = {.pointError = 0.0f};
        FOR_EACH_KERNELS(k)
        {
            Collect(&s, k, &thresholds, found);
            for (uint32_t i = 0; i < qc_side; i++)
                for (uint32_t j = 0; j < qc_side; j += i == j || round % 8 == 0 ? 1 : 7)
                {
                    bool meets =
                        qcOracle_Relate((const double(*)[3])a[i], (const double(*)[3])b[j]) != qc_relationDisjoint;
                    CHECK_THAT(!meets || found[i][j], "%s: pair %u %u is left out", k->name, i, j);
                    meeting += meets;
                    apart += !meets;
                    kept += !meets && found[i][j];
                }
        }
    }
    ck_assert_int_gt(meeting, 100);
    ck_assert_int_lt(kept, apart * 3 / 4);
}
END_TEST

/// One pair at the query distance, moved closer or apart by the errors of points, in a random slot of each side.
static void CheckKept(Search* s, qcRandom* random, const qcDistanceThresholds* thresholds, double a[3][3],
                      double b[3][3])
{
    static uint8_t found[qc_side][qc_side];
    uint32_t i = qcRandom_Below(random, qc_side), j = qcRandom_Below(random, qc_side);
    Put(s, 0, i, a);
    Put(s, 1, j, b);
    FOR_EACH_KERNELS(k)
    {
        Collect(s, k, thresholds, found);
        CHECK_THAT(found[i][j], "%s: left out, error %a, query %a", k->name, (double)thresholds->pointError,
                   (double)thresholds->query);
    }
}

START_TEST(planes_keep_pairs_at_the_query_distance_whatever_the_errors_of_points)
{
    static Search s;
    qcRandom random = {22};
    Begin(&s);
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], error = i % 5 == 0 ? 0x1p-24 : ldexp(1.0, -4 - i % 20);
        double apart = i % 3 == 0 ? 0.0 : ldexp(1.0, -i % 20 - 2);
        qcMakeOverEachOther(&random, false, apart, a, b, n);
        qcOracleDistance* distance = qcOracleDistance_Create((const double(*)[3])a, (const double(*)[3])b);
        qcDistanceThresholds thresholds = {.pointError = (float)error,
                                           .query = qcRoundUp(qcOracleDistance_Get(distance))};
        qcOracleDistance_Destroy(distance);
        qcMoveApart(a, b, n, error - 0x1p-24);
        if (i % 2 == 0)
            CheckKept(&s, &random, &thresholds, a, b);
        else
            CheckKept(&s, &random, &thresholds, b, a);
    }
}
END_TEST

START_TEST(planes_keep_pairs_that_meet_after_a_transform)
{
    static Search s;
    qcRandom random = {23};
    Begin(&s);
    for (int i = 0; i < 4000; i++)
    {
        double a[3][3], b[3][3], n[3], inFrameOfB[3][3];
        qcMakeOverEachOther(&random, false, 0.0, a, b, n);
        qcDistanceThresholds thresholds = {0};
        qcMakeTransform(&random, &thresholds, i % 2 == 0 ? b : a, inFrameOfB);
        // The error is that of the search: rounding in the second frame, and in the transform.
        double worst = 0.0;
        for (int r = 0; r < 3; r++)
        {
            double ratios = 0.0;
            for (int c = 0; c < 3; c++)
                ratios += fabs((double)thresholds.linear[r][c]);
            worst = fmax(worst, 12.0 * ratios + 6.0 * fabs((double)thresholds.shift[r]));
        }
        // Corners of the second are within its unit box.
        double largest = 1.0;
        for (int c = 0; c < 3; c++)
            for (int axis = 0; axis < 3; axis++)
                largest = fmax(largest, fabs(inFrameOfB[c][axis]));
        thresholds.pointError = qcRoundUp(worst * largest * 0x1p-24);
        CheckKept(&s, &random, &thresholds, i % 2 == 0 ? a : b, inFrameOfB);
    }
}
END_TEST

START_TEST(planes_of_triangles_without_area_separate_nothing)
{
    static Search s;
    static uint8_t found[qc_side][qc_side];
    double point[3][3] = {{0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}},
           tiny[3][3] = {{1e-15, 0, 0}, {0, 1e-15, 0}, {0, 0, 1e-15}},
           far[3][3] = {{1, 1, 1}, {1, 1, 0.5}, {1, 1, 0.75}};
    Begin(&s);
    for (uint32_t i = 0; i < qc_side; i++)
    {
        Put(&s, 0, i, far);
        Put(&s, 1, i, i % 2 == 0 ? point : tiny);
    }
    qcDistanceThresholds thresholds = {.pointError = 0x1p-24f};
    FOR_EACH_KERNELS(k)
    {
        Collect(&s, k, &thresholds, found);
        for (uint32_t i = 0; i < qc_side; i++)
            for (uint32_t j = 0; j < qc_side; j++)
                ck_assert(found[i][j]);
    }
}
END_TEST

QC_RUN_TESTS("cluster_planes", planes_keep_all_pairs_that_meet,
             planes_keep_pairs_at_the_query_distance_whatever_the_errors_of_points,
             planes_keep_pairs_that_meet_after_a_transform, planes_of_triangles_without_area_separate_nothing)
