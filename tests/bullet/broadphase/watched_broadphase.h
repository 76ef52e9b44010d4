// A qcBroadphase that compares its pairs with brute force over the boxes that were set, each time that pairs are
// calculated: in every step of any world.
#ifndef QC_TESTS_BULLET_BROADPHASE_WATCHED_BROADPHASE_H
#define QC_TESTS_BULLET_BROADPHASE_WATCHED_BROADPHASE_H

#include "bullet/broadphase/broadphase_model.h"

#include <map>

class qcWatchedBroadphase : public qcBroadphase
{
  public:
    size_t comparisons = 0; ///< number of times that pairs were calculated
    size_t pairs = 0;       ///< sum over the comparisons of the number of pairs
    uint64_t order = 0;     ///< hash of all these pairs, in the order of the cache

    btBroadphaseProxy* createProxy(const btVector3& aabbMin, const btVector3& aabbMax, int shapeType, void* userPtr,
                                   int group, int mask, btDispatcher* dispatcher) override
    {
        btBroadphaseProxy* proxy =
            qcBroadphase::createProxy(aabbMin, aabbMax, shapeType, userPtr, group, mask, dispatcher);
        m_boxes[proxy->m_uniqueId] = {proxy, aabbMin, aabbMax, m_calculating};
        return proxy;
    }

    void destroyProxy(btBroadphaseProxy* proxy, btDispatcher* dispatcher) override
    {
        CHECK_QUICKLY(m_boxes.erase(proxy->m_uniqueId) == 1);
        qcBroadphase::destroyProxy(proxy, dispatcher);
    }

    void setAabb(btBroadphaseProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax,
                 btDispatcher* dispatcher) override
    {
        auto box = m_boxes.find(proxy->m_uniqueId);
        CHECK_QUICKLY(box != m_boxes.end());
        box->second = {proxy, aabbMin, aabbMax, m_calculating};
        qcBroadphase::setAabb(proxy, aabbMin, aabbMax, dispatcher);
    }

    void calculateOverlappingPairs(btDispatcher* dispatcher) override
    {
        if (m_calculating)
            return;
        m_calculating = true;
        qcBroadphase::calculateOverlappingPairs(dispatcher);
        m_calculating = false;
        Compare();
    }

  private:
    struct Box
    {
        btBroadphaseProxy* proxy;
        btVector3 aabbMin, aabbMax;
        bool late; ///< set by a callback while pairs were calculated: takes effect the next time
    };

    void Compare()
    {
        std::vector<qcIdPair> expected, held = qcPairsIn(getOverlappingPairCache());
        for (auto a = m_boxes.begin(); a != m_boxes.end(); ++a)
            for (auto b = std::next(a); b != m_boxes.end(); ++b)
                if (TestAabbAgainstAabb2(a->second.aabbMin, a->second.aabbMax, b->second.aabbMin, b->second.aabbMax) &&
                    Agree(a->second.proxy, b->second.proxy))
                    expected.push_back({a->first, b->first});
        for (const std::vector<qcIdPair>* list : {&expected, &held})
            for (const qcIdPair& pair : *list)
            {
                CHECK_QUICKLY(m_boxes.count(pair.first) == 1 && m_boxes.count(pair.second) == 1);
                bool late = m_boxes[pair.first].late || m_boxes[pair.second].late;
                const std::vector<qcIdPair>& other = list == &held ? expected : held;
                if (!late && !std::binary_search(other.begin(), other.end(), pair))
                    ck_abort_msg("pair %d %d is %s", pair.first, pair.second, list == &held ? "too many" : "missing");
            }
        for (auto& [id, box] : m_boxes)
            box.late = false;
        const btBroadphasePairArray& array = getOverlappingPairCache()->getOverlappingPairArray();
        for (int i = 0; i < array.size(); i++)
            for (const btBroadphaseProxy* proxy : {array[i].m_pProxy0, array[i].m_pProxy1})
                order = (order ^ uint64_t(proxy->m_uniqueId)) * 0x100000001b3;
        comparisons++;
        pairs += held.size();
    }

    /// True if groups and masks agree. A filter callback is not called, since it may count its calls.
    static bool Agree(const btBroadphaseProxy* a, const btBroadphaseProxy* b)
    {
        return (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
               (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
    }

    std::map<int, Box> m_boxes; ///< by unique id
    bool m_calculating = false;
};

#endif
