// The BVH forest of a set of boxes: its kernels against brute force, and the work that is saved when few boxes move.
#include "broadphase/box_model.h"
#include "broadphase/bvh_build_order.h"
#include "support/suite.h"

/// A forest of random boxes in one dynamic tree, some of them removed again.
static uint32_t GrowTree(qcForest* forest, uint64_t seed, uint32_t count, bool infinite)
{
    qcRandom random = {seed};
    CHECK_OK(qcForest_Reserve(forest, count));
    for (uint32_t id = 0; id < count; id++)
    {
        qcFloatBox box;
        for (int k = 0; k < 3; k++)
        {
            box.lower[k] = (float)qcRandom_Integer(&random, 0, 10);
            box.upper[k] = box.lower[k] + (float)qcRandom_Integer(&random, 0, 3);
            if (infinite && qcRandom_Below(&random, 20) == 0)
                box.lower[k] = -INFINITY;
            if (infinite && qcRandom_Below(&random, 20) == 0)
                box.upper[k] = INFINITY;
        }
        qcForest_Insert(forest, id, &box, false);
    }
    uint32_t tree;
    CHECK_OK(qcForest_MergeDynamic(forest, &tree));
    for (uint32_t id = 1; id < count; id += 1 + qcRandom_Below(&random, 9))
        qcForest_Remove(forest, id);
    return tree;
}

/// The lanes that overlap the rows, as a bit mask like that of the kernels.
static uint64_t OverlapByHand(const qcForest* forest, const uint32_t* rows, const uint32_t* lanes)
{
    const qcFloatBox* boxes = forest->boxes.data;
    uint64_t bits = 0;
    for (uint32_t row = 0; row < qc_lanes; row++)
        for (uint32_t lane = 0; lane < qc_lanes; lane++)
            if (rows[row] != QC_NO_BOX && lanes[lane] != QC_NO_BOX &&
                qcFloatBox_Overlap(&boxes[rows[row]], &boxes[lanes[lane]]))
                bits |= (uint64_t)1 << (lane + qc_lanes * row);
    return bits;
}

static void CheckFindOverlaps(const qcForest* forest, const qcBoxTree* tree, uint32_t octet, uint32_t first)
{
    qcOctetHit hits[qc_modelRoom / qc_lanes];
    const qcBoxKernels* kernels;
    for (size_t i = 0; (kernels = qcBoxKernels_Nth(i)) != NULL; i++)
    {
        uint64_t found[qc_modelRoom / qc_lanes] = {0};
        size_t count = kernels->findOverlaps(&tree->shape.octets[octet], &tree->shape, first, hits);
        for (size_t h = 0; h < count; h++)
        {
            CHECK_QUICKLY(hits[h].octet >= first && hits[h].octet < tree->laneCount / qc_lanes);
            CHECK_QUICKLY(found[hits[h].octet] == 0 && hits[h].lanes != 0);
            found[hits[h].octet] = hits[h].lanes;
        }
        for (uint32_t o = first; o < tree->laneCount / qc_lanes; o++)
            CHECK_QUICKLY(found[o] == OverlapByHand(forest, &QC_AT(uint32_t, tree->ids, qc_lanes * octet),
                                                    &QC_AT(uint32_t, tree->ids, qc_lanes * o)));
    }
}

START_TEST(every_kernel_finds_what_brute_force_finds)
{
    static const uint32_t counts[] = {1, 7, 8, 9, 63, 64, 65, 200, 513, 1500};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (int infinite = 0; infinite <= 1; infinite++)
        {
            qcForest forest = {0};
            const qcBoxTree* tree = &forest.trees[GrowTree(&forest, c + 1, counts[c], infinite)];
            uint32_t octets = tree->laneCount / qc_lanes;
            for (uint32_t octet = 0; octet < octets; octet++)
                CheckFindOverlaps(&forest, tree, octet, octet % 3 == 0 ? 0 : octet);
            qcForest_Free(&forest);
        }
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

/// A path among the boxes of GrowTree; some of its axes have no slab.
static qcFloatCast MakeCast(qcRandom* random)
{
    qcFloatCast cast;
    for (int k = 0; k < 3; k++)
    {
        double from = (double)qcRandom_Integer(random, -4, 40) / 4.0,
               to = (double)qcRandom_Integer(random, -4, 40) / 4.0;
        cast.path.lower[k] = (float)fmin(from, to);
        cast.path.upper[k] = (float)fmax(from, to);
        cast.lowerOffset[k] = (float)(from + (double)qcRandom_Below(random, 2) / 3.0);
        cast.upperOffset[k] = (float)from;
        cast.inverse[k] = from != to && qcRandom_Below(random, 10) != 0 ? (float)(1.0 / (to - from)) : 0.0f;
    }
    return cast;
}

START_TEST(every_kernel_casts_with_the_same_result_to_the_last_bit)
{
    qcForest forest = {0};
    const qcBoxTree* tree = &forest.trees[GrowTree(&forest, 5, 513, true)];
    qcRandom random = {6};
    uint32_t hits = 0, misses = 0;
    for (uint32_t i = 0; i < 20000; i++)
    {
        const qcOctet* octet = &tree->shape.octets[i % (tree->laneCount / qc_lanes)];
        qcFloatCast cast = MakeCast(&random);
        float fraction = (float)qcRandom_Below(&random, 5) / 4.0f, entries[2][qc_lanes];
        uint32_t lanes = qcBoxKernels_Nth(0)->cast(octet, &cast, fraction, entries[0]);
        // Lanes that overlap the path as a whole are culled by their slabs alone.
        uint32_t overlapping = qcBoxKernels_Nth(0)->overlap(octet, &cast.path);
        ck_assert_uint_eq(lanes & ~overlapping, 0);
        hits += (uint32_t)__builtin_popcount(lanes);
        misses += (uint32_t)__builtin_popcount(overlapping & ~lanes);
        const qcBoxKernels* kernels;
        for (size_t n = 1; (kernels = qcBoxKernels_Nth(n)) != NULL; n++)
        {
            ck_assert_uint_eq(kernels->cast(octet, &cast, fraction, entries[1]), lanes);
            for (int lane = 0; lane < qc_lanes; lane++)
                if ((lanes >> lane & 1) != 0)
                    ck_assert_mem_eq(&entries[0][lane], &entries[1][lane], sizeof(float));
        }
    }
    ck_assert_uint_gt(hits, 1000);
    ck_assert_uint_gt(misses, 1000);
    qcForest_Free(&forest);
}
END_TEST

START_TEST(a_box_of_floats_is_the_smallest_around_a_box)
{
    static const double values[] = {0.0,    -0.0,  1.0,    0.1,      -0.1,      1e-310,   -1e-310,  1e300,
                                    -1e300, 1e-60, -1e-60, 16777217, -16777217, INFINITY, -INFINITY};
    for (size_t i = 0; i < sizeof values / sizeof *values; i++)
    {
        const double value[3] = {values[i], values[i], values[i]};
        qcFloatBox box;
        bool exact = qcFloatBox_Enclose(&box, value, value);
        ck_assert((double)box.lower[0] <= values[i] && (double)box.upper[0] >= values[i]);
        ck_assert(isinf(values[i]) || (double)nextafterf(box.lower[0], INFINITY) > values[i]);
        ck_assert(isinf(values[i]) || (double)nextafterf(box.upper[0], -INFINITY) < values[i]);
        ck_assert_int_eq(exact, (double)box.lower[2] == values[i] && (double)box.upper[2] == values[i]);
    }
}
END_TEST

START_TEST(a_box_of_floats_relative_to_an_origin_contains_the_box)
{
    // Differences that round to a float: 2^53 + 1 and 2^53 - 0.5 become 2^53.
    static const qcBoxOrigin origin = {{-0x1p53, 0x1p53, 0x1p960}, true};
    qcFloatBox box;
    qcBoxOrigin_EncloseFrom(&origin, &box, (double[3]){-0.5, -1, -DBL_MAX}, (double[3]){1, 0.5, DBL_MAX});
    ck_assert(box.lower[0] < 0x1p53f && box.upper[0] > 0x1p53f);
    ck_assert(box.lower[1] < -0x1p53f && box.upper[1] > -0x1p53f);
    ck_assert(box.lower[2] == -INFINITY && box.upper[2] == INFINITY);
    // No wider than rounding makes it.
    ck_assert(box.lower[0] >= 0x1p53f - 0x1p30f && box.upper[0] <= 0x1p53f + 0x1p30f);
    qcBoxOrigin_EncloseFrom(&origin, &box, (double[3]){-INFINITY, INFINITY, -INFINITY},
                            (double[3]){INFINITY, INFINITY, -INFINITY});
    ck_assert(box.lower[0] == -INFINITY && box.upper[0] == INFINITY);
    ck_assert(box.lower[1] == INFINITY && box.upper[1] == INFINITY);
    ck_assert(box.lower[2] == -INFINITY && box.upper[2] == -INFINITY);
    // The origin itself.
    qcBoxOrigin_EncloseFrom(&origin, &box, origin.at, origin.at);
    for (int k = 0; k < 3; k++)
        ck_assert(box.lower[k] == 0.0f && box.upper[k] == 0.0f);
}
END_TEST

START_TEST(the_origin_moves_only_where_fewer_boxes_are_coarse)
{
    qcBounds sample[qc_originSample];
    for (uint32_t i = 0; i < qc_originSample; i++)
        for (int k = 0; k < 3; k++)
        {
            sample[i].lower[k] = 1e9 + 0.1 * (i * (uint32_t)(k + 3) % 64);
            sample[i].upper[k] = sample[i].lower[k] + 0.5;
        }
    qcBoxOrigin origin = {.isSet = false};
    ck_assert(qcBoxOrigin_Choose(&origin, sample, qc_originSample));
    ck_assert(origin.isSet && fabs(origin.at[0] - 1e9) < 10.0 && fabs(origin.at[2] - 1e9) < 10.0);
    // There no box is coarse.
    ck_assert(!qcBoxOrigin_Choose(&origin, sample, qc_originSample));
    // Two crowds far apart: no origin is near both.
    origin = (qcBoxOrigin){.isSet = false};
    for (uint32_t i = 0; i < qc_originSample; i += 2)
        for (int k = 0; k < 3; k++)
        {
            sample[i].lower[k] -= 2e9;
            sample[i].upper[k] -= 2e9;
        }
    ck_assert(!qcBoxOrigin_Choose(&origin, sample, qc_originSample));
    // Points near zero are coarse wherever the origin is.
    for (uint32_t i = 0; i < qc_originSample; i++)
        for (int k = 0; k < 3; k++)
            sample[i].lower[k] = sample[i].upper[k] = 0.1 * (i * (uint32_t)(k + 3) % 61 + 1);
    ck_assert(!qcBoxOrigin_Choose(&origin, sample, qc_originSample));
    ck_assert(!qcBoxOrigin_Choose(&origin, sample, 0));
    ck_assert(!origin.isSet);
}
END_TEST

START_TEST(build_order_keeps_every_item_and_neighbours_together)
{
    enum
    {
        count = 4000
    };
    static qcFloatBox boxes[count];
    static qcBoxItem items[count];
    bool seen[count] = {false};
    // A line in descending order, which is bad for naive splits. One box is far away, one is infinite.
    for (uint32_t i = 0; i < count; i++)
    {
        float x = (float)(count - i);
        boxes[i] = (qcFloatBox){{x, 0.0f, 0.0f}, {x + 1.0f, 1.0f, 1.0f}};
    }
    boxes[17] = (qcFloatBox){{1e9f, 0.0f, 0.0f}, {1e9f + 100.0f, 1.0f, 1.0f}};
    boxes[18] = (qcFloatBox){{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    for (uint32_t i = 0; i < count; i++)
        items[i] = qcBoxItem_Make(&boxes[i], i);
    qcBuildOrder_Arrange(items, count, boxes);
    uint32_t wide = 0;
    for (uint32_t i = 0; i < count; i += qc_lanes)
    {
        float lower = INFINITY, upper = -INFINITY;
        for (uint32_t j = i; j < i + qc_lanes; j++)
        {
            CHECK_QUICKLY(!seen[items[j].id]);
            seen[items[j].id] = true;
            lower = fminf(lower, boxes[items[j].id].lower[0]);
            upper = fmaxf(upper, boxes[items[j].id].upper[0]);
        }
        wide += upper - lower > 11.0f;
    }
    ck_assert_uint_le(wide, 1);
}
END_TEST

/// A grid of boxes: `stay` of them stationary, `move` that will move.
static qcModel* MakeWorld(uint32_t stay, uint32_t move)
{
    qcModel* model = qcModel_Make();
    for (uint32_t i = 0; i < stay + move; i++)
    {
        double lower[3] = {i % 10, i / 10 % 10, i / 100}, upper[3] = {lower[0] + 0.9, lower[1] + 0.9, lower[2] + 0.9};
        qcModel_Add(model, lower, upper);
    }
    qcModel_CheckMovedPairs(model);
    return model;
}

START_TEST(a_search_without_moves_does_nothing)
{
    qcModel* model = MakeWorld(1000, 0);
    ck_assert_uint_eq(qcBoxes_GetProfile(model->set).moved, 1000);
    ck_assert_uint_eq(qcBoxes_GetProfile(model->set).sought, 1000);
    for (int step = 0; step < 3; step++)
    {
        for (uint32_t id = 0; id < 1000; id++)
            qcModel_Move(model, id, model->boxes[id].lower, model->boxes[id].upper);
        ck_assert_uint_eq(qcModel_CheckMovedPairs(model), 0);
        qcBoxProfile profile = qcBoxes_GetProfile(model->set);
        ck_assert(profile.moved == 0 && profile.sought == 0 && profile.compared == 0 && profile.sorted == 0);
    }
    qcModel_Free(model);
}
END_TEST

/// Moves boxes added after 1000 stationary ones, for 100 steps. Returns the sum of the searches' profiles.
static qcBoxProfile MoveSteps(qcModel* model, uint32_t count)
{
    qcRandom random = {5};
    qcBoxProfile sum = {0};
    for (int step = 0; step < 100; step++)
    {
        for (uint32_t id = 1000; id < 1000 + count; id++)
        {
            double lower[3], upper[3];
            for (int k = 0; k < 3; k++)
            {
                double way = k == (int)(id % 3) ? 0.06 : qcRandom_Uniform(&random, -0.01, 0.01);
                lower[k] = model->boxes[id].lower[k] + way;
                upper[k] = model->boxes[id].upper[k] + way;
            }
            qcModel_Move(model, id, lower, upper);
        }
        qcModel_CheckMovedPairs(model);
        qcModel_CheckForest(model);
        qcBoxProfile profile = qcBoxes_GetProfile(model->set);
        ck_assert_uint_eq(profile.moved, count);
        ck_assert_uint_le(profile.compared, count * 40);
        sum.sought += profile.sought;
        sum.sorted += profile.sorted;
    }
    return sum;
}

START_TEST(a_search_with_few_moves_leaves_the_rest_alone)
{
    qcModel* model = MakeWorld(1000, 20);
    qcBoxProfile sum = MoveSteps(model, 20);
    // Without fat AABBs each of the 2000 moves would search the forest, and would be sorted several times with others.
    ck_assert_uint_lt(sum.sought, 1000);
    ck_assert_uint_lt(sum.sorted, 8 * 1000);
    qcModel_Free(model);
}
END_TEST

START_TEST(a_search_with_very_few_moves_builds_no_tree)
{
    qcModel* model = MakeWorld(1000, 6);
    qcBoxProfile sum = MoveSteps(model, 6);
    ck_assert_uint_gt(sum.sought, 20);
    ck_assert_uint_eq(sum.sorted, 0);
    qcModel_Free(model);
}
END_TEST

QC_RUN_TESTS("box forest", every_kernel_finds_what_brute_force_finds,
             every_kernel_casts_with_the_same_result_to_the_last_bit, a_box_of_floats_is_the_smallest_around_a_box,
             a_box_of_floats_relative_to_an_origin_contains_the_box, the_origin_moves_only_where_fewer_boxes_are_coarse,
             build_order_keeps_every_item_and_neighbours_together, a_search_without_moves_does_nothing,
             a_search_with_few_moves_leaves_the_rest_alone, a_search_with_very_few_moves_builds_no_tree)
