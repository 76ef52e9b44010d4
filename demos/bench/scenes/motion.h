// Motion for the benchmarks: smooth, deterministic to the bit, and closed: its last frame leads to its first.
#ifndef QC_DEMOS_BENCH_SCENES_MOTION_H
#define QC_DEMOS_BENCH_SCENES_MOTION_H

#include "common/mesh_io/mesh_file.h"

#include <quickcullide/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

/// Frames of a motion of a scene.
typedef struct qcBenchMotion
{
    double diagonal;     ///< of the box around the scene
    uint32_t frameCount; ///< 3 or more
} qcBenchMotion;

/// The motion of these bodies, together.
qcBenchMotion qcBenchMotion_Make(const qcMesh* bodies, uint32_t bodyCount, uint32_t frameCount);

/// Positions of a body of floats in a frame. Each vertex moves along a closed curve, by 0.3 % of the diagonal a frame;
/// motions of adjacent vertices are similar.
void qcBenchMotion_Deform(const qcBenchMotion* motion, const qcMesh* body, uint32_t frame, float* positions);

/// The transform of a rigid body in a frame: it sways about its place and turns a little to and fro, each body in its
/// own way, by about 0.3 % of the diagonal a frame.
qcTransform qcBenchMotion_Carry(const qcBenchMotion* motion, const qcTransform* place, uint32_t body, uint32_t frame);

#ifdef __cplusplus
}
#endif

#endif
