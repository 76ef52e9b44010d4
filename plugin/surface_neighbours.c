// Pairs within flat discs have no such features (surface_kernels_flat.h); of the others the kernel drops most.
#include "surface_neighbours.h"

#include "parallel.h"

#include <assert.h>

enum
{
    // Nodes of a block: 64 take about 0.1 ms.
    qc_nodeBlock = 16,
    qc_leastBlocks = 4
};

static void TakeNode(const qcSurfaceNeighboursJob* job, uint32_t node, uint32_t worker)
{
    const qcSurface* surface = job->surface;
    qcFilterSide side = {surface->corners.data, surface->points.data};
    qcFilterBound bound = {.pointError = surface->pointError, .reach = qcSurface_Reach(surface, surface->margin)};
    const uint32_t* links = surface->clusters.firstLink.data;
    for (uint32_t link = links[node]; link < links[node + 1]; link++)
    {
        qcPlaceSkip skips[qc_mostSkips];
        qcPlacePair pairs[qc_nodeSize * qc_nodeSize];
        int skipCount = qcSurface_FindSkips(surface, node, link, skips);
        const qcPlacePair* end = qcClusters_FindNeighbours(&surface->clusters, node, link, skips, skipCount, pairs);
        size_t count = job->kernels->keepNearNeighbours(&side, &bound, pairs, (size_t)(end - pairs));
        job->function(job->context, pairs, count, worker);
    }
}

static void TakeBlock(void* context, size_t block, uint32_t worker)
{
    const qcSurfaceNeighboursJob* job = context;
    uint32_t nodes = job->surface->clusters.nodeCount, first = (uint32_t)block * qc_nodeBlock;
    for (uint32_t node = first; node < nodes && node < first + qc_nodeBlock; node++)
        TakeNode(job, node, worker);
}

void qcSurfaceNeighbours_Find(const qcSurfaceNeighboursJob* job)
{
    assert(job->surface->related);
    qcSurfaceNeighboursJob copy = *job; // as loops take it
    size_t blocks = ((size_t)job->surface->clusters.nodeCount + qc_nodeBlock - 1) / qc_nodeBlock;
    qcParallel_For(job->threads, blocks, qc_leastBlocks, TakeBlock, &copy);
}
