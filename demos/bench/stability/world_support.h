// What the bodies of a Bullet world lie on: a body that touches nothing hangs in the air, one below the ground has
// passed through it.
#ifndef QC_DEMOS_BENCH_STABILITY_WORLD_SUPPORT_H
#define QC_DEMOS_BENCH_STABILITY_WORLD_SUPPORT_H

#include <BulletDynamics/Dynamics/btDiscreteDynamicsWorld.h>
#include <BulletSoftBody/btSoftBody.h>

#include <cstddef>

struct qcWorldSupport
{
    /// Bodies that move and touch no fixed body, neither themselves nor over other bodies. Rigid bodies touch where
    /// Bullet's manifolds have points; soft ones where a node is less than 5 cm from a plane or the box of a body.
    size_t hanging = 0;
    /// Depth of the deepest vertex of a qcMeshShape, or node, under a static plane, m.
    double below = 0;
};

/// O(vertices * planes + nodes * bodies + points).
qcWorldSupport qcMeasureSupport(const btDiscreteDynamicsWorld& world);

/// Bullet's soft bodies carry the flag of static objects.
bool qcMoves(const btCollisionObject& object);
/// A node is fixed, or anchored to a rigid body.
bool qcIsHeld(const btSoftBody& soft);

#endif
