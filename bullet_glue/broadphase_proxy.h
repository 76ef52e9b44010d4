// A proxy of qcBroadphase, and what both of its files need.
#ifndef QC_BULLET_GLUE_BROADPHASE_PROXY_H
#define QC_BULLET_GLUE_BROADPHASE_PROXY_H

#include "quickcullide/bullet_broadphase.h"

#include <LinearMath/btAabbUtil2.h>

constexpr uint32_t qc_noBox = UINT32_MAX;

// Enough for a character or sensor, nothing beside a step in which many boxes move.
constexpr int qc_pairsAtOnce = 8;

/// With floats, what Bullet sees of it is one cache line, and all that a box that stays needs.
struct alignas(64) qcBroadphase::Proxy : btBroadphaseProxy
{
    Proxy(const btVector3& aabbMin, const btVector3& aabbMax, void* userPtr, int group, int mask)
        : btBroadphaseProxy(aabbMin, aabbMax, userPtr, group, mask)
    {
    }

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

/// Looks whether the filter is still what it was.
inline void qcBroadphase::LookAt(Listed& listed)
{
    if (listed.group == listed.proxy->m_collisionFilterGroup && listed.mask == listed.proxy->m_collisionFilterMask)
        return;
    listed.group = listed.proxy->m_collisionFilterGroup;
    listed.mask = listed.proxy->m_collisionFilterMask;
    Seek(listed.proxy);
}

/// Calls visit(Proxy*) for each proxy whose box meets the given one.
template <class Visit>
void qcBroadphase::VisitBox(const btVector3& aabbMin, const btVector3& aabbMax, Visit visit) const
{
    auto offer = [&](Proxy* proxy)
    {
        if (!proxy->destroyed && TestAabbAgainstAabb2(proxy->m_aabbMin, proxy->m_aabbMax, aabbMin, aabbMax))
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
    for (int i = 0; m_outsideCount > 0 && i < m_proxies.size(); i++)
        if (m_proxies[i].proxy->box == qc_noBox)
            offer(m_proxies[i].proxy);
}

#endif
