// Bodies in motion for the benchmarks: triangles, and positions or transforms in each frame.
#ifndef QC_DEMOS_BENCH_SCENES_ANIMATION_H
#define QC_DEMOS_BENCH_SCENES_ANIMATION_H

#include "common/mesh_io/mesh_file.h"

#include <quickcullide/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum qcAnimationKind
{
    qc_animatedSelf,      ///< one deforming body with itself
    qc_animatedDeforming, ///< bodies with each other, all vertices new in each frame
    qc_animatedRigid,     ///< bodies with each other, transforms new in each frame
    qc_animatedMixed      ///< each body by its definition
} qcAnimationKind;

/// Bodies, and where they are in each frame.
typedef struct qcAnimation
{
    int index; ///< of the scene in the list of its benchmark
    qcAnimationKind kind;
    qcMesh* bodies; ///< floats; local space where rigid
    uint32_t bodyCount, triangleCount;
    uint32_t frameCount;
    float** positions;       ///< frameCount * bodyCount arrays; null where rigid
    qcTransform* transforms; ///< frameCount * bodyCount; null where deforming
    qcBodyDef* definitions;  ///< of qc_animatedMixed, bodyCount: all but positions and triangles; otherwise null
} qcAnimation;

/// Whether a body has transforms.
static inline bool qcAnimation_IsRigid(const qcAnimation* animation, uint32_t body)
{
    return animation->kind == qc_animatedMixed ? !animation->definitions[body].deforming
                                               : animation->kind == qc_animatedRigid;
}

/// Makes the frames of an animation whose kind, bodies and frameCount are set; bodies of the kinds other than
/// qc_animatedSelf are piled up first. False: out of memory.
bool qcAnimation_MakeFrames(qcAnimation* animation);
void qcAnimation_Free(qcAnimation* animation);

#ifdef __cplusplus
}
#endif

#endif
