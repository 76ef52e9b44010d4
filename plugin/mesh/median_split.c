// Halves centroids recursively along the longest axis (a k-d tree; Bentley 1975). A histogram of a sample bounds the
// median; only the items within these bounds are visited again.
#include "mesh/median_split.h"

#include "base/four_floats.h"
#include "base/parallel_for.h"
#include "mesh/limits.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum
{
    // Ranges that are halved in parallel.
    qc_maxRanges = 8,
    // The sample of a range has one of so many items, or fewer.
    qc_minStride = 16,
    qc_maxSample = 4096,
    // A histogram with fewer bins has more triangles in the bin of the median.
    qc_maxBins = 256,
    qc_binItems = 4,   ///< items a bin, at least
    qc_maxInserted = 8 ///< insertion takes 20 ns for so many
};

/// Items that lie side by side, and as much memory.
typedef struct Range
{
    qcCentroid *items, *scratch;
    uint32_t* triangles; ///< the result
    uint32_t count;
} Range;

static void InsertAlong(qcCentroid* items, uint32_t count, int axis)
{
    for (uint32_t i = 1; i < count; i++)
    {
        qcCentroid item = items[i];
        uint32_t at = i;
        for (; at > 0 && items[at - 1].at[axis] > item.at[axis]; at--)
            items[at] = items[at - 1];
        items[at] = item;
    }
}

/// The longest axis of the items, and its bounds.
typedef struct Axis
{
    int index;
    float low, high;
} Axis;

static Axis FindAxis(const qcCentroid* items, uint32_t count)
{
    // Two sets, so that no comparison waits for the last one. The lane of the triangle is not used.
    qcFourFloats low[2], high[2];
    low[0] = low[1] = high[0] = high[1] = qcFourFloats_Load(&items[count - 1]);
    for (uint32_t i = 0; i + 1 < count; i += 2)
        for (int set = 0; set < 2; set++)
        {
            qcFourFloats item = qcFourFloats_Load(&items[i + (uint32_t)set]);
            low[set] = qcFourFloats_Min(item, low[set]);
            high[set] = qcFourFloats_Max(item, high[set]);
        }
    low[0] = qcFourFloats_Min(low[0], low[1]);
    high[0] = qcFourFloats_Max(high[0], high[1]);
    qcFourFloats extent = high[0] - low[0];
    int longest = 0;
    for (int k = 1; k < 3; k++)
        if (extent[k] > extent[longest])
            longest = k;
    return (Axis){longest, low[0][longest], high[0][longest]};
}

static void FindBounds(const qcCentroid* items, uint32_t count, Axis* axis)
{
    axis->low = axis->high = items[0].at[axis->index];
    for (uint32_t i = 1; i < count; i++)
    {
        float x = items[i].at[axis->index];
        axis->low = x < axis->low ? x : axis->low;
        axis->high = x > axis->high ? x : axis->high;
    }
}

/// Counts the items in equal parts of the axis.
static void CountBins(const qcCentroid* items, uint32_t count, const Axis* axis, float scale, uint32_t binCount,
                      uint32_t* counts)
{
    uint32_t others[qc_maxBins];
    // Two tables: neighbouring items are often in one bin, whose count would be waited for.
    uint32_t* tables[2] = {counts, others};
    for (int i = 0; i < 2; i++)
        memset(tables[i], 0, binCount * sizeof(uint32_t));
    for (uint32_t i = 0; i < count; i++)
        tables[i % 2][(uint32_t)(int32_t)((items[i].at[axis->index] - axis->low) * scale)]++;
    for (uint32_t bin = 0; bin < binCount; bin++)
        counts[bin] += others[bin];
}

/// Values along an axis: from `low` to below `high`.
typedef struct Band
{
    int axis;
    float low, high;
} Band;

/// The bins of the items with ranks within `reach` of this one. The items are not all equal.
static Band FindBand(const qcCentroid* items, uint32_t count, const Axis* axis, uint32_t rank, uint32_t reach)
{
    Band band = {axis->index, 0.0f, FLT_MAX};
    uint32_t counts[qc_maxBins];
    uint32_t binCount = count / qc_binItems < qc_maxBins ? count / qc_binItems : qc_maxBins;
    // Rounding must not lead behind the last bin.
    float scale = (float)binCount * (1.0f - 0x1p-20f) / (axis->high - axis->low);
    if (!(scale < FLT_MAX))
        return band;
    CountBins(items, count, axis, scale, binCount, counts);
    uint32_t bin = 0, below = 0;
    for (; bin < binCount && below + counts[bin] + reach <= rank; bin++)
        below += counts[bin];
    if (bin != 0)
        band.low = axis->low + (float)bin / scale;
    for (; bin < binCount && below <= rank + reach; bin++)
        below += counts[bin];
    if (bin != binCount)
        band.high = axis->low + (float)bin / scale;
    return band;
}

/// Floats from 0 on are in the order of their bits, which are compared in less time.
static uint32_t Bits(const float* at)
{
    uint32_t bits;
    memcpy(&bits, at, sizeof bits);
    return bits;
}

/// Moves the items below the band to the front, those above it to the end. Returns the range of these three in which
/// the item of this rank lies. Without branches: each item is written to all places where it may belong.
static Range SplitByBand(const Range* range, const Band* band, uint32_t rank)
{
    const uint32_t first = Bits(&band->low), end = Bits(&band->high);
    const int axis = band->axis;
    qcCentroid *lower = range->items, *higher = range->scratch, *last = higher + range->count - 1, *within = last;
    for (const qcCentroid *item = lower, *stop = lower + range->count; item != stop; item++)
    {
        uint32_t at = Bits(&item->at[axis]);
        qcFourFloats copy = qcFourFloats_Load(item);
        qcFourFloats_Store(copy, lower);
        qcFourFloats_Store(copy, higher);
        qcFourFloats_Store(copy, within);
        lower += at < first;
        higher += at >= end;
        within -= at - first < end - first;
    }
    uint32_t count = (uint32_t)(last - within), higherCount = (uint32_t)(higher - range->scratch),
             lowerCount = range->count - count - higherCount;
    memcpy(lower, within + 1, count * sizeof(qcCentroid));
    memcpy(lower + count, range->scratch, higherCount * sizeof(qcCentroid));
    Range part = {range->items, range->scratch, NULL, lowerCount};
    if (rank >= lowerCount)
        part = (Range){lower, range->scratch, NULL, count};
    if (rank >= lowerCount + count)
        part = (Range){lower + count, range->scratch, NULL, higherCount};
    return part;
}

/// Moves the `lower` items with the lowest values along the axis to the front.
static void Partition(Range range, uint32_t lower, int index)
{
    while (lower != 0 && lower < range.count && range.count > qc_maxInserted)
    {
        Axis axis = {.index = index};
        FindBounds(range.items, range.count, &axis);
        if (!(axis.low < axis.high))
            return;
        const Band band = FindBand(range.items, range.count, &axis, lower, 0);
        Range part = SplitByBand(&range, &band, lower);
        // They are equal, but for the last bit.
        if (part.count == range.count)
            return;
        lower -= (uint32_t)(part.items - range.items);
        range = part;
    }
    if (range.count <= qc_maxInserted)
        InsertAlong(range.items, range.count, index);
}

/// Copies a sample of the items to the scratch: one of each stride, at random, since meshes repeat themselves.
static uint32_t TakeSample(const Range* range)
{
    uint32_t stride = range->count / qc_maxSample, random = 1;
    stride = stride > qc_minStride ? stride : qc_minStride;
    uint32_t count = range->count / stride;
    for (uint32_t i = 0; i < count; i++)
    {
        random = random * 1664525 + 1013904223; // Numerical Recipes' generator; its highest bits are the best
        range->scratch[i] = range->items[i * stride + (random >> 16) % stride];
    }
    return count;
}

/// Moves the `lower` items with the lowest values along the longest axis of a sample to the front.
static void Cut(const Range* range, uint32_t lower)
{
    Range part = *range;
    uint32_t count = TakeSample(range), rank = (uint32_t)((uint64_t)lower * count / range->count);
    Axis axis = FindAxis(range->scratch, count);
    if (axis.low < axis.high)
    {
        // Three standard deviations. Where the item lies outside, more items are visited again.
        uint32_t reach = (uint32_t)(1.5f * sqrtf((float)count));
        const Band band = FindBand(range->scratch, count, &axis, rank, reach);
        part = SplitByBand(range, &band, lower);
    }
    Partition(part, lower - (uint32_t)(part.items - range->items), axis.index);
}

static Range UpperPart(const Range* range, uint32_t lower)
{
    return (Range){range->items + lower, range->scratch + lower, range->triangles + lower, range->count - lower};
}

/// Lists the triangles of a range by nodes and clusters.
static void Halve(Range range)
{
    while (range.count > qc_maxSmallOrder)
    {
        uint32_t lower = qcSmallOrder_CutAt(range.count, qc_nodeSize);
        Cut(&range, lower);
        Halve((Range){range.items, range.scratch, range.triangles, lower});
        range = UpperPart(&range, lower);
    }
    if (range.count != 0)
        qcOrderKernels_Get()->makeSmallOrder(range.items, range.count, range.scratch, range.triangles);
}

static void HalveRange(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    Halve(((const Range*)context)[i]);
}

/// The ranges of a level, and where the upper parts go.
typedef struct Cuts
{
    Range* ranges;
    size_t count;
} Cuts;

static void CutRange(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Cuts* cuts = context;
    Range* range = &cuts->ranges[i];
    cuts->ranges[cuts->count + i] = UpperPart(range, range->count);
    if (range->count <= qc_maxSmallOrder)
        return;
    uint32_t lower = qcSmallOrder_CutAt(range->count, qc_nodeSize);
    Cut(range, lower);
    cuts->ranges[cuts->count + i] = UpperPart(range, lower);
    range->count = lower;
}

void qcMedianSplit_Run(qcCentroid* items, qcCentroid* scratch, uint32_t count, uint32_t threads, uint32_t* triangles)
{
    Range ranges[qc_maxRanges] = {{items, scratch, triangles, count}};
    Cuts cuts = {ranges, 1};
    for (; threads > 1 && cuts.count < qc_maxRanges; cuts.count *= 2)
        qcParallel_For(threads, cuts.count, 2, CutRange, &cuts);
    qcParallel_For(threads, cuts.count, 2, HalveRange, ranges);
}
