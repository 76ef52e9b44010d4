// Grows patches triangle by triangle: over one edge of the loop to a vertex outside of the patch, or into a notch, over
// two successive edges of the loop. Either way the patch stays a disc with one loop around it.
#include "mesh/flat_patches.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "base/worker_results.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_seeds = 4,
    // A patch with fewer triangles of each of its nodes excludes too few pairs to be worth its test.
    qc_minShare = qc_nodeSize / 2,
    // Notches don't shorten a loop so much that a longer one could be kept: it runs around a fan of many triangles.
    qc_maxGrowingLoop = 8 * qc_maxLoop
};

#define QC_INSIDE UINT32_MAX

/// The state of a vertex during the growth of patches.
typedef struct PatchVertex
{
    uint32_t patch; ///< the last patch that has it
    uint32_t next;  ///< on the loop, or QC_INSIDE
    uint32_t block; ///< the last patch with it in its block, the nodes that the patch is grown around
} PatchVertex;

/// The growth of the patches of one size.
typedef struct qcPatchBuilder
{
    qcFlatPatches* patches;
    qcPatchSource source;
    uint32_t size;
    qcWorkerResult result;
    qcArray slots, loops; ///< of these patches, as in qcFlatPatches
    qcArray patchOf;      ///< uint32_t by slot: the last patch that has the triangle
    qcArray vertices;     ///< of PatchVertex
    qcArray queue;        ///< uint32_t: slots of triangles that may join
    qcArray masks;        ///< uint64_t by node: its triangles in the patch
    //  the patch that grows, its number from 1 on
    uint32_t patch, firstNode, endNode;
    uint32_t start;               ///< a vertex of the loop
    uint32_t loopCount;           ///< vertices of the loop
    uint32_t beginNode, stopNode; ///< whose patches are made in this part
} Builder;

static void Free(Builder* b)
{
    qcArray* arrays[] = {&b->slots, &b->loops, &b->patchOf, &b->vertices, &b->queue, &b->masks};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}

static bool HasTriangle(const Builder* b, size_t slot)
{
    return QC_AT(uint32_t, b->source.clusters->triangles, slot) != QC_NO_TRIANGLE;
}

//  ---- growth --------------------------------------------------------------------------------------

static PatchVertex* VertexAt(const Builder* b, uint32_t vertex)
{
    return &QC_AT(PatchVertex, b->vertices, vertex);
}

static bool IsInPatch(const Builder* b, uint32_t slot)
{
    return slot != QC_NO_SLOT && QC_AT(uint32_t, b->patchOf, slot) == b->patch;
}

static void Begin(Builder* b, uint32_t seed)
{
    const uint32_t* v = b->source.corners[seed].vertex;
    for (int c = 0; c < 3; c++)
    {
        VertexAt(b, v[c])->patch = b->patch;
        VertexAt(b, v[c])->next = v[(c + 1) % 3];
    }
    b->start = v[0];
    b->loopCount = 3;
}

/// Adds a triangle to the patch and updates the loop. False: the result would not be a disc with one loop, or the
/// triangle is no notch and `notchesOnly` is set.
static bool Join(Builder* b, uint32_t slot, bool notchesOnly)
{
    const uint32_t *v = b->source.corners[slot].vertex,
                   *across = &QC_AT(uint32_t, b->source.adjacency->across, 3 * (size_t)slot);
    bool shared[3];
    int count = 0;
    for (int c = 0; c < 3; c++)
        count += shared[c] = IsInPatch(b, across[c]);
    if (count == 1 && !notchesOnly)
    {
        int c = shared[0] ? 0 : shared[1] ? 1 : 2;
        // The loop has the edge in the other direction.
        uint32_t from = v[(c + 1) % 3], to = v[c], apex = v[(c + 2) % 3];
        if (VertexAt(b, apex)->patch == b->patch || VertexAt(b, from)->next != to)
            return false;
        *VertexAt(b, apex) = (PatchVertex){b->patch, to, VertexAt(b, apex)->block};
        VertexAt(b, from)->next = apex;
        b->loopCount++;
        return true;
    }
    if (count == 2)
    {
        int c = !shared[0] ? 0 : !shared[1] ? 1 : 2;
        uint32_t from = v[c], to = v[(c + 1) % 3], notch = v[(c + 2) % 3];
        if (VertexAt(b, from)->next != notch || VertexAt(b, notch)->next != to || VertexAt(b, to)->next == from)
            return false;
        VertexAt(b, from)->next = to;
        VertexAt(b, notch)->next = QC_INSIDE;
        b->start = from;
        b->loopCount--;
        return true;
    }
    return false;
}

static bool IsInBlock(const Builder* b, uint32_t slot)
{
    uint32_t node = slot / qc_nodeSize;
    return node >= b->firstNode && node < b->endNode;
}

/// True for triangles that share a vertex with the block.
static bool TouchesBlock(const Builder* b, uint32_t slot)
{
    const uint32_t* v = b->source.corners[slot].vertex;
    return VertexAt(b, v[0])->block == b->patch || VertexAt(b, v[1])->block == b->patch ||
           VertexAt(b, v[2])->block == b->patch;
}

/// Queues the triangles across the edges of a triangle.
static qcStatus PushAcross(Builder* b, uint32_t slot)
{
    QC_TRY(qcArray_Reserve(&b->queue, b->queue.count + 3, sizeof(uint32_t), "flat patches"));
    for (size_t c = 0; c < 3; c++)
    {
        uint32_t other = QC_AT(uint32_t, b->source.adjacency->across, 3 * (size_t)slot + c);
        if (other != QC_NO_SLOT && !IsInPatch(b, other))
            QC_AT(uint32_t, b->queue, b->queue.count++) = other;
    }
    return qc_statusOk;
}

static qcStatus Add(Builder* b, uint32_t slot)
{
    qcArray* slots = &b->slots;
    QC_TRY(qcArray_Reserve(slots, slots->count + 1, sizeof(uint32_t), "flat patches"));
    QC_AT(uint32_t, *slots, slots->count++) = slot;
    QC_AT(uint32_t, b->patchOf, slot) = b->patch;
    return PushAcross(b, slot);
}

typedef enum Phase
{
    phase_block,   ///< triangles of the block
    phase_ring,    ///< and those that share a vertex with it
    phase_notches, ///< notches anywhere: the flatness test of a smooth loop is faster
    phase_end
} Phase;

/// Grows from a seed, breadth first, so that the patch stays round. A patch whose loop gets too long is not completed.
static qcStatus Grow(Builder* b, uint32_t seed, qcFlatPatch* patch)
{
    patch->firstSlot = (uint32_t)b->slots.count;
    b->queue.count = 0;
    Begin(b, seed);
    QC_TRY(Add(b, seed));
    for (Phase phase = phase_block; phase < phase_end; phase++)
    {
        size_t refused = 0;
        for (size_t at = 0; at < b->queue.count && b->loopCount <= qc_maxGrowingLoop; at++)
        {
            uint32_t slot = QC_AT(uint32_t, b->queue, at);
            if (IsInPatch(b, slot))
                continue;
            bool allowed =
                phase == phase_notches || IsInBlock(b, slot) || (phase == phase_ring && TouchesBlock(b, slot));
            if (allowed && Join(b, slot, phase == phase_notches))
                QC_TRY(Add(b, slot));
            else
                QC_AT(uint32_t, b->queue, refused++) = slot;
        }
        // The next phase may accept them.
        b->queue.count = refused;
    }
    patch->slotCount = (uint32_t)(b->slots.count - patch->firstSlot);
    return qc_statusOk;
}

/// Sets the masks of the patch by node. Returns the count of its triangles in the block.
static uint32_t FillMasks(Builder* b, const qcFlatPatch* patch)
{
    uint64_t* masks = b->masks.data;
    uint32_t ownCount = 0;
    const uint32_t* slots = &QC_AT(uint32_t, b->slots, patch->firstSlot);
    for (uint32_t i = 0; i < patch->slotCount; i++)
        masks[slots[i] / qc_nodeSize] = 0;
    for (uint32_t i = 0; i < patch->slotCount; i++)
    {
        masks[slots[i] / qc_nodeSize] |= UINT64_C(1) << slots[i] % qc_nodeSize;
        ownCount += IsInBlock(b, slots[i]);
    }
    return ownCount;
}

static qcStatus StoreLoop(Builder* b, qcFlatPatch* patch)
{
    qcArray* loops = &b->loops;
    patch->firstLoop = (uint32_t)loops->count;
    patch->loopCount = b->loopCount;
    QC_TRY(qcArray_Reserve(loops, loops->count + patch->loopCount, sizeof(uint32_t), "flat patches"));
    uint32_t v = b->start;
    for (uint32_t i = 0; i < patch->loopCount; i++, v = VertexAt(b, v)->next)
        QC_AT(uint32_t, *loops, loops->count++) = v;
    return qc_statusOk;
}

/// Writes the patch's masks to the links between its block and the nodes around.
static void FillLinks(const Builder* b, const qcFlatPatch* patch)
{
    const qcClusters* c = b->source.clusters;
    const uint32_t *firstLink = c->firstLink.data, *slots = &QC_AT(uint32_t, b->slots, patch->firstSlot);
    const qcLeafLink* links = c->links.data;
    const uint64_t* masks = b->masks.data;
    qcPatchLink* patchLinks = b->patches->links.data;
    for (uint32_t node = b->firstNode; node < b->endNode; node++)
    {
        QC_AT(uint64_t, b->patches->own, qc_patchSizes * (size_t)node + b->size) = masks[node];
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            patchLinks[l].ofNode[b->size] = masks[links[l].other];
    }
    for (uint32_t i = 0; i < patch->slotCount; i++)
    {
        uint32_t node = slots[i] / qc_nodeSize;
        // Each node once: at the first of its triangles.
        if ((masks[node] & (0 - masks[node])) != UINT64_C(1) << slots[i] % qc_nodeSize)
            continue;
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            if (links[l].other >= b->firstNode && links[l].other < b->endNode)
                patchLinks[l].ofOther[b->size] = masks[node];
    }
}

/// Marks the vertices of the block, and clears the masks that FillLinks reads.
static void MarkBlock(Builder* b)
{
    const uint32_t* firstLink = b->source.clusters->firstLink.data;
    const qcLeafLink* links = b->source.clusters->links.data;
    uint64_t* masks = b->masks.data;
    for (size_t p = (size_t)b->firstNode * qc_nodeSize; p < (size_t)b->endNode * qc_nodeSize; p++)
        for (int c = 0; c < 3 && HasTriangle(b, p); c++)
            VertexAt(b, b->source.corners[p].vertex[c])->block = b->patch;
    for (uint32_t node = b->firstNode; node < b->endNode; node++)
    {
        masks[node] = 0;
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            masks[links[l].other] = 0;
    }
}

static qcStatus GrowAround(Builder* b, uint32_t patch, uint32_t firstNode, uint32_t nodeCount)
{
    qcFlatPatches* patches = b->patches;
    qcFlatPatch* made = &QC_AT(qcFlatPatch, patches->patches, patch);
    b->firstNode = firstNode;
    b->endNode = firstNode + nodeCount;
    uint32_t step = nodeCount * qc_nodeSize / qc_seeds, best = 0;
    for (uint32_t i = 0; i < qc_seeds && best == 0; i++)
    {
        uint32_t seed = firstNode * qc_nodeSize + (i + qc_seeds / 2) % qc_seeds * step;
        if (!HasTriangle(b, seed))
            continue;
        b->patch++;
        MarkBlock(b);
        QC_TRY(Grow(b, seed, made));
        best = FillMasks(b, made);
        if (best < nodeCount * qc_minShare || b->loopCount > qc_maxLoop)
        {
            b->slots.count = made->firstSlot;
            *made = (qcFlatPatch){0};
            best = 0;
            continue;
        }
        QC_TRY(StoreLoop(b, made));
        FillLinks(b, made);
    }
    return qc_statusOk;
}

static qcStatus Reserve(Builder* b, const qcPatchSource* source)
{
    size_t slots = source->clusters->triangles.count;
    QC_TRY(qcArray_GrowZeroed(&b->patchOf, slots, sizeof(uint32_t), "flat patches"));
    QC_TRY(qcArray_GrowZeroed(&b->vertices, source->vertexCount, sizeof(PatchVertex), "flat patches"));
    return qcArray_Resize(&b->masks, source->clusters->nodeCount, sizeof(uint64_t), "flat patches");
}

static qcStatus GrowPart(Builder* b)
{
    uint32_t nodes = b->patches->nodeCount, block = b->size == 0 ? 1 : qc_patchNodes;
    for (uint32_t first = b->beginNode; first < b->stopNode; first += block)
        QC_TRY(GrowAround(b, (b->size == 0 ? 0 : nodes) + first / block, first,
                          nodes - first < block ? nodes - first : block));
    return qc_statusOk;
}

static void GrowSize(void* context, size_t size, uint32_t worker)
{
    (void)worker;
    Builder* builder = (Builder*)context + size;
    (void)qcWorkerResult_Add(&builder->result, GrowPart(builder));
}

/// Appends the slots and loops of the patches of one size.
static qcStatus AddSize(qcFlatPatches* patches, const Builder* b)
{
    QC_TRY(qcWorkerResult_Check(&b->result));
    size_t first = b->size == 0 ? 0 : patches->nodeCount,
           end = b->size == 0 ? patches->nodeCount : patches->patches.count;
    for (size_t i = first; i < end; i++)
    {
        QC_AT(qcFlatPatch, patches->patches, i).firstSlot += (uint32_t)patches->slots.count;
        QC_AT(qcFlatPatch, patches->patches, i).firstLoop += (uint32_t)patches->loops.count;
    }
    QC_TRY(qcArray_Append(&patches->slots, &b->slots, sizeof(uint32_t), "flat patches"));
    return qcArray_Append(&patches->loops, &b->loops, sizeof(uint32_t), "flat patches");
}

qcStatus qcFlatPatches_Begin(qcFlatPatches* patches, qcPatchGrowth* growth, const qcPatchSource* source)
{
    uint32_t nodes = source->clusters->nodeCount, large = (nodes + qc_patchNodes - 1) / qc_patchNodes;
    *patches = (qcFlatPatches){.nodeCount = nodes};
    *growth = (qcPatchGrowth){.builders = qcAllocateZeroed(qc_patchSizes * sizeof(Builder))};
    if (growth->builders == NULL)
        return qcFailMemory(qc_patchSizes * sizeof(Builder), "flat patches");
    QC_TRY(qcArray_GrowZeroed(&patches->patches, (size_t)nodes + large, sizeof(qcFlatPatch), "flat patches"));
    QC_TRY(qcArray_GrowZeroed(&patches->own, qc_patchSizes * (size_t)nodes, sizeof(uint64_t), "flat patches"));
    QC_TRY(qcArray_GrowZeroed(&patches->links, source->clusters->links.count, sizeof(qcPatchLink), "flat patches"));
    for (uint32_t size = 0; size < qc_patchSizes; size++)
        QC_TRY(Reserve(&growth->builders[size], source));
    return qc_statusOk;
}

qcStatus qcFlatPatches_Grow(qcFlatPatches* patches, qcPatchGrowth* growth, const qcPatchSource* source,
                            uint32_t nodeCount, uint32_t threads)
{
    uint32_t left = patches->nodeCount - growth->nextNode;
    uint32_t count = nodeCount < left ? (nodeCount + qc_patchNodes - 1) / qc_patchNodes * qc_patchNodes : left;
    uint32_t end = growth->nextNode + (count < left ? count : left);
    for (uint32_t size = 0; size < qc_patchSizes; size++)
    {
        Builder* b = &growth->builders[size];
        b->patches = patches;
        b->source = *source;
        b->size = size;
        b->beginNode = growth->nextNode;
        b->stopNode = end;
    }
    // The two sizes in parallel: each writes to elements of its own.
    qcParallel_For(threads, qc_patchSizes, qc_patchSizes, GrowSize, growth->builders);
    growth->nextNode = end;
    for (uint32_t size = 0; size < qc_patchSizes; size++)
        QC_TRY(qcWorkerResult_Check(&growth->builders[size].result));
    for (uint32_t size = 0; size < qc_patchSizes && end == patches->nodeCount; size++)
        QC_TRY(AddSize(patches, &growth->builders[size]));
    return qc_statusOk;
}

void qcPatchGrowth_Free(qcPatchGrowth* growth)
{
    for (uint32_t size = 0; size < qc_patchSizes && growth->builders != NULL; size++)
        Free(&growth->builders[size]);
    qcFree(growth->builders, qc_patchSizes * sizeof(Builder));
    *growth = (qcPatchGrowth){.builders = NULL};
}

void qcFlatPatches_Free(qcFlatPatches* patches)
{
    qcArray* arrays[] = {&patches->patches, &patches->slots, &patches->loops, &patches->own, &patches->links};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
    patches->nodeCount = 0;
}
