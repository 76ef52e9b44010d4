// Halves the triangles recursively along the longest axis of their centroids (a k-d tree; Bentley 1975). A histogram
// finds the bin of the median; only the triangles of that bin are looked at again.
#include "mesh/cluster_order.h"

#include "mesh/limits.h"
#include "base/four_floats.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

enum
{
    // A vertex with so many triangles is a hub: its triangles get nodes of their own, in which all are neighbours, so
    // that those nodes share one pair mask. Fewer than 16 nodes have few pairs.
    qc_hubValence = 1024,
    // Ranges that are halved in parallel; one with fewer triangles takes less than half a millisecond.
    qc_maxRanges = 8,
    qc_minRange = 4096,
    qc_centroidBlock = 4096,
    qc_minBlocks = 4,
    // A histogram with fewer bins has more triangles in the bin of the median.
    qc_maxBins = 256,
    qc_binItems = 4, ///< items a bin, at least
                     // Insertion takes 20 ns for 8 items.
    qc_maxInserted = 8
};

#define QC_NO_HUB UINT32_MAX

typedef struct Item
{
    float at[3]; ///< of the centroid, 0 .. 1 along the longest axis of the body
    uint32_t triangle;
} Item;

typedef struct Order
{
    const uint32_t* indices;
    const double* positions;
    uint32_t triangleCount, vertexCount;
    double low[3], scale; ///< of centroids
    qcArray items;        ///< of Item
    qcArray scratch;      ///< of Item, as many
    qcArray valences;     ///< uint32_t, by vertex: its triangles
    uint32_t maxValence;
    uint32_t threads;
} Order;

static void Free(Order* o)
{
    qcArray_Free(&o->items);
    qcArray_Free(&o->scratch);
    qcArray_Free(&o->valences);
}

static const uint32_t* Corners(const Order* o, uint32_t triangle)
{
    return o->indices + 3 * (size_t)triangle;
}

//  ---- centroids -----------------------------------------------------------------------------------

static void CountValences(Order* o)
{
    uint32_t* valences = o->valences.data;
    memset(valences, 0, o->vertexCount * sizeof(uint32_t));
    for (size_t i = 0; i < 3 * (size_t)o->triangleCount; i++)
        valences[o->indices[i]]++;
    o->maxValence = 0;
    for (uint32_t v = 0; v < o->vertexCount; v++)
        o->maxValence = valences[v] > o->maxValence ? valences[v] : o->maxValence;
}

/// Sets the origin and the scale of centroids, from the box around all vertices with a triangle.
static void FindScale(Order* o)
{
    const uint32_t* valences = o->valences.data;
    double high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX}, extent = 0.0;
    for (int k = 0; k < 3; k++)
        o->low[k] = DBL_MAX;
    for (uint32_t v = 0; v < o->vertexCount; v++)
        for (size_t k = 0; k < 3 && valences[v] != 0; k++)
        {
            double x = o->positions[3 * (size_t)v + k];
            o->low[k] = x < o->low[k] ? x : o->low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    for (int k = 0; k < 3; k++)
        extent = high[k] - o->low[k] > extent ? high[k] - o->low[k] : extent;
    o->scale = extent > 0.0 ? 1.0 / (3.0 * extent) : 0.0;
}

/// Overflow may make it no number.
static float Clamp(double x)
{
    return x > 0.0 ? (x < 1.0 ? (float)x : 1.0f) : 0.0f;
}

static void FindCentroids(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Order* o = context;
    uint32_t first = (uint32_t)block * qc_centroidBlock, left = o->triangleCount - first;
    Item* items = o->items.data;
    for (uint32_t t = first; t < first + (left < qc_centroidBlock ? left : qc_centroidBlock); t++)
    {
        const uint32_t* c = Corners(o, t);
        const double *p = o->positions + 3 * (size_t)c[0], *q = o->positions + 3 * (size_t)c[1],
                     *r = o->positions + 3 * (size_t)c[2];
        items[t].triangle = t;
        for (int k = 0; k < 3; k++)
            items[t].at[k] = Clamp((p[k] - o->low[k] + (q[k] - o->low[k]) + (r[k] - o->low[k])) * o->scale);
    }
}

//  ---- halving -------------------------------------------------------------------------------------

/// Items that lie side by side, and as much memory.
typedef struct Range
{
    Item *items, *scratch;
    uint32_t count;
} Range;

static void InsertAlong(Item* items, uint32_t count, int axis)
{
    for (uint32_t i = 1; i < count; i++)
    {
        Item item = items[i];
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

static Axis FindAxis(const Item* items, uint32_t count)
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

static void FindBounds(const Item* items, uint32_t count, Axis* axis)
{
    axis->low = axis->high = items[0].at[axis->index];
    for (uint32_t i = 1; i < count; i++)
    {
        float x = items[i].at[axis->index];
        axis->low = x < axis->low ? x : axis->low;
        axis->high = x > axis->high ? x : axis->high;
    }
}

static uint32_t BinOf(const Item* item, const Axis* axis, float scale)
{
    return (uint32_t)(int32_t)((item->at[axis->index] - axis->low) * scale);
}

/// The bin of the item with this rank.
static uint32_t FindBin(const Item* items, uint32_t count, const Axis* axis, float scale, uint32_t binCount,
                        uint32_t rank)
{
    uint32_t counts[2][qc_maxBins];
    for (int i = 0; i < 2; i++)
        memset(counts[i], 0, binCount * sizeof(uint32_t));
    // Two tables: neighbouring items are often in one bin, whose count would be waited for.
    for (uint32_t i = 0; i + 1 < count; i += 2)
    {
        counts[0][BinOf(&items[i], axis, scale)]++;
        counts[1][BinOf(&items[i + 1], axis, scale)]++;
    }
    if (count % 2 != 0)
        counts[0][BinOf(&items[count - 1], axis, scale)]++;
    uint32_t bin = 0, below = 0;
    while (below + counts[0][bin] + counts[1][bin] <= rank)
    {
        below += counts[0][bin] + counts[1][bin];
        bin++;
    }
    return bin;
}

/// Moves the items of lower bins to the front, those of higher bins to the end. Returns the range of the bin's own
/// items. Without branches: each item is written to all places where it may belong.
static Range SplitByBin(const Range* range, const Axis* axis, float scale, uint32_t bin)
{
    const float first = (float)bin, end = (float)(bin + 1);
    Item *lower = range->items, *higher = range->scratch, *last = range->scratch + range->count - 1, *equal = last;
    for (const Item *item = lower, *stop = lower + range->count; item != stop; item++)
    {
        float at = (item->at[axis->index] - axis->low) * scale;
        qcFourFloats copy = qcFourFloats_Load(item);
        qcFourFloats_Store(copy, lower);
        qcFourFloats_Store(copy, higher);
        qcFourFloats_Store(copy, equal);
        lower += at < first;
        higher += at >= end;
        equal -= (at >= first) & (at < end);
    }
    size_t count = (size_t)(last - equal), higherCount = (size_t)(higher - range->scratch);
    memcpy(lower, equal + 1, count * sizeof(Item));
    memcpy(lower + count, range->scratch, higherCount * sizeof(Item));
    return (Range){lower, range->scratch, (uint32_t)count};
}

/// Moves the `lower` items with the lowest values along the axis to the front.
static void Partition(Range range, uint32_t lower, Axis axis)
{
    while (lower != 0 && lower < range.count && range.count > qc_maxInserted && axis.low < axis.high)
    {
        uint32_t binCount = range.count / qc_binItems < qc_maxBins ? range.count / qc_binItems : qc_maxBins;
        // Rounding must not lead behind the last bin.
        float scale = (float)binCount * (1.0f - 0x1p-20f) / (axis.high - axis.low);
        if (!(scale < FLT_MAX))
            break;
        uint32_t bin = FindBin(range.items, range.count, &axis, scale, binCount, lower);
        Range own = SplitByBin(&range, &axis, scale, bin);
        lower -= (uint32_t)(own.items - range.items);
        range = own;
        FindBounds(range.items, range.count, &axis);
    }
    if (range.count <= qc_maxInserted)
        InsertAlong(range.items, range.count, axis.index);
}

/// Splits the items in two halves; returns the count of the first. Cuts lie at multiples of the largest size * 8^k that
/// fits, so that the triangles of eight nodes, and of eight times eight, lie together too.
static uint32_t Cut(const Range* range, uint32_t size)
{
    uint32_t whole = size;
    while (whole < (range->count + 7) / 8)
        whole *= 8;
    uint32_t lower = ((range->count - 1) / whole + 2) / 2 * whole;
    Partition(*range, lower, FindAxis(range->items, range->count));
    return lower;
}

static Range UpperPart(const Range* range, uint32_t lower)
{
    return (Range){range->items + lower, range->scratch + lower, range->count - lower};
}

/// Splits down to groups of `size`; only the last one may have fewer.
static void Halve(Range range, uint32_t size)
{
    while (range.count > size)
    {
        uint32_t lower = Cut(&range, size);
        Halve((Range){range.items, range.scratch, lower}, size);
        range = UpperPart(&range, lower);
    }
}

/// Splits a range into nodes, and each node into clusters.
static void HalveRange(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Range* range = (const Range*)context + i;
    Halve(*range, qc_nodeSize);
    for (uint32_t k = 0; k < range->count; k += qc_nodeSize)
    {
        Range node = UpperPart(range, k);
        node.count = node.count < qc_nodeSize ? node.count : qc_nodeSize;
        Halve(node, qc_clusterSize);
    }
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
    if (range->count < qc_minRange)
        return;
    uint32_t lower = Cut(range, qc_nodeSize);
    cuts->ranges[cuts->count + i] = UpperPart(range, lower);
    range->count = lower;
}

static void HalveAll(const Order* o, Item* items, uint32_t count)
{
    Range ranges[qc_maxRanges] = {{items, o->scratch.data, count}};
    Cuts cuts = {ranges, 1};
    for (; o->threads > 1 && cuts.count < qc_maxRanges; cuts.count *= 2)
        qcParallel_For(o->threads, cuts.count, 2, CutRange, &cuts);
    qcParallel_For(o->threads, cuts.count, 2, HalveRange, ranges);
}

//  ---- hubs ----------------------------------------------------------------------------------------

/// The triangle's vertex with the most triangles if these are very many, or QC_NO_HUB.
static uint32_t HubOf(const Order* o, uint32_t triangle)
{
    const uint32_t* corner = Corners(o, triangle);
    uint32_t hub = QC_NO_HUB, maxValence = qc_hubValence - 1;
    for (int k = 0; k < 3; k++)
    {
        uint32_t valence = QC_AT(uint32_t, o->valences, corner[k]);
        if (valence > maxValence)
        {
            hub = corner[k];
            maxValence = valence;
        }
    }
    return hub;
}

static bool HasHub(const Order* o)
{
    return o->maxValence >= qc_hubValence;
}

/// Sorts by hub, triangles without one last.
static qcStatus SortByHub(Order* o, qcArray* keys, qcArray* scratch)
{
    uint32_t n = o->triangleCount;
    const Item* items = o->items.data;
    QC_TRY(qcArray_Resize(keys, n, sizeof(qcSortItem), "order of triangles"));
    for (uint32_t i = 0; i < n; i++)
        QC_AT(qcSortItem, *keys, i) = (qcSortItem){HubOf(o, items[i].triangle), i};
    QC_TRY(qcSort_Items(keys->data, n, scratch));
    QC_TRY(qcArray_Resize(scratch, n, sizeof(Item), "order of triangles"));
    for (uint32_t i = 0; i < n; i++)
        QC_AT(Item, *scratch, i) = items[QC_AT(qcSortItem, *keys, i).value];
    memcpy(o->items.data, scratch->data, n * sizeof(Item));
    return qc_statusOk;
}

//  ---- order ---------------------------------------------------------------------------------------

static qcStatus Reserve(Order* o)
{
    QC_TRY(qcArray_Resize(&o->items, o->triangleCount, sizeof(Item), "order of triangles"));
    QC_TRY(qcArray_Resize(&o->scratch, o->triangleCount, sizeof(Item), "order of triangles"));
    return qcArray_Resize(&o->valences, o->vertexCount, sizeof(uint32_t), "order of triangles");
}

/// Appends the nodes of a group of items.
static qcStatus AddNodes(Order* o, Item* items, uint32_t count, qcArray* slots)
{
    HalveAll(o, items, count);
    size_t first = slots->count, nodes = ((size_t)count + qc_nodeSize - 1) / qc_nodeSize;
    QC_TRY(qcArray_Resize(slots, first + nodes * qc_nodeSize, sizeof(uint32_t), "order of triangles"));
    for (uint32_t i = 0; i < nodes * qc_nodeSize; i++)
        QC_AT(uint32_t, *slots, first + i) = i < count ? items[i].triangle : QC_NO_TRIANGLE;
    return qc_statusOk;
}

static qcStatus Make(Order* o, qcArray* slots)
{
    QC_TRY(Reserve(o));
    CountValences(o);
    FindScale(o);
    size_t blocks = ((size_t)o->triangleCount + qc_centroidBlock - 1) / qc_centroidBlock;
    qcParallel_For(o->threads, blocks, qc_minBlocks, FindCentroids, o);
    bool hasHub = HasHub(o);
    if (hasHub)
    {
        qcArray keys = {0}, scratch = {0};
        qcStatus status = SortByHub(o, &keys, &scratch);
        qcArray_Free(&keys);
        qcArray_Free(&scratch);
        QC_TRY(status);
    }
    Item* items = o->items.data;
    for (uint32_t begin = 0, end; begin < o->triangleCount; begin = end)
    {
        end = hasHub ? begin + 1 : o->triangleCount;
        while (end < o->triangleCount && HubOf(o, items[end].triangle) == HubOf(o, items[begin].triangle))
            end++;
        QC_TRY(AddNodes(o, items + begin, end - begin, slots));
    }
    return qc_statusOk;
}

qcStatus qcClusterOrder_Make(qcArray* slots, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                             uint32_t vertexCount, uint32_t threads, bool* hasHub)
{
    if (triangleCount > UINT32_MAX / 3)
        return qcFailMemory(SIZE_MAX, "order of more than 2^32 / 3 triangles");
    slots->count = 0;
    *hasHub = false;
    if (triangleCount == 0)
        return qc_statusOk;
    Order order = {.indices = indices,
                   .positions = positions,
                   .triangleCount = triangleCount,
                   .vertexCount = vertexCount,
                   .threads = threads};
    qcStatus status = Make(&order, slots);
    *hasHub = HasHub(&order);
    Free(&order);
    return status;
}
