// Calls of the pair cache: none for unchanged boxes, one for each pair that begins or ends.
#include "bullet/broadphase/broadphase_model.h"

namespace
{
/// Counts its calls.
struct CountingCache : btHashedOverlappingPairCache
{
    int added = 0, removed = 0;

    btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override
    {
        added++;
        return btHashedOverlappingPairCache::addOverlappingPair(a, b);
    }
    void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b, btDispatcher* dispatcher) override
    {
        removed++;
        return btHashedOverlappingPairCache::removeOverlappingPair(a, b, dispatcher);
    }
};
} // namespace

START_TEST(the_cache_is_touched_only_for_pairs_that_begin_and_end)
{
    CountingCache cache;
    qcBroadphaseModel model(&cache);
    qcRandom random = {8};
    for (int i = 0; i < 1000; i++)
    {
        btVector3 aabbMin = qcRandomPoint(&random, 15);
        model.Create(aabbMin, aabbMin + btVector3(1, 1, 1));
    }
    std::vector<qcIdPair> before;
    int begun = 0, ended = 0;
    for (int step = 0; step < 20; step++)
    {
        // Asleep at first: each box is set to equal bounds, as a world does.
        for (size_t i = 0; i < model.proxies.size(); i++)
        {
            btVector3 way(0, step < 5 ? btScalar(0) : btScalar(0.01) * btScalar(i % 9), 0);
            model.Move(i, model.proxies[i].aabbMin + way, model.proxies[i].aabbMax + way);
        }
        model.Check();
        std::vector<qcIdPair> now = qcPairsIn(model.cache), changed;
        std::set_difference(now.begin(), now.end(), before.begin(), before.end(), std::back_inserter(changed));
        begun += int(changed.size());
        changed.clear();
        std::set_difference(before.begin(), before.end(), now.begin(), now.end(), std::back_inserter(changed));
        ended += int(changed.size());
        before = now;
        // The first eight that move after a step are added at once, and again by the search, unless it removes them.
        ck_assert_int_ge(cache.added, begun);
        ck_assert_int_le(cache.added, begun + 8 * 20 * (step + 1));
        ck_assert_int_ge(cache.removed, ended);
        ck_assert_int_le(cache.removed - ended, cache.added - begun);
        if (step == 4)
            ck_assert_int_eq(cache.removed, 0);
    }
    ck_assert_int_gt(ended, 100);
}
END_TEST

START_TEST(ten_thousand_sleeping_boxes_cause_no_work_on_pairs)
{
    CountingCache cache;
    qcBroadphaseModel model(&cache);
    for (int i = 0; i < 10000; i++)
    {
        btVector3 aabbMin(btScalar(i % 100), btScalar(i / 100), 0);
        model.Create(aabbMin, aabbMin + btVector3(btScalar(1.5), btScalar(0.5), 1));
    }
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    int added = cache.added;
    ck_assert_int_gt(added, 9000);
    for (int step = 0; step < 3; step++)
    {
        for (size_t i = 0; i < model.proxies.size(); i++)
            model.Move(i, model.proxies[i].aabbMin, model.proxies[i].aabbMax);
        model.broadphase.calculateOverlappingPairs(&model.dispatcher);
        ck_assert_int_eq(cache.added, added);
        ck_assert_int_eq(cache.removed, 0);
    }
    // One by one it would take long: Bullet's cache searches all pairs each time.
    model.proxies.clear();
}
END_TEST

START_TEST(thousands_of_new_boxes_in_one_place_cost_what_their_pairs_cost)
{
    const int count = 2000, pairs = count * (count - 1) / 2;
    CountingCache cache;
    qcBroadphaseModel model(&cache);
    for (int i = 0; i < count; i++)
    {
        model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
        // Only the first few have their pairs at once.
        ck_assert_int_le(cache.added, 8 * i);
    }
    const int atOnce = cache.added;
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    ck_assert_int_eq(cache.getNumOverlappingPairs(), pairs);
    ck_assert_int_le(cache.added, pairs + atOnce);
    // They stay, and all of them may be set.
    for (int i = 0; i < count; i++)
        model.Move(size_t(i), btVector3(0, 0, 0), btVector3(1, 1, 1));
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    ck_assert_int_le(cache.added, pairs + atOnce);
    ck_assert_int_eq(cache.removed, 0);
    // One leaves.
    model.Move(0, btVector3(5, 5, 5), btVector3(6, 6, 6));
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    ck_assert_int_eq(cache.getNumOverlappingPairs(), pairs - (count - 1));
    ck_assert_int_le(cache.added, pairs + atOnce);
    ck_assert_int_eq(cache.removed, count - 1);
    // All part.
    for (int i = 1; i < count; i++)
        model.Move(size_t(i), btVector3(btScalar(2 * i), 0, 0), btVector3(btScalar(2 * i + 1), 1, 1));
    model.broadphase.calculateOverlappingPairs(&model.dispatcher);
    ck_assert_int_eq(cache.getNumOverlappingPairs(), 0);
    ck_assert_int_eq(cache.removed, pairs);
}
END_TEST

QC_RUN_TESTS("work of the broadphase", the_cache_is_touched_only_for_pairs_that_begin_and_end,
             ten_thousand_sleeping_boxes_cause_no_work_on_pairs,
             thousands_of_new_boxes_in_one_place_cost_what_their_pairs_cost)
