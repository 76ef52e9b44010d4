// The narrow phase. Workers take candidates in blocks; sorting by candidate key afterwards makes the result the same
// for any number of threads.
#include "narrowphase/narrowphase.h"

#include "base/clock.h"
#include "narrowphase/feature_contacts.h"
#include "triangle/exact.h"
#include "triangle/proximity.h"
#include "base/radix_sort.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Large beside the cost of taking a block, small beside all candidates of a small scene.
    qc_blockSize = 128,
    // 1024 pairs take about 0.3 ms.
    qc_leastBlocks = 8,
    qc_leastSegments = 1024,
    // Pairs that are named at once take 10 microseconds.
    qc_namedPairs = 2048,
    qc_leastNamings = 8,
    // 256 pairs take about 0.2 ms.
    qc_leastProximities = 256
};

typedef struct Job
{
    qcNarrowphase* narrow;
    const qcStepTriangles* triangles;
    const qcArray *keys, *neighbourKeys; ///< of uint64_t; blocks of the second come after those of the first
    size_t keyBlocks;
    const qcDetectDef* def;
    const qcTriangleKernels* kernels;
} Job;

typedef struct Side
{
    uint32_t body, triangle; ///< numbers of the step, index in the body
} Side;

static Side SideOf(const qcStepTriangles* t, uint32_t rank)
{
    uint32_t body = qcStepTriangles_BodyOf(t, rank);
    return (Side){body, rank - qcStepTriangles_First(t, body)};
}

/// A triangle's corners. Neighbours in a list of pairs mostly have one in common.
typedef struct Corners
{
    bool known;
    uint32_t rank;
    const qcBody* body;
    double corner[3][3];
} Corners;

static void TakeCorners(const Job* job, uint32_t rank, Corners* corners)
{
    if (corners->known && corners->rank == rank)
        return;
    Side side = SideOf(job->triangles, rank);
    corners->known = true;
    corners->rank = rank;
    corners->body = qcStepTriangles_Body(job->triangles, side.body);
    qcBody_GetTriangle(corners->body, side.triangle, corners->corner);
}

static void TakeCornersOfPair(const Job* job, uint64_t key, Corners corners[2])
{
    TakeCorners(job, (uint32_t)(key >> 32), &corners[0]);
    TakeCorners(job, (uint32_t)key, &corners[1]);
}

static void Relate(const Job* job, qcNarrowphaseWorker* sink, uint64_t key, Corners corners[2])
{
    TakeCornersOfPair(job, key, corners);
    const double(*p)[3] = (const double(*)[3])corners[0].corner;
    const double(*q)[3] = (const double(*)[3])corners[1].corner;
    double margin = qcBody_PairMargin(corners[0].body, corners[1].body, job->def->margin);
    uint64_t undecided = 0;
    qcRelation relation = qcExact_Within(p, q, margin, &undecided);
    sink->tests++;
    sink->fallbacks += undecided != 0;
    bool touching = job->def->touching || job->def->margin > 0.0;
    if (relation == qc_relationDisjoint || (relation == qc_relationTouching && !touching))
        return;
    qcStatus status = qcArray_Reserve(&sink->found, sink->found.count + 1, sizeof(qcSortItem), "pairs");
    if (qcWorkerResult_Add(&sink->result, status))
        QC_AT(qcSortItem, sink->found, sink->found.count++) = (qcSortItem){key, (uint64_t)relation};
}

static qcContactSide ContactSideOf(const Job* job, Side side)
{
    uint32_t slot = qcStepTriangles_Slot(job->triangles, side.body);
    const qcBody* body = qcStepTriangles_Body(job->triangles, side.body);
    bool isNearest = job->def->nearestContacts && !body->deforming;
    const qcLocalMinima* surroundings = isNearest ? &QC_AT(qcLocalMinima, job->narrow->surroundings, slot) : NULL;
    return (qcContactSide){body, slot, side.triangle, surroundings};
}

static qcContactPair ContactPairOf(const Job* job, uint64_t key)
{
    qcContactPair pair = {.a = ContactSideOf(job, SideOf(job->triangles, (uint32_t)(key >> 32))),
                          .b = ContactSideOf(job, SideOf(job->triangles, (uint32_t)key))};
    // Between two bodies of a kind all contacts count.
    if (pair.a.body->deforming == pair.b.body->deforming)
        pair.a.surroundings = pair.b.surroundings = NULL;
    pair.margin = qcBody_PairMargin(pair.a.body, pair.b.body, job->def->contactMargin);
    return pair;
}

static void AddContacts(qcNarrowphaseWorker* sink, uint64_t key, const qcContact* found, size_t count)
{
    size_t first = sink->contacts.count;
    if (count == 0)
        return;
    qcStatus status = qcArray_Reserve(&sink->contacts, first + count, sizeof(qcContact), "contacts");
    if (status == qc_statusOk)
        status = qcArray_Reserve(&sink->contactKeys, first + count, sizeof(qcSortItem), "contacts");
    if (!qcWorkerResult_Add(&sink->result, status))
        return;
    memcpy(&QC_AT(qcContact, sink->contacts, first), found, count * sizeof(qcContact));
    for (size_t i = 0; i < count; i++)
        QC_AT(qcSortItem, sink->contactKeys, first + i) = (qcSortItem){key, first + i};
    sink->contacts.count = sink->contactKeys.count = first + count;
}

/// Of pairs that are looked at together.
static void FindContacts(const Job* job, qcNarrowphaseWorker* sink, const uint64_t* keys, size_t count,
                         qcContactFacet facets[2])
{
    qcContactPair pairs[qc_featurePairs];
    qcFeatureMask near[qc_featurePairs];
    for (size_t i = 0; i < count; i++)
        pairs[i] = ContactPairOf(job, keys[i]);
    qcContact_FindNear(job->kernels, pairs, count, near);
    for (size_t i = 0; i < count && qcWorkerResult_IsOk(&sink->result); i++)
    {
        qcContact found[qc_maxContactsPerPair];
        if (near[i] == 0)
            continue;
        qcContactFacet_Set(&facets[0], &pairs[i].a);
        qcContactFacet_Set(&facets[1], &pairs[i].b);
        int foundCount = qcContact_Find(&facets[0], &facets[1], pairs[i].margin, near[i], found);
        AddContacts(sink, keys[i], found, (size_t)foundCount);
    }
}

static size_t BlockCount(const qcArray* keys)
{
    return (keys->count + qc_blockSize - 1) / qc_blockSize;
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcNarrowphaseWorker* sink = &QC_AT(qcNarrowphaseWorker, job->narrow->sinks, worker);
    bool neighbours = block >= job->keyBlocks;
    const qcArray* keys = neighbours ? job->neighbourKeys : job->keys;
    size_t first = (neighbours ? block - job->keyBlocks : block) * qc_blockSize;
    size_t end = first + qc_blockSize < keys->count ? first + qc_blockSize : keys->count;
    Corners corners[2] = {{.known = false}, {.known = false}};
    for (size_t i = first; i < end && !neighbours && qcWorkerResult_IsOk(&sink->result); i++)
        Relate(job, sink, QC_AT(uint64_t, *keys, i), corners);
    if (job->def->contactMargin == 0.0)
        return;
    double start = qcClock_Now();
    qcContactFacet facets[2] = {{.index = NULL}, {.index = NULL}};
    for (size_t i = first; i < end && qcWorkerResult_IsOk(&sink->result); i += qc_featurePairs)
        FindContacts(job, sink, &QC_AT(uint64_t, *keys, i), end - i < qc_featurePairs ? end - i : qc_featurePairs,
                     facets);
    sink->contactMs += qcClock_Now() - start;
}

static qcStatus EmptySinks(qcNarrowphase* narrow, uint32_t threads)
{
    QC_TRY(qcWorkerResults_Begin(&narrow->sinks, threads, sizeof(qcNarrowphaseWorker), "pairs"));
    for (size_t i = 0; i < narrow->sinks.count; i++)
    {
        qcNarrowphaseWorker* sink = &QC_AT(qcNarrowphaseWorker, narrow->sinks, i);
        sink->found.count = sink->contacts.count = sink->contactKeys.count = 0;
        sink->tests = sink->fallbacks = 0;
        sink->contactMs = 0.0;
    }
    return qc_statusOk;
}

/// Of the rigid bodies of the step, by slot.
static qcStatus MakeSurroundings(qcNarrowphase* narrow, const qcStepTriangles* triangles)
{
    const qcArray* slots = &triangles->bodies->slots;
    QC_TRY(qcArray_GrowZeroed(&narrow->surroundings, slots->count, sizeof(qcLocalMinima), "surroundings"));
    for (size_t slot = 0; slot < slots->count; slot++)
    {
        const qcBody* body = &QC_AT(qcBody, *slots, slot);
        qcLocalMinima* surroundings = &QC_AT(qcLocalMinima, narrow->surroundings, slot);
        if (qcBody_IsUsed(body) && !body->deforming)
            QC_TRY(qcLocalMinima_Make(surroundings, body));
        else
            qcLocalMinima_Free(surroundings);
    }
    return qc_statusOk;
}

/// Sorted, into narrow->order.
static qcStatus CollectPairs(qcNarrowphase* narrow, const qcArray* sure)
{
    size_t total = sure->count, at = 0;
    for (size_t i = 0; i < narrow->sinks.count; i++)
        total += QC_AT(qcNarrowphaseWorker, narrow->sinks, i).found.count;
    QC_TRY(qcArray_Resize(&narrow->order, total, sizeof(qcSortItem), "pairs"));
    QC_TRY(qcArray_Resize(&narrow->pairs, total, sizeof(qcPair), "pairs"));
    for (size_t i = 0; i < narrow->sinks.count; i++)
    {
        const qcArray* found = &QC_AT(qcNarrowphaseWorker, narrow->sinks, i).found;
        if (found->count != 0)
            memcpy(&QC_AT(qcSortItem, narrow->order, at), found->data, found->count * sizeof(qcSortItem));
        at += found->count;
    }
    if (sure->count != 0)
        memcpy(&QC_AT(qcSortItem, narrow->order, at), sure->data, sure->count * sizeof(qcSortItem));
    return qcSort_Items(narrow->order.data, total, &narrow->scratch);
}

static void NameBlock(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    const qcStepTriangles* t = job->triangles;
    const qcArray* order = &job->narrow->order;
    size_t end = (block + 1) * qc_namedPairs < order->count ? (block + 1) * qc_namedPairs : order->count;
    for (size_t i = block * qc_namedPairs; i < end; i++)
    {
        qcSortItem item = QC_AT(qcSortItem, *order, i);
        Side a = SideOf(t, (uint32_t)(item.key >> 32)), b = SideOf(t, (uint32_t)item.key);
        QC_AT(qcPair, job->narrow->pairs, i) = (qcPair){.bodyA = qcStepTriangles_Slot(t, a.body),
                                                        .triangleA = a.triangle,
                                                        .bodyB = qcStepTriangles_Slot(t, b.body),
                                                        .triangleB = b.triangle,
                                                        .relation = (qcRelation)item.value};
    }
}

static void ComputeSegment(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    qcSegment* segment = &QC_AT(qcSegment, job->narrow->segments, i);
    *segment = (qcSegment){{0}, {0}};
    qcSortItem item = QC_AT(qcSortItem, job->narrow->order, i);
    if (item.value != qc_relationPenetrating)
        return;
    Corners corners[2] = {{.known = false}, {.known = false}};
    TakeCornersOfPair(job, item.key, corners);
    qcExact_Segment((const double(*)[3])corners[0].corner, (const double(*)[3])corners[1].corner, segment);
}

static void ComputeProximity(void* context, size_t i, uint32_t worker)
{
    (void)worker;
    const Job* job = context;
    qcSortItem item = QC_AT(qcSortItem, job->narrow->order, i);
    Corners corners[2] = {{.known = false}, {.known = false}};
    TakeCornersOfPair(job, item.key, corners);
    qcProximity_Of((const double(*)[3])corners[0].corner, (const double(*)[3])corners[1].corner, (qcRelation)item.value,
                   &QC_AT(qcProximity, job->narrow->proximities, i), &QC_AT(qcClosestFeatures, job->narrow->feet, i));
}

static qcStatus CollectContacts(qcNarrowphase* narrow)
{
    size_t total = 0, at = 0;
    for (size_t i = 0; i < narrow->sinks.count; i++)
        total += QC_AT(qcNarrowphaseWorker, narrow->sinks, i).contacts.count;
    QC_TRY(qcArray_Resize(&narrow->order, total, sizeof(qcSortItem), "contacts"));
    QC_TRY(qcArray_Resize(&narrow->contacts, total, sizeof(qcContact), "contacts"));
    for (size_t i = 0; i < narrow->sinks.count; i++)
    {
        const qcNarrowphaseWorker* sink = &QC_AT(qcNarrowphaseWorker, narrow->sinks, i);
        for (size_t k = 0; k < sink->contactKeys.count; k++, at++)
        {
            // The place names the worker too. Contacts of one key lie together in one worker, and the sort is stable.
            qcSortItem item = QC_AT(qcSortItem, sink->contactKeys, k);
            item.value |= (uint64_t)i << 48;
            QC_AT(qcSortItem, narrow->order, at) = item;
        }
    }
    QC_TRY(qcSort_Items(narrow->order.data, total, &narrow->scratch));
    for (size_t i = 0; i < total; i++)
    {
        uint64_t place = QC_AT(qcSortItem, narrow->order, i).value;
        QC_AT(qcContact, narrow->contacts, i) = QC_AT(
            qcContact, QC_AT(qcNarrowphaseWorker, narrow->sinks, place >> 48).contacts, place & 0xffffffffffffULL);
    }
    return qc_statusOk;
}

qcStatus qcNarrowphase_Run(qcNarrowphase* narrow, const qcStepTriangles* triangles, const qcCandidates* candidates,
                           const qcDetectDef* def, uint32_t threads, qcProfile* profile)
{
    double start = qcClock_Now();
    narrow->pairs.count = narrow->segments.count = narrow->proximities.count = narrow->contacts.count = 0;
    QC_TRY(EmptySinks(narrow, threads));
    if (def->contactMargin > 0.0 && def->nearestContacts)
        QC_TRY(MakeSurroundings(narrow, triangles));
    Job job = {.narrow = narrow,
               .triangles = triangles,
               .keys = &candidates->keys,
               .neighbourKeys = &candidates->neighbourKeys,
               .keyBlocks = BlockCount(&candidates->keys),
               .def = def,
               .kernels = qcTriangleKernels_Get()};
    qcParallel_For(threads, job.keyBlocks + BlockCount(job.neighbourKeys), qc_leastBlocks, TakeBlock, &job);
    QC_TRY(qcWorkerResults_End(&narrow->sinks, sizeof(qcNarrowphaseWorker)));
    double contactMs = 0.0;
    for (size_t i = 0; i < narrow->sinks.count; i++)
    {
        const qcNarrowphaseWorker* sink = &QC_AT(qcNarrowphaseWorker, narrow->sinks, i);
        profile->candidates += sink->tests;
        profile->exactFallbacks += sink->fallbacks;
        contactMs += sink->contactMs / threads;
    }
    QC_TRY(CollectPairs(narrow, &candidates->sure));
    qcParallel_For(threads, (narrow->pairs.count + qc_namedPairs - 1) / qc_namedPairs, qc_leastNamings, NameBlock,
                   &job);
    profile->candidates += candidates->sure.count;
    profile->filterHits = candidates->sure.count;
    profile->pairs = narrow->pairs.count;
    if (def->segments)
    {
        QC_TRY(qcArray_Resize(&narrow->segments, narrow->pairs.count, sizeof(qcSegment), "segments"));
        qcParallel_For(threads, narrow->pairs.count, qc_leastSegments, ComputeSegment, &job);
    }
    if (def->proximities)
    {
        QC_TRY(qcArray_Resize(&narrow->proximities, narrow->pairs.count, sizeof(qcProximity), "proximities"));
        QC_TRY(qcArray_Resize(&narrow->feet, narrow->pairs.count, sizeof(qcClosestFeatures), "proximities"));
        qcParallel_For(threads, narrow->pairs.count, qc_leastProximities, ComputeProximity, &job);
    }
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
    for (size_t i = 0; i < narrow->sinks.count; i++)
    {
        qcNarrowphaseWorker* sink = &QC_AT(qcNarrowphaseWorker, narrow->sinks, i);
        qcArray_Free(&sink->found);
        qcArray_Free(&sink->contacts);
        qcArray_Free(&sink->contactKeys);
    }
    for (size_t slot = 0; slot < narrow->surroundings.count; slot++)
        qcLocalMinima_Free(&QC_AT(qcLocalMinima, narrow->surroundings, slot));
    qcArray_Free(&narrow->surroundings);
    qcArray_Free(&narrow->sinks);
    qcArray_Free(&narrow->order);
    qcArray_Free(&narrow->scratch);
    qcArray_Free(&narrow->pairs);
    qcArray_Free(&narrow->segments);
    qcArray_Free(&narrow->proximities);
    qcArray_Free(&narrow->feet);
    qcArray_Free(&narrow->contacts);
}
