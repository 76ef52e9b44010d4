// Workers take candidates in blocks. Sorting by candidate key makes the result independent of the number of threads.
#include "narrowphase/narrowphase.h"

#include "base/clock.h"
#include "base/ordered_keys.h"
#include "base/parallel_for.h"
#include "base/parallel_sort.h"
#include "base/radix_sort.h"
#include "base/status.h"
#include "narrowphase/feature_contacts.h"
#include "scene/float_positions.h"
#include "triangle/exact.h"
#include "triangle/motion_in_parts.h"
#include "triangle/proximity.h"

#include <string.h>

enum
{
    // Pairs of triangles that are in no cache take 10 microseconds a block.
    qc_blockSize = qc_featurePairs,
    // 256 pairs take about 0.1 ms.
    qc_minBlocks = 16,
    qc_minSegments = 1024,
    // Filling a block of qcPair takes 1 to 3 microseconds.
    qc_pairBlock = 256,
    qc_minPairBlocks = 64,
    // 256 pairs take about 0.2 ms.
    qc_minProximities = 256
};

typedef struct Job
{
    qcNarrowphase* narrow;
    const qcStepTriangles* triangles;
    const qcArray *keys, *contactKeys; ///< of uint64_t; blocks of the second follow those of the first
    size_t keyBlocks;
    const qcDetectDef* def;
    const qcTriangleKernels* kernels;
} Job;

typedef struct Side
{
    uint32_t body, triangle; ///< body of the step, index of the triangle in it
} Side;

static Side SideOf(const qcStepTriangles* t, uint32_t global)
{
    uint32_t body = qcStepTriangles_BodyOf(t, global);
    return (Side){body, global - qcStepTriangles_First(t, body)};
}

/// The triangles of a body, by their global indices.
typedef struct BodyTriangles
{
    uint32_t first, count, slot;
} BodyTriangles;

/// `last` has the body of the last triangle, which is mostly that of the next, too.
static inline uint32_t FindTriangle(const qcStepTriangles* t, uint32_t global, BodyTriangles* last)
{
    if (global - last->first >= last->count)
    {
        uint32_t body = qcStepTriangles_BodyOf(t, global), first = qcStepTriangles_First(t, body);
        *last = (BodyTriangles){first, qcStepTriangles_First(t, body + 1) - first, qcStepTriangles_Slot(t, body)};
    }
    return global - last->first;
}

/// A cache of one triangle's corners: consecutive pairs of a list mostly share one triangle.
typedef struct Corners
{
    bool filled;
    uint32_t global;
    BodyTriangles own; ///< of its body
    const qcBody* body;
    double corner[3][3];     ///< at the start of a motion
    qcMovingTriangle moving; ///< of a motion only
    const uint32_t* indices;
} Corners;

static void LoadCorners(const Job* job, uint32_t global, Corners* corners)
{
    if (corners->filled && corners->global == global)
        return;
    uint32_t triangle = FindTriangle(job->triangles, global, &corners->own);
    corners->filled = true;
    corners->global = global;
    corners->body = &QC_AT(qcBody, job->triangles->bodies->slots, corners->own.slot);
    corners->indices = corners->body->indices + 3 * (size_t)triangle;
    if (!job->def->motion)
    {
        qcBody_GetNewestTriangle(corners->body, triangle, corners->corner);
        return;
    }
    qcBody_GetStartTriangle(corners->body, triangle, corners->corner);
    memcpy(corners->moving.start, corners->corner, sizeof corners->corner);
    qcBody_GetTriangle(corners->body, triangle, corners->moving.end);
}

static void LoadPair(const Job* job, uint64_t key, Corners corners[2])
{
    LoadCorners(job, (uint32_t)(key >> 32), &corners[0]);
    LoadCorners(job, (uint32_t)key, &corners[1]);
}

static bool HaveCommonIndex(const uint32_t a[3], const uint32_t b[3])
{
    for (int i = 0; i < 9; i++)
        if (a[i / 3] == b[i % 3])
            return true;
    return false;
}

/// True if the triangles are proven apart over the motion.
static bool StaysApart(const Corners corners[2])
{
    const qcMovingTriangle *a = &corners[0].moving, *b = &corners[1].moving;
    if (corners[0].body == corners[1].body && HaveCommonIndex(corners[0].indices, corners[1].indices))
        return qcMotion_SeparatesNeighbours(a, corners[0].indices, b, corners[1].indices);
    return qcMotion_StaysApart(a, b);
}

static void TestPair(const Job* job, qcNarrowphaseWorker* worker, uint64_t key, Corners corners[2])
{
    LoadPair(job, key, corners);
    const double(*p)[3] = (const double(*)[3])corners[0].corner;
    const double(*q)[3] = (const double(*)[3])corners[1].corner;
    double margin = qcBody_PairMargin(corners[0].body, corners[1].body, job->def->margin);
    worker->tests++;
    if (job->def->motion && StaysApart(corners))
        return;
    uint64_t undecided = 0;
    qcRelation relation = qcExact_Within(p, q, margin, &undecided);
    worker->fallbacks += undecided != 0;
    bool touching = job->def->touching || job->def->margin > 0.0;
    if (!job->def->motion && (relation == qc_relationDisjoint || (relation == qc_relationTouching && !touching)))
        return;
    qcStatus status = qcArray_Reserve(&worker->found, worker->found.count + 1, sizeof(uint64_t), "pairs");
    if (qcWorkerResult_Add(&worker->result, status))
        QC_AT(uint64_t, worker->found, worker->found.count++) = qcRelatedPair_Make(key, relation);
}

static qcContactSide ContactSideOf(const Job* job, Side side)
{
    uint32_t slot = qcStepTriangles_Slot(job->triangles, side.body);
    const qcBody* body = qcStepTriangles_Body(job->triangles, side.body);
    bool filters = job->def->nearestContacts && !body->deforming;
    const qcLocalMinima* localMinima = filters ? &QC_AT(qcLocalMinima, job->narrow->localMinima, slot) : NULL;
    return (qcContactSide){body, slot, side.triangle, localMinima};
}

static qcContactPair ContactPairOf(const Job* job, uint64_t key)
{
    qcContactPair pair = {.a = ContactSideOf(job, SideOf(job->triangles, (uint32_t)(key >> 32))),
                          .b = ContactSideOf(job, SideOf(job->triangles, (uint32_t)key))};
    // The filter applies to contacts of a deforming body with a rigid one.
    if (pair.a.body->deforming == pair.b.body->deforming)
        pair.a.localMinima = pair.b.localMinima = NULL;
    pair.margin = qcBody_PairMargin(pair.a.body, pair.b.body, job->def->contactMargin);
    return pair;
}

static void AddContacts(qcNarrowphaseWorker* worker, uint64_t key, const qcContact* found, size_t count)
{
    size_t first = worker->contacts.count;
    if (count == 0)
        return;
    qcStatus status = qcArray_Reserve(&worker->contacts, first + count, sizeof(qcContact), "contacts");
    if (status == qc_statusOk)
        status = qcArray_Reserve(&worker->contactKeys, first + count, sizeof(qcSortItem), "contacts");
    if (!qcWorkerResult_Add(&worker->result, status))
        return;
    memcpy(&QC_AT(qcContact, worker->contacts, first), found, count * sizeof(qcContact));
    for (size_t i = 0; i < count; i++)
        QC_AT(qcSortItem, worker->contactKeys, first + i) = (qcSortItem){key, first + i};
    worker->contacts.count = worker->contactKeys.count = first + count;
}

/// Contacts of 1 to qc_featurePairs pairs, whose features are filtered together.
static void FindContacts(const Job* job, qcNarrowphaseWorker* worker, const uint64_t* keys, size_t count,
                         qcContactTriangle cached[2])
{
    qcContactPair pairs[qc_featurePairs];
    qcFeatureMask near[qc_featurePairs];
    for (size_t i = 0; i < count; i++)
        pairs[i] = ContactPairOf(job, keys[i]);
    qcContact_FindNear(job->kernels, pairs, count, near);
    for (size_t i = 0; i < count && qcWorkerResult_IsOk(&worker->result); i++)
    {
        qcContact found[qc_maxContactsPerPair];
        if (near[i] == 0)
            continue;
        qcContactTriangle_Load(&cached[0], &pairs[i].a);
        qcContactTriangle_Load(&cached[1], &pairs[i].b);
        int foundCount = qcContact_Find(&cached[0], &cached[1], pairs[i].margin, near[i], found);
        AddContacts(worker, keys[i], found, (size_t)foundCount);
    }
}

/// Fetches the corner indices of a pair's triangles into the caches, or, once these are there, the corners. `last`: see
/// FindTriangle.
static inline void FetchPair(const Job* job, uint64_t key, bool corners, BodyTriangles last[2])
{
    const uint32_t globals[] = {(uint32_t)(key >> 32), (uint32_t)key};
    for (int i = 0; i < 2; i++)
    {
        uint32_t triangle = FindTriangle(job->triangles, globals[i], &last[i]);
        const qcBody* body = &QC_AT(qcBody, job->triangles->bodies->slots, last[i].slot);
        if (corners)
            qcBody_FetchNewestTriangle(body, triangle);
        else
            __builtin_prefetch(body->indices + 3 * (size_t)triangle);
    }
}

/// Tests the pairs of a block. Pairs of a device lie apart in memory: their triangles are fetched ahead.
static void TestPairs(const Job* job, qcNarrowphaseWorker* worker, size_t first, size_t end)
{
    const uint64_t* keys = job->keys->data;
    const size_t ahead = 2, count = job->keys->count; // a test takes as long as a fetch
    Corners corners[2];                               // too large to be cleared for each block
    BodyTriangles last[2] = {{0, 0, 0}, {0, 0, 0}};
    corners[0].filled = corners[1].filled = false;
    corners[0].own = corners[1].own = last[0];
    for (size_t i = first; i < end && qcWorkerResult_IsOk(&worker->result); i++)
    {
        if (i + 2 * ahead < count)
            FetchPair(job, keys[i + 2 * ahead], false, last);
        if (i + ahead < count)
            FetchPair(job, keys[i + ahead], true, last);
        TestPair(job, worker, keys[i], corners);
    }
}

static size_t BlockCount(const qcArray* keys)
{
    return (keys->count + qc_blockSize - 1) / qc_blockSize;
}

static void TakeBlock(void* context, size_t block, uint32_t workerIndex)
{
    const Job* job = context;
    qcNarrowphaseWorker* worker = &QC_AT(qcNarrowphaseWorker, job->narrow->workers, workerIndex);
    bool contactsOnly = block >= job->keyBlocks;
    const qcArray* keys = contactsOnly ? job->contactKeys : job->keys;
    size_t first = (contactsOnly ? block - job->keyBlocks : block) * qc_blockSize;
    size_t end = first + qc_blockSize < keys->count ? first + qc_blockSize : keys->count;
    if (!contactsOnly)
        TestPairs(job, worker, first, end);
    if (job->def->contactMargin == 0.0)
        return;
    double start = qcClock_Now();
    qcContactTriangle cached[2] = {{.index = NULL}, {.index = NULL}};
    for (size_t i = first; i < end && qcWorkerResult_IsOk(&worker->result); i += qc_featurePairs)
        FindContacts(job, worker, &QC_AT(uint64_t, *keys, i), end - i < qc_featurePairs ? end - i : qc_featurePairs,
                     cached);
    worker->contactMs += qcClock_Now() - start;
}

static qcStatus BeginWorkers(qcNarrowphase* narrow, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&narrow->workers, threads, sizeof(qcNarrowphaseWorker), "pairs"));
    for (size_t i = 0; i < narrow->workers.count; i++)
    {
        qcNarrowphaseWorker* worker = &QC_AT(qcNarrowphaseWorker, narrow->workers, i);
        worker->found.count = worker->contacts.count = worker->contactKeys.count = 0;
        worker->tests = worker->fallbacks = 0;
        worker->contactMs = 0.0;
    }
    return qc_statusOk;
}

/// Prepares the local-minimum filter of each rigid body.
static qcStatus PrepareLocalMinima(qcNarrowphase* narrow, const qcStepTriangles* triangles)
{
    const qcArray* slots = &triangles->bodies->slots;
    QC_TRY(qcArray_GrowZeroed(&narrow->localMinima, slots->count, sizeof(qcLocalMinima), "the local-minimum filter"));
    for (size_t slot = 0; slot < slots->count; slot++)
    {
        const qcBody* body = &QC_AT(qcBody, *slots, slot);
        qcLocalMinima* localMinima = &QC_AT(qcLocalMinima, narrow->localMinima, slot);
        if (qcBody_IsUsed(body) && !body->deforming)
            QC_TRY(qcLocalMinima_Make(localMinima, body));
        else
            qcLocalMinima_Free(localMinima);
    }
    return qc_statusOk;
}

/// Where the classified pairs begin that are in order, as those of a device are in most of its steps: only the others
/// are sorted. Their number: where few are, all are sorted.
static size_t FindOrdered(const qcArray* classified, size_t total)
{
    size_t begin = qcOrderedKeys_FindBegin(classified->data, classified->count);
    return 2 * (classified->count - begin) > total ? begin : classified->count;
}

/// All pairs, sorted, into narrow->related.
static qcStatus CollectPairs(qcNarrowphase* narrow, const qcArray* classified, uint32_t threads)
{
    size_t total = classified->count;
    for (size_t i = 0; i < narrow->workers.count; i++)
        total += QC_AT(qcNarrowphaseWorker, narrow->workers, i).found.count;
    // The first worker's list grows into the list of all: one copy less in memory.
    qcArray* first = &QC_AT(qcNarrowphaseWorker, narrow->workers, 0).found;
    qcArray old = narrow->related;
    narrow->related = *first;
    *first = old;
    first->count = 0;
    QC_TRY(qcArray_Reserve(&narrow->related, total, sizeof(uint64_t), "pairs"));
    for (size_t i = 1; i < narrow->workers.count; i++)
        QC_TRY(qcArray_Append(&narrow->related, &QC_AT(qcNarrowphaseWorker, narrow->workers, i).found, sizeof(uint64_t),
                              "pairs"));
    const uint64_t* ordered = classified->data;
    size_t begin = FindOrdered(classified, total), orderedCount = classified->count - begin;
    uint64_t* related = narrow->related.data;
    if (begin != 0)
        memcpy(related + narrow->related.count, ordered, begin * sizeof(uint64_t));
    narrow->related.count = total;
    QC_TRY(qcArray_Resize(&narrow->pairs, total, sizeof(qcPair), "pairs"));
    QC_TRY(qcParallelSort_Keys(threads, related, total - orderedCount, &narrow->scratch));
    if (orderedCount != 0)
        qcOrderedKeys_Merge(related, total - orderedCount, ordered + begin, orderedCount);
    return qc_statusOk;
}

static void FillPairs(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    const qcStepTriangles* t = job->triangles;
    const qcArray* related = &job->narrow->related;
    size_t end = (block + 1) * qc_pairBlock < related->count ? (block + 1) * qc_pairBlock : related->count;
    BodyTriangles a = {0, 0, 0}, b = {0, 0, 0};
    for (size_t i = block * qc_pairBlock; i < end; i++)
    {
        uint64_t pair = QC_AT(uint64_t, *related, i), key = qcRelatedPair_Key(pair);
        uint32_t triangleA = FindTriangle(t, (uint32_t)(key >> 32), &a), triangleB = FindTriangle(t, (uint32_t)key, &b);
        QC_AT(qcPair, job->narrow->pairs, i) = (qcPair){.bodyA = a.slot,
                                                        .triangleA = triangleA,
                                                        .bodyB = b.slot,
                                                        .triangleB = triangleB,
                                                        .relation = qcRelatedPair_Relation(pair)};
    }
}

static void ComputeSegment(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    qcSegment* segment = &QC_AT(qcSegment, job->narrow->segments, i);
    *segment = (qcSegment){{0}, {0}};
    uint64_t pair = QC_AT(uint64_t, job->narrow->related, i);
    if (qcRelatedPair_Relation(pair) != qc_relationPenetrating)
        return;
    Corners corners[2] = {{.filled = false}, {.filled = false}};
    LoadPair(job, qcRelatedPair_Key(pair), corners);
    qcExact_Segment((const double(*)[3])corners[0].corner, (const double(*)[3])corners[1].corner, segment);
}

static void ComputeProximity(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    uint64_t pair = QC_AT(uint64_t, job->narrow->related, i);
    Corners corners[2] = {{.filled = false}, {.filled = false}};
    LoadPair(job, qcRelatedPair_Key(pair), corners);
    qcProximity_Of((const double(*)[3])corners[0].corner, (const double(*)[3])corners[1].corner,
                   qcRelatedPair_Relation(pair), &QC_AT(qcProximity, job->narrow->proximities, i),
                   &QC_AT(qcClosestFeatures, job->narrow->closestFeatures, i));
}

static qcStatus CollectContacts(qcNarrowphase* narrow)
{
    size_t total = 0, at = 0;
    for (size_t i = 0; i < narrow->workers.count; i++)
        total += QC_AT(qcNarrowphaseWorker, narrow->workers, i).contacts.count;
    QC_TRY(qcArray_Resize(&narrow->contactOrder, total, sizeof(qcSortItem), "contacts"));
    QC_TRY(qcArray_Resize(&narrow->contacts, total, sizeof(qcContact), "contacts"));
    for (size_t i = 0; i < narrow->workers.count; i++)
    {
        const qcNarrowphaseWorker* worker = &QC_AT(qcNarrowphaseWorker, narrow->workers, i);
        for (size_t k = 0; k < worker->contactKeys.count; k++, at++)
        {
            // The upper 16 bits hold the worker. All contacts of a key are one worker's, in order, and the sort is
            // stable.
            qcSortItem item = QC_AT(qcSortItem, worker->contactKeys, k);
            item.value |= (uint64_t)i << 48;
            QC_AT(qcSortItem, narrow->contactOrder, at) = item;
        }
    }
    QC_TRY(qcSort_Items(narrow->contactOrder.data, total, &narrow->contactScratch));
    for (size_t i = 0; i < total; i++)
    {
        uint64_t index = QC_AT(qcSortItem, narrow->contactOrder, i).value;
        QC_AT(qcContact, narrow->contacts, i) = QC_AT(
            qcContact, QC_AT(qcNarrowphaseWorker, narrow->workers, index >> 48).contacts, index & 0xffffffffffffULL);
    }
    return qc_statusOk;
}

/// Tests candidates and finds contacts in all workers. `contactMs`: the share of contacts in the wall-clock time.
static qcStatus RunWorkers(Job* job, uint32_t threads, qcProfile* profile, double* contactMs)
{
    qcNarrowphase* narrow = job->narrow;
    qcParallel_For(threads, job->keyBlocks + BlockCount(job->contactKeys), qc_minBlocks, TakeBlock, job);
    QC_TRY(qcWorkerResults_End(&narrow->workers, sizeof(qcNarrowphaseWorker)));
    *contactMs = 0.0;
    for (size_t i = 0; i < narrow->workers.count; i++)
    {
        const qcNarrowphaseWorker* worker = &QC_AT(qcNarrowphaseWorker, narrow->workers, i);
        profile->candidates += worker->tests;
        profile->exactFallbacks += worker->fallbacks;
        *contactMs += worker->contactMs / threads;
    }
    return qc_statusOk;
}

/// Pairs, segments and proximities in the order of narrow->related.
static qcStatus FillResults(Job* job, uint32_t threads)
{
    qcNarrowphase* narrow = job->narrow;
    size_t count = narrow->pairs.count;
    qcParallel_For(threads, (count + qc_pairBlock - 1) / qc_pairBlock, qc_minPairBlocks, FillPairs, job);
    if (job->def->segments)
    {
        QC_TRY(qcArray_Resize(&narrow->segments, count, sizeof(qcSegment), "segments"));
        qcParallel_For(threads, count, qc_minSegments, ComputeSegment, job);
    }
    if (job->def->proximities)
    {
        QC_TRY(qcArray_Resize(&narrow->proximities, count, sizeof(qcProximity), "proximities"));
        QC_TRY(qcArray_Resize(&narrow->closestFeatures, count, sizeof(qcClosestFeatures), "proximities"));
        qcParallel_For(threads, count, qc_minProximities, ComputeProximity, job);
    }
    return qc_statusOk;
}

qcStatus qcNarrowphase_Run(const qcStepTriangles* triangles, const qcCandidates* candidates, const qcDetectDef* def,
                           uint32_t threads, qcNarrowphase* narrow, qcProfile* profile)
{
    double start = qcClock_Now(), contactMs = 0.0;
    narrow->pairs.count = narrow->segments.count = narrow->proximities.count = narrow->contacts.count = 0;
    QC_TRY(BeginWorkers(narrow, threads));
    if (def->contactMargin > 0.0 && def->nearestContacts)
        QC_TRY(PrepareLocalMinima(narrow, triangles));
    Job job = {.narrow = narrow,
               .triangles = triangles,
               .keys = &candidates->keys,
               .contactKeys = &candidates->contactKeys,
               .keyBlocks = BlockCount(&candidates->keys),
               .def = def,
               .kernels = qcTriangleKernels_Get()};
    QC_TRY(RunWorkers(&job, threads, profile, &contactMs));
    QC_TRY(CollectPairs(narrow, &candidates->classified, threads));
    QC_TRY(FillResults(&job, threads));
    profile->candidates += candidates->classified.count;
    profile->filterHits = candidates->classified.count;
    profile->pairs = narrow->pairs.count;
    double middle = qcClock_Now();
    if (def->contactMargin > 0.0)
        QC_TRY(CollectContacts(narrow));
    profile->contacts = narrow->contacts.count;
    profile->contactMs = contactMs + qcClock_Now() - middle;
    profile->exactMs = middle - start - contactMs;
    return qc_statusOk;
}

void qcNarrowphase_Free(qcNarrowphase* narrow)
{
    for (size_t i = 0; i < narrow->workers.count; i++)
    {
        qcNarrowphaseWorker* worker = &QC_AT(qcNarrowphaseWorker, narrow->workers, i);
        qcArray_Free(&worker->found);
        qcArray_Free(&worker->contacts);
        qcArray_Free(&worker->contactKeys);
    }
    for (size_t slot = 0; slot < narrow->localMinima.count; slot++)
        qcLocalMinima_Free(&QC_AT(qcLocalMinima, narrow->localMinima, slot));
    qcArray_Free(&narrow->localMinima);
    qcArray_Free(&narrow->workers);
    qcArray_Free(&narrow->related);
    qcArray_Free(&narrow->contactOrder);
    qcArray_Free(&narrow->contactScratch);
    qcArray_Free(&narrow->scratch);
    qcArray_Free(&narrow->pairs);
    qcArray_Free(&narrow->segments);
    qcArray_Free(&narrow->proximities);
    qcArray_Free(&narrow->closestFeatures);
    qcArray_Free(&narrow->contacts);
}
