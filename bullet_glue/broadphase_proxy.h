// A proxy of qcBroadphase, and what both of its files need.
#ifndef QC_BULLET_GLUE_BROADPHASE_PROXY_H
#define QC_BULLET_GLUE_BROADPHASE_PROXY_H

#include "quickcullide/bullet_broadphase.h"

#include <LinearMath/btAabbUtil2.h>

constexpr uint32_t qc_noBox = UINT32_MAX;

// Enough for a character or sensor, nothing beside a step in which many boxes move.
constexpr int qc_pairsAtOnce = 8;

struct qcBroadphase::Proxy : btBroadphaseProxy
{
    Proxy(const btVector3& aabbMin, const btVector3& aabbMax, void* userPtr, int group, int mask)
        : btBroadphaseProxy(aabbMin, aabbMax, userPtr, group, mask), seenGroup(group), seenMask(mask)
    {
    }

    Proxy *previous = nullptr, *next = nullptr, *nextPending = nullptr;
    uint32_t box = qc_noBox;
    bool listed = false;    ///< and in the tree, or counted as outside of it
    bool pending = false;   ///< changes wait for the last walk to end
    bool destroyed = false; ///< freed when the last walk ends
    bool moves = false;     ///< to wantedMin, wantedMax when the last walk ends
    int seenGroup, seenMask;
    long long created = 0;    ///< the interval in which it was created,
    long long touched = 0;    ///< last moved or got another filter,
    long long sought = 0;     ///< last had to look for pairs although its box in the tree did not change
    btVector3 oldMin, oldMax; ///< bounds at the last search, if touched since
    btVector3 wantedMin, wantedMax;
};

/// While one lives the tree stays as it is.
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
    for (Proxy* proxy = m_outsideCount > 0 ? m_first : nullptr; proxy != nullptr; proxy = proxy->next)
        if (proxy->box == qc_noBox)
            offer(proxy);
}

#endif
