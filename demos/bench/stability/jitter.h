// Random starts: how a scene ends must not hang on the place and the orientation that its bodies happen to have at
// first.
#ifndef QC_DEMOS_BENCH_STABILITY_JITTER_H
#define QC_DEMOS_BENCH_STABILITY_JITTER_H

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <cstdint>

/// Moves each body that moves by at most `shift` metres along each horizontal axis, and turns it by at most `turn`
/// radians: rigid ones around any axis, soft ones around the vertical one. Nodes of soft bodies move by up to a
/// hundredth of `shift` more. Soft bodies that are fixed somewhere stay. An equal number gives an equal start.
void qcJitterStart(btDiscreteDynamicsWorld* world, double shift, double turn, uint32_t start);

#endif
