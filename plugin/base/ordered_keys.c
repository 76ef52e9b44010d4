// From the last key on, so that the first list needs no second place.
#include "base/ordered_keys.h"

#include <string.h>

size_t qcOrderedKeys_FindBegin(const uint64_t* keys, size_t count)
{
    size_t begin = count;
    while (begin > 1 && keys[begin - 2] <= keys[begin - 1])
        begin--;
    return begin > 1 ? begin - 1 : 0;
}

/// The number of ordered keys that are not above a key.
static size_t CountUpTo(const uint64_t* ordered, size_t count, uint64_t key)
{
    size_t begin = 0;
    while (begin < count)
    {
        size_t middle = begin + (count - begin) / 2;
        if (ordered[middle] <= key)
            begin = middle + 1;
        else
            count = middle;
    }
    return begin;
}

void qcOrderedKeys_Merge(uint64_t* keys, size_t count, const uint64_t* ordered, size_t orderedCount)
{
    while (count > 0 && orderedCount > 0)
    {
        uint64_t key = keys[count - 1];
        size_t below = CountUpTo(ordered, orderedCount, key);
        memcpy(keys + count + below, ordered + below, (orderedCount - below) * sizeof *keys);
        keys[--count + below] = key;
        orderedCount = below;
    }
    if (orderedCount > 0)
        memcpy(keys + count, ordered, orderedCount * sizeof *keys);
}
