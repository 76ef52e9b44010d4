// Keeps a Bullet pair cache equal to "boxes overlap and filters agree".
#ifndef QC_GLUE_BROADPHASE_PAIR_CACHE_SYNC_H
#define QC_GLUE_BROADPHASE_PAIR_CACHE_SYNC_H

#include "broadphase/pair_cache.h"
#include "broadphase/proxy_set.h"
#include "common/object_key.h"

#include <atomic>

/// Applies the changes of overlaps that the set of boxes reports. Invariant: a pair that overlapped at the last search
/// and still does is in the cache, or was rejected by groups and masks that have not changed since. Where the invariant
/// may be broken, all pairs are filtered again: someone else changed the cache, a filter changed, there is a filter
/// callback, the cache defers removal, or a proxy has invalid bounds.
///
/// Callbacks may create, move and destroy proxies. While an iteration runs (IterationGuard) such changes are pending.
class qcPairCacheSync
{
  public:
    /// Null: makes a btHashedOverlappingPairCache and owns it.
    explicit qcPairCacheSync(btOverlappingPairCache* cache);
    qcPairCacheSync(const qcPairCacheSync&) = delete;
    qcPairCacheSync& operator=(const qcPairCacheSync&) = delete;
    ~qcPairCacheSync();

    /// The proxies. Stored by value: setAabb accesses them without one more pointer.
    qcProxySet& GetProxies()
    {
        return m_proxies;
    }
    const qcProxySet& GetProxies() const
    {
        return m_proxies;
    }
    btOverlappingPairCache* GetCache() const
    {
        return m_cache;
    }
    bool IsIterating() const
    {
        return m_iterations > 0;
    }
    /// Lists a new proxy and adds its pairs; its changes are pending while an iteration runs.
    void Add(qcProxy* proxy);
    void Move(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax);
    /// Removes the proxy's pairs, and frees it now or at the end of the last iteration.
    void Destroy(qcProxy* proxy, btDispatcher* dispatcher);
    /// Brings the cache up to date.
    void Update(btDispatcher* dispatcher);
    /// Allows the next few proxies that change to get their pairs before the search.
    void ResetEarlyQueries();

    /// True if a filter callback decided in the last search.
    bool HasFilterCallback() const
    {
        return m_filter != nullptr;
    }
    /// Calls visit(a, b) for each overlapping pair that the filter callback rejected in the last search.
    template <class Visit> void VisitRejected(Visit visit) const
    {
        for (int i = 0; i < m_rejected.size(); i += 2)
            visit(m_rejected[i], m_rejected[i + 1]);
    }

    /// While one lives, the set of proxies stays as it is.
    class IterationGuard
    {
      public:
        explicit IterationGuard(qcPairCacheSync& sync) : m_sync(sync)
        {
            ++m_sync.m_iterations;
        }
        ~IterationGuard()
        {
            if (--m_sync.m_iterations == 0)
                m_sync.ApplyPending();
        }
        IterationGuard(const IterationGuard&) = delete;
        IterationGuard& operator=(const IterationGuard&) = delete;

      private:
        qcPairCacheSync& m_sync;
    };

  private:
    using Pairs = btAlignedObjectArray<qcProxy*>; ///< two entries a pair

    /// New pairs that are added together, and whose memory is fetched ahead.
    static constexpr int qc_fetchedPairs = 32;
    struct UpcomingPairs
    {
        qcPairCache::Upcoming pair[qc_fetchedPairs];
        int count;
    };

    /// True if the proxy waits to be freed. Mostly none does, and no state is read.
    bool IsDestroyed(const qcProxy* proxy) const
    {
        return m_destroyedCount != 0 && proxy->state().destroyed;
    }
    void PendMove(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax);
    void MoveNow(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax);
    void Free(qcProxy* proxy);
    void ApplyPending();
    static void RemoveFrom(Pairs& pairs, const qcProxy* proxy);
    bool AddIfAccepted(qcProxy* a, qcProxy* b);
    void AddEarlyPair(qcProxy* a, qcProxy* b);
    void AddEarlyPairs(qcProxy* proxy);
    void Reject(qcProxy* a, qcProxy* b);
    void TestPair(qcProxy* a, qcProxy* b);
    void FindForeignChanges();
    void FilterRejected();
    void QueryPairs();
    void AddBegun(const qcBoxChanges& changes);
    void FetchProxies(const qcBoxChanges& changes, size_t first, UpcomingPairs& pairs) const;
    void AddFetched(UpcomingPairs& pairs);
    void AppendFetched(UpcomingPairs& pairs, int known);
    bool IsNew(const qcProxy* a, const qcProxy* b) const;
    void RemoveEnded(const qcBoxChanges& changes, btDispatcher* dispatcher);
    void UpdatePairs(const qcBoxChanges& changes, btDispatcher* dispatcher);
    bool IsAccepted(const btBroadphasePair& pair);
    void RemovePair(int index, btDispatcher* dispatcher);
    void RemovePairs(btDispatcher* dispatcher);
    void RemoveDuplicates();

    qcProxySet m_proxies;
    btOverlappingPairCache* m_cache;
    bool m_ownsCache;
    std::atomic<int> m_iterations{0}; ///< queries and searches that are running
    unsigned m_destroyCount = 0;      ///< Destroy calls: a loop over pairs notices removed pairs by a change
    int m_destroyedCount = 0;         ///< proxies that are freed at the end of the last iteration
    bool m_querying = false;          ///< the pairs of some proxies are queried again
    bool m_filterAll = false;         ///< all pairs are queried and filtered again
    int m_earlyQueries;               ///< proxies left whose pairs are added before the search
    int m_knownPairCount = 0;         ///< size of the cache after our last change
    const btOverlapFilterCallback* m_filter = nullptr;
    Pairs m_rejected; ///< while there is a filter callback: overlapping pairs that it rejected
    Pairs m_found;    ///< scratch: overlapping proxies of one whose pairs are added before the search
    Pairs m_early;    ///< pairs added to the cache since the last search, the lower id first
};

// Inline up to the comparison of boxes: most boxes that a world sets are unchanged.
inline void qcPairCacheSync::Move(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax)
{
    if (IsIterating())
    {
        PendMove(proxy, aabbMin, aabbMax);
        return;
    }
    m_proxies.CompareFilterOf(proxy);
    if (!qcAreSame(aabbMin, proxy->m_aabbMin) || !qcAreSame(aabbMax, proxy->m_aabbMax))
        MoveNow(proxy, aabbMin, aabbMax);
}

#endif
