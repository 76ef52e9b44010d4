// Most vertex fans are proven separated (kernels/vertex_fan_test.inl.h): their pairs are not even listed. Around the
// other vertices the pairs are listed, and a kernel drops most of them.
#include "sweep/bvh/neighbour_pairs.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "sweep/bvh/bvh_lattice.h"

#include <string.h>

enum
{
    // Batches, and vertices: a block takes some 10 microseconds.
    qc_batchBlock = 16,
    qc_vertexBlock = 256,
    qc_minBlocks = 4,
    qc_maxPairs = qc_nodeSize * qc_nodeSize ///< that the kernel takes at once
};

typedef struct Search
{
    const qcNeighbourPairsJob* job;
    const qcTriangleBvh* bvh;
    const qcVertexFans* fans;
    uint8_t* isSeparated; ///< by vertex
    qcIndexedTriangles triangles;
    qcDistanceThresholds thresholds;
} Search;

static bool IsOutlier(const Search* s, uint32_t slot)
{
    return s->bvh->fit.lattice.hasOutliers && qcBvhFit_IsOutlier(&s->bvh->fit, &s->triangles.corners[slot]);
}

/// True if errors of points around a vertex may be larger than the kernels allow for.
static bool HasOutliers(const Search* s, uint32_t vertex)
{
    const uint32_t *first = s->fans->around.first.data, *slots = s->fans->around.triangles.data;
    bool has = false;
    for (uint32_t i = first[vertex]; s->bvh->fit.lattice.hasOutliers && i < first[vertex + 1]; i++)
        has |= IsOutlier(s, slots[i]);
    return has;
}

static void TestFans(void* context, size_t block, uint32_t worker)
{
    (void)worker;
    const Search* s = context;
    size_t end = (block + 1) * qc_batchBlock;
    end = end < s->fans->batches.count ? end : s->fans->batches.count;
    for (size_t i = block * qc_batchBlock; i < end; i++)
    {
        const qcVertexFanBatch* batch = &QC_AT(qcVertexFanBatch, s->fans->batches, i);
        const uint32_t* vertices = &QC_AT(uint32_t, s->fans->vertices, batch->firstVertex);
        uint32_t separated =
            s->job->kernels->findSeparatedFans(s->triangles.points, vertices, batch->valence, &s->thresholds);
        for (uint32_t lane = 0; lane < batch->count; lane++)
            s->isSeparated[vertices[lane]] = (separated >> lane & 1u) != 0 && !HasOutliers(s, vertices[lane]);
    }
}

static bool HasVertex(const qcCorners* corners, uint32_t vertex)
{
    return corners->vertex[0] == vertex || corners->vertex[1] == vertex || corners->vertex[2] == vertex;
}

/// True if the pair is listed at this vertex: the lowest of its common vertices, none of which has a separated fan.
static bool IsListedAt(const Search* s, uint32_t vertex, uint32_t a, uint32_t b)
{
    const qcCorners *p = &s->triangles.corners[a], *q = &s->triangles.corners[b];
    for (int c = 0; c < 3; c++)
    {
        uint32_t other = p->vertex[c];
        if (HasVertex(q, other) && (other < vertex || s->isSeparated[other]))
            return false;
    }
    return true;
}

static void ReportPairs(const Search* s, qcSlotPair* pairs, size_t count, uint32_t worker)
{
    count = s->job->kernels->filterNeighbours(&s->triangles, &s->thresholds, pairs, count);
    s->job->function(s->job->context, pairs, count, worker);
}

static void FindPairsAtVertices(void* context, size_t block, uint32_t worker)
{
    const Search* s = context;
    const uint32_t *first = s->fans->around.first.data, *slots = s->fans->around.triangles.data;
    uint32_t begin = (uint32_t)block * qc_vertexBlock, left = s->bvh->vertexCount - begin;
    qcSlotPair pairs[qc_maxPairs];
    size_t count = 0;
    for (uint32_t v = begin; v < begin + (left < qc_vertexBlock ? left : qc_vertexBlock); v++)
    {
        if (s->isSeparated[v])
            continue;
        for (uint32_t i = first[v]; i < first[v + 1]; i++)
            for (uint32_t k = i + 1; k < first[v + 1]; k++)
            {
                if (!IsListedAt(s, v, slots[i], slots[k]))
                    continue;
                const qcSlotPair pair = {slots[i], slots[k]};
                if (IsOutlier(s, pair.a) || IsOutlier(s, pair.b))
                {
                    s->job->function(s->job->context, &pair, 1, worker);
                    continue;
                }
                pairs[count++] = pair;
                if (count < qc_maxPairs)
                    continue;
                ReportPairs(s, pairs, count, worker);
                count = 0;
            }
    }
    ReportPairs(s, pairs, count, worker);
}

qcStatus qcNeighbourPairs_Find(const qcNeighbourPairsJob* job)
{
    qcBodyBvh* body = job->body;
    const qcTriangleBvh* bvh = &body->bvh;
    QC_TRY(qcBodyBvh_MakeFans(body));
    QC_TRY(qcArray_Resize(&body->isSeparated, bvh->vertexCount, 1, "vertex fans"));
    if (bvh->vertexCount != 0)
        memset(body->isSeparated.data, 0, bvh->vertexCount);
    Search search = {.job = job,
                     .bvh = bvh,
                     .fans = &body->fans,
                     .isSeparated = body->isSeparated.data,
                     .triangles = {bvh->corners.data, bvh->fit.points.data},
                     .thresholds = {.pointError = bvh->fit.pointError,
                                    .query = qcTriangleBvh_DistanceInFrame(bvh, bvh->fit.margin)}};
    size_t batches = (body->fans.batches.count + qc_batchBlock - 1) / qc_batchBlock;
    qcParallel_For(job->threads, batches, qc_minBlocks, TestFans, &search);
    size_t blocks = ((size_t)bvh->vertexCount + qc_vertexBlock - 1) / qc_vertexBlock;
    qcParallel_For(job->threads, blocks, qc_minBlocks, FindPairsAtVertices, &search);
    return qc_statusOk;
}
