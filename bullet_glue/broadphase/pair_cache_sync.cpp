// The pair cache is kept equal to "boxes overlap and filters agree". What changed comes from qcBoxes; the cache is
// touched for nothing else.
//
// A pair that overlapped at the last search and still does is in the cache, or was rejected by the groups and masks of
// proxies that have not changed them. All pairs are looked at where that is not known: someone else changed the cache,
// a filter changed, there is a filter callback, the cache removes nothing itself, a proxy has odd bounds.
#include "broadphase/proxy.h"

#include <LinearMath/btQuickprof.h>

#include <utility>

/// Adds the pair of two proxies that overlap, if their filters agree. Returns whether they do.
bool qcBroadphase::Judge(Proxy* a, Proxy* b)
{
    // Lower id first, as Bullet does it: a callback may rely on it.
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    if (!m_pairCache->needsBroadphaseCollision(a, b))
        return false;
    // The callback may have destroyed one, and may do so now: Bullet's caches ask it once more.
    if (!a->state().destroyed && !b->state().destroyed)
        m_pairCache->addOverlappingPair(a, b);
    for (Proxy* proxy : {a, b})
        if (proxy->state().destroyed)
            m_pairCache->removeOverlappingPairsContainingProxy(proxy, nullptr);
    return true;
}

void qcBroadphase::RemoveFrom(btAlignedObjectArray<Proxy*>& pairs, const Proxy* proxy)
{
    int kept = 0;
    for (int i = 0; i < pairs.size(); i += 2)
    {
        if (pairs[i] == proxy || pairs[i + 1] == proxy)
            continue;
        pairs[kept++] = pairs[i];
        pairs[kept++] = pairs[i + 1];
    }
    pairs.resize(kept);
}

/// A pair may end before the next search, and its filters may change: it is listed, and checked there.
void qcBroadphase::AddPairNow(Proxy* a, Proxy* b)
{
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    int before = m_pairCache->getNumOverlappingPairs();
    if (a->state().destroyed || b->state().destroyed || !Judge(a, b) || m_pairCache->getNumOverlappingPairs() <= before)
        return;
    a->state().addedPairs = b->state().addedPairs = true;
    m_addedPairs.push_back(a);
    m_addedPairs.push_back(b);
}

void qcBroadphase::AddPairsNow(Proxy* proxy)
{
    if (m_pairsAtOnce == 0)
        return;
    m_pairsAtOnce--;
    // In a list first: a callback may change what is asked here. Most find nothing, and need no walk.
    auto visit = [&](Proxy* other)
    {
        if (other != proxy)
            m_found.push_back(other);
    };
    if (m_oddCount > 0 || m_outsideCount > 0)
        VisitBox(proxy->m_aabbMin, proxy->m_aabbMax, visit);
    else
    {
        auto function = [](uint32_t, void* other, void* context)
        {
            (*static_cast<decltype(visit)*>(context))(static_cast<Proxy*>(other));
            return true;
        };
        qcBoxes_QueryBegun(m_boxes, proxy->state().box, function, &visit);
    }
    if (m_found.size() == 0)
        return;
    Walk walk(*this);
    int before = m_pairCache->getNumOverlappingPairs();
    for (int i = 0; i < m_found.size(); i++)
        AddPairNow(proxy, m_found[i]);
    m_knownPairCount += m_pairCache->getNumOverlappingPairs() - before;
    m_found.resize(0);
}

/// A pair to ask the filter callback about again.
void qcBroadphase::Reject(Proxy* a, Proxy* b)
{
    if (m_filter == nullptr || a->state().destroyed || b->state().destroyed)
        return;
    m_rejected.push_back(a);
    m_rejected.push_back(b);
}

void qcBroadphase::Consider(Proxy* a, Proxy* b)
{
    if (a->state().destroyed || b->state().destroyed || !Overlap(a, b))
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
    for (int i = 0; m_outsideCount > 0 && i < m_proxyCount; i++)
        if (m_proxies[i].proxy->state().box == qc_noBox)
        {
            AddBox(m_proxies[i].proxy);
            // The set does not know what it overlapped before.
            Seek(m_proxies[i].proxy);
        }
}

/// At the filters that were not looked at when boxes were set.
void qcBroadphase::LookAtFilters()
{
    constexpr int at_once = 8;
    int i = m_lookedCount;
    for (; i + at_once <= m_proxyCount; i += at_once)
    {
        const Listed* listed = &m_proxies[i];
        uint64_t differ = 0;
        for (int j = 0; j < at_once; j++)
        {
            differ |= listed[j].filter ^ FilterOf(listed[j].proxy);
        }
        for (int j = 0; differ != 0 && j < at_once; j++)
            LookAt(m_proxies[i + j]);
    }
    for (; i < m_proxyCount; i++)
        LookAt(m_proxies[i]);
}

/// The callback may want now what it did not want before.
void qcBroadphase::JudgeRejected()
{
    int kept = 0;
    for (int i = 0; i < m_rejected.size() && !m_judgeAll && m_filter != nullptr; i += 2)
    {
        Proxy *a = m_rejected[i], *b = m_rejected[i + 1];
        // Pairs of those that look for theirs are found anew.
        if (a->state().destroyed || b->state().destroyed || IsSeeking(a) || IsSeeking(b) || !Overlap(a, b) ||
            Judge(a, b))
            continue;
        m_rejected[kept++] = a;
        m_rejected[kept++] = b;
    }
    m_rejected.resize(kept);
}

/// Its overlaps don't follow from what changed between boxes.
bool qcBroadphase::IsSeeking(const Proxy* proxy) const
{
    return proxy->state().sought == m_interval || proxy->state().odd || proxy->state().box == qc_noBox;
}

void qcBroadphase::SeekPairs()
{
    for (int i = 0; i < m_proxyCount; i++)
    {
        Proxy* proxy = m_proxies[i].proxy;
        if (!m_judgeAll && !IsSeeking(proxy))
            continue;
        VisitBox(proxy->m_aabbMin, proxy->m_aabbMax,
                 [&](Proxy* other)
                 {
                     // Of two that look for pairs, one finds this one.
                     bool both = m_judgeAll || IsSeeking(other);
                     if (other != proxy && (!both || proxy->m_uniqueId < other->m_uniqueId))
                         Consider(proxy, other);
                 });
    }
}

qcBroadphase::Proxy* qcBroadphase::ProxyOf(uint32_t box) const
{
    return static_cast<Proxy*>(qcBoxes_GetUserData(m_boxes, box));
}

void qcBroadphase::AddBegun(const qcBoxChanges& changes)
{
    for (size_t i = 0; i < changes.beganCount; i++)
    {
        Proxy *a = ProxyOf(changes.began[i].a), *b = ProxyOf(changes.began[i].b);
        // Pairs of those that look for theirs are found by them.
        if (m_judgeAll || (m_seeking && (IsSeeking(a) || IsSeeking(b))))
            continue;
        Consider(a, b);
    }
}

/// Removes the pairs that no longer overlap, and those added since the last search whose filters no longer agree.
void qcBroadphase::RemoveEnded(const qcBoxChanges& changes, btDispatcher* dispatcher)
{
    for (size_t i = 0; i < changes.endedCount; i++)
    {
        Proxy *a = ProxyOf(changes.ended[i].a), *b = ProxyOf(changes.ended[i].b);
        if (!a->state().destroyed && !b->state().destroyed)
            m_pairCache->removeOverlappingPair(a, b, dispatcher);
    }
    for (int i = 0; i < m_addedPairs.size(); i += 2)
    {
        Proxy *a = m_addedPairs[i], *b = m_addedPairs[i + 1];
        if (a->state().destroyed || b->state().destroyed ||
            (Overlap(a, b) && m_pairCache->needsBroadphaseCollision(a, b)))
            continue;
        // A filter may have destroyed one, and with it the pair.
        if (!a->state().destroyed && !b->state().destroyed)
            m_pairCache->removeOverlappingPair(a, b, dispatcher);
    }
}

/// What changed between boxes since the last search.
qcBoxChanges qcBroadphase::FindChanges()
{
    BT_PROFILE("qcBroadphase search");
    qcBoxChanges changes = {};
    qcStatus status = m_boxes != nullptr ? qcBoxes_FindChangedPairs(m_boxes, &changes) : qc_statusOk;
    m_judgeAll = m_judgeAll || status != qc_statusOk || changes.all;
    if (status == qc_statusOk)
        return changes;
    m_status = status;
    return {};
}

/// Brings the cache up to date.
void qcBroadphase::UpdatePairs(const qcBoxChanges& changes, btDispatcher* dispatcher)
{
    BT_PROFILE("qcBroadphase pairs");
    m_seeking = m_anythingSought || m_oddCount > 0 || m_outsideCount > 0;
    JudgeRejected();
    AddBegun(changes);
    if (m_judgeAll || m_seeking)
        SeekPairs();
    if (m_judgeAll || m_seeking || m_filter != nullptr || m_pairCache->hasDeferredRemoval())
        RemovePairs(dispatcher);
    else
        RemoveEnded(changes, dispatcher);
}

bool qcBroadphase::IsStillWanted(const btBroadphasePair& pair)
{
    Proxy *a = static_cast<Proxy*>(pair.m_pProxy0), *b = static_cast<Proxy*>(pair.m_pProxy1);
    if (a == nullptr || b == nullptr || a->state().destroyed || b->state().destroyed)
        return false;
    if (!Overlap(a, b))
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
    qcBoxChanges changes = m_anythingTouched ? FindChanges() : qcBoxChanges{};
    // Afterwards: what was set, and is looked at again by the search, is still in the processor's cache.
    LookAtFilters();
    if (m_anythingTouched || m_judgeAll || m_filter != nullptr)
        UpdatePairs(changes, dispatcher);
    for (int i = 0; i < m_addedPairs.size(); i++)
        m_addedPairs[i]->state().addedPairs = false;
    m_addedPairs.resize(0);
    m_interval++;
    m_lookedCount = 0;
    m_anythingTouched = m_anythingSought = false;
    m_judgeAll = false;
    m_pairsAtOnce = qc_pairsAtOnce;
    m_knownPairCount = m_pairCache->getNumOverlappingPairs();
}
