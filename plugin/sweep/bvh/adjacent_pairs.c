// Around most vertices nothing comes near (kernels/vertex_fan_test.inl.h): of these no pair is looked at. Around the
// others the pairs are listed, and the kernel drops most.
#include "sweep/bvh/adjacent_pairs.h"

#include "base/parallel_for.h"
#include "base/status.h"

#include <string.h>

enum
{
    // Batches, and vertices: a block takes some 10 microseconds.
    qc_batchBlock = 16,
    qc_vertexBlock = 256,
    qc_leastBlocks = 4,
    qc_room = qc_nodeSize * qc_nodeSize ///< pairs that the kernel takes at once
};

typedef struct Search
{
    const qcAdjacentPairsJob* job;
    qcFilterSide side;
    qcDistanceThresholds bound;
} Search;

static void AskBatches(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Search* s = context;
    qcTriangleBvh* surface = s->job->surface;
    size_t end = (block + 1) * qc_batchBlock;
    end = end < surface->stars.batches.count ? end : surface->stars.batches.count;
    for (size_t i = block * qc_batchBlock; i < end; i++)
    {
        const qcVertexFanBatch* batch = &QC_AT(qcVertexFanBatch, surface->stars.batches, i);
        const uint32_t* vertices = &QC_AT(uint32_t, surface->stars.vertices, batch->firstVertex);
        uint32_t quiet = s->job->kernels->findQuietStars(s->side.points, vertices, batch->valence, &s->bound);
        for (uint32_t lane = 0; lane < batch->count; lane++)
            QC_AT(uint8_t, surface->quiet, vertices[lane]) = quiet >> lane & 1u;
    }
}

static bool HasVertex(const qcCorners* corners, uint32_t vertex)
{
    return corners->vertex[0] == vertex || corners->vertex[1] == vertex || corners->vertex[2] == vertex;
}

/// Is the pair looked at around this vertex: the least of those that it has in common, none of which is quiet?
static bool IsPairOf(const qcTriangleBvh* surface, uint32_t vertex, uint32_t a, uint32_t b)
{
    const qcCorners *p = &QC_AT(qcCorners, surface->corners, a), *q = &QC_AT(qcCorners, surface->corners, b);
    for (int c = 0; c < 3; c++)
    {
        uint32_t other = p->vertex[c];
        if (HasVertex(q, other) && (other < vertex || QC_AT(uint8_t, surface->quiet, other)))
            return false;
    }
    return true;
}

static void GivePairs(const Search* s, qcSlotPair* pairs, size_t count, uint32_t worker)
{
    count = s->job->kernels->keepNearNeighbours(&s->side, &s->bound, pairs, count);
    s->job->function(s->job->context, pairs, count, worker);
}

static void TakeVertices(void* context, size_t block, uint32_t worker)
{
    const Search* s = context;
    const qcTriangleBvh* surface = s->job->surface;
    const uint32_t *first = surface->stars.around.first.data, *places = surface->stars.around.triangles.data;
    uint32_t begin = (uint32_t)block * qc_vertexBlock, left = surface->vertexCount - begin;
    qcSlotPair pairs[qc_room];
    size_t count = 0;
    for (uint32_t v = begin; v < begin + (left < qc_vertexBlock ? left : qc_vertexBlock); v++)
    {
        if (QC_AT(uint8_t, surface->quiet, v))
            continue;
        for (uint32_t i = first[v]; i < first[v + 1]; i++)
            for (uint32_t k = i + 1; k < first[v + 1]; k++)
            {
                if (!IsPairOf(surface, v, places[i], places[k]))
                    continue;
                pairs[count++] = (qcSlotPair){places[i], places[k]};
                if (count < qc_room)
                    continue;
                GivePairs(s, pairs, count, worker);
                count = 0;
            }
    }
    GivePairs(s, pairs, count, worker);
}

qcStatus qcAdjacentPairs_Find(const qcAdjacentPairsJob* job)
{
    qcTriangleBvh* surface = job->surface;
    QC_TRY(qcVertexFans_Make(&surface->stars, surface->corners.data, surface->corners.count, surface->vertexCount));
    QC_TRY(qcArray_Resize(&surface->quiet, surface->vertexCount, 1, "stars of a surface"));
    if (surface->vertexCount != 0)
        memset(surface->quiet.data, 0, surface->vertexCount);
    Search search = {
        .job = job,
        .side = {surface->corners.data, surface->points.data},
        .bound = {.pointError = surface->pointError, .reach = qcTriangleBvh_Reach(surface, surface->margin)}};
    size_t batches = (surface->stars.batches.count + qc_batchBlock - 1) / qc_batchBlock;
    qcParallel_For(job->threads, batches, qc_leastBlocks, AskBatches, &search);
    size_t blocks = ((size_t)surface->vertexCount + qc_vertexBlock - 1) / qc_vertexBlock;
    qcParallel_For(job->threads, blocks, qc_leastBlocks, TakeVertices, &search);
    return qc_statusOk;
}
