// In blocks, on several threads: first the pairs of each block that surely intersect are counted, then all are written
// to their places.
#include "cull/layers/device_pairs.h"

#include "base/parallel_for.h"
#include "base/related_pair.h"
#include "base/status.h"

enum
{
    // A block takes some 10 microseconds.
    qc_pairsOfBlock = 4096,
    qc_minBlocks = 4
};

typedef struct TakenPairs
{
    const qcDevicePairs* from;
    uint64_t *keys, *classified, *contactKeys; ///< ends of the lists; null: the pairs are not listed for contacts
    size_t* sureBefore; ///< by block: pairs in it, then in those before it, that surely intersect
} TakenPairs;

static size_t PairsOfBlock(const TakenPairs* taken, size_t block)
{
    size_t left = taken->from->count - block * qc_pairsOfBlock;
    return left < qc_pairsOfBlock ? left : qc_pairsOfBlock;
}

static uint64_t PairAt(const TakenPairs* taken, size_t i)
{
    const uint32_t* words = taken->from->pairs[i];
    return (uint64_t)words[1] << 32 | words[0];
}

static void CountSurePairs(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const TakenPairs* taken = context;
    size_t first = qc_pairsOfBlock * block, sure = 0, count = PairsOfBlock(taken, block);
    for (size_t i = 0; i < count; i++)
        sure += qcRelatedPair_Relation(PairAt(taken, first + i)) != qc_relationDisjoint;
    taken->sureBefore[block] = sure;
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const TakenPairs* taken = context;
    size_t first = block * qc_pairsOfBlock, sureAt = taken->sureBefore[block], openAt = first - sureAt;
    for (size_t i = 0; i < PairsOfBlock(taken, block); i++)
    {
        uint64_t pair = PairAt(taken, first + i), key = qcRelatedPair_Key(pair);
        if (qcRelatedPair_Relation(pair) == qc_relationDisjoint)
        {
            taken->keys[openAt++] = key;
            continue;
        }
        if (taken->contactKeys != NULL)
            taken->contactKeys[sureAt] = key;
        taken->classified[sureAt++] = pair;
    }
}

/// Returns the number of pairs that surely intersect.
static size_t FindSureBefore(TakenPairs* taken, size_t blocks)
{
    qcParallel_For(taken->from->threads, blocks, qc_minBlocks, CountSurePairs, taken);
    size_t sum = 0;
    for (size_t block = 0; block < blocks; block++)
    {
        size_t sure = taken->sureBefore[block];
        taken->sureBefore[block] = sum;
        sum += sure;
    }
    return sum;
}

/// Makes room for more keys. Returns where they begin.
static qcStatus AddRoom(qcArray* keys, size_t count, uint64_t** begin)
{
    size_t at = keys->count;
    QC_TRY(qcArray_Resize(keys, at + count, sizeof(uint64_t), "candidates"));
    *begin = (uint64_t*)keys->data + at;
    return qc_statusOk;
}

qcStatus qcDevicePairs_Take(const qcDevicePairs* pairs, qcArray* scratch, const qcPairKeys* keys)
{
    size_t blocks = (pairs->count + qc_pairsOfBlock - 1) / qc_pairsOfBlock;
    if (blocks == 0)
        return qc_statusOk;
    QC_TRY(qcArray_Resize(scratch, blocks, sizeof(size_t), "candidates"));
    TakenPairs taken = {.from = pairs, .sureBefore = scratch->data};
    size_t sure = FindSureBefore(&taken, blocks);
    QC_TRY(AddRoom(keys->keys, pairs->count - sure, &taken.keys));
    QC_TRY(AddRoom(keys->classified, sure, &taken.classified));
    if (pairs->listClassified)
        QC_TRY(AddRoom(keys->contactKeys, sure, &taken.contactKeys));
    qcParallel_For(pairs->threads, blocks, qc_minBlocks, TakeBlock, &taken);
    return qc_statusOk;
}
