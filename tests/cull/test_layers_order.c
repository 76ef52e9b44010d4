// Where the step before had many pairs, the device of `layers` puts them in order, in buckets of neighbouring
// triangles. Everything the result has is that of the sweep, also where buckets overflow.
#define _POSIX_C_SOURCE 200809L
#include "base/ordered_keys.h"
#include "pipeline/scene_state.h"
#include "support/devices.h"
#include "support/scenes.h"
#include "support/suite.h"

enum
{
    qc_leastOrdered = 4096, // pairs
    qc_bucketRoom = 512     // pairs of a bucket
};

static bool IsOrdered(const qcProfile* profile)
{
    for (size_t i = 0; i < profile->layerTimeCount; i++)
        if (strcmp(profile->layerTimes[i].name, "order") == 0)
            return profile->layerTimes[i].threadMs >= 0.0;
    return false;
}

/// The number of sure pairs that the device put in order. The scene has others only if buckets overflow.
static size_t CountOrdered(const qcScene* scene, bool all)
{
    const qcArray* sure = &scene->detector.triangleStage.candidates.classified;
    size_t begin = qcOrderedKeys_FindBegin(sure->data, sure->count);
    ck_assert(!all || begin == 0);
    return sure->count - begin;
}

static void CheckSame(const void* expected, const void* found, size_t bytes, const char* what)
{
    ck_assert_msg(bytes == 0 || memcmp(expected, found, bytes) == 0, "other %s than the sweep's", what);
}

/// Compares all lists of a result with those of the sweep. `other`: an equal scene, for the sweep.
static const qcResult* CheckStep(qcScene* scene, qcScene* other, const qcDetectDef* given)
{
    qcDetectDef def = *given;
    const qcResult *expected = NULL, *found = NULL;
    def.method = qc_methodSweep;
    CHECK_OK(qcScene_Detect(other, &def, &expected));
    def.method = qc_methodLayers;
    def.layerTimes = true;
    CHECK_OK(qcScene_Detect(scene, &def, &found));
    ck_assert_msg(found->profile.fallback == NULL, "%s", found->profile.fallback);
    ck_assert(!found->profile.reused);
    qcPairList expectedPairs = qcListOf(expected), foundPairs = qcListOf(found);
    qcCheckSamePairs(&expectedPairs, &foundPairs, "layers");
    if (def.segments)
        CheckSame(expected->segments, found->segments, found->pairCount * sizeof(qcSegment), "segments");
    ck_assert_uint_eq(found->contactCount, expected->contactCount);
    CheckSame(expected->contacts, found->contacts, found->contactCount * sizeof(qcContact), "contacts");
    return found;
}

/// Which triangles are large and meet hundreds of small ones.
typedef enum Large
{
    large_none,
    large_first, ///< first of their pairs: they fill buckets
    large_last,
} Large;

/// Small triangles, and some that are as large as the scene.
static qcSoup MakeSoup(uint64_t seed, uint32_t count, double size, Large large)
{
    enum
    {
        qc_largeCount = 8
    };
    qcSoup soup = qcSoup_MakeRandom(seed, count, size);
    uint32_t first = large == large_first ? 0 : count - qc_largeCount;
    for (uint32_t t = first; large != large_none && t < first + qc_largeCount; t++)
        for (uint32_t c = 0; c < 3; c++)
        {
            double* corner = soup.positions + 3 * (size_t)soup.indices[3 * t + c];
            corner[0] = c == 1 ? 4.0 : -1.0;
            corner[1] = c == 2 ? 4.0 : -1.0;
            corner[2] = 0.1 + 0.1 * (t - first) + 0.01 * c;
        }
    return soup;
}

/// Two equal scenes of two bodies each: one for `layers`, one for the sweep.
typedef struct Twins
{
    qcScene* scenes[2];
    qcBodyId first; ///< in both; the one that moves
} Twins;

static Twins MakeTwins(qcDevice* device, const qcSoup* a, const qcSoup* b)
{
    Twins twins;
    for (int i = 0; i < 2; i++)
    {
        twins.scenes[i] = qcMakeScene(device);
        twins.first = qcAddDeformingSoup(twins.scenes[i], a);
        qcAddSoup(twins.scenes[i], b);
    }
    return twins;
}

static void Move(const Twins* twins, const qcSoup* soup)
{
    for (int i = 0; i < 2; i++)
        CHECK_OK(qcScene_SetVertices(twins->scenes[i], twins->first, soup->positions, qc_positionF64, 0));
}

static const qcResult* CheckTwins(const Twins* twins, const qcDetectDef* def)
{
    return CheckStep(twins->scenes[0], twins->scenes[1], def);
}

static void FreeTwins(const Twins* twins)
{
    for (int i = 0; i < 2; i++)
        qcScene_Destroy(twins->scenes[i]);
}

/// The most pairs of a bucket: of those whose first triangles are four in a row, since there are fewer than 4096
/// triangles for 1024 buckets.
static size_t FindLargestBucket(const qcResult* result)
{
    size_t largest = 0, count = 0;
    for (size_t i = 0; i < result->pairCount; i++)
    {
        const qcPair* pair = &result->pairs[i];
        bool goes = i > 0 && pair[-1].bodyA == pair->bodyA && pair[-1].triangleA / 4 == pair->triangleA / 4;
        count = goes ? count + 1 : 1;
        largest = count > largest ? count : largest;
    }
    return largest;
}

START_TEST(many_pairs_are_put_in_order_and_are_those_of_the_sweep)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    static const Large larges[] = {large_none, large_first, large_last};
    QC_FOR_EACH_DEVICE(device)
    for (int l = 0; l < 3 && qcHasCompute(device); l++)
    {
        qcSoup soup = MakeSoup(5, 1600, 0.15, larges[l]), moved = MakeSoup(6, 1600, 0.15, larges[l]),
               other = MakeSoup(7, 700, 0.15, large_none);
        Twins twins = MakeTwins(device, &soup, &other);
        for (uint32_t options = 0; options < 8; options++)
        {
            qcDetectDef def = qcDefaultDetectDef();
            def.threads = 1 + options % 3;
            def.segments = options % 2 != 0;
            def.margin = options % 4 == 2 ? 0.01 : 0.0;
            def.contactMargin = options % 4 == 3 ? 0.01 : 0.0;
            Move(&twins, options % 2 == 0 ? &moved : &soup);
            const qcResult* result = CheckTwins(&twins, &def);
            ck_assert_uint_gt(result->pairCount, qc_leastOrdered);
            ck_assert(IsOrdered(&result->profile) == (options != 0));
            // Some buckets overflow only if large triangles are the first of their pairs.
            bool overflows = FindLargestBucket(result) > qc_bucketRoom;
            ck_assert(overflows == (larges[l] == large_first));
            if (options != 0)
                ck_assert_uint_gt(CountOrdered(twins.scenes[0], !overflows), result->pairCount / 2);
        }
        FreeTwins(&twins);
        qcSoup_Free(&soup);
        qcSoup_Free(&moved);
        qcSoup_Free(&other);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(steps_with_few_and_with_more_pairs_than_the_last_find_all)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!qcHasCompute(device))
            continue;
        // Fewer than are put in order, as many, and so many more that the list must grow.
        qcSoup few = qcSoup_MakeRandom(5, 2500, 0.08), many = qcSoup_MakeRandom(5, 2500, 0.12),
               crowd = qcSoup_MakeRandom(5, 2500, 0.4), other = qcSoup_MakeRandom(8, 100, 0.01);
        const qcSoup* const steps[] = {&many, &crowd, &crowd, &few, &few, &many, &few, &crowd, &many, &crowd};
        Twins twins = MakeTwins(device, &few, &other);
        uint64_t reruns = 0;
        bool wasLarge = false;
        for (size_t i = 0; i < sizeof steps / sizeof steps[0]; i++)
        {
            qcDetectDef def = qcDefaultDetectDef();
            Move(&twins, steps[i]);
            const qcResult* result = CheckTwins(&twins, &def);
            ck_assert(IsOrdered(&result->profile) == wasLarge);
            wasLarge = steps[i] != &few;
            ck_assert((result->pairCount > qc_leastOrdered) == wasLarge);
            ck_assert_uint_gt(result->pairCount, qc_leastOrdered / 4);
            reruns += wasLarge && i == 1 ? result->profile.reruns : 0;
        }
        ck_assert_uint_gt(reruns, 0); // of a step that puts its pairs in order
        FreeTwins(&twins);
        qcSoup_Free(&few);
        qcSoup_Free(&many);
        qcSoup_Free(&crowd);
        qcSoup_Free(&other);
    }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

static bool LeaveOut(void* context, uint32_t slotA, uint32_t slotB)
{
    const uint32_t* leftOut = context;
    return slotA != *leftOut && slotB != *leftOut;
}

START_TEST(a_filter_leaves_out_pairs_that_are_in_order)
{
    setenv("QC_LAYERS_REFINE", "device", 1);
    qcSoup soup = qcSoup_MakeRandom(5, 2000, 0.15), other = qcSoup_MakeRandom(6, 500, 0.15);
    QC_FOR_EACH_DEVICE(device)
    {
        if (!qcHasCompute(device))
            continue;
        Twins twins = MakeTwins(device, &soup, &other);
        qcDetectDef def = qcDefaultDetectDef();
        CheckTwins(&twins, &def);
        for (uint32_t leftOut = 0; leftOut < 3; leftOut++)
        {
            def.pairFilter = LeaveOut;
            def.pairFilterContext = &leftOut;
            Move(&twins, &soup);
            const qcResult* result = CheckTwins(&twins, &def);
            ck_assert(IsOrdered(&result->profile));
            for (size_t i = 0; i < result->pairCount; i++)
                ck_assert(leftOut == 2 || result->pairs[i].bodyA == result->pairs[i].bodyB);
        }
        FreeTwins(&twins);
    }
    qcSoup_Free(&soup);
    qcSoup_Free(&other);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

QC_RUN_TESTS("layers, order", many_pairs_are_put_in_order_and_are_those_of_the_sweep,
             steps_with_few_and_with_more_pairs_than_the_last_find_all, a_filter_leaves_out_pairs_that_are_in_order)
