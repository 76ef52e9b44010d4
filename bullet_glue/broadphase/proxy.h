// A proxy of qcBroadphase, and what both of its files need.
#ifndef QC_GLUE_BROADPHASE_PROXY_H
#define QC_GLUE_BROADPHASE_PROXY_H

#include "quickcullide/bullet_broadphase.h"

#include <LinearMath/btAabbUtil2.h>

constexpr uint32_t qc_noBox = UINT32_MAX;

// Enough for a character or sensor, nothing beside a step in which many boxes move.
constexpr int qc_pairsAtOnce = 8;

/// What Bullet sees, and all that a box that stays needs: with floats, one cache line.
struct qcBroadphase::Proxy : btBroadphaseProxy
{
    using btBroadphaseProxy::btBroadphaseProxy;

    State& state() const;
};

/// What is ours of a proxy.
struct qcBroadphase::State
{
    uint32_t box = qc_noBox;
    int place = -1;          ///< in the list of all proxies; negative: not there yet
    long long sought = 0;    ///< the interval in which it last had to look for all its pairs
    bool odd = false;        ///< bounds are NaN or inverted: what it overlaps is not what its box overlaps
    bool addedPairs = false; ///< is in the list of pairs that were added at once
    bool pending = false;    ///< changes wait for the last walk to end
    bool destroyed = false;  ///< freed when the last walk ends
    bool moves = false;      ///< to wantedMin, wantedMax when the last walk ends
    Proxy* nextPending = nullptr;
    btVector3 wantedMin, wantedMax;
};

/// Where a proxy lives, or may.
union qcBroadphase::Room
{
    Room() : next(nullptr)
    {
    }
    ~Room() = delete;

    Proxy proxy;
    Room* next; ///< that is free
};

constexpr size_t qc_blockSize = 16384;

/// Proxies lie side by side, since each step looks at the filters of all: in a step that moves 10 of 1000 boxes, beside
/// other broadphases that fill the processor's cache, that took a third of the time when they were scattered. A
/// twentieth is for leaving out what is not Bullet's.
struct alignas(qc_blockSize) qcBroadphase::Block
{
    static constexpr size_t c_roomCount = (qc_blockSize - 64) / (sizeof(Room) + sizeof(State));

    alignas(64) unsigned char rooms[c_roomCount * sizeof(Room)];
    alignas(State) unsigned char states[c_roomCount * sizeof(State)];
    Block* next; ///< of those that were allocated by themselves, or with others behind them
};

inline qcBroadphase::State& qcBroadphase::Proxy::state() const
{
    uintptr_t address = reinterpret_cast<uintptr_t>(this), within = address % qc_blockSize;
    Block* block = reinterpret_cast<Block*>(address - within);
    return reinterpret_cast<State*>(block->states)[within / sizeof(Room)];
}

/// While one lives the set stays as it is.
class qcBroadphase::Walk
{
  public:
    explicit Walk(qcBroadphase& broadphase) : m_broadphase(broadphase)
    {
        ++m_broadphase.m_walks;
    }
    ~Walk()
    {
        if (--m_broadphase.m_walks == 0 && m_broadphase.m_pending != nullptr)
            m_broadphase.ApplyPending();
    }

  private:
    qcBroadphase& m_broadphase;
};

template <class Box> inline bool Overlap(const Box* a, const Box* b)
{
    return TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax);
}

/// Both in one number, which is read at once.
inline uint64_t FilterOf(const btBroadphaseProxy* proxy)
{
    return uint64_t(uint32_t(proxy->m_collisionFilterMask)) << 32 | uint32_t(proxy->m_collisionFilterGroup);
}

/// Looks whether the filter is still what it was.
inline void qcBroadphase::LookAt(Listed& listed)
{
    if (listed.filter == FilterOf(listed.proxy))
        return;
    listed.filter = FilterOf(listed.proxy);
    Seek(listed.proxy);
}

/// Calls visit(Proxy*) for each proxy whose box meets the given one.
template <class Visit>
void qcBroadphase::VisitBox(const btVector3& aabbMin, const btVector3& aabbMax, Visit visit) const
{
    auto offer = [&](Proxy* proxy)
    {
        if (!proxy->state().destroyed && TestAabbAgainstAabb2(proxy->m_aabbMin, proxy->m_aabbMax, aabbMin, aabbMax))
            visit(proxy);
    };
    auto function = [](uint32_t, void* proxy, void* context)
    {
        (*static_cast<decltype(offer)*>(context))(static_cast<Proxy*>(proxy));
        return true;
    };
    const double lower[3] = {double(aabbMin[0]), double(aabbMin[1]), double(aabbMin[2])};
    const double upper[3] = {double(aabbMax[0]), double(aabbMax[1]), double(aabbMax[2])};
    qcBoxes_QueryBox(m_boxes, lower, upper, function, &offer);
    for (int i = 0; m_outsideCount > 0 && i < m_proxyCount; i++)
        if (m_proxies[i].proxy->state().box == qc_noBox)
            offer(m_proxies[i].proxy);
}

#endif
