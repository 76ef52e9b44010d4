// Broadphases over the same moving boxes. They take turns frame by frame: disturbances of the machine affect all alike,
// and each starts with caches that another has filled, like in a simulation.
#include "bench/broadphase/broadphase.h"

#include "common/median.h"
#include "common/stopwatch.h"

#include <quickcullide/bullet_broadphase.h>

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/BroadphaseCollision/btSimpleBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <random>
#include <vector>

namespace
{
constexpr uint32_t c_warmFrames = 10, c_minFrames = 10;
// The time limit of one scene.
constexpr double c_enoughMs = 10000.0;
// Creating 50 000 proxies takes bt32BitAxisSweep3 half a minute. A frame of 1000 takes btSimpleBroadphase 11 ms, and
// all others then start with cold caches.
constexpr uint32_t c_maxForSweep = 10000, c_maxForSimple = 500;

/// Boxes with edges of 1 to 2 that go 0.1 a frame, in a cube so dense that each overlaps about four others.
class Boxes
{
  public:
    std::vector<btVector3> lower, upper;
    const double side;

    Boxes(uint32_t count, uint32_t moving) : side(std::cbrt(count * 27.0 / 4.0)), m_moving(moving)
    {
        for (uint32_t i = 0; i < count; i++)
        {
            btVector3 half;
            for (int k = 0; k < 3; k++)
                half[k] = btScalar(Random(0.5, 1.0));
            m_place.push_back(
                btVector3(btScalar(Random(0, side)), btScalar(Random(0, side)), btScalar(Random(0, side))));
            m_half.push_back(half);
            btVector3 way(btScalar(Random(-1, 1)), btScalar(Random(-1, 1)), btScalar(Random(-1, 1)));
            m_way.push_back(way * (btScalar(0.1) / (way.length() + SIMD_EPSILON)));
        }
        lower.resize(count);
        upper.resize(count);
        for (uint32_t i = 0; i < count; i++)
            Enclose(i);
    }

    void Move()
    {
        for (uint32_t i = 0; i < m_moving; i++)
        {
            for (int k = 0; k < 3; k++)
            {
                btScalar next = m_place[i][k] + m_way[i][k];
                if (next < 0 || next > btScalar(side))
                    m_way[i][k] = -m_way[i][k];
                m_place[i][k] += m_way[i][k];
            }
            Enclose(i);
        }
    }

    /// The number of overlaps, by sorting along one axis and without a broadphase.
    size_t CountOverlaps() const
    {
        std::vector<uint32_t> order(lower.size());
        for (uint32_t i = 0; i < order.size(); i++)
            order[i] = i;
        std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return lower[a].x() < lower[b].x(); });
        size_t count = 0;
        for (size_t i = 0; i < order.size(); i++)
            for (size_t j = i + 1; j < order.size() && lower[order[j]].x() <= upper[order[i]].x(); j++)
                count += TestAabbAgainstAabb2(lower[order[i]], upper[order[i]], lower[order[j]], upper[order[j]]);
        return count;
    }

  private:
    double Random(double from, double to)
    {
        // The engine's numbers are the same everywhere, a distribution's are not.
        return from + (to - from) * (double(m_engine()) / 4294967296.0);
    }

    void Enclose(uint32_t i)
    {
        lower[i] = m_place[i] - m_half[i];
        upper[i] = m_place[i] + m_half[i];
    }

    const uint32_t m_moving;
    std::mt19937 m_engine{12345};
    std::vector<btVector3> m_place, m_half, m_way;
};

class Contestant
{
  public:
    Contestant(const char* name, btBroadphaseInterface* broadphase) : m_name(name), m_broadphase(broadphase)
    {
    }

    void Create(const Boxes& boxes)
    {
        double start = qcStopwatch_NowMs();
        for (size_t i = 0; i < boxes.lower.size(); i++)
            m_proxies.push_back(m_broadphase->createProxy(boxes.lower[i], boxes.upper[i], BOX_SHAPE_PROXYTYPE,
                                                          reinterpret_cast<void*>(i), btBroadphaseProxy::DefaultFilter,
                                                          btBroadphaseProxy::AllFilter, &m_dispatcher));
        double created = qcStopwatch_NowMs();
        m_broadphase->calculateOverlappingPairs(&m_dispatcher);
        m_createMs = created - start;
        m_firstMs = qcStopwatch_NowMs() - created;
    }

    /// Returns the time in milliseconds.
    double Step(const Boxes& boxes, size_t setCount, bool counts)
    {
        double start = qcStopwatch_NowMs();
        for (size_t i = 0; i < setCount; i++)
            m_broadphase->setAabb(m_proxies[i], boxes.lower[i], boxes.upper[i], &m_dispatcher);
        double set = qcStopwatch_NowMs();
        m_broadphase->calculateOverlappingPairs(&m_dispatcher);
        double end = qcStopwatch_NowMs();
        if (counts)
        {
            m_setMs.push_back(set - start);
            m_findMs.push_back(end - set);
            m_frameMs.push_back(end - start);
        }
        return end - start;
    }

    qcBroadphaseRow Report(const Boxes& boxes) const
    {
        qcBroadphaseRow row = {};
        row.name = m_name;
        row.createMs = m_createMs;
        row.firstMs = m_firstMs;
        row.setMs = qcMedianOf(m_setMs);
        row.findMs = qcMedianOf(m_findMs);
        row.frameMs = qcMedianOf(m_frameMs);
        row.minMs = *std::min_element(m_frameMs.begin(), m_frameMs.end());
        row.maxMs = *std::max_element(m_frameMs.begin(), m_frameMs.end());
        const btBroadphasePairArray& pairs = m_broadphase->getOverlappingPairCache()->getOverlappingPairArray();
        row.held = size_t(pairs.size());
        for (int i = 0; i < pairs.size(); i++)
        {
            size_t a = reinterpret_cast<size_t>(pairs[i].m_pProxy0->m_clientObject);
            size_t b = reinterpret_cast<size_t>(pairs[i].m_pProxy1->m_clientObject);
            row.overlapping += TestAabbAgainstAabb2(boxes.lower[a], boxes.upper[a], boxes.lower[b], boxes.upper[b]);
        }
        return row;
    }

  private:
    const char* m_name;
    btDefaultCollisionConfiguration m_configuration;
    btCollisionDispatcher m_dispatcher{&m_configuration};
    // Destroyed with its proxies in it: Bullet removes proxies one by one in time quadratic in their number.
    std::unique_ptr<btBroadphaseInterface> m_broadphase;
    std::vector<btBroadphaseProxy*> m_proxies;
    double m_createMs = 0, m_firstMs = 0;
    std::vector<double> m_setMs, m_findMs, m_frameMs;
};

typedef std::vector<std::unique_ptr<Contestant>> Contestants;

Contestants Invite(const Boxes& boxes)
{
    Contestants contestants;
    auto invite = [&](const char* name, btBroadphaseInterface* broadphase)
    { contestants.push_back(std::make_unique<Contestant>(name, broadphase)); };
    uint32_t count = uint32_t(boxes.lower.size());
    invite("qcBroadphase", new qcBroadphase);
    invite("btDbvtBroadphase", new btDbvtBroadphase);
    // Pairs are found once a frame for all moved boxes, not in each setAabb.
    btDbvtBroadphase* deferred = new btDbvtBroadphase;
    deferred->m_deferedcollide = true;
    invite("btDbvtBroadphase deferred", deferred);
    btVector3 reach(4, 4, 4), end = btVector3(1, 1, 1) * btScalar(boxes.side) + reach;
    if (count <= c_maxForSweep)
        invite("bt32BitAxisSweep3", new bt32BitAxisSweep3(-reach, end, count + 2, nullptr, true));
    if (count <= c_maxForSimple)
        invite("btSimpleBroadphase", new btSimpleBroadphase(int(count) + 2));
    return contestants;
}

void Measure(const qcBroadphaseScene& scene, qcBroadphaseResult* result)
{
    uint32_t moving = uint32_t(uint64_t(scene.boxes) * scene.percent / 100);
    Boxes boxes(scene.boxes, moving);
    Contestants contestants = Invite(boxes);
    for (auto& contestant : contestants)
        contestant->Create(boxes);
    *result = {};
    double spent = 0;
    for (uint32_t frame = 0; result->frames < scene.frames; frame++)
    {
        boxes.Move();
        // Each broadphase is first, and follows each other one, equally often.
        for (size_t i = 0; i < contestants.size(); i++)
            spent += contestants[(i + frame) % contestants.size()]->Step(boxes, scene.setsAll ? scene.boxes : moving,
                                                                         frame >= c_warmFrames);
        result->frames += frame >= c_warmFrames;
        if (result->frames >= c_minFrames && spent > c_enoughMs)
            break;
    }
    for (auto& contestant : contestants)
        result->rows[result->count++] = contestant->Report(boxes);
    result->expected = boxes.CountOverlaps();
}
} // namespace

bool qcBroadphase_Measure(const qcBroadphaseScene* scene, qcBroadphaseResult* result)
{
    try
    {
        Measure(*scene, result);
        return true;
    }
    catch (const std::bad_alloc&)
    {
        return false;
    }
}
