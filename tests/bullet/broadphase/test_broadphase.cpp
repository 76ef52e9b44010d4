// The pairs of qcBroadphase: after each step the cache holds exactly the overlapping pairs that filters accept.
#include "bullet/broadphase/broadphase_moves.h"

#include <cstdlib>
#include <cstring>
#include <map>
#include <unistd.h>

namespace
{
/// A filter that accepts other pairs each time that its mood changes.
struct ChangingFilter : btOverlapFilterCallback
{
    int mood = 0;
    mutable size_t calls = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override
    {
        calls++;
        // Bullet's order: the lower unique id first.
        CHECK_QUICKLY(a->m_uniqueId < b->m_uniqueId);
        return (a->m_uniqueId + 2 * b->m_uniqueId + mood) % 3 != 0;
    }
};

/// A ghost-pair callback that lists the pairs that have begun and not ended.
struct Ghosts : btOverlappingPairCallback
{
    std::map<qcIdPair, int> pairs;

    btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override
    {
        CHECK_QUICKLY(++pairs[qcIdsOf(a, b)] == 1);
        return nullptr;
    }
    void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b, btDispatcher*) override
    {
        CHECK_QUICKLY(--pairs[qcIdsOf(a, b)] == 0);
        pairs.erase(qcIdsOf(a, b));
        return nullptr;
    }
    void removeOverlappingPairsContainingProxy(btBroadphaseProxy*, btDispatcher*) override
    {
        ck_abort_msg("Bullet's caches don't call this");
    }
};

struct Life
{
    uint64_t seed;
    qcBoxKinds kinds;
    bool filters = false;        ///< groups and masks change
    bool changingFilter = false; ///< a filter callback is set, removed and changed
    bool foreignChanges = false; ///< the cache is changed by others
};

void Meddle(qcBroadphaseModel& model, qcRandom* random)
{
    size_t i = qcRandom_Below(random, uint32_t(model.proxies.size()));
    btBroadphaseProxy *a = model.proxies[i].proxy, *b = model.proxies[0].proxy;
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    switch (qcRandom_Below(random, 6))
    {
        case 0: model.cache->removeOverlappingPairsContainingProxy(a, &model.dispatcher); break;
        case 1: model.cache->cleanProxyFromPairs(a, &model.dispatcher); break;
        case 2: model.cache->sortOverlappingPairs(&model.dispatcher); break;
        case 3:
            if (a != b)
                model.cache->addOverlappingPair(a, b);
            break;
        default: break;
    }
}

/// Makes random changes and checks the cache after each step. Returns the number of all pairs.
size_t LiveThrough(const Life& life, btOverlappingPairCache* given = nullptr, Ghosts* ghosts = nullptr)
{
    qcRandom random = {life.seed};
    qcBroadphaseModel model(given);
    ChangingFilter changingFilter;
    size_t seen = 0;
    model.cache->setInternalGhostPairCallback(ghosts);
    for (int step = 0; step < 150; step++)
    {
        for (uint32_t additions = qcRandom_Below(&random, step < 10 ? 20 : 5); additions > 0; additions--)
        {
            btVector3 aabbMin, aabbMax;
            qcRandomBounds(&random, life.kinds, &aabbMin, &aabbMax);
            int group = life.filters ? int(qcRandom_Below(&random, 8)) : 1;
            model.Create(aabbMin, aabbMax, group, life.filters ? int(qcRandom_Below(&random, 8)) : -1);
        }
        // Now and then all boxes are set, as a world does.
        bool atRest = qcRandom_Below(&random, 4) == 0, inOrder = qcRandom_Below(&random, 3) == 0;
        for (size_t i = 0; i < model.proxies.size(); i++)
        {
            // Before setAabb: a later change takes effect one step later.
            if (life.filters && qcRandom_Below(&random, 20) == 0)
                model.proxies[i].proxy->m_collisionFilterMask = int(qcRandom_Below(&random, 8));
            if (!atRest && (inOrder || qcRandom_Below(&random, 2) == 0))
                qcMoveOne(model, &random, life.kinds, i);
            if (qcRandom_Below(&random, 50) == 0)
                model.Destroy(i);
        }
        if (life.changingFilter && qcRandom_Below(&random, 5) == 0)
            model.cache->setOverlapFilterCallback(qcRandom_Below(&random, 3) == 0 ? nullptr : &changingFilter);
        if (qcRandom_Below(&random, 3) == 0)
            changingFilter.mood++;
        if (life.foreignChanges && !model.proxies.empty())
            Meddle(model, &random);
        seen += model.Check();
        if (ghosts != nullptr)
        {
            std::vector<qcIdPair> held = qcPairsIn(model.cache);
            CHECK_QUICKLY(ghosts->pairs.size() == held.size());
            for (const qcIdPair& pair : held)
                CHECK_QUICKLY(ghosts->pairs.count(pair) == 1);
        }
    }
    if (life.changingFilter)
        ck_assert_uint_gt(changingFilter.calls, 0);
    return seen;
}

/// All combinations of options.
std::vector<Life> Lives(uint64_t seeds = 1)
{
    std::vector<Life> lives;
    for (uint64_t seed = 1; seed <= seeds; seed++)
        for (int kinds = 0; kinds < 16; kinds++)
        {
            Life life;
            life.seed = seed;
            life.kinds.grid = kinds & 1;
            life.kinds.strange = kinds & 2;
            life.filters = kinds & 4;
            life.changingFilter = kinds & 8;
            lives.push_back(life);
        }
    return lives;
}
} // namespace

//  ---- exactly the pairs -----------------------------------------------------------------------------

START_TEST(the_cache_holds_exactly_the_overlapping_pairs_that_filters_accept)
{
    for (const Life& life : Lives(2))
        ck_assert_uint_gt(LiveThrough(life), 500);
    ck_assert_uint_eq(qcGetByteCount(), 0);
}
END_TEST

START_TEST(a_sorted_cache_holds_exactly_the_overlapping_pairs_that_filters_accept)
{
    for (const Life& life : Lives())
    {
        btSortedOverlappingPairCache cache;
        ck_assert_uint_gt(LiveThrough(life, &cache), 500);
    }
}
END_TEST

START_TEST(a_cache_changed_by_others_is_corrected_in_the_next_step)
{
    for (Life life : Lives())
    {
        life.foreignChanges = true;
        btHashedOverlappingPairCache cache;
        ck_assert_uint_gt(LiveThrough(life, &cache), 500);
    }
}
END_TEST

START_TEST(a_ghost_pair_callback_is_called_for_each_pair_that_begins_or_ends)
{
    for (const Life& life : Lives())
    {
        Ghosts ghosts;
        ck_assert_uint_gt(LiveThrough(life, nullptr, &ghosts), 500);
        ck_assert_uint_eq(ghosts.pairs.size(), 0);
    }
}
END_TEST

START_TEST(a_null_cache_stays_empty)
{
    btNullPairCache cache;
    qcBroadphaseModel model(&cache);
    for (int step = 0; step < 5; step++)
    {
        for (int i = 0; i < 20; i++)
            model.Create(btVector3(0, 0, 0), btVector3(1, 1, btScalar(step)));
        model.broadphase.calculateOverlappingPairs(&model.dispatcher);
        ck_assert_int_eq(cache.getNumOverlappingPairs(), 0);
    }
}
END_TEST

START_TEST(boxes_that_touch_are_a_pair_and_boxes_one_ulp_apart_are_none)
{
    qcBroadphaseModel model;
    const btScalar beyond = std::nextafter(btScalar(1), btScalar(2));
    model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    size_t other = model.Create(btVector3(1, 1, 1), btVector3(2, 2, 2));
    ck_assert_uint_eq(model.Check(), 1);
    for (int k = 0; k < 3; k++)
    {
        btVector3 apart(1, 1, 1);
        apart[k] = beyond;
        model.Move(other, apart, btVector3(2, 2, 2));
        ck_assert_uint_eq(model.Check(), 0);
        model.Move(other, btVector3(1, 1, 1), btVector3(2, 2, 2));
        ck_assert_uint_eq(model.Check(), 1);
    }
}
END_TEST

START_TEST(a_pair_lives_as_long_as_its_boxes_overlap)
{
    qcBroadphaseModel model;
    size_t a = model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    size_t b = model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    model.Check();
    btBroadphaseProxy *proxyA = model.proxies[a].proxy, *proxyB = model.proxies[b].proxy;
    model.cache->findPair(proxyA, proxyB)->m_internalTmpValue = 4711;
    for (int step = 0; step < 200; step++)
    {
        btVector3 offset(btScalar(step % 100) / 100, 0, 0);
        model.Move(a, offset, offset + btVector3(1, 1, 1));
        model.Check();
        ck_assert_int_eq(model.cache->findPair(proxyA, proxyB)->m_internalTmpValue, 4711);
    }
    model.Move(a, btVector3(2, 0, 0), btVector3(3, 1, 1));
    ck_assert_uint_eq(model.Check(), 0);
    model.Move(a, btVector3(0, 0, 0), btVector3(1, 1, 1));
    ck_assert_uint_eq(model.Check(), 1);
    ck_assert_int_eq(model.cache->findPair(proxyA, proxyB)->m_internalTmpValue, 0);
}
END_TEST

START_TEST(the_first_boxes_moved_after_a_step_have_their_pairs_at_once)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 100; i++)
        model.Create(btVector3(btScalar(2 * i), 0, 0), btVector3(btScalar(2 * i + 1), 1, 1));
    size_t hand = model.Create(btVector3(0, 9, 0), btVector3(1, 10, 1));
    model.Check();
    for (int i = 0; i < 5; i++)
    {
        model.Move(hand, btVector3(btScalar(2 * i), 0, 0), btVector3(btScalar(2 * i + 1), 1, 1));
        ck_assert_ptr_nonnull(model.cache->findPair(model.proxies[hand].proxy, model.proxies[size_t(i)].proxy));
    }
    ck_assert_uint_eq(model.Check(), 1);
    btBroadphaseProxy* created = model.proxies[model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1))].proxy;
    ck_assert_ptr_nonnull(model.cache->findPair(created, model.proxies[0].proxy));
}
END_TEST

START_TEST(a_filter_changed_after_set_aabb_takes_effect_in_the_next_step)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 3; i++)
        model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    ck_assert_uint_eq(model.Check(), 3);
    for (int mask : {0, -1})
    {
        for (size_t i = 0; i < 3; i++)
            model.Move(i, btVector3(0, 0, 0), btVector3(1, 1, 1));
        model.proxies[1].proxy->m_collisionFilterMask = mask;
        model.broadphase.calculateOverlappingPairs(&model.dispatcher);
        for (size_t i = 0; i < 3; i++)
            model.Move(i, btVector3(0, 0, 0), btVector3(1, 1, 1));
        ck_assert_uint_eq(model.Check(), mask == 0 ? 1 : 3);
    }
}
END_TEST

START_TEST(a_filter_changed_before_set_aabb_takes_effect_in_the_same_step)
{
    // All boxes are set again, or only those after the changed one, as in a world that leaves out sleeping objects.
    for (size_t first : {size_t(0), size_t(2)})
    {
        qcBroadphaseModel model;
        for (int i = 0; i < 4; i++)
            model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
        ck_assert_uint_eq(model.Check(), 6);
        for (int mask : {0, -1})
        {
            for (size_t i = 0; i < 4; i++)
                model.Move(i, btVector3(0, 0, 0), btVector3(1, 1, 1));
            model.proxies[1].proxy->m_collisionFilterMask = mask;
            for (size_t i = first; i < 4; i++)
                model.Move(i, btVector3(0, 0, 0), btVector3(1, 1, 1));
            ck_assert_uint_eq(model.Check(), mask == 0 ? 3 : 6);
        }
    }
}
END_TEST

START_TEST(filters_of_many_boxes_at_rest_are_read_in_turn_or_when_a_box_is_set_again)
{
    // Twos that overlap; boxes are not set again.
    qcBroadphaseModel model;
    for (int i = 0; i < 10000; i++)
        model.Create(btVector3(btScalar(i - i % 2), 0, 0), btVector3(btScalar(i - i % 2) + btScalar(0.5), 1, 1));
    ck_assert_uint_eq(model.Check(), 5000);
    auto takesEffectAfter = [&model](size_t box, int mask)
    {
        btBroadphaseProxy *a = model.proxies[box].proxy, *b = model.proxies[box ^ 1].proxy;
        a->m_collisionFilterMask = mask;
        int steps = 0;
        do
        {
            model.broadphase.calculateOverlappingPairs(&model.dispatcher);
            steps++;
        } while ((model.cache->findPair(a, b) == nullptr) == (mask != 0) && steps < 10);
        return steps;
    };
    for (int mask : {0, -1})
        for (size_t box : {size_t(0), size_t(4999), size_t(9998)})
            ck_assert_int_le(takesEffectAfter(box, mask), 3);
    for (int mask : {0, -1})
        for (size_t box : {size_t(0), size_t(4999), size_t(9998)})
        {
            model.proxies[box].proxy->m_collisionFilterMask = mask;
            model.Move(box, model.proxies[box].proxy->m_aabbMin, model.proxies[box].proxy->m_aabbMax);
            ck_assert_int_eq(takesEffectAfter(box, mask), 1);
        }
    ck_assert_uint_eq(model.Check(), 5000);
}
END_TEST

START_TEST(a_thousand_new_boxes_in_one_place_are_all_pairs)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 1000; i++)
        model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    ck_assert_uint_eq(model.Check(), 1000 * 999 / 2);
}
END_TEST

//  ---- the contract ----------------------------------------------------------------------------------

START_TEST(the_same_calls_give_the_same_pairs_in_the_same_order)
{
    std::vector<qcIdPair> first;
    for (int run = 0; run < 4; run++)
    {
        // The last runs are on a broadphase that was used, by few boxes or by many, and reset.
        auto model = std::make_unique<qcBroadphaseModel>();
        int used = 0; // ids
        if (run >= 2)
        {
            used = run == 2 ? 50 : 700;
            for (int i = 0; i < used; i++)
            {
                model->Create(btVector3(btScalar(i), 0, 0), btVector3(btScalar(i + 1), btScalar(i), 1));
                if (i % 100 == 49)
                    model->Check();
            }
            model->Check();
            model->broadphase.resetPool(&model->dispatcher);
            ck_assert_int_eq(model->proxies[model->Create(btVector3(), btVector3())].proxy->m_uniqueId, ++used);
            while (!model->proxies.empty())
                model->Destroy(model->proxies.size() - 1);
            model->broadphase.resetPool(&model->dispatcher);
        }
        qcRandom random = {99};
        std::vector<qcIdPair> order;
        for (int step = 0; step < 30; step++)
        {
            for (int i = 0; i < 10; i++)
            {
                btVector3 aabbMin, aabbMax;
                qcRandomBounds(&random, qcBoxKinds(), &aabbMin, &aabbMax);
                size_t created = model->Create(aabbMin, aabbMax);
                if (step == 0 && i == 0)
                    ck_assert_int_eq(model->proxies[created].proxy->m_uniqueId, used + 1);
            }
            for (size_t i = 0; i < model->proxies.size(); i += 2)
                qcMoveOne(*model, &random, qcBoxKinds(), i);
            model->Destroy(qcRandom_Below(&random, uint32_t(model->proxies.size())));
            model->Check();
            const btBroadphasePairArray& pairs = model->cache->getOverlappingPairArray();
            for (int i = 0; i < pairs.size(); i++)
                order.push_back({pairs[i].m_pProxy0->m_uniqueId - used, pairs[i].m_pProxy1->m_uniqueId - used});
        }
        if (run == 0)
            first = order;
        ck_assert_uint_gt(order.size(), 1000);
        ck_assert(order == first);
    }
}
END_TEST

START_TEST(unique_ids_are_not_used_twice)
{
    qcBroadphaseModel model;
    int last = 0;
    for (int i = 0; i < 100; i++)
    {
        size_t created = model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
        ck_assert_int_gt(model.proxies[created].proxy->m_uniqueId, last);
        last = model.proxies[created].proxy->m_uniqueId;
        if (i % 3 != 0)
            model.Destroy(created);
    }
}
END_TEST

START_TEST(the_broadphase_box_is_the_smallest_around_all_proxies)
{
    qcBroadphaseModel model;
    btVector3 aabbMin(1, 1, 1), aabbMax(2, 2, 2);
    model.broadphase.getBroadphaseAabb(aabbMin, aabbMax);
    ck_assert(aabbMin == btVector3(0, 0, 0) && aabbMax == btVector3(0, 0, 0));
    size_t a = model.Create(btVector3(1, 2, 3), btVector3(4, 5, 6));
    model.Create(btVector3(-1, 3, 4), btVector3(0, 9, 5));
    model.broadphase.getBroadphaseAabb(aabbMin, aabbMax);
    ck_assert(aabbMin == btVector3(-1, 2, 3) && aabbMax == btVector3(4, 9, 6));
    model.Move(a, btVector3(0, 3, 4), btVector3(btScalar(0.5), 4, 5));
    model.broadphase.getBroadphaseAabb(aabbMin, aabbMax);
    ck_assert(aabbMin == btVector3(-1, 3, 4) && aabbMax == btVector3(btScalar(0.5), 9, 5));
}
END_TEST

START_TEST(statistics_count_proxies_and_pairs)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 7; i++)
        model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    model.Check();
    FILE* file = tmpfile();
    fflush(stdout);
    const int standardOutput = dup(STDOUT_FILENO);
    dup2(fileno(file), STDOUT_FILENO);
    model.broadphase.printStats();
    fflush(stdout);
    dup2(standardOutput, STDOUT_FILENO);
    close(standardOutput);
    rewind(file);
    char line[200] = "";
    ck_assert_ptr_nonnull(fgets(line, sizeof line, file));
    fclose(file);
    ck_assert_ptr_nonnull(strstr(line, "7 proxies"));
    ck_assert_ptr_nonnull(strstr(line, "21 pairs"));
}
END_TEST

START_TEST(null_proxies_are_ignored)
{
    qcBroadphaseModel model;
    model.broadphase.destroyProxy(nullptr, &model.dispatcher);
    model.broadphase.setAabb(nullptr, btVector3(0, 0, 0), btVector3(1, 1, 1), &model.dispatcher);
    ck_assert_uint_eq(model.Check(), 0);
}
END_TEST

//  ---- memory ----------------------------------------------------------------------------------------

namespace
{
struct Heap
{
    size_t calls, failFrom, failTo;
};

void* Allocate(size_t size, void* context)
{
    Heap* heap = static_cast<Heap*>(context);
    heap->calls++;
    return heap->calls >= heap->failFrom && heap->calls < heap->failTo ? nullptr
                                                                       : aligned_alloc(64, (size + 63) / 64 * 64);
}

void Release(void* memory, size_t, void*)
{
    free(memory);
}
} // namespace

START_TEST(no_pair_is_lost_without_memory_and_errors_end_with_new_memory)
{
    Heap heap = {0, 0, 0};
    ck_assert_int_eq(qcSetAllocator(Allocate, Release, &heap), qc_statusOk);
    int troubled = 0;
    for (size_t failFrom = 1; failFrom < 60; failFrom++)
        for (size_t length : {size_t(1), size_t(1000000)})
        {
            heap = {0, failFrom, failFrom + length};
            qcBroadphaseModel model;
            qcRandom random = {failFrom};
            bool trouble = false;
            for (int step = 0; step < 6; step++)
            {
                for (int i = 0; i < 25; i++)
                {
                    btVector3 aabbMin = qcRandomPoint(&random, 5);
                    model.Create(aabbMin, aabbMin + btVector3(1, 1, 1));
                    trouble = trouble || model.broadphase.getStatus() != qc_statusOk;
                }
                for (size_t i = 0; i < model.proxies.size(); i += 2)
                    qcMoveOne(model, &random, qcBoxKinds(), i);
                model.Check();
                trouble = trouble || model.broadphase.getStatus() != qc_statusOk;
                model.Destroy(qcRandom_Below(&random, uint32_t(model.proxies.size())));
                // Queries see the proxies outside of the tree as well.
                struct Counter : btBroadphaseAabbCallback
                {
                    size_t count = 0;
                    bool process(const btBroadphaseProxy*) override
                    {
                        count++;
                        return true;
                    }
                } counter;
                model.broadphase.aabbTest(btVector3(-99, -99, -99), btVector3(99, 99, 99), counter);
                CHECK_QUICKLY(counter.count == model.proxies.size());
                btVector3 aabbMin, aabbMax;
                model.broadphase.getBroadphaseAabb(aabbMin, aabbMax);
                for (const qcModelProxy& p : model.proxies)
                    for (int k = 0; k < 3; k++)
                        CHECK_QUICKLY(aabbMin[k] <= p.aabbMin[k] && aabbMax[k] >= p.aabbMax[k]);
            }
            troubled += trouble;
            heap = {0, 0, 0};
            model.Check();
            ck_assert_int_eq(model.broadphase.getStatus(), qc_statusOk);
        }
    ck_assert_int_gt(troubled, 30);
    ck_assert_uint_eq(qcGetByteCount(), 0);
    ck_assert_int_eq(qcSetAllocator(nullptr, nullptr, nullptr), qc_statusOk);
}
END_TEST

namespace
{
void* AllocateNothing(size_t, int)
{
    return nullptr;
}

void FreeNothing(void*)
{
}
} // namespace

START_TEST(create_proxy_returns_null_without_memory)
{
    qcBroadphaseModel model;
    model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
    btAlignedAllocSetCustomAligned(AllocateNothing, FreeNothing);
    // Free slots may be left for some. They overlap nothing, since Bullet's cache does not check its allocations.
    btBroadphaseProxy* proxy = nullptr;
    std::vector<btBroadphaseProxy*> made;
    do
    {
        btVector3 aabbMin(btScalar(10 + 2 * int(made.size())), 0, 0);
        proxy =
            model.broadphase.createProxy(aabbMin, aabbMin + btVector3(1, 1, 1), 0, nullptr, 1, -1, &model.dispatcher);
        made.push_back(proxy);
    } while (proxy != nullptr && made.size() < 1000);
    btAlignedAllocSetCustomAligned(nullptr, nullptr);
    ck_assert_ptr_null(proxy);
    ck_assert_int_eq(model.broadphase.getStatus(), qc_statusOutOfMemory);
    ck_assert_uint_eq(model.Check(), 0);
    ck_assert_int_eq(model.broadphase.getStatus(), qc_statusOk);
}
END_TEST

QC_RUN_TESTS("broadphase", the_cache_holds_exactly_the_overlapping_pairs_that_filters_accept,
             a_sorted_cache_holds_exactly_the_overlapping_pairs_that_filters_accept,
             a_cache_changed_by_others_is_corrected_in_the_next_step,
             a_ghost_pair_callback_is_called_for_each_pair_that_begins_or_ends, a_null_cache_stays_empty,
             boxes_that_touch_are_a_pair_and_boxes_one_ulp_apart_are_none, a_pair_lives_as_long_as_its_boxes_overlap,
             the_first_boxes_moved_after_a_step_have_their_pairs_at_once,
             a_filter_changed_after_set_aabb_takes_effect_in_the_next_step,
             a_filter_changed_before_set_aabb_takes_effect_in_the_same_step,
             filters_of_many_boxes_at_rest_are_read_in_turn_or_when_a_box_is_set_again,
             a_thousand_new_boxes_in_one_place_are_all_pairs, the_same_calls_give_the_same_pairs_in_the_same_order,
             unique_ids_are_not_used_twice, the_broadphase_box_is_the_smallest_around_all_proxies,
             statistics_count_proxies_and_pairs, null_proxies_are_ignored,
             no_pair_is_lost_without_memory_and_errors_end_with_new_memory, create_proxy_returns_null_without_memory)
