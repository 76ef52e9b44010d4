// Which bodies have surfaces, and what pairs of places mean.
#include "sweep/bvh_candidates.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/partial_refit.h"

#include <string.h>

enum
{
    // A body no larger is laid together at once, in about a millisecond.
    qc_smallBody = 4096
};

static qcBodyBvh* BvhAt(const qcBvhCandidates* sweep, uint32_t slot)
{
    return &QC_AT(qcBodyBvh, sweep->bvhs, slot);
}

/// Room for all slots; surfaces of bodies that are gone are freed.
static qcStatus SyncSlots(qcBvhCandidates* sweep, const qcStepTriangles* t)
{
    const qcArray* slots = &t->bodies->slots;
    size_t old = sweep->bvhs.count;
    QC_TRY(qcArray_GrowZeroed(&sweep->bvhs, slots->count, sizeof(qcBodyBvh), "surfaces"));
    QC_TRY(qcArray_GrowZeroed(&sweep->seen, slots->count, sizeof(uint32_t), "surfaces"));
    for (uint32_t slot = 0; slot < old; slot++)
    {
        qcBodyBvh* bvh = BvhAt(sweep, slot);
        if (bvh->bvh.generation != 0 && bvh->bvh.generation != QC_AT(qcBody, *slots, slot).generation)
            qcBodyBvh_Free(bvh);
    }
    return qc_statusOk;
}

/// Has the body a surface in this step? A large one that is new and meets itself has not: what is made for its pairs
/// with itself takes as long as a step without it, and its topology may not live for another. Where neighbours are
/// asked for such a step takes twice as long.
static bool MayHaveSurface(qcBvhCandidates* sweep, uint32_t slot, const qcBody* body, bool listNeighbours)
{
    uint32_t* seen = &QC_AT(uint32_t, sweep->seen, slot);
    bool isNew = *seen != body->generation;
    *seen = body->generation;
    return BvhAt(sweep, slot)->bvh.generation != 0 || !isNew || !qcBody_HasSelfCollision(body) ||
           body->triangleCount <= qc_smallBody || listNeighbours;
}

typedef struct Mending
{
    qcBvhCandidates* sweep;
    const qcStepTriangles* triangles;
    double margin;
    uint32_t threads; ///< of each
} Mending;

static qcRefitTask* OrderAt(const qcBvhCandidates* sweep, size_t i)
{
    return &QC_AT(qcRefitTask, sweep->orders, i);
}

static qcStatus AddOrder(qcBvhCandidates* sweep, uint32_t body)
{
    size_t at = sweep->orders.count;
    QC_TRY(qcArray_Resize(&sweep->orders, at + 1, sizeof(qcRefitTask), "surfaces"));
    *OrderAt(sweep, at) = (qcRefitTask){.body = body};
    return qc_statusOk;
}

static void AddResult(const qcBvhCandidates* sweep, uint32_t worker, qcStatus status)
{
    (void)qcWorkerResult_Add(&QC_AT(qcWorkerResult, sweep->results, worker), status);
}

static void MakeOne(void* context, size_t i, uint32_t worker)
{
    const Mending* making = context;
    const qcRefitTask* order = OrderAt(making->sweep, i);
    const qcBody* body = qcStepTriangles_Body(making->triangles, order->body);
    qcBodyBvh* bvh = BvhAt(making->sweep, qcStepTriangles_Slot(making->triangles, order->body));
    AddResult(making->sweep, worker,
              bvh->bvh.generation == 0 ? qcBodyBvh_Build(bvh, body, making->threads)
                                       : qcBodyBvh_BuildAdjacency(bvh, body, making->threads));
}

/// Surfaces that are wanted and not there yet, or that have not been asked for pairs with themselves before.
static qcStatus MakeSurfaces(qcBvhCandidates* sweep, const qcStepTriangles* triangles, uint32_t threads,
                             const uint8_t* wanted)
{
    sweep->orders.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcBodyBvh* bvh = BvhAt(sweep, qcStepTriangles_Slot(triangles, body));
        bool relates = qcBody_HasSelfCollision(qcStepTriangles_Body(triangles, body)) && !bvh->hasAdjacency;
        if (wanted[body] && (bvh->bvh.generation == 0 || relates))
            QC_TRY(AddOrder(sweep, body));
    }
    QC_TRY(qcWorkerResults_Begin(&sweep->results, threads, sizeof(qcWorkerResult), "surfaces"));
    // Several side by side, or one by all.
    size_t count = sweep->orders.count;
    Mending making = {.sweep = sweep, .triangles = triangles, .threads = count == 1 ? threads : 1};
    qcParallel_For(count == 1 ? 1 : threads, count, 2, MakeOne, &making);
    return qcWorkerResults_End(&sweep->results, sizeof(qcWorkerResult));
}

static void FitOne(void* context, size_t i, uint32_t worker)
{
    const Mending* fitting = context;
    const qcBvhCandidates* sweep = fitting->sweep;
    qcRefitTask* order = OrderAt(sweep, i);
    qcBodyBvh* bvh = BvhAt(sweep, qcStepTriangles_Slot(fitting->triangles, order->body));
    AddResult(sweep, worker,
              qcTriangleBvh_Fit(&bvh->bvh, qcStepTriangles_Body(fitting->triangles, order->body), fitting->margin,
                                sweep->kernels, fitting->threads, &QC_AT(qcBvhScratch, sweep->scratches, worker),
                                &order->fits));
}

/// How far apart triangles of two bodies, or of one, count: what is near, and what is a candidate.
static double PairMargin(const qcBvhCandidatesJob* job, const qcBody* a, const qcBody* b)
{
    double nearest = qcBody_PairMargin(a, b, job->nearest);
    double contacts = qcContactDistance(qcBody_PairMargin(a, b, job->contactMargin));
    return nearest > contacts ? nearest : contacts;
}

/// A body that meets itself, whose pairs within more than the job's margin are kept, may have moved but a little since.
static qcStatus TryToFollow(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, uint32_t body)
{
    qcBodyBvh* bvh = BvhAt(sweep, qcStepTriangles_Slot(job->triangles, body));
    const qcBody* b = qcStepTriangles_Body(job->triangles, body);
    bool follows = false;
    if (qcBody_HasSelfCollision(b) && !job->testNeighbours && !job->listNeighbours && job->margin <= bvh->bvh.margin)
        QC_TRY(qcBodyBvh_PartialRefit(bvh, b, (bvh->verlet.margin - PairMargin(job, b, b)) / 2.0, sweep->kernels,
                                      &QC_AT(qcBvhScratch, sweep->scratches, 0), &follows));
    QC_AT(uint8_t, sweep->followed, body) = follows;
    return qc_statusOk;
}

/// Surfaces that follow their bodies, and orders for the others that are not where they are.
static qcStatus FollowOrOrder(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, const uint8_t* wanted)
{
    const qcStepTriangles* triangles = job->triangles;
    QC_TRY(qcArray_Resize(&sweep->followed, triangles->bodyCount, 1, "surfaces"));
    sweep->orders.count = 0;
    sweep->fittedTriangles = sweep->followedTriangles = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(triangles, body);
        QC_AT(uint8_t, sweep->followed, body) = 0;
        if (!wanted[body] ||
            qcTriangleBvh_IsUpToDate(&BvhAt(sweep, qcStepTriangles_Slot(triangles, body))->bvh, b, job->margin))
            continue;
        QC_TRY(TryToFollow(sweep, job, body));
        if (QC_AT(uint8_t, sweep->followed, body))
        {
            sweep->followedTriangles += b->triangleCount;
            continue;
        }
        QC_TRY(AddOrder(sweep, body));
        sweep->fittedTriangles += b->triangleCount;
    }
    return qc_statusOk;
}

/// Large bodies one after another by all threads, then the others side by side.
static qcStatus FitSurfaces(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, uint8_t* wanted)
{
    const qcStepTriangles* triangles = job->triangles;
    uint32_t threads = job->threads;
    QC_TRY(qcArray_GrowZeroed(&sweep->scratches, threads, sizeof(qcBvhScratch), "fitting surfaces"));
    QC_TRY(qcWorkerResults_Begin(&sweep->results, threads, sizeof(qcWorkerResult), "fitting surfaces"));
    QC_TRY(FollowOrOrder(sweep, job, wanted));
    uint64_t left = sweep->fittedTriangles;
    uint64_t large = left / (4 * (uint64_t)threads);
    Mending fitting = {sweep, triangles, job->margin, threads};
    size_t small = 0;
    for (size_t i = 0; i < sweep->orders.count; i++)
    {
        uint32_t count = qcStepTriangles_Body(triangles, OrderAt(sweep, i)->body)->triangleCount;
        if (count >= large)
        {
            FitOne(&fitting, i, 0);
            left -= count;
            continue;
        }
        qcRefitTask done = *OrderAt(sweep, small);
        *OrderAt(sweep, small++) = *OrderAt(sweep, i);
        *OrderAt(sweep, i) = done;
    }
    fitting.threads = 1;
    qcParallel_For(left > qc_smallBody ? threads : 1, small, 2, FitOne, &fitting);
    for (size_t i = 0; i < sweep->orders.count; i++)
        wanted[OrderAt(sweep, i)->body] = OrderAt(sweep, i)->fits;
    return qcWorkerResults_End(&sweep->results, sizeof(qcWorkerResult));
}

qcStatus qcBvhCandidates_Prepare(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, uint8_t* wanted)
{
    const qcStepTriangles* triangles = job->triangles;
    if (sweep->kernels == NULL)
        sweep->kernels = qcTriangleKernels_Get();
    QC_TRY(SyncSlots(sweep, triangles));
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        bool may = MayHaveSurface(sweep, qcStepTriangles_Slot(triangles, body), qcStepTriangles_Body(triangles, body),
                                  job->listNeighbours && !job->testNeighbours);
        wanted[body] = wanted[body] && may;
    }
    QC_TRY(MakeSurfaces(sweep, triangles, job->threads, wanted));
    return FitSurfaces(sweep, job, wanted);
}

//  ---- pairs ---------------------------------------------------------------------------------------

typedef struct Run
{
    qcBvhCandidates* sweep;
    const qcBvhCandidatesJob* job;
    bool flatDiscs; ///< what is flat doesn't come near itself, but where it is neighbour of itself
    bool keeps;     ///< pairs within a body, for a step that follows
} Run;

/// What the places of a pair mean: triangles of these two surfaces, the first of which have these numbers in the step.
typedef struct PairOfSurfaces
{
    const Run* run;
    const uint32_t* triangles[2];
    uint32_t first[2];
    uint32_t keptOf; ///< slot of the body whose pairs these are, if they are kept, or UINT32_MAX
} PairOfSurfaces;

static uint64_t KeyOf(const void* context, qcSlotPair pair)
{
    const PairOfSurfaces* sides = context;
    return qcStepTriangles_Key(sides->first[0] + sides->triangles[0][pair.a],
                               sides->first[1] + sides->triangles[1][pair.b]);
}

static bool AddKeys(void* context, const qcClassifiedPairs* found, uint32_t worker)
{
    const PairOfSurfaces* sides = context;
    const Run* run = sides->run;
    if (sides->keptOf != UINT32_MAX)
        qcVerletList_Add(&run->sweep->kept, sides->keptOf, found, worker);
    return qcPairBuffer_Add(&QC_AT(qcPairBuffer, run->sweep->sinks, worker), found, run->job->listNeighbours, KeyOf,
                            sides);
}

/// Flags for the nodes of bodies whose triangles need not all take part.
static qcStatus ClearReached(const Run* run)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcStepTriangles* t = run->job->triangles;
    size_t nodes = 0;
    QC_TRY(qcArray_Resize(&sweep->firstReached, t->bodyCount, sizeof(size_t), "nodes that are reached"));
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        bool some = run->job->bodies[body] && !qcBody_HasSelfCollision(qcStepTriangles_Body(t, body));
        QC_AT(size_t, sweep->firstReached, body) = some ? nodes : SIZE_MAX;
        nodes += some ? BvhAt(sweep, qcStepTriangles_Slot(t, body))->bvh.clusters.nodeCount : 0;
    }
    QC_TRY(qcArray_Resize(&sweep->reached, nodes, 1, "nodes that are reached"));
    if (nodes != 0)
        memset(sweep->reached.data, 0, nodes);
    return qc_statusOk;
}

static uint8_t* ReachedOf(const qcBvhCandidates* sweep, uint32_t body)
{
    size_t first = QC_AT(size_t, sweep->firstReached, body);
    return first != SIZE_MAX ? &QC_AT(uint8_t, sweep->reached, first) : NULL;
}

static qcBodyBvh* BvhOf(const Run* run, uint32_t body)
{
    return BvhAt(run->sweep, qcStepTriangles_Slot(run->job->triangles, body));
}

static PairOfSurfaces MakeSides(const Run* run, uint32_t a, uint32_t b)
{
    PairOfSurfaces sides = {.run = run, .keptOf = UINT32_MAX};
    const uint32_t bodies[2] = {a, b};
    if (run->keeps && a == b)
        sides.keptOf = qcStepTriangles_Slot(run->job->triangles, a);
    for (int i = 0; i < 2; i++)
    {
        sides.first[i] = qcStepTriangles_First(run->job->triangles, bodies[i]);
        sides.triangles[i] = BvhOf(run, bodies[i])->bvh.clusters.triangles.data;
    }
    return sides;
}

/// There is room for it.
static void AddJob(const Run* run, uint32_t a, uint32_t b)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcBvhCandidatesJob* job = run->job;
    // What is in the world comes first: the other goes to its coordinates, and nothing has to be inverted.
    if (BvhOf(run, a)->bvh.isLocal && !BvhOf(run, b)->bvh.isLocal)
    {
        uint32_t first = b;
        b = a;
        a = first;
    }
    const qcBody *bodyA = qcStepTriangles_Body(job->triangles, a), *bodyB = qcStepTriangles_Body(job->triangles, b);
    PairOfSurfaces* sides = &QC_AT(PairOfSurfaces, sweep->sides, sweep->jobs.count);
    *sides = MakeSides(run, a, b);
    QC_AT(qcBvhPairsJob, sweep->jobs, sweep->jobs.count++) =
        (qcBvhPairsJob){.kernels = sweep->kernels,
                        .a = BvhOf(run, a),
                        .b = BvhOf(run, b),
                        .bodyA = bodyA,
                        .bodyB = bodyB,
                        .query = PairMargin(job, bodyA, bodyB),
                        .near = qcBody_PairMargin(bodyA, bodyB, job->nearest),
                        .includeNeighbours = job->testNeighbours,
                        .skipFlatPatches = run->flatDiscs && a == b,
                        .visitedA = ReachedOf(sweep, a),
                        .visitedB = ReachedOf(sweep, b),
                        .function = AddKeys,
                        .context = sides};
}

static bool IsAskedAboutItself(const Run* run, uint32_t body)
{
    return run->job->bodies[body] && qcBody_HasSelfCollision(qcStepTriangles_Body(run->job->triangles, body));
}

/// Of what isn't asked about nothing is known: it may not have been prepared.
static bool Follows(const Run* run, uint32_t body)
{
    return IsAskedAboutItself(run, body) && QC_AT(uint8_t, run->sweep->followed, body) != 0;
}

/// All at once, so that threads have enough to do where many small bodies meet; those within bodies that were followed
/// come last, and `searchCount` tells how many there are without them.
static qcStatus MakeJobs(const Run* run, size_t* searchCount)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcBvhCandidatesJob* job = run->job;
    const qcArray* pairs = &job->objects->pairs;
    size_t most = pairs->count + job->triangles->bodyCount;
    QC_TRY(qcArray_Reserve(&sweep->jobs, most, sizeof(qcBvhPairsJob), "pairs of surfaces"));
    QC_TRY(qcArray_Resize(&sweep->sides, most, sizeof(PairOfSurfaces), "pairs of surfaces"));
    sweep->jobs.count = 0;
    for (size_t i = 0; i < pairs->count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, *pairs, i);
        if (job->bodies[pair.a])
            AddJob(run, pair.a, pair.b);
    }
    for (int followed = 0; followed < 2; followed++)
    {
        for (uint32_t body = 0; body < job->triangles->bodyCount; body++)
            if (IsAskedAboutItself(run, body) && Follows(run, body) == (followed != 0))
                AddJob(run, body, body);
        if (!followed)
            *searchCount = sweep->jobs.count;
    }
    return qc_statusOk;
}

typedef struct KeptJobs
{
    const Run* run;
    size_t first;
} KeptJobs;

static void FindKept(void* context, size_t i, uint32_t worker)
{
    const KeptJobs* jobs = context;
    qcBvhCandidates* sweep = jobs->run->sweep;
    const qcBvhPairsJob* job = &QC_AT(qcBvhPairsJob, sweep->jobs, jobs->first + i);
    uint32_t slot = (uint32_t)(job->a - (const qcBodyBvh*)sweep->bvhs.data);
    qcVerletList_Find(&sweep->kept, slot, job, worker);
}

static qcStatus FindPairs(const Run* run)
{
    qcBvhCandidates* sweep = run->sweep;
    size_t searchCount = 0;
    QC_TRY(MakeJobs(run, &searchCount));
    QC_TRY(qcBvhPairs_Find(&sweep->pairs, sweep->jobs.data, searchCount, run->job->threads));
    KeptJobs kept = {run, searchCount};
    qcParallel_For(run->job->threads, sweep->jobs.count - searchCount, 2, FindKept, &kept);
    return qc_statusOk;
}

/// Whether what is found within a body is kept. Not where a body takes its pairs from those that were kept before,
/// which are good for more steps than those within a smaller margin would be.
static bool Keeps(const Run* run)
{
    bool finds = false, takes = false;
    for (uint32_t body = 0; body < run->job->triangles->bodyCount; body++)
    {
        finds = finds || IsAskedAboutItself(run, body);
        takes = takes || Follows(run, body);
    }
    return finds && !takes && run->job->margin > 0.0 && !run->job->testNeighbours;
}

/// From now on pairs within bodies are kept. What was kept before is of another step.
static qcStatus BeginToKeep(const Run* run)
{
    for (uint32_t slot = 0; slot < run->sweep->bvhs.count; slot++)
        qcVerletReference_Clear(&BvhAt(run->sweep, slot)->verlet);
    return qcVerletList_Begin(&run->sweep->kept, run->job->threads);
}

/// They have been found.
static qcStatus EndKeeping(const Run* run)
{
    QC_TRY(qcVerletList_Check(&run->sweep->kept));
    for (uint32_t body = 0; body < run->job->triangles->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(run->job->triangles, body);
        if (!IsAskedAboutItself(run, body) || !b->deforming)
            continue;
        QC_TRY(qcBodyBvh_SetVerletReference(BvhOf(run, body), b, PairMargin(run->job, b, b)));
    }
    return qc_statusOk;
}

static void AddContactKeys(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker)
{
    const PairOfSurfaces* sides = context;
    qcPairBuffer_AddNeighbours(&QC_AT(qcPairBuffer, sides->run->sweep->sinks, worker), pairs, count, KeyOf, sides);
}

static qcStatus AddNeighbours(const Run* run, uint32_t body, qcProfile* profile)
{
    qcBodyBvh* bvh = BvhOf(run, body);
    if (run->job->testNeighbours)
        return qc_statusOk;
    profile->skippedNeighbours += bvh->bvh.clusters.neighbourCount;
    PairOfSurfaces sides = MakeSides(run, body, body);
    qcNeighbourPairsJob job = {.kernels = run->sweep->kernels,
                               .body = bvh,
                               .threads = run->job->threads,
                               .function = AddContactKeys,
                               .context = &sides};
    return run->job->listNeighbours ? qcNeighbourPairs_Find(&job) : qc_statusOk;
}

static void CountTriangles(const Run* run, uint32_t body, qcProfile* profile)
{
    const qcBody* b = qcStepTriangles_Body(run->job->triangles, body);
    const uint8_t* reached = ReachedOf(run->sweep, body);
    uint32_t left = b->triangleCount;
    if (reached != NULL)
    {
        const qcClusters* clusters = &BvhOf(run, body)->bvh.clusters;
        left = 0;
        for (uint32_t node = 0; node < clusters->nodeCount; node++)
            left += reached[node] ? qc_nodeSize : 0;
        left = left < b->triangleCount ? left : b->triangleCount;
    }
    profile->selfBodies += reached == NULL;
    profile->trianglePcs += left;
    profile->skippedTriangles += b->triangleCount - left;
}

static void FindFlat(const Run* run, uint32_t body, qcProfile* profile)
{
    qcBodyBvh* bvh = BvhOf(run, body);
    if (!run->flatDiscs || Follows(run, body))
        return;
    qcPatchState_Test(&bvh->patches, &bvh->bvh, run->sweep->kernels, run->job->threads);
    profile->flatTriangles += qcPatchState_CountFlat(&bvh->patches);
}

qcStatus qcBvhCandidates_Run(qcBvhCandidates* sweep, const qcBvhCandidatesJob* job, qcProfile* profile)
{
    const qcStepTriangles* t = job->triangles;
    Run run = {.sweep = sweep, .job = job, .flatDiscs = !job->testNeighbours};
    run.keeps = Keeps(&run);
    QC_TRY(qcPairBuffers_Begin(&sweep->sinks, job->threads));
    QC_TRY(ClearReached(&run));
    if (run.keeps)
        QC_TRY(BeginToKeep(&run));
    for (uint32_t body = 0; body < t->bodyCount; body++)
        if (IsAskedAboutItself(&run, body) || job->neighbourBodies[body])
            FindFlat(&run, body, profile);
    QC_TRY(FindPairs(&run));
    if (run.keeps)
        QC_TRY(EndKeeping(&run));
    // What was reached is known now.
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        if (job->bodies[body])
            CountTriangles(&run, body, profile);
        if (IsAskedAboutItself(&run, body) || job->neighbourBodies[body])
            QC_TRY(AddNeighbours(&run, body, profile));
    }
    profile->fittedTriangles += sweep->fittedTriangles;
    profile->followedTriangles += sweep->followedTriangles;
    qcCandidates* candidates = job->candidates;
    qcPairKeys keys = {&candidates->keys, &candidates->neighbourKeys, &candidates->sure};
    return qcPairBuffers_End(&sweep->sinks, &keys);
}

void qcBvhCandidates_Free(qcBvhCandidates* sweep)
{
    for (uint32_t slot = 0; slot < sweep->bvhs.count; slot++)
        qcBodyBvh_Free(BvhAt(sweep, slot));
    qcPairBuffers_Free(&sweep->sinks);
    for (size_t i = 0; i < sweep->scratches.count; i++)
        qcBvhScratch_Free(&QC_AT(qcBvhScratch, sweep->scratches, i));
    qcBvhPairs_Free(&sweep->pairs);
    qcVerletList_Free(&sweep->kept);
    qcArray* arrays[] = {&sweep->bvhs,     &sweep->seen, &sweep->orders, &sweep->results, &sweep->scratches,
                         &sweep->followed, &sweep->jobs, &sweep->sides,  &sweep->reached, &sweep->firstReached};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
