// Which bodies have a BVH in this step, and its build, refit or partial refit.
#include "sweep/bvh_candidates.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "scene/float_positions.h"
#include "sweep/bvh/bvh_copy.h"
#include "sweep/bvh/partial_refit.h"
#include "sweep/copied_orders.h"

enum
{
    // The refit of a BVH for a body no larger takes some ten microseconds.
    qc_smallBody = 4096,
    // The topology of a body may not live for many steps. Its adjacency, which costs several searches, is built from
    // this search on.
    qc_searchesBefore = 2,
    // Leaf nodes whose share of the adjacency is built in a step in any case: 64 bodies of one node, 0.4 ms.
    qc_minAdjacency = 1024,
    // Steps over which copies make the lists of their outlines (8 bunnies of 69 666 triangles: all in the second step
    // 6 ms, spread out 3 ms at most).
    qc_outlineSteps = 4,
    // Triangles of a body whose order takes several times as long as finding those in a region.
    qc_minLimited = 1024
};

void qcBvhCandidates_Delete(qcBvhCandidates* sweep, uint32_t slot)
{
    qcBodyBvh* bvh = qcBvhCandidates_At(sweep, slot);
    if (bvh == NULL)
        return;
    qcBodyBvh_Free(bvh);
    qcFree(bvh, sizeof *bvh);
    QC_AT(qcBodyBvh*, sweep->bvhs, slot) = NULL;
}

/// Room for all slots, and an empty BVH for each flagged body without one; deletes BVHs of removed bodies.
static qcStatus SyncSlots(const qcStepTriangles* t, const uint8_t* flags, qcBvhCandidates* sweep)
{
    const qcArray* slots = &t->bodies->slots;
    size_t old = sweep->bvhs.count;
    QC_TRY(qcArray_GrowZeroed(&sweep->bvhs, slots->count, sizeof(qcBodyBvh*), "BVHs"));
    for (uint32_t slot = 0; slot < old; slot++)
    {
        const qcBodyBvh* bvh = qcBvhCandidates_At(sweep, slot);
        if (bvh != NULL && bvh->bvh.generation != 0 && bvh->bvh.generation != QC_AT(qcBody, *slots, slot).generation)
            qcBvhCandidates_Delete(sweep, slot);
    }
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        qcBodyBvh** bvh = &QC_AT(qcBodyBvh*, sweep->bvhs, qcStepTriangles_Slot(t, body));
        if (!flags[body] || *bvh != NULL)
            continue;
        *bvh = qcAllocateZeroed(sizeof **bvh);
        if (*bvh == NULL)
            return qcFailMemory(sizeof **bvh, "a BVH");
    }
    return qc_statusOk;
}

typedef struct Tasks
{
    qcBvhCandidates* sweep;
    const qcBvhCandidatesJob* job;
    size_t first;     ///< that is run
    double maxMargin; ///< of the bodies whose boxes need one
    uint32_t threads; ///< of each task
} Tasks;

static qcRefitTask* TaskAt(const qcBvhCandidates* sweep, size_t i)
{
    return &QC_AT(qcRefitTask, sweep->tasks, i);
}

static void SwapTasks(const qcBvhCandidates* sweep, size_t i, size_t k)
{
    qcRefitTask task = *TaskAt(sweep, i);
    *TaskAt(sweep, i) = *TaskAt(sweep, k);
    *TaskAt(sweep, k) = task;
}

static qcStatus AddTask(qcBvhCandidates* sweep, uint32_t body)
{
    size_t at = sweep->tasks.count;
    QC_TRY(qcArray_Resize(&sweep->tasks, at + 1, sizeof(qcRefitTask), "BVHs"));
    *TaskAt(sweep, at) = (qcRefitTask){.body = body, .order = body};
    return qc_statusOk;
}

static void AddResult(const qcBvhCandidates* sweep, uint32_t worker, qcStatus status)
{
    (void)qcWorkerResult_Add(&QC_AT(qcWorkerResult, sweep->results, worker), status);
}

//  ---- regions -------------------------------------------------------------------------------------

/// Whether only triangles that other bodies may come near can take part in the step, so that others can be left out.
static bool MayBeLimited(const qcBvhCandidatesJob* job, const qcBody* body)
{
    return body->deforming && !qcBody_HasSelfCollision(body) && !job->triangles->motion;
}

/// The region of a new body in which others may come near. False: there is none, or it would take too long to find.
static bool FindRegion(const qcBvhCandidatesJob* job, uint32_t body, qcBvhRegion* region)
{
    const qcBody* b = qcStepTriangles_Body(job->triangles, body);
    const qcArray* pairs = &job->pairs->pairs;
    if (!MayBeLimited(job, b) || b->triangleCount < qc_minLimited || pairs->count > b->triangleCount ||
        !qcBvhRegion_Begin(region, b))
        return false;
    for (size_t i = 0; i < pairs->count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, *pairs, i);
        if (pair.a == body || pair.b == body)
            qcBvhRegion_Include(region, qcStepTriangles_Body(job->triangles, pair.a == body ? pair.b : pair.a),
                                job->queryDistance);
    }
    return true;
}

static void FollowOne(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Tasks* tasks = context;
    uint32_t body = TaskAt(tasks->sweep, i)->body;
    const qcStepTriangles* triangles = tasks->job->triangles;
    qcTriangleBvh* bvh = &qcBvhCandidates_At(tasks->sweep, qcStepTriangles_Slot(triangles, body))->bvh;
    const qcBody* b = qcStepTriangles_Body(triangles, body);
    bvh->leavesRegion = !MayBeLimited(tasks->job, b);
    if (!bvh->leavesRegion)
        qcBvhRegion_Follow(bvh->region, b);
}

/// Finds out which limited BVHs lack triangles that may take part in the step.
static qcStatus FollowRegions(const qcBvhCandidatesJob* job, const uint8_t* flags, qcBvhCandidates* sweep)
{
    const qcStepTriangles* triangles = job->triangles;
    sweep->tasks.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
        if (flags[body] && qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, body))->bvh.region != NULL)
            QC_TRY(AddTask(sweep, body));
    if (sweep->tasks.count == 0)
        return qc_statusOk;
    Tasks tasks = {.sweep = sweep, .job = job};
    qcParallel_For(job->threads, sweep->tasks.count, 2, FollowOne, &tasks);
    for (size_t i = 0; i < job->pairs->pairs.count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, job->pairs->pairs, i);
        const uint32_t bodies[2] = {pair.a, pair.b};
        for (int side = 0; side < 2; side++)
        {
            qcBodyBvh* bvh = qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, bodies[side]));
            if (flags[bodies[side]] && bvh->bvh.region != NULL && !bvh->bvh.leavesRegion)
                bvh->bvh.leavesRegion = !qcBvhRegion_Covers(
                    bvh->bvh.region, qcStepTriangles_Body(triangles, bodies[1 - side]), job->queryDistance);
        }
    }
    return qc_statusOk;
}

//  ---- builds --------------------------------------------------------------------------------------

static bool NeedsOrder(const qcTriangleBvh* bvh)
{
    return bvh->leavesRegion || qcTriangleBvh_HasGrown(bvh);
}

/// The BVH whose order a task's body takes over, or null.
static const qcTriangleBvh* FindOrder(const Tasks* tasks, const qcRefitTask* task, const qcBody* body)
{
    const qcStepTriangles* triangles = tasks->job->triangles;
    if (task->order == task->body)
        return NULL;
    const qcTriangleBvh* bvh = &qcBvhCandidates_At(tasks->sweep, qcStepTriangles_Slot(triangles, task->order))->bvh;
    return qcBvhCopy_Suits(bvh, qcStepTriangles_Body(triangles, task->order), body) ? bvh : NULL;
}

/// Builds the BVH of a body that has none, or adds what a limited one lacks.
static qcStatus BuildNew(const Tasks* tasks, const qcRefitTask* task, bool isFirst, qcBodyBvh* bvh)
{
    qcBvhRegion region;
    const qcBody* body = qcStepTriangles_Body(tasks->job->triangles, task->body);
    qcFloatPositions_Convert(body);
    const qcOrderOptions options = {tasks->threads, &region.cells};
    if (bvh->bvh.leavesRegion && !qcBody_HasSelfCollision(body) && qcBvhRegion_Begin(&region, body))
        return qcTriangleBvh_Complete(&bvh->bvh, body, &options);
    qcBodyBvh_Free(bvh);
    const qcTriangleBvh* order = FindOrder(tasks, task, body);
    if (order != NULL)
    {
        QC_TRY(qcBodyBvh_BuildLike(bvh, body, order, tasks->threads));
        bvh->bvh.wholeFits = (uint32_t)(task - TaskAt(tasks->sweep, 0)) % qc_outlineSteps;
        return qc_statusOk;
    }
    bool isLimited = isFirst && !task->isCopied && FindRegion(tasks->job, task->body, &region);
    return qcBodyBvh_Build(bvh, body, isLimited ? &region : NULL, tasks->threads);
}

static void BuildOne(void* context, size_t i, uint32_t worker)
{
    const Tasks* tasks = context;
    const qcRefitTask* task = TaskAt(tasks->sweep, tasks->first + i);
    qcBodyBvh* bvh = qcBvhCandidates_At(tasks->sweep, qcStepTriangles_Slot(tasks->job->triangles, task->body));
    bool isFirst = bvh->bvh.generation == 0;
    if (isFirst || NeedsOrder(&bvh->bvh))
        AddResult(tasks->sweep, worker, BuildNew(tasks, task, isFirst, bvh));
    else if (!qcBodyBvh_FindsSelfPairs(bvh))
        AddResult(tasks->sweep, worker, qcBodyBvh_PrepareSelf(bvh, tasks->threads));
    else
        AddResult(tasks->sweep, worker, qcBodyBvh_ContinueAdjacency(bvh, tasks->threads));
}

/// Whether the body's BVH has to be built, built anew, made ready for self pairs, or given more adjacency.
static bool NeedsBuild(const qcBodyBvh* bvh, const qcBody* body)
{
    if (bvh->bvh.generation == 0 || NeedsOrder(&bvh->bvh))
        return true;
    return qcBody_HasSelfCollision(body) && !bvh->hasAdjacency &&
           (!qcBodyBvh_FindsSelfPairs(bvh) || bvh->searches >= qc_searchesBefore);
}

/// Whether all that the task's body lacks is more adjacency, without which its pairs are found too.
static bool LacksAdjacencyOnly(const qcStepTriangles* triangles, const qcBvhCandidates* sweep, const qcRefitTask* task)
{
    const qcBodyBvh* bvh = qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, task->body));
    return bvh->bvh.generation != 0 && !NeedsOrder(&bvh->bvh) && qcBodyBvh_FindsSelfPairs(bvh);
}

/// Leaves adjacency to later steps where this one would build much more than it searches: of many small bodies, that
/// of the first ones is built.
static void SpreadAdjacency(const qcStepTriangles* triangles, qcBvhCandidates* sweep)
{
    uint64_t share = qc_minAdjacency, work = 0;
    for (size_t i = 0; i < sweep->tasks.count; i++)
        if (LacksAdjacencyOnly(triangles, sweep, TaskAt(sweep, i)))
            share += qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, TaskAt(sweep, i)->body))
                         ->bvh.clusters.nodeCount;
    size_t kept = 0;
    for (size_t i = 0; i < sweep->tasks.count; i++)
    {
        const qcRefitTask* task = TaskAt(sweep, i);
        if (LacksAdjacencyOnly(triangles, sweep, task))
        {
            if (work >= share)
                continue;
            work += qcBodyBvh_AdjacencyWork(qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, task->body)));
        }
        *TaskAt(sweep, kept++) = *task;
    }
    sweep->tasks.count = kept;
}

/// Puts tasks that wait for others behind these. Returns how many don't wait.
static size_t QueueWaiting(const qcBvhCandidates* sweep)
{
    size_t now = 0;
    for (size_t i = 0; i < sweep->tasks.count; i++)
        if (!TaskAt(sweep, i)->waits)
            SwapTasks(sweep, i, now++);
    return now;
}

/// Runs tasks: several side by side, or one by all threads.
static qcStatus BuildAll(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, size_t first, size_t end)
{
    uint32_t threads = job->threads;
    size_t count = end - first;
    QC_TRY(qcWorkerResults_Begin(&sweep->results, threads, sizeof(qcWorkerResult), "BVHs"));
    Tasks tasks = {.sweep = sweep, .job = job, .first = first, .threads = count == 1 ? threads : 1};
    qcParallel_For(count == 1 ? 1 : threads, count, 2, BuildOne, &tasks);
    return qcWorkerResults_End(&sweep->results, sizeof(qcWorkerResult));
}

/// Builds the flagged BVHs that don't exist yet, and the adjacency of those whose body has lived for some steps.
static qcStatus BuildBvhs(const qcBvhCandidatesJob* job, const uint8_t* flags, qcBvhCandidates* sweep)
{
    const qcStepTriangles* triangles = job->triangles;
    sweep->tasks.count = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcBodyBvh* bvh = qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, body));
        if (flags[body] && NeedsBuild(bvh, qcStepTriangles_Body(triangles, body)))
            QC_TRY(AddTask(sweep, body));
    }
    SpreadAdjacency(triangles, sweep);
    QC_TRY(qcCopiedOrders_Find(triangles, sweep));
    size_t now = QueueWaiting(sweep);
    QC_TRY(BuildAll(job, sweep, 0, now));
    return BuildAll(job, sweep, now, sweep->tasks.count);
}

/// The largest margin of the flagged bodies that aren't fitted in local coordinates.
static double MaxWorldMargin(const qcBvhCandidatesJob* job, const uint8_t* flags)
{
    double max = 0.0;
    for (uint32_t i = 0; i < job->triangles->bodyCount; i++)
    {
        const qcBody* body = qcStepTriangles_Body(job->triangles, i);
        if (flags[i] && body->margin > max && !qcTriangleBvh_FitsLocally(body))
            max = body->margin;
    }
    return max;
}

/// The margin of a body's boxes: the distance within which its pairs with itself and with bodies in world coordinates
/// are candidates. Boxes in local coordinates grow where the pair is searched. A cloth's boxes, which are tested
/// against each other, so don't grow with the margin of what it lies on.
static double FitMargin(const qcBvhCandidatesJob* job, const qcBody* body, double maxMargin)
{
    return qcBvhCandidates_DistanceWithin(job, body->margin + maxMargin);
}

/// Whether leaf nodes of the body are fitted once a search has found them. This is done for bodies without
/// self-collision. The first fit is a whole one, since the outline's lists take time.
static bool IsOutlined(const qcBvhCandidatesJob* job, const qcTriangleBvh* bvh, const qcBody* body)
{
    return !job->triangles->motion && !qcBody_HasSelfCollision(body) && !qcTriangleBvh_FitsLocally(body) &&
           bvh->fitCount != 0 && bvh->wholeFits == 0 && bvh->clusters.nodeCount > 1;
}

static void RefitOne(void* context, size_t i, uint32_t worker)
{
    const Tasks* tasks = context;
    const qcBvhCandidates* sweep = tasks->sweep;
    qcRefitTask* task = TaskAt(sweep, i);
    const qcStepTriangles* triangles = tasks->job->triangles;
    qcBodyBvh* bvh = qcBvhCandidates_At(sweep, qcStepTriangles_Slot(triangles, task->body));
    const qcBody* body = qcStepTriangles_Body(triangles, task->body);
    qcBvhScratch* scratch = &QC_AT(qcBvhScratch, sweep->refitScratch, worker);
    if (triangles->motion)
    {
        AddResult(sweep, worker,
                  qcTriangleBvh_FitMotion(&bvh->bvh, body, sweep->kernels, tasks->threads, scratch, &task->upToDate));
        return;
    }
    AddResult(sweep, worker,
              (IsOutlined(tasks->job, &bvh->bvh, body) ? qcTriangleBvh_FitOutline : qcTriangleBvh_Fit)(
                  &bvh->bvh, body, FitMargin(tasks->job, body, tasks->maxMargin), sweep->kernels, tasks->threads,
                  scratch, &task->upToDate));
}

/// Refits only the moved vertices, if the Verlet list allows for their motion: its pairs were found within a larger
/// distance than this step's.
static qcStatus TryPartialRefit(const qcBvhCandidatesJob* job, uint32_t body, double maxMargin, qcBvhCandidates* sweep)
{
    qcBodyBvh* bvh = qcBvhCandidates_At(sweep, qcStepTriangles_Slot(job->triangles, body));
    const qcBody* b = qcStepTriangles_Body(job->triangles, body);
    bool done = false;
    if (qcBody_HasSelfCollision(b) && !qcBody_IsInFloats(b) && !job->testNeighbours && !job->listNeighbours &&
        FitMargin(job, b, maxMargin) <= bvh->bvh.fit.margin)
        QC_TRY(qcBodyBvh_PartialRefit(bvh, b, (bvh->verlet.margin - qcBvhCandidates_PairDistance(job, b, b)) / 2.0,
                                      sweep->kernels, &QC_AT(qcBvhScratch, sweep->refitScratch, 0), &done));
    QC_AT(uint8_t, sweep->partlyRefitted, body) = done;
    return qc_statusOk;
}

static bool IsUpToDate(const qcBvhCandidatesJob* job, uint32_t slot, const qcBody* body, double maxMargin,
                       const qcBvhCandidates* sweep)
{
    const qcTriangleBvh* bvh = &qcBvhCandidates_At(sweep, slot)->bvh;
    if (job->triangles->motion)
        return qcTriangleBvh_IsMotionUpToDate(bvh, body);
    return (IsOutlined(job, bvh, body) ? qcTriangleBvh_IsOutlineUpToDate
                                       : qcTriangleBvh_IsUpToDate)(bvh, body, FitMargin(job, body, maxMargin));
}

static uint32_t CountFitted(const qcBvhCandidatesJob* job, uint32_t body, const qcBvhCandidates* sweep)
{
    return qcTriangleBvh_TriangleCount(&qcBvhCandidates_At(sweep, qcStepTriangles_Slot(job->triangles, body))->bvh,
                                       qcStepTriangles_Body(job->triangles, body));
}

/// Partial refits where they suffice, tasks for the other BVHs that aren't up to date.
static qcStatus QueueRefits(const qcBvhCandidatesJob* job, const uint8_t* flags, double maxMargin,
                            qcBvhCandidates* sweep)
{
    const qcStepTriangles* triangles = job->triangles;
    QC_TRY(qcArray_Resize(&sweep->partlyRefitted, triangles->bodyCount, 1, "BVHs"));
    sweep->tasks.count = 0;
    sweep->refittedTriangles = sweep->partlyRefittedTriangles = 0;
    for (uint32_t body = 0; body < triangles->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(triangles, body);
        QC_AT(uint8_t, sweep->partlyRefitted, body) = 0;
        if (!flags[body] || IsUpToDate(job, qcStepTriangles_Slot(triangles, body), b, maxMargin, sweep))
            continue;
        QC_TRY(TryPartialRefit(job, body, maxMargin, sweep));
        if (QC_AT(uint8_t, sweep->partlyRefitted, body))
            sweep->partlyRefittedTriangles += b->triangleCount;
        if (QC_AT(uint8_t, sweep->partlyRefitted, body) &&
            (!triangles->motion || IsUpToDate(job, qcStepTriangles_Slot(triangles, body), b, maxMargin, sweep)))
            continue;
        QC_TRY(AddTask(sweep, body));
        sweep->refittedTriangles += QC_AT(uint8_t, sweep->partlyRefitted, body) ? 0 : CountFitted(job, body, sweep);
    }
    return qc_statusOk;
}

/// Large bodies one after another by all threads, then the others side by side.
static qcStatus RefitBvhs(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, uint8_t* flags)
{
    uint32_t threads = job->threads;
    QC_TRY(qcArray_GrowZeroed(&sweep->refitScratch, threads, sizeof(qcBvhScratch), "refits"));
    QC_TRY(qcWorkerResults_Begin(&sweep->results, threads, sizeof(qcWorkerResult), "refits"));
    double maxMargin = MaxWorldMargin(job, flags);
    QC_TRY(QueueRefits(job, flags, maxMargin, sweep));
    uint64_t left = sweep->refittedTriangles;
    uint64_t large = left / (4 * (uint64_t)threads);
    Tasks tasks = {.sweep = sweep, .job = job, .maxMargin = maxMargin, .threads = threads};
    size_t small = 0;
    for (size_t i = 0; i < sweep->tasks.count; i++)
    {
        uint32_t count = CountFitted(job, TaskAt(sweep, i)->body, sweep);
        if (count >= large)
        {
            RefitOne(&tasks, i, 0);
            left -= count;
            continue;
        }
        SwapTasks(sweep, i, small++);
    }
    tasks.threads = 1;
    qcParallel_For(left > qc_smallBody ? threads : 1, small, 2, RefitOne, &tasks);
    for (size_t i = 0; i < sweep->tasks.count; i++)
        flags[TaskAt(sweep, i)->body] = TaskAt(sweep, i)->upToDate;
    return qcWorkerResults_End(&sweep->results, sizeof(qcWorkerResult));
}

qcStatus qcBvhCandidates_Prepare(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, uint8_t* flags)
{
    if (sweep->kernels == NULL)
        sweep->kernels = qcTriangleKernels_Get();
    QC_TRY(SyncSlots(job->triangles, flags, sweep));
    QC_TRY(FollowRegions(job, flags, sweep));
    QC_TRY(BuildBvhs(job, flags, sweep));
    return RefitBvhs(job, sweep, flags);
}
