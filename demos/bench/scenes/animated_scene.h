// A scene of the library that goes through the frames of an animation.
#ifndef QC_DEMOS_BENCH_SCENES_ANIMATED_SCENE_H
#define QC_DEMOS_BENCH_SCENES_ANIMATED_SCENE_H

#include "bench/scenes/animation.h"

#include <quickcullide/quickcullide.h>

#ifdef __cplusplus
extern "C" {
#endif

/// A scene of the library whose bodies follow an animation.
typedef struct qcAnimatedScene
{
    qcScene* scene;
    qcBodyId* ids;
    const qcResult* result; ///< of the last step
    double moveMs;          ///< of the last step: positions or transforms in
} qcAnimatedScene;

/// False: the reason is in qcLastMessage. Close it in any case.
bool qcAnimatedScene_Open(const qcAnimation* animation, qcDevice* device, qcAnimatedScene* ours);
/// A frame's positions or transforms in, pairs out.
bool qcAnimatedScene_Step(qcAnimatedScene* ours, const qcAnimation* animation, uint32_t frame, const qcDetectDef* def);
void qcAnimatedScene_Close(qcAnimatedScene* ours);

#ifdef __cplusplus
}
#endif

#endif
