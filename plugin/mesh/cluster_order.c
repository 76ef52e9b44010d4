// Halves the triangles recursively along the longest axis of their centroids (a k-d tree; Bentley 1975). A histogram of
// a sample bounds the median; only the triangles within these bounds are looked at again.
#include "mesh/cluster_order.h"

#include "mesh/limits.h"
#include "mesh/small_order.h"
#include "mesh/triangle_sample.h"
#include "base/four_floats.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

enum
{
    // A vertex with so many triangles is a hub: its triangles get nodes of their own, in which all are neighbours, so
    // that those nodes share one pair mask. Fewer than 16 nodes have few pairs.
    qc_hubValence = 1024,
    // Ranges that are halved in parallel.
    qc_maxRanges = 8,
    // If fewer than one in so many triangles is outside the region, none is left out. (First step of 27 bunnies: 7.3 ms
    // with 4, 6.5 ms with 8.)
    qc_leftOutShare = 8,
    // Triangles, or vertices.
    qc_centroidBlock = 4096,
    qc_minBlocks = 4,
    // The sample of a range has one of so many items, or fewer.
    qc_minStride = 16,
    qc_maxSample = 4096,
    // A histogram with fewer bins has more triangles in the bin of the median.
    qc_maxBins = 256,
    qc_binItems = 4, ///< items a bin, at least
                     // Insertion takes 20 ns for 8 items.
    qc_maxInserted = 8
};

#define QC_NO_HUB UINT32_MAX

typedef struct Order
{
    const uint32_t* indices;
    const double* positions;
    uint32_t triangleCount, vertexCount;
    double low[3], scale; ///< of centroids
    qcArray items;        ///< of qcCentroid
    qcArray scratch;      ///< of qcCentroid, as many, or of qcFourFloats by vertex
    qcArray valences;     ///< uint32_t, by vertex: its triangles
    uint32_t maxValence;
    const qcOrderOptions* options;
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

/// Sets the origin and the scale of centroids, from the box around all vertices with a triangle, or most of them: with
/// outliers the centroids of all others would have few different values.
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
    qcTriangleSample sample;
    qcTriangleSample_Take(&sample, o->indices, o->triangleCount, o->positions);
    (void)qcTriangleSample_Trim(&sample, o->low, high);
    for (int k = 0; k < 3; k++)
        extent = high[k] - o->low[k] > extent ? high[k] - o->low[k] : extent;
    o->scale = extent > 0.0 ? 1.0 / (3.0 * extent) : 0.0;
}

/// Overflow may make it no number.
static qcFourFloats Clamp(qcFourFloats at)
{
    const qcFourFloats zero = {0.0f, 0.0f, 0.0f, 0.0f}, one = {1.0f, 1.0f, 1.0f, 1.0f};
    return qcFourFloats_Min(qcFourFloats_Max(at, zero), one);
}

/// A third of each vertex's position, into the scratch.
static void ScaleVertices(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Order* o = context;
    uint32_t first = (uint32_t)block * qc_centroidBlock, left = o->vertexCount - first;
    qcFourFloats* thirds = o->scratch.data;
    for (uint32_t v = first; v < first + (left < qc_centroidBlock ? left : qc_centroidBlock); v++)
    {
        const double* p = o->positions + 3 * (size_t)v;
        thirds[v] = (qcFourFloats){(float)((p[0] - o->low[0]) * o->scale), (float)((p[1] - o->low[1]) * o->scale),
                                   (float)((p[2] - o->low[2]) * o->scale), 0.0f};
    }
}

static void FindCentroids(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Order* o = context;
    uint32_t first = (uint32_t)block * qc_centroidBlock, left = o->triangleCount - first;
    const qcFourFloats* thirds = o->scratch.data;
    qcCentroid* items = o->items.data;
    for (uint32_t t = first; t < first + (left < qc_centroidBlock ? left : qc_centroidBlock); t++)
    {
        const uint32_t* c = Corners(o, t);
        qcFourFloats_Store(Clamp(thirds[c[0]] + thirds[c[1]] + thirds[c[2]]), &items[t]);
        items[t].triangle = t;
    }
}

/// Lists the triangles that meet the region, at least one. Returns their number.
static uint32_t FindInRegion(const Order* o)
{
    const qcFourFloats* thirds = o->scratch.data;
    qcCentroid* items = o->items.data;
    uint32_t count = 0;
    for (uint32_t t = 0; t < o->triangleCount; t++)
    {
        const uint32_t* c = Corners(o, t);
        qcFourFloats p = thirds[c[0]], q = thirds[c[1]], r = thirds[c[2]];
        qcFourFloats_Store(Clamp(p + q + r), &items[count]);
        items[count].triangle = t;
        count +=
            qcRegionCells_Meet(o->options->region, qcFourFloats_Min(qcFourFloats_Min(p, q), r) * (3.0f * qc_cellsAlong),
                               qcFourFloats_Max(qcFourFloats_Max(p, q), r) * (3.0f * qc_cellsAlong));
    }
    return count != 0 ? count : 1;
}

//  ---- halving -------------------------------------------------------------------------------------

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
        // Three standard deviations. Where the item lies outside, more items are looked at again.
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

static void HalveAll(const Order* o, qcCentroid* items, uint32_t count, uint32_t* triangles)
{
    Range ranges[qc_maxRanges] = {{items, o->scratch.data, triangles, count}};
    Cuts cuts = {ranges, 1};
    for (; o->options->threads > 1 && cuts.count < qc_maxRanges; cuts.count *= 2)
        qcParallel_For(o->options->threads, cuts.count, 2, CutRange, &cuts);
    qcParallel_For(o->options->threads, cuts.count, 2, HalveRange, ranges);
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
    const qcCentroid* items = o->items.data;
    QC_TRY(qcArray_Resize(keys, n, sizeof(qcSortItem), "order of triangles"));
    for (uint32_t i = 0; i < n; i++)
        QC_AT(qcSortItem, *keys, i) = (qcSortItem){HubOf(o, items[i].triangle), i};
    QC_TRY(qcSort_Items(keys->data, n, scratch));
    QC_TRY(qcArray_Resize(scratch, n, sizeof(qcCentroid), "order of triangles"));
    for (uint32_t i = 0; i < n; i++)
        QC_AT(qcCentroid, *scratch, i) = items[QC_AT(qcSortItem, *keys, i).value];
    memcpy(o->items.data, scratch->data, n * sizeof(qcCentroid));
    return qc_statusOk;
}

//  ---- order ---------------------------------------------------------------------------------------

static qcStatus Reserve(Order* o)
{
    QC_TRY(qcArray_Resize(&o->items, o->triangleCount, sizeof(qcCentroid), "order of triangles"));
    uint32_t count = o->triangleCount > o->vertexCount ? o->triangleCount : o->vertexCount;
    QC_TRY(qcArray_Resize(&o->scratch, count, sizeof(qcCentroid), "order of triangles"));
    return qcArray_Resize(&o->valences, o->vertexCount, sizeof(uint32_t), "order of triangles");
}

/// Appends the nodes of a group of items.
static qcStatus AddNodes(Order* o, qcCentroid* items, uint32_t count, qcArray* slots)
{
    size_t first = slots->count, nodes = ((size_t)count + qc_nodeSize - 1) / qc_nodeSize;
    QC_TRY(qcArray_Resize(slots, first + nodes * qc_nodeSize, sizeof(uint32_t), "order of triangles"));
    HalveAll(o, items, count, &QC_AT(uint32_t, *slots, first));
    for (size_t i = first + count; i < slots->count; i++)
        QC_AT(uint32_t, *slots, i) = QC_NO_TRIANGLE;
    return qc_statusOk;
}

static size_t BlockCount(uint32_t count)
{
    return ((size_t)count + qc_centroidBlock - 1) / qc_centroidBlock;
}

/// Takes the scale from the box of the region.
static void UseRegionScale(Order* o)
{
    memcpy(o->low, o->options->region->lower, sizeof o->low);
    o->scale = o->options->region->scale / (3.0 * qc_cellsAlong);
}

static void ScaleAllVertices(Order* o)
{
    qcParallel_For(o->options->threads, BlockCount(o->vertexCount), qc_minBlocks, ScaleVertices, o);
}

/// Lists all triangles.
static void FindAllCentroids(Order* o)
{
    ScaleAllVertices(o);
    qcParallel_For(o->options->threads, BlockCount(o->triangleCount), qc_minBlocks, FindCentroids, o);
}

/// The nodes of the triangles in the region, unless nearly all are there: then none are added.
static qcStatus AddRegion(Order* o, qcArray* slots)
{
    UseRegionScale(o);
    ScaleAllVertices(o);
    uint32_t count = FindInRegion(o);
    return count < o->triangleCount - o->triangleCount / qc_leftOutShare ? AddNodes(o, o->items.data, count, slots)
                                                                         : qc_statusOk;
}

/// The nodes of the triangles whose flags are not set.
static qcStatus AddRest(Order* o, const uint8_t* present, qcArray* slots)
{
    qcCentroid* items = o->items.data;
    uint32_t count = 0;
    UseRegionScale(o);
    FindAllCentroids(o);
    for (uint32_t t = 0; t < o->triangleCount; t++)
    {
        items[count] = items[t];
        count += !present[t];
    }
    return AddNodes(o, items, count, slots);
}

static qcStatus AddAll(Order* o, qcArray* slots)
{
    CountValences(o);
    FindScale(o);
    FindAllCentroids(o);
    bool hasHub = HasHub(o);
    if (hasHub)
    {
        qcArray keys = {0}, scratch = {0};
        qcStatus status = SortByHub(o, &keys, &scratch);
        qcArray_Free(&keys);
        qcArray_Free(&scratch);
        QC_TRY(status);
    }
    qcCentroid* items = o->items.data;
    for (uint32_t begin = 0, end; begin < o->triangleCount; begin = end)
    {
        end = hasHub ? begin + 1 : o->triangleCount;
        while (end < o->triangleCount && HubOf(o, items[end].triangle) == HubOf(o, items[begin].triangle))
            end++;
        QC_TRY(AddNodes(o, items + begin, end - begin, slots));
    }
    return qc_statusOk;
}

static qcStatus Make(Order* o, qcArray* slots, qcOrderSummary* summary)
{
    QC_TRY(Reserve(o));
    if (o->options->region != NULL)
        QC_TRY(AddRegion(o, slots));
    summary->isLimited = slots->count != 0;
    if (summary->isLimited)
        return qc_statusOk;
    QC_TRY(AddAll(o, slots));
    summary->hasHub = HasHub(o);
    return qc_statusOk;
}

qcStatus qcClusterOrder_Make(qcArray* slots, const uint32_t* indices, uint32_t triangleCount, const double* positions,
                             uint32_t vertexCount, const qcOrderOptions* options, qcOrderSummary* summary)
{
    if (triangleCount > UINT32_MAX / 3)
        return qcFailMemory(SIZE_MAX, "order of more than 2^32 / 3 triangles");
    slots->count = 0;
    *summary = (qcOrderSummary){.hasHub = false};
    if (triangleCount == 0)
        return qc_statusOk;
    Order order = {.indices = indices,
                   .positions = positions,
                   .triangleCount = triangleCount,
                   .vertexCount = vertexCount,
                   .options = options};
    qcStatus status = Make(&order, slots, summary);
    Free(&order);
    return status;
}

static qcStatus Complete(Order* o, qcArray* present, qcArray* slots)
{
    QC_TRY(Reserve(o));
    QC_TRY(qcArray_GrowZeroed(present, o->triangleCount, 1, "order of triangles"));
    for (size_t i = 0; i < slots->count; i++)
        if (QC_AT(uint32_t, *slots, i) != QC_NO_TRIANGLE)
            QC_AT(uint8_t, *present, QC_AT(uint32_t, *slots, i)) = 1;
    return AddRest(o, present->data, slots);
}

qcStatus qcClusterOrder_Complete(qcArray* slots, const uint32_t* indices, uint32_t triangleCount,
                                 const double* positions, uint32_t vertexCount, const qcOrderOptions* options)
{
    qcArray present = {0};
    Order order = {.indices = indices,
                   .positions = positions,
                   .triangleCount = triangleCount,
                   .vertexCount = vertexCount,
                   .options = options};
    qcStatus status = Complete(&order, &present, slots);
    qcArray_Free(&present);
    Free(&order);
    return status;
}
