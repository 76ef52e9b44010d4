// Pairs within flat discs have no such features (surface_kernels_flat.h); of the others the kernel drops most.
#include "surface_neighbours.h"

#include "parallel.h"
#include "status.h"

#include <string.h>

enum
{
    // Nodes of a block: 64 take about 0.1 ms.
    qc_nodeBlock = 16,
    qc_leastBlocks = 4
};

typedef struct Sink
{
    qcArray keys; ///< uint64_t
    qcStatus status;
} Sink;

typedef struct Search
{
    qcSurfaceNeighbours* memory;
    const qcSurfaceNeighboursJob* job;
    qcFilterSide side;
    qcFilterBound bound;
} Search;

static void TakeNode(const Search* s, uint32_t node, Sink* sink)
{
    const qcSurface* surface = s->job->surface;
    const qcClusters* clusters = &surface->clusters;
    const uint32_t *links = clusters->firstLink.data, *triangles = clusters->triangles.data;
    for (uint32_t link = links[node]; link < links[node + 1] && sink->status == qc_statusOk; link++)
    {
        qcPlaceSkip skips[qc_mostSkips];
        qcPlacePair pairs[qc_nodeSize * qc_nodeSize];
        int skipCount = qcSurface_FindSkips(surface, node, link, skips);
        const qcPlacePair* end = qcClusters_FindNeighbours(clusters, node, link, skips, skipCount, pairs);
        size_t count = s->job->kernels->keepNearNeighbours(&s->side, &s->bound, pairs, (size_t)(end - pairs));
        sink->status = qcArray_Reserve(&sink->keys, sink->keys.count + count, sizeof(uint64_t), "neighbours");
        for (size_t i = 0; i < count && sink->status == qc_statusOk; i++)
        {
            uint64_t a = s->job->first + triangles[pairs[i].a], b = s->job->first + triangles[pairs[i].b];
            QC_AT(uint64_t, sink->keys, sink->keys.count++) = a < b ? a << 32 | b : b << 32 | a;
        }
    }
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    const Search* s = context;
    uint32_t nodes = s->job->surface->clusters.nodeCount, first = (uint32_t)block * qc_nodeBlock;
    for (uint32_t node = first; node < nodes && node < first + qc_nodeBlock; node++)
        TakeNode(s, node, &QC_AT(Sink, s->memory->sinks, worker));
}

qcStatus qcSurfaceNeighbours_Add(qcSurfaceNeighbours* neighbours, const qcSurfaceNeighboursJob* job, qcArray* keys)
{
    const qcSurface* surface = job->surface;
    Search search = {.memory = neighbours,
                     .job = job,
                     .side = {surface->corners.data, surface->points.data},
                     .bound = {.pointError = surface->pointError, .reach = qcSurface_Reach(surface)}};
    size_t old = neighbours->sinks.count;
    if (job->threads > old)
    {
        QC_TRY(qcArray_Resize(&neighbours->sinks, job->threads, sizeof(Sink), "neighbours"));
        memset(&QC_AT(Sink, neighbours->sinks, old), 0, (job->threads - old) * sizeof(Sink));
    }
    for (size_t i = 0; i < neighbours->sinks.count; i++)
    {
        QC_AT(Sink, neighbours->sinks, i).keys.count = 0;
        QC_AT(Sink, neighbours->sinks, i).status = qc_statusOk;
    }
    size_t blocks = ((size_t)surface->clusters.nodeCount + qc_nodeBlock - 1) / qc_nodeBlock;
    qcParallel_For(job->threads, blocks, qc_leastBlocks, TakeBlock, &search);
    for (size_t i = 0; i < neighbours->sinks.count; i++)
    {
        const Sink* sink = &QC_AT(Sink, neighbours->sinks, i);
        // The message is the worker's own; say it again on this thread.
        if (sink->status != qc_statusOk)
            return qcArray_FailAgain(&sink->keys, "neighbours");
        QC_TRY(qcArray_Append(keys, &sink->keys, sizeof(uint64_t), "neighbours"));
    }
    return qc_statusOk;
}

void qcSurfaceNeighbours_Free(qcSurfaceNeighbours* neighbours)
{
    for (size_t i = 0; i < neighbours->sinks.count; i++)
        qcArray_Free(&QC_AT(Sink, neighbours->sinks, i).keys);
    qcArray_Free(&neighbours->sinks);
}
