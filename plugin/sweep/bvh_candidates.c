// Jobs for the search of BVHs, and candidate keys from pairs of slots.
#include "sweep/bvh_candidates.h"

#include "base/aabb.h"
#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/partial_refit.h"

#include <math.h>
#include <string.h>

typedef struct Run
{
    qcBvhCandidates* sweep;
    const qcBvhCandidatesJob* job;
    bool flatPatches; ///< pairs within flat patches are skipped; false where neighbours are candidates
    bool fillsVerlet; ///< pairs within bodies go to the Verlet list, too
} Run;

/// The BVHs of a pair of slots, by the triangles of their bodies.
typedef struct PairSides
{
    const Run* run;
    const uint32_t* triangles[2]; ///< by slot: index in the body
    uint32_t first[2];            ///< global index of the body's first triangle
    uint32_t verletSlot;          ///< slot of the body whose pairs go to the Verlet list, or UINT32_MAX
    uint32_t bodies[2];           ///< as in qcStepTriangles
    bool isCoarse;                ///< qcBvhFit::isCoarse of one of the BVHs
} PairSides;

double qcBvhCandidates_DistanceWithin(const qcBvhCandidatesJob* job, double margins)
{
    double near = fmin(job->margin, margins), contacts = qcContactDistance(fmin(job->contactMargin, margins));
    return fmax(near, contacts);
}

double qcBvhCandidates_PairDistance(const qcBvhCandidatesJob* job, const qcBody* a, const qcBody* b)
{
    return qcBvhCandidates_DistanceWithin(job, a->margin + b->margin);
}

static void KeysOf(const void* context, const qcSlotPair* pairs, size_t count, uint64_t* keys)
{
    const PairSides* sides = context;
    const uint32_t *a = sides->triangles[0], *b = sides->triangles[1];
    for (size_t i = 0; i < count; i++)
        keys[i] = qcStepTriangles_Key(sides->first[0] + a[pairs[i].a], sides->first[1] + b[pairs[i].b]);
}

/// Whether the boxes of the triangles in double are within the query distance.
static bool AreNear(const PairSides* sides, qcSlotPair pair, double query)
{
    const qcStepTriangles* t = sides->run->job->triangles;
    double lower[2][3], upper[2][3];
    qcStepTriangles_GetTriangleBox(t, sides->bodies[0], sides->triangles[0][pair.a], lower[0], upper[0]);
    qcStepTriangles_GetTriangleBox(t, sides->bodies[1], sides->triangles[1][pair.b], lower[1], upper[1]);
    return qcBounds_AreNear(lower[0], upper[0], lower[1], upper[1], query);
}

/// Drops undecided pairs that boxes of a coarse BVH could not tell apart: of some thousand triangles in one level these
/// would be millions.
static void DropApart(const PairSides* sides, qcClassifiedPairs* found)
{
    const qcStepTriangles* t = sides->run->job->triangles;
    double query = qcBvhCandidates_PairDistance(sides->run->job, qcStepTriangles_Body(t, sides->bodies[0]),
                                                qcStepTriangles_Body(t, sides->bodies[1]));
    size_t kept = found->nearCount + found->separateCount + found->intersectingCount;
    for (size_t i = kept; i < found->count; i++)
    {
        found->pairs[kept] = found->pairs[i];
        kept += AreNear(sides, found->pairs[i], query);
    }
    found->count = kept;
}

static bool AddKeys(void* context, const qcClassifiedPairs* found, uint32_t worker)
{
    const PairSides* sides = context;
    const Run* run = sides->run;
    qcClassifiedPairs kept = *found;
    if (sides->isCoarse)
        DropApart(sides, &kept);
    if (sides->verletSlot != UINT32_MAX)
        qcVerletList_Add(&run->sweep->verletList, sides->verletSlot, &kept, worker);
    return qcPairBuffer_Add(&QC_AT(qcPairBuffer, run->sweep->buffers, worker), &kept, run->job->listNeighbours, KeysOf,
                            sides);
}

/// Clears the flags of leaf nodes of bodies without self-collision, of which not all triangles may take part.
static qcStatus ClearVisited(const Run* run)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcStepTriangles* t = run->job->triangles;
    size_t nodes = 0;
    QC_TRY(qcArray_Resize(&sweep->firstVisited, t->bodyCount, sizeof(size_t), "visited nodes"));
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        bool some = run->job->bodies[body] && !qcBody_HasSelfCollision(qcStepTriangles_Body(t, body));
        QC_AT(size_t, sweep->firstVisited, body) = some ? nodes : SIZE_MAX;
        nodes += some ? qcBvhCandidates_At(sweep, qcStepTriangles_Slot(t, body))->bvh.clusters.nodeCount : 0;
    }
    QC_TRY(qcArray_Resize(&sweep->visited, nodes, 1, "visited nodes"));
    if (nodes != 0)
        memset(sweep->visited.data, 0, nodes);
    return qc_statusOk;
}

static uint8_t* VisitedOf(const qcBvhCandidates* sweep, uint32_t body)
{
    size_t first = QC_AT(size_t, sweep->firstVisited, body);
    return first != SIZE_MAX ? &QC_AT(uint8_t, sweep->visited, first) : NULL;
}

static qcBodyBvh* BvhOf(const Run* run, uint32_t body)
{
    return qcBvhCandidates_At(run->sweep, qcStepTriangles_Slot(run->job->triangles, body));
}

static PairSides MakeSides(const Run* run, uint32_t a, uint32_t b)
{
    PairSides sides = {.run = run, .verletSlot = UINT32_MAX};
    const uint32_t bodies[2] = {a, b};
    if (run->fillsVerlet && a == b)
        sides.verletSlot = qcStepTriangles_Slot(run->job->triangles, a);
    for (int i = 0; i < 2; i++)
    {
        sides.first[i] = qcStepTriangles_First(run->job->triangles, bodies[i]);
        sides.triangles[i] = BvhOf(run, bodies[i])->bvh.clusters.triangles.data;
        sides.bodies[i] = bodies[i];
        sides.isCoarse |= BvhOf(run, bodies[i])->bvh.fit.isCoarse;
    }
    return sides;
}

/// Appends a job; there is room for it.
static void AddJob(const Run* run, uint32_t a, uint32_t b)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcBvhCandidatesJob* job = run->job;
    const qcStepTriangles* t = job->triangles;
    if (a != b &&
        !qcBvhPairs_AreInOrder(BvhOf(run, a), qcStepTriangles_Body(t, a), BvhOf(run, b), qcStepTriangles_Body(t, b)))
    {
        uint32_t first = b;
        b = a;
        a = first;
    }
    const qcBody *bodyA = qcStepTriangles_Body(job->triangles, a), *bodyB = qcStepTriangles_Body(job->triangles, b);
    PairSides* sides = &QC_AT(PairSides, sweep->sides, sweep->jobs.count);
    *sides = MakeSides(run, a, b);
    QC_AT(qcBvhPairsJob, sweep->jobs, sweep->jobs.count++) =
        (qcBvhPairsJob){.kernels = sweep->kernels,
                        .a = BvhOf(run, a),
                        .b = BvhOf(run, b),
                        .bodyA = bodyA,
                        .bodyB = bodyB,
                        .query = qcBvhCandidates_PairDistance(job, bodyA, bodyB),
                        .near = qcBody_PairMargin(bodyA, bodyB, job->margin),
                        .includeNeighbours = job->testNeighbours,
                        .skipFlatPatches = run->flatPatches && a == b,
                        .motion = job->triangles->motion,
                        .neighbourCount = &BvhOf(run, a)->neighbourCount,
                        .visitedA = VisitedOf(sweep, a),
                        .visitedB = VisitedOf(sweep, b),
                        .function = AddKeys,
                        .context = sides};
}

/// Whether pairs of the body with itself are found here.
static bool FindsSelfPairs(const Run* run, uint32_t body)
{
    return run->job->bodies[body] && qcBody_HasSelfCollision(qcStepTriangles_Body(run->job->triangles, body));
}

/// Whether the body's pairs with itself come from the Verlet list. The flag is valid for prepared bodies only.
static bool UsesVerlet(const Run* run, uint32_t body)
{
    return FindsSelfPairs(run, body) && !run->job->triangles->motion &&
           QC_AT(uint8_t, run->sweep->partlyRefitted, body) != 0;
}

static void AddSelfJob(const Run* run, uint32_t body, bool verlet)
{
    qcBodyBvh* bvh = BvhOf(run, body);
    if (!verlet)
    {
        bvh->searches++;
        bvh->neighbourCount = 0;
    }
    AddJob(run, body, body);
}

/// Makes all jobs of the step together, so that threads have enough work with many small bodies. The first
/// `searchCount` are searches; the others take their pairs from the Verlet list.
static qcStatus MakeJobs(const Run* run, size_t* searchCount)
{
    qcBvhCandidates* sweep = run->sweep;
    const qcBvhCandidatesJob* job = run->job;
    const qcArray* pairs = &job->pairs->pairs;
    size_t maxCount = pairs->count + job->triangles->bodyCount;
    QC_TRY(qcArray_Reserve(&sweep->jobs, maxCount, sizeof(qcBvhPairsJob), "pairs of BVHs"));
    QC_TRY(qcArray_Resize(&sweep->sides, maxCount, sizeof(PairSides), "pairs of BVHs"));
    sweep->jobs.count = 0;
    for (size_t i = 0; i < pairs->count; i++)
    {
        qcBodyPair pair = QC_AT(qcBodyPair, *pairs, i);
        if (job->bodies[pair.a])
            AddJob(run, pair.a, pair.b);
    }
    for (int verlet = 0; verlet < 2; verlet++)
    {
        for (uint32_t body = 0; body < job->triangles->bodyCount; body++)
            if (FindsSelfPairs(run, body) && UsesVerlet(run, body) == (verlet != 0))
                AddSelfJob(run, body, verlet != 0);
        if (!verlet)
            *searchCount = sweep->jobs.count;
    }
    return qc_statusOk;
}

typedef struct VerletJobs
{
    const Run* run;
    size_t first;
} VerletJobs;

static void ReadVerletList(void* context, size_t i, uint32_t worker)
{
    const VerletJobs* jobs = context;
    qcBvhCandidates* sweep = jobs->run->sweep;
    const qcBvhPairsJob* job = &QC_AT(qcBvhPairsJob, sweep->jobs, jobs->first + i);
    const qcBody* slots = jobs->run->job->triangles->bodies->slots.data;
    uint32_t slot = (uint32_t)(job->bodyA - slots);
    qcVerletList_Find(&sweep->verletList, slot, job, worker);
}

/// Fits the visited leaf nodes of outlines.
static qcStatus FitVisitedNodes(const Run* run)
{
    const qcStepTriangles* t = run->job->triangles;
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        if (!run->job->bodies[body] || !BvhOf(run, body)->bvh.fit.isOutline)
            continue;
        QC_TRY(qcTriangleBvh_FitNodes(&BvhOf(run, body)->bvh, qcStepTriangles_Body(t, body),
                                      VisitedOf(run->sweep, body), run->sweep->kernels, run->job->threads,
                                      &QC_AT(qcBvhScratch, run->sweep->refitScratch, 0)));
    }
    return qc_statusOk;
}

static qcStatus FindPairs(const Run* run)
{
    qcBvhCandidates* sweep = run->sweep;
    size_t searchCount = 0;
    QC_TRY(MakeJobs(run, &searchCount));
    QC_TRY(qcBvhPairs_Begin(&sweep->pairs, sweep->jobs.data, searchCount, run->job->threads));
    QC_TRY(FitVisitedNodes(run));
    qcBvhPairs_Finish(&sweep->pairs, sweep->jobs.data, searchCount, run->job->threads);
    VerletJobs verlet = {run, searchCount};
    qcParallel_For(run->job->threads, sweep->jobs.count - searchCount, 2, ReadVerletList, &verlet);
    return qc_statusOk;
}

/// Whether the step fills the Verlet list. It does not while a body uses the list: pairs found within this step's
/// smaller distance would last for fewer steps.
static bool FillsVerlet(const Run* run)
{
    bool finds = false, uses = false;
    for (uint32_t body = 0; body < run->job->triangles->bodyCount; body++)
    {
        finds = finds || FindsSelfPairs(run, body);
        uses = uses || UsesVerlet(run, body);
    }
    return finds && !uses && run->job->queryDistance > 0.0 && !run->job->testNeighbours;
}

/// Empties the Verlet list.
static qcStatus BeginVerlet(const Run* run)
{
    for (uint32_t slot = 0; slot < run->sweep->bvhs.count; slot++)
        if (qcBvhCandidates_At(run->sweep, slot) != NULL)
            qcVerletReference_Clear(&qcBvhCandidates_At(run->sweep, slot)->verlet);
    return qcVerletList_Begin(&run->sweep->verletList, run->job->threads);
}

/// Stores the reference positions of the list that was filled.
static qcStatus EndVerlet(const Run* run)
{
    QC_TRY(qcVerletList_Check(&run->sweep->verletList));
    for (uint32_t body = 0; body < run->job->triangles->bodyCount; body++)
    {
        const qcBody* b = qcStepTriangles_Body(run->job->triangles, body);
        if (!FindsSelfPairs(run, body) || !b->deforming)
            continue;
        QC_TRY(qcBodyBvh_SetVerletReference(BvhOf(run, body), b, qcBvhCandidates_PairDistance(run->job, b, b)));
    }
    return qc_statusOk;
}

static void AddContactKeys(void* context, const qcSlotPair* pairs, size_t count, uint32_t worker)
{
    const PairSides* sides = context;
    qcPairBuffer_AddNeighbours(&QC_AT(qcPairBuffer, sides->run->sweep->buffers, worker), pairs, count, KeysOf, sides);
}

static qcStatus AddNeighbourPairs(const Run* run, uint32_t body, qcProfile* profile)
{
    qcBodyBvh* bvh = BvhOf(run, body);
    if (run->job->testNeighbours)
        return qc_statusOk;
    profile->skippedNeighbours += bvh->hasAdjacency ? bvh->bvh.clusters.neighbourCount : bvh->neighbourCount;
    PairSides sides = MakeSides(run, body, body);
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
    const uint8_t* visited = VisitedOf(run->sweep, body);
    uint32_t left = b->triangleCount;
    if (visited != NULL)
    {
        const qcClusters* clusters = &BvhOf(run, body)->bvh.clusters;
        left = 0;
        for (uint32_t node = 0; node < clusters->nodeCount; node++)
            left += visited[node] ? qc_nodeSize : 0;
        left = left < b->triangleCount ? left : b->triangleCount;
    }
    profile->selfBodies += visited == NULL;
    profile->trianglePcs += left;
    profile->skippedTriangles += b->triangleCount - left;
}

static qcStatus FindFlatPatches(const Run* run, uint32_t body, qcProfile* profile)
{
    qcBodyBvh* bvh = BvhOf(run, body);
    if (!run->flatPatches || !bvh->hasAdjacency || UsesVerlet(run, body))
        return qc_statusOk;
    const qcTriangleKernels* kernels = run->sweep->kernels;
    const qcPatchFlags* flags = &bvh->patches.present;
    if (run->job->triangles->motion)
    {
        const qcBody* b = qcStepTriangles_Body(run->job->triangles, body);
        QC_TRY(qcPatchState_TestMotion(&bvh->patches, &bvh->bvh, qcTriangleBvh_StartFit(&bvh->bvh, b), kernels,
                                       run->job->threads));
        flags = &bvh->patches.motion;
    }
    else
        qcPatchState_Test(&bvh->patches, &bvh->bvh, kernels, run->job->threads);
    profile->flatTriangles += qcPatchState_CountFlat(&bvh->patches, flags);
    return qc_statusOk;
}

qcStatus qcBvhCandidates_Run(const qcBvhCandidatesJob* job, qcBvhCandidates* sweep, qcCandidates* candidates,
                             qcProfile* profile)
{
    const qcStepTriangles* t = job->triangles;
    Run run = {.sweep = sweep, .job = job, .flatPatches = !job->testNeighbours};
    run.fillsVerlet = FillsVerlet(&run);
    QC_TRY(qcPairBuffers_Begin(&sweep->buffers, job->threads, t->maxPairs));
    QC_TRY(ClearVisited(&run));
    if (run.fillsVerlet)
        QC_TRY(BeginVerlet(&run));
    for (uint32_t body = 0; body < t->bodyCount; body++)
        if (FindsSelfPairs(&run, body) || job->neighboursOnly[body])
            QC_TRY(FindFlatPatches(&run, body, profile));
    QC_TRY(FindPairs(&run));
    // A list that a failure has cut short must not serve later steps.
    QC_TRY(qcWorkerResults_End(&sweep->buffers, sizeof(qcPairBuffer)));
    if (run.fillsVerlet)
        QC_TRY(EndVerlet(&run));
    for (uint32_t body = 0; body < t->bodyCount; body++)
    {
        if (job->bodies[body])
            CountTriangles(&run, body, profile);
        if (FindsSelfPairs(&run, body) || job->neighboursOnly[body])
            QC_TRY(AddNeighbourPairs(&run, body, profile));
    }
    profile->fittedTriangles += sweep->refittedTriangles;
    profile->followedTriangles += sweep->partlyRefittedTriangles;
    // A step of `brute` or an image method prepares no BVH and has no refits to report.
    sweep->refittedTriangles = sweep->partlyRefittedTriangles = 0;
    const qcPairKeys keys = {&candidates->keys, &candidates->contactKeys, &candidates->classified};
    return qcPairBuffers_End(&sweep->buffers, &keys);
}

void qcBvhCandidates_Free(qcBvhCandidates* sweep)
{
    for (uint32_t slot = 0; slot < sweep->bvhs.count; slot++)
        qcBvhCandidates_Delete(sweep, slot);
    qcPairBuffers_Free(&sweep->buffers);
    for (size_t i = 0; i < sweep->refitScratch.count; i++)
        qcBvhScratch_Free(&QC_AT(qcBvhScratch, sweep->refitScratch, i));
    qcBvhPairs_Free(&sweep->pairs);
    qcVerletList_Free(&sweep->verletList);
    qcArray* arrays[] = {&sweep->bvhs,    &sweep->tasks,        &sweep->keys,           &sweep->sorted,
                         &sweep->results, &sweep->refitScratch, &sweep->partlyRefitted, &sweep->jobs,
                         &sweep->sides,   &sweep->visited,      &sweep->firstVisited};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
