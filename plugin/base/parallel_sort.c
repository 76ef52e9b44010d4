// One pass by the leading bits, each thread with blocks of the keys; then each thread sorts some of the ranges that
// have the same leading bits.
#include "base/parallel_sort.h"

#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_leadingBits = 8,
    qc_ranges = 1 << qc_leadingBits,
    // Counting or distributing the keys of a block takes some 5 microseconds.
    qc_blockKeys = 4096,
    qc_maxBlocks = 64,
    qc_minBlocks = 8,
    qc_minRanges = 32
};

typedef struct ParallelSort
{
    uint64_t *keys, *ordered; ///< `ordered`: by leading bits
    size_t count, blockKeys, blockCount;
    int shift;
    size_t (*ends)[qc_ranges]; ///< by block and range: numbers of keys, then begins and at last ends in `ordered`
} ParallelSort;

static size_t RangeOf(const ParallelSort* sort, uint64_t key)
{
    return key >> sort->shift & (qc_ranges - 1);
}

static size_t BlockEnd(const ParallelSort* sort, size_t block)
{
    size_t end = (block + 1) * sort->blockKeys;
    return end < sort->count ? end : sort->count;
}

static void CountBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const ParallelSort* sort = context;
    size_t numbers[qc_ranges] = {0};
    for (size_t i = block * sort->blockKeys; i < BlockEnd(sort, block); i++)
        numbers[RangeOf(sort, sort->keys[i])]++;
    memcpy(sort->ends[block], numbers, sizeof numbers);
}

static void DistributeBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const ParallelSort* sort = context;
    size_t* ends = sort->ends[block];
    for (size_t i = block * sort->blockKeys; i < BlockEnd(sort, block); i++)
        sort->ordered[ends[RangeOf(sort, sort->keys[i])]++] = sort->keys[i];
}

static void SortRange(void* context, size_t range, uint32_t worker)
{
    (void)worker;
    const ParallelSort* sort = context;
    const size_t* ends = sort->ends[sort->blockCount - 1];
    size_t first = range != 0 ? ends[range - 1] : 0, count = ends[range] - first;
    qcSort_KeysWith(sort->ordered + first, sort->keys + first, count);
    if (count != 0)
        memcpy(sort->keys + first, sort->ordered + first, count * sizeof(uint64_t));
}

/// From numbers of keys to where each block's keys of a range begin.
static void FindBegins(const ParallelSort* sort)
{
    size_t sum = 0;
    for (size_t range = 0; range < qc_ranges; range++)
        for (size_t block = 0; block < sort->blockCount; block++)
        {
            size_t number = sort->ends[block][range];
            sort->ends[block][range] = sum;
            sum += number;
        }
}

qcStatus qcParallelSort_Keys(uint32_t threads, uint64_t* keys, size_t count, qcArray* scratch)
{
    bool isLong = threads > 1 && count >= (size_t)qc_minBlocks * qc_blockKeys;
    uint64_t differ = isLong ? qcSort_FindDifference(keys, count) : 0;
    if (differ == 0)
        return qcSort_Keys(keys, count, scratch);
    int top = 64 - __builtin_clzll(differ);
    ParallelSort sort = {.keys = keys,
                         .count = count,
                         .blockKeys = (count + qc_maxBlocks - 1) / qc_maxBlocks,
                         .shift = top > qc_leadingBits ? top - qc_leadingBits : 0};
    sort.blockKeys = sort.blockKeys > qc_blockKeys ? sort.blockKeys : qc_blockKeys;
    sort.blockCount = (count + sort.blockKeys - 1) / sort.blockKeys;
    QC_TRY(qcArray_Reserve(scratch, count + sort.blockCount * qc_ranges, sizeof(uint64_t), "sorting"));
    sort.ordered = scratch->data;
    sort.ends = (size_t(*)[qc_ranges])(sort.ordered + count);
    qcParallel_For(threads, sort.blockCount, qc_minBlocks, CountBlock, &sort);
    FindBegins(&sort);
    qcParallel_For(threads, sort.blockCount, qc_minBlocks, DistributeBlock, &sort);
    qcParallel_For(threads, qc_ranges, qc_minRanges, SortRange, &sort);
    return qc_statusOk;
}
