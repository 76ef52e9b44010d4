// Builds a body's BVH, its adjacency, fans and Verlet reference.
#include "sweep/bvh/body_bvh.h"

#include "base/status.h"

enum
{
    // Work in a step, and that of the stages, in units of about 10 ns a triangle. A search takes 3 to 6.
    qc_stepWork = 2,
    qc_nodesWork = 2,
    qc_linksWork = 2,
    qc_masksWork = 7,
    qc_aroundWork = 1,
    qc_acrossWork = 8,
    qc_patchesWork = 26,
    // Steps of small bodies are short in any case, unless there are many (see prepare_bvhs.c).
    qc_minNodes = 16
};

/// The nodes of a stage whose work is left, at least one.
static uint32_t NodesFor(int64_t work, int64_t nodeWork, uint32_t left)
{
    int64_t nodes = work / nodeWork + 1;
    return nodes < left ? (uint32_t)nodes : left;
}

static void EndAdjacency(qcBodyBvh* bodyBvh)
{
    bodyBvh->hasAdjacency = true;
    qcLinking_Free(&bodyBvh->adjacency.linking);
    qcAdjacency_Free(&bodyBvh->adjacency.adjacency);
    qcArray_Free(&bodyBvh->vertices);
}

/// A stage, or as much of it as there is work for.
static qcStatus RunStage(qcBodyBvh* bodyBvh, int64_t* work, uint32_t threads)
{
    qcTriangleBvh* bvh = &bodyBvh->bvh;
    qcAdjacencyBuild* build = &bodyBvh->adjacency;
    const qcCorners* corners = bvh->corners.data;
    uint32_t nodes = bvh->clusters.nodeCount, count;
    switch (build->stage)
    {
        case qc_adjacencyNodes:
            QC_TRY(qcLinking_Begin(&build->linking, &bvh->clusters, corners, bvh->vertexCount));
            *work -= qc_nodesWork * (int64_t)nodes;
            build->stage++;
            break;
        case qc_adjacencyLinks:
            QC_TRY(qcLinking_FindLinks(&build->linking, &bvh->clusters));
            *work -= qc_linksWork * (int64_t)nodes;
            build->stage++;
            break;
        case qc_adjacencyMasks:
            count = NodesFor(*work, qc_masksWork, nodes - build->linking.nextNode);
            QC_TRY(qcLinking_Continue(&build->linking, &bvh->clusters, count));
            *work -= qc_masksWork * (int64_t)count;
            build->stage += build->linking.nextNode == nodes;
            break;
        case qc_adjacencyAround:
            QC_TRY(qcAdjacency_Begin(&build->adjacency, corners, bvh->corners.count, bvh->vertexCount));
            *work -= qc_aroundWork * (int64_t)nodes;
            build->stage++;
            break;
        case qc_adjacencyAcross:
            count = NodesFor(*work, qc_acrossWork, nodes - build->nextNode);
            qcAdjacency_FindAcross(&build->adjacency, corners, bvh->vertexCount, (size_t)build->nextNode * qc_nodeSize,
                                   (size_t)(build->nextNode + count) * qc_nodeSize, threads);
            build->nextNode += count;
            *work -= qc_acrossWork * (int64_t)count;
            build->stage += build->nextNode == nodes;
            break;
        case qc_adjacencyPatches:
            count = NodesFor(*work, qc_patchesWork, nodes);
            QC_TRY(qcPatchState_Build(&bodyBvh->patches, bvh, &build->adjacency, count, threads));
            *work -= qc_patchesWork * (int64_t)count;
            if (qcPatchState_IsBuilt(&bodyBvh->patches))
                EndAdjacency(bodyBvh);
            break;
    }
    return qc_statusOk;
}

static void FreeAdjacency(qcBodyBvh* bodyBvh)
{
    qcLinking_Free(&bodyBvh->adjacency.linking);
    qcAdjacency_Free(&bodyBvh->adjacency.adjacency);
    qcPatchState_Free(&bodyBvh->patches);
    bodyBvh->adjacency = (qcAdjacencyBuild){.stage = qc_adjacencyNodes};
}

/// Stages until the work is done. On failure there is no adjacency.
static qcStatus RunStages(qcBodyBvh* bodyBvh, int64_t work, uint32_t threads)
{
    qcStatus status = qc_statusOk;
    while (status == qc_statusOk && !bodyBvh->hasAdjacency && work > 0)
        status = RunStage(bodyBvh, &work, threads);
    if (status == qc_statusOk)
        return status;
    FreeAdjacency(bodyBvh);
    qcClusters_Unlink(&bodyBvh->bvh.clusters);
    return status;
}

qcStatus qcBodyBvh_BuildAdjacency(qcBodyBvh* bodyBvh, uint32_t threads)
{
    return RunStages(bodyBvh, INT64_MAX, threads);
}

uint32_t qcBodyBvh_AdjacencyWork(const qcBodyBvh* bodyBvh)
{
    uint32_t nodes = bodyBvh->bvh.clusters.nodeCount;
    return nodes > qc_minNodes ? nodes : qc_minNodes;
}

qcStatus qcBodyBvh_ContinueAdjacency(qcBodyBvh* bodyBvh, uint32_t threads)
{
    return RunStages(bodyBvh, qc_stepWork * (int64_t)qcBodyBvh_AdjacencyWork(bodyBvh), threads);
}

qcStatus qcBodyBvh_PrepareSelf(qcBodyBvh* bodyBvh, uint32_t threads)
{
    const qcTriangleBvh* bvh = &bodyBvh->bvh;
    if (qcBodyBvh_FindsSelfPairs(bodyBvh))
        return qc_statusOk;
    if (bvh->clusters.hasHub)
        return qcBodyBvh_BuildAdjacency(bodyBvh, threads);
    return qcClusters_ListVertices(&bvh->clusters, bvh->corners.data, bvh->vertexCount, threads, &bodyBvh->vertices);
}

/// All besides the BVH. `status`: of its build.
static qcStatus EndBuild(qcStatus status, const qcBody* body, uint32_t threads, qcBodyBvh* bodyBvh)
{
    if (status == qc_statusOk && qcBody_HasSelfCollision(body))
        status = qcBodyBvh_PrepareSelf(bodyBvh, threads);
    if (status != qc_statusOk)
        qcBodyBvh_Free(bodyBvh);
    return status;
}

qcStatus qcBodyBvh_Build(qcBodyBvh* bodyBvh, const qcBody* body, const qcBvhRegion* region, uint32_t threads)
{
    *bodyBvh = (qcBodyBvh){.hasAdjacency = false};
    const qcOrderOptions options = {.threads = threads, .region = region != NULL ? &region->cells : NULL};
    qcStatus status = qcTriangleBvh_Build(&bodyBvh->bvh, body, &options);
    if (status == qc_statusOk && region != NULL)
        status = qcTriangleBvh_KeepRegion(&bodyBvh->bvh, body, region);
    return EndBuild(status, body, threads, bodyBvh);
}

qcStatus qcBodyBvh_BuildLike(qcBodyBvh* bodyBvh, const qcBody* body, const qcTriangleBvh* other, uint32_t threads)
{
    *bodyBvh = (qcBodyBvh){.hasAdjacency = false};
    return EndBuild(qcTriangleBvh_BuildLike(&bodyBvh->bvh, body, other), body, threads, bodyBvh);
}

qcStatus qcBodyBvh_MakeFans(qcBodyBvh* bodyBvh)
{
    const qcTriangleBvh* bvh = &bodyBvh->bvh;
    return qcVertexFans_Make(&bodyBvh->fans, bvh->corners.data, bvh->corners.count, bvh->vertexCount);
}

qcStatus qcBodyBvh_SetVerletReference(qcBodyBvh* bodyBvh, const qcBody* body, double margin)
{
    qcVerletReference_Clear(&bodyBvh->verlet);
    QC_TRY(qcBodyBvh_MakeFans(bodyBvh));
    return qcVerletReference_Set(&bodyBvh->verlet, &bodyBvh->bvh, body, margin);
}

void qcBodyBvh_Free(qcBodyBvh* bodyBvh)
{
    qcTriangleBvh_Free(&bodyBvh->bvh);
    FreeAdjacency(bodyBvh);
    qcVertexFans_Free(&bodyBvh->fans);
    qcArray_Free(&bodyBvh->isSeparated);
    qcArray_Free(&bodyBvh->vertices);
    qcVerletReference_Free(&bodyBvh->verlet);
    bodyBvh->hasAdjacency = false;
}
