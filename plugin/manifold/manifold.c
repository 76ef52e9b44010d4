// Manifolds of all bodies. The manifolds of two bodies depend on no others: a worker builds them from their pairs
// alone, which fit into a core's caches. Where two bodies have so many pairs that one worker would finish last, all
// share them.
#include "manifold/manifold.h"

#include "manifold/manifold_builder.h"
#include "manifold/overlap_kernels.h"
#include "manifold/stage_switches.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // A body pair takes from 1 to 1 000 microseconds.
    qc_minBodyPairs = 4,
    // Min pairs for which threads at every stage pay: they take about a millisecond.
    qc_minSharedPairs = 256,
    // More than fits into the memory of any machine. Numbers of pair sides have 32 bits, with room for two more bits.
    qc_maxManifoldPairs = 1 << 28
};

/// Two bodies, or one with itself.
typedef struct qcBodyPairRange
{
    uint32_t firstRun, runCount;
    uint32_t pairCount;
    uint32_t builder;                 ///< index of the builder that holds the manifolds
    size_t firstManifold, firstPoint; ///< in the lists of the builder
    size_t manifoldCount, pointCount;
} qcBodyPairRange;

typedef struct Job
{
    qcAllManifolds* all;
    const qcStepTriangles* triangles;
    const qcManifoldInput* input;
    size_t shared; ///< number of body pairs built by all threads together; the others are built by one worker each
} Job;

//  ---- body pairs -----------------------------------------------------------------------------------------

static uint64_t BodiesOf(const qcPair* pair)
{
    return (uint64_t)pair->bodyA << 32 | pair->bodyB;
}

/// The end of the pairs from `first` on that have the bodies and the triangle of A in common.
static size_t EndOfRun(const qcManifoldInput* input, size_t first)
{
    const qcPair* pair = &input->pairs[first];
    size_t end = first + 1;
    while (end < input->count && input->pairs[end].triangleA == pair->triangleA &&
           BodiesOf(&input->pairs[end]) == BodiesOf(pair))
        end++;
    return end;
}

/// Lists the runs sorted by bodies. Runs of the same two bodies stay in the order of their pairs.
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

static qcStatus ListBodyPairs(qcAllManifolds* all)
{
    const qcSortItem* runs = all->runs.data;
    size_t count = 0;
    for (size_t r = 0; r < all->runs.count; r++)
        count += r == 0 || runs[r].key != runs[r - 1].key;
    QC_TRY(qcArray_Resize(&all->bodyPairs, count, sizeof(qcBodyPairRange), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&all->order, count, sizeof(qcSortItem), "pairs of manifolds"));
    qcBodyPairRange* bodyPair = all->bodyPairs.data;
    for (uint32_t r = 0; r < all->runs.count; r++)
    {
        if (r == 0 || runs[r].key != runs[r - 1].key)
        {
            bodyPair += r != 0;
            *bodyPair = (qcBodyPairRange){.firstRun = r};
        }
        bodyPair->runCount++;
        bodyPair->pairCount += (uint32_t)runs[r].value;
    }
    for (size_t i = 0; i < count; i++)
        QC_AT(qcSortItem, all->order, i) =
            (qcSortItem){UINT32_MAX - QC_AT(qcBodyPairRange, all->bodyPairs, i).pairCount, (uint64_t)i};
    return qcSort_Items(all->order.data, count, &all->scratch);
}

static qcBodyPairRange* BodyPairAt(const qcAllManifolds* all, size_t i)
{
    return &QC_AT(qcBodyPairRange, all->bodyPairs, QC_AT(qcSortItem, all->order, i).value);
}

//  ---- their manifolds ------------------------------------------------------------------------------------

static qcStatus Build(const Job* job, qcBodyPairRange* bodyPair, uint32_t builder, uint32_t threads)
{
    qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, job->all->builders, builder);
    const qcBodyPairInput input = {.reported = job->input,
                                   .runs = &QC_AT(qcSortItem, job->all->runs, bodyPair->firstRun),
                                   .runCount = bodyPair->runCount,
                                   .pairCount = bodyPair->pairCount};
    bodyPair->builder = builder;
    bodyPair->firstManifold = m->manifolds.count;
    bodyPair->firstPoint = m->manifoldPoints.count;
    QC_TRY(qcManifoldBuilder_Build(m, job->triangles, &input, threads));
    bodyPair->manifoldCount = m->manifolds.count - bodyPair->firstManifold;
    bodyPair->pointCount = m->manifoldPoints.count - bodyPair->firstPoint;
    return qc_statusOk;
}

static void BuildOne(void* context, size_t index, uint32_t worker)
{
    const Job* job = context;
    qcWorkerResult* result = &QC_AT(qcManifoldBuilder, job->all->builders, worker).result;
    if (qcWorkerResult_IsOk(result))
        (void)qcWorkerResult_Add(result, Build(job, BodyPairAt(job->all, job->shared + index), worker, 1));
}

static qcStatus BuildAll(Job* job, uint32_t threads)
{
    const qcAllManifolds* all = job->all;
    for (; threads > 1 && job->shared < all->bodyPairs.count; job->shared++)
    {
        // The largest body pairs come first. One with more than a thread's share of the pairs is built by all threads:
        // one worker would delay the end.
        qcBodyPairRange* bodyPair = BodyPairAt(all, job->shared);
        if (bodyPair->pairCount < qc_minSharedPairs || bodyPair->pairCount < job->input->count / threads)
            break;
        QC_TRY(Build(job, bodyPair, 0, threads));
    }
    qcParallel_ForLargestFirst(threads, all->bodyPairs.count - job->shared, qc_minBodyPairs, BuildOne, job);
    return qcWorkerResults_End(&all->builders, sizeof(qcManifoldBuilder));
}

static qcStatus BeginBuilders(qcAllManifolds* all, uint32_t threads)
{
    const qcOverlapKernels* kernels = qcOverlapKernels_Get();
    QC_TRY(qcWorkerResults_Begin(&all->builders, threads, sizeof(qcManifoldBuilder), "manifolds"));
    for (size_t i = 0; i < all->builders.count; i++)
    {
        qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, all->builders, i);
        m->manifolds.count = m->manifoldPoints.count = 0;
        m->kernels = kernels;
    }
    return qc_statusOk;
}

/// Appends the manifolds of all body pairs in the order of the bodies.
static qcStatus Gather(qcAllManifolds* all)
{
    size_t manifoldCount = 0, pointCount = 0;
    for (size_t i = 0; i < all->builders.count; i++)
    {
        manifoldCount += QC_AT(qcManifoldBuilder, all->builders, i).manifolds.count;
        pointCount += QC_AT(qcManifoldBuilder, all->builders, i).manifoldPoints.count;
    }
    QC_TRY(qcArray_Reserve(&all->manifolds, manifoldCount, sizeof(qcManifold), "manifolds"));
    QC_TRY(qcArray_Reserve(&all->points, pointCount, sizeof(qcManifoldPoint), "manifolds"));
    for (size_t i = 0; i < all->bodyPairs.count; i++)
    {
        const qcBodyPairRange* bodyPair = &QC_AT(qcBodyPairRange, all->bodyPairs, i);
        const qcManifoldBuilder* m = &QC_AT(qcManifoldBuilder, all->builders, bodyPair->builder);
        for (size_t k = 0; k < bodyPair->manifoldCount; k++)
        {
            qcManifold* manifold = &QC_AT(qcManifold, all->manifolds, all->manifolds.count++);
            *manifold = QC_AT(qcManifold, m->manifolds, bodyPair->firstManifold + k);
            manifold->firstPoint += (uint32_t)all->points.count;
        }
        if (bodyPair->pointCount != 0)
            memcpy(&QC_AT(qcManifoldPoint, all->points, all->points.count),
                   &QC_AT(qcManifoldPoint, m->manifoldPoints, bodyPair->firstPoint),
                   bodyPair->pointCount * sizeof(qcManifoldPoint));
        all->points.count += bodyPair->pointCount;
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
    QC_READ_STAGE_SWITCHES();
    QC_TRY(BeginBuilders(all, threads));
    QC_TRY(ListRuns(all, input));
    QC_TRY(ListBodyPairs(all));
    Job job = {all, triangles, input, 0};
    QC_TRY(BuildAll(&job, threads));
    return Gather(all);
}

void qcAllManifolds_Free(qcAllManifolds* all)
{
    for (size_t i = 0; i < all->builders.count; i++)
        qcManifoldBuilder_Free(&QC_AT(qcManifoldBuilder, all->builders, i));
    qcArray* arrays[] = {&all->runs,     &all->bodyPairs, &all->order, &all->scratch,
                         &all->builders, &all->manifolds, &all->points};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
