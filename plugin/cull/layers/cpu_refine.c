// Lists of cells, clusters, boxes of triangles, separating axes, sure hits.
//
// Why no pair is lost. Two nodes whose boxes overlap both have an entry in the cell of the greater of their lower ends:
// there, and in no other cell, the one that comes first in the list meets the other (gl/layers.c). A node meets itself
// in the cell of its lower ends. Boxes in groups are the levels of gl/layers.c without the diagonal: what is within
// reach overlaps. Tables leave out neighbours and nothing else. All vertices are in one frame, with one bound on their
// error: that the filter drops only what is farther apart, and that sure hits are some, is shown in
// kernels/separating_axis.inl.h. Empty boxes have the highest level as lower ends and 0 as upper ones, below all lower
// ends: they meet nothing.
#include "cull/layers/cpu_refine.h"

#include "base/parallel_for.h"
#include "base/status.h"

enum
{
    // Entries: a block takes some 50 microseconds.
    qc_entryBlock = 64,
    qc_leastBlocks = 4,
    qc_queueRoom = qc_queueFull + qc_nodeSize * qc_nodeSize
};

typedef struct Refining
{
    const qcLayersRefineJob* job;
    qcLayersRefine* memory;
    qcIndexedTriangles sides[2]; ///< the same
    qcDistanceThresholds bound;
    uint64_t trianglePairs;
} Refining;

/// What one worker has found and not yet given away.
typedef struct Queue
{
    const Refining* r;
    qcSlotPair *pairs, *end;
    uint32_t worker;
    uint64_t count;
} Queue;

static uint32_t RankOf(const qcLayersRefineJob* job, uint32_t place)
{
    uint32_t slot, triangle = qcLayersBodies_TriangleAt(job->bodies, place, &slot);
    return qcStepTriangles_First(job->triangles, job->numberOf[slot]) + triangle;
}

static uint64_t KeyOf(const void* context, qcSlotPair pair)
{
    const Refining* r = context;
    return qcStepTriangles_Key(RankOf(r->job, pair.a), RankOf(r->job, pair.b));
}

static void Flush(Queue* queue)
{
    const Refining* r = queue->r;
    qcClassifiedPairs found = {.pairs = queue->pairs, .count = (size_t)(queue->end - queue->pairs)};
    queue->count += found.count;
    queue->end = queue->pairs;
    qcClassifiedPairs_Filter(&found, r->memory->kernels, r->sides, &r->bound);
    qcPairBuffer_Add(&QC_AT(qcPairBuffer, r->memory->sinks, queue->worker), &found, r->job->listKnown, KeyOf, r);
}

static bool MayMeet(const qcLayersBody* a, const qcLayersBody* b)
{
    return ((a->flags | b->flags) & qc_layersIsMoving) != 0 && (a->group & b->mask) != 0 && (b->group & a->mask) != 0 &&
           (a->owner == 0 || a->owner != b->owner);
}

/// The pairs of two nodes of one body that the rules let meet, as in a table; null: all.
static const uint64_t* TableOf(const Refining* r, uint32_t slot, uint32_t a, uint32_t b)
{
    if (r->job->testNeighbours)
        return a == b ? qcPairMask_OfOneNode() : NULL;
    const qcLayersPlace* place = &QC_AT(qcLayersPlace, r->job->bodies->places, slot);
    uint32_t link = qcClusters_FindLink(&place->clusters, a - place->firstNode, b - place->firstNode);
    return link != QC_NO_LINK ? qcClusters_PairMask(&place->clusters, link) : NULL;
}

/// Entries of two nodes, or one and the same.
static void TakeNodes(Queue* queue, const qcLayersEntry* p, const qcLayersEntry* q)
{
    const Refining* r = queue->r;
    const qcLayersBody* bodies = r->job->bodies->bodies.data;
    const uint64_t* table = NULL;
    // Within one body, links lead from lower to higher places.
    uint32_t a = p->node < q->node ? p->node : q->node, b = p->node < q->node ? q->node : p->node;
    if (p->body == q->body)
        table = TableOf(r, p->body, a, b);
    else if (!MayMeet(&bodies[p->body], &bodies[q->body]))
        return;
    if (queue->end - queue->pairs >= qc_queueFull)
        Flush(queue);
    const qcBvhBoxes boxes = {r->job->image->clusterGroups, r->job->image->nodeGroups};
    queue->end = r->memory->kernels->collectPairs(&boxes, a, &boxes, b, table, NULL, 0, queue->end);
}

/// As OVERLAP in common.glsl: no subtraction borrows from a top bit.
static bool Overlap(const uint32_t p[4], const uint32_t q[4])
{
    const uint32_t guards = 0x80008000u;
    return ((p[2] - q[0]) & (q[2] - p[0]) & (p[3] - q[1]) & (q[3] - p[1]) & guards) == guards;
}

/// The cell of the greater of two boxes' lower ends.
static uint32_t FirstCommonCell(const Refining* r, const uint32_t p[4], const uint32_t q[4])
{
    const uint32_t ends[2][3] = {{p[0] & 0x7fffu, p[0] >> 16, p[1] & 0x7fffu},
                                 {q[0] & 0x7fffu, q[0] >> 16, q[1] & 0x7fffu}};
    uint32_t at[3];
    for (int i = 0; i < 3; i++)
        at[i] = (ends[0][i] > ends[1][i] ? ends[0][i] : ends[1][i]) >> (15 - r->job->cellsLog2[i]);
    return qcLayers_CellAt(at, r->job->cellsLog2);
}

/// The node of an entry with itself, and with those further on in the list.
static void TakeEntry(Queue* queue, const qcLayersEntry* entry)
{
    const Refining* r = queue->r;
    const qcLayersImage* image = r->job->image;
    const uint32_t* box = image->nodeBoxes[entry->node];
    bool meetsItself = (QC_AT(qcLayersBody, r->job->bodies->bodies, entry->body).flags & qc_layersMeetsItself) != 0;
    if (meetsItself && FirstCommonCell(r, box, box) == entry->cell)
        TakeNodes(queue, entry, entry);
    for (uint32_t next = entry->next; next != QC_NO_ENTRY; next = image->entries[next].next)
    {
        const qcLayersEntry* other = &image->entries[next];
        const uint32_t* otherBox = image->nodeBoxes[other->node];
        if (Overlap(box, otherBox) && (meetsItself || entry->body != other->body) &&
            FirstCommonCell(r, box, otherBox) == entry->cell)
            TakeNodes(queue, entry, other);
    }
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    Refining* r = context;
    const qcLayersImage* image = r->job->image;
    Queue queue = {.r = r, .worker = worker};
    queue.pairs = queue.end = &QC_AT(qcSlotPair, r->memory->queues, (size_t)worker * qc_queueRoom);
    size_t first = block * qc_entryBlock, left = image->entryCount - first;
    for (size_t i = first; i < first + (left < qc_entryBlock ? left : qc_entryBlock); i++)
        TakeEntry(&queue, &image->entries[i]);
    Flush(&queue);
    __atomic_fetch_add(&r->trianglePairs, queue.count, __ATOMIC_RELAXED);
}

qcStatus qcLayersRefine_Run(qcLayersRefine* refine, const qcLayersRefineJob* job, const qcPairKeys* keys,
                            uint64_t* trianglePairs)
{
    if (refine->kernels == NULL)
        refine->kernels = qcTriangleKernels_Get();
    QC_TRY(qcPairBuffers_Begin(&refine->sinks, job->threads));
    QC_TRY(qcArray_Resize(&refine->queues, (size_t)job->threads * qc_queueRoom, sizeof(qcSlotPair), "pairs of places"));
    Refining r = {
        .job = job,
        .memory = refine,
        .bound = {.pointError = job->pointError, .query = job->reach, .near = job->margin, .far = job->margin}};
    r.sides[0] = r.sides[1] = (qcIndexedTriangles){job->bodies->corners.data, job->image->vertices};
    size_t blocks = ((size_t)job->image->entryCount + qc_entryBlock - 1) / qc_entryBlock;
    qcParallel_For(job->threads, blocks, qc_leastBlocks, TakeBlock, &r);
    *trianglePairs = r.trianglePairs;
    return qcPairBuffers_End(&refine->sinks, keys);
}

void qcLayersRefine_Free(qcLayersRefine* refine)
{
    qcArray_Free(&refine->queues);
    qcPairBuffers_Free(&refine->sinks);
}
