// Sweep and prune: the pairs of brute force, each once, wherever boxes are, and few comparisons although some boxes are
// far away or very large.
#include "sweep/sweep_and_prune.h"

#include "support/scenes.h"
#include "support/suite.h"
#include "sweep/sample_bodies.h"

#include <float.h>
#include <math.h>

enum
{
    qc_maxBoxes = 4096
};

typedef enum qcArrangement
{
    qc_inPlane,
    qc_inCube,
    qc_onLine,
    qc_onDiagonal,
    qc_ofAllSizes,
    qc_asPoints,
    qc_allEqual,
    qc_twoClusters,
    qc_oneFar,
    qc_tenFar,
    qc_percentFar,
    qc_percentFarAlongOneAxis,
    qc_oneBeyondFloats,
    qc_percentHuge,
    qc_halfHuge,
    qc_percentInfinite,
    qc_allInfinite,
    qc_arrangementCount
} qcArrangement;

static bool IsOdd(qcArrangement arrangement, uint32_t i, uint32_t count)
{
    switch (arrangement)
    {
        case qc_oneFar:
        case qc_oneBeyondFloats: return i == count / 3;
        case qc_tenFar: return i % (count / 10) == 3;
        case qc_percentFar:
        case qc_percentFarAlongOneAxis:
        case qc_percentHuge:
        case qc_percentInfinite: return i % 100 == 7;
        case qc_twoClusters:
        case qc_halfHuge: return i % 2 == 0;
        default: return false;
    }
}

/// Boxes of one size in a plane, a cube or a line, and some odd ones among them, at `distance`, or as large. In a plane
/// no two boxes overlap.
static void Arrange(qcArrangement arrangement, double distance, uint64_t seed, qcSweepBox* boxes, uint32_t count)
{
    qcRandom random = {seed};
    const uint32_t side = (uint32_t)sqrt(count), edge = (uint32_t)ceil(cbrt(count));
    const qcSweepFrame frame = {{0.0, 0.0, 0.0}, 0.0};
    for (uint32_t i = 0; i < count; i++)
    {
        double size[3] = {1.0, 1.0, 1.0}, lower[3] = {1.5 * (i % side), 0.0, 1.5 * (i / side)}, upper[3];
        bool isOdd = IsOdd(arrangement, i, count);
        for (int axis = 0; axis < 3; axis++)
        {
            if (arrangement == qc_inCube)
                lower[axis] = (double[]){i % edge, i / edge % edge, i / edge / edge}[axis] * 0.9;
            if (arrangement == qc_onLine)
                lower[axis] = axis == 1 ? 0.7 * i : 5.0;
            if (arrangement == qc_onDiagonal)
                lower[axis] = 0.7 * i;
            if (arrangement == qc_ofAllSizes)
                size[axis] = exp(qcRandom_Uniform(&random, -12.0, 3.0));
            if (arrangement == qc_asPoints)
                size[axis] = 0.0;
            if (arrangement == qc_allEqual || arrangement == qc_allInfinite)
                lower[axis] = 3.0;
            if (isOdd && arrangement != qc_percentHuge && arrangement != qc_halfHuge)
                lower[axis] += (axis == 1 ? -2.0 : 1.0) * distance *
                               (arrangement == qc_twoClusters ? 1.0 : qcRandom_Uniform(&random, 0.5, 2.0)) *
                               (arrangement == qc_percentFarAlongOneAxis && axis != 1 ? 0.0 : 1.0);
            if (isOdd && (arrangement == qc_percentHuge || arrangement == qc_halfHuge))
                size[axis] = axis == 1 ? 1.0 : distance;
            if (isOdd && arrangement == qc_percentHuge)
                lower[axis] = axis == 1 ? 2.0 * (i + 1) : -distance / 2.0;
            if (isOdd && arrangement == qc_oneBeyondFloats)
                lower[axis] = 1e300;
            upper[axis] = lower[axis] + size[axis];
        }
        boxes[i] = qcSweepFrame_Map(&frame, lower, upper, i, i);
        for (int axis = 0; axis < 3; axis++)
            if (arrangement == qc_allInfinite || (isOdd && arrangement == qc_percentInfinite && axis != (int)(i % 3)))
            {
                boxes[i].lower[axis] = -INFINITY;
                boxes[i].upper[axis] = INFINITY;
            }
    }
}

typedef struct Found
{
    uint8_t* times; ///< by a * count + b, a < b
    uint32_t count;
} Found;

static void CountPair(void* context, const qcSweepBox* a, const qcSweepBox* b, uint32_t worker)
{
    (void)worker;
    const Found* found = context;
    size_t low = a->item < b->item ? a->item : b->item, high = a->item < b->item ? b->item : a->item;
    found->times[low * found->count + high]++;
}

static bool Overlap(const qcSweepBox* a, const qcSweepBox* b)
{
    bool overlap = true;
    for (int axis = 0; axis < 3; axis++)
        overlap = overlap && a->lower[axis] <= b->upper[axis] && b->lower[axis] <= a->upper[axis];
    return overlap;
}

START_TEST(each_pair_is_found_once_wherever_boxes_are)
{
    static const double distances[] = {1.0, 1e3, 1e8, 1e20, 1e38};
    static qcSweepBox boxes[qc_maxBoxes];
    qcSweep sweep = {0};
    for (uint32_t kind = 0; kind < qc_arrangementCount; kind++)
        for (size_t d = 0; d < sizeof distances / sizeof distances[0]; d++)
            for (uint32_t count = 2; count <= 700; count = count * 3 + 5)
            {
                Arrange((qcArrangement)kind, distances[d], 1 + d, boxes, count < 20 ? 20 : count);
                Found found = {calloc((size_t)count * count, 1), count};
                ck_assert_ptr_nonnull(found.times);
                CHECK_OK(qcSweep_FindPairs(&sweep, boxes, count, 1, CountPair, &found));
                for (uint32_t i = 0; i < count; i++)
                    for (uint32_t j = i + 1; j < count; j++)
                        CHECK_THAT(found.times[(size_t)i * count + j] == Overlap(&boxes[i], &boxes[j]),
                                   "arrangement %u at %g: boxes %u and %u of %u found %d times", kind, distances[d], i,
                                   j, count, found.times[(size_t)i * count + j]);
                free(found.times);
            }
    qcSweep_Free(&sweep);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static void IgnorePair(void* context, const qcSweepBox* a, const qcSweepBox* b, uint32_t worker)
{
    (void)context;
    (void)a;
    (void)b;
    (void)worker;
}

static uint64_t CountComparisons(qcSweep* sweep, qcArrangement arrangement, double distance)
{
    static qcSweepBox boxes[qc_maxBoxes];
    Arrange(arrangement, distance, 1, boxes, qc_maxBoxes);
    CHECK_OK(qcSweep_FindPairs(sweep, boxes, qc_maxBoxes, 1, IgnorePair, NULL));
    ck_assert_uint_le(sweep->entries.count, 3 * qc_maxBoxes);
    return sweep->comparisons;
}

START_TEST(few_boxes_far_away_or_huge_cost_few_comparisons)
{
    static const qcArrangement kinds[] = {qc_onLine,      qc_onDiagonal,      qc_asPoints,
                                          qc_oneFar,      qc_tenFar,          qc_percentFar,
                                          qc_twoClusters, qc_oneBeyondFloats, qc_percentFarAlongOneAxis};
    qcSweep sweep = {0};
    const uint64_t plain = CountComparisons(&sweep, qc_inPlane, 0.0);
    ck_assert_uint_le(plain, 8 * qc_maxBoxes);
    for (size_t kind = 0; kind < sizeof kinds / sizeof kinds[0]; kind++)
        for (double distance = 1e3; distance < 1e30; distance *= 10.0)
        {
            // Boxes of the second cluster become equal beyond the precision of floats.
            if (kinds[kind] == qc_twoClusters && distance > 1e6)
                break;
            uint64_t comparisons = CountComparisons(&sweep, kinds[kind], distance);
            CHECK_THAT(comparisons <= 2 * plain, "arrangement %d at %g: %llu comparisons instead of %llu", kinds[kind],
                       distance, (unsigned long long)comparisons, (unsigned long long)plain);
        }
    // Each huge box is compared with all others.
    const uint64_t huge = qc_maxBoxes / 100 + 1;
    ck_assert_uint_le(CountComparisons(&sweep, qc_percentHuge, 1e6), 4 * plain + 2 * huge * qc_maxBoxes);
    qcSweep_Free(&sweep);
}
END_TEST

/// The pairs of bodies in a step of triangles side by side, the first of which is at a distance.
static uint64_t BodyPairsWithFirstAt(double distance)
{
    qcScene* scene = qcMakeScene(NULL);
    for (uint32_t body = 0; body < 256; body++)
    {
        qcSoup soup = qcSoup_MakeRandom(1 + body, 1, 0.2);
        qcSoup_Translate(&soup, body == 0 ? distance : 2.0 * (body % 16), 0.0, 2.0 * (body / 16));
        qcAddSoup(scene, &soup);
        qcSoup_Free(&soup);
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    const qcResult* result;
    CHECK_OK(qcScene_Detect(scene, &def, &result));
    uint64_t pairs = result->profile.bodyPairs;
    qcScene_Destroy(scene);
    return pairs;
}

START_TEST(boxes_keep_their_precision_although_the_first_is_far_away)
{
    for (double distance = 0.0; distance < 1e30; distance = 1e4 * (distance + 1.0))
        ck_assert_uint_eq(BodyPairsWithFirstAt(distance), 0);
}
END_TEST

START_TEST(the_origin_is_the_median_corner)
{
    double corners[5][3] = {{1e30, 2.0, -1.0}, {3.0, -1e30, -1.0}, {1.0, 1.0, -1.0}, {2.0, 3.0, -1.0}, {4.0, 4.0, 7.0}};
    qcSweepFrame frame = {{5.0, 5.0, 5.0}, 0.0};
    qcSweepFrame_SetOrigin(&frame, corners, 0);
    ck_assert_double_eq(frame.origin[0], 5.0);
    qcSweepFrame_SetOrigin(&frame, corners, 5);
    ck_assert_double_eq(frame.origin[0], 3.0);
    ck_assert_double_eq(frame.origin[1], 2.0);
    ck_assert_double_eq(frame.origin[2], -1.0);
}
END_TEST

QC_RUN_TESTS("sweep_and_prune", each_pair_is_found_once_wherever_boxes_are,
             few_boxes_far_away_or_huge_cost_few_comparisons, boxes_keep_their_precision_although_the_first_is_far_away,
             the_origin_is_the_median_corner)
