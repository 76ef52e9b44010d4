// Halves up to 4096 triangles along the longest axis: bisection finds the coordinate of the median, one pass splits.
#include "mesh/small_order.h"

#include "base/eight_shorts.h"
#include "mesh/limits.h"

#include <float.h>
#include <stdbool.h>

enum
{
    qc_maxCoordinate = INT16_MAX,
    // Items that span fewer steps of the coordinates are rounded anew, if there are more than two clusters of them.
    qc_minExtent = 64,
    qc_countedKeys = 32 ///< at a time
};

typedef union Item
{
    int16_t at[4]; ///< 0 .. qc_maxCoordinate; the last is the index of the centroid
    uint64_t all;
} Item;

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
    // Two items at a time; the last two may be one that was looked at before.
    qcEightShorts low, high;
    Item pair[2] = {items[0], items[count - 1]};
    low = high = qcEightShorts_Load(pair);
    for (uint32_t i = 0; i + 1 < count; i += 2)
    {
        qcEightShorts both = qcEightShorts_Load(items + i);
        low = qcEightShorts_Min(low, both);
        high = qcEightShorts_Max(high, both);
    }
    Axis longest = {0, 0, -1};
    for (int k = 0; k < 3; k++)
    {
        int first = low[k] < low[k + 4] ? low[k] : low[k + 4], last = high[k] > high[k + 4] ? high[k] : high[k + 4];
        if (last - first > longest.high - longest.low)
            longest = (Axis){k, first, last};
    }
    return longest;
}

/// The keys below a value; `count` is rounded up to a multiple of qc_countedKeys.
static uint32_t CountBelow(const int16_t* keys, uint32_t count, int value)
{
    qcEightShorts sums[qc_countedKeys / 8] = {{0}};
    const int16_t v = (int16_t)value;
    const qcEightShorts limit = {v, v, v, v, v, v, v, v};
    for (uint32_t i = 0; i < count; i += qc_countedKeys)
        for (size_t k = 0; k < qc_countedKeys / 8; k++)
            sums[k] -= qcEightShorts_Load(keys + i + 8 * k) < limit;
    const qcEightShorts sum = sums[0] + sums[1] + (sums[2] + sums[3]);
    uint64_t halves[2];
    memcpy(halves, &sum, sizeof halves);
    // The sum of four shorts, without a carry between them, to the highest one.
    return (uint32_t)((halves[0] + halves[1]) * UINT64_C(0x0001000100010001) >> 48);
}

/// The value below which `lower` keys are. Where there is none since keys are equal, the first of these become less.
static int FindMedian(int16_t* keys, uint32_t count, const Axis* axis, uint32_t lower)
{
    int low = axis->low, high = axis->high + 1;
    uint32_t below = 0;
    while (below != lower && high - low > 1)
    {
        int middle = (low + high) / 2;
        uint32_t found = CountBelow(keys, count, middle);
        below = found <= lower ? found : below;
        *(found <= lower ? &low : &high) = middle;
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
    for (uint32_t i = 0; i < count; i++)
        keys[i] = range->items[i].at[axis->index];
    for (uint32_t i = count; i % qc_countedKeys != 0; i++)
        keys[i] = INT16_MAX;
    const int median = FindMedian(keys, count, axis, lower);
    // Without branches: each item is written to both places where it may belong.
    Item *front = range->items, *back = range->scratch + count - 1;
    for (uint32_t i = 0; i < count; i++)
    {
        const uint64_t item = range->items[i].all;
        bool isLower = keys[i] < median;
        front->all = back->all = item;
        front += isLower;
        back -= !isLower;
    }
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

void qcSmallOrder_Make(const qcCentroid* centroids, uint32_t count, void* memory, uint32_t* triangles)
{
    Item* items = memory;
    Range range = {items, items + count, centroids, triangles, count};
    for (uint32_t i = 0; i < count; i++)
        items[i].at[3] = (int16_t)i;
    Round(&range);
    Halve(range, qc_nodeSize);
}
