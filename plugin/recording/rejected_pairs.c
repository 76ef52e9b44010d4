// Linear probing in a table that is at most half full.
#include "recording/rejected_pairs.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

enum
{
    qc_firstCapacity = 64
};

void qcRejectedPairs_Init(qcRejectedPairs* pairs)
{
    *pairs = (qcRejectedPairs){0};
    pthread_mutex_init(&pairs->mutex, NULL);
}

void qcRejectedPairs_Free(qcRejectedPairs* pairs)
{
    qcFree(pairs->keys, pairs->capacity * sizeof *pairs->keys);
    pthread_mutex_destroy(&pairs->mutex);
}

void qcRejectedPairs_Start(qcRejectedPairs* pairs, qcPairFilter filter, void* context)
{
    pairs->filter = filter;
    pairs->context = context;
    pairs->count = 0;
    pairs->outOfMemory = false;
    if (pairs->capacity != 0)
        memset(pairs->keys, 0xff, pairs->capacity * sizeof *pairs->keys);
}

/// Inserts a key that may be there already; there is a free place.
static void Insert(qcRejectedPairs* pairs, uint64_t key)
{
    size_t mask = pairs->capacity - 1, at = (size_t)(key * 0x9e3779b97f4a7c15u >> 20) & mask;
    while (pairs->keys[at] != UINT64_MAX && pairs->keys[at] != key)
        at = (at + 1) & mask;
    pairs->count += pairs->keys[at] != key;
    pairs->keys[at] = key;
}

static bool Grow(qcRejectedPairs* pairs)
{
    size_t capacity = pairs->capacity != 0 ? 2 * pairs->capacity : qc_firstCapacity;
    uint64_t* keys = qcAllocate(capacity * sizeof *keys);
    if (keys == NULL)
        return false;
    memset(keys, 0xff, capacity * sizeof *keys);
    qcRejectedPairs old = *pairs;
    pairs->keys = keys;
    pairs->capacity = capacity;
    pairs->count = 0;
    for (size_t i = 0; i < old.capacity; i++)
        if (old.keys[i] != UINT64_MAX)
            Insert(pairs, old.keys[i]);
    qcFree(old.keys, old.capacity * sizeof *keys);
    return true;
}

bool qcRejectedPairs_Filter(void* context, uint32_t slotA, uint32_t slotB)
{
    qcRejectedPairs* pairs = context;
    if (pairs->filter(pairs->context, slotA, slotB))
        return true;
    pthread_mutex_lock(&pairs->mutex);
    if (2 * pairs->count < pairs->capacity || Grow(pairs))
        Insert(pairs, qcRejectedPair_Key(slotA, slotB));
    else
        pairs->outOfMemory = true;
    pthread_mutex_unlock(&pairs->mutex);
    return false;
}

static int CompareKeys(const void* a, const void* b)
{
    uint64_t x = *(const uint64_t*)a, y = *(const uint64_t*)b;
    return (x > y) - (x < y);
}

void qcRejectedPairs_Sort(qcRejectedPairs* pairs)
{
    size_t count = 0;
    for (size_t i = 0; i < pairs->capacity; i++)
        if (pairs->keys[i] != UINT64_MAX)
            pairs->keys[count++] = pairs->keys[i];
    if (count != 0)
        qsort(pairs->keys, count, sizeof *pairs->keys, CompareKeys);
}
