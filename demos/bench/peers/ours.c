// Our methods as the benchmarks run them: a scene, and for each frame new vertices or transforms, then a detection.
#include "bench/peers/peers.h"

#include "common/stopwatch.h"

#include <stdlib.h>

static qcStatus AddBody(qcPeerOurs* ours, const qcPeerWork* work, uint32_t index)
{
    const qcMesh* mesh = &work->bodies[index];
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = work->kind == qc_peerRigid ? mesh->positions : work->positions[index];
    def.vertexCount = mesh->vertexCount;
    def.indices = mesh->indices;
    def.triangleCount = mesh->triangleCount;
    def.deforming = work->kind != qc_peerRigid;
    if (work->kind == qc_peerRigid)
        def.transform = work->transforms[index];
    def.selfCollision = work->kind == qc_peerSelf;
    return qcScene_AddBody(ours->scene, &def, &ours->ids[index]);
}

bool qcPeerOurs_Open(const qcPeerWork* work, qcDevice* device, qcPeerOurs* ours)
{
    *ours = (qcPeerOurs){.ids = calloc(work->bodyCount, sizeof *ours->ids)};
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    bool opened = ours->ids != NULL && qcScene_Create(&def, &ours->scene) == qc_statusOk;
    for (uint32_t i = 0; opened && i < work->bodyCount; ++i)
        opened = AddBody(ours, work, i) == qc_statusOk;
    return opened;
}

bool qcPeerOurs_Step(qcPeerOurs* ours, const qcPeerWork* work, uint32_t frame, const qcDetectDef* def)
{
    qcStatus status = qc_statusOk;
    double start = qcStopwatch_NowMs();
    for (uint32_t i = 0; status == qc_statusOk && i < work->bodyCount; ++i)
    {
        size_t k = (size_t)frame * work->bodyCount + i;
        status = work->kind == qc_peerRigid
                     ? qcScene_SetTransform(ours->scene, ours->ids[i], &work->transforms[k])
                     : qcScene_SetVertices(ours->scene, ours->ids[i], work->positions[k], qc_positionF32, 0);
    }
    ours->moveMs = qcStopwatch_NowMs() - start;
    if (status == qc_statusOk)
        status = qcScene_Detect(ours->scene, def, &ours->result);
    return status == qc_statusOk;
}

void qcPeerOurs_Close(qcPeerOurs* ours)
{
    qcScene_Destroy(ours->scene);
    free(ours->ids);
    *ours = (qcPeerOurs){0};
}
