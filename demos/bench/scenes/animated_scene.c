// Each frame: new vertices or transforms, then a detection.
#include "bench/scenes/animated_scene.h"

#include "common/stopwatch.h"

#include <stdlib.h>

static qcStatus AddBody(qcAnimatedScene* ours, const qcAnimation* animation, uint32_t index)
{
    const qcMesh* mesh = &animation->bodies[index];
    const bool rigid = qcAnimation_IsRigid(animation, index), mixed = animation->kind == qc_animatedMixed;
    qcBodyDef def = mixed ? animation->definitions[index] : qcDefaultBodyDef();
    def.positions = rigid ? mesh->positions : animation->positions[index];
    def.vertexCount = mesh->vertexCount;
    def.indices = mesh->indices;
    def.triangleCount = mesh->triangleCount;
    def.deforming = !rigid;
    if (rigid)
        def.transform = animation->transforms[index];
    if (!mixed)
        def.selfCollision = animation->kind == qc_animatedSelf;
    return qcScene_AddBody(ours->scene, &def, &ours->ids[index]);
}

bool qcAnimatedScene_Open(const qcAnimation* animation, qcDevice* device, qcAnimatedScene* ours)
{
    *ours = (qcAnimatedScene){.ids = calloc(animation->bodyCount, sizeof *ours->ids)};
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    bool opened = ours->ids != NULL && qcScene_Create(&def, &ours->scene) == qc_statusOk;
    for (uint32_t i = 0; opened && i < animation->bodyCount; ++i)
        opened = AddBody(ours, animation, i) == qc_statusOk;
    return opened;
}

bool qcAnimatedScene_Step(qcAnimatedScene* ours, const qcAnimation* animation, uint32_t frame, const qcDetectDef* def)
{
    qcStatus status = qc_statusOk;
    double start = qcStopwatch_NowMs();
    for (uint32_t i = 0; status == qc_statusOk && i < animation->bodyCount; ++i)
    {
        size_t k = (size_t)frame * animation->bodyCount + i;
        status = qcAnimation_IsRigid(animation, i)
                     ? qcScene_SetTransform(ours->scene, ours->ids[i], &animation->transforms[k])
                     : qcScene_SetVertices(ours->scene, ours->ids[i], animation->positions[k], qc_positionF32, 0);
    }
    ours->moveMs = qcStopwatch_NowMs() - start;
    if (status == qc_statusOk)
        status = qcScene_Detect(ours->scene, def, &ours->result);
    return status == qc_statusOk;
}

void qcAnimatedScene_Close(qcAnimatedScene* ours)
{
    qcScene_Destroy(ours->scene);
    free(ours->ids);
    *ours = (qcAnimatedScene){0};
}
