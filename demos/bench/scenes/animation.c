// Frames of an animation: from the motion of its bodies, piled up where there are several.
#include "bench/scenes/animation.h"

#include "bench/scenes/motion.h"
#include "bench/scenes/piles.h"

#include <stdlib.h>

static bool MakeDeforming(qcAnimation* animation, const qcTransform* places)
{
    for (uint32_t i = 0; i < animation->bodyCount; ++i)
    {
        if (animation->kind != qc_animatedSelf)
            qcBenchPile_Put(&animation->bodies[i], &places[i], animation->bodies[i].positions);
    }
    qcBenchMotion motion = qcBenchMotion_Make(animation->bodies, animation->bodyCount, animation->frameCount);
    animation->positions = calloc((size_t)animation->frameCount * animation->bodyCount, sizeof *animation->positions);
    for (uint32_t k = 0; animation->positions != NULL && k < animation->frameCount * animation->bodyCount; ++k)
    {
        const qcMesh* body = &animation->bodies[k % animation->bodyCount];
        animation->positions[k] = malloc((size_t)body->vertexCount * 3 * sizeof(float));
        if (animation->positions[k] == NULL)
            return false;
        qcBenchMotion_Deform(&motion, body, k / animation->bodyCount, animation->positions[k]);
    }
    return animation->positions != NULL;
}

static bool MakeRigid(qcAnimation* animation, const qcTransform* places)
{
    // The bodies coincide in local space: motion is relative to the extent of one of them.
    qcBenchMotion motion = qcBenchMotion_Make(animation->bodies, animation->bodyCount, animation->frameCount);
    animation->transforms = calloc((size_t)animation->frameCount * animation->bodyCount, sizeof *animation->transforms);
    for (uint32_t k = 0; animation->transforms != NULL && k < animation->frameCount * animation->bodyCount; ++k)
    {
        uint32_t body = k % animation->bodyCount;
        animation->transforms[k] = qcBenchMotion_Carry(&motion, &places[body], body, k / animation->bodyCount);
    }
    return animation->transforms != NULL;
}

bool qcAnimation_MakeFrames(qcAnimation* animation)
{
    qcTransform* places = calloc(animation->bodyCount, sizeof *places);
    if (places == NULL)
        return false;
    qcBenchPile_Place(animation->bodyCount, places);
    bool made = animation->kind == qc_animatedRigid ? MakeRigid(animation, places) : MakeDeforming(animation, places);
    free(places);
    return made;
}

void qcAnimation_Free(qcAnimation* animation)
{
    for (uint32_t i = 0; animation->bodies != NULL && i < animation->bodyCount; ++i)
        qcMesh_Free(&animation->bodies[i]);
    for (uint32_t k = 0; animation->positions != NULL && k < animation->frameCount * animation->bodyCount; ++k)
        free(animation->positions[k]);
    free(animation->bodies);
    free(animation->positions);
    free(animation->transforms);
    free(animation->definitions);
    *animation = (qcAnimation){0};
}
