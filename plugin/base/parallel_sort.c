// One pass by the leading bits, each thread with blocks of the keys; then each thread sorts some of the ranges, of keys
// whose leading bits follow each other.
#include "base/parallel_sort.h"

#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_leadingBits = 8,
    qc_leadings = 1 << qc_leadingBits,
    // Ranges of a thread. More of them, one for each of the leading bits, are sorted in twice the time: in passes over
    // few keys the digits are what takes time.
    qc_threadRanges = 4,
    // Counting or distributing the keys of a block takes some 5 microseconds.
    qc_blockKeys = 4096,
    qc_maxBlocks = 64,
    qc_minBlocks = 8,
    qc_minRanges = 4
};

typedef struct ParallelSort
{
    uint64_t *keys, *ordered; ///< `ordered`: by leading bits
    size_t count, blockKeys, blockCount;
    int shift;
    size_t (*ends)[qc_leadings]; ///< by block and leading bits: numbers, then begins and at last ends in `ordered`
    size_t rangeEnds[qc_leadings], rangeCount;
} ParallelSort;

static size_t LeadingOf(const ParallelSort* sort, uint64_t key)
{
    return key >> sort->shift & (qc_leadings - 1);
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
    size_t numbers[qc_leadings] = {0}, end = BlockEnd(sort, block);
    for (size_t i = block * sort->blockKeys; i < end; i++)
        numbers[LeadingOf(sort, sort->keys[i])]++;
    memcpy(sort->ends[block], numbers, sizeof numbers);
}

static void DistributeBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const ParallelSort* sort = context;
    size_t *ends = sort->ends[block], end = BlockEnd(sort, block);
    for (size_t i = block * sort->blockKeys; i < end; i++)
        sort->ordered[ends[LeadingOf(sort, sort->keys[i])]++] = sort->keys[i];
}

static void SortRange(void* context, size_t range, uint32_t worker)
{
    (void)worker;
    const ParallelSort* sort = context;
    size_t first = range != 0 ? sort->rangeEnds[range - 1] : 0, count = sort->rangeEnds[range] - first;
    qcSort_KeysWith(sort->ordered + first, sort->keys + first, count);
    if (count != 0)
        memcpy(sort->keys + first, sort->ordered + first, count * sizeof(uint64_t));
}

/// From numbers of keys to where each block's keys of a range begin.
static void FindBegins(const ParallelSort* sort)
{
    size_t sum = 0;
    for (size_t leading = 0; leading < qc_leadings; leading++)
        for (size_t block = 0; block < sort->blockCount; block++)
        {
            size_t number = sort->ends[block][leading];
            sort->ends[block][leading] = sum;
            sum += number;
        }
}

/// Ranges of at least `least` keys, up to the last one.
static void FindRanges(ParallelSort* sort, size_t least)
{
    const size_t* ends = sort->ends[sort->blockCount - 1];
    size_t begin = 0;
    sort->rangeCount = 0;
    for (size_t leading = 0; leading < qc_leadings; leading++)
    {
        if (ends[leading] - begin < least && ends[leading] != sort->count)
            continue;
        sort->rangeEnds[sort->rangeCount++] = begin = ends[leading];
        if (begin == sort->count)
            return;
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
    QC_TRY(qcArray_Reserve(scratch, count + sort.blockCount * qc_leadings, sizeof(uint64_t), "sorting"));
    sort.ordered = scratch->data;
    sort.ends = (size_t(*)[qc_leadings])(sort.ordered + count);
    qcParallel_For(threads, sort.blockCount, qc_minBlocks, CountBlock, &sort);
    FindBegins(&sort);
    qcParallel_For(threads, sort.blockCount, qc_minBlocks, DistributeBlock, &sort);
    FindRanges(&sort, count / (qc_threadRanges * (size_t)threads));
    qcParallel_For(threads, sort.rangeCount, qc_minRanges, SortRange, &sort);
    return qc_statusOk;
}
