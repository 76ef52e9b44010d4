// One state of any Bullet world: its energy, contacts and penetrating pairs. It reads only what the world itself
// holds, so that every demo's world can be measured.
#ifndef QC_DEMOS_BENCH_STABILITY_WORLD_MEASURE_H
#define QC_DEMOS_BENCH_STABILITY_WORLD_MEASURE_H

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>

#include <cstddef>

struct qcWorldMeasure
{
    /// Kinetic energy and that of gravity above y = 0, of all bodies that move; J. What bodies store by being stretched
    /// or bent is left out: Bullet's links are constraints and have no energy, and forces of the deformable world are
    /// its own.
    double energy = 0;
    double kinetic = 0; ///< part of the energy
    double mass = 0;    ///< of all bodies that move, kg
    int bodies = 0;     ///< that move
    int contacts = 0;   ///< points in Bullet's manifolds
    /// Depth of the deepest of these points, m: of shells (margins) and, for soft bodies, of their thickness, before
    /// the step's response.
    double depth = 0;
};

/// O(bodies + nodes + points).
qcWorldMeasure qcMeasureWorld(const btDiscreteDynamicsWorld& world);

/// Pairs of triangles of a state that penetrate, without common vertices, by the exact test.
struct qcPenetratingPairs
{
    size_t all = 0;  ///< of soft bodies, ropes and qcMeshShapes, with themselves (soft only) and each other
    size_t soft = 0; ///< those with a triangle or link of a soft body
};

/// Counts them by a scene of its own, independently of the world's contact. `selfCollision`: of soft bodies with
/// themselves too. False: the reason is in qcLastMessage.
bool qcCountPenetrating(const btDiscreteDynamicsWorld& world, bool selfCollision, qcPenetratingPairs* pairs);

/// Keeps all bodies awake from now on: what only sleep would stop goes on moving, and shows.
void qcKeepAwake(btDiscreteDynamicsWorld* world);

#endif
