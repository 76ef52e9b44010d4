// Rays and sweeps in batches, on threads.
#include "quickcullide/bullet_queries.h"

#include "common/compound_children.h"
#include "common/finite.h"
#include "common/parallel_loop.h"
#include "quickcullide/bullet_broadphase.h"

#include <BulletCollision/CollisionShapes/btConvexShape.h>
#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <initializer_list>
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

/// True if Bullet's ray tests and sweeps only read the object. btGImpactMeshShape counts its readers, not atomically,
/// and a soft body's first ray builds its tree of faces.
bool IsOnlyRead(const btCollisionObject* object)
{
    if (const btSoftBody* soft = btSoftBody::upcast(object))
        return soft->m_faces.size() == 0 || !soft->m_fdbvt.empty();
    bool read = true;
    qcForEachSimpleShape(object->getCollisionShape(), btTransform::getIdentity(),
                         [&read](const btCollisionShape* shape, const btTransform&)
                         { read = read && shape->getShapeType() != GIMPACT_SHAPE_PROXYTYPE; });
    return read;
}

/// Threads that may cast at once. O(objects) for more than one.
unsigned ThreadsFor(const btCollisionWorld& world, const qcCastDef& def, size_t count)
{
    const unsigned threads = count > s_blockSize ? qcWorkersOf(def.threads) : 1;
    if (threads == 1 || dynamic_cast<const qcBroadphase*>(world.getBroadphase()) == nullptr)
        return 1;
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    bool areRead = true;
    for (int i = 0; i < objects.size() && areRead; i++)
        areRead = IsOnlyRead(objects[i]);
    return areRead ? threads : 1;
}

/// Calls cast(i) for each index below `count`; its result becomes hits[i] once all have returned.
template <typename Cast>
qcStatus ForEach(const btCollisionWorld& world, const qcCastDef& def, size_t count, qcCastHit* hits, const Cast& cast)
{
    std::vector<qcCastHit> found(count);
    qcForEach(ThreadsFor(world, def, count), count, s_blockSize, [&](size_t i, uint32_t) { found[i] = cast(i); });
    std::copy(found.begin(), found.end(), hits);
    return qc_statusOk;
}

/// An argument and its name.
struct Pointer
{
    const char* name;
    const void* value;
};

/// Fails, with a message, if a pointer is null or a query not finite.
template <typename Query>
qcStatus Check(const char* function, std::initializer_list<Pointer> pointers, const Query* queries, size_t count)
{
    for (const Pointer& pointer : pointers)
        if (pointer.value == nullptr)
            return qcFail(qc_statusBadInput, "%s: %s is null", function, pointer.name);
    for (size_t i = 0; i < count; i++)
        if (!IsFinite(queries[i]))
            return qcFail(qc_statusBadInput, "%s: a coordinate of query %zu is not finite", function, i);
    return qc_statusOk;
}
} // namespace

qcStatus qcCastRays(const btCollisionWorld* world, const qcRay* rays, size_t count, qcCastHit* hits,
                    const qcCastDef& def)
try
{
    if (count == 0)
        return qc_statusOk;
    qcStatus status = Check("qcCastRays", {{"world", world}, {"rays", rays}, {"hits", hits}}, rays, count);
    if (status != qc_statusOk)
        return status;
    return ForEach(*world, def, count, hits, [&](size_t i) { return CastOne(*world, rays[i], def); });
}
catch (const std::bad_alloc&)
{
    return qcFail(qc_statusOutOfMemory, "qcCastRays: out of memory");
}

qcStatus qcCastShape(const btCollisionWorld* world, const btConvexShape* shape, const qcSweep* sweeps, size_t count,
                     qcCastHit* hits, const qcCastDef& def)
try
{
    if (count == 0)
        return qc_statusOk;
    qcStatus status =
        Check("qcCastShape", {{"world", world}, {"shape", shape}, {"sweeps", sweeps}, {"hits", hits}}, sweeps, count);
    if (status != qc_statusOk)
        return status;
    return ForEach(*world, def, count, hits, [&](size_t i) { return CastOne(*world, *shape, sweeps[i], def); });
}
catch (const std::bad_alloc&)
{
    return qcFail(qc_statusOutOfMemory, "qcCastShape: out of memory");
}
