// Pairs come from the list, and from a search for the triangles that moved too far for it.
// Proof that no pair is lost: plugin/docs/proofs/verlet_list.md.
#include "sweep/bvh/verlet_list.h"

#include "base/aabb.h"
#include "base/status.h"

#include <math.h>
#include <string.h>

/// Consecutive pairs of one body.
typedef struct PairRun
{
    uint32_t slot;
    size_t disjoint; ///< the first so many are proven disjoint
    size_t count;
} PairRun;

static qcVerletWorker* WorkerAt(const qcVerletList* list, size_t worker)
{
    return &QC_AT(qcVerletWorker, list->workers, worker);
}

qcStatus qcVerletList_Begin(qcVerletList* list, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&list->workers, threads, sizeof(qcVerletWorker), "a Verlet list"));
    for (size_t i = 0; i < list->workers.count; i++)
        WorkerAt(list, i)->pairs.count = WorkerAt(list, i)->runs.count = 0;
    return qc_statusOk;
}

static qcStatus AddRun(qcVerletWorker* worker, const PairRun* run, const qcSlotPair* pairs)
{
    size_t first = worker->pairs.count, at = worker->runs.count;
    QC_TRY(qcArray_Resize(&worker->pairs, first + run->count, sizeof(qcSlotPair), "a Verlet list"));
    QC_TRY(qcArray_Resize(&worker->runs, at + 1, sizeof(PairRun), "a Verlet list"));
    memcpy(&QC_AT(qcSlotPair, worker->pairs, first), pairs, run->count * sizeof *pairs);
    QC_AT(PairRun, worker->runs, at) = *run;
    return qc_statusOk;
}

void qcVerletList_Add(qcVerletList* list, uint32_t slot, const qcClassifiedPairs* found, uint32_t worker)
{
    qcVerletWorker* to = WorkerAt(list, worker);
    PairRun run = {slot, found->nearCount + found->separateCount, found->count};
    if (qcWorkerResult_IsOk(&to->result) && run.count != 0)
        (void)qcWorkerResult_Add(&to->result, AddRun(to, &run, found->pairs));
}

qcStatus qcVerletList_Check(const qcVerletList* list)
{
    return qcWorkerResults_End(&list->workers, sizeof(qcVerletWorker));
}

//  ---- search ----------------------------------------------------------------------------------------

/// Eight triangles that moved far, side by side, and their boxes.
typedef struct FarTriangles
{
    uint32_t slot[qc_boxLanes];
    int count;
    qcBox8 boxes;
} FarTriangles;

typedef struct Search
{
    const qcBvhPairsJob* job;
    const qcTriangleBvh* bvh;
    const uint8_t* flags; ///< qcMotionFlag by slot
    qcIndexedTriangles sides[2];
    qcDistanceThresholds thresholds;
    uint32_t worker;
    bool isOpen;  ///< false: the job's function has stopped the search
    size_t count; ///< in the queue
    qcSlotPair queue[qc_queueFull];
} Search;

static void Flush(Search* s)
{
    qcClassifiedPairs found = {.pairs = s->queue, .count = s->count};
    s->count = 0;
    if (found.count == 0 || !s->isOpen)
        return;
    qcClassifiedPairs_Filter(&found, s->job->kernels, s->sides, &s->thresholds, false);
    s->isOpen = found.count == 0 || s->job->function(s->job->context, &found, s->worker);
}

static void Push(Search* s, qcSlotPair pair)
{
    if (s->count == qc_queueFull)
        Flush(s);
    s->queue[s->count++] = pair;
}

/// Queues pairs of the list whose triangles have not moved far. With a query distance of 0, disjoint pairs that have
/// not moved at all are left out: they are still disjoint.
static void PushRun(Search* s, const PairRun* run, const qcSlotPair* pairs)
{
    size_t disjoint = s->job->query == 0.0 ? run->disjoint : 0;
    for (size_t i = 0; i < run->count; i++)
    {
        uint8_t a = s->flags[pairs[i].a], b = s->flags[pairs[i].b];
        bool still = a == qc_motionNone && b == qc_motionNone, far = a == qc_motionLarge || b == qc_motionLarge;
        if (!far && !(still && i < disjoint))
            Push(s, pairs[i]);
    }
}

static void PushList(Search* s, const qcVerletList* list, uint32_t slot)
{
    for (size_t i = 0; i < list->workers.count; i++)
    {
        const qcVerletWorker* worker = WorkerAt(list, i);
        const qcSlotPair* pairs = worker->pairs.data;
        for (size_t k = 0; k < worker->runs.count; k++)
        {
            const PairRun* run = &QC_AT(PairRun, worker->runs, k);
            if (run->slot == slot)
                PushRun(s, run, pairs);
            pairs += run->count;
        }
    }
}

static bool ShareVertex(const qcCorners* a, const qcCorners* b)
{
    bool share = false;
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            share |= a->vertex[i] == b->vertex[k];
    return share;
}

/// Queues a triangle and one that moved far: each pair once, no neighbours.
static void PushFarPair(Search* s, uint32_t slot, uint32_t far)
{
    const qcCorners* corners = s->sides[0].corners;
    bool isPushed = slot == far || (slot < far && s->flags[slot] == qc_motionLarge);
    if (!isPushed && !ShareVertex(&corners[slot], &corners[far]))
        Push(s, (qcSlotPair){slot, far});
}

static void Descend(Search* s, const FarTriangles* far, uint32_t level, size_t at)
{
    uint64_t overlaps =
        s->job->kernels->findOverlaps(qcTriangleBvh_Box8At(s->bvh, &s->bvh->fit, level, (uint32_t)at), &far->boxes);
    for (uint32_t i = 0; overlaps != 0; i++, overlaps >>= 1)
    {
        // Bits i + 8 k for all k.
        uint64_t ofChild = overlaps & UINT64_C(0x0101010101010101);
        overlaps &= ~UINT64_C(0x0101010101010101);
        if (ofChild == 0)
            continue;
        size_t child = at * qc_boxLanes + i;
        if (level > 0)
            Descend(s, far, level - 1, child);
        for (; level == 0 && ofChild != 0; ofChild &= ofChild - 1)
            PushFarPair(s, (uint32_t)child, far->slot[__builtin_ctzll(ofChild) / qc_boxLanes]);
    }
}

static void Clear(FarTriangles* far)
{
    far->count = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 2 * qc_boxLanes; k++)
            far->boxes.ends[axis][k] = qc_emptyEnd;
}

/// The level of a coordinate, clamped to the lattice.
static int16_t LevelOf(const qcLatticeTransform* lattice, int axis, double x)
{
    double level = (x - lattice->origin[axis]) * lattice->scale[axis];
    int whole = !(level > 0.0) ? 0 : level < qc_lastLevel ? (int)level : qc_lastLevel;
    return (int16_t)(whole - 32768);
}

/// The box has the job's query distance as its margin; the rest of the fit's margin is taken off its lower end.
static void AddFarTriangle(FarTriangles* far, const Search* s, uint32_t slot)
{
    const qcTriangleBvh* bvh = s->bvh;
    const uint32_t* vertex = QC_AT(qcCorners, bvh->corners, slot).vertex;
    double spare = bvh->fit.margin - s->job->query;
    double corners[3][3], lower[3], upper[3];
    for (int c = 0; c < 3; c++)
        memcpy(corners[c], s->job->bodyA->world + 3 * (size_t)QC_AT(uint32_t, bvh->vertexOf, vertex[c]),
               sizeof corners[c]);
    qcBounds_OfTriangle((const double(*)[3])corners, lower, upper);
    int to = far->count++;
    far->slot[to] = slot;
    for (int axis = 0; axis < 3; axis++)
    {
        double rounding = 0x1p-50 * (fabs(lower[axis]) + bvh->fit.margin);
        int16_t* ends = far->boxes.ends[axis];
        ends[to] = LevelOf(&bvh->fit.lattice, axis, lower[axis] + spare - rounding);
        ends[qc_boxLanes + to] = (int16_t)~LevelOf(&bvh->fit.lattice, axis, upper[axis] + s->job->query);
    }
}

/// True if one of eight triangles has moved far.
static bool HasLargeMotion(const uint8_t flags[qc_boxLanes])
{
    uint64_t all;
    memcpy(&all, flags, sizeof all);
    return (all & UINT64_C(0x0101010101010101) * qc_motionLarge) != 0;
}

static void PushFarTriangles(Search* s)
{
    const qcTriangleBvh* bvh = s->bvh;
    FarTriangles far;
    Clear(&far);
    for (uint32_t slot = 0; slot < bvh->corners.count; slot++)
    {
        // Most have not: eight are tested together.
        if (slot % qc_boxLanes == 0 && !HasLargeMotion(s->flags + slot))
        {
            slot += qc_boxLanes - 1;
            continue;
        }
        if (s->flags[slot] != qc_motionLarge)
            continue;
        AddFarTriangle(&far, s, slot);
        if (far.count < qc_boxLanes)
            continue;
        Descend(s, &far, bvh->levels - 1, 0);
        Clear(&far);
    }
    if (far.count != 0)
        Descend(s, &far, bvh->levels - 1, 0);
}

void qcVerletList_Find(const qcVerletList* list, uint32_t slot, const qcBvhPairsJob* job, uint32_t worker)
{
    const qcTriangleBvh* bvh = &job->a->bvh;
    const qcIndexedTriangles triangles = {bvh->corners.data, bvh->fit.points.data};
    Search search;
    search.job = job;
    search.bvh = bvh;
    search.flags = job->a->verlet.motionFlags.data;
    search.sides[0] = search.sides[1] = triangles;
    search.thresholds = qcTriangleBvh_Thresholds(bvh, job->query, job->near);
    search.worker = worker;
    search.isOpen = true;
    search.count = 0;
    PushList(&search, list, slot);
    PushFarTriangles(&search);
    Flush(&search);
}

void qcVerletList_Free(qcVerletList* list)
{
    for (size_t i = 0; i < list->workers.count; i++)
    {
        qcArray_Free(&WorkerAt(list, i)->pairs);
        qcArray_Free(&WorkerAt(list, i)->runs);
    }
    qcArray_Free(&list->workers);
}
