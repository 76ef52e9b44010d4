// Keys of many shapes and numbers, against the C library's sort: keys, on one thread and on several, and items whose
// values tell their order apart.
#include "base/parallel_sort.h"
#include "base/radix_sort.h"
#include "support/check_ok.h"
#include "support/soups.h"
#include "support/suite.h"

#include <stdlib.h>

/// How keys lie: which of the sort's ways they take.
typedef enum Shape
{
    shape_equal,
    shape_anywhere,   ///< in 64 bits
    shape_twoNumbers, ///< of 17 bits, as pairs of triangles have, bits 2 to 18 and 33 to 49
    shape_fewLeading, ///< all but some have equal leading bits
    shape_small,      ///< many are equal
    shape_ascending,
    shape_count
} Shape;

static uint64_t MakeKey(qcRandom* random, Shape shape, size_t i)
{
    switch (shape)
    {
        case shape_equal: return 7;
        case shape_anywhere: return qcRandom_Next(random);
        case shape_twoNumbers: return (qcRandom_Next(random) & 0x1ffff) << 33 | (qcRandom_Next(random) & 0x1ffff) << 2;
        case shape_fewLeading:
            return qcRandom_Below(random, 50) == 0 ? qcRandom_Next(random) : qcRandom_Below(random, 5000);
        case shape_small: return qcRandom_Below(random, 60);
        default: return 3 * (uint64_t)i;
    }
}

static int CompareItems(const void* x, const void* y)
{
    const qcSortItem *a = x, *b = y;
    if (a->key != b->key)
        return a->key < b->key ? -1 : 1;
    return a->value < b->value ? -1 : a->value > b->value;
}

static const size_t s_counts[] = {0, 1, 2, 31, 32, 33, 200, 1024, 1025, 4500, 49152, 49153, 120000};

START_TEST(keys_and_items_are_sorted_and_equal_keys_keep_their_order)
{
    qcRandom random = {31};
    qcArray scratch = {0};
    for (size_t c = 0; c < sizeof s_counts / sizeof s_counts[0]; c++)
        for (int shape = 0; shape < shape_count; shape++)
        {
            size_t count = s_counts[c];
            qcSortItem *items = malloc((count + 1) * sizeof *items), *sorted = malloc((count + 1) * sizeof *sorted);
            uint64_t *keys = malloc((count + 1) * sizeof *keys), *parallel = malloc((count + 1) * sizeof *parallel);
            for (size_t i = 0; i < count; i++)
            {
                keys[i] = parallel[i] = MakeKey(&random, (Shape)shape, i);
                items[i] = sorted[i] = (qcSortItem){keys[i], i};
            }
            qsort(sorted, count, sizeof *sorted, CompareItems);
            CHECK_OK(qcSort_Items(items, count, &scratch));
            qcArray_Free(&scratch);
            CHECK_OK(qcSort_Keys(keys, count, &scratch));
            qcArray_Free(&scratch);
            CHECK_OK(qcParallelSort_Keys(1 + (uint32_t)shape, parallel, count, &scratch));
            qcArray_Free(&scratch);
            for (size_t i = 0; i < count; i++)
                if (CompareItems(&items[i], &sorted[i]) != 0 || keys[i] != sorted[i].key ||
                    parallel[i] != sorted[i].key)
                    ck_abort_msg("shape %d, %zu keys: number %zu is wrong", shape, count, i);
            free(items);
            free(sorted);
            free(keys);
            free(parallel);
        }
}
END_TEST

QC_RUN_TESTS("radix_sort", keys_and_items_are_sorted_and_equal_keys_keep_their_order)
