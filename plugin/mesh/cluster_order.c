// Halves the triangles recursively along their longest axis (a k-d tree; Bentley 1975). Three axes are those of space,
// two are distances along the mesh, in edges from two far vertices: they separate layers of cloth that touch now and
// may part later.
#include "mesh/cluster_order.h"

#include "mesh/limits.h"
#include "mesh/vertex_triangles.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/scalar.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_walks = 4,        ///< of each component: two find far vertices, two give the axes
    qc_fewVertices = 64, ///< of a component that fits into a node: no hops needed
    qc_axes = 5,         ///< three of space, two of hops
    // A vertex with so many triangles is a hub: its triangles get nodes of their own, in which all are neighbours, so
    // that those nodes share one pair mask. Fewer than 16 nodes have few pairs.
    qc_hubValence = 1024,
    // Ranges that are halved in parallel; one with fewer triangles takes less than half a millisecond.
    qc_maxRanges = 8,
    qc_minRange = 4096
};

#define QC_NO_HUB UINT32_MAX
#define QC_NOT_REACHED UINT32_MAX

/// Length of a hop, in mean triangle lengths. Less than a half: on a flat grid of squares, where hops along x and y add
/// up, the hop axes stay shorter than those of space, so that flat patches are halved in space alone. 0.25 leaves
/// layers of a folded cloth together in twice as many nodes; 0.9 makes a bunny's nodes 12 % longer.
static const float s_hop = 0.4f;

typedef struct Item
{
    float at[qc_axes]; ///< of the centroid: space, the longest axis 0 .. 1; hops as long as s_hop mean triangles
    uint32_t triangle;
} Item;

/// Edges between a vertex and the start of each walk.
typedef struct Hops
{
    uint32_t from[qc_walks];
} Hops;

typedef struct Order
{
    const uint32_t* indices;
    uint32_t triangleCount, vertexCount;
    qcArray items; ///< of Item
    qcVertexTriangles around;
    qcArray hops;  ///< of Hops, by vertex
    qcArray queue; ///< uint32_t: vertices of one component, in the order in which a walk reached them
    uint32_t threads;
} Order;

static void Free(Order* o)
{
    qcArray_Free(&o->items);
    qcVertexTriangles_Free(&o->around);
    qcArray_Free(&o->hops);
    qcArray_Free(&o->queue);
}

static const uint32_t* Corners(const Order* o, uint32_t triangle)
{
    return o->indices + 3 * (size_t)triangle;
}

//  ---- axes ----------------------------------------------------------------------------------------

/// An eighth of the bounds: no sum of three and no difference of finite numbers overflows.
static void Bounds(const Order* o, const double* positions, uint32_t triangle, double low[3], double high[3])
{
    const uint32_t* corner = Corners(o, triangle);
    for (int k = 0; k < 3; k++)
    {
        double a = positions[3 * (size_t)corner[0] + k] / 8, b = positions[3 * (size_t)corner[1] + k] / 8,
               c = positions[3 * (size_t)corner[2] + k] / 8;
        low[k] = qcMin(a, qcMin(b, c));
        high[k] = qcMax(a, qcMax(b, c));
    }
}

/// Sets the axes of space. Returns the mean length of a triangle in them.
static float SetSpace(Order* o, const double* positions)
{
    double low[3], high[3], a[3], b[3];
    Bounds(o, positions, 0, low, high);
    for (uint32_t t = 1; t < o->triangleCount; t++)
    {
        Bounds(o, positions, t, a, b);
        for (int k = 0; k < 3; k++)
        {
            low[k] = qcMin(low[k], a[k]);
            high[k] = qcMax(high[k], b[k]);
        }
    }
    double extent = qcMax(qcMax(high[0] - low[0], high[1] - low[1]), high[2] - low[2]), length = 0;
    for (uint32_t t = 0; t < o->triangleCount; t++)
    {
        Item* item = &QC_AT(Item, o->items, t);
        item->triangle = t;
        Bounds(o, positions, t, a, b);
        double longest = 0;
        const uint32_t* c = Corners(o, t);
        for (int k = 0; k < 3; k++)
        {
            double centre = positions[3 * (size_t)c[0] + k] / 24 + positions[3 * (size_t)c[1] + k] / 24 +
                            positions[3 * (size_t)c[2] + k] / 24;
            item->at[k] = extent > 0 ? (float)((centre - low[k]) / extent) : 0.0f;
            longest = qcMax(longest, b[k] - a[k]);
        }
        length += extent > 0 ? longest / extent : 0;
    }
    return (float)(length / o->triangleCount);
}

/// Breadth first. Returns the number of vertices reached; the queue lists them.
static uint32_t Walk(Order* o, uint32_t source, int walk)
{
    uint32_t *queue = o->queue.data, count = 1;
    const uint32_t *first = o->around.first.data, *around = o->around.triangles.data;
    Hops* hops = o->hops.data;
    queue[0] = source;
    hops[source].from[walk] = 0;
    for (uint32_t at = 0; at < count; at++)
    {
        uint32_t v = queue[at], next = hops[v].from[walk] + 1;
        for (uint32_t i = first[v]; i < first[v + 1]; i++)
        {
            const uint32_t* corner = Corners(o, around[i]);
            for (int k = 0; k < 3; k++)
                if (hops[corner[k]].from[walk] == QC_NOT_REACHED)
                {
                    hops[corner[k]].from[walk] = next;
                    queue[count++] = corner[k];
                }
        }
    }
    return count;
}

static uint32_t MinCount(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/// Walks from one end of each component, and from a vertex far from both its ends.
static void WalkComponents(Order* o)
{
    const uint32_t* queue = o->queue.data;
    Hops* hops = o->hops.data;
    memset(o->hops.data, 0xff, o->vertexCount * sizeof(Hops));
    for (uint32_t v = 0; v < o->vertexCount; v++)
    {
        if (hops[v].from[0] != QC_NOT_REACHED || qcVertexTriangles_Count(&o->around, v) == 0)
            continue;
        uint32_t count = Walk(o, v, 0);
        if (count <= qc_fewVertices)
        {
            for (uint32_t i = 0; i < count; i++)
                hops[queue[i]] = (Hops){{0}};
            continue;
        }
        Walk(o, queue[count - 1], 1);
        Walk(o, queue[count - 1], 2);
        uint32_t side = queue[0];
        for (uint32_t i = 1; i < count; i++)
        {
            const uint32_t *far = hops[queue[i]].from, *best = hops[side].from;
            if (MinCount(far[1], far[2]) > MinCount(best[1], best[2]))
                side = queue[i];
        }
        Walk(o, side, 3);
    }
}

static void SetHops(Order* o, float length)
{
    // If all triangles are points, only hops distinguish them.
    float hop = length > 0 ? s_hop * length / 3 : 1.0f;
    const Hops* hops = o->hops.data;
    for (uint32_t t = 0; t < o->triangleCount; t++)
    {
        const uint32_t* c = Corners(o, t);
        const uint32_t *a = hops[c[0]].from, *b = hops[c[1]].from, *d = hops[c[2]].from;
        float* at = QC_AT(Item, o->items, t).at;
        at[3] = hop * (float)((uint64_t)a[1] + b[1] + d[1]);
        at[4] = hop * (float)((uint64_t)a[3] + b[3] + d[3]);
    }
}

//  ---- halving -------------------------------------------------------------------------------------

static void Swap(Item* a, Item* b)
{
    Item item = *a;
    *a = *b;
    *b = item;
}

static float MedianOfThree(float a, float b, float c)
{
    float low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

static uint32_t RandomBelow(uint32_t* random, uint32_t bound)
{
    *random = *random * 1664525u + 1013904223u; // Numerical Recipes
    return (uint32_t)((uint64_t)*random * bound >> 32);
}

static void SortAlong(Item* items, uint32_t count, int axis)
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

/// Moves the `lower` items with the lowest values along an axis to the front (Hoare's Find). Random pivots: no input
/// order is a bad case.
static void Partition(Item* items, uint32_t count, uint32_t lower, int axis)
{
    uint32_t random = count;
    ptrdiff_t begin = 0, end = count, rank = lower;
    while (end - begin > 16)
    {
        uint32_t size = (uint32_t)(end - begin);
        const Item* some = items + begin;
        float pivot =
            MedianOfThree(some[RandomBelow(&random, size)].at[axis], some[RandomBelow(&random, size)].at[axis],
                          some[RandomBelow(&random, size)].at[axis]);
        ptrdiff_t i = begin, j = end - 1;
        while (i <= j)
        {
            while (items[i].at[axis] < pivot)
                i++;
            while (items[j].at[axis] > pivot)
                j--;
            if (i <= j)
                Swap(&items[i++], &items[j--]);
        }
        // Items up to j are at most the pivot, those from i on at least; those between are equal to it.
        if (rank <= j)
            end = j + 1;
        else if (rank >= i)
            begin = i;
        else
            return;
    }
    SortAlong(items + begin, (uint32_t)(end - begin), axis);
}

static int LongestAxis(const Item* items, uint32_t count)
{
    Item low = items[0], high = items[0];
    for (uint32_t i = 1; i < count; i++)
        for (int k = 0; k < qc_axes; k++)
        {
            float x = items[i].at[k];
            low.at[k] = x < low.at[k] ? x : low.at[k];
            high.at[k] = x > high.at[k] ? x : high.at[k];
        }
    int longest = 0;
    for (int k = 1; k < qc_axes; k++)
        if (high.at[k] - low.at[k] > high.at[longest] - low.at[longest])
            longest = k;
    return longest;
}

/// Splits the items in two halves; returns the count of the first. Cuts lie at multiples of the largest size * 8^k that
/// fits, so that the triangles of eight nodes, and of eight times eight, lie together too.
static uint32_t Cut(Item* items, uint32_t count, uint32_t size)
{
    uint32_t whole = size;
    while (whole < (count + 7) / 8)
        whole *= 8;
    uint32_t lower = ((count - 1) / whole + 2) / 2 * whole;
    Partition(items, count, lower, LongestAxis(items, count));
    return lower;
}

/// Splits down to groups of `size`; only the last one may have fewer.
static void Halve(Item* items, uint32_t count, uint32_t size)
{
    if (count <= size)
        return;
    uint32_t lower = Cut(items, count, size);
    Halve(items, lower, size);
    Halve(items + lower, count - lower, size);
}

typedef struct Range
{
    Item* items;
    uint32_t count;
} Range;

/// Splits a range into nodes, and each node into clusters.
static void HalveRange(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Range* range = (const Range*)context + i;
    Halve(range->items, range->count, qc_nodeSize);
    for (uint32_t k = 0; k < range->count; k += qc_nodeSize)
        Halve(range->items + k, range->count - k < qc_nodeSize ? range->count - k : qc_nodeSize, qc_clusterSize);
}

/// Splits a few times on this thread, then in parallel.
static void HalveAll(const Order* o, Item* items, uint32_t count)
{
    Range ranges[qc_maxRanges] = {{items, count}};
    size_t rangeCount = 1;
    for (bool cut = true; cut && 2 * rangeCount <= qc_maxRanges;)
    {
        cut = false;
        for (size_t i = rangeCount; i-- > 0;)
        {
            Range all = ranges[i];
            if (all.count < qc_minRange)
                continue;
            uint32_t lower = Cut(all.items, all.count, qc_nodeSize);
            ranges[i].count = lower;
            ranges[rangeCount++] = (Range){all.items + lower, all.count - lower};
            cut = true;
        }
    }
    qcParallel_For(o->threads, rangeCount, 2, HalveRange, ranges);
}

//  ---- hubs ----------------------------------------------------------------------------------------

/// The triangle's vertex with the most triangles if these are very many, or QC_NO_HUB.
static uint32_t HubOf(const Order* o, uint32_t triangle)
{
    const uint32_t* corner = Corners(o, triangle);
    uint32_t hub = QC_NO_HUB, maxValence = qc_hubValence - 1;
    for (int k = 0; k < 3; k++)
    {
        uint32_t valence = qcVertexTriangles_Count(&o->around, corner[k]);
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
    for (uint32_t v = 0; v < o->vertexCount; v++)
        if (qcVertexTriangles_Count(&o->around, v) >= qc_hubValence)
            return true;
    return false;
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
    size_t n = o->triangleCount, vertices = o->vertexCount;
    QC_TRY(qcArray_Resize(&o->items, n, sizeof(Item), "order of triangles"));
    QC_TRY(qcVertexTriangles_Build(&o->around, o->indices, n, o->vertexCount));
    QC_TRY(qcArray_Resize(&o->hops, vertices, sizeof(Hops), "order of triangles"));
    return qcArray_Resize(&o->queue, vertices, sizeof(uint32_t), "order of triangles");
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

static qcStatus Make(Order* o, const double* positions, qcArray* slots)
{
    QC_TRY(Reserve(o));
    float length = SetSpace(o, positions);
    WalkComponents(o);
    SetHops(o, length);

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
                             uint32_t vertexCount, uint32_t threads)
{
    if (triangleCount > UINT32_MAX / 3)
        return qcFailMemory(SIZE_MAX, "order of more than 2^32 / 3 triangles");
    slots->count = 0;
    if (triangleCount == 0)
        return qc_statusOk;
    Order order = {.indices = indices, .triangleCount = triangleCount, .vertexCount = vertexCount, .threads = threads};
    qcStatus status = Make(&order, positions, slots);
    Free(&order);
    return status;
}
