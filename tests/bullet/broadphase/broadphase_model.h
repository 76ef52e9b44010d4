// A qcBroadphase beside a plain list of its proxies: the pair cache must hold what brute force over the list finds.
#ifndef QC_TESTS_BULLET_BROADPHASE_BROADPHASE_MODEL_H
#define QC_TESTS_BULLET_BROADPHASE_BROADPHASE_MODEL_H

#include <quickcullide/bullet_broadphase.h>

#include "support/soups.h"
#include "support/suite.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

/// For loops that run a million times: each ck_assert writes to a file.
#define CHECK_QUICKLY(claim)                                                                                           \
    do                                                                                                                 \
    {                                                                                                                  \
        if (!(claim))                                                                                                  \
            ck_abort_msg("%s", #claim);                                                                                \
    } while (0)

struct qcModelProxy
{
    btBroadphaseProxy* proxy;
    btVector3 aabbMin, aabbMax;
};

/// Unique ids of two proxies, the lower one first.
typedef std::pair<int, int> qcIdPair;

inline qcIdPair qcIdsOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b)
{
    return {std::min(a->m_uniqueId, b->m_uniqueId), std::max(a->m_uniqueId, b->m_uniqueId)};
}

/// The pairs in a cache, sorted. Duplicates are a failure.
inline std::vector<qcIdPair> qcPairsIn(btOverlappingPairCache* cache)
{
    std::vector<qcIdPair> pairs;
    const btBroadphasePairArray& array = cache->getOverlappingPairArray();
    for (int i = 0; i < array.size(); i++)
        pairs.push_back(qcIdsOf(array[i].m_pProxy0, array[i].m_pProxy1));
    std::sort(pairs.begin(), pairs.end());
    ck_assert(std::adjacent_find(pairs.begin(), pairs.end()) == pairs.end());
    return pairs;
}

struct qcBroadphaseModel
{
    btDefaultCollisionConfiguration configuration;
    btCollisionDispatcher dispatcher{&configuration};
    qcBroadphase broadphase;
    btOverlappingPairCache* cache;
    std::vector<qcModelProxy> proxies;

    explicit qcBroadphaseModel(btOverlappingPairCache* given = nullptr)
        : broadphase(given), cache(broadphase.getOverlappingPairCache())
    {
    }

    ~qcBroadphaseModel()
    {
        while (!proxies.empty())
            Destroy(proxies.size() - 1);
    }

    size_t Create(const btVector3& aabbMin, const btVector3& aabbMax, int group = 1, int mask = -1)
    {
        btBroadphaseProxy* proxy = broadphase.createProxy(aabbMin, aabbMax, 0, this, group, mask, &dispatcher);
        CHECK_QUICKLY(proxy != nullptr && proxy->m_clientObject == this && proxy->m_collisionFilterGroup == group &&
                      proxy->m_collisionFilterMask == mask);
        proxies.push_back({proxy, aabbMin, aabbMax});
        return proxies.size() - 1;
    }

    void Move(size_t i, const btVector3& aabbMin, const btVector3& aabbMax)
    {
        // Before the call, in which a callback may move it once more.
        proxies[i].aabbMin = aabbMin;
        proxies[i].aabbMax = aabbMax;
        broadphase.setAabb(proxies[i].proxy, aabbMin, aabbMax, &dispatcher);
    }

    void Destroy(size_t i)
    {
        broadphase.destroyProxy(proxies[i].proxy, &dispatcher);
        proxies[i] = proxies.back();
        proxies.pop_back();
    }

    bool Agree(btBroadphaseProxy* a, btBroadphaseProxy* b) const
    {
        if (a->m_uniqueId > b->m_uniqueId)
            std::swap(a, b);
        btOverlapFilterCallback* filter = cache->getOverlapFilterCallback();
        if (filter != nullptr)
            return filter->needBroadphaseCollision(a, b);
        return (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
               (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
    }

    std::vector<qcIdPair> Expected() const
    {
        std::vector<qcIdPair> expected;
        for (size_t i = 0; i < proxies.size(); i++)
            for (size_t j = i + 1; j < proxies.size(); j++)
                if (TestAabbAgainstAabb2(proxies[i].aabbMin, proxies[i].aabbMax, proxies[j].aabbMin,
                                         proxies[j].aabbMax) &&
                    Agree(proxies[i].proxy, proxies[j].proxy))
                    expected.push_back(qcIdsOf(proxies[i].proxy, proxies[j].proxy));
        std::sort(expected.begin(), expected.end());
        return expected;
    }

    /// One step; returns the number of pairs.
    size_t Check()
    {
        broadphase.calculateOverlappingPairs(&dispatcher);
        std::vector<qcIdPair> expected = Expected(), held = qcPairsIn(cache);
        for (const qcIdPair& pair : expected)
            if (!std::binary_search(held.begin(), held.end(), pair))
                ck_abort_msg("pair %d %d is missing", pair.first, pair.second);
        for (const qcIdPair& pair : held)
            if (!std::binary_search(expected.begin(), expected.end(), pair))
                ck_abort_msg("pair %d %d should not be there", pair.first, pair.second);
        for (const qcModelProxy& p : proxies)
        {
            btVector3 aabbMin, aabbMax;
            broadphase.getAabb(p.proxy, aabbMin, aabbMax);
            for (int k = 0; k < 3; k++)
            {
                CHECK_QUICKLY(aabbMin[k] == p.aabbMin[k] || p.aabbMin[k] != p.aabbMin[k]);
                CHECK_QUICKLY(aabbMax[k] == p.aabbMax[k] || p.aabbMax[k] != p.aabbMax[k]);
            }
        }
        return held.size();
    }
};

inline btVector3 qcRandomPoint(qcRandom* random, double room)
{
    double x = qcRandom_Uniform(random, 0, room), y = qcRandom_Uniform(random, 0, room);
    return btVector3(btScalar(x), btScalar(y), btScalar(qcRandom_Uniform(random, 0, room)));
}

inline btVector3 qcRandomGridPoint(qcRandom* random, int room)
{
    double x = qcRandom_Integer(random, 0, room), y = qcRandom_Integer(random, 0, room);
    return btVector3(btScalar(x), btScalar(y), btScalar(qcRandom_Integer(random, 0, room)));
}

#endif
