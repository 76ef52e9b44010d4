// The broadphase of a Bullet world: proxies (proxy_set.h), the pair cache (pair_cache_sync.h), and queries.
#include "quickcullide/bullet_broadphase.h"

#include "broadphase/broadphase_recorder.h"
#include "broadphase/pair_cache_sync.h"
#include "common/finite.h"

#include <LinearMath/btIDebugDraw.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

struct qcBroadphase::Data : qcPairCacheSync
{
    using qcPairCacheSync::qcPairCacheSync;

    qcBroadphaseRecorder recorder;
};

namespace
{
/// Squared distance of the ends of two paths, relative to the squared length: nearer ends are swept as they are.
constexpr double s_sharePath = 1e-10;

/// The path of a box cast: its ends, and the extents of the box.
struct Path
{
    double from[3], to[3], castLower[3], castUpper[3];
};

/// A cast that runs.
struct Cast
{
    btBroadphaseRayCallback* callback;
    btScalar lambda;                          ///< the callback's at the start
    double fraction;                          ///< of the path that is searched
    qcBroadphaseRecorder::Reported* reported; ///< null: the cast is not recorded

    void Process(qcProxy* proxy)
    {
        if (proxy->state().destroyed)
            return;
        uint32_t id = uint32_t(proxy->m_uniqueId);
        callback->process(proxy);
        if (reported != nullptr)
            reported->Add(id, double(callback->m_lambda_max));
    }
};

/// Bullet's tree goes along the callback's direction to its largest lambda and ignores rayTo; other broadphases do the
/// reverse. The longer of the two paths, swept by the largest difference between them, contains both.
Path MakePath(const btVector3& rayFrom, const btVector3& rayTo, const btBroadphaseRayCallback& callback,
              const btVector3& aabbMin, const btVector3& aabbMax)
{
    Path path;
    double far[3], near[3], farLength = 0, nearLength = 0;
    for (int k = 0; k < 3; k++)
    {
        path.from[k] = double(rayFrom[k]);
        path.to[k] = double(rayTo[k]);
        path.castLower[k] = double(aabbMin[k]);
        path.castUpper[k] = double(aabbMax[k]);
        double inverse = double(callback.m_rayDirectionInverse[k]);
        double direction = std::fabs(inverse) >= double(BT_LARGE_FLOAT) ? 0.0 : 1.0 / inverse;
        near[k] = path.to[k] - path.from[k];
        far[k] = direction * double(callback.m_lambda_max);
        nearLength += near[k] * near[k];
        farLength += far[k] * far[k];
    }
    if (!std::isfinite(farLength) || !std::isfinite(nearLength))
        return path;
    if (nearLength > farLength)
    {
        std::swap(near, far);
        std::swap(nearLength, farLength);
    }
    double along = 0, apart = 0, share = 1;
    for (int k = 0; k < 3; k++)
    {
        along += near[k] * far[k];
        apart += (near[k] - far[k]) * (near[k] - far[k]);
    }
    // Mostly both paths are the same but for rounding, and no quotient is needed.
    if (apart > s_sharePath * farLength)
        share = std::min(std::max(along / farLength, 0.0), 1.0);
    for (int k = 0; k < 3; k++)
    {
        // The second term bounds the rounding of the first term and of the new end.
        double difference = std::fabs(near[k] - share * far[k]) +
                            1e-15 * (std::fabs(path.from[k]) + std::fabs(near[k]) + std::fabs(far[k]));
        path.to[k] = path.from[k] + far[k];
        path.castLower[k] -= difference;
        path.castUpper[k] += difference;
    }
    return path;
}
} // namespace

qcBroadphase::qcBroadphase(btOverlappingPairCache* pairCache) : m_data(new Data(pairCache))
{
}

qcBroadphase::~qcBroadphase()
{
    delete m_data;
}

//  ---- proxies ---------------------------------------------------------------------------------------

btBroadphaseProxy* qcBroadphase::createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int /*shapeType*/,
                                             void* userPtr, int collisionFilterGroup, int collisionFilterMask,
                                             btDispatcher* /*dispatcher*/)
{
    qcProxy* proxy = m_data->GetProxies().Create(aabbMin, aabbMax, userPtr, collisionFilterGroup, collisionFilterMask);
    if (proxy == nullptr)
        return nullptr;
    if (m_data->recorder.IsOn())
        m_data->recorder.Add(proxy);
    m_data->Add(proxy);
    return proxy;
}

void qcBroadphase::destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher)
{
    qcProxy* own = static_cast<qcProxy*>(proxy);
    if (own == nullptr)
        return;
    if (m_data->recorder.IsOn() && !own->state().destroyed)
        m_data->recorder.Remove(own);
    m_data->Destroy(own, dispatcher);
}

void qcBroadphase::setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                           btDispatcher* /*dispatcher*/)
{
    qcProxy* own = static_cast<qcProxy*>(proxy);
    if (own == nullptr)
        return;
    if (m_data->recorder.IsOn())
        m_data->recorder.Move(own, aabbMin, aabbMax, m_data->IsIterating());
    m_data->Move(own, aabbMin, aabbMax);
}

void qcBroadphase::getAabb(btBroadphaseProxy* proxy, btVector3& aabbMin, btVector3& aabbMax) const
{
    aabbMin = proxy->m_aabbMin;
    aabbMax = proxy->m_aabbMax;
}

//  ---- queries ---------------------------------------------------------------------------------------

void qcBroadphase::aabbTest(const btVector3& aabbMin, const btVector3& aabbMax, btBroadphaseAabbCallback& callback)
{
    qcPairCacheSync::IterationGuard guard(*m_data);
    if (!m_data->recorder.IsOn())
    {
        m_data->GetProxies().VisitBox(aabbMin, aabbMax, [&](qcProxy* proxy) { callback.process(proxy); });
        return;
    }
    qcBroadphaseRecorder::Reported reported;
    m_data->recorder.BeginQuery();
    m_data->GetProxies().VisitBox(aabbMin, aabbMax,
                                  [&](qcProxy* proxy)
                                  {
                                      reported.Add(uint32_t(proxy->m_uniqueId));
                                      callback.process(proxy);
                                  });
    m_data->recorder.EndQuery(aabbMin, aabbMax, reported);
}

void qcBroadphase::rayTest(const btVector3& rayFrom, const btVector3& rayTo, btBroadphaseRayCallback& rayCallback,
                           const btVector3& aabbMin, const btVector3& aabbMax)
{
    qcPairCacheSync::IterationGuard guard(*m_data);
    qcBroadphaseRecorder* recorder = m_data->recorder.IsOn() ? &m_data->recorder : nullptr;
    qcBroadphaseRecorder::Reported reported;
    Cast cast = {&rayCallback, rayCallback.m_lambda_max, 1.0, recorder != nullptr ? &reported : nullptr};
    auto function = [](uint32_t, void* userData, void* context)
    {
        Cast* caller = static_cast<Cast*>(context);
        caller->Process(static_cast<qcProxy*>(userData));
        if (caller->callback->m_lambda_max < caller->lambda)
            caller->fraction = double(caller->callback->m_lambda_max) / double(caller->lambda);
        return true;
    };
    qcBoxCast recorded;
    if (recorder != nullptr)
    {
        recorded = qcBoxCastOf(rayFrom, rayTo, rayCallback, aabbMin, aabbMax);
        recorder->BeginQuery();
    }
    Path path = MakePath(rayFrom, rayTo, rayCallback, aabbMin, aabbMax);
    qcBoxes_CastBox(m_data->GetProxies().GetBoxes(), path.from, path.to, path.castLower, path.castUpper, &cast.fraction,
                    function, &cast);
    m_data->GetProxies().VisitOutside([&](qcProxy* proxy) { cast.Process(proxy); });
    if (recorder != nullptr)
        recorder->EndCast(recorded, reported);
}

//  ---- pairs -----------------------------------------------------------------------------------------

void qcBroadphase::calculateOverlappingPairs(btDispatcher* dispatcher)
{
    if (m_data->IsIterating())
        return;
    if (!m_data->recorder.IsOn())
    {
        m_data->Update(dispatcher);
        return;
    }
    m_data->recorder.BeginPairs();
    // New pairs are made by the filters as they are: a filter that is compared later could not be replayed.
    m_data->GetProxies().CompareAllFilters();
    m_data->Update(dispatcher);
    m_data->recorder.EndPairs(*m_data);
}

btOverlappingPairCache* qcBroadphase::getOverlappingPairCache()
{
    return m_data->GetCache();
}

const btOverlappingPairCache* qcBroadphase::getOverlappingPairCache() const
{
    return m_data->GetCache();
}

//  ---- the whole -------------------------------------------------------------------------------------

void qcBroadphase::getBroadphaseAabb(btVector3& aabbMin, btVector3& aabbMax) const
{
    double lower[3], upper[3];
    m_data->GetProxies().GetBounds(lower, upper);
    aabbMin.setValue(btScalar(lower[0]), btScalar(lower[1]), btScalar(lower[2]));
    aabbMax.setValue(btScalar(upper[0]), btScalar(upper[1]), btScalar(upper[2]));
}

void qcBroadphase::resetPool(btDispatcher* /*dispatcher*/)
{
    if (m_data->GetProxies().GetCount() > 0 || m_data->IsIterating())
        return;
    if (m_data->recorder.IsOn())
        m_data->recorder.Reset();
    m_data->GetProxies().Reset();
    m_data->ResetEarlyQueries();
}

void qcBroadphase::printStats()
{
    std::printf("qcBroadphase: %d proxies, %d of them outside of the set; %d pairs\n", m_data->GetProxies().GetCount(),
                m_data->GetProxies().GetOutsideCount(), m_data->GetCache()->getNumOverlappingPairs());
}

void qcBroadphase::debugDraw(btIDebugDraw* drawer) const
{
    auto middleOf = [](const btBroadphaseProxy* proxy) { return (proxy->m_aabbMin + proxy->m_aabbMax) / 2; };
    btIDebugDraw::DefaultColors colors = drawer->getDefaultColors();
    for (int i = 0; i < m_data->GetProxies().GetCount(); i++)
    {
        const qcProxy* proxy = m_data->GetProxies().At(i);
        if (qcIsFinite(proxy->m_aabbMin) && qcIsFinite(proxy->m_aabbMax))
            drawer->drawAabb(proxy->m_aabbMin, proxy->m_aabbMax, colors.m_aabb);
    }
    const btOverlappingPairCache* cache = m_data->GetCache();
    const btBroadphasePair* pairs = cache->getOverlappingPairArrayPtr();
    for (int i = 0; i < cache->getNumOverlappingPairs(); i++)
    {
        btVector3 from = middleOf(pairs[i].m_pProxy0), to = middleOf(pairs[i].m_pProxy1);
        if (qcIsFinite(from) && qcIsFinite(to))
            drawer->drawLine(from, to, colors.m_contactPoint);
    }
    drawer->flushLines();
}

qcStatus qcBroadphase::record(const char* path)
{
    if (m_data->IsIterating())
        return qcFail(qc_statusBadInput, "qcBroadphase::record: called by a callback of the broadphase");
    return m_data->recorder.Start(path, m_data->GetProxies());
}

qcStatus qcBroadphase::getStatus() const
{
    return m_data->GetProxies().GetStatus();
}
