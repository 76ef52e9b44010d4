// Rays and sweeps in batches, on threads.
#include "quickcullide/bullet_queries.h"

#include "common/finite.h"
#include "common/parallel_loop.h"
#include "quickcullide/bullet_broadphase.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>

#include <algorithm>
#include <new>
#include <vector>

namespace
{
/// Queries that a thread takes at once: a ray costs half a microsecond, to take one from the loop a tenth.
constexpr size_t s_blockSize = 16;

bool IsFinite(const qcRay& ray)
{
    return qcIsFinite(ray.from) && qcIsFinite(ray.to);
}

bool IsFinite(const qcSweep& sweep)
{
    return qcIsFinite(sweep.from) && qcIsFinite(sweep.to);
}

/// With a fourth coordinate of 0, which Bullet leaves unset and operator== compares.
btVector3 Clean(const btVector3& v)
{
    return btVector3(v.x(), v.y(), v.z());
}

template <typename Result> void SetShapeInfo(const Result& result, qcCastHit* hit)
{
    hit->part = result.m_localShapeInfo != nullptr ? result.m_localShapeInfo->m_shapePart : -1;
    hit->triangle = result.m_localShapeInfo != nullptr ? result.m_localShapeInfo->m_triangleIndex : -1;
}

struct ClosestRay : btCollisionWorld::ClosestRayResultCallback
{
    ClosestRay(const qcRay& ray, qcCastHit* hit)
        : btCollisionWorld::ClosestRayResultCallback(ray.from, ray.to), m_hit(hit)
    {
    }

    btScalar addSingleResult(btCollisionWorld::LocalRayResult& result, bool normalInWorldSpace) override
    {
        SetShapeInfo(result, m_hit);
        return btCollisionWorld::ClosestRayResultCallback::addSingleResult(result, normalInWorldSpace);
    }

    qcCastHit* m_hit;
};

struct ClosestSweep : btCollisionWorld::ClosestConvexResultCallback
{
    ClosestSweep(const qcSweep& sweep, qcCastHit* hit)
        : btCollisionWorld::ClosestConvexResultCallback(sweep.from.getOrigin(), sweep.to.getOrigin()), m_hit(hit)
    {
    }

    btScalar addSingleResult(btCollisionWorld::LocalConvexResult& result, bool normalInWorldSpace) override
    {
        SetShapeInfo(result, m_hit);
        return btCollisionWorld::ClosestConvexResultCallback::addSingleResult(result, normalInWorldSpace);
    }

    qcCastHit* m_hit;
};

/// Copies what rays and sweeps call by the same names.
template <typename Closest> void CopyClosest(const Closest& closest, qcCastHit* hit)
{
    hit->fraction = closest.m_closestHitFraction;
    if (!closest.hasHit())
        return;
    hit->normal = Clean(closest.m_hitNormalWorld);
    hit->point = Clean(closest.m_hitPointWorld);
}

qcCastHit CastOne(const btCollisionWorld& world, const qcRay& ray, const qcCastDef& def)
{
    qcCastHit hit;
    ClosestRay closest(ray, &hit);
    closest.m_collisionFilterGroup = def.group;
    closest.m_collisionFilterMask = def.mask;
    closest.m_flags = def.rayFlags;
    world.rayTest(ray.from, ray.to, closest);
    hit.object = closest.m_collisionObject;
    CopyClosest(closest, &hit);
    return hit;
}

qcCastHit CastOne(const btCollisionWorld& world, const btConvexShape& shape, const qcSweep& sweep, const qcCastDef& def)
{
    qcCastHit hit;
    ClosestSweep closest(sweep, &hit);
    closest.m_collisionFilterGroup = def.group;
    closest.m_collisionFilterMask = def.mask;
    world.convexSweepTest(&shape, sweep.from, sweep.to, closest, def.allowedPenetration);
    hit.object = closest.m_hitCollisionObject;
    CopyClosest(closest, &hit);
    return hit;
}

/// Calls cast(i) for each index below `count`; its result becomes hits[i] once all have returned.
template <typename Cast>
qcStatus ForEach(const btCollisionWorld& world, const qcCastDef& def, size_t count, qcCastHit* hits, const Cast& cast)
{
    std::vector<qcCastHit> found(count);
    const bool threaded = dynamic_cast<const qcBroadphase*>(world.getBroadphase()) != nullptr;
    qcForEach(threaded ? qcWorkersOf(def.threads) : 1, count, s_blockSize,
              [&](size_t i, uint32_t) { found[i] = cast(i); });
    std::copy(found.begin(), found.end(), hits);
    return qc_statusOk;
}

template <typename Query>
bool IsValid(const btCollisionWorld* world, const Query* queries, size_t count, const qcCastHit* hits)
{
    return world != nullptr && queries != nullptr && hits != nullptr &&
           std::all_of(queries, queries + count, [](const Query& query) { return IsFinite(query); });
}
} // namespace

qcStatus qcCastRays(const btCollisionWorld* world, const qcRay* rays, size_t count, qcCastHit* hits,
                    const qcCastDef& def)
try
{
    if (count == 0)
        return qc_statusOk;
    if (!IsValid(world, rays, count, hits))
        return qc_statusBadInput;
    return ForEach(*world, def, count, hits, [&](size_t i) { return CastOne(*world, rays[i], def); });
}
catch (const std::bad_alloc&)
{
    return qc_statusOutOfMemory;
}

qcStatus qcCastShape(const btCollisionWorld* world, const btConvexShape* shape, const qcSweep* sweeps, size_t count,
                     qcCastHit* hits, const qcCastDef& def)
try
{
    if (count == 0)
        return qc_statusOk;
    if (shape == nullptr || !IsValid(world, sweeps, count, hits))
        return qc_statusBadInput;
    return ForEach(*world, def, count, hits, [&](size_t i) { return CastOne(*world, *shape, sweeps[i], def); });
}
catch (const std::bad_alloc&)
{
    return qc_statusOutOfMemory;
}
