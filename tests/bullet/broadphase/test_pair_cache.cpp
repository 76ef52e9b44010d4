// The pair cache that qcBroadphase makes, beside a btHashedOverlappingPairCache that it is given: the same pairs in the
// same order, whatever is added at once.
#include "bullet/broadphase/broadphase_model.h"

namespace
{
/// Boxes of edge 1 in a cube so dense that each overlaps about `density` others. With `groups`, filters reject three
/// quarters of the pairs.
void CreateBoxes(qcBroadphaseModel& model, uint64_t seed, uint32_t count, double density, bool groups = false)
{
    qcRandom random = {seed};
    const double side = std::cbrt(8.0 * count / density);
    for (uint32_t i = 0; i < count; i++)
    {
        btVector3 corner;
        for (int k = 0; k < 3; k++)
            corner[k] = btScalar(qcRandom_Uniform(&random, 0.0, side));
        const int group = groups ? 1 << qcRandom_Below(&random, 4) : 1;
        model.Create(corner, corner + btVector3(1, 1, 1), group, groups ? 3 * group : -1);
    }
}

struct PairCounter : btOverlapCallback
{
    int count = 0;

    bool processOverlap(btBroadphasePair&) override
    {
        count++;
        return false;
    }
};

void CheckSameOrder(qcBroadphaseModel& own, qcBroadphaseModel& given)
{
    own.broadphase.calculateOverlappingPairs(&own.dispatcher);
    given.broadphase.calculateOverlappingPairs(&given.dispatcher);
    const btBroadphasePairArray &a = own.cache->getOverlappingPairArray(), &b = given.cache->getOverlappingPairArray();
    ck_assert_int_eq(a.size(), b.size());
    for (int i = 0; i < a.size(); i++)
    {
        CHECK_QUICKLY(a[i].m_pProxy0->m_uniqueId == b[i].m_pProxy0->m_uniqueId);
        CHECK_QUICKLY(a[i].m_pProxy1->m_uniqueId == b[i].m_pProxy1->m_uniqueId);
        CHECK_QUICKLY(own.cache->findPair(a[i].m_pProxy0, a[i].m_pProxy1) == &a[i]);
    }
}

void Check(uint32_t first, uint32_t second, double density)
{
    btHashedOverlappingPairCache cache;
    qcBroadphaseModel own, given(&cache);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 1, first, density);
    CheckSameOrder(own, given);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 2, second, density);
    CheckSameOrder(own, given);
    ck_assert_int_gt(own.cache->getNumOverlappingPairs(), 0);
    // Every second box goes, and others come.
    for (qcBroadphaseModel* model : {&own, &given})
        for (size_t i = model->proxies.size() / 2; i-- > 0;)
            model->Destroy(2 * i);
    CheckSameOrder(own, given);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 3, second, density);
    CheckSameOrder(own, given);
}
} // namespace

START_TEST(pairs_of_many_new_boxes_are_in_the_order_of_bullets_own_cache)
{
    // No pairs before, few, many; few new ones; so dense that the first boxes have pairs before the search.
    Check(0, 3000, 4);
    Check(20, 3000, 4);
    Check(800, 3000, 8);
    Check(3000, 40, 4);
    Check(2, 700, 300);
    Check(80, 81, 900);
}
END_TEST

START_TEST(filters_of_groups_reject_pairs_of_many_new_boxes)
{
    btHashedOverlappingPairCache cache;
    qcBroadphaseModel own, given(&cache);
    for (qcBroadphaseModel* model : {&own, &given})
        CreateBoxes(*model, 1, 3000, 8, true);
    CheckSameOrder(own, given);
    const size_t count = own.Check();
    ck_assert_uint_gt(count, 2000);
    ck_assert_uint_lt(count, 4000);
}
END_TEST

/// Logs the calls of a filter and of a ghost-pair callback. The filter rejects a third of the pairs.
struct Log : btOverlapFilterCallback, btOverlappingPairCallback
{
    mutable std::vector<qcIdPair> filtered;
    std::vector<qcIdPair> added;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        filtered.push_back({a->m_uniqueId, b->m_uniqueId});
        return (a->m_uniqueId + b->m_uniqueId) % 3 != 0;
    }
    btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override
    {
        added.push_back({a->m_uniqueId, b->m_uniqueId});
        return nullptr;
    }
    void* removeOverlappingPair(btBroadphaseProxy*, btBroadphaseProxy*, btDispatcher*) override
    {
        return nullptr;
    }
    void removeOverlappingPairsContainingProxy(btBroadphaseProxy*, btDispatcher*) override
    {
    }
};

START_TEST(callbacks_are_called_for_pairs_of_many_new_boxes_as_by_bullets_own_cache)
{
    for (int kind = 1; kind <= 3; kind++)
    {
        btHashedOverlappingPairCache cache;
        qcBroadphaseModel own, given(&cache);
        Log logs[2];
        int next = 0;
        for (qcBroadphaseModel* model : {&own, &given})
        {
            Log* log = &logs[next++];
            model->cache->setOverlapFilterCallback((kind & 1) != 0 ? log : nullptr);
            model->cache->setInternalGhostPairCallback((kind & 2) != 0 ? log : nullptr);
            // After a change of the filter callback all pairs are queried.
            model->broadphase.calculateOverlappingPairs(&model->dispatcher);
            CreateBoxes(*model, 1, 2000, 4);
        }
        CheckSameOrder(own, given);
        ck_assert(logs[0].filtered == logs[1].filtered && logs[0].added == logs[1].added);
        ck_assert_uint_eq(logs[0].filtered.empty(), (kind & 1) == 0);
        ck_assert_uint_eq(logs[0].added.size(), (kind & 2) != 0 ? size_t(own.cache->getNumOverlappingPairs()) : 0);
        for (qcBroadphaseModel* model : {&own, &given})
        {
            model->cache->setOverlapFilterCallback(nullptr);
            model->cache->setInternalGhostPairCallback(nullptr);
        }
    }
}
END_TEST

START_TEST(bullets_own_functions_work_on_pairs_of_many_new_boxes)
{
    qcBroadphaseModel model;
    CreateBoxes(model, 1, 3000, 6);
    ck_assert_uint_gt(model.Check(), 5000);
    btOverlappingPairCache* cache = model.cache;
    // The tables have room for about as many pairs again: these make Bullet's own functions enlarge them.
    std::vector<std::pair<btBroadphaseProxy*, btBroadphaseProxy*>> added;
    const int before = cache->getNumOverlappingPairs();
    for (size_t i = 0; cache->getNumOverlappingPairs() < 5 * before; i++)
    {
        btBroadphaseProxy *a = model.proxies[i % 3000].proxy, *b = model.proxies[(7 * i + i / 3000 + 1) % 3000].proxy;
        const int size = cache->getNumOverlappingPairs();
        if (a != b && cache->addOverlappingPair(a, b) != nullptr && cache->getNumOverlappingPairs() > size)
            added.push_back({a, b});
    }
    for (const auto& pair : added)
        CHECK_QUICKLY(cache->findPair(pair.second, pair.first) != nullptr);
    PairCounter counter;
    cache->processAllOverlappingPairs(&counter, &model.dispatcher);
    ck_assert_int_eq(counter.count, cache->getNumOverlappingPairs());
    for (const auto& pair : added)
    {
        cache->removeOverlappingPair(pair.first, pair.second, &model.dispatcher);
        CHECK_QUICKLY(cache->findPair(pair.first, pair.second) == nullptr);
    }
    ck_assert_int_eq(cache->getNumOverlappingPairs(), before);
    model.Check();
    CreateBoxes(model, 2, 3000, 20);
    model.Check();
}
END_TEST

QC_RUN_TESTS("pair cache", pairs_of_many_new_boxes_are_in_the_order_of_bullets_own_cache,
             filters_of_groups_reject_pairs_of_many_new_boxes,
             callbacks_are_called_for_pairs_of_many_new_boxes_as_by_bullets_own_cache,
             bullets_own_functions_work_on_pairs_of_many_new_boxes)
