/// @file
/// Many rays or sweeps at once, on threads:
///
///     std::vector<qcRay> rays = ...;
///     std::vector<qcCastHit> hits(rays.size());
///     qcStatus status = qcCastRays(world, rays.data(), rays.size(), hits.data());
#ifndef QUICKCULLIDE_BULLET_QUERIES_H
#define QUICKCULLIDE_BULLET_QUERIES_H

#include "base.h"

#include <BulletCollision/CollisionDispatch/btCollisionWorld.h>

#include <cstddef>
#include <cstdint>

/// A ray between two points of the world.
struct qcRay
{
    btVector3 from{0, 0, 0}; ///< in the world's units of length
    btVector3 to{0, 0, 0};   ///< in the world's units of length
};

/// The way of a convex shape in the world: it moves along a line and turns at a constant rate.
struct qcSweep
{
    btTransform from = btTransform::getIdentity(); ///< of the shape at the beginning
    btTransform to = btTransform::getIdentity();   ///< of the shape at the end
};

/// The closest hit of a ray or sweep.
struct qcCastHit
{
    const btCollisionObject* object = nullptr; ///< null: nothing is hit
    btScalar fraction = 1;                     ///< of the way, 0 to 1; 1 without a hit
    btVector3 normal{0, 0, 0};                 ///< length 1, of the surface that is hit, in world space
    btVector3 point{0, 0, 0};                  ///< of contact, in world space
    int part = -1;                             ///< of a mesh, in Bullet's numbering; -1: none
    int triangle = -1;                         ///< of a mesh, or the child of a compound, as Bullet has it; -1: none
};

/// Which objects are hit, and how a batch runs.
struct qcCastDef
{
    /// Filter group and mask of the rays and sweeps, as in Bullet's result callbacks.
    int group = btBroadphaseProxy::DefaultFilter;
    int mask = btBroadphaseProxy::AllFilter; ///< see `group`
    /// Flags of rays, of btTriangleRaycastCallback::EFlags. 0: none.
    unsigned rayFlags = 0;
    /// Allowed penetration of sweeps, as in btCollisionWorld::convexSweepTest, in units of length. 0: none.
    btScalar allowedPenetration = 0;
    /// Threads at most, on those of the library's loops (see qcSetParallelFor, qcSetTaskScheduler). 0: all of them.
    /// Batches of a few queries stay on the calling thread.
    unsigned threads = 0;
};

/// Casts `count` rays by the world's rayTest. hits[i] receives the closest hit of rays[i], the one that
/// rayTest finds, whatever the number of threads. O(count) memory.
///
/// qc_statusBadInput: a pointer is null although count > 0, or a coordinate is not finite.
/// qc_statusOutOfMemory: an allocation failed. In both cases no hit is written.
///
/// Thread-safety: call it where rayTest may be called: between steps, on one thread or on several at once; nothing may
/// change the world meanwhile. Several threads are used if the world's broadphase is a qcBroadphase; set
/// qcCastDef::threads to 1 while that is recorded. With Bullet's own broadphases, whose ray tests share a stack, all
/// queries stay on the calling thread; so they do while the world has a btGImpactMeshShape, or a soft body at whose
/// faces no ray has been cast yet: Bullet's tests of these are not for several threads. Shapes of your own, and a
/// profiler of your own (btSetCustomEnterProfileZoneFunc), are called on these threads; they must not throw.
QC_API qcStatus qcCastRays(const btCollisionWorld* world, const qcRay* rays, size_t count, qcCastHit* hits,
                           const qcCastDef& def = qcCastDef());

/// Sweeps a convex shape along `count` ways by the world's convexSweepTest. Everything else is as for qcCastRays;
/// qc_statusBadInput, too, if the shape is null.
QC_API qcStatus qcCastShape(const btCollisionWorld* world, const btConvexShape* shape, const qcSweep* sweeps,
                            size_t count, qcCastHit* hits, const qcCastDef& def = qcCastDef());

#endif
