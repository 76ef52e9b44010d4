// Grows discs triangle by triangle: over one edge of the loop to a vertex that is not in the disc, or into a notch,
// over two edges that follow each other on the loop. Either leaves a disc with one loop around it.
#include "discs.h"

#include "status.h"

#include <stdbool.h>
#include <string.h>

enum
{
    // An edge between two vertices of more triangles is taken to have no other side.
    qc_mostAround = 64,
    qc_seeds = 4,
    // A disc that leaves out more of its node skips too little to be looked at.
    qc_leastShare = qc_nodeSize / 2
};

#define QC_NO_PLACE UINT32_MAX
#define QC_INSIDE UINT32_MAX

/// A vertex of the disc that grows.
typedef struct Joint
{
    uint32_t disc;  ///< which it is in
    uint32_t next;  ///< on the loop, or QC_INSIDE
    uint32_t block; ///< the disc around whose own triangles have it
} Joint;

typedef struct Builder
{
    qcDiscs* discs;
    const qcClusters* clusters;
    const qcCorners* corners;
    uint32_t vertexCount;
    qcArray first, around; ///< uint32_t of each vertex and one more; places
    qcArray across;        ///< uint32_t, three a place: what lies over each edge, or QC_NO_PLACE
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
    qcArray* arrays[] = {&b->first, &b->around, &b->across, &b->inDisc, &b->joints, &b->queue, &b->masks};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}

static bool HasTriangle(const Builder* b, size_t place)
{
    return QC_AT(uint32_t, b->clusters->triangles, place) != QC_NO_TRIANGLE;
}

//  ---- what lies over each edge --------------------------------------------------------------------

static void FindAround(Builder* b)
{
    uint32_t* first = b->first.data;
    size_t places = b->clusters->triangles.count;
    memset(first, 0, ((size_t)b->vertexCount + 1) * sizeof *first);
    for (size_t p = 0; p < places; p++)
        for (int c = 0; c < 3 && HasTriangle(b, p); c++)
            first[b->corners[p].vertex[c]]++;
    uint32_t end = 0;
    for (uint32_t v = 0; v < b->vertexCount; v++)
        first[v] = end += first[v];
    first[b->vertexCount] = end;
    for (size_t p = places; p-- > 0;)
        for (int c = 0; c < 3 && HasTriangle(b, p); c++)
            QC_AT(uint32_t, b->around, --first[b->corners[p].vertex[c]]) = (uint32_t)p;
}

/// The one other triangle that has the edge u v, if it has it as v u.
static uint32_t FindAcross(const Builder* b, uint32_t place, uint32_t u, uint32_t v)
{
    const uint32_t *first = b->first.data, *around = b->around.data;
    uint32_t at = first[v + 1] - first[v] < first[u + 1] - first[u] ? v : u, found = QC_NO_PLACE;
    if (u == v || first[at + 1] - first[at] > qc_mostAround)
        return QC_NO_PLACE;
    for (uint32_t i = first[at]; i < first[at + 1]; i++)
    {
        const uint32_t* w = b->corners[around[i]].vertex;
        bool has = (w[0] == u || w[1] == u || w[2] == u) && (w[0] == v || w[1] == v || w[2] == v);
        if (around[i] == place || !has)
            continue;
        bool opposite = (w[0] == v && w[1] == u) || (w[1] == v && w[2] == u) || (w[2] == v && w[0] == u);
        bool proper = w[0] != w[1] && w[1] != w[2] && w[2] != w[0];
        if (found != QC_NO_PLACE || !opposite || !proper)
            return QC_NO_PLACE;
        found = around[i];
    }
    return found;
}

static void FindAllAcross(Builder* b)
{
    for (size_t p = 0; p < b->clusters->triangles.count; p++)
        for (int c = 0; c < 3; c++)
        {
            const uint32_t* v = b->corners[p].vertex;
            bool proper = HasTriangle(b, p) && v[0] != v[1] && v[1] != v[2] && v[2] != v[0];
            QC_AT(uint32_t, b->across, 3 * p + c) =
                proper ? FindAcross(b, (uint32_t)p, v[c], v[(c + 1) % 3]) : QC_NO_PLACE;
        }
}

//  ---- growth --------------------------------------------------------------------------------------

static Joint* JointAt(const Builder* b, uint32_t vertex)
{
    return &QC_AT(Joint, b->joints, vertex);
}

static bool IsInDisc(const Builder* b, uint32_t place)
{
    return place != QC_NO_PLACE && QC_AT(uint32_t, b->inDisc, place) == b->disc;
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
    const uint32_t *v = b->corners[place].vertex, *across = &QC_AT(uint32_t, b->across, 3 * (size_t)place);
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
        uint32_t other = QC_AT(uint32_t, b->across, 3 * (size_t)place + c);
        if (other != QC_NO_PLACE && !IsInDisc(b, other))
            QC_AT(uint32_t, b->queue, b->queue.count++) = other;
    }
    return qc_statusOk;
}

static qcStatus Add(Builder* b, uint32_t place)
{
    qcArray* places = &b->discs->places;
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
static qcStatus Grow(Builder* b, uint32_t seed, qcDisc* disc)
{
    disc->firstPlace = (uint32_t)b->discs->places.count;
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
    disc->placeCount = (uint32_t)(b->discs->places.count - disc->firstPlace);
    return qc_statusOk;
}

/// Sets the masks of the disc's triangles by node; returns how many of the block it has.
static uint32_t FillMasks(Builder* b, const qcDisc* disc)
{
    uint64_t* masks = b->masks.data;
    uint32_t ownCount = 0;
    const uint32_t* places = &QC_AT(uint32_t, b->discs->places, disc->firstPlace);
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

static qcStatus KeepLoop(Builder* b, qcDisc* disc)
{
    qcArray* loops = &b->discs->loops;
    disc->firstLoop = (uint32_t)loops->count;
    disc->loopCount = CountLoop(b);
    QC_TRY(qcArray_Reserve(loops, loops->count + disc->loopCount, sizeof(uint32_t), "discs of triangles"));
    uint32_t v = b->start;
    for (uint32_t i = 0; i < disc->loopCount; i++, v = JointAt(b, v)->next)
        QC_AT(uint32_t, *loops, loops->count++) = v;
    return qc_statusOk;
}

/// What the disc has of the nodes around its block, for each link between the two.
static void FillRings(const Builder* b, const qcDisc* disc, int size)
{
    const qcClusters* c = b->clusters;
    const uint32_t *firstLink = c->firstLink.data, *places = &QC_AT(uint32_t, b->discs->places, disc->firstPlace);
    const qcNodeLink* links = c->links.data;
    const uint64_t* masks = b->masks.data;
    qcDiscRing* rings = b->discs->rings.data;
    for (uint32_t node = b->firstNode; node < b->endNode; node++)
    {
        QC_AT(uint64_t, b->discs->own, qc_discSizes * (size_t)node + size) = masks[node];
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            rings[l].ofNode[size] = masks[links[l].other];
    }
    for (uint32_t i = 0; i < disc->placeCount; i++)
    {
        uint32_t node = places[i] / qc_nodeSize;
        // Each node once: at the first of its triangles.
        if ((masks[node] & (0 - masks[node])) != UINT64_C(1) << places[i] % qc_nodeSize)
            continue;
        for (uint32_t l = firstLink[node]; l < firstLink[node + 1]; l++)
            if (links[l].other >= b->firstNode && links[l].other < b->endNode)
                rings[l].ofOther[size] = masks[node];
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
            for (uint32_t i = QC_AT(uint32_t, b->first, v); i < QC_AT(uint32_t, b->first, v + 1); i++)
                masks[QC_AT(uint32_t, b->around, i) / qc_nodeSize] = 0;
        }
}

static qcStatus GrowAround(Builder* b, int size, uint32_t disc, uint32_t firstNode, uint32_t nodeCount)
{
    qcDiscs* discs = b->discs;
    qcDisc* made = &QC_AT(qcDisc, discs->discs, disc);
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
        if (best < nodeCount * qc_leastShare || CountLoop(b) > qc_mostLoop)
        {
            discs->places.count = made->firstPlace;
            *made = (qcDisc){0};
            best = 0;
            continue;
        }
        QC_TRY(KeepLoop(b, made));
        FillRings(b, made, size);
    }
    return qc_statusOk;
}

static qcStatus Build(Builder* b)
{
    qcDiscs* d = b->discs;
    const qcClusters* c = b->clusters;
    size_t places = c->triangles.count;
    uint32_t nodes = d->nodeCount, large = (nodes + qc_discNodes - 1) / qc_discNodes;
    QC_TRY(qcArray_Resize(&b->first, (size_t)b->vertexCount + 1, sizeof(uint32_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->around, 3 * places, sizeof(uint32_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->across, 3 * places, sizeof(uint32_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->inDisc, places, sizeof(uint32_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->joints, b->vertexCount, sizeof(Joint), "discs of triangles"));
    QC_TRY(qcArray_Resize(&b->masks, nodes, sizeof(uint64_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&d->discs, (size_t)nodes + large, sizeof(qcDisc), "discs of triangles"));
    QC_TRY(qcArray_Resize(&d->own, qc_discSizes * (size_t)nodes, sizeof(uint64_t), "discs of triangles"));
    QC_TRY(qcArray_Resize(&d->rings, c->links.count, sizeof(qcDiscRing), "discs of triangles"));
    memset(b->inDisc.data, 0, places * sizeof(uint32_t));
    memset(b->joints.data, 0, b->vertexCount * sizeof(Joint));
    memset(d->discs.data, 0, d->discs.count * sizeof(qcDisc));
    memset(d->own.data, 0, d->own.count * sizeof(uint64_t));
    memset(d->rings.data, 0, d->rings.count * sizeof(qcDiscRing));
    FindAround(b);
    FindAllAcross(b);
    for (uint32_t node = 0; node < nodes; node++)
        QC_TRY(GrowAround(b, 0, node, node, 1));
    for (uint32_t i = 0; i < large; i++)
    {
        uint32_t first = i * qc_discNodes;
        QC_TRY(GrowAround(b, 1, nodes + i, first, nodes - first < qc_discNodes ? nodes - first : qc_discNodes));
    }
    return qc_statusOk;
}

qcStatus qcDiscs_Build(qcDiscs* discs, const qcClusters* clusters, const qcCorners* corners, uint32_t vertexCount)
{
    *discs = (qcDiscs){.nodeCount = clusters->nodeCount};
    Builder builder = {.discs = discs, .clusters = clusters, .corners = corners, .vertexCount = vertexCount};
    qcStatus status = Build(&builder);
    Free(&builder);
    if (status != qc_statusOk)
        qcDiscs_Free(discs);
    return status;
}

void qcDiscs_Free(qcDiscs* discs)
{
    qcArray* arrays[] = {&discs->discs, &discs->places, &discs->loops, &discs->own, &discs->rings};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
    discs->nodeCount = 0;
}
