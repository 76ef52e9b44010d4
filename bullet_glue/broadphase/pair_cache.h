// Bullet's pair cache, with room for many new pairs at once.
#ifndef QC_GLUE_BROADPHASE_PAIR_CACHE_H
#define QC_GLUE_BROADPHASE_PAIR_CACHE_H

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>

#include <memory>

/// Holds the same pairs in the same order. Pairs of many new proxies lie anywhere in the tables, so that each addition
/// would wait for memory several times: the tables grow once, what additions read is fetched ahead, and pairs that are
/// known to be distinct are not compared. The first search of 160 000 boxes takes two thirds of the time that it takes
/// with one addition after another (`qc-bench broadphase --boxes 160000`, column "first").
class qcPairCache : public btHashedOverlappingPairCache
{
  public:
    /// A pair that is added soon.
    struct Upcoming
    {
        btBroadphaseProxy *a, *b;
        int bucket;
        int known; ///< a pair in its bucket, or BT_NULL_PAIR
    };

    ~qcPairCache() override;

    /// Makes room for so many more pairs, if there are few so far. Returns whether there is room for them.
    bool ReserveMore(int count);
    /// True if Append adds pairs as addOverlappingPair does: no callback is to be called, and Bullet's hash is known.
    bool CanAppend();
    /// Adds pairs that differ from each other and from all pairs from index `first` on. Their filters agree, and there
    /// is room for them.
    void Append(Upcoming* pairs, int count, int first);
    /// Fetches what their additions will read.
    void Fetch(Upcoming* pairs, int count) const;

  private:
    int BucketOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b) const;
    bool KnowsBuckets(int first) const;
    bool Holds(const Upcoming& pair, int end) const;
    void FetchBuckets(Upcoming* pairs, int count) const;
    bool Grow(int capacity, int soon);
    void FreeUnused();

    /// Memory for one pair, not cleared.
    struct alignas(btBroadphasePair) PairSlot
    {
        unsigned char bytes[sizeof(btBroadphasePair)];
    };

    // The memory of the tables, until Bullet's own functions make them larger. Bullet's allocator would clear all of
    // it, which is the first use of its pages.
    std::unique_ptr<PairSlot[]> m_pairSlots;
    std::unique_ptr<int[]> m_links; ///< of the hash table, then of m_next
    int m_capacity = 0;             ///< pairs for which that memory has room
};

#endif
