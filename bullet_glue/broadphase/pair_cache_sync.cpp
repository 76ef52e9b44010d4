// Keeps a Bullet pair cache equal to "boxes overlap and filters agree".
#include "broadphase/pair_cache_sync.h"

#include <LinearMath/btQuickprof.h>

#include <climits>
#include <utility>

namespace
{
// Max number of proxies whose pairs are added at once between two searches: enough for a character or a sensor, and
// negligible cost in a step that moves many boxes.
constexpr int qc_earlyQueries = 8;
} // namespace

qcPairCacheSync::qcPairCacheSync(btOverlappingPairCache* cache)
    : m_cache(cache), m_ownsCache(cache == nullptr), m_earlyQueries(qc_earlyQueries)
{
    if (m_ownsCache)
        m_cache = new (btAlignedAlloc(sizeof(qcPairCache), 16)) qcPairCache();
    m_knownPairCount = m_cache->getNumOverlappingPairs();
}

qcPairCacheSync::~qcPairCacheSync()
{
    if (!m_ownsCache)
        return;
    m_cache->~btOverlappingPairCache();
    btAlignedFree(m_cache);
}

void qcPairCacheSync::ResetEarlyQueries()
{
    m_earlyQueries = qc_earlyQueries;
}

//  ---- single proxies --------------------------------------------------------------------------------

void qcPairCacheSync::Add(qcProxy* proxy)
{
    if (IsIterating())
    {
        m_proxies.Pend(proxy);
        return;
    }
    m_proxies.List(proxy);
    AddEarlyPairs(proxy);
}

void qcPairCacheSync::PendMove(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax)
{
    proxy->state().moves = true;
    proxy->state().pendingMin = aabbMin;
    proxy->state().pendingMax = aabbMax;
    m_proxies.Pend(proxy);
}

void qcPairCacheSync::MoveNow(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax)
{
    m_proxies.Move(proxy, aabbMin, aabbMax);
    AddEarlyPairs(proxy);
}

void qcPairCacheSync::Destroy(qcProxy* proxy, btDispatcher* dispatcher)
{
    if (proxy->state().destroyed)
        return;
    {
        // A ghost-pair callback may create and move other proxies: their pairs are added once the cache is consistent
        // again.
        IterationGuard guard(*this);
        int before = m_cache->getNumOverlappingPairs();
        // Removed at once: a ghost-pair callback reads the object, which its owner is about to delete.
        m_cache->removeOverlappingPairsContainingProxy(proxy, dispatcher);
        m_knownPairCount += m_cache->getNumOverlappingPairs() - before;
    }
    m_destroyCount++;
    if (!IsIterating())
    {
        Free(proxy);
        return;
    }
    proxy->state().destroyed = true;
    m_destroyedCount++;
    m_proxies.Pend(proxy);
}

void qcPairCacheSync::Free(qcProxy* proxy)
{
    if (proxy->state().addedPairs)
        RemoveFrom(m_early, proxy);
    RemoveFrom(m_rejected, proxy);
    m_proxies.Free(proxy);
}

void qcPairCacheSync::ApplyPending()
{
    while (qcProxy* proxy = m_proxies.TakePending())
    {
        if (proxy->state().destroyed)
        {
            m_destroyedCount--;
            Free(proxy);
            continue;
        }
        if (proxy->state().index < 0)
            m_proxies.List(proxy);
        if (proxy->state().moves)
            m_proxies.Move(proxy, proxy->state().pendingMin, proxy->state().pendingMax);
        proxy->state().moves = false;
    }
}

//  ---- pairs -----------------------------------------------------------------------------------------

/// Adds the pair of two overlapping proxies if their filters agree. Returns whether they agree.
bool qcPairCacheSync::AddIfAccepted(qcProxy* a, qcProxy* b)
{
    // Lower id first, as in Bullet: a callback may rely on this order.
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    if (!m_cache->needsBroadphaseCollision(a, b))
        return false;
    // The filter may have destroyed a proxy, and may destroy one during the addition: Bullet's caches call it once
    // more.
    if (!IsDestroyed(a) && !IsDestroyed(b))
        m_cache->addOverlappingPair(a, b);
    for (qcProxy* proxy : {a, b})
        if (IsDestroyed(proxy))
            m_cache->removeOverlappingPairsContainingProxy(proxy, nullptr);
    return true;
}

void qcPairCacheSync::RemoveFrom(Pairs& pairs, const qcProxy* proxy)
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

/// Adds a pair before the next search. It is listed for a check in that search: by then the pair may have ended, or its
/// filters may have changed.
void qcPairCacheSync::AddEarlyPair(qcProxy* a, qcProxy* b)
{
    if (a->m_uniqueId > b->m_uniqueId)
        std::swap(a, b);
    int before = m_cache->getNumOverlappingPairs();
    if (IsDestroyed(a) || IsDestroyed(b) || !AddIfAccepted(a, b) || m_cache->getNumOverlappingPairs() <= before)
        return;
    a->state().addedPairs = b->state().addedPairs = true;
    m_early.push_back(a);
    m_early.push_back(b);
}

void qcPairCacheSync::AddEarlyPairs(qcProxy* proxy)
{
    if (m_earlyQueries == 0)
        return;
    m_earlyQueries--;
    // Collected in a list first: a callback may change the set. Most proxies find nothing and need no guard.
    auto visit = [&](qcProxy* other)
    {
        if (other != proxy)
            m_found.push_back(other);
    };
    if (m_proxies.HasExceptions())
        m_proxies.VisitBox(proxy->m_aabbMin, proxy->m_aabbMax, visit);
    else
    {
        auto function = [](uint32_t, void* other, void* context)
        {
            (*static_cast<decltype(visit)*>(context))(static_cast<qcProxy*>(other));
            return true;
        };
        qcBoxes_QueryBegun(m_proxies.GetBoxes(), proxy->state().box, function, &visit);
    }
    if (m_found.size() == 0)
        return;
    IterationGuard guard(*this);
    int before = m_cache->getNumOverlappingPairs();
    for (int i = 0; i < m_found.size(); i++)
        AddEarlyPair(proxy, m_found[i]);
    m_knownPairCount += m_cache->getNumOverlappingPairs() - before;
    m_found.resize(0);
}

/// Lists a rejected pair. The next search calls the filter callback for it again.
void qcPairCacheSync::Reject(qcProxy* a, qcProxy* b)
{
    if (m_filter == nullptr || IsDestroyed(a) || IsDestroyed(b))
        return;
    m_rejected.push_back(a);
    m_rejected.push_back(b);
}

void qcPairCacheSync::TestPair(qcProxy* a, qcProxy* b)
{
    if (IsDestroyed(a) || IsDestroyed(b) || !qcOverlap(a, b))
        return;
    if (!AddIfAccepted(a, b))
        Reject(a, b);
}

/// Detects changes by others: to the filter callback and to the pair cache itself.
void qcPairCacheSync::FindForeignChanges()
{
    const btOverlapFilterCallback* filter = m_cache->getOverlapFilterCallback();
    m_filterAll = m_filterAll || filter != m_filter || m_cache->getNumOverlappingPairs() != m_knownPairCount;
    m_filter = filter;
    m_proxies.AddMissingBoxes();
}

/// Tests the rejected pairs again: the callback may accept them now.
void qcPairCacheSync::FilterRejected()
{
    int kept = 0;
    for (int i = 0; i < m_rejected.size() && !m_filterAll && m_filter != nullptr; i += 2)
    {
        qcProxy *a = m_rejected[i], *b = m_rejected[i + 1];
        // Skips proxies that are queried again: their queries find these pairs.
        if (IsDestroyed(a) || IsDestroyed(b) || m_proxies.NeedsQuery(a) || m_proxies.NeedsQuery(b) ||
            !qcOverlap(a, b) || AddIfAccepted(a, b))
            continue;
        m_rejected[kept++] = a;
        m_rejected[kept++] = b;
    }
    m_rejected.resize(kept);
}

void qcPairCacheSync::QueryPairs()
{
    for (int i = 0; i < m_proxies.GetCount(); i++)
    {
        qcProxy* proxy = m_proxies.At(i);
        if (!m_filterAll && !m_proxies.NeedsQuery(proxy))
            continue;
        m_proxies.VisitBox(proxy->m_aabbMin, proxy->m_aabbMax,
                           [&](qcProxy* other)
                           {
                               // A pair of two queried proxies is found once.
                               bool both = m_filterAll || m_proxies.NeedsQuery(other);
                               if (other != proxy && (!both || proxy->m_uniqueId < other->m_uniqueId))
                                   TestPair(proxy, other);
                           });
    }
}

void qcPairCacheSync::AddBegun(const qcBoxChanges& changes)
{
    // Queries find all pairs.
    if (m_filterAll)
        return;
    qcPairCache* own = m_ownsCache ? static_cast<qcPairCache*>(m_cache) : nullptr;
    const int known = m_cache->getNumOverlappingPairs();
    const bool hasRoom =
        own != nullptr && changes.beganCount <= size_t(INT_MAX) && own->ReserveMore(int(changes.beganCount));
    bool appends = false;
    UpcomingPairs pairs[2];
    FetchProxies(changes, 0, pairs[0]);
    for (size_t first = 0, block = 0; first < changes.beganCount; first += qc_fetchedPairs, block++)
    {
        FetchProxies(changes, first + qc_fetchedPairs, pairs[(block + 1) % 2]);
        appends = appends || (hasRoom && own->CanAppend());
        if (appends)
            AppendFetched(pairs[block % 2], known);
        else
            AddFetched(pairs[block % 2]);
    }
}

/// Fetches the proxies of the pairs from this one on that are added together.
void qcPairCacheSync::FetchProxies(const qcBoxChanges& changes, size_t first, UpcomingPairs& pairs) const
{
    pairs.count = 0;
    // Pairs are in the order of the first box: mostly it is that of the previous pair.
    uint32_t box = qc_noBox;
    qcProxy* a = nullptr;
    for (size_t i = first; i < changes.beganCount && pairs.count < qc_fetchedPairs; i++)
    {
        if (changes.began[i].a != box)
        {
            box = changes.began[i].a;
            a = m_proxies.OfBox(box);
            __builtin_prefetch(&a->m_collisionFilterGroup);
        }
        qcProxy* b = m_proxies.OfBox(changes.began[i].b);
        __builtin_prefetch(&b->m_collisionFilterGroup);
        __builtin_prefetch(&b->m_uniqueId);
        pairs.pair[pairs.count++] = {a, b, 0, 0};
    }
}

void qcPairCacheSync::AddFetched(UpcomingPairs& pairs)
{
    if (m_ownsCache)
        static_cast<qcPairCache*>(m_cache)->Fetch(pairs.pair, pairs.count);
    for (int i = 0; i < pairs.count; i++)
    {
        qcProxy *a = static_cast<qcProxy*>(pairs.pair[i].a), *b = static_cast<qcProxy*>(pairs.pair[i].b);
        if (IsNew(a, b))
            TestPair(a, b);
    }
}

/// True if the pair of two boxes that began to overlap is new. Proxies that are queried again are skipped: their
/// queries find these pairs.
bool qcPairCacheSync::IsNew(const qcProxy* a, const qcProxy* b) const
{
    return !m_querying || (!m_proxies.NeedsQuery(a) && !m_proxies.NeedsQuery(b));
}

/// Adds pairs of which only those before index `known` of the cache are looked up: a search reports a pair once.
void qcPairCacheSync::AppendFetched(UpcomingPairs& pairs, int known)
{
    qcPairCache* own = static_cast<qcPairCache*>(m_cache);
    int count = 0;
    for (int i = 0; i < pairs.count; i++)
    {
        qcProxy *a = static_cast<qcProxy*>(pairs.pair[i].a), *b = static_cast<qcProxy*>(pairs.pair[i].b);
        pairs.pair[count] = pairs.pair[i];
        count += IsNew(a, b) && !IsDestroyed(a) && !IsDestroyed(b) && own->qcPairCache::needsBroadphaseCollision(a, b);
    }
    own->Append(pairs.pair, count, known);
}

/// Removes the pairs that no longer overlap, and those added since the last search whose filters no longer agree.
void qcPairCacheSync::RemoveEnded(const qcBoxChanges& changes, btDispatcher* dispatcher)
{
    for (size_t i = 0; i < changes.endedCount; i++)
    {
        qcProxy *a = m_proxies.OfBox(changes.ended[i].a), *b = m_proxies.OfBox(changes.ended[i].b);
        if (!IsDestroyed(a) && !IsDestroyed(b))
            m_cache->removeOverlappingPair(a, b, dispatcher);
    }
    for (int i = 0; i < m_early.size(); i += 2)
    {
        qcProxy *a = m_early[i], *b = m_early[i + 1];
        if (IsDestroyed(a) || IsDestroyed(b) || (qcOverlap(a, b) && m_cache->needsBroadphaseCollision(a, b)))
            continue;
        // A filter may have destroyed one, and with it the pair.
        if (!IsDestroyed(a) && !IsDestroyed(b))
            m_cache->removeOverlappingPair(a, b, dispatcher);
    }
}

/// Brings the cache up to date.
void qcPairCacheSync::UpdatePairs(const qcBoxChanges& changes, btDispatcher* dispatcher)
{
    BT_PROFILE("qcBroadphase pairs");
    m_querying = m_proxies.HasRequeries() || m_proxies.HasExceptions();
    FilterRejected();
    AddBegun(changes);
    if (m_filterAll || m_querying)
        QueryPairs();
    if (m_filterAll || m_querying || m_filter != nullptr || m_cache->hasDeferredRemoval())
        RemovePairs(dispatcher);
    else
        RemoveEnded(changes, dispatcher);
}

bool qcPairCacheSync::IsAccepted(const btBroadphasePair& pair)
{
    qcProxy *a = static_cast<qcProxy*>(pair.m_pProxy0), *b = static_cast<qcProxy*>(pair.m_pProxy1);
    if (a == nullptr || b == nullptr || IsDestroyed(a) || IsDestroyed(b))
        return false;
    if (!qcOverlap(a, b))
        return false;
    if (m_cache->needsBroadphaseCollision(a, b))
        return true;
    Reject(a, b);
    return false;
}

void qcPairCacheSync::RemovePair(int index, btDispatcher* dispatcher)
{
    btBroadphasePairArray& pairs = m_cache->getOverlappingPairArray();
    if (!m_cache->hasDeferredRemoval())
    {
        m_cache->removeOverlappingPair(pairs[index].m_pProxy0, pairs[index].m_pProxy1, dispatcher);
        return;
    }
    // A cache with deferred removal leaves the removal to the broadphase. The pair leaves the array first: cleaning may
    // call back.
    btBroadphasePair pair = pairs[index];
    pairs.swap(index, pairs.size() - 1);
    pairs.pop_back();
    m_cache->cleanOverlappingPair(pair, dispatcher);
}

void qcPairCacheSync::RemovePairs(btDispatcher* dispatcher)
{
    btBroadphasePairArray& pairs = m_cache->getOverlappingPairArray();
    for (int i = 0; i < pairs.size();)
    {
        const unsigned destroyed = m_destroyCount;
        const int size = pairs.size();
        bool accepted = IsAccepted(pairs[i]);
        if (!accepted && m_destroyCount == destroyed)
            RemovePair(i, dispatcher);
        if (m_destroyCount != destroyed)
            i = 0; // a callback destroyed a proxy: pairs are gone, others have taken their places
        else if (accepted || pairs.size() == size)
            i++;
    }
    if (m_cache->hasDeferredRemoval())
        RemoveDuplicates();
}

/// A cache with deferred removal may hold a pair twice; the first after sorting is the one that has an algorithm.
void qcPairCacheSync::RemoveDuplicates()
{
    btBroadphasePairArray& pairs = m_cache->getOverlappingPairArray();
    if (pairs.size() == 0)
        return;
    pairs.quickSort(btBroadphasePairSortPredicate());
    int kept = 1;
    for (int i = 1; i < pairs.size(); i++)
        if (!(pairs[i] == pairs[kept - 1]))
            pairs[kept++] = pairs[i];
    pairs.resize(kept);
}

void qcPairCacheSync::Update(btDispatcher* dispatcher)
{
    IterationGuard guard(*this);
    m_proxies.ClearStatus();
    FindForeignChanges();
    qcBoxChanges changes = m_proxies.HasChanges() ? m_proxies.FindChanges() : qcBoxChanges{};
    m_filterAll = m_filterAll || changes.all;
    // After the search, which reads the boxes just set while they are still in the processor's cache.
    m_proxies.CompareFilters();
    if (m_proxies.HasChanges() || m_filterAll || m_filter != nullptr)
        UpdatePairs(changes, dispatcher);
    for (int i = 0; i < m_early.size(); i++)
        m_early[i]->state().addedPairs = false;
    m_early.resize(0);
    m_proxies.EndInterval();
    m_filterAll = false;
    ResetEarlyQueries();
    m_knownPairCount = m_cache->getNumOverlappingPairs();
}
