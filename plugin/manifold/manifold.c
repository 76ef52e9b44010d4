// Contact points of all bodies. What two bodies have to do with each other is independent of all others: their pairs
// are taken together and looked at as one, small enough for a core's caches, each by whichever thread is free.
//
// Where two bodies have so many pairs that a thread would be at them when all others are done, all threads share them.
#include "manifold/manifold.h"

#include "manifold/overlap_kernels.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Meetings at once; one takes from 1 to 1 000 microseconds.
    qc_leastMeetings = 4,
    // Pairs that are worth the waking of threads at every stage: some milliseconds.
    qc_leastSharedPairs = 2048
};

typedef struct Job
{
    qcAllManifolds* all;
    const qcStepTriangles* triangles;
    const qcManifoldInput* input;
    size_t shared; ///< meetings that are done
} Job;

//  ---- meetings -------------------------------------------------------------------------------------------

static uint64_t BodiesOf(const qcPair* pair)
{
    return (uint64_t)pair->bodyA << 32 | pair->bodyB;
}

/// The end of the pairs from `first` on that have bodies and a triangle of A in common.
static size_t EndOfRun(const qcManifoldInput* input, size_t first)
{
    const qcPair* pair = &input->pairs[first];
    size_t end = first + 1;
    while (end < input->count && input->pairs[end].triangleA == pair->triangleA &&
           BodiesOf(&input->pairs[end]) == BodiesOf(pair))
        end++;
    return end;
}

/// Sorted by bodies; of two bodies they stay in their order, and so do the pairs.
static qcStatus ListRuns(qcAllManifolds* all, const qcManifoldInput* input)
{
    size_t count = 0;
    for (size_t first = 0; first < input->count; first = EndOfRun(input, first))
        count++;
    QC_TRY(qcArray_Resize(&all->runs, count, sizeof(qcSortItem), "pairs of manifolds"));
    count = 0;
    for (size_t first = 0, end; first < input->count; first = end)
    {
        end = EndOfRun(input, first);
        QC_AT(qcSortItem, all->runs, count++) =
            (qcSortItem){BodiesOf(&input->pairs[first]), (uint64_t)first << 32 | (end - first)};
    }
    return qcSort_Items(all->runs.data, all->runs.count, &all->scratch);
}

static qcStatus ListMeetings(qcAllManifolds* all)
{
    const qcSortItem* runs = all->runs.data;
    size_t count = 0;
    for (size_t r = 0; r < all->runs.count; r++)
        count += r == 0 || runs[r].key != runs[r - 1].key;
    QC_TRY(qcArray_Resize(&all->meetings, count, sizeof(qcBodyPairRange), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&all->order, count, sizeof(qcSortItem), "pairs of manifolds"));
    qcBodyPairRange* meeting = all->meetings.data;
    for (uint32_t r = 0; r < all->runs.count; r++)
    {
        if (r == 0 || runs[r].key != runs[r - 1].key)
        {
            meeting += r != 0;
            *meeting = (qcBodyPairRange){.firstRun = r};
        }
        meeting->runCount++;
        meeting->pairCount += (uint32_t)runs[r].value;
    }
    for (size_t i = 0; i < count; i++)
        QC_AT(qcSortItem, all->order, i) =
            (qcSortItem){UINT32_MAX - QC_AT(qcBodyPairRange, all->meetings, i).pairCount, (uint64_t)i};
    return qcSort_Items(all->order.data, count, &all->scratch);
}

static qcBodyPairRange* MeetingAt(const qcAllManifolds* all, size_t place)
{
    return &QC_AT(qcBodyPairRange, all->meetings, QC_AT(qcSortItem, all->order, place).value);
}

//  ---- their manifolds ------------------------------------------------------------------------------------

static qcStatus Build(const Job* job, qcBodyPairRange* meeting, uint32_t maker, uint32_t threads)
{
    qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, job->all->makers, maker);
    const qcMeetingInput input = {.reported = job->input,
                                  .runs = &QC_AT(qcSortItem, job->all->runs, meeting->firstRun),
                                  .runCount = meeting->runCount,
                                  .count = meeting->pairCount,
                                  .proximities = job->input->proximities,
                                  .feet = job->input->feet,
                                  .margin = job->input->margin};
    meeting->maker = maker;
    meeting->firstManifold = m->manifolds.count;
    meeting->firstPoint = m->points.count;
    QC_TRY(qcManifoldBuilder_Build(m, job->triangles, &input, threads));
    meeting->manifoldCount = m->manifolds.count - meeting->firstManifold;
    meeting->pointCount = m->points.count - meeting->firstPoint;
    return qc_statusOk;
}

static void TakeMeeting(void* context, size_t index, uint32_t worker)
{
    const Job* job = context;
    qcWorkerResult* result = &QC_AT(qcManifoldBuilder, job->all->makers, worker).result;
    if (qcWorkerResult_IsOk(result))
        (void)qcWorkerResult_Add(result, Build(job, MeetingAt(job->all, job->shared + index), worker, 1));
}

static qcStatus BuildAll(Job* job, uint32_t threads)
{
    const qcAllManifolds* all = job->all;
    for (; threads > 1 && job->shared < all->meetings.count; job->shared++)
    {
        // The largest come first. More than half of what a thread has to do: the last one begun ends late.
        qcBodyPairRange* meeting = MeetingAt(all, job->shared);
        if (meeting->pairCount < qc_leastSharedPairs || meeting->pairCount < job->input->count / (2 * threads))
            break;
        QC_TRY(Build(job, meeting, 0, threads));
    }
    qcParallel_For(threads, all->meetings.count - job->shared, qc_leastMeetings, TakeMeeting, job);
    return qcWorkerResults_End(&all->makers, sizeof(qcManifoldBuilder));
}

static qcStatus EmptyMakers(qcAllManifolds* all, uint32_t threads)
{
    const qcOverlapKernels* sight = qcOverlapKernels_Get();
    QC_TRY(qcWorkerResults_Begin(&all->makers, threads, sizeof(qcManifoldBuilder), "manifolds"));
    for (size_t i = 0; i < all->makers.count; i++)
    {
        qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, all->makers, i);
        m->manifolds.count = m->points.count = 0;
        m->sight = sight;
    }
    return qc_statusOk;
}

/// In the order of the bodies.
static qcStatus Gather(qcAllManifolds* all)
{
    size_t manifoldCount = 0, pointCount = 0;
    for (size_t i = 0; i < all->makers.count; i++)
    {
        manifoldCount += QC_AT(qcManifoldBuilder, all->makers, i).manifolds.count;
        pointCount += QC_AT(qcManifoldBuilder, all->makers, i).points.count;
    }
    QC_TRY(qcArray_Reserve(&all->manifolds, manifoldCount, sizeof(qcManifold), "manifolds"));
    QC_TRY(qcArray_Reserve(&all->points, pointCount, sizeof(qcManifoldPoint), "manifolds"));
    for (size_t i = 0; i < all->meetings.count; i++)
    {
        const qcBodyPairRange* meeting = &QC_AT(qcBodyPairRange, all->meetings, i);
        const qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, all->makers, meeting->maker);
        for (size_t k = 0; k < meeting->manifoldCount; k++)
        {
            qcManifold* manifold = &QC_AT(qcManifold, all->manifolds, all->manifolds.count++);
            *manifold = QC_AT(qcManifold, m->manifolds, meeting->firstManifold + k);
            manifold->firstPoint += (uint32_t)all->points.count;
        }
        if (meeting->pointCount != 0)
            memcpy(&QC_AT(qcManifoldPoint, all->points, all->points.count),
                   &QC_AT(qcManifoldPoint, m->points, meeting->firstPoint),
                   meeting->pointCount * sizeof(qcManifoldPoint));
        all->points.count += meeting->pointCount;
    }
    return qc_statusOk;
}

qcStatus qcAllManifolds_Build(qcAllManifolds* all, const qcStepTriangles* triangles, const qcManifoldInput* input,
                              uint32_t threads)
{
    all->manifolds.count = all->points.count = 0;
    if (input->count == 0)
        return qc_statusOk;
    if (input->count > qc_maxManifoldPairs)
        return qcFail(qc_statusOutOfMemory, "out of memory: manifolds of %zu pairs", input->count);
    QC_TRY(EmptyMakers(all, threads));
    QC_TRY(ListRuns(all, input));
    QC_TRY(ListMeetings(all));
    Job job = {all, triangles, input, 0};
    QC_TRY(BuildAll(&job, threads));
    return Gather(all);
}

void qcAllManifolds_Free(qcAllManifolds* all)
{
    for (size_t i = 0; i < all->makers.count; i++)
        qcManifoldBuilder_Free(&QC_AT(qcManifoldBuilder, all->makers, i));
    qcArray* arrays[] = {&all->runs,   &all->meetings,  &all->order, &all->scratch,
                         &all->makers, &all->manifolds, &all->points};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
