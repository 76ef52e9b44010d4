// From the roots of two BVHs downwards: eight boxes against eight at a time, both BVHs at the same level, down to
// triangles. (Simultaneous traversal: Brinkhoff, Kriegel, Seeger: Efficient Processing of Spatial Joins Using R-Trees,
// 1993.) Proof that no pair is lost: plugin/docs/proofs/bvh_pairs.md.
#include "sweep/bvh/bvh_pairs.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/lattice_map.h"
#include "sweep/bvh/motion_bvhs.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum
{
    // Pairs of nodes that are dealt to threads, at least, and one for so many clusters: enough that no thread waits
    // long for the last.
    qc_nodePairsPerThread = 64,
    qc_clustersPerNodePair = 512,
    qc_tasksPerThread = 64,
    // Clusters of both sides, as of 4096 triangles with themselves: a search of fewer stays on one thread. With two it
    // took 1.1 times as long where the cores have no common cache.
    qc_minClusters = 1024,
    // Searches that are prepared together, in about ten microseconds, and the min number of blocks that is worth waking
    // a thread for.
    qc_searchBlock = 16,
    qc_minSearchBlocks = 8,
    // Clusters of a BVH that exceeds the cache next to a core: 1.5 MB. A dragon of 871 K triangles takes 5 % less with
    // prefetches, a cloth of 20 K 2 % more.
    qc_minPrefetched = 16384,
    qc_queueRoom = qc_queueFull + qc_maxCollected
};

/// Two nodes of the current level of their search.
typedef struct NodePair
{
    uint32_t search, a, b;
} NodePair;

typedef struct Search
{
    const qcBvhPairsJob* job;
    const qcTriangleBvh *a, *b;
    uint32_t level;               ///< of its node pairs
    qcTransformedBvh transformed; ///< b in the lattice of a
    /// b is local: boxes are compared in its lattice too, above leaf nodes. In these that would take as long as it
    /// saves.
    bool isTurned;
    qcBoxTransform reverse; ///< from the lattice of a to that of b, if isTurned
    qcIndexedTriangles sides[2];
    qcDistanceThresholds thresholds;
    bool same;
    bool filters;        ///< false: the thresholds are too inexact for the filter
    qcMotionBvh* motion; ///< of a and of b; null: no motion
} Search;

/// The pairs that one worker has found and not yet reported.
typedef struct Queue
{
    const Search* search;
    qcSlotPair *pairs, *end;
    qcPlaneCache* planes;
    qcBox8 transformed;      ///< the boxes of a leaf node's clusters in the lattice of the other BVH
    uint64_t transformedKey; ///< its search and its number; UINT64_MAX: none
    uint32_t worker;
    bool isOpen; ///< false: the job's function has stopped the search
} Queue;

/// Bits i + 8 j with i <= j.
static const uint64_t s_inOrder = UINT64_C(0xff7f3f1f0f070301);

static void Flush(Queue* queue)
{
    const Search* s = queue->search;
    size_t count = (size_t)(queue->end - queue->pairs);
    queue->end = queue->pairs;
    if (count == 0 || !queue->isOpen)
        return;
    qcClassifiedPairs found = {.pairs = queue->pairs, .count = count};
    if (s->filters && s->motion != NULL)
        found.count = s->job->kernels->filterMotion(&s->motion[0], &s->motion[1], found.pairs, count);
    else if (s->filters)
        qcClassifiedPairs_Filter(&found, s->job->kernels, s->sides, &s->thresholds, true);
    queue->isOpen = found.count == 0 || s->job->function(s->job->context, &found, queue->worker);
}

/// The pairs of two leaf nodes of one body that are left out.
typedef struct Rules
{
    const uint64_t* pairMasks; ///< null: all pairs are tested
    uint64_t ownMask[qc_maxPairMaskSize + 1];
    qcPairExclusion exclusions[qc_maxExclusions];
    int exclusionCount;
} Rules;

/// The mask of two nodes of a body without links.
static void FindMask(const Search* s, uint32_t a, uint32_t b, Rules* rules)
{
    const qcClusterVertices* vertices = s->job->a->vertices.data;
    const qcBox8* nodes = qcTriangleBvh_Boxes(s->a, &s->a->fit).nodes;
    uint64_t clusters = s->motion != NULL ? UINT64_MAX : s->job->kernels->findOverlaps(&nodes[a], &nodes[b]);
    uint32_t neighbours = s->job->kernels->findPairMask(vertices + (size_t)a * qc_boxLanes,
                                                        vertices + (size_t)b * qc_boxLanes, clusters, rules->ownMask);
    if (neighbours != 0 && s->job->neighbourCount != NULL)
        __atomic_fetch_add(s->job->neighbourCount, neighbours, __ATOMIC_RELAXED);
    rules->pairMasks = rules->ownMask;
}

/// False: all pairs are left out.
static bool FindRules(const Search* s, uint32_t a, uint32_t b, Rules* rules)
{
    const qcBvhPairsJob* job = s->job;
    rules->pairMasks = NULL;
    rules->exclusionCount = 0;
    if (job->includeNeighbours)
    {
        rules->pairMasks = a == b ? qcPairMask_OfOneNode() : NULL;
        return true;
    }
    if (!job->a->hasAdjacency)
    {
        FindMask(s, a, b, rules);
        return true;
    }
    const qcClusters* clusters = &job->a->bvh.clusters;
    uint32_t link = qcClusters_FindLink(clusters, a, b);
    if (link == QC_NO_LINK)
        return true;
    rules->pairMasks = qcClusters_PairMask(clusters, link);
    if (job->skipFlatPatches)
        rules->exclusionCount = qcPatchState_FindExclusions(
            &job->a->patches, job->motion ? &job->a->patches.motion : &job->a->patches.present, clusters, a, link,
            rules->exclusions);
    for (int i = 0; i < rules->exclusionCount; i++)
        if ((rules->exclusions[i].a & rules->exclusions[i].b) == UINT64_MAX)
            return false;
    return true;
}

/// The overlapping clusters of two leaf nodes of two bodies. Consecutive pairs mostly share the second node.
static uint64_t FindClusterOverlaps(Queue* queue, NodePair nodes)
{
    const Search* s = queue->search;
    uint64_t key = (uint64_t)nodes.search << 32 | nodes.b;
    if (queue->transformedKey != key)
        s->job->kernels->transformBoxes(&s->transformed.boxes.nodes[nodes.b], &s->transformed.levels,
                                        &queue->transformed);
    queue->transformedKey = key;
    return s->job->kernels->findOverlaps(&qcTriangleBvh_Boxes(s->a, &s->a->fit).nodes[nodes.a], &queue->transformed);
}

static void MarkVisited(const qcBvhPairsJob* job, NodePair nodes)
{
    if (job->visitedA != NULL)
        __atomic_store_n(&job->visitedA[nodes.a], 1, __ATOMIC_RELAXED);
    if (job->visitedB != NULL)
        __atomic_store_n(&job->visitedB[nodes.b], 1, __ATOMIC_RELAXED);
}

static void CompareLeafNodes(Queue* queue, NodePair nodes)
{
    uint32_t number = nodes.search, a = nodes.a, b = nodes.b;
    const Search* s = queue->search;
    const qcBvhPairsJob* job = s->job;
    MarkVisited(job, nodes);
    if (queue->end - queue->pairs >= qc_queueFull)
        Flush(queue);
    Rules rules;
    rules.pairMasks = NULL;
    rules.exclusionCount = 0;
    if (s->same && !FindRules(s, a, b, &rules))
        return;
    if (s->motion != NULL)
    {
        queue->end = job->kernels->collectMotionPairs(&s->motion[0], a, &s->motion[1], b, rules.pairMasks,
                                                      rules.exclusions, rules.exclusionCount, queue->end);
        return;
    }
    qcBvhBoxes boxesA = qcTriangleBvh_Boxes(s->a, &s->a->fit);
    const qcPlaneTest test = {.sides = {s->sides[0], s->sides[1]},
                              .thresholds = &s->thresholds,
                              .isOne = s->same,
                              .key = (uint64_t)number << 32,
                              .cache = queue->planes};
    const qcPlaneTest* planes = s->filters ? &test : NULL;
    if (!s->same)
    {
        uint64_t clusters = FindClusterOverlaps(queue, nodes);
        if (clusters != 0)
            queue->end =
                job->kernels->collectTransformedPairs(&boxesA, a, &s->transformed, b, clusters, planes, queue->end);
        return;
    }
    queue->end = job->kernels->collectPairs(&boxesA, a, &boxesA, b, rules.pairMasks, rules.exclusions,
                                            rules.exclusionCount, planes, queue->end);
}

/// Eight boxes of a node at the start and at the end, in the reference lattices; transformed ones are put into `own`.
static void GetMotionBoxes(const Search* s, const qcMotionBvh* motion, const qcTriangleBvh* bvh,
                           const qcBvhFit* startFit, uint32_t level, uint32_t node, qcBox8 own[2],
                           const qcBox8* boxes[2])
{
    boxes[0] = qcTriangleBvh_Box8At(bvh, startFit, level, node);
    boxes[1] = qcTriangleBvh_Box8At(bvh, &bvh->fit, level, node);
    for (int t = 0; t < 2 && motion->isTransformed; t++)
    {
        s->job->kernels->transformBoxes(boxes[t], &motion->at[t].levels, &own[t]);
        boxes[t] = &own[t];
    }
}

static uint64_t FindMotionOverlaps(const Search* s, uint32_t level, NodePair nodes)
{
    qcBox8 ownA[2], ownB[2];
    const qcBox8 *a[2], *b[2];
    GetMotionBoxes(s, &s->motion[0], s->a, qcTriangleBvh_StartFit(s->a, s->job->bodyA), level, nodes.a, ownA, a);
    GetMotionBoxes(s, &s->motion[1], s->b, qcTriangleBvh_StartFit(s->b, s->job->bodyB), level, nodes.b, ownB, b);
    uint64_t overlaps = s->job->kernels->findMotionOverlaps(a, b);
    return s->same && nodes.a == nodes.b ? overlaps & s_inOrder : overlaps;
}

/// The overlapping children of two nodes: bit i + 8 j.
static uint64_t FindOverlaps(const Search* s, uint32_t level, NodePair nodes)
{
    if (s->motion != NULL)
        return FindMotionOverlaps(s, level, nodes);
    const qcBox8* a = qcTriangleBvh_Box8At(s->a, &s->a->fit, level, nodes.a);
    const qcBox8* b = qcTriangleBvh_Box8At(s->b, &s->b->fit, level, nodes.b);
    if (!s->same)
    {
        qcBox8 transformed;
        s->job->kernels->transformBoxes(b, &s->transformed.levels, &transformed);
        uint64_t overlaps = s->job->kernels->findOverlaps(a, &transformed);
        if (!s->isTurned || overlaps == 0)
            return overlaps;
        s->job->kernels->transformBoxes(a, &s->reverse, &transformed);
        return overlaps & s->job->kernels->findOverlaps(&transformed, b);
    }
    uint64_t overlaps = s->job->kernels->findOverlaps(a, b);
    return nodes.a == nodes.b ? overlaps & s_inOrder : overlaps;
}

static NodePair ChildAt(NodePair nodes, uint32_t bit)
{
    return (NodePair){nodes.search, nodes.a * qc_boxLanes + bit % qc_boxLanes,
                      nodes.b * qc_boxLanes + bit / qc_boxLanes};
}

/// The boxes of a leaf node that is compared soon, and of its clusters.
static void Prefetch(const qcTriangleBvh* bvh, uint32_t node)
{
    const qcBvhBoxes boxes = qcTriangleBvh_Boxes(bvh, &bvh->fit);
    const char *own = (const char*)&boxes.nodes[node],
               *clusters = (const char*)&boxes.clusters[(size_t)node * qc_boxLanes];
    __builtin_prefetch(own);
    __builtin_prefetch(own + sizeof(qcBox8) - 1);
    for (size_t at = 0; at < qc_boxLanes * sizeof(qcBox8); at += 64)
        __builtin_prefetch(clusters + at);
}

static void PrefetchChildren(const Search* s, NodePair nodes, uint64_t overlaps)
{
    for (uint32_t i = 0; i < qc_boxLanes; i++)
    {
        if ((overlaps >> i & UINT64_C(0x0101010101010101)) != 0)
            Prefetch(s->a, nodes.a * qc_boxLanes + i);
        if ((overlaps >> qc_boxLanes * i & 0xffu) != 0 && (nodes.a != nodes.b || !s->same))
            Prefetch(s->b, nodes.b * qc_boxLanes + i);
    }
}

static void Descend(Queue* queue, uint32_t level, NodePair nodes)
{
    if (level == 1)
    {
        CompareLeafNodes(queue, nodes);
        return;
    }
    uint64_t overlaps = FindOverlaps(queue->search, level, nodes);
    if (level == 2 && queue->search->a->box8Count[0] > qc_minPrefetched)
        PrefetchChildren(queue->search, nodes, overlaps);
    for (; overlaps != 0; overlaps &= overlaps - 1)
        Descend(queue, level - 1, ChildAt(nodes, (uint32_t)__builtin_ctzll(overlaps)));
}

//  ---- two bodies ------------------------------------------------------------------------------------

static qcRigidTransform TransformOf(const qcTriangleBvh* bvh, const qcBody* body)
{
    qcRigidTransform t = {.transform = bvh->fit.isLocal ? body->transform : qcIdentityTransform()};
    memcpy(t.lower, bvh->fit.isLocal ? body->localLower : body->lower, sizeof t.lower);
    memcpy(t.upper, bvh->fit.isLocal ? body->localUpper : body->upper, sizeof t.upper);
    return t;
}

/// Thresholds of a distance in a's frame. Vectors of the frame are at most `growth` times as long in the world, so
/// pairs within near / growth are near; vectors of the world are at most `stretch` times as long in the frame, so pairs
/// farther apart than near * stretch are not.
static void SetNear(qcDistanceThresholds* thresholds, double near, double growth, double stretch)
{
    thresholds->near = nextafterf((float)(near / growth), 0.0f);
    thresholds->far = nextafterf((float)(near * stretch), INFINITY);
}

qcDistanceThresholds qcTriangleBvh_Thresholds(const qcTriangleBvh* bvh, double query, double near)
{
    qcDistanceThresholds thresholds = {.pointError = bvh->fit.pointError,
                                       .query = qcTriangleBvh_DistanceInFrame(bvh, query)};
    // For bodies in the world: in their frames lengths are those of the world, scaled.
    SetNear(&thresholds, near * bvh->fit.lattice.unit[0], 1.0, 1.0);
    return thresholds;
}

/// From the lattice of a to that of b, for boxes.
static void FindReverse(Search* s, const qcRigidTransform* transformA, const qcRigidTransform* transformB)
{
    qcRelativeTransform r = qcRelativeTransform_Find(transformB, transformA);
    qcTransformedBvh transformed;
    qcDistanceThresholds unused = {.pointError = 0.0f};
    const qcLatticeMap map = {.to = &s->b->fit.lattice,
                              .from = &s->a->fit.lattice,
                              .relative = &r,
                              .fromPointError = (double)s->a->fit.pointError,
                              .rounds = true,
                              .query = s->job->query,
                              .growsBoxes = true,
                              .transformed = &transformed,
                              .thresholds = &unused};
    (void)qcLatticeMap_Find(&map);
    s->reverse = transformed.levels;
}

static void FindTransforms(Search* s)
{
    qcRigidTransform transformA = TransformOf(s->a, s->job->bodyA), transformB = TransformOf(s->b, s->job->bodyB);
    qcRelativeTransform r = qcRelativeTransform_Find(&transformA, &transformB);
    bool isLocal = s->a->fit.isLocal || s->b->fit.isLocal;
    const qcLatticeMap map = {.to = &s->a->fit.lattice,
                              .from = &s->b->fit.lattice,
                              .relative = &r,
                              .fromPointError = (double)s->b->fit.pointError,
                              .rounds = isLocal,
                              .query = s->job->query,
                              .growsBoxes = isLocal,
                              .transformed = &s->transformed,
                              .thresholds = &s->thresholds};
    s->filters = qcLatticeMap_Find(&map);
    s->thresholds.query = qcTriangleBvh_DistanceInFrame(s->a, s->job->query * r.stretch);
    if (s->a->fit.isLocal)
        SetNear(&s->thresholds, s->job->near * s->a->fit.lattice.unit[0], r.growth, r.stretch);
    s->thresholds.isTransformed = true;
    // Pairs of single leaf nodes are compared in less time.
    s->isTurned = s->b->fit.isLocal && (s->a->clusters.nodeCount > 1 || s->b->clusters.nodeCount > 1);
    if (s->isTurned)
        FindReverse(s, &transformA, &transformB);
    s->transformed.boxes = qcTriangleBvh_Boxes(s->b, &s->b->fit);
    s->transformed.triangles = s->sides[1];
}

static void Prepare(Search* s, const qcBvhPairsJob* job, qcMotionBvh* motion)
{
    *s = (Search){.job = job,
                  .a = &job->a->bvh,
                  .b = &job->b->bvh,
                  .same = job->a == job->b,
                  .filters = true,
                  .motion = job->motion ? motion : NULL};
    assert(!s->same || job->includeNeighbours || qcBodyBvh_FindsSelfPairs(job->a));
    if (job->motion)
    {
        const qcBvhOfBody bvhs[2] = {{s->a, job->bodyA}, {s->b, job->bodyB}};
        s->filters = qcMotionBvhs_Find(bvhs, s->same, motion);
        return;
    }
    s->sides[0] = (qcIndexedTriangles){s->a->corners.data, s->a->fit.points.data};
    s->sides[1] = (qcIndexedTriangles){s->b->corners.data, s->b->fit.points.data};
    s->thresholds = qcTriangleBvh_Thresholds(s->a, job->query, job->near);
    if (!s->same)
        FindTransforms(s);
}

//  ---- all searches ----------------------------------------------------------------------------------

typedef struct Run
{
    qcBvhPairs* memory;
    const qcBvhPairsJob* jobs;
    size_t jobCount;
    size_t share; ///< pairs of nodes in a task
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
        Prepare(SearchAt(run, i), &run->jobs[i],
                run->memory->motions.count != 0 ? &QC_AT(qcMotionBvh, run->memory->motions, 2 * i) : NULL);
}

/// From the roots down, level by level, until there are `enough` pairs of nodes.
static qcStatus FindNodePairs(qcArray* nodePairs, Search* s, uint32_t number, size_t enough)
{
    s->level = s->a->levels > s->b->levels ? s->a->levels : s->b->levels;
    size_t first = nodePairs->count;
    QC_TRY(qcArray_Resize(nodePairs, first + 1, sizeof(NodePair), "pairs of nodes"));
    QC_AT(NodePair, *nodePairs, first) = (NodePair){number, 0, 0};
    while (s->level > 1 && nodePairs->count > first && nodePairs->count - first < enough)
    {
        size_t end = nodePairs->count, at = end;
        for (size_t i = first; i < end; i++)
        {
            NodePair nodes = QC_AT(NodePair, *nodePairs, i);
            QC_TRY(qcArray_Reserve(nodePairs, at + 64, sizeof(NodePair), "pairs of nodes"));
            for (uint64_t overlaps = FindOverlaps(s, s->level, nodes); overlaps != 0; overlaps &= overlaps - 1)
                QC_AT(NodePair, *nodePairs, at++) = ChildAt(nodes, (uint32_t)__builtin_ctzll(overlaps));
            nodePairs->count = at;
        }
        nodePairs->count = first + (at - end);
        memmove(&QC_AT(NodePair, *nodePairs, first), &QC_AT(NodePair, *nodePairs, end), (at - end) * sizeof(NodePair));
        s->level--;
    }
    return qc_statusOk;
}

static size_t SizeOf(const qcBvhPairsJob* job)
{
    return job->a->bvh.box8Count[0] + job->b->bvh.box8Count[0];
}

static double SizeOfAll(const Run* run)
{
    double clusters = 0.0;
    for (size_t i = 0; i < run->jobCount; i++)
        clusters += (double)SizeOf(&run->jobs[i]);
    return clusters;
}

/// Each search gets a share in proportion to its clusters; one of an outline goes down to leaf nodes.
static qcStatus FindAllNodePairs(const Run* run, double clusters, uint32_t threads)
{
    qcArray* nodePairs = &run->memory->nodePairs;
    double total = threads > 1 ? fmax((double)threads * qc_nodePairsPerThread, clusters / qc_clustersPerNodePair) : 0.0;
    nodePairs->count = 0;
    for (size_t i = 0; i < run->jobCount; i++)
    {
        const qcBvhPairsJob* job = &run->jobs[i];
        bool isOutline = job->a->bvh.fit.isOutline || job->b->bvh.fit.isOutline;
        size_t first = nodePairs->count;
        double enough = total * (double)SizeOf(job) / clusters;
        QC_TRY(FindNodePairs(nodePairs, SearchAt(run, i), (uint32_t)i, isOutline ? SIZE_MAX : (size_t)enough));
        for (size_t k = first; isOutline && k < nodePairs->count; k++)
            MarkVisited(job, QC_AT(NodePair, *nodePairs, k));
    }
    return qc_statusOk;
}

static void SearchTask(void* context, size_t task, uint32_t worker)
{
    const Run* run = context;
    const qcArray* nodePairs = &run->memory->nodePairs;
    Queue queue = {.transformedKey = UINT64_MAX, .worker = worker, .isOpen = true};
    queue.planes = &QC_AT(qcPlaneCache, run->memory->planes, worker);
    memset(queue.planes->keys, 0xff, sizeof queue.planes->keys);
    memset(queue.planes->boxKeys, 0xff, sizeof queue.planes->boxKeys);
    queue.pairs = queue.end = &QC_AT(qcSlotPair, run->memory->queues, (size_t)worker * qc_queueRoom);
    size_t first = task * run->share, left = nodePairs->count - first,
           end = first + (left < run->share ? left : run->share);
    for (size_t k = first; k < end; k++)
    {
        NodePair nodes = QC_AT(NodePair, *nodePairs, k);
        const Search* search = SearchAt(run, nodes.search);
        if (queue.search != NULL && queue.search != search)
            Flush(&queue);
        queue.search = search;
        Descend(&queue, search->level, nodes);
    }
    Flush(&queue);
}

/// Few clusters stay on one thread.
static uint32_t ThreadsFor(double clusters, uint32_t threads)
{
    return clusters < qc_minClusters ? 1 : threads;
}

qcStatus qcBvhPairs_Begin(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads)
{
    Run run = {.memory = pairs, .jobs = jobs, .jobCount = jobCount};
    QC_TRY(qcArray_Resize(&pairs->searches, jobCount, sizeof(Search), "searches of BVHs"));
    bool isMotion = jobCount != 0 && jobs[0].motion;
    QC_TRY(qcArray_Resize(&pairs->motions, isMotion ? 2 * jobCount : 0, sizeof(qcMotionBvh), "searches of BVHs"));
    QC_TRY(qcArray_Resize(&pairs->queues, (size_t)threads * qc_queueRoom, sizeof(qcSlotPair), "pairs of slots"));
    QC_TRY(qcArray_Resize(&pairs->planes, threads, sizeof(qcPlaneCache), "planes of clusters"));
    qcParallel_For(threads, (jobCount + qc_searchBlock - 1) / qc_searchBlock, qc_minSearchBlocks, PrepareBlock, &run);
    double clusters = SizeOfAll(&run);
    return FindAllNodePairs(&run, clusters, ThreadsFor(clusters, threads));
}

void qcBvhPairs_Finish(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads)
{
    Run run = {.memory = pairs, .jobs = jobs, .jobCount = jobCount};
    threads = ThreadsFor(SizeOfAll(&run), threads);
    size_t count = pairs->nodePairs.count;
    run.share = threads > 1 ? count / ((size_t)threads * qc_tasksPerThread) + 1 : count;
    if (count != 0)
        qcParallel_For(threads, (count + run.share - 1) / run.share, 2, SearchTask, &run);
}

qcStatus qcBvhPairs_Find(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads)
{
    QC_TRY(qcBvhPairs_Begin(pairs, jobs, jobCount, threads));
    qcBvhPairs_Finish(pairs, jobs, jobCount, threads);
    return qc_statusOk;
}

void qcBvhPairs_Free(qcBvhPairs* pairs)
{
    qcArray_Free(&pairs->searches);
    qcArray_Free(&pairs->nodePairs);
    qcArray_Free(&pairs->motions);
    qcArray_Free(&pairs->queues);
    qcArray_Free(&pairs->planes);
}
