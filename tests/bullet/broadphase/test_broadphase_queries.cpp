// Queries of qcBroadphase: boxes and rays, beside btDbvtBroadphase and a plain list; changes made by callbacks.
#include "bullet/broadphase/broadphase_model.h"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include <functional>
#include <map>
#include <set>
#include <thread>

namespace
{
struct Visits : btBroadphaseRayCallback
{
    std::vector<int> ids; ///< in the order of the visits
    std::function<void(const btBroadphaseProxy*)> action;
    bool answer = true;

    bool process(const btBroadphaseProxy* proxy) override
    {
        ids.push_back(proxy->m_uniqueId);
        if (action)
            action(proxy);
        return answer;
    }

    /// Sets the callback's fields for the ray, as btCollisionWorld::rayTest does.
    void Aim(const btVector3& direction, btScalar lambda)
    {
        for (int k = 0; k < 3; k++)
        {
            m_rayDirectionInverse[k] = direction[k] == 0 ? btScalar(BT_LARGE_FLOAT) : 1 / direction[k];
            m_signs[k] = m_rayDirectionInverse[k] < 0;
        }
        m_lambda_max = lambda;
    }

    /// The ids, sorted. Duplicates are a failure.
    std::vector<int> Sorted() const
    {
        std::vector<int> sorted = ids;
        std::sort(sorted.begin(), sorted.end());
        CHECK_QUICKLY(std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end());
        return sorted;
    }
};

bool Includes(const std::vector<int>& all, const std::vector<int>& some)
{
    return std::includes(all.begin(), all.end(), some.begin(), some.end());
}

/// Unique ids of the proxies whose boxes are hit by the path; `slack`: enlargement of the boxes relative to the
/// coordinates of the path's ends.
std::vector<int> OverlapsOnPath(const qcBroadphaseModel& model, const btVector3& from, const btVector3& to,
                                const btVector3& castMin, const btVector3& castMax, double slack)
{
    std::vector<int> met;
    for (const qcModelProxy& p : model.proxies)
    {
        long double enter = 0, leave = 1;
        for (int k = 0; k < 3; k++)
        {
            long double grow = slack * (std::fabs((long double)(from[k])) + std::fabs((long double)(to[k])) + 1);
            long double low = (long double)(p.aabbMin[k]) - castMax[k] - from[k] - grow;
            long double high = (long double)(p.aabbMax[k]) - castMin[k] - from[k] + grow;
            long double d = (long double)(to[k]) - from[k];
            if (d == 0)
            {
                if (low > 0 || high < 0)
                    leave = -1;
                continue;
            }
            enter = std::max(enter, (d > 0 ? low : high) / d);
            leave = std::min(leave, (d > 0 ? high : low) / d);
        }
        if (enter <= leave)
            met.push_back(p.proxy->m_uniqueId);
    }
    std::sort(met.begin(), met.end());
    return met;
}

/// A btDbvtBroadphase with the model's boxes and unique ids.
struct Peer
{
    btDbvtBroadphase broadphase;
    std::vector<btBroadphaseProxy*> proxies;

    explicit Peer(const qcBroadphaseModel& model)
    {
        std::map<int, const qcModelProxy*> byId;
        for (const qcModelProxy& p : model.proxies)
            byId[p.proxy->m_uniqueId] = &p;
        for (const auto& [id, p] : byId)
        {
            broadphase.m_gid = id - 1;
            proxies.push_back(broadphase.createProxy(p->aabbMin, p->aabbMax, 0, nullptr, 1, 0, nullptr));
        }
    }
    ~Peer()
    {
        for (btBroadphaseProxy* proxy : proxies)
            broadphase.destroyProxy(proxy, nullptr);
    }
};

void Fill(qcBroadphaseModel& model, qcRandom* random, int count, bool grid)
{
    for (int i = 0; i < count; i++)
    {
        btVector3 aabbMin = grid ? qcRandomGridPoint(random, 12) : qcRandomPoint(random, 12);
        model.Create(aabbMin, aabbMin + (grid ? qcRandomGridPoint(random, 2) : qcRandomPoint(random, 2)));
    }
    // Some boxes move, so that the tree's enlarged boxes differ from them.
    for (size_t i = 0; i < model.proxies.size(); i += 3)
    {
        btVector3 step = grid ? qcRandomGridPoint(random, 1) : qcRandomPoint(random, 0.1);
        model.Move(i, model.proxies[i].aabbMin + step, model.proxies[i].aabbMax + step);
    }
    model.Check();
}
} // namespace

START_TEST(a_box_query_visits_exactly_the_proxies_that_it_overlaps)
{
    for (int grid = 0; grid <= 1; grid++)
    {
        qcRandom random = {5};
        qcBroadphaseModel model;
        Fill(model, &random, 300, grid);
        const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();
        for (int i = 0; i < 200; i++)
        {
            btVector3 aabbMin = grid ? qcRandomGridPoint(&random, 12) : qcRandomPoint(&random, 12);
            btVector3 aabbMax = aabbMin + qcRandomGridPoint(&random, 3);
            if (i % 20 == 0)
                std::swap(aabbMin, aabbMax);
            if (i % 20 == 1)
                aabbMin.setY(nan);
            std::vector<int> expected;
            for (const qcModelProxy& p : model.proxies)
                if (TestAabbAgainstAabb2(p.aabbMin, p.aabbMax, aabbMin, aabbMax))
                    expected.push_back(p.proxy->m_uniqueId);
            std::sort(expected.begin(), expected.end());
            Visits visits;
            visits.answer = i % 2; // no answer ends the query
            model.broadphase.aabbTest(aabbMin, aabbMax, visits);
            CHECK_QUICKLY(visits.Sorted() == expected);
        }
    }
}
END_TEST

START_TEST(a_ray_visits_all_proxies_that_bullet_visits_and_that_geometry_requires)
{
    size_t met = 0, visited = 0;
    for (int grid = 0; grid <= 1; grid++)
    {
        qcRandom random = {17};
        qcBroadphaseModel model;
        Fill(model, &random, 400, grid);
        Peer peer(model);
        for (int i = 0; i < 300; i++)
        {
            btVector3 from = qcRandomGridPoint(&random, 14), to = qcRandomGridPoint(&random, 14);
            if (!grid)
            {
                from += qcRandomPoint(&random, 1);
                to += qcRandomPoint(&random, 1);
            }
            for (int k = 0; k < 3; k++)
                if (qcRandom_Below(&random, 3) == 0)
                    to[k] = from[k];
            btVector3 castMin(0, 0, 0), castMax(0, 0, 0);
            if (i % 2)
            {
                castMin = -qcRandomPoint(&random, 1);
                castMax = qcRandomPoint(&random, 1);
            }
            btVector3 way = to - from;
            Visits ours, theirs;
            // With lambda in units of length, as in a world, and as a fraction of the way.
            if (i % 3 && !way.fuzzyZero())
                ours.Aim(way.normalized(), way.normalized().dot(way));
            else
                ours.Aim(way, 1);
            theirs.Aim(btVector3(1, 1, 1), 0);
            static_cast<btBroadphaseRayCallback&>(theirs) = ours;
            model.broadphase.rayTest(from, to, ours, castMin, castMax);
            peer.broadphase.rayTest(from, to, theirs, castMin, castMax);
            std::vector<int> sorted = ours.Sorted(), exact = OverlapsOnPath(model, from, to, castMin, castMax, 0);
            CHECK_QUICKLY(Includes(sorted, exact));
            CHECK_QUICKLY(Includes(sorted, theirs.Sorted()));
            CHECK_QUICKLY(Includes(OverlapsOnPath(model, from, to, castMin, castMax, 1e-5), sorted));
            met += exact.size();
            visited += sorted.size();
        }
    }
    ck_assert_uint_gt(met, 1000);
    ck_assert_uint_lt(visited, met + met / 4);
}
END_TEST

START_TEST(a_ray_covers_the_way_of_the_callback_and_that_of_the_caller)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 10; i++)
        model.Create(btVector3(btScalar(2 * i), 0, 0), btVector3(btScalar(2 * i + 1), 1, 1));
    model.Create(btVector3(-50, 100, 0), btVector3(50, 101, 1));
    const btVector3 from(btScalar(-0.5), btScalar(0.5), btScalar(0.5)), to(btScalar(2.5), btScalar(0.5), btScalar(0.5));
    const btScalar nan = std::numeric_limits<btScalar>::quiet_NaN();

    Visits asUsual;
    asUsual.Aim(btVector3(1, 0, 0), 3);
    model.broadphase.rayTest(from, to, asUsual);
    ck_assert(asUsual.Sorted() == std::vector<int>({1, 2}));
    // Longer than the way to `to`, as Bullet's tree allows.
    Visits longer;
    longer.Aim(btVector3(1, 0, 0), btScalar(7.1));
    model.broadphase.rayTest(from, to, longer);
    ck_assert(longer.Sorted() == std::vector<int>({1, 2, 3, 4}));
    Visits endless;
    endless.Aim(btVector3(1, 0, 0), BT_LARGE_FLOAT);
    model.broadphase.rayTest(from, to, endless);
    ck_assert(Includes(endless.Sorted(), {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
    // Shorter: other broadphases go to `to`.
    Visits shorter;
    shorter.Aim(btVector3(1, 0, 0), 1);
    model.broadphase.rayTest(from, to, shorter);
    ck_assert(shorter.Sorted() == std::vector<int>({1, 2}));
    // A callback without a valid direction.
    Visits useless;
    useless.Aim(btVector3(nan, nan, nan), nan);
    model.broadphase.rayTest(from, to, useless);
    ck_assert(useless.Sorted() == std::vector<int>({1, 2}));
    Visits elsewhere;
    elsewhere.Aim(btVector3(0, 1, 0), 100);
    model.broadphase.rayTest(from, to, elsewhere);
    ck_assert(Includes(elsewhere.Sorted(), {1, 2, 11}));
    // A path of length 0 hits the boxes that contain its point.
    Visits standing;
    standing.Aim(btVector3(nan, nan, nan), nan);
    model.broadphase.rayTest(to, to, standing);
    ck_assert(standing.Sorted() == std::vector<int>({2}));
    // A start that is not finite: all proxies are visited, to miss none.
    Visits lost;
    lost.Aim(btVector3(nan, nan, nan), nan);
    model.broadphase.rayTest(btVector3(nan, nan, nan), to, lost);
    ck_assert_uint_eq(lost.ids.size(), 11);
}
END_TEST

START_TEST(a_callback_that_lowers_lambda_shortens_the_ray)
{
    qcBroadphaseModel model;
    for (int i = 0; i < 1000; i++)
        model.Create(btVector3(btScalar(2 * i), 0, 0), btVector3(btScalar(2 * i + 1), 1, 1));
    Visits visits;
    visits.Aim(btVector3(1, 0, 0), 2000);
    visits.answer = false; // ends nothing, as in Bullet
    visits.action = [&](const btBroadphaseProxy* proxy)
    { visits.m_lambda_max = std::min(visits.m_lambda_max, proxy->m_aabbMin.x() + 1); };
    model.broadphase.rayTest(btVector3(-1, btScalar(0.5), btScalar(0.5)), btVector3(1999, btScalar(0.5), btScalar(0.5)),
                             visits);
    ck_assert(std::find(visits.ids.begin(), visits.ids.end(), 1) != visits.ids.end());
    ck_assert_uint_le(visits.ids.size(), 10);
}
END_TEST

START_TEST(several_threads_may_cast_rays_at_once)
{
    qcRandom random = {23};
    qcBroadphaseModel model;
    Fill(model, &random, 300, false);
    auto ask = [&]
    {
        qcRandom own = {29};
        for (int i = 0; i < 300; i++)
        {
            btVector3 from = qcRandomPoint(&own, 14), to = qcRandomPoint(&own, 14), zero(0, 0, 0);
            Visits visits;
            visits.Aim((to - from).normalized(), (to - from).length());
            model.broadphase.rayTest(from, to, visits);
            CHECK_QUICKLY(Includes(visits.Sorted(), OverlapsOnPath(model, from, to, zero, zero, 0)));
            Visits inBox;
            model.broadphase.aabbTest(from, from, inBox);
            CHECK_QUICKLY(inBox.Sorted() == OverlapsOnPath(model, from, from, zero, zero, 0));
        }
    };
    std::vector<std::thread> threads;
    for (int i = 0; i < 4; i++)
        threads.emplace_back(ask);
    for (std::thread& thread : threads)
        thread.join();
}
END_TEST

START_TEST(a_query_callback_may_create_move_and_destroy_proxies)
{
    for (int ray = 0; ray <= 1; ray++)
        for (uint64_t start = 1; start <= 20; start++)
        {
            qcRandom random = {start};
            qcBroadphaseModel model;
            Fill(model, &random, 300, true);
            std::set<int> gone;
            Visits visits;
            visits.Aim(btVector3(1, 1, 1), 14);
            visits.action = [&](const btBroadphaseProxy* proxy)
            {
                CHECK_QUICKLY(gone.count(proxy->m_uniqueId) == 0);
                size_t other = qcRandom_Below(&random, uint32_t(model.proxies.size()));
                switch (qcRandom_Below(&random, 4))
                {
                    case 0:
                        for (size_t i = 0; i < model.proxies.size(); i++)
                            if (model.proxies[i].proxy == proxy)
                            {
                                gone.insert(proxy->m_uniqueId);
                                model.Destroy(i);
                                break;
                            }
                        break;
                    case 1:
                        gone.insert(model.proxies[other].proxy->m_uniqueId);
                        model.Destroy(other);
                        break;
                    case 2: model.Move(other, btVector3(0, 0, 0), btVector3(12, 12, 12)); break;
                    default:
                    {
                        // Created and moved, or created and destroyed, in one callback.
                        size_t created = model.Create(btVector3(0, 0, 0), btVector3(1, 1, 1));
                        model.Move(created, btVector3(5, 5, 5), btVector3(6, 6, 6));
                        if (qcRandom_Below(&random, 2) == 0)
                        {
                            gone.insert(model.proxies[created].proxy->m_uniqueId);
                            model.Destroy(created);
                        }
                    }
                }
                // A query within a query.
                Visits inner;
                model.broadphase.aabbTest(btVector3(0, 0, 0), btVector3(2, 2, 2), inner);
                for (int id : inner.ids)
                    CHECK_QUICKLY(gone.count(id) == 0);
            };
            if (ray)
                model.broadphase.rayTest(btVector3(0, 0, 0), btVector3(14, 14, 14), visits);
            else
                model.broadphase.aabbTest(btVector3(3, 3, 3), btVector3(8, 8, 8), visits);
            CHECK_QUICKLY(!visits.ids.empty());
            model.Check();
            // Proxies created by the callback are found now.
            Visits after;
            model.broadphase.aabbTest(btVector3(-99, -99, -99), btVector3(99, 99, 99), after);
            CHECK_QUICKLY(after.Sorted().size() == model.proxies.size());
        }
}
END_TEST

QC_RUN_TESTS("broadphase queries", a_box_query_visits_exactly_the_proxies_that_it_overlaps,
             a_ray_visits_all_proxies_that_bullet_visits_and_that_geometry_requires,
             a_ray_covers_the_way_of_the_callback_and_that_of_the_caller,
             a_callback_that_lowers_lambda_shortens_the_ray, several_threads_may_cast_rays_at_once,
             a_query_callback_may_create_move_and_destroy_proxies)
