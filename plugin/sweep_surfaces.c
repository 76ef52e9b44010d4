// Which bodies have surfaces, and what pairs of places mean.
#include "sweep_surfaces.h"

#include "parallel.h"
#include "status.h"

#include <string.h>

enum
{
    // A body no larger is laid together at once, in about a millisecond.
    qc_smallBody = 4096
};

static qcSurface* SurfaceAt(const qcSweepSurfaces* sweep, uint32_t slot)
{
    return &QC_AT(qcSurface, sweep->surfaces, slot);
}

/// Room for all slots; surfaces of bodies that are gone are freed.
static qcStatus SyncSlots(qcSweepSurfaces* sweep, const qcTriangles* t)
{
    const qcArray* slots = &t->bodies->slots;
    size_t old = sweep->surfaces.count;
    QC_TRY(qcArray_GrowZeroed(&sweep->surfaces, slots->count, sizeof(qcSurface), "surfaces"));
    QC_TRY(qcArray_GrowZeroed(&sweep->seen, slots->count, sizeof(uint32_t), "surfaces"));
    for (uint32_t slot = 0; slot < old; slot++)
    {
        qcSurface* surface = SurfaceAt(sweep, slot);
        if (surface->generation != 0 && surface->generation != QC_AT(qcBody, *slots, slot).generation)
            qcSurface_Free(surface);
    }
    return qc_statusOk;
}

/// Has the body a surface in this step? A large one that is new and meets itself has not: what is made for its pairs
/// with itself takes as long as a step without it, and its topology may not live for another. Where neighbours are
/// asked for such a step takes twice as long.
static bool MayHaveSurface(qcSweepSurfaces* sweep, uint32_t slot, const qcBody* body, bool listNeighbours)
{
    uint32_t* seen = &QC_AT(uint32_t, sweep->seen, slot);
    bool isNew = *seen != body->generation;
    *seen = body->generation;
    return SurfaceAt(sweep, slot)->generation != 0 || !isNew || !qcBody_MeetsItself(body) ||
           body->triangleCount <= qc_smallBody || listNeighbours;
}

typedef struct Making
{
    qcSweepSurfaces* sweep;
    const qcTriangles* triangles;
    uint32_t threads; ///< of each
} Making;

static void MakeOne(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Making* making = context;
    qcSurfaceToMake* order = &QC_AT(qcSurfaceToMake, making->sweep->toMake, i);
    const qcBody* body = qcTriangles_Body(making->triangles, order->body);
    qcSurface* surface = SurfaceAt(making->sweep, qcTriangles_Slot(making->triangles, order->body));
    order->status = surface->generation == 0 ? qcSurface_Build(surface, body, making->threads)
                                             : qcSurface_Relate(surface, body, making->threads);
}

/// Surfaces that are wanted and not there yet, or that have not been asked for pairs with themselves before.
static qcStatus MakeSurfaces(qcSweepSurfaces* sweep, const qcTriangles* triangles, uint32_t threads,
                             const uint8_t* wanted)
{
    sweep->toMake.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcSurface* surface = SurfaceAt(sweep, qcTriangles_Slot(triangles, body));
        bool relates = qcBody_MeetsItself(qcTriangles_Body(triangles, body)) && !surface->related;
        if (!wanted[body] || (surface->generation != 0 && !relates))
            continue;
        size_t at = sweep->toMake.count;
        QC_TRY(qcArray_Resize(&sweep->toMake, at + 1, sizeof(qcSurfaceToMake), "surfaces"));
        QC_AT(qcSurfaceToMake, sweep->toMake, at) = (qcSurfaceToMake){body, qc_statusOk};
    }
    // Several side by side, or one by all.
    Making making = {sweep, triangles, sweep->toMake.count == 1 ? threads : 1};
    qcParallel_For(sweep->toMake.count == 1 ? 1 : threads, sweep->toMake.count, 2, MakeOne, &making);
    for (size_t i = 0; i < sweep->toMake.count; i++)
        // The message is the worker's own; say it again on this thread.
        if (QC_AT(qcSurfaceToMake, sweep->toMake, i).status != qc_statusOk)
            return qcArray_FailAgain(&sweep->toMake, "surfaces");
    return qc_statusOk;
}

qcStatus qcSweepSurfaces_Prepare(qcSweepSurfaces* sweep, const qcTriangles* triangles, double margin, uint32_t threads,
                                 bool listNeighbours, uint8_t* wanted)
{
    if (sweep->kernels == NULL)
        sweep->kernels = qcSurfaceKernels_Get();
    QC_TRY(SyncSlots(sweep, triangles));
    sweep->fittedTriangles = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        bool may =
            MayHaveSurface(sweep, qcTriangles_Slot(triangles, body), qcTriangles_Body(triangles, body), listNeighbours);
        wanted[body] = wanted[body] && may;
    }
    QC_TRY(MakeSurfaces(sweep, triangles, threads, wanted));
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        if (!wanted[body])
            continue;
        const qcBody* b = qcTriangles_Body(triangles, body);
        qcSurface* surface = SurfaceAt(sweep, qcTriangles_Slot(triangles, body));
        bool fits;
        uint64_t before = surface->fits;
        QC_TRY(qcSurface_Fit(surface, b, margin, sweep->kernels, threads, &sweep->scratch, &fits));
        sweep->fittedTriangles += surface->fits != before ? b->triangleCount : 0;
        wanted[body] = fits;
    }
    return qc_statusOk;
}

//  ---- pairs ---------------------------------------------------------------------------------------

typedef struct Run
{
    qcSweepSurfaces* sweep;
    const qcSweepSurfacesJob* job;
    bool flatDiscs; ///< what is flat doesn't come near itself, but where it is neighbour of itself
    //  the two bodies that are looked at
    const uint32_t* triangles[2];
    uint32_t first[2];
} Run;

static uint64_t KeyOf(const void* context, qcPlacePair pair)
{
    const Run* run = context;
    return qcTriangles_Key(run->first[0] + run->triangles[0][pair.a], run->first[1] + run->triangles[1][pair.b]);
}

static bool AddKeys(void* context, const qcFoundPairs* found, uint32_t worker)
{
    const Run* run = context;
    return qcPairSink_Add(&QC_AT(qcPairSink, run->sweep->sinks, worker), found, run->job->listNeighbours, KeyOf, run);
}

/// Flags for the nodes of bodies whose triangles need not all take part.
static qcStatus ClearReached(const Run* run)
{
    qcSweepSurfaces* sweep = run->sweep;
    const qcTriangles* t = run->job->triangles;
    size_t nodes = 0;
    QC_TRY(qcArray_Resize(&sweep->firstReached, t->bodyCount, sizeof(size_t), "nodes that are reached"));
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        bool some = run->job->bodies[body] && !qcBody_MeetsItself(qcTriangles_Body(t, body));
        QC_AT(size_t, sweep->firstReached, body) = some ? nodes : SIZE_MAX;
        nodes += some ? SurfaceAt(sweep, qcTriangles_Slot(t, body))->clusters.nodeCount : 0;
    }
    QC_TRY(qcArray_Resize(&sweep->reached, nodes, 1, "nodes that are reached"));
    if (nodes != 0)
        memset(sweep->reached.data, 0, nodes);
    return qc_statusOk;
}

static uint8_t* ReachedOf(const qcSweepSurfaces* sweep, uint32_t body)
{
    size_t first = QC_AT(size_t, sweep->firstReached, body);
    return first != SIZE_MAX ? &QC_AT(uint8_t, sweep->reached, first) : NULL;
}

static qcSurface* SurfaceOf(const Run* run, uint32_t body)
{
    return SurfaceAt(run->sweep, qcTriangles_Slot(run->job->triangles, body));
}

/// What pairs of places are of from now on.
static void LookAt(Run* run, uint32_t a, uint32_t b)
{
    const uint32_t bodies[2] = {a, b};
    for (int i = 0; i < 2; i++)
    {
        run->first[i] = qcTriangles_First(run->job->triangles, bodies[i]);
        run->triangles[i] = SurfaceOf(run, bodies[i])->clusters.triangles.data;
    }
}

static qcStatus FindPairs(Run* run, uint32_t a, uint32_t b)
{
    qcSweepSurfaces* sweep = run->sweep;
    const qcSweepSurfacesJob* job = run->job;
    // What is in the world comes first: the other goes to its coordinates, and nothing has to be inverted.
    if (SurfaceOf(run, a)->isLocal && !SurfaceOf(run, b)->isLocal)
    {
        uint32_t first = b;
        b = a;
        a = first;
    }
    const qcBody *bodyA = qcTriangles_Body(job->triangles, a), *bodyB = qcTriangles_Body(job->triangles, b);
    double nearest = qcBody_PairMargin(bodyA, bodyB, job->nearest);
    qcSurfacePairsJob pairs = {.kernels = sweep->kernels,
                               .a = SurfaceOf(run, a),
                               .b = SurfaceOf(run, b),
                               .bodyA = bodyA,
                               .bodyB = bodyB,
                               .margin = nearest > job->contactReach ? nearest : job->contactReach,
                               .nearest = nearest,
                               .neighbours = job->testNeighbours,
                               .flatDiscs = run->flatDiscs && a == b,
                               .threads = job->threads,
                               .reachedA = ReachedOf(sweep, a),
                               .reachedB = ReachedOf(sweep, b),
                               .function = AddKeys,
                               .context = run};
    LookAt(run, a, b);
    return qcSurfacePairs_Find(&sweep->pairs, &pairs);
}

static void AddContactKeys(void* context, const qcPlacePair* pairs, size_t count, uint32_t worker)
{
    const Run* run = context;
    qcPairSink_AddNeighbours(&QC_AT(qcPairSink, run->sweep->sinks, worker), pairs, count, KeyOf, run);
}

static qcStatus AddNeighbours(Run* run, uint32_t body, qcProfile* profile)
{
    qcSurface* surface = SurfaceOf(run, body);
    if (run->job->testNeighbours)
        return qc_statusOk;
    profile->skippedNeighbours += surface->clusters.neighbourCount;
    LookAt(run, body, body);
    qcSurfaceNeighboursJob job = {.kernels = run->sweep->kernels,
                                  .surface = surface,
                                  .threads = run->job->threads,
                                  .function = AddContactKeys,
                                  .context = run};
    return run->job->listNeighbours ? qcSurfaceNeighbours_Find(&job) : qc_statusOk;
}

static void CountTriangles(const Run* run, uint32_t body, qcProfile* profile)
{
    const qcBody* b = qcTriangles_Body(run->job->triangles, body);
    const uint8_t* reached = ReachedOf(run->sweep, body);
    uint32_t left = b->triangleCount;
    if (reached != NULL)
    {
        const qcClusters* clusters = &SurfaceOf(run, body)->clusters;
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
    qcSurface* surface = SurfaceOf(run, body);
    if (!run->flatDiscs)
        return;
    qcSurface_FindFlat(surface, run->sweep->kernels, run->job->threads);
    profile->flatTriangles += qcSurface_CountFlat(surface);
}

qcStatus qcSweepSurfaces_Run(qcSweepSurfaces* sweep, const qcSweepSurfacesJob* job, qcProfile* profile)
{
    const qcTriangles* t = job->triangles;
    Run run = {.sweep = sweep, .job = job, .flatDiscs = !job->testNeighbours};
    QC_TRY(qcPairSinks_Begin(&sweep->sinks, job->threads));
    QC_TRY(ClearReached(&run));
    for (size_t i = 0; i < job->objects->pairs.count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, job->objects->pairs, i);
        if (job->bodies[pair.a])
            QC_TRY(FindPairs(&run, pair.a, pair.b));
    }
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        if (!job->bodies[body] && !job->neighbourBodies[body])
            continue;
        if (job->bodies[body])
            CountTriangles(&run, body, profile);
        if (!qcBody_MeetsItself(qcTriangles_Body(t, body)))
            continue;
        FindFlat(&run, body, profile);
        if (job->bodies[body])
            QC_TRY(FindPairs(&run, body, body));
        QC_TRY(AddNeighbours(&run, body, profile));
    }
    profile->fittedTriangles += sweep->fittedTriangles;
    qcCandidates* candidates = job->candidates;
    qcPairKeys keys = {&candidates->keys, &candidates->neighbourKeys, &candidates->sure};
    return qcPairSinks_End(&sweep->sinks, &keys);
}

void qcSweepSurfaces_Free(qcSweepSurfaces* sweep)
{
    for (uint32_t slot = 0; slot < sweep->surfaces.count; slot++)
        qcSurface_Free(SurfaceAt(sweep, slot));
    qcPairSinks_Free(&sweep->sinks);
    qcSurfacePairs_Free(&sweep->pairs);
    qcSurfaceScratch_Free(&sweep->scratch);
    qcArray* arrays[] = {&sweep->surfaces, &sweep->seen, &sweep->toMake, &sweep->reached, &sweep->firstReached};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
