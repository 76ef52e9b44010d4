// Pairs of triangles of two leaf nodes. Proof: plugin/docs/proofs/bvh_pairs.md.
#include "sweep/bvh/leaf_pairs.h"

void qcPairQueue_Flush(qcPairQueue* queue)
{
    const qcBvhSearch* s = queue->search;
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
static void FindMask(const qcBvhSearch* s, uint32_t a, uint32_t b, Rules* rules)
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
static bool FindRules(const qcBvhSearch* s, uint32_t a, uint32_t b, Rules* rules)
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
static uint64_t FindClusterOverlaps(qcPairQueue* queue, qcNodePair nodes)
{
    const qcBvhSearch* s = queue->search;
    uint64_t key = (uint64_t)nodes.search << 32 | nodes.b;
    if (queue->transformedKey != key)
        s->job->kernels->transformBoxes(&s->transformed.boxes.nodes[nodes.b], &s->transformed.levels,
                                        &queue->transformed);
    queue->transformedKey = key;
    return s->job->kernels->findOverlaps(&qcTriangleBvh_Boxes(s->a, &s->a->fit).nodes[nodes.a], &queue->transformed);
}

void qcBvhPairsJob_MarkVisited(const qcBvhPairsJob* job, qcNodePair nodes)
{
    if (job->visitedA != NULL)
        __atomic_store_n(&job->visitedA[nodes.a], 1, __ATOMIC_RELAXED);
    if (job->visitedB != NULL)
        __atomic_store_n(&job->visitedB[nodes.b], 1, __ATOMIC_RELAXED);
}

/// Marks the leaf nodes, and makes room for their pairs.
static void Begin(qcPairQueue* queue, qcNodePair nodes)
{
    qcBvhPairsJob_MarkVisited(queue->search->job, nodes);
    if (queue->end - queue->pairs >= qc_queueFull)
        qcPairQueue_Flush(queue);
}

static qcPlaneTest MakePlaneTest(const qcPairQueue* queue, uint32_t number)
{
    const qcBvhSearch* s = queue->search;
    return (qcPlaneTest){.sides = {s->sides[0], s->sides[1]},
                         .thresholds = &s->thresholds,
                         .isOne = s->same,
                         .key = (uint64_t)number << 32,
                         .cache = queue->planes};
}

static void AddMotionPairs(qcPairQueue* queue, qcNodePair nodes, const uint64_t* pairMasks,
                           const qcPairExclusion* exclusions, int exclusionCount)
{
    const qcBvhSearch* s = queue->search;
    queue->end = s->job->kernels->collectMotionPairs(&s->motion[0], nodes.a, &s->motion[1], nodes.b, pairMasks,
                                                     exclusions, exclusionCount, queue->end);
}

/// Adds the pairs of clusters of two bodies.
static void AddTransformedPairs(qcPairQueue* queue, qcNodePair nodes, uint64_t clusters)
{
    const qcBvhSearch* s = queue->search;
    if (clusters == 0)
        return;
    qcBvhBoxes boxes = qcTriangleBvh_Boxes(s->a, &s->a->fit);
    const qcPlaneTest planes = MakePlaneTest(queue, nodes.search);
    queue->end = s->job->kernels->collectTransformedPairs(&boxes, nodes.a, &s->transformed, nodes.b, clusters,
                                                          s->filters ? &planes : NULL, queue->end);
}

void qcPairQueue_AddClusters(qcPairQueue* queue, qcNodePair nodes, uint64_t clusters)
{
    Begin(queue, nodes);
    if (queue->search->motion == NULL)
    {
        AddTransformedPairs(queue, nodes, clusters);
        return;
    }
    const uint64_t leftOut[] = {0, ~clusters, 0}; // a packed mask
    AddMotionPairs(queue, nodes, leftOut, NULL, 0);
}

void qcPairQueue_AddNodes(qcPairQueue* queue, qcNodePair nodes)
{
    const qcBvhSearch* s = queue->search;
    Begin(queue, nodes);
    Rules rules;
    rules.pairMasks = NULL;
    rules.exclusionCount = 0;
    if (s->same && !FindRules(s, nodes.a, nodes.b, &rules))
        return;
    if (s->motion != NULL)
    {
        AddMotionPairs(queue, nodes, rules.pairMasks, rules.exclusions, rules.exclusionCount);
        return;
    }
    if (!s->same)
    {
        AddTransformedPairs(queue, nodes, FindClusterOverlaps(queue, nodes));
        return;
    }
    qcBvhBoxes boxes = qcTriangleBvh_Boxes(s->a, &s->a->fit);
    const qcPlaneTest planes = MakePlaneTest(queue, nodes.search);
    queue->end = s->job->kernels->collectPairs(&boxes, nodes.a, &boxes, nodes.b, rules.pairMasks, rules.exclusions,
                                               rules.exclusionCount, s->filters ? &planes : NULL, queue->end);
}
