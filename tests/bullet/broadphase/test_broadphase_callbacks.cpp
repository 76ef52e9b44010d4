// Callbacks of filters and ghost pairs that create, move and destroy proxies.
#include "bullet/broadphase/broadphase_moves.h"

#include <map>

namespace
{
/// A filter that, once, destroys one of its two proxies and another one, moves a third and creates a fourth.
struct Vandal : btOverlapFilterCallback
{
    qcBroadphaseModel* model;
    mutable int countdown = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy*) const override
    {
        if (--countdown != 0)
            return true;
        for (size_t i = 0; i < model->proxies.size(); i++)
            if (model->proxies[i].proxy == a)
            {
                model->Destroy(i);
                break;
            }
        model->Destroy(model->proxies.size() / 2);
        model->Move(0, btVector3(2, 2, 2), btVector3(5, 5, 5));
        model->Create(btVector3(0, 0, 0), btVector3(3, 3, 3));
        return true;
    }
};
} // namespace

START_TEST(a_filter_may_create_move_and_destroy_proxies)
{
    for (int moment = 1; moment < 400; moment += 7)
        for (int sorted = 0; sorted <= 1; sorted++)
        {
            btHashedOverlappingPairCache hashedCache;
            btSortedOverlappingPairCache sortedCache;
            qcBroadphaseModel model(sorted ? static_cast<btOverlappingPairCache*>(&sortedCache) : &hashedCache);
            qcRandom random = {uint64_t(moment)};
            for (int i = 0; i < 40; i++)
            {
                btVector3 aabbMin = qcRandomPoint(&random, 4);
                model.Create(aabbMin, aabbMin + btVector3(1, 1, 1));
            }
            Vandal vandal;
            vandal.model = &model;
            model.cache->setOverlapFilterCallback(&vandal);
            model.Check();
            for (size_t i = 0; i < model.proxies.size(); i++)
                qcMoveOne(model, &random, qcBoxKinds(), i);
            vandal.countdown = moment;
            model.broadphase.calculateOverlappingPairs(&model.dispatcher);
            vandal.countdown = 0;
            // New and moved proxies get their pairs by the next step. The other proxies' pairs have not ended.
            std::map<int, const qcModelProxy*> alive;
            for (const qcModelProxy& p : model.proxies)
                alive[p.proxy->m_uniqueId] = &p;
            for (const qcIdPair& pair : qcPairsIn(model.cache))
            {
                const qcModelProxy *a = alive[pair.first], *b = alive[pair.second];
                CHECK_QUICKLY(a != nullptr && b != nullptr);
                CHECK_QUICKLY(TestAabbAgainstAabb2(a->aabbMin, a->aabbMax, b->aabbMin, b->aabbMax) ||
                              a == &model.proxies[0] || b == &model.proxies[0]);
            }
            model.Check();
            for (size_t i = 0; i < model.proxies.size(); i++)
                qcMoveOne(model, &random, qcBoxKinds(), i);
            model.Check();
            model.cache->setOverlapFilterCallback(nullptr);
            model.Check();
        }
}
END_TEST

namespace
{
/// A filter that, once, destroys the first of its two proxies.
struct Assassin : btOverlapFilterCallback
{
    qcBroadphaseModel* model;
    mutable int countdown = 0;

    bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy*) const override
    {
        if (--countdown == 0)
            for (size_t i = 0; i < model->proxies.size(); i++)
                if (model->proxies[i].proxy == a)
                {
                    model->Destroy(i);
                    break;
                }
        return true;
    }
};
} // namespace

START_TEST(a_filter_that_destroys_a_proxy_during_set_aabb_leaves_no_pair_of_it)
{
    // Bullet's caches call the filter once more when a pair is added.
    for (int moment = 1; moment <= 12; moment++)
        for (int sorted = 0; sorted <= 1; sorted++)
        {
            btHashedOverlappingPairCache hashedCache;
            btSortedOverlappingPairCache sortedCache;
            qcBroadphaseModel model(sorted ? static_cast<btOverlappingPairCache*>(&sortedCache) : &hashedCache);
            Assassin assassin;
            assassin.model = &model;
            for (int i = 0; i < 6; i++)
                model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
            size_t hand = model.Create(btVector3(9, 9, 9), btVector3(10, 10, 10));
            model.Check();
            model.cache->setOverlapFilterCallback(&assassin);
            assassin.countdown = moment;
            model.Move(hand, btVector3(0, 0, 0), btVector3(2, 2, 2));
            ck_assert_uint_eq(model.proxies.size(), 6);
            for (const qcIdPair& pair : qcPairsIn(model.cache))
                for (int id : {pair.first, pair.second})
                    CHECK_QUICKLY(std::any_of(model.proxies.begin(), model.proxies.end(),
                                              [&](const qcModelProxy& p) { return p.proxy->m_uniqueId == id; }));
            ck_assert_uint_eq(model.Check(), 15);
        }
}
END_TEST

namespace
{
/// A ghost-pair callback that creates and moves proxies when pairs begin and end.
struct Breeder : btOverlappingPairCallback
{
    qcBroadphaseModel* model;
    qcRandom random = {3};
    int born = 0;

    void Breed()
    {
        if (model->proxies.size() > 80)
            return;
        btVector3 aabbMin = qcRandomPoint(&random, 6);
        size_t created = model->Create(aabbMin, aabbMin + btVector3(1, 1, 1));
        if (born++ % 3 == 0)
            model->Move(created, btVector3(2, 2, 2), btVector3(4, 4, 4));
        qcMoveOne(*model, &random, qcBoxKinds(), qcRandom_Below(&random, uint32_t(model->proxies.size())));
    }
    btBroadphasePair* addOverlappingPair(btBroadphaseProxy*, btBroadphaseProxy*) override
    {
        if (qcRandom_Below(&random, 4) == 0)
            Breed();
        return nullptr;
    }
    void* removeOverlappingPair(btBroadphaseProxy*, btBroadphaseProxy*, btDispatcher*) override
    {
        if (qcRandom_Below(&random, 4) == 0)
            Breed();
        return nullptr;
    }
    void removeOverlappingPairsContainingProxy(btBroadphaseProxy*, btDispatcher*) override
    {
    }
};
} // namespace

START_TEST(a_ghost_pair_callback_may_create_and_move_proxies)
{
    qcBroadphaseModel model;
    Breeder breeder;
    breeder.model = &model;
    for (int i = 0; i < 20; i++)
        model.Create(btVector3(btScalar(i % 5), 0, 0), btVector3(btScalar(i % 5 + 1), 1, 1));
    model.Check();
    model.cache->setInternalGhostPairCallback(&breeder);
    for (int step = 0; step < 200; step++)
    {
        // Before anything moves, since the first boxes moved after a step have their pairs at once. Each pair that ends
        // with a destroyed proxy may create another proxy.
        for (int deaths = 0; deaths < 5 && model.proxies.size() > 5; deaths++)
        {
            btBroadphaseProxy* doomed = model.proxies[0].proxy;
            model.proxies.erase(model.proxies.begin());
            model.broadphase.destroyProxy(doomed, &model.dispatcher);
        }
        for (size_t i = 0; i < model.proxies.size(); i += 3)
            qcMoveOne(model, &breeder.random, qcBoxKinds(), i);
        model.broadphase.calculateOverlappingPairs(&model.dispatcher);
        // Boxes moved by callbacks take effect from here on.
        model.cache->setInternalGhostPairCallback(nullptr);
        model.Check();
        model.cache->setInternalGhostPairCallback(&breeder);
    }
    ck_assert_int_gt(breeder.born, 300);
    model.cache->setInternalGhostPairCallback(nullptr);
}
END_TEST

namespace
{
/// A filter that accepts every pair.
struct Generous : btOverlapFilterCallback
{
    bool needBroadphaseCollision(btBroadphaseProxy*, btBroadphaseProxy*) const override
    {
        return true;
    }
};

constexpr int s_groupA = 2, s_groupB = 4;
} // namespace

START_TEST(a_pair_accepted_by_a_filter_between_steps_ends_with_the_filter)
{
    for (int sorted = 0; sorted <= 1; sorted++)
        for (int moves = 0; moves <= 1; moves++)
        {
            btHashedOverlappingPairCache hashedCache;
            btSortedOverlappingPairCache sortedCache;
            qcBroadphaseModel model(sorted ? static_cast<btOverlappingPairCache*>(&sortedCache) : &hashedCache);
            Generous generous;
            model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1), s_groupA, s_groupA);
            size_t other = model.Create(btVector3(9, 9, 9), btVector3(10, 10, 10), s_groupB, s_groupB);
            ck_assert_uint_eq(model.Check(), 0);
            model.cache->setOverlapFilterCallback(&generous);
            if (moves)
                model.Move(other, btVector3(0, 0, 0), btVector3(2, 2, 2));
            else
                model.Create(btVector3(0, 0, 0), btVector3(2, 2, 2), s_groupB, s_groupB);
            ck_assert_uint_eq(qcPairsIn(model.cache).size(), 1);
            model.cache->setOverlapFilterCallback(nullptr);
            ck_assert_uint_eq(model.Check(), 0);
        }
}
END_TEST

START_TEST(a_pair_accepted_by_its_groups_between_steps_ends_with_the_groups)
{
    qcBroadphaseModel model;
    model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1), s_groupA, s_groupA);
    size_t other = model.Create(btVector3(9, 9, 9), btVector3(10, 10, 10), s_groupB, s_groupB);
    ck_assert_uint_eq(model.Check(), 0);
    btBroadphaseProxy* proxy = model.proxies[other].proxy;
    proxy->m_collisionFilterGroup = proxy->m_collisionFilterMask = s_groupA;
    model.Move(other, btVector3(0, 0, 0), btVector3(2, 2, 2));
    ck_assert_uint_eq(qcPairsIn(model.cache).size(), 1);
    proxy->m_collisionFilterGroup = proxy->m_collisionFilterMask = s_groupB;
    ck_assert_uint_eq(model.Check(), 0);
}
END_TEST

QC_RUN_TESTS("broadphase callbacks", a_filter_may_create_move_and_destroy_proxies,
             a_filter_that_destroys_a_proxy_during_set_aabb_leaves_no_pair_of_it,
             a_ghost_pair_callback_may_create_and_move_proxies,
             a_pair_accepted_by_a_filter_between_steps_ends_with_the_filter,
             a_pair_accepted_by_its_groups_between_steps_ends_with_the_groups)
