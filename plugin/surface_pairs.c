// From the tops of two surfaces downwards: eight boxes against eight at a time, on all levels alike, down to triangles.
// (Two trees at once: Brinkhoff, Kriegel, Seeger: Efficient Processing of Spatial Joins Using R-Trees, 1993.)
//
// Why no pair is lost. Boxes within the margin of each other overlap in the lattice (surface.c), and then so do the
// boxes around them on every level. Boxes of another surface come from its own lattice: see qcGroupMap. The tables
// leave out neighbours and nothing else, and the filter what is surely apart (surface_kernels_filter.h).
#include "surface_pairs.h"

#include "parallel.h"
#include "placement.h"
#include "status.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum
{
    // Pairs of groups that are given to threads: enough that no thread waits long for the last.
    qc_itemsPerThread = 64,
    qc_queueRoom = qc_queueFull + qc_nodeSize * qc_nodeSize
};

typedef struct Item
{
    uint32_t a, b;
} Item;

typedef struct Search
{
    const qcSurfacePairsJob* job;
    qcSurfacePairs* memory;
    uint32_t level;         ///< of the items
    qcMappedSurface mapped; ///< b, as a sees it
    qcFilterSide sides[2];
    qcFilterBound bound;
    bool same;
    bool filters; ///< the bound is of use
} Search;

/// What one worker has found and not yet given away.
typedef struct Queue
{
    const Search* search;
    qcPlacePair *pairs, *end;
    uint32_t worker;
    bool wanted;
} Queue;

/// Bits i + 8 j with i <= j.
static const uint64_t s_inOrder = UINT64_C(0xff7f3f1f0f070301);

void qcFoundPairs_Filter(qcFoundPairs* found, const qcSurfaceKernels* kernels, const qcFilterSide sides[2],
                         const qcFilterBound* bound)
{
    found->count = kernels->filter(&sides[0], &sides[1], bound, found->pairs, found->count);
    if (bound->reach > 0.0f)
    {
        qcApartCounts counts = kernels->part(&sides[0], &sides[1], bound, found->pairs, found->count);
        found->near = counts.near;
        found->apart = counts.apart;
        found->count = counts.count;
    }
    size_t known = found->near + found->apart;
    found->penetrating = kernels->findPiercing(&sides[0], &sides[1], bound, found->pairs + known, found->count - known);
}

static void Flush(Queue* queue)
{
    const Search* s = queue->search;
    size_t count = (size_t)(queue->end - queue->pairs);
    queue->end = queue->pairs;
    if (count == 0 || !queue->wanted)
        return;
    qcFoundPairs found = {.pairs = queue->pairs, .count = count};
    if (s->filters)
        qcFoundPairs_Filter(&found, s->job->kernels, s->sides, &s->bound);
    queue->wanted = found.count == 0 || s->job->function(s->job->context, &found, queue->worker);
}

static qcSurfaceBoxes BoxesOf(const qcSurface* surface)
{
    const qcBoxGroup* groups = surface->groups.data;
    return (qcSurfaceBoxes){groups, groups + surface->firstGroup[1]};
}

static void CompareNodes(Queue* queue, uint32_t a, uint32_t b)
{
    const Search* s = queue->search;
    const qcSurfacePairsJob* job = s->job;
    if (job->reachedA != NULL)
        __atomic_store_n(&job->reachedA[a], 1, __ATOMIC_RELAXED);
    if (job->reachedB != NULL)
        __atomic_store_n(&job->reachedB[b], 1, __ATOMIC_RELAXED);
    if (queue->end - queue->pairs >= qc_queueFull)
        Flush(queue);
    qcSurfaceBoxes sideA = BoxesOf(job->a);
    if (!s->same)
    {
        queue->end = job->kernels->collectMapped(&sideA, a, &s->mapped, b, queue->end);
        return;
    }
    qcSurfaceBoxes sideB = BoxesOf(job->b);
    qcPlaceSkip skips[qc_mostSkips];
    int skipCount = 0;
    const uint64_t* words = NULL;
    if (job->neighbours)
        words = a == b ? qcClusters_OrderTable() : NULL;
    else
    {
        uint32_t link = qcClusters_FindLink(&job->a->clusters, a, b);
        if (link != QC_NO_LINK)
            words = qcClusters_Table(&job->a->clusters, link);
        if (link != QC_NO_LINK && job->flatDiscs)
            skipCount = qcSurface_FindSkips(job->a, a, link, skips);
        for (int i = 0; i < skipCount; i++)
            if ((skips[i].a & skips[i].b) == UINT64_MAX)
                return;
    }
    queue->end = job->kernels->collect(&sideA, a, &sideB, b, words, skips, skipCount, queue->end);
}

/// The groups of the level below that meet: bit i + 8 j.
static uint64_t CompareGroups(const Search* s, uint32_t level, Item item)
{
    const qcBoxGroup* a = qcSurface_Group(s->job->a, level, item.a);
    const qcBoxGroup* b = qcSurface_Group(s->job->b, level, item.b);
    if (!s->same)
    {
        qcBoxGroup mapped;
        s->job->kernels->mapGroup(b, &s->mapped.levels, &mapped);
        return s->job->kernels->compare(a, &mapped);
    }
    uint64_t meet = s->job->kernels->compare(a, b);
    return item.a == item.b ? meet & s_inOrder : meet;
}

static Item Child(Item item, uint32_t bit)
{
    return (Item){item.a * qc_groupSize + bit % qc_groupSize, item.b * qc_groupSize + bit / qc_groupSize};
}

static void Descend(Queue* queue, uint32_t level, Item item)
{
    if (level == 1)
    {
        CompareNodes(queue, item.a, item.b);
        return;
    }
    for (uint64_t meet = CompareGroups(queue->search, level, item); meet != 0; meet &= meet - 1)
        Descend(queue, level - 1, Child(item, (uint32_t)__builtin_ctzll(meet)));
}

static void TakeItem(void* context, size_t i, uint32_t worker)
{
    const Search* s = context;
    Queue queue = {.search = s, .worker = worker, .wanted = true};
    queue.pairs = queue.end = &QC_AT(qcPlacePair, s->memory->queues, (size_t)worker * qc_queueRoom);
    size_t count = s->memory->items.count, share = s->job->threads > 1 ? 4 : count;
    for (size_t k = i * share; k < count && k < (i + 1) * share; k++)
        Descend(&queue, s->level, QC_AT(Item, s->memory->items, k));
    Flush(&queue);
}

/// From the tops down, level by level, until there is enough for all threads to do.
static qcStatus FindItems(Search* s)
{
    qcSurfacePairs* memory = s->memory;
    const qcSurfacePairsJob* job = s->job;
    s->level = job->a->levels > job->b->levels ? job->a->levels : job->b->levels;
    QC_TRY(qcArray_Resize(&memory->items, 1, sizeof(Item), "pairs of groups"));
    QC_AT(Item, memory->items, 0) = (Item){0, 0};
    size_t enough = job->threads > 1 ? (size_t)job->threads * qc_itemsPerThread : 1;
    while (s->level > 1 && memory->items.count != 0 && memory->items.count < enough)
    {
        memory->next.count = 0;
        for (size_t i = 0; i < memory->items.count; i++)
        {
            Item item = QC_AT(Item, memory->items, i);
            size_t at = memory->next.count;
            QC_TRY(qcArray_Reserve(&memory->next, at + 64, sizeof(Item), "pairs of groups"));
            for (uint64_t meet = CompareGroups(s, s->level, item); meet != 0; meet &= meet - 1)
                QC_AT(Item, memory->next, at++) = Child(item, (uint32_t)__builtin_ctzll(meet));
            memory->next.count = at;
        }
        qcArray items = memory->items;
        memory->items = memory->next;
        memory->next = items;
        s->level--;
    }
    return qc_statusOk;
}

static qcPlacement PlacementOf(const qcSurface* surface, const qcBody* body)
{
    qcPlacement p = {.transform = surface->isLocal ? body->transform : qcIdentityTransform()};
    memcpy(p.lower, surface->isLocal ? body->localLower : body->lower, sizeof p.lower);
    memcpy(p.upper, surface->isLocal ? body->localUpper : body->upper, sizeof p.upper);
    return p;
}

/// What a map's errors come to, in levels: floats round each number and each operation by 2^-24 of what goes in, eight
/// times at most; 16 times are allowed for, and 2^-4 of a level for levels as the kernels compute them.
static float FindGrowth(double sizes, double error)
{
    double grow = 0x1p-20 * sizes + 0x1p-4 + error;
    // Numbers too large for floats, and products that may leave their range, make boxes that meet everything.
    return grow < 0x1p80 ? nextafterf((float)grow, INFINITY) : INFINITY;
}

/// From b's lattice and frame to a's: back to b's coordinates, from there to a's, and on. Coordinates of points, in
/// units of b's frame, are 1 at most.
static void FindMaps(Search* s)
{
    const qcSurface *a = s->job->a, *b = s->job->b;
    qcPlacement placementA = PlacementOf(a, s->job->bodyA), placementB = PlacementOf(b, s->job->bodyB);
    qcRelativePlacement r = qcRelativePlacement_Find(&placementA, &placementB);
    qcGroupMap *levels = &s->mapped.levels, *points = &s->mapped.points;
    const double half = 32768.0;
    for (int i = 0; i < 3; i++)
    {
        double origin = r.shift[i] - a->map.origin[i], level = 0.0, levelSizes = 0.0, pointSizes = 0.0, rho = 0.0;
        for (int k = 0; k < 3; k++)
            origin += r.linear[i][k] * b->map.origin[k];
        for (int k = 0; k < 3; k++)
        {
            double scale = a->map.scale[i] * r.linear[i][k] / b->map.scale[k];
            double pointScale = a->map.scale[i] * r.linear[i][k] / b->map.unit[k];
            double ratio = a->map.unit[i] * r.linear[i][k] / b->map.unit[k];
            levels->linear[i][k] = (float)scale;
            points->linear[i][k] = (float)pointScale;
            s->bound.linear[i][k] = (float)ratio;
            level += half * scale;
            levelSizes += 2.0 * half * fabs(scale);
            pointSizes += fabs(pointScale);
            rho += fabs(ratio);
        }
        double offset = origin * a->map.scale[i], at = origin * a->map.unit[i];
        // Of two bodies in the world nothing has been rounded on the way.
        double rounding = a->isLocal || b->isLocal ? r.error[i] : 0.0;
        // Boxes in the world have the margin. Local ones don't, nor do points: then b's boxes get it, on both sides.
        double margin = s->job->margin * r.reach[i] * (1.0 + 1e-8);
        levels->shift[i] = (float)(offset + level);
        levels->grow[i] = FindGrowth(fabs(offset) + levelSizes,
                                     a->map.scale[i] * (rounding + (a->isLocal || b->isLocal ? margin : 0.0)));
        points->shift[i] = (float)offset;
        points->grow[i] = FindGrowth(fabs(offset) + pointSizes,
                                     a->map.scale[i] * (rounding + margin) + pointSizes * (double)b->pointError);
        s->bound.shift[i] = (float)at;
        double error = (12.0 * rho + 6.0 * fabs(at)) * 0x1p-24 + rounding * a->map.unit[i];
        s->bound.pointError = fmaxf(s->bound.pointError, nextafterf((float)error, INFINITY));
        s->filters = s->filters && error < 1e6;
    }
    s->bound.reach = qcSurface_Reach(a, s->job->margin * r.stretch);
    s->bound.mapped = true;
    s->mapped.boxes = BoxesOf(b);
    s->mapped.triangles = s->sides[1];
}

qcStatus qcSurfacePairs_Find(qcSurfacePairs* pairs, const qcSurfacePairsJob* job)
{
    Search search = {.job = job, .memory = pairs, .same = job->a == job->b, .filters = true};
    assert(!search.same || job->neighbours || job->a->related);
    const qcSurface* sides[2] = {job->a, job->b};
    for (int i = 0; i < 2; i++)
        search.sides[i] = (qcFilterSide){sides[i]->corners.data, sides[i]->points.data};
    search.bound.pointError = job->a->pointError;
    // Where bodies are in the world, lengths are as they are there.
    search.bound.margin = job->a->isLocal ? -1.0f : nextafterf((float)(job->nearest * job->a->map.unit[0]), 0.0f);
    if (search.same)
        search.bound.reach = qcSurface_Reach(job->a, job->margin);
    else
        FindMaps(&search);
    QC_TRY(qcArray_Resize(&pairs->queues, (size_t)job->threads * qc_queueRoom, sizeof(qcPlacePair), "pairs of places"));
    QC_TRY(FindItems(&search));
    size_t count = pairs->items.count;
    if (count == 0)
        return qc_statusOk;
    qcParallel_For(job->threads, job->threads > 1 ? (count + 3) / 4 : 1, 2, TakeItem, &search);
    return qc_statusOk;
}

void qcSurfacePairs_Free(qcSurfacePairs* pairs)
{
    qcArray_Free(&pairs->items);
    qcArray_Free(&pairs->next);
    qcArray_Free(&pairs->queues);
}
