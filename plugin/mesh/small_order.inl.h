// Halves up to 4096 triangles along the longest axis: bisection finds the coordinate of the median, and ranks find that
// of few; one pass splits. The source of an instruction set defines before it includes this header: Shorts (qc_shorts
// of int16_t), LoadShorts, MinShorts, MaxShorts; ReadKeys, CountBelow and MoveItems as mesh/item_moves.inl.h does.
#ifndef QC_MESH_SMALL_ORDER_INL_H
#define QC_MESH_SMALL_ORDER_INL_H

#include "mesh/limits.h"
#include "mesh/order_item.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

enum
{
    qc_maxCoordinate = INT16_MAX,
    // Items that span fewer steps of the coordinates are rounded anew, if there are more than two clusters of them.
    qc_minExtent = 64,
};

/// Items that lie side by side, and as much memory.
typedef struct Range
{
    Item *items, *scratch;
    const qcCentroid* centroids;
    uint32_t* triangles; ///< the result
    uint32_t count;
} Range;

/// Rounds the centroids, relative to the box around them.
static void Round(const Range* range)
{
    float low[3] = {FLT_MAX, FLT_MAX, FLT_MAX}, high[3] = {0.0f, 0.0f, 0.0f}, extent = 0.0f;
    for (uint32_t i = 0; i < range->count; i++)
        for (int k = 0; k < 3; k++)
        {
            float x = range->centroids[range->items[i].at[3]].at[k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    for (int k = 0; k < 3; k++)
        extent = high[k] - low[k] > extent ? high[k] - low[k] : extent;
    float scale = (float)qc_maxCoordinate * (1.0f - 0x1p-20f) / extent;
    scale = scale < FLT_MAX ? scale : 0.0f;
    for (uint32_t i = 0; i < range->count; i++)
        for (int k = 0; k < 3; k++)
            range->items[i].at[k] = (int16_t)((range->centroids[range->items[i].at[3]].at[k] - low[k]) * scale);
}

/// The longest axis of the items, and its bounds.
typedef struct Axis
{
    int index, low, high;
} Axis;

static Axis FindAxis(const Item* items, uint32_t count)
{
    // A vector at a time; the last one overlaps the one before it.
    Shorts low = LoadShorts(items), high = low;
    for (uint32_t i = qc_shorts / 4; i < count; i += qc_shorts / 4)
    {
        Shorts some = LoadShorts(items + (i + qc_shorts / 4 < count ? i : count - qc_shorts / 4));
        low = MinShorts(low, some);
        high = MaxShorts(high, some);
    }
    Item lows[qc_shorts / 4], highs[qc_shorts / 4];
    memcpy(lows, &low, sizeof lows);
    memcpy(highs, &high, sizeof highs);
    Axis longest = {0, 0, -1};
    for (int k = 0; k < 3; k++)
    {
        int first = lows[0].at[k], last = highs[0].at[k];
        for (int i = 1; i < qc_shorts / 4; i++)
        {
            first = lows[i].at[k] < first ? lows[i].at[k] : first;
            last = highs[i].at[k] > last ? highs[i].at[k] : last;
        }
        if (last - first > longest.high - longest.low)
            longest = (Axis){k, first, last};
    }
    return longest;
}

/// The key that `lower` of up to qc_countedKeys keys are below; -1: there is none, since keys are equal. In the time of
/// two of the steps of a bisection, which each wait for the one before.
static int FindByRank(const int16_t* keys, uint32_t count, uint32_t lower)
{
    enum
    {
        qc_vectors = qc_countedKeys / qc_shorts
    };
    Shorts own[qc_vectors], ranks[qc_vectors];
    for (int k = 0; k < qc_vectors; k++)
    {
        own[k] = LoadShorts(keys + k * qc_shorts);
        ranks[k] = (Shorts){0};
    }
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < qc_vectors; k++)
            ranks[k] -= (Shorts){0} + keys[i] < own[k];
    Shorts found = (Shorts){0} - 1;
    for (int k = 0; k < qc_vectors; k++)
    {
        const Shorts isIt = ranks[k] == (Shorts){0} + (int16_t)lower;
        found = MaxShorts(found, (own[k] & isIt) | ~isIt);
    }
    int16_t all[qc_shorts], max = -1;
    memcpy(all, &found, sizeof all);
    for (int k = 0; k < qc_shorts; k++)
        max = all[k] > max ? all[k] : max;
    return max;
}

/// The value below which `lower` keys are. Where there is none since keys are equal, the first of these become less.
static int FindMedian(int16_t* keys, uint32_t count, const Axis* axis, uint32_t lower)
{
    const int ranked = count <= qc_countedKeys ? FindByRank(keys, count, lower) : -1;
    if (ranked >= 0)
        return ranked;
    int low = axis->low, high = axis->high + 1;
    uint32_t below = 0;
    while (below != lower && high - low > 1)
    {
        int middle = (low + high) / 2;
        uint32_t found = CountBelow(keys, count, middle);
        below = found <= lower ? found : below;
        bool isLow = found <= lower;
        low = isLow ? middle : low;
        high = isLow ? high : middle;
    }
    for (uint32_t i = 0; i < count && below != lower; i++)
    {
        bool isEqual = keys[i] == low;
        keys[i] = (int16_t)(keys[i] - isEqual);
        below += isEqual;
    }
    return low;
}

/// Moves the `lower` items with the lowest coordinates to the front, the others to the scratch, behind as many places.
static void Split(const Range* range, const Axis* axis, uint32_t lower)
{
    int16_t keys[qc_maxSmallOrder + qc_countedKeys];
    const uint32_t count = range->count;
    ReadKeys(range->items, count, axis->index, keys);
    const Shorts above = (Shorts){0} + INT16_MAX;
    for (int k = 0; k < qc_countedKeys; k += qc_shorts)
        memcpy(keys + count + k, &above, sizeof above);
    const int median = FindMedian(keys, count, axis, lower);
    MoveItems(range->items, keys, count, median, range->scratch + count - 1);
}

/// Down to groups of `size`; nodes then down to clusters.
static void Halve(Range range, uint32_t size)
{
    while (range.count > size)
    {
        uint32_t lower = qcSmallOrder_CutAt(range.count, size);
        Axis axis = FindAxis(range.items, range.count);
        if (axis.high - axis.low < qc_minExtent && range.count > 2 * qc_clusterSize)
        {
            Round(&range);
            axis = FindAxis(range.items, range.count);
        }
        Split(&range, &axis, lower);
        Range upper = range;
        upper.items = range.scratch + lower;
        upper.scratch = range.items + lower;
        upper.triangles += lower;
        upper.count -= lower;
        range.count = lower;
        Halve(range, size);
        range = upper;
    }
    if (size == qc_nodeSize)
    {
        Halve(range, qc_clusterSize);
        return;
    }
    for (uint32_t i = 0; i < range.count; i++)
        range.triangles[i] = range.centroids[range.items[i].at[3]].triangle;
}

static void MakeSmallOrder(const qcCentroid* centroids, uint32_t count, void* memory, uint32_t* triangles)
{
    Item* items = memory;
    Range range = {items, items + count, centroids, triangles, count};
    for (uint32_t i = 0; i < count; i++)
        items[i].at[3] = (int16_t)i;
    Round(&range);
    Halve(range, qc_nodeSize);
}

#endif
