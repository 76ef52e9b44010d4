// Why no pair is lost. Where pairs were kept, all that were no further apart than a margin d were, but for neighbours,
// which are not looked for now either: what flat discs leave out (kernels/flat_patch_test.inl.h) is further apart than
// the fit's margin. A point of a triangle moves no further than the corner that moves furthest. So two triangles whose
// corners have moved by (d - m) / 2 at most and that are within m now were within d then: they are among those kept.
// All others have a triangle with a corner that went further, and those triangles are compared with the boxes of all,
// which hold what moved where it is now.
//
// Triangles that went far get boxes of their own, with m above them. Those of the surface have the margin of its fit,
// M, above them, which is d or more: so that lower(T) <= upper(U) + m is lower(T) + (M - m) <= upper(U) + M. The left
// side is made smaller than what sums of such numbers are rounded by, far from the origin too (some 2^-52 of them); all
// that follows is as in sweep/bvh/triangle_bvh.c, and monotone.
//
// What was known to be apart and has not moved still is: where the job has no margin, that is all there is to know.
// What was known to meet, or wasn't known, is looked at again.
#include "sweep/bvh/verlet_list.h"

#include "base/status.h"
#include "sweep/bvh/partial_refit.h"

#include <math.h>
#include <string.h>

/// Pairs that lie together in a sink.
typedef struct KeptRun
{
    uint32_t slot;
    size_t apart; ///< so many are apart
    size_t count; ///< in all; the others may not be
} KeptRun;

static qcVerletWorker* SinkAt(const qcVerletList* kept, size_t worker)
{
    return &QC_AT(qcVerletWorker, kept->sinks, worker);
}

qcStatus qcVerletList_Begin(qcVerletList* kept, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&kept->sinks, threads, sizeof(qcVerletWorker), "pairs that are kept"));
    for (size_t i = 0; i < kept->sinks.count; i++)
        SinkAt(kept, i)->pairs.count = SinkAt(kept, i)->runs.count = 0;
    return qc_statusOk;
}

static qcStatus AddRun(qcVerletWorker* sink, const KeptRun* run, const qcSlotPair* pairs)
{
    size_t first = sink->pairs.count, at = sink->runs.count;
    QC_TRY(qcArray_Resize(&sink->pairs, first + run->count, sizeof(qcSlotPair), "pairs that are kept"));
    QC_TRY(qcArray_Resize(&sink->runs, at + 1, sizeof(KeptRun), "pairs that are kept"));
    memcpy(&QC_AT(qcSlotPair, sink->pairs, first), pairs, run->count * sizeof *pairs);
    QC_AT(KeptRun, sink->runs, at) = *run;
    return qc_statusOk;
}

void qcVerletList_Add(qcVerletList* kept, uint32_t slot, const qcClassifiedPairs* found, uint32_t worker)
{
    qcVerletWorker* sink = SinkAt(kept, worker);
    KeptRun run = {slot, found->near + found->apart, found->count};
    if (qcWorkerResult_IsOk(&sink->result) && run.count != 0)
        (void)qcWorkerResult_Add(&sink->result, AddRun(sink, &run, found->pairs));
}

qcStatus qcVerletList_Check(const qcVerletList* kept)
{
    return qcWorkerResults_End(&kept->sinks, sizeof(qcVerletWorker));
}

//  ---- finding ---------------------------------------------------------------------------------------

/// Triangles that went far, as many as boxes in a group, and the group of their boxes.
typedef struct FarGroup
{
    uint32_t place[qc_groupSize];
    int count;
    qcBox8 boxes;
} FarGroup;

typedef struct Finding
{
    const qcBvhPairsJob* job;
    const uint8_t* marks; ///< by place
    qcFilterSide sides[2];
    qcDistanceThresholds bound;
    uint32_t worker;
    bool wanted;
    size_t count; ///< in the queue
    qcSlotPair queue[qc_queueFull];
} Finding;

static void Flush(Finding* f)
{
    qcClassifiedPairs found = {.pairs = f->queue, .count = f->count};
    f->count = 0;
    if (found.count == 0 || !f->wanted)
        return;
    qcClassifiedPairs_Filter(&found, f->job->kernels, f->sides, &f->bound);
    f->wanted = found.count == 0 || f->job->function(f->job->context, &found, f->worker);
}

static void Push(Finding* f, qcSlotPair pair)
{
    if (f->count == qc_queueFull)
        Flush(f);
    f->queue[f->count++] = pair;
}

static void TakeRun(Finding* f, const KeptRun* run, const qcSlotPair* pairs)
{
    size_t apart = f->job->margin == 0.0 ? run->apart : 0;
    for (size_t i = 0; i < run->count; i++)
    {
        uint8_t a = f->marks[pairs[i].a], b = f->marks[pairs[i].b];
        bool still = a == qc_markStill && b == qc_markStill, far = a == qc_markFar || b == qc_markFar;
        if (!far && !(still && i < apart))
            Push(f, pairs[i]);
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

/// A pair of a triangle with one that went far: each once, and none of neighbours.
static void OfferPair(Finding* f, uint32_t place, uint32_t far)
{
    const qcCorners* corners = f->job->a->corners.data;
    bool isTaken = place == far || (f->marks[place] == qc_markFar && place < far);
    if (!isTaken && !ShareVertex(&corners[place], &corners[far]))
        Push(f, (qcSlotPair){place, far});
}

static void Descend(Finding* f, const FarGroup* group, uint32_t level, size_t at)
{
    uint64_t meet = f->job->kernels->compare(qcTriangleBvh_Group(f->job->a, level, (uint32_t)at), &group->boxes);
    for (uint32_t i = 0; meet != 0; i++, meet >>= 1)
    {
        // Bits i + 8 k of all k.
        uint64_t those = meet & UINT64_C(0x0101010101010101);
        meet &= ~UINT64_C(0x0101010101010101);
        if (those == 0)
            continue;
        size_t child = at * qc_groupSize + i;
        if (level > 0)
            Descend(f, group, level - 1, child);
        for (; level == 0 && those != 0; those &= those - 1)
            OfferPair(f, (uint32_t)child, group->place[__builtin_ctzll(those) / qc_groupSize]);
    }
}

static void EmptyGroup(FarGroup* group)
{
    group->count = 0;
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 2 * qc_groupSize; k++)
            group->boxes.ends[axis][k] = qc_emptyEnd;
}

/// The level of a coordinate, within what levels there are.
static int16_t LevelOf(const qcLatticeTransform* map, int axis, double x)
{
    double level = (x - map->origin[axis]) * map->scale[axis];
    int whole = !(level > 0.0) ? 0 : level < 65533.0 ? (int)level : 65533;
    return (int16_t)(whole - 32768);
}

static void AddToGroup(FarGroup* group, const Finding* f, uint32_t place)
{
    const qcTriangleBvh* surface = f->job->a;
    const uint32_t* vertex = QC_AT(qcCorners, surface->corners, place).vertex;
    double spare = surface->margin - f->job->margin;
    const double* p[3];
    for (int c = 0; c < 3; c++)
        p[c] = f->job->bodyA->world + 3 * (size_t)QC_AT(uint32_t, surface->vertexOf, vertex[c]);
    int to = group->count++;
    group->place[to] = place;
    for (int axis = 0; axis < 3; axis++)
    {
        double lower = fmin(p[0][axis], fmin(p[1][axis], p[2][axis]));
        double upper = fmax(p[0][axis], fmax(p[1][axis], p[2][axis]));
        double rounding = 0x1p-50 * (fabs(lower) + surface->margin);
        int16_t* ends = group->boxes.ends[axis];
        ends[to] = LevelOf(&surface->map, axis, lower + spare - rounding);
        ends[qc_groupSize + to] = (int16_t)~LevelOf(&surface->map, axis, upper + f->job->margin);
    }
}

/// Did one of eight places go far?
static bool IsSomeFar(const uint8_t marks[qc_groupSize])
{
    uint64_t all;
    memcpy(&all, marks, sizeof all);
    return (all & UINT64_C(0x0101010101010101) * qc_markFar) != 0;
}

static void TakeFar(Finding* f)
{
    const qcTriangleBvh* surface = f->job->a;
    FarGroup group;
    EmptyGroup(&group);
    for (uint32_t place = 0; place < surface->corners.count; place++)
    {
        // Few have: eight are looked at together.
        if (place % qc_groupSize == 0 && !IsSomeFar(f->marks + place))
        {
            place += qc_groupSize - 1;
            continue;
        }
        if (f->marks[place] != qc_markFar)
            continue;
        AddToGroup(&group, f, place);
        if (group.count < qc_groupSize)
            continue;
        Descend(f, &group, surface->levels - 1, 0);
        EmptyGroup(&group);
    }
    if (group.count != 0)
        Descend(f, &group, surface->levels - 1, 0);
}

void qcVerletList_Find(const qcVerletList* kept, uint32_t slot, const qcBvhPairsJob* job, uint32_t worker)
{
    const qcFilterSide side = {job->a->corners.data, job->a->points.data};
    Finding finding;
    finding.job = job;
    finding.marks = job->a->placeMarks.data;
    finding.sides[0] = finding.sides[1] = side;
    finding.bound = qcTriangleBvh_FindBound(job->a, job->margin, job->nearest);
    finding.worker = worker;
    finding.wanted = true;
    finding.count = 0;
    for (size_t i = 0; i < kept->sinks.count; i++)
    {
        const qcVerletWorker* sink = SinkAt(kept, i);
        const qcSlotPair* pairs = sink->pairs.data;
        for (size_t k = 0; k < sink->runs.count; k++)
        {
            const KeptRun* run = &QC_AT(KeptRun, sink->runs, k);
            if (run->slot == slot)
                TakeRun(&finding, run, pairs);
            pairs += run->count;
        }
    }
    TakeFar(&finding);
    Flush(&finding);
}

void qcVerletList_Free(qcVerletList* kept)
{
    for (size_t i = 0; i < kept->sinks.count; i++)
    {
        qcArray_Free(&SinkAt(kept, i)->pairs);
        qcArray_Free(&SinkAt(kept, i)->runs);
    }
    qcArray_Free(&kept->sinks);
}
