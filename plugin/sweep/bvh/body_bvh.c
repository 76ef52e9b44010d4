// Builds a body's BVH, its adjacency, fans and Verlet reference.
#include "sweep/bvh/body_bvh.h"

#include "base/parallel_for.h"
#include "base/status.h"
#include "base/worker_results.h"

/// Two tasks that don't depend on each other.
typedef struct Linking
{
    qcTriangleBvh* bvh;
    const qcBody* body;
    qcAdjacency adjacency;
    qcWorkerResult results[2];
} Linking;

static void LinkTask(void* context, size_t task, uint32_t worker)
{
    (void)worker;
    Linking* l = context;
    qcTriangleBvh* bvh = l->bvh;
    qcStatus status = task == 0
                          ? qcClusters_Link(&bvh->clusters, l->body->indices, l->body->vertexCount)
                          : qcAdjacency_Build(&l->adjacency, bvh->corners.data, bvh->corners.count, bvh->vertexCount);
    (void)qcWorkerResult_Add(&l->results[task], status);
}

static qcStatus BuildAdjacency(qcBodyBvh* bodyBvh, Linking* linking, uint32_t threads)
{
    qcParallel_For(threads, 2, 2, LinkTask, linking);
    for (int i = 0; i < 2; i++)
        QC_TRY(qcWorkerResult_Check(&linking->results[i]));
    return qcPatchState_Build(&bodyBvh->patches, &bodyBvh->bvh, &linking->adjacency, threads);
}

qcStatus qcBodyBvh_BuildAdjacency(qcBodyBvh* bodyBvh, const qcBody* body, uint32_t threads)
{
    if (bodyBvh->hasAdjacency)
        return qc_statusOk;
    Linking linking = {.bvh = &bodyBvh->bvh, .body = body};
    qcStatus status = BuildAdjacency(bodyBvh, &linking, threads);
    qcAdjacency_Free(&linking.adjacency);
    if (status != qc_statusOk)
        qcClusters_Unlink(&bodyBvh->bvh.clusters);
    bodyBvh->hasAdjacency = status == qc_statusOk;
    return status;
}

qcStatus qcBodyBvh_Build(qcBodyBvh* bodyBvh, const qcBody* body, uint32_t threads)
{
    *bodyBvh = (qcBodyBvh){.hasAdjacency = false};
    qcStatus status = qcTriangleBvh_Build(&bodyBvh->bvh, body, threads);
    if (status == qc_statusOk && qcBody_HasSelfCollision(body))
        status = qcBodyBvh_BuildAdjacency(bodyBvh, body, threads);
    if (status != qc_statusOk)
        qcBodyBvh_Free(bodyBvh);
    return status;
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
    qcPatchState_Free(&bodyBvh->patches);
    qcVertexFans_Free(&bodyBvh->fans);
    qcArray_Free(&bodyBvh->isSeparated);
    qcVerletReference_Free(&bodyBvh->verlet);
    bodyBvh->hasAdjacency = false;
}
