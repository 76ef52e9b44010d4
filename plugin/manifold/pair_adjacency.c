// Which unsettled pairs are adjacent, triangle by triangle: the pairs of a triangle are listed by the vertices of their
// other triangles (a fan each), and those near each other in a list are adjacent.
#include "manifold/pair_adjacency.h"
#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // A block takes some 100 microseconds.
    qc_adjacencyBlock = 64,
    qc_minAdjacencyBlocks = 4,
    // Room is made for so many pairs at once.
    qc_adjacencyRoom = 64
};

/// The pairs of the triangle whose other triangle has a given vertex.
typedef struct Fan
{
    uint32_t first, count;
} Fan;

/// Whether a pair has been added for the current one, and where.
typedef struct Visit
{
    uint32_t by; ///< the current pair plus 1
    uint32_t entry;
} Visit;

/// The pairs of one triangle, numbered from 0.
typedef struct TrianglePairs
{
    qcAdjacencyWorker* worker;
    qcPairSide* sides;
    uint32_t first, count; ///< of the sides
    Fan* fans;
    uint32_t* fanOf;    ///< three a pair
    uint32_t* position; ///< three a pair: among the members
    uint32_t* members;  ///< of all fans
    Visit* visits;
} TrianglePairs;

/// A triangle with its pair sides.
typedef struct Triangle
{
    const qcManifoldTriangle* triangle;
    qcSideRange sides;
} Triangle;

typedef struct Job
{
    const qcContactTopology* topology;
    qcPairAdjacency* adjacency;
} Job;

static qcStatus Begin(qcPairAdjacency* adjacency, qcAdjacencyWorker* worker, qcSideRange range, TrianglePairs* pairs)
{
    size_t corners = 3 * (size_t)range.count;
    QC_TRY(qcArray_Reserve(&worker->fans, corners, sizeof(Fan), "adjacent pairs of manifolds"));
    QC_TRY(qcArray_Reserve(&worker->fanLists, 3 * corners, sizeof(uint32_t), "adjacent pairs of manifolds"));
    QC_TRY(qcArray_Reserve(&worker->visits, range.count, sizeof(Visit), "adjacent pairs of manifolds"));
    uint32_t* lists = worker->fanLists.data;
    *pairs = (TrianglePairs){.worker = worker,
                             .first = range.first,
                             .sides = &QC_AT(qcPairSide, adjacency->sides, range.first),
                             .count = range.count,
                             .fans = worker->fans.data,
                             .fanOf = lists,
                             .position = lists + corners,
                             .members = lists + 2 * corners,
                             .visits = worker->visits.data};
    return qc_statusOk;
}

static void ListFans(TrianglePairs* pairs)
{
    uint32_t* fanOfVertex = pairs->worker->fanOfVertex.data;
    uint32_t fans = 0, first = 0;
    for (uint32_t i = 0; i < pairs->count; i++)
    {
        pairs->visits[i].by = 0;
        const uint32_t* vertex = pairs->sides[i].other->vertex;
        for (uint32_t c = 0; c < 3; c++)
        {
            uint32_t* fan = &fanOfVertex[vertex[c]];
            if (*fan == 0)
            {
                pairs->fans[fans].count = 0;
                *fan = ++fans;
            }
            pairs->fanOf[3 * i + c] = *fan - 1;
            pairs->fans[*fan - 1].count++;
        }
    }
    for (uint32_t f = 0; f < fans; f++)
    {
        pairs->fans[f].first = first;
        first += pairs->fans[f].count;
        pairs->fans[f].count = 0;
    }
    for (uint32_t i = 0; i < pairs->count; i++)
    {
        const uint32_t* vertex = pairs->sides[i].other->vertex;
        for (uint32_t c = 0; c < 3; c++)
        {
            Fan* fan = &pairs->fans[pairs->fanOf[3 * i + c]];
            pairs->position[3 * i + c] = fan->first + fan->count;
            pairs->members[fan->first + fan->count++] = i;
            fanOfVertex[vertex[c]] = 0;
        }
    }
}

/// Adds the pairs adjacent to pair i through one corner; returns the new number.
static uint32_t AddFan(const TrianglePairs* pairs, uint32_t i, uint32_t corner, uint32_t* adjacent, uint32_t count)
{
    const Fan* fan = &pairs->fans[pairs->fanOf[3 * i + corner]];
    uint32_t position = pairs->position[3 * i + corner], end = fan->first + fan->count;
    uint32_t first = position - fan->first > qc_maxFanSteps ? position - qc_maxFanSteps : fan->first;
    uint32_t last = end - position > qc_maxFanSteps ? position + qc_maxFanSteps + 1 : end;
    for (uint32_t k = first; k < last; k++)
    {
        uint32_t j = pairs->members[k];
        Visit* visit = &pairs->visits[j];
        if (j == i)
            continue;
        if (visit->by != i + 1)
        {
            *visit = (Visit){i + 1, count};
            adjacent[count++] = (pairs->first + j) * qc_sideStep + 1;
        }
        // A vertex of a degenerate triangle counts twice.
        else if ((adjacent[visit->entry] & qc_sharedVertices) < 3)
            adjacent[visit->entry]++;
    }
    return count;
}

static qcStatus FindAdjacent(qcPairAdjacency* adjacency, uint32_t worker, const Triangle* of)
{
    if (of->sides.count == 0)
        return qc_statusOk;
    TrianglePairs pairs;
    qcAdjacencyWorker* self = &QC_AT(qcAdjacencyWorker, adjacency->workers, worker);
    QC_TRY(Begin(adjacency, self, of->sides, &pairs));
    ListFans(&pairs);
    for (uint32_t i = 0; i < pairs.count; i++)
    {
        qcPairSide* side = &pairs.sides[i];
        side->heights = qcManifoldTriangle_Heights(side->other, of->triangle->corner[0], of->triangle->normal);
        size_t first = self->adjacent.count;
        if (i % qc_adjacencyRoom == 0)
            QC_TRY(qcArray_Reserve(&self->adjacent, first + (size_t)qc_adjacencyRoom * qc_maxAdjacentPairs,
                                   sizeof(uint32_t), "adjacent pairs of manifolds"));
        uint32_t count = 0;
        for (uint32_t c = 0; c < 3; c++)
            count = AddFan(&pairs, i, c, &QC_AT(uint32_t, self->adjacent, first), count);
        self->adjacent.count = first + count;
        side->worker = (uint16_t)worker;
        side->adjacentCount = (uint8_t)count;
        side->firstAdjacent = first;
    }
    return qc_statusOk;
}

static void FindBlock(void* context, size_t block, uint32_t worker)
{
    const Job* job = context;
    qcWorkerResult* result = &QC_AT(qcAdjacencyWorker, job->adjacency->workers, worker).result;
    size_t count = job->topology->triangles.count, end = (block + 1) * qc_adjacencyBlock;
    for (size_t t = block * qc_adjacencyBlock; t < (end < count ? end : count) && qcWorkerResult_IsOk(result); t++)
    {
        const Triangle triangle = {&QC_AT(qcManifoldTriangle, job->topology->triangles, t),
                                   QC_AT(qcSideRange, job->adjacency->ranges, t)};
        (void)qcWorkerResult_Add(result, FindAdjacent(job->adjacency, worker, &triangle));
    }
}

/// Lists the unsettled pairs of each triangle, in their order.
static qcStatus ListSides(const qcContactTopology* topology, const qcContactRegions* regions,
                          const qcContactProximity* proximity, qcPairAdjacency* adjacency)
{
    size_t pairs = topology->pairs.count, triangles = topology->triangles.count;
    size_t unsettled = regions->unsettledPairs.count;
    QC_TRY(qcArray_Resize(&adjacency->sides, 2 * unsettled, sizeof(qcPairSide), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&adjacency->sideOf, 2 * pairs, sizeof(uint32_t), "pairs of manifolds"));
    QC_TRY(qcArray_Resize(&adjacency->ranges, triangles, sizeof(qcSideRange), "pairs of manifolds"));
    uint32_t number = 0;
    for (size_t t = 0; t < triangles; t++)
    {
        const qcManifoldTriangle* triangle = &QC_AT(qcManifoldTriangle, topology->triangles, t);
        uint32_t first = number;
        for (uint32_t k = 0; k < triangle->pairCount; k++)
        {
            uint32_t p = QC_AT(qcPairEntry, topology->pairsOf, triangle->firstPair + k).pair;
            const qcManifoldPair* pair = qcContactTopology_Pair(topology, p);
            if (qcContactRegions_IsSettled(regions, pair))
                continue;
            uint32_t side = pair->side[0] == triangle ? 0 : 1;
            QC_AT(uint32_t, adjacency->sideOf, 2 * (size_t)p + side) = number;
            QC_AT(qcPairSide, adjacency->sides, number++) = (qcPairSide){
                .other = pair->side[1 - side], .gap = qcContactProximity_Pair(proximity, p)->gap, .pair = p};
        }
        QC_AT(qcSideRange, adjacency->ranges, t) = (qcSideRange){first, number - first};
    }
    return qc_statusOk;
}

static qcStatus BeginWorkers(uint32_t threads, size_t vertices, qcPairAdjacency* adjacency)
{
    QC_TRY(
        qcWorkerResults_Begin(&adjacency->workers, threads, sizeof(qcAdjacencyWorker), "adjacent pairs of manifolds"));
    for (size_t i = 0; i < adjacency->workers.count; i++)
    {
        qcAdjacencyWorker* worker = &QC_AT(qcAdjacencyWorker, adjacency->workers, i);
        worker->adjacent.count = 0;
        if (i >= threads)
            continue;
        QC_TRY(qcArray_Resize(&worker->fanOfVertex, vertices, sizeof(uint32_t), "adjacent pairs of manifolds"));
        memset(worker->fanOfVertex.data, 0, vertices * sizeof(uint32_t));
    }
    return qc_statusOk;
}

qcStatus qcPairAdjacency_Find(const qcContactTopology* topology, const qcContactRegions* regions,
                              const qcContactProximity* proximity, uint32_t threads, qcPairAdjacency* adjacency)
{
    QC_TRY(ListSides(topology, regions, proximity, adjacency));
    QC_TRY(BeginWorkers(threads, topology->vertices.count, adjacency));
    Job job = {topology, adjacency};
    size_t blocks = (topology->triangles.count + qc_adjacencyBlock - 1) / qc_adjacencyBlock;
    qcParallel_For(threads, blocks, qc_minAdjacencyBlocks, FindBlock, &job);
    return qcWorkerResults_End(&adjacency->workers, sizeof(qcAdjacencyWorker));
}

void qcPairAdjacency_Free(qcPairAdjacency* adjacency)
{
    for (size_t i = 0; i < adjacency->workers.count; i++)
    {
        qcAdjacencyWorker* worker = &QC_AT(qcAdjacencyWorker, adjacency->workers, i);
        qcArray* arrays[] = {&worker->adjacent, &worker->fanOfVertex, &worker->fans, &worker->fanLists,
                             &worker->visits};
        for (size_t k = 0; k < sizeof arrays / sizeof arrays[0]; k++)
            qcArray_Free(arrays[k]);
    }
    qcArray* arrays[] = {&adjacency->sides, &adjacency->ranges, &adjacency->sideOf, &adjacency->workers};
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        qcArray_Free(arrays[i]);
}
