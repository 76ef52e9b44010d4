// The pair cache is kept equal to "boxes overlap and filters agree". What may have changed comes from qcBoxes.
//
// What was decided stays: a pair that overlapped at the last search and still does is in the cache, or was rejected by
// the groups and masks of proxies that have not changed them; only the others are judged.
#include "broadphase_proxy.h"

#include <utility>

/// Adds the pair of two proxies that overlap, if their filters agree. Returns whether they do.
bool qcBroadphase::Judge(Proxy* a, Proxy* b)
{
    // Lower id first, as Bullet does it: a callback may rely on it.
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    if (!m_pairCache->needsBroadphaseCollision(a, b))
        return false;
    // The callback may have destroyed one.
    if (!a->destroyed && !b->destroyed)
        m_pairCache->addOverlappingPair(a, b);
    return true;
}

/// The pair overlapped at the last search and was decided then.
bool qcBroadphase::IsDecided(const Proxy* a, const Proxy* b) const
{
    if (m_judgeAll || m_filter != nullptr || a->created == m_interval || b->created == m_interval ||
        a->sought == m_interval || b->sought == m_interval)
        return false;
    bool movedA = a->touched == m_interval, movedB = b->touched == m_interval;
    return TestAabbAgainstAabb2(movedA ? a->oldMin : a->m_aabbMin, movedA ? a->oldMax : a->m_aabbMax,
                                movedB ? b->oldMin : b->m_aabbMin, movedB ? b->oldMax : b->m_aabbMax);
}

void qcBroadphase::AddPairsNow(Proxy* proxy)
{
    if (m_pairsAtOnce == 0)
        return;
    m_pairsAtOnce--;
    Walk walk(*this);
    int before = m_pairCache->getNumOverlappingPairs();
    VisitBox(proxy->m_aabbMin, proxy->m_aabbMax,
             [&](Proxy* other)
             {
                 if (other != proxy && !proxy->destroyed && !IsDecided(proxy, other))
                     Judge(proxy, other);
             });
    m_knownPairCount += m_pairCache->getNumOverlappingPairs() - before;
}

/// A pair to ask the filter callback about again.
void qcBroadphase::Reject(Proxy* a, Proxy* b)
{
    if (m_filter == nullptr || a->destroyed || b->destroyed)
        return;
    m_rejected.push_back(a);
    m_rejected.push_back(b);
}

void qcBroadphase::Consider(Proxy* a, Proxy* b)
{
    if (a->destroyed || b->destroyed || IsDecided(a, b) ||
        !TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax))
        return;
    if (!Judge(a, b))
        Reject(a, b);
}

/// Looks for what changed by other hands than ours: filters, and the pair cache itself.
void qcBroadphase::LookForChanges()
{
    const btOverlapFilterCallback* filter = m_pairCache->getOverlapFilterCallback();
    m_judgeAll = m_judgeAll || filter != m_filter || m_pairCache->getNumOverlappingPairs() != m_knownPairCount;
    m_filter = filter;
    for (Proxy* proxy = m_first; proxy != nullptr; proxy = proxy->next)
    {
        if (proxy->box == qc_noBox)
            AddBox(proxy);
        if (proxy->seenGroup == proxy->m_collisionFilterGroup && proxy->seenMask == proxy->m_collisionFilterMask)
            continue;
        proxy->seenGroup = proxy->m_collisionFilterGroup;
        proxy->seenMask = proxy->m_collisionFilterMask;
        Touch(proxy);
        Seek(proxy);
    }
}

/// The callback may want now what it did not want before. Pairs of touched proxies are found anew.
void qcBroadphase::JudgeRejected()
{
    int kept = 0;
    for (int i = 0; i < m_rejected.size() && !m_judgeAll && m_filter != nullptr; i += 2)
    {
        Proxy *a = m_rejected[i], *b = m_rejected[i + 1];
        if (a->destroyed || b->destroyed || a->touched == m_interval || b->touched == m_interval || Judge(a, b))
            continue;
        m_rejected[kept++] = a;
        m_rejected[kept++] = b;
    }
    m_rejected.resize(kept);
}

void qcBroadphase::FindPairs()
{
    const qcBoxPair* pairs = nullptr;
    size_t count = 0;
    qcStatus status = m_boxes != nullptr ? qcBoxes_FindMovedPairs(m_boxes, &pairs, &count) : qc_statusOk;
    if (status != qc_statusOk)
    {
        m_status = status;
        m_judgeAll = true;
        m_rejected.resize(0);
        count = 0;
    }
    for (size_t i = 0; i < count; i++)
        Consider(static_cast<Proxy*>(qcBoxes_GetUserData(m_boxes, pairs[i].a)),
                 static_cast<Proxy*>(qcBoxes_GetUserData(m_boxes, pairs[i].b)));
    if (!m_judgeAll && !m_anythingSought && m_outsideCount == 0)
        return;
    for (Proxy* proxy = m_first; proxy != nullptr; proxy = proxy->next)
    {
        if (!m_judgeAll && proxy->sought != m_interval && proxy->box != qc_noBox)
            continue;
        VisitBox(proxy->m_aabbMin, proxy->m_aabbMax,
                 [&](Proxy* other)
                 {
                     // Of two that look for pairs, one finds this one.
                     bool both = m_judgeAll || other->sought == m_interval || other->box == qc_noBox;
                     if (other != proxy && (!both || proxy->m_uniqueId < other->m_uniqueId))
                         Consider(proxy, other);
                 });
    }
}

bool qcBroadphase::IsStillWanted(const btBroadphasePair& pair)
{
    Proxy *a = static_cast<Proxy*>(pair.m_pProxy0), *b = static_cast<Proxy*>(pair.m_pProxy1);
    if (a == nullptr || b == nullptr || a->destroyed || b->destroyed)
        return false;
    if (!m_judgeAll && m_filter == nullptr && a->touched != m_interval && b->touched != m_interval)
        return true;
    if (!TestAabbAgainstAabb2(a->m_aabbMin, a->m_aabbMax, b->m_aabbMin, b->m_aabbMax))
        return false;
    if (m_pairCache->needsBroadphaseCollision(a, b))
        return true;
    Reject(a, b);
    return false;
}

void qcBroadphase::RemovePair(int index, btDispatcher* dispatcher)
{
    btBroadphasePairArray& pairs = m_pairCache->getOverlappingPairArray();
    if (!m_pairCache->hasDeferredRemoval())
    {
        m_pairCache->removeOverlappingPair(pairs[index].m_pProxy0, pairs[index].m_pProxy1, dispatcher);
        return;
    }
    // Such a cache leaves it to the broadphase. Out of the array first: what is cleaned may call back.
    btBroadphasePair pair = pairs[index];
    pairs.swap(index, pairs.size() - 1);
    pairs.pop_back();
    m_pairCache->cleanOverlappingPair(pair, dispatcher);
}

void qcBroadphase::RemovePairs(btDispatcher* dispatcher)
{
    btBroadphasePairArray& pairs = m_pairCache->getOverlappingPairArray();
    for (int i = 0; i < pairs.size();)
    {
        const unsigned destroyed = m_destroyCount;
        const int size = pairs.size();
        bool wanted = IsStillWanted(pairs[i]);
        if (!wanted && m_destroyCount == destroyed)
            RemovePair(i, dispatcher);
        if (m_destroyCount != destroyed)
            i = 0; // a callback destroyed a proxy: pairs are gone, others have taken their places
        else if (wanted || pairs.size() == size)
            i++;
    }
    if (m_pairCache->hasDeferredRemoval())
        RemoveDuplicates();
}

/// A cache with deferred removal may hold a pair twice; the first after sorting is the one that has an algorithm.
void qcBroadphase::RemoveDuplicates()
{
    btBroadphasePairArray& pairs = m_pairCache->getOverlappingPairArray();
    if (pairs.size() == 0)
        return;
    pairs.quickSort(btBroadphasePairSortPredicate());
    int kept = 1;
    for (int i = 1; i < pairs.size(); i++)
        if (!(pairs[i] == pairs[kept - 1]))
            pairs[kept++] = pairs[i];
    pairs.resize(kept);
}

void qcBroadphase::calculateOverlappingPairs(btDispatcher* dispatcher)
{
    if (m_walks > 0)
        return;
    Walk walk(*this);
    m_status = qc_statusOk;
    LookForChanges();
    if (m_anythingTouched || m_judgeAll || m_filter != nullptr)
    {
        JudgeRejected();
        FindPairs();
        RemovePairs(dispatcher);
    }
    m_interval++;
    m_anythingTouched = m_anythingSought = false;
    m_judgeAll = false;
    m_pairsAtOnce = qc_pairsAtOnce;
    m_knownPairCount = m_pairCache->getNumOverlappingPairs();
}
