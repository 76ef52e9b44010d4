// Where ordered keys begin, and their merging, against the C library's sort.
#include "base/ordered_keys.h"
#include "support/soups.h"
#include "support/suite.h"

#include <stdlib.h>

static int CompareKeys(const void* x, const void* y)
{
    const uint64_t a = *(const uint64_t*)x, b = *(const uint64_t*)y;
    return a < b ? -1 : a > b;
}

/// `range`: keys are below it.
static void FillOrdered(qcRandom* random, uint64_t* keys, size_t count, uint32_t range)
{
    for (size_t i = 0; i < count; i++)
        keys[i] = (uint64_t)qcRandom_Below(random, range) << 20;
    qsort(keys, count, sizeof *keys, CompareKeys);
}

START_TEST(ordered_lists_of_all_sizes_are_merged)
{
    static const size_t s_counts[] = {0, 1, 2, 3, 17, 300, 4000};
    static const uint32_t s_ranges[] = {1, 3, 1000000};
    enum
    {
        qc_most = 4000
    };
    static uint64_t s_keys[2 * qc_most + 1], s_ordered[qc_most], s_expected[2 * qc_most];
    qcRandom random = {5};
    for (int c = 0; c < 7 * 7 * 3; c++)
    {
        size_t count = s_counts[c % 7], orderedCount = s_counts[c / 7 % 7], total = count + orderedCount;
        FillOrdered(&random, s_keys, count, s_ranges[c / 49]);
        FillOrdered(&random, s_ordered, orderedCount, s_ranges[c / 49]);
        memcpy(s_expected, s_keys, count * sizeof *s_keys);
        memcpy(s_expected + count, s_ordered, orderedCount * sizeof *s_keys);
        qsort(s_expected, total, sizeof *s_expected, CompareKeys);
        s_keys[total] = 77; // behind the room
        qcOrderedKeys_Merge(s_keys, count, s_ordered, orderedCount);
        ck_assert_int_eq(memcmp(s_keys, s_expected, total * sizeof *s_keys), 0);
        ck_assert_uint_eq(s_keys[total], 77);
    }
}
END_TEST

START_TEST(the_ordered_end_begins_behind_the_last_key_above_its_next)
{
    qcRandom random = {6};
    uint64_t keys[40];
    for (int round = 0; round < 2000; round++)
    {
        size_t count = qcRandom_Below(&random, 41), begin = 0;
        // Few descents, or many.
        for (size_t i = 0; i < count; i++)
            keys[i] = round % 2 == 0 ? qcRandom_Below(&random, 4) : i + 3 * qcRandom_Below(&random, 2);
        for (size_t i = 1; i < count; i++)
            begin = keys[i - 1] > keys[i] ? i : begin;
        ck_assert_uint_eq(qcOrderedKeys_FindBegin(keys, count), begin);
    }
}
END_TEST

QC_RUN_TESTS("ordered_keys", ordered_lists_of_all_sizes_are_merged,
             the_ordered_end_begins_behind_the_last_key_above_its_next)
