// From the roots of two BVHs downwards: eight boxes against eight at a time, both BVHs at the same level, down to leaf
// nodes. (Simultaneous traversal: Brinkhoff, Kriegel, Seeger: Efficient Processing of Spatial Joins Using R-Trees,
// 1993.) Large triangles beside small ones: down the BVH of the latter, eight at a time. Proof that no pair is lost:
// plugin/docs/proofs/bvh_pairs.md.
#include "sweep/bvh/bvh_pairs.h"

#include "base/aabb.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/bvh_lattice.h"
#include "sweep/bvh/lattice_map.h"
#include "sweep/bvh/leaf_pairs.h"
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
    // A search of so many already takes memory for all threads: in a later step the same bodies may be searched by
    // them, and which step that is depends on measured times. Memory would grow in a scene at rest.
    qc_minThreadsMemory = 256,
    // Searches that are prepared together, in about ten microseconds, and the smallest number of blocks that is worth
    // waking a thread for.
    qc_searchBlock = 16,
    qc_minSearchBlocks = 8,
    // Clusters of a BVH that exceeds the cache next to a core: 1.5 MB. A dragon of 871 K triangles takes 5 % less with
    // prefetches, a cloth of 20 K 2 % more.
    qc_minPrefetched = 16384,
    // Triangles are large if they are this many times as large as the others, so that one is beside many of these.
    qc_largeSize = 4,
    qc_queueRoom = qc_queueFull + qc_maxCollected
};

/// Bits i + 8 j with i <= j.
static const uint64_t s_inOrder = UINT64_C(0xff7f3f1f0f070301);

/// Eight boxes of a node at the start and at the end, in the reference lattices; transformed ones are put into `own`.
static void GetMotionBoxes(const qcBvhSearch* s, const qcMotionBvh* motion, const qcTriangleBvh* bvh,
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

static uint64_t FindMotionOverlaps(const qcBvhSearch* s, uint32_t levelA, uint32_t levelB, qcNodePair nodes)
{
    qcBox8 ownA[2], ownB[2];
    const qcBox8 *a[2], *b[2];
    GetMotionBoxes(s, &s->motion[0], s->a, qcTriangleBvh_StartFit(s->a, s->job->bodyA), levelA, nodes.a, ownA, a);
    GetMotionBoxes(s, &s->motion[1], s->b, qcTriangleBvh_StartFit(s->b, s->job->bodyB), levelB, nodes.b, ownB, b);
    uint64_t overlaps = s->job->kernels->findMotionOverlaps(a, b);
    return s->same && nodes.a == nodes.b ? overlaps & s_inOrder : overlaps;
}

/// The overlapping children of two nodes: bit i + 8 j.
static uint64_t FindOverlaps(const qcBvhSearch* s, uint32_t levelA, uint32_t levelB, qcNodePair nodes)
{
    if (s->motion != NULL)
        return FindMotionOverlaps(s, levelA, levelB, nodes);
    const qcBox8* a = qcTriangleBvh_Box8At(s->a, &s->a->fit, levelA, nodes.a);
    const qcBox8* b = qcTriangleBvh_Box8At(s->b, &s->b->fit, levelB, nodes.b);
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

static qcNodePair ChildAt(qcNodePair nodes, uint32_t bit)
{
    return (qcNodePair){nodes.search, nodes.a * qc_boxLanes + bit % qc_boxLanes,
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

static void PrefetchChildren(const qcBvhSearch* s, qcNodePair nodes, uint64_t overlaps)
{
    for (uint32_t i = 0; i < qc_boxLanes; i++)
    {
        if ((overlaps >> i & UINT64_C(0x0101010101010101)) != 0)
            Prefetch(s->a, nodes.a * qc_boxLanes + i);
        if ((overlaps >> qc_boxLanes * i & 0xffu) != 0 && (nodes.a != nodes.b || !s->same))
            Prefetch(s->b, nodes.b * qc_boxLanes + i);
    }
}

static void Descend(qcPairQueue* queue, uint32_t level, qcNodePair nodes)
{
    if (level == 1)
    {
        qcPairQueue_AddNodes(queue, nodes);
        return;
    }
    uint64_t overlaps = FindOverlaps(queue->search, level, level, nodes);
    if (level == 2 && queue->search->a->box8Count[0] > qc_minPrefetched)
        PrefetchChildren(queue->search, nodes, overlaps);
    for (; overlaps != 0 && queue->isOpen; overlaps &= overlaps - 1)
        Descend(queue, level - 1, ChildAt(nodes, (uint32_t)__builtin_ctzll(overlaps)));
}

//  ---- large triangles beside small ones ---------------------------------------------------------------

static const qcTriangleBvh* BvhOf(const qcBvhSearch* s, int side)
{
    return side == 0 ? s->a : s->b;
}

static uint32_t* NodeOf(qcNodePair* nodes, int side)
{
    return side == 0 ? &nodes->a : &nodes->b;
}

/// The boxes of a cluster's triangles: over a motion at both ends in the reference lattices, else in the lattice of
/// their own BVH. In that of the other one, which may be turned, those of a floor would be as high as the floor is
/// wide.
typedef struct LargeTriangles
{
    const qcBox8* boxes[2];
    qcBox8 own[2];
} LargeTriangles;

static void FindLargeTriangles(const qcBvhSearch* s, qcNodePair nodes, LargeTriangles* large)
{
    const qcTriangleBvh* bvh = BvhOf(s, s->large);
    uint32_t cluster = *NodeOf(&nodes, s->large);
    large->boxes[0] = &qcTriangleBvh_Boxes(bvh, &bvh->fit).clusters[cluster];
    for (int t = 0; t < 2 && s->motion != NULL; t++)
    {
        const qcMotionBvh* motion = &s->motion[s->large];
        large->boxes[t] = &motion->at[t].boxes.clusters[cluster];
        if (!motion->isTransformed)
            continue;
        s->job->kernels->transformTriangles(&motion->at[t], cluster, &large->own[t]);
        large->boxes[t] = &large->own[t];
    }
}

/// The children of the other BVH's node that one of the triangles overlaps: bit i.
static uint32_t FindChildrenBeside(const qcBvhSearch* s, uint32_t level, qcNodePair nodes, const LargeTriangles* large)
{
    const qcTriangleKernels* kernels = s->job->kernels;
    const int small = 1 - s->large;
    const qcTriangleBvh* bvh = BvhOf(s, small);
    uint32_t node = *NodeOf(&nodes, small);
    qcBox8 own[2];
    uint64_t overlaps;
    if (s->motion != NULL)
    {
        const qcBox8* boxes[2];
        const qcBody* body = small == 0 ? s->job->bodyA : s->job->bodyB;
        GetMotionBoxes(s, &s->motion[small], bvh, qcTriangleBvh_StartFit(bvh, body), level, node, own, boxes);
        overlaps = kernels->findMotionOverlaps(boxes, large->boxes);
    }
    else
    {
        kernels->transformBoxes(qcTriangleBvh_Box8At(bvh, &bvh->fit, level, node),
                                small == 0 ? &s->reverse : &s->transformed.levels, &own[0]);
        overlaps = kernels->findOverlaps(&own[0], large->boxes[0]);
    }
    return qcPairMask_FirstOfWord(overlaps);
}

static qcNodePair ChildBeside(const qcBvhSearch* s, qcNodePair nodes, uint32_t bit)
{
    uint32_t* node = NodeOf(&nodes, 1 - s->large);
    *node = *node * qc_boxLanes + bit;
    return nodes;
}

/// The leaf nodes of a pair at level 1.
static qcNodePair LeafNodes(const qcBvhSearch* s, qcNodePair nodes)
{
    if (s->hasLarge)
        *NodeOf(&nodes, s->large) /= qc_boxLanes;
    return nodes;
}

static void DescendBeside(qcPairQueue* queue, uint32_t level, qcNodePair nodes, const LargeTriangles* large)
{
    const qcBvhSearch* s = queue->search;
    uint32_t children = FindChildrenBeside(s, level, nodes, large);
    if (level == 1 && children != 0)
    {
        unsigned cluster = 1u << *NodeOf(&nodes, s->large) % qc_boxLanes;
        qcPairQueue_AddClusters(queue, LeafNodes(s, nodes),
                                s->large == 0 ? qcPairMask_Product(cluster, children)
                                              : qcPairMask_Product(children, cluster));
    }
    for (; level > 1 && children != 0 && queue->isOpen; children &= children - 1)
        DescendBeside(queue, level - 1, ChildBeside(s, nodes, (uint32_t)__builtin_ctz(children)), large);
}

//  ---- two bodies ------------------------------------------------------------------------------------

/// The size of a body, without its outliers.
static double SizeOfBody(const qcTriangleBvh* bvh, const qcBody* body)
{
    const double* extent = bvh->fit.latticeExtent;
    return bvh->fit.lattice.hasOutliers ? fmax(extent[0], fmax(extent[1], extent[2]))
                                        : qcBounds_Widest(body->lower, body->upper);
}

/// 0 if the triangles of a are several times as large as those of b, 1 if those of b are, else -1. An estimate, for
/// bodies as wide as long.
static int FindLargeBody(const qcBvhOfBody* a, const qcBvhOfBody* b)
{
    double sizeA = SizeOfBody(a->bvh, a->body), sizeB = SizeOfBody(b->bvh, b->body);
    // Squares of sizes, times both counts of triangles.
    double squareA = sizeA * sizeA * b->body->triangleCount, squareB = sizeB * sizeB * a->body->triangleCount;
    const double ratio = qc_largeSize * qc_largeSize;
    return squareA > ratio * squareB ? 0 : squareB > ratio * squareA ? 1 : -1;
}

/// True if the levels of a lattice around one body are smaller than the other's triangles.
static bool IsLatticeFine(const qcBvhOfBody* body, const qcBvhOfBody* other)
{
    double triangle = SizeOfBody(other->bvh, other->body) / sqrt((double)other->body->triangleCount);
    return SizeOfBody(body->bvh, body->body) < qc_lastLevel * triangle;
}

bool qcBvhPairs_AreInOrder(const qcBodyBvh* a, const qcBody* bodyA, const qcBodyBvh* b, const qcBody* bodyB)
{
    if (a->bvh.fit.isLocal != b->bvh.fit.isLocal)
        return !a->bvh.fit.isLocal;
    const qcBvhOfBody ofA = {&a->bvh, bodyA}, ofB = {&b->bvh, bodyB};
    int large = FindLargeBody(&ofA, &ofB);
    if (large < 0)
        return true;
    bool isFirst = !a->bvh.fit.isLocal || (large == 0 ? IsLatticeFine(&ofA, &ofB) : IsLatticeFine(&ofB, &ofA));
    return isFirst == (large == 0);
}

/// Finds the BVH with large triangles, if there is one. For those of b the lattice of b has to be known.
static void FindLarge(qcBvhSearch* s)
{
    const qcBvhOfBody a = {s->a, s->job->bodyA}, b = {s->b, s->job->bodyB};
    int large = FindLargeBody(&a, &b);
    if (large < 0 || (large == 1 && !s->b->fit.isLocal))
        return;
    s->large = large;
    s->hasLarge = BvhOf(s, 1 - large)->clusters.nodeCount > 1 && !BvhOf(s, large)->fit.isOutline;
}

/// `isTo`: others are transformed to its coordinates.
static qcRigidTransform TransformOf(const qcTriangleBvh* bvh, const qcBody* body, bool isTo)
{
    qcRigidTransform t = {.transform = bvh->fit.isLocal ? body->transform : qcIdentityTransform()};
    memcpy(t.lower, bvh->fit.isLocal ? body->localLower : body->lower, sizeof t.lower);
    memcpy(t.upper, bvh->fit.isLocal ? body->localUpper : body->upper, sizeof t.upper);
    // World coordinates aren't rounded, and errors of outliers are larger in proportion.
    if (bvh->fit.lattice.hasOutliers && !(isTo && bvh->fit.isLocal))
        qcBvhLattice_GetBox(&bvh->fit.lattice, t.lower, t.upper);
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
                                       .hasOutliers = bvh->fit.lattice.hasOutliers,
                                       .query = qcTriangleBvh_DistanceInFrame(bvh, query)};
    // For bodies in the world: in their frames lengths are those of the world, scaled.
    SetNear(&thresholds, near * bvh->fit.lattice.unit[0], 1.0, 1.0);
    return thresholds;
}

/// From the lattice of a to that of b, for boxes.
static void FindReverse(qcBvhSearch* s)
{
    qcRigidTransform transformA = TransformOf(s->a, s->job->bodyA, false),
                     transformB = TransformOf(s->b, s->job->bodyB, true);
    qcRelativeTransform r = qcRelativeTransform_Find(&transformB, &transformA);
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

static void FindTransforms(qcBvhSearch* s)
{
    qcRigidTransform transformA = TransformOf(s->a, s->job->bodyA, true),
                     transformB = TransformOf(s->b, s->job->bodyB, false);
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
        FindReverse(s);
    s->transformed.boxes = qcTriangleBvh_Boxes(s->b, &s->b->fit);
    s->transformed.triangles = s->sides[1];
}

static void Prepare(qcBvhSearch* s, const qcBvhPairsJob* job, qcMotionBvh* motion)
{
    *s = (qcBvhSearch){.job = job,
                       .a = &job->a->bvh,
                       .b = &job->b->bvh,
                       .same = job->a == job->b,
                       .filters = true,
                       .motion = job->motion ? motion : NULL};
    if (!s->same)
        FindLarge(s);
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

static qcBvhSearch* SearchAt(const Run* run, size_t i)
{
    return &QC_AT(qcBvhSearch, run->memory->searches, i);
}

static void PrepareBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Run* run = context;
    for (size_t i = block * qc_searchBlock; i < run->jobCount && i < (block + 1) * qc_searchBlock; i++)
        Prepare(SearchAt(run, i), &run->jobs[i],
                run->memory->motions.count != 0 ? &QC_AT(qcMotionBvh, run->memory->motions, 2 * i) : NULL);
}

/// Appends the children of two nodes at these levels.
static qcStatus AppendChildren(qcArray* nodePairs, const qcBvhSearch* s, uint32_t levelA, uint32_t levelB,
                               qcNodePair nodes)
{
    QC_TRY(qcArray_Reserve(nodePairs, nodePairs->count + 64, sizeof(qcNodePair), "pairs of nodes"));
    for (uint64_t overlaps = FindOverlaps(s, levelA, levelB, nodes); overlaps != 0; overlaps &= overlaps - 1)
        QC_AT(qcNodePair, *nodePairs, nodePairs->count++) = ChildAt(nodes, (uint32_t)__builtin_ctzll(overlaps));
    return qc_statusOk;
}

/// Appends the children of a node beside a cluster of large triangles.
static qcStatus AppendChildrenBeside(qcArray* nodePairs, const qcBvhSearch* s, uint32_t level, qcNodePair nodes)
{
    QC_TRY(qcArray_Reserve(nodePairs, nodePairs->count + qc_boxLanes, sizeof(qcNodePair), "pairs of nodes"));
    LargeTriangles large;
    FindLargeTriangles(s, nodes, &large);
    for (uint32_t children = FindChildrenBeside(s, level, nodes, &large); children != 0; children &= children - 1)
        QC_AT(qcNodePair, *nodePairs, nodePairs->count++) = ChildBeside(s, nodes, (uint32_t)__builtin_ctz(children));
    return qc_statusOk;
}

/// Removes the pairs of nodes from `first` to `end`.
static void RemoveNodePairs(qcArray* nodePairs, size_t first, size_t end)
{
    size_t count = nodePairs->count - end;
    memmove(&QC_AT(qcNodePair, *nodePairs, first), &QC_AT(qcNodePair, *nodePairs, end), count * sizeof(qcNodePair));
    nodePairs->count = first + count;
}

/// Replaces the roots, at `first`, by each cluster of large triangles that overlaps the other root, and that root.
static qcStatus ReplaceByClusters(qcArray* nodePairs, size_t first, const qcBvhSearch* s)
{
    for (uint32_t level = BvhOf(s, s->large)->levels - 1; level > 0; level--)
    {
        size_t end = nodePairs->count;
        for (size_t i = first; i < end; i++)
            QC_TRY(AppendChildren(nodePairs, s, s->large == 0 ? level : UINT32_MAX, s->large == 0 ? UINT32_MAX : level,
                                  QC_AT(qcNodePair, *nodePairs, i)));
        RemoveNodePairs(nodePairs, first, end);
    }
    return qc_statusOk;
}

/// Appends the pairs from which the search goes down.
static qcStatus AppendRoots(qcArray* nodePairs, qcBvhSearch* s, uint32_t number)
{
    size_t first = nodePairs->count;
    const qcNodePair roots = {number, 0, 0};
    QC_TRY(qcArray_Resize(nodePairs, first + 1, sizeof(qcNodePair), "pairs of nodes"));
    QC_AT(qcNodePair, *nodePairs, first) = roots;
    s->level = s->a->levels > s->b->levels ? s->a->levels : s->b->levels;
    if (!s->hasLarge)
        return qc_statusOk;
    QC_TRY(ReplaceByClusters(nodePairs, first, s));
    const qcTriangleBvh* small = BvhOf(s, 1 - s->large);
    if (nodePairs->count - first <= small->clusters.nodeCount)
    {
        s->level = small->levels - 1;
        return qc_statusOk;
    }
    // There are small triangles among the large ones.
    s->hasLarge = false;
    nodePairs->count = first + 1;
    QC_AT(qcNodePair, *nodePairs, first) = roots;
    return qc_statusOk;
}

/// From the roots down, level by level, until there are `enough` pairs of nodes.
static qcStatus FindNodePairs(qcArray* nodePairs, qcBvhSearch* s, uint32_t number, size_t enough)
{
    size_t first = nodePairs->count;
    QC_TRY(AppendRoots(nodePairs, s, number));
    for (; s->level > 1 && nodePairs->count > first && nodePairs->count - first < enough; s->level--)
    {
        size_t end = nodePairs->count;
        for (size_t i = first; i < end; i++)
        {
            qcNodePair nodes = QC_AT(qcNodePair, *nodePairs, i);
            QC_TRY(s->hasLarge ? AppendChildrenBeside(nodePairs, s, s->level, nodes)
                               : AppendChildren(nodePairs, s, s->level, s->level, nodes));
        }
        RemoveNodePairs(nodePairs, first, end);
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
            qcBvhPairsJob_MarkVisited(job, LeafNodes(SearchAt(run, i), QC_AT(qcNodePair, *nodePairs, k)));
    }
    return qc_statusOk;
}

static void SearchTask(void* context, size_t task, uint32_t worker)
{
    const Run* run = context;
    const qcArray* nodePairs = &run->memory->nodePairs;
    qcPairQueue queue = {.transformedKey = UINT64_MAX, .worker = worker, .isOpen = true};
    queue.planes = &QC_AT(qcPlaneCache, run->memory->planes, worker);
    memset(queue.planes->keys, 0xff, sizeof queue.planes->keys);
    memset(queue.planes->boxKeys, 0xff, sizeof queue.planes->boxKeys);
    queue.pairs = queue.end = &QC_AT(qcSlotPair, run->memory->queues, (size_t)worker * qc_queueRoom);
    size_t first = task * run->share, left = nodePairs->count - first,
           end = first + (left < run->share ? left : run->share);
    for (size_t k = first; k < end && queue.isOpen; k++)
    {
        qcNodePair nodes = QC_AT(qcNodePair, *nodePairs, k);
        const qcBvhSearch* search = SearchAt(run, nodes.search);
        if (queue.search != NULL && queue.search != search)
            qcPairQueue_Flush(&queue);
        queue.search = search;
        if (search->hasLarge)
        {
            LargeTriangles large;
            FindLargeTriangles(search, nodes, &large);
            DescendBeside(&queue, search->level, nodes, &large);
        }
        else
            Descend(&queue, search->level, nodes);
    }
    qcPairQueue_Flush(&queue);
}

/// Few clusters stay on one thread.
static uint32_t ThreadsFor(double clusters, uint32_t threads)
{
    return clusters < qc_minClusters ? 1 : threads;
}

qcStatus qcBvhPairs_Begin(qcBvhPairs* pairs, const qcBvhPairsJob* jobs, size_t jobCount, uint32_t threads)
{
    Run run = {.memory = pairs, .jobs = jobs, .jobCount = jobCount};
    QC_TRY(qcArray_Resize(&pairs->searches, jobCount, sizeof(qcBvhSearch), "searches of BVHs"));
    bool isMotion = jobCount != 0 && jobs[0].motion;
    QC_TRY(qcArray_Resize(&pairs->motions, isMotion ? 2 * jobCount : 0, sizeof(qcMotionBvh), "searches of BVHs"));
    double clusters = SizeOfAll(&run);
    size_t room = clusters < qc_minThreadsMemory ? 1 : threads;
    QC_TRY(qcArray_Resize(&pairs->queues, room * qc_queueRoom, sizeof(qcSlotPair), "pairs of slots"));
    QC_TRY(qcArray_Resize(&pairs->planes, room, sizeof(qcPlaneCache), "planes of clusters"));
    qcParallel_For(threads, (jobCount + qc_searchBlock - 1) / qc_searchBlock, qc_minSearchBlocks, PrepareBlock, &run);
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
