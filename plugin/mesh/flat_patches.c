// Grows discs triangle by triangle: over one edge of the loop to a vertex that is not in the disc, or into a notch,
// over two edges that follow each other on the loop. Either leaves a disc with one loop around it.
#include "mesh/flat_patches.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "base/worker_results.h"

#include <stdbool.h>
#include <string.h>

enum
{
    qc_seeds = 4,
    // A disc that leaves out more of its node skips too little to be looked at.
    qc_leastShare = qc_nodeSize / 2
};

#define QC_INSIDE UINT32_MAX

/// A vertex of the disc that grows.
typedef struct Joint
{
    uint32_t disc;  ///< which it is in
    uint32_t next;  ///< on the loop, or QC_INSIDE
    uint32_t block; ///< the disc around whose own triangles have it
} Joint;

/// Grows the discs of one size.
typedef struct Builder
{
    qcFlatPatches* discs;
    const qcClusters* clusters;
    const qcAdjacency* adjacency;
    const qcCorners* corners;
    uint32_t vertexCount;
    int size;
    qcWorkerResult result;
    qcArray places, loops; ///< of these discs, as in qcFlatPatches
    qcArray inDisc;        ///< uint32_t by place: the disc it is in
    qcArray joints;        ///< of Joint, by vertex
    qcArray queue;         ///< uint32_t: places that may join
    qcArray masks;         ///< uint64_t by node
    //  the disc that grows
    uint32_t disc, firstNode, endNode;
    uint32_t start; ///< a vertex of the loop
} Builder;

static void Free(Builder* b)
{
    qcArray* arrays[] = {&b->places, &b->loops, &b->inDisc, &b->joints, &b->queue, &b->masks};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}

static bool HasTriangle(const Builder* b, size_t place)
{
    return QC_AT(uint32_t, b->clusters->triangles, place) != QC_NO_TRIANGLE;
}

//  ---- growth --------------------------------------------------------------------------------------

static Joint* JointAt(const Builder* b, uint32_t vertex)
{
    return &QC_AT(Joint, b->joints, vertex);
}

static bool IsInDisc(const Builder* b, uint32_t place)
{
    return place != QC_NO_SLOT && QC_AT(uint32_t, b->inDisc, place) == b->disc;
}

static void Begin(Builder* b, uint32_t seed)
{
    const uint32_t* v = b->corners[seed].vertex;
    for (int c = 0; c < 3; c++)
    {
        JointAt(b, v[c])->disc = b->disc;
        JointAt(b, v[c])->next = v[(c + 1) % 3];
    }
    b->start = v[0];
}

/// Changes the loop so that the triangle is inside; false: it would not be a disc with one loop, or it is no notch and
/// only those are wanted.
static bool Join(Builder* b, uint32_t place, bool notchesOnly)
{
    const uint32_t *v = b->corners[place].vertex, *across = &QC_AT(uint32_t, b->adjacency->across, 3 * (size_t)place);
    bool shared[3];
    int count = 0;
    for (int c = 0; c < 3; c++)
        count += shared[c] = IsInDisc(b, across[c]);
    if (count == 1 && !notchesOnly)
    {
        int c = shared[0] ? 0 : shared[1] ? 1 : 2;
        // The loop has the edge in the other direction.
        uint32_t from = v[(c + 1) % 3], to = v[c], apex = v[(c + 2) % 3];
        if (JointAt(b, apex)->disc == b->disc || JointAt(b, from)->next != to)
            return false;
        *JointAt(b, apex) = (Joint){b->disc, to, JointAt(b, apex)->block};
        JointAt(b, from)->next = apex;
        return true;
    }
    if (count == 2)
    {
        int c = !shared[0] ? 0 : !shared[1] ? 1 : 2;
        uint32_t from = v[c], to = v[(c + 1) % 3], notch = v[(c + 2) % 3];
        if (JointAt(b, from)->next != notch || JointAt(b, notch)->next != to || JointAt(b, to)->next == from)
            return false;
        JointAt(b, from)->next = to;
        JointAt(b, notch)->next = QC_INSIDE;
        b->start = from;
        return true;
    }
    return false;
}

static bool IsOfBlock(const Builder* b, uint32_t place)
{
    uint32_t node = place / qc_nodeSize;
    return node >= b->firstNode && node < b->endNode;
}

/// Around the block: it shares a vertex with it.
static bool IsOfRing(const Builder* b, uint32_t place)
{
    const uint32_t* v = b->corners[place].vertex;
    return JointAt(b, v[0])->block == b->disc || JointAt(b, v[1])->block == b->disc ||
           JointAt(b, v[2])->block == b->disc;
}

/// What lies over its edges may join next.
static qcStatus PushAcross(Builder* b, uint32_t place)
{
    QC_TRY(qcArray_Reserve(&b->queue, b->queue.count + 3, sizeof(uint32_t), "discs of triangles"));
    for (int c = 0; c < 3; c++)
    {
        uint32_t other = QC_AT(uint32_t, b->adjacency->across, 3 * (size_t)place + c);
        if (other != QC_NO_SLOT && !IsInDisc(b, other))
            QC_AT(uint32_t, b->queue, b->queue.count++) = other;
    }
    return qc_statusOk;
}

static qcStatus Add(Builder* b, uint32_t place)
{
    qcArray* places = &b->places;
    QC_TRY(qcArray_Reserve(places, places->count + 1, sizeof(uint32_t), "discs of triangles"));
    QC_AT(uint32_t, *places, places->count++) = place;
    QC_AT(uint32_t, b->inDisc, place) = b->disc;
    return PushAcross(b, place);
}

typedef enum Phase
{
    phase_block,   ///< over the block alone
    phase_ring,    ///< over all that shares a vertex with it
    phase_notches, ///< what makes the loop smoother: it is told quicker that a smooth one is simple
    phase_end
} Phase;

/// From a seed. Breadth first: the disc stays round.
static qcStatus Grow(Builder* b, uint32_t seed, qcFlatPatch* disc)
{
    disc->firstPlace = (uint32_t)b->places.count;
    b->queue.count = 0;
    Begin(b, seed);
    QC_TRY(Add(b, seed));
    for (Phase phase = phase_block; phase < phase_end; phase++)
    {
        size_t refused = 0;
        for (size_t at = 0; at < b->queue.count; at++)
        {
            uint32_t place = QC_AT(uint32_t, b->queue, at);
            if (IsInDisc(b, place))
                continue;
            bool allowed = phase == phase_notches || IsOfBlock(b, place) || (phase == phase_ring && IsOfRing(b, place));
            if (allowed && Join(b, place, phase == phase_notches))
                QC_TRY(Add(b, place));
            else
                QC_AT(uint32_t, b->queue, refused++) = place;
        }
        // The next phase may take them.
        b->queue.count = refused;
    }
    disc->placeCount = (uint32_t)(b->places.count - disc->firstPlace);
    return qc_statusOk;
}

/// Sets the masks of the disc's triangles by node; returns how many of the block it has.
static uint32_t FillMasks(Builder* b, const qcFlatPatch* disc)
{
    uint64_t* masks = b->masks.data;
    uint32_t ownCount = 0;
    const uint32_t* places = &QC_AT(uint32_t, b->places, disc->firstPlace);
    for (uint32_t i = 0; i < disc->placeCount; i++)
        masks[places[i] / qc_nodeSize] = 0;
    for (uint32_t i = 0; i < disc->placeCount; i++)
    {
        masks[places[i] / qc_nodeSize] |= UINT64_C(1) << places[i] % qc_nodeSize;
        ownCount += IsOfBlock(b, places[i]);
    }
    return ownCount;
}

static uint32_t CountLoop(const Builder* b)
{
    uint32_t count = 0, v = b->start;
    do
    {
        v = JointAt(b, v)->next;
        count++;
    } while (v != b->start);
    return count;
}

static qcStatus KeepLoop(Builder* b, qcFlatPatch* disc)
{
    qcArray* loops = &b->loops;
    disc->firstLoop = (uint32_t)loops->count;
    disc->loopCount = CountLoop(b);
    QC_TRY(qcArray_Reserve(loops, loops->count + disc->loopCount, sizeof(uint32_t), "discs of triangles"));
    uint32_t v = b->start;
    for (uint32_t i = 0; i < disc->loopCount; i++, v = JointAt(b, v)->next)
        QC_AT(uint32_t, *loops, loops->count++) = v;
    return qc_statusOk;
}

/// What the disc has of the nodes around its block, for each link between the two.
static void FillRings(const Builder* b, const qcFlatPatch* disc)
{
    const qcClusters* c = b->clusters;
    const uint32_t *firstLink = c->firstLink.data, *places = &QC_AT(uint32_t, b->places, disc->firstPlace);
    const qcLeafLink* links = c->links.data;
    const uint64_t* masks = b->masks.data;
    qcPatchLoop* rings = b->discs->rings.data;
    for (uint32_t node = b->firstNode; node < b->endNode; node++)
    {
        QC_AT(uint64_t, b->discs->own, qc_patchSizes * (size_t)node + b->size) = masks[node];
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            rings[l].ofNode[b->size] = masks[links[l].other];
    }
    for (uint32_t i = 0; i < disc->placeCount; i++)
    {
        uint32_t node = places[i] / qc_nodeSize;
        // Each node once: at the first of its triangles.
        if ((masks[node] & (0 - masks[node])) != UINT64_C(1) << places[i] % qc_nodeSize)
            continue;
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            if (links[l].other >= b->firstNode && links[l].other < b->endNode)
                rings[l].ofOther[b->size] = masks[node];
    }
}

/// Marks the block's own vertices, and clears the masks of all nodes that share one.
static void MarkBlock(Builder* b)
{
    uint64_t* masks = b->masks.data;
    for (size_t p = (size_t)b->firstNode * qc_nodeSize; p < (size_t)b->endNode * qc_nodeSize; p++)
        for (int c = 0; c < 3 && HasTriangle(b, p); c++)
        {
            uint32_t v = b->corners[p].vertex[c];
            JointAt(b, v)->block = b->disc;
            const uint32_t* first = &QC_AT(uint32_t, b->adjacency->first, v);
            for (uint32_t i = first[0]; i < first[1]; i++)
                masks[QC_AT(uint32_t, b->adjacency->around, i) / qc_nodeSize] = 0;
        }
}

static qcStatus GrowAround(Builder* b, uint32_t disc, uint32_t firstNode, uint32_t nodeCount)
{
    qcFlatPatches* discs = b->discs;
    qcFlatPatch* made = &QC_AT(qcFlatPatch, discs->discs, disc);
    b->firstNode = firstNode;
    b->endNode = firstNode + nodeCount;
    uint32_t step = nodeCount * qc_nodeSize / qc_seeds, best = 0;
    for (uint32_t i = 0; i < qc_seeds && best == 0; i++)
    {
        uint32_t seed = firstNode * qc_nodeSize + (i + qc_seeds / 2) % qc_seeds * step;
        if (!HasTriangle(b, seed))
            continue;
        b->disc++;
        MarkBlock(b);
        QC_TRY(Grow(b, seed, made));
        best = FillMasks(b, made);
        if (best < nodeCount * qc_leastShare || CountLoop(b) > qc_maxLoop)
        {
            b->places.count = made->firstPlace;
            *made = (qcFlatPatch){0};
            best = 0;
            continue;
        }
        QC_TRY(KeepLoop(b, made));
        FillRings(b, made);
    }
    return qc_statusOk;
}

static qcStatus GrowAll(Builder* b)
{
    size_t places = b->clusters->triangles.count;
    uint32_t nodes = b->discs->nodeCount, block = b->size == 0 ? 1 : qc_patchNodes;
    QC_TRY(qcArray_Resize(&b->inDisc, places, sizeof(uint32_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->joints, b->vertexCount, sizeof(Joint), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->masks, nodes, sizeof(uint64_t), "discs of triangles"));
    memset(b->inDisc.data, 0, places * sizeof(uint32_t));
    memset(b->joints.data, 0, b->vertexCount * sizeof(Joint));
    uint32_t disc = b->size == 0 ? 0 : nodes;
    for (uint32_t first = 0; first < nodes; first += block)
        QC_TRY(GrowAround(b, disc++, first, nodes - first < block ? nodes - first : block));
    return qc_statusOk;
}

static void GrowSize(void* context, size_t size, uint32_t worker)
{
    (void)worker;
    Builder* builder = (Builder*)context + size;
    (void)qcWorkerResult_Add(&builder->result, GrowAll(builder));
}

/// Adds the places and loops of the discs of one size.
static qcStatus AddSize(qcFlatPatches* d, const Builder* b)
{
    QC_TRY(qcWorkerResult_Check(&b->result));
    size_t first = b->size == 0 ? 0 : d->nodeCount, end = b->size == 0 ? d->nodeCount : d->discs.count;
    for (size_t i = first; i < end; i++)
    {
        QC_AT(qcFlatPatch, d->discs, i).firstPlace += (uint32_t)d->places.count;
        QC_AT(qcFlatPatch, d->discs, i).firstLoop += (uint32_t)d->loops.count;
    }
    QC_TRY(qcArray_Append(&d->places, &b->places, sizeof(uint32_t), "discs of triangles"));
    return qcArray_Append(&d->loops, &b->loops, sizeof(uint32_t), "discs of triangles");
}

static qcStatus Build(qcFlatPatches* d, Builder builders[qc_patchSizes], uint32_t threads)
{
    const qcClusters* c = builders[0].clusters;
    uint32_t nodes = d->nodeCount, large = (nodes + qc_patchNodes - 1) / qc_patchNodes;
    QC_TRY(qcArray_GrowZeroed(&d->discs, (size_t)nodes + large, sizeof(qcFlatPatch), "discs of triangles"));
    QC_TRY(qcArray_GrowZeroed(&d->own, qc_patchSizes * (size_t)nodes, sizeof(uint64_t), "discs of triangles"));
    QC_TRY(qcArray_GrowZeroed(&d->rings, c->links.count, sizeof(qcPatchLoop), "discs of triangles"));
    // The two sizes side by side: they write to what is each one's own.
    qcParallel_For(threads, qc_patchSizes, qc_patchSizes, GrowSize, builders);
    for (int size = 0; size < qc_patchSizes; size++)
        QC_TRY(AddSize(d, &builders[size]));
    return qc_statusOk;
}

qcStatus qcFlatPatches_Build(qcFlatPatches* discs, const qcClusters* clusters, const qcAdjacency* adjacency,
                             const qcCorners* corners, uint32_t vertexCount, uint32_t threads)
{
    *discs = (qcFlatPatches){.nodeCount = clusters->nodeCount};
    Builder builders[qc_patchSizes];
    for (int size = 0; size < qc_patchSizes; size++)
        builders[size] = (Builder){.discs = discs,
                                   .clusters = clusters,
                                   .adjacency = adjacency,
                                   .corners = corners,
                                   .vertexCount = vertexCount,
                                   .size = size};
    qcStatus status = Build(discs, builders, threads);
    for (int size = 0; size < qc_patchSizes; size++)
        Free(&builders[size]);
    if (status != qc_statusOk)
        qcFlatPatches_Free(discs);
    return status;
}

void qcFlatPatches_Free(qcFlatPatches* discs)
{
    qcArray* arrays[] = {&discs->discs, &discs->places, &discs->loops, &discs->own, &discs->rings};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
    discs->nodeCount = 0;
}
