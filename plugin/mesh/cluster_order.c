// Groups the triangles: those around each hub and all others, or those in the region and the rest. Each group gets
// nodes of its own; median_split.c puts its triangles in order by their centroids.
#include "mesh/cluster_order.h"

#include "mesh/limits.h"
#include "mesh/median_split.h"
#include "mesh/triangle_sample.h"
#include "base/aabb.h"
#include "base/four_floats.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    // A vertex with so many triangles is a hub: its triangles get nodes of their own, in which all are neighbours, so
    // that those nodes share one pair mask. Fewer than 16 nodes have few pairs.
    qc_hubValence = 1024,
    // If fewer than one in so many triangles is outside the region, none is left out. (First step of 27 bunnies: 7.3 ms
    // with 4, 6.5 ms with 8.)
    qc_leftOutShare = 8,
    // Triangles, or vertices.
    qc_centroidBlock = 4096,
    qc_minBlocks = 4
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
    double high[3];
    qcBounds_Clear(o->low, high);
    for (uint32_t v = 0; v < o->vertexCount; v++)
        if (valences[v] != 0)
            qcBounds_IncludePoint(o->positions + 3 * (size_t)v, o->low, high);
    qcTriangleSample sample;
    qcTriangleSample_Take(&sample, o->indices, o->triangleCount, o->positions);
    (void)qcTriangleSample_Trim(&sample, o->low, high);
    double extent = qcBounds_Widest(o->low, high);
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
    qcMedianSplit_Run(items, o->scratch.data, count, o->options->threads, &QC_AT(uint32_t, *slots, first));
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
