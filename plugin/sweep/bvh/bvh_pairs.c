// From the tops of two surfaces downwards: eight boxes against eight at a time, on all levels alike, down to triangles.
// (Two trees at once: Brinkhoff, Kriegel, Seeger: Efficient Processing of Spatial Joins Using R-Trees, 1993.)
//
// Why no pair is lost. Boxes within the margin of each other overlap in the lattice (sweep/bvh/triangle_bvh.c), and
// then so do the boxes around them on every level. Boxes of another surface come from its own lattice: see qcGroupMap.
// The tables leave out neighbours and nothing else, and the filter what is surely apart
// (kernels/separating_axis.inl.h).
#include "sweep/bvh/bvh_pairs.h"

#include "base/parallel_for.h"
#include "base/rigid_transform.h"
#include "base/status.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum
{
    // Pairs of groups that are given to threads: enough that no thread waits long for the last.
    qc_itemsPerThread = 64,
    qc_tasksPerThread = 16,
    // Searches that are prepared together, in about ten microseconds, and as many times as waking a thread is worth.
    qc_searchBlock = 16,
    qc_leastSearchBlocks = 8,
    qc_queueRoom = qc_queueFull + qc_nodeSize * qc_nodeSize
};

typedef struct Item
{
    uint32_t search, a, b;
} Item;

typedef struct Search
{
    const qcBvhPairsJob* job;
    uint32_t level;         ///< of the items
    qcMappedSurface mapped; ///< b, as a sees it
    qcFilterSide sides[2];
    qcDistanceThresholds bound;
    bool same;
    bool filters; ///< the bound is of use
} Search;

/// What one worker has found and not yet given away.
typedef struct Queue
{
    const Search* search;
    qcSlotPair *pairs, *end;
    uint32_t worker;
    bool wanted;
} Queue;

/// Bits i + 8 j with i <= j.
static const uint64_t s_inOrder = UINT64_C(0xff7f3f1f0f070301);

static void Flush(Queue* queue)
{
    const Search* s = queue->search;
    size_t count = (size_t)(queue->end - queue->pairs);
    queue->end = queue->pairs;
    if (count == 0 || !queue->wanted)
        return;
    qcClassifiedPairs found = {.pairs = queue->pairs, .count = count};
    if (s->filters)
        qcClassifiedPairs_Filter(&found, s->job->kernels, s->sides, &s->bound);
    queue->wanted = found.count == 0 || s->job->function(s->job->context, &found, queue->worker);
}

static qcSurfaceBoxes BoxesOf(const qcTriangleBvh* surface)
{
    const qcBox8* groups = surface->groups.data;
    return (qcSurfaceBoxes){groups, groups + surface->firstGroup[1]};
}

static void CompareNodes(Queue* queue, uint32_t a, uint32_t b)
{
    const Search* s = queue->search;
    const qcBvhPairsJob* job = s->job;
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
    qcPairExclusion skips[qc_maxExclusions];
    int skipCount = 0;
    const uint64_t* table = NULL;
    if (job->neighbours)
        table = a == b ? qcPairMask_OfOneNode() : NULL;
    else
    {
        uint32_t link = qcClusters_FindLink(&job->a->clusters, a, b);
        if (link != QC_NO_LINK)
            table = qcClusters_PairMask(&job->a->clusters, link);
        if (link != QC_NO_LINK && job->flatDiscs)
            skipCount = qcTriangleBvh_FindSkips(job->a, a, link, skips);
        for (int i = 0; i < skipCount; i++)
            if ((skips[i].a & skips[i].b) == UINT64_MAX)
                return;
    }
    queue->end = job->kernels->collect(&sideA, a, &sideB, b, table, skips, skipCount, queue->end);
}

/// The groups of the level below that meet: bit i + 8 j.
static uint64_t CompareGroups(const Search* s, uint32_t level, Item item)
{
    const qcBox8* a = qcTriangleBvh_Group(s->job->a, level, item.a);
    const qcBox8* b = qcTriangleBvh_Group(s->job->b, level, item.b);
    if (!s->same)
    {
        qcBox8 mapped;
        s->job->kernels->mapGroup(b, &s->mapped.levels, &mapped);
        return s->job->kernels->compare(a, &mapped);
    }
    uint64_t meet = s->job->kernels->compare(a, b);
    return item.a == item.b ? meet & s_inOrder : meet;
}

static Item Child(Item item, uint32_t bit)
{
    return (Item){item.search, item.a * qc_groupSize + bit % qc_groupSize, item.b * qc_groupSize + bit / qc_groupSize};
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

static qcRigidTransform PlacementOf(const qcTriangleBvh* surface, const qcBody* body)
{
    qcRigidTransform p = {.transform = surface->isLocal ? body->transform : qcIdentityTransform()};
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

/// What is no further apart in a's frame is near in the world, where vectors of the frame are at most `growth` times as
/// long; and what is further is not, as vectors of the world are at most `stretch` times as long in the frame.
static void SetMargin(qcDistanceThresholds* bound, double margin, double growth, double stretch)
{
    bound->margin = nextafterf((float)(margin / growth), 0.0f);
    bound->beyond = nextafterf((float)(margin * stretch), INFINITY);
}

qcDistanceThresholds qcTriangleBvh_FindBound(const qcTriangleBvh* surface, double margin, double nearest)
{
    qcDistanceThresholds bound = {.pointError = surface->pointError, .reach = qcTriangleBvh_Reach(surface, margin)};
    // Where bodies are in the world, lengths are as they are there.
    SetMargin(&bound, nearest * surface->map.unit[0], 1.0, 1.0);
    return bound;
}

/// From b's lattice and frame to a's: back to b's coordinates, from there to a's, and on. Coordinates of points, in
/// units of b's frame, are 1 at most.
static void FindMaps(Search* s)
{
    const qcTriangleBvh *a = s->job->a, *b = s->job->b;
    qcRigidTransform placementA = PlacementOf(a, s->job->bodyA), placementB = PlacementOf(b, s->job->bodyB);
    qcRelativeTransform r = qcRelativeTransform_Find(&placementA, &placementB);
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
    s->bound.reach = qcTriangleBvh_Reach(a, s->job->margin * r.stretch);
    if (a->isLocal)
        SetMargin(&s->bound, s->job->nearest * a->map.unit[0], r.growth, r.stretch);
    s->bound.mapped = true;
    s->mapped.boxes = BoxesOf(b);
    s->mapped.triangles = s->sides[1];
}

static void Prepare(Search* s, const qcBvhPairsJob* job)
{
    *s = (Search){.job = job, .same = job->a == job->b, .filters = true};
    assert(!s->same || job->neighbours || job->a->related);
    const qcTriangleBvh* sides[2] = {job->a, job->b};
    for (int i = 0; i < 2; i++)
        s->sides[i] = (qcFilterSide){sides[i]->corners.data, sides[i]->points.data};
    s->bound = qcTriangleBvh_FindBound(job->a, job->margin, job->nearest);
    if (!s->same)
        FindMaps(s);
}

//  ---- all searches ----------------------------------------------------------------------------------

typedef struct Run
{
    qcBvhPairs* memory;
    const qcBvhPairsJob* jobs;
    size_t jobCount;
    size_t share; ///< items that a worker takes at a time
} Run;

static Search* SearchAt(const Run* run, size_t i)
{
    return &QC_AT(Search, run->memory->searches, i);
}

static void PrepareBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Run* run = context;
    for (size_t i = block * qc_searchBlock; i < run->jobCount && i < (block + 1) * qc_searchBlock; i++)
        Prepare(SearchAt(run, i), &run->jobs[i]);
}

/// From the tops down, level by level, until there are enough.
static qcStatus FindItems(qcArray* items, Search* s, uint32_t number, size_t enough)
{
    const qcBvhPairsJob* job = s->job;
    s->level = job->a->levels > job->b->levels ? job->a->levels : job->b->levels;
    size_t first = items->count;
    QC_TRY(qcArray_Resize(items, first + 1, sizeof(Item), "pairs of groups"));
    QC_AT(Item, *items, first) = (Item){number, 0, 0};
    while (s->level > 1 && items->count > first && items->count - first < enough)
    {
        size_t end = items->count, at = end;
        for (size_t i = first; i < end; i++)
        {
            Item item = QC_AT(Item, *items, i);
            QC_TRY(qcArray_Reserve(items, at + 64, sizeof(Item), "pairs of groups"));
            for (uint64_t meet = CompareGroups(s, s->level, item); meet != 0; meet &= meet - 1)
                QC_AT(Item, *items, at++) = Child(item, (uint32_t)__builtin_ctzll(meet));
            items->count = at;
        }
        items->count = first + (at - end);
        memmove(&QC_AT(Item, *items, first), &QC_AT(Item, *items, end), (at - end) * sizeof(Item));
        s->level--;
    }
    return qc_statusOk;
}

static size_t SizeOf(const qcBvhPairsJob* job)
{
    return job->a->groupCount[0] + job->b->groupCount[0];
}

/// To each search as many as it has of all clusters.
static qcStatus FindAllItems(const Run* run, uint32_t threads)
{
    qcArray* items = &run->memory->items;
    double wanted = threads > 1 ? (double)threads * qc_itemsPerThread : 0.0, clusters = 0.0;
    for (size_t i = 0; i < run->jobCount; i++)
        clusters += (double)SizeOf(&run->jobs[i]);
    items->count = 0;
    for (size_t i = 0; i < run->jobCount; i++)
    {
        double enough = wanted * (double)SizeOf(&run->jobs[i]) / clusters;
        QC_TRY(FindItems(items, SearchAt(run, i), (uint32_t)i, (size_t)enough));
    }
    return qc_statusOk;
}

static void TakeItems(void* context, size_t task, uint32_t worker)
{
    const Run* run = context;
    const qcArray* items = &run->memory->items;
    Queue queue = {.worker = worker, .wanted = true};
    queue.pairs = queue.end = &QC_AT(qcSlotPair, run->memory->queues, (size_t)worker * qc_queueRoom);
    size_t first = task * run->share, left = items->count - first,
           end = first + (left < run->share ? left : run->share);
    for (size_t k = first; k < end; k++)
    {
        Item item = QC_AT(Item, *items, k);
        const Search* search = SearchAt(run, item.search);
        if (queue.search != NULL && queue.search != search)
            Flush(&queue);
        queue.search = search;
        Descend(&queue, search->level, item);
    }
    Flush(&queue);
}

qcStatus qcBvhPairs_Find(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads)
{
    Run run = {.memory = pairs, .jobs = jobs, .jobCount = jobCount};
    QC_TRY(qcArray_Resize(&pairs->searches, jobCount, sizeof(Search), "pairs of surfaces"));
    QC_TRY(qcArray_Resize(&pairs->queues, (size_t)threads * qc_queueRoom, sizeof(qcSlotPair), "pairs of places"));
    qcParallel_For(threads, (jobCount + qc_searchBlock - 1) / qc_searchBlock, qc_leastSearchBlocks, PrepareBlock, &run);
    QC_TRY(FindAllItems(&run, threads));
    size_t count = pairs->items.count;
    run.share = threads > 1 ? count / (threads * qc_tasksPerThread) + 1 : count;
    if (count != 0)
        qcParallel_For(threads, (count + run.share - 1) / run.share, 2, TakeItems, &run);
    return qc_statusOk;
}

void qcBvhPairs_Free(qcBvhPairs* pairs)
{
    qcArray_Free(&pairs->searches);
    qcArray_Free(&pairs->items);
    qcArray_Free(&pairs->queues);
}
