// Refines the lists of cells to clusters, to boxes of triangles, then tests separating axes and classifies.
// Proof that no pair is lost: plugin/docs/proofs/layers_refine.md.
#include "cull/layers/cpu_refine.h"

#include "base/parallel_for.h"
#include "base/status.h"

enum
{
    // Entries: a block takes some 50 microseconds.
    qc_entryBlock = 64,
    qc_minBlocks = 4,
    qc_queueRoom = qc_queueFull + qc_nodeSize * qc_nodeSize
};

typedef struct Refining
{
    const qcCpuRefineJob* job;
    qcCpuRefine* memory;
    qcIndexedTriangles sides[2]; ///< the same
    qcDistanceThresholds bound;
    uint64_t trianglePairs;
} Refining;

/// Pairs that one worker has found and not yet filtered.
typedef struct Queue
{
    const Refining* r;
    qcSlotPair *pairs, *end;
    uint32_t worker;
    uint64_t count;
} Queue;

static uint32_t GlobalIndexOf(const qcCpuRefineJob* job, uint32_t triangleSlot)
{
    uint32_t slot, triangle = qcGpuResidency_TriangleAt(job->residency, triangleSlot, &slot);
    return qcStepTriangles_First(job->triangles, job->bodyOf[slot]) + triangle;
}

static void KeysOf(const void* context, const qcSlotPair* pairs, size_t count, uint64_t* keys)
{
    const Refining* r = context;
    for (size_t i = 0; i < count; i++)
        keys[i] = qcStepTriangles_Key(GlobalIndexOf(r->job, pairs[i].a), GlobalIndexOf(r->job, pairs[i].b));
}

static void Flush(Queue* queue)
{
    const Refining* r = queue->r;
    qcClassifiedPairs found = {.pairs = queue->pairs, .count = (size_t)(queue->end - queue->pairs)};
    queue->count += found.count;
    queue->end = queue->pairs;
    qcClassifiedPairs_Filter(&found, r->memory->kernels, r->sides, &r->bound, false);
    qcPairBuffer_Add(&QC_AT(qcPairBuffer, r->memory->buffers, queue->worker), &found, r->job->listClassified, KeysOf,
                     r);
}

/// Whether two bodies are tested, by the device's table: qcBodyPair_Classify without sets and without the step's
/// filter.
static bool AreTested(const qcLayersBody* a, const qcLayersBody* b)
{
    return ((a->flags | b->flags) & qc_layersIsMoving) != 0 && (a->group & b->mask) != 0 && (b->group & a->mask) != 0 &&
           (a->owner == 0 || a->owner != b->owner);
}

/// The pair masks of two leaf nodes of one body: pairs to test. Null: all.
static const uint64_t* PairMasksOf(const Refining* r, uint32_t slot, uint32_t a, uint32_t b)
{
    if (r->job->testNeighbours)
        return a == b ? qcPairMask_OfOneNode() : NULL;
    const qcBodyResidency* body = &QC_AT(qcBodyResidency, r->job->residency->bodies, slot);
    uint32_t link = qcClusters_FindLink(&body->clusters, a - body->firstNode, b - body->firstNode);
    return link != QC_NO_LINK ? qcClusters_PairMask(&body->clusters, link) : NULL;
}

/// Finds the pairs of two entries' nodes, which may be the same.
static void FindPairs(Queue* queue, const qcLayersEntry* p, const qcLayersEntry* q)
{
    const Refining* r = queue->r;
    const qcLayersBody* table = r->job->residency->table.data;
    const uint64_t* pairMasks = NULL;
    // Within one body, links lead from lower to higher nodes.
    uint32_t a = p->node < q->node ? p->node : q->node, b = p->node < q->node ? q->node : p->node;
    if (p->body == q->body)
        pairMasks = PairMasksOf(r, p->body, a, b);
    else if (!AreTested(&table[p->body], &table[q->body]))
        return;
    if (queue->end - queue->pairs >= qc_queueFull)
        Flush(queue);
    const qcBvhBoxes boxes = {r->job->image->clusterGroups, r->job->image->nodeGroups};
    queue->end = r->memory->kernels->collectPairs(&boxes, a, &boxes, b, pairMasks, NULL, 0, NULL, queue->end);
}

/// OVERLAP of common.glsl: no subtraction borrows from a top bit.
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

/// Finds the pairs of an entry's node with itself and with the nodes further on in the list.
static void FindPairsOfEntry(Queue* queue, const qcLayersEntry* entry)
{
    const Refining* r = queue->r;
    const qcLayersImage* image = r->job->image;
    const uint32_t* box = image->nodeBoxes[entry->node];
    bool hasSelfPairs = (QC_AT(qcLayersBody, r->job->residency->table, entry->body).flags & qc_layersMeetsItself) != 0;
    if (hasSelfPairs && FirstCommonCell(r, box, box) == entry->cell)
        FindPairs(queue, entry, entry);
    for (uint32_t next = entry->next; next != QC_NO_ENTRY; next = image->entries[next].next)
    {
        const qcLayersEntry* other = &image->entries[next];
        const uint32_t* otherBox = image->nodeBoxes[other->node];
        if (Overlap(box, otherBox) && (hasSelfPairs || entry->body != other->body) &&
            FirstCommonCell(r, box, otherBox) == entry->cell)
            FindPairs(queue, entry, other);
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
        FindPairsOfEntry(&queue, &image->entries[i]);
    Flush(&queue);
    __atomic_fetch_add(&r->trianglePairs, queue.count, __ATOMIC_RELAXED);
}

qcStatus qcCpuRefine_Run(const qcCpuRefineJob* job, qcCpuRefine* refine, const qcPairKeys* keys,
                         uint64_t* trianglePairs)
{
    if (refine->kernels == NULL)
        refine->kernels = qcTriangleKernels_Get();
    QC_TRY(qcPairBuffers_Begin(&refine->buffers, job->threads, job->triangles->maxPairs));
    QC_TRY(qcArray_Resize(&refine->queues, (size_t)job->threads * qc_queueRoom, sizeof(qcSlotPair), "pairs of slots"));
    Refining r = {
        .job = job,
        .memory = refine,
        .bound = {.pointError = job->pointError, .query = job->queryDistance, .near = job->margin, .far = job->margin}};
    r.sides[0] = r.sides[1] = (qcIndexedTriangles){job->residency->corners.data, job->image->vertices};
    size_t blocks = ((size_t)job->image->entryCount + qc_entryBlock - 1) / qc_entryBlock;
    qcParallel_For(job->threads, blocks, qc_minBlocks, TakeBlock, &r);
    *trianglePairs = r.trianglePairs;
    return qcPairBuffers_End(&refine->buffers, keys);
}

void qcCpuRefine_Free(qcCpuRefine* refine)
{
    qcArray_Free(&refine->queues);
    qcPairBuffers_Free(&refine->buffers);
}
