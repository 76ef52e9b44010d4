// A qcBroadphase gets the recorded calls again.
#include "replay/box_replay.h"

#include <quickcullide/bullet_broadphase.h>

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>

#include <algorithm>
#include <unordered_map>

namespace
{
btVector3 VectorOf(const double* numbers)
{
    return btVector3(btScalar(numbers[0]), btScalar(numbers[1]), btScalar(numbers[2]));
}

uint32_t IdOf(const btBroadphaseProxy* proxy)
{
    return uint32_t(reinterpret_cast<uintptr_t>(proxy->m_clientObject));
}

qcBoxPair PairOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b)
{
    return {std::min(IdOf(a), IdOf(b)), std::max(IdOf(a), IdOf(b))};
}

bool IsLess(const qcBoxPair& x, const qcBoxPair& y)
{
    return x.a != y.a ? x.a < y.a : x.b < y.b;
}

/// Rejects the pairs that the recorded callback rejected.
struct RecordedFilter : btOverlapFilterCallback
{
    const qcBoxPair* rejected = nullptr;
    size_t count = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        return !std::binary_search(rejected, rejected + count, PairOf(a, b), IsLess);
    }
};

struct QueryCallback : btBroadphaseAabbCallback
{
    std::vector<uint32_t> ids;

    bool process(const btBroadphaseProxy* proxy) override
    {
        ids.push_back(IdOf(proxy));
        return true;
    }
};

/// Shortens the cast after each box as the recorded callback did.
struct CastCallback : btBroadphaseRayCallback
{
    const qcBoxOperation* cast;
    std::vector<uint32_t> ids;

    bool process(const btBroadphaseProxy* proxy) override
    {
        if (ids.size() < cast->count)
            m_lambda_max = btScalar(cast->lambdas[ids.size()]);
        ids.push_back(IdOf(proxy));
        return true;
    }
};

class BroadphaseReplay : public qcBoxReplay
{
  public:
    ~BroadphaseReplay() override
    {
        for (auto& [id, proxy] : m_proxies)
            m_broadphase.destroyProxy(proxy, &m_dispatcher);
    }

    void Add(uint32_t id, const double* bounds, uint32_t group, uint32_t mask) override
    {
        m_proxies[id] =
            m_broadphase.createProxy(VectorOf(bounds), VectorOf(bounds + 3), 0, reinterpret_cast<void*>(uintptr_t(id)),
                                     int(group), int(mask), &m_dispatcher);
    }
    void Remove(uint32_t id) override
    {
        m_broadphase.destroyProxy(m_proxies[id], &m_dispatcher);
        m_proxies.erase(id);
    }
    void Move(uint32_t id, const double* bounds) override
    {
        m_broadphase.setAabb(m_proxies[id], VectorOf(bounds), VectorOf(bounds + 3), &m_dispatcher);
    }
    void SetFilter(uint32_t id, uint32_t group, uint32_t mask) override
    {
        m_proxies[id]->m_collisionFilterGroup = int(group);
        m_proxies[id]->m_collisionFilterMask = int(mask);
        // Set again, so that the filter is read in this step.
        m_broadphase.setAabb(m_proxies[id], m_proxies[id]->m_aabbMin, m_proxies[id]->m_aabbMax, &m_dispatcher);
    }
    void Reset() override
    {
        m_broadphase.resetPool(&m_dispatcher);
    }

    std::vector<qcBoxPair> FindPairs(const qcBoxOperation& search) override
    {
        btOverlappingPairCache* cache = m_broadphase.getOverlappingPairCache();
        m_filter.rejected = search.rejected;
        m_filter.count = search.rejectedCount;
        cache->setOverlapFilterCallback(search.hasCallback ? &m_filter : nullptr);
        m_broadphase.calculateOverlappingPairs(&m_dispatcher);
        // The list of rejected pairs is the operation's.
        m_filter.count = 0;
        std::vector<qcBoxPair> pairs;
        const btBroadphasePair* cached = cache->getOverlappingPairArrayPtr();
        for (int i = 0; i < cache->getNumOverlappingPairs(); i++)
            pairs.push_back(PairOf(cached[i].m_pProxy0, cached[i].m_pProxy1));
        std::sort(pairs.begin(), pairs.end(), IsLess);
        return pairs;
    }

    std::vector<uint32_t> Query(const double* bounds) override
    {
        QueryCallback callback;
        m_broadphase.aabbTest(VectorOf(bounds), VectorOf(bounds + 3), callback);
        std::sort(callback.ids.begin(), callback.ids.end());
        return callback.ids;
    }

    std::vector<uint32_t> Cast(const qcBoxOperation& operation) override
    {
        const qcBoxCast& cast = operation.cast;
        CastCallback callback;
        callback.cast = &operation;
        callback.m_rayDirectionInverse = VectorOf(cast.directionInverse);
        callback.m_lambda_max = btScalar(cast.lambda);
        for (int k = 0; k < 3; k++)
            callback.m_signs[k] = callback.m_rayDirectionInverse[k] < 0;
        m_broadphase.rayTest(VectorOf(cast.from), VectorOf(cast.to), callback, VectorOf(cast.bounds),
                             VectorOf(cast.bounds + 3));
        return callback.ids;
    }

  private:
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    RecordedFilter m_filter;
    qcBroadphase m_broadphase;
    std::unordered_map<uint32_t, btBroadphaseProxy*> m_proxies;
};
} // namespace

std::unique_ptr<qcBoxReplay> qcMakeBroadphaseReplay(uint32_t scalarSize)
{
    return scalarSize == sizeof(btScalar) ? std::make_unique<BroadphaseReplay>() : nullptr;
}
