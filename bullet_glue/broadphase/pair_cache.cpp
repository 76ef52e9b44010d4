// Bullet's pair cache, with room for many new pairs at once.
#include "broadphase/pair_cache.h"

#include <algorithm>
#include <cstdint>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#include <unistd.h>
#endif

namespace
{
// Where so many times more pairs are added than there are.
constexpr int qc_fewKnown = 4;
constexpr int qc_maxCapacity = 1 << 28;
// Pairs whose buckets are compared with Bullet's: another hash differs for one of them.
constexpr int qc_checkedPairs = 32;

/// Maps the pages of fresh memory together. One by one, at their first use, they take 4 % more of the first search of
/// 160 000 boxes (`qc-bench broadphase --boxes 160000`, column "first").
void MapPages(void* memory, size_t size)
{
#ifdef MADV_POPULATE_WRITE
    const uintptr_t page = uintptr_t(sysconf(_SC_PAGESIZE)), start = reinterpret_cast<uintptr_t>(memory);
    const uintptr_t first = (start + page - 1) / page * page, end = (start + size) / page * page;
    // An older kernel refuses: the pages are then mapped one by one.
    if (first < end)
        (void)madvise(reinterpret_cast<void*>(first), end - first, MADV_POPULATE_WRITE);
#else
    (void)memory;
    (void)size;
#endif
}
} // namespace

qcPairCache::~qcPairCache()
{
    // Before their memory is freed.
    getOverlappingPairArray().clear();
    m_hashTable.clear();
    m_next.clear();
}

/// The bucket in which Bullet's own functions look for a pair.
int qcPairCache::BucketOf(const btBroadphaseProxy* a, const btBroadphaseProxy* b) const
{
    // Wang's hash of 32 bits.
    unsigned key = unsigned(std::min(a->m_uniqueId, b->m_uniqueId)) | unsigned(std::max(a->m_uniqueId, b->m_uniqueId))
                                                                          << 16;
    key += ~(key << 15);
    key ^= key >> 10;
    key += key << 3;
    key ^= key >> 6;
    key += ~(key << 11);
    key ^= key >> 16;
    return int(key & unsigned(m_hashTable.size() - 1));
}

/// True if each pair, from a given one on, is in its bucket. False: this version of Bullet uses another hash.
bool qcPairCache::KnowsBuckets(int first) const
{
    const btBroadphasePairArray& known = getOverlappingPairArray();
    for (int i = first; i < known.size(); i++)
    {
        int at = m_hashTable[BucketOf(known[i].m_pProxy0, known[i].m_pProxy1)];
        while (at != i && at != BT_NULL_PAIR)
            at = m_next[at];
        if (at != i)
            return false;
    }
    return true;
}

bool qcPairCache::ReserveMore(int count)
{
    btBroadphasePairArray& known = getOverlappingPairArray();
    FreeUnused();
    if (count > qc_maxCapacity / 2 || known.size() > count / qc_fewKnown)
        return false;
    // Bullet's tables have a power of two of entries.
    int capacity = m_hashTable.size();
    while (capacity < known.size() + count)
        capacity *= 2;
    if (capacity == m_hashTable.size())
        return true;
    if (!KnowsBuckets(0))
        return false;
    return Grow(capacity, known.size() + count);
}

/// Frees our memory once Bullet's own functions have moved the tables into larger memory.
void qcPairCache::FreeUnused()
{
    const bool used = m_pairSlots != nullptr && (getOverlappingPairArray().capacity() == m_capacity ||
                                                 m_hashTable.size() == m_capacity || m_next.size() == m_capacity);
    if (!used)
    {
        m_pairSlots.reset();
        m_links.reset();
    }
}

/// Moves the tables into larger memory, of which `soon` pairs are used soon. Returns false if there is none.
bool qcPairCache::Grow(int capacity, int soon)
{
    btBroadphasePairArray& known = getOverlappingPairArray();
    const int count = known.size();
    std::unique_ptr<PairSlot[]> slots(new (std::nothrow) PairSlot[size_t(capacity)]);
    std::unique_ptr<int[]> links(new (std::nothrow) int[2 * size_t(capacity)]);
    if (slots == nullptr || links == nullptr)
        return false;
    MapPages(slots.get(), size_t(soon) * sizeof(PairSlot));
    MapPages(links.get(), (size_t(capacity) + size_t(soon)) * sizeof(int));
    for (int i = 0; i < count; i++)
        new (&slots[size_t(i)]) btBroadphasePair(known[i]);
    std::fill_n(links.get(), capacity, BT_NULL_PAIR);
    known.initializeFromBuffer(slots.get(), count, capacity);
    m_hashTable.initializeFromBuffer(links.get(), capacity, capacity);
    m_next.initializeFromBuffer(links.get() + capacity, capacity, capacity);
    m_pairSlots.swap(slots);
    m_links.swap(links);
    m_capacity = capacity;
    for (int i = 0; i < count; i++)
    {
        int& first = m_hashTable[BucketOf(known[i].m_pProxy0, known[i].m_pProxy1)];
        m_next[i] = first;
        first = i;
    }
    return true;
}

bool qcPairCache::CanAppend()
{
    const int count = getNumOverlappingPairs();
    return m_ghostPairCallback == nullptr && getOverlapFilterCallback() == nullptr && count > 0 &&
           KnowsBuckets(std::max(0, count - qc_checkedPairs));
}

/// True if a pair is among those before index `end`.
bool qcPairCache::Holds(const Upcoming& pair, int end) const
{
    const btBroadphasePairArray& known = getOverlappingPairArray();
    const btBroadphasePair added(*pair.a, *pair.b);
    int at = end > 0 ? m_hashTable[pair.bucket] : BT_NULL_PAIR;
    // The youngest pairs are first in a bucket.
    while (at != BT_NULL_PAIR && (at >= end || !(known[at] == added)))
        at = m_next[at];
    return at != BT_NULL_PAIR;
}

void qcPairCache::Append(Upcoming* pairs, int count, int first)
{
    btBroadphasePairArray& known = getOverlappingPairArray();
    FetchBuckets(pairs, count);
    for (int i = 0; i < count; i++)
    {
        if (Holds(pairs[i], first))
            continue;
        const int index = known.size();
        new (&known.expandNonInitializing()) btBroadphasePair(*pairs[i].a, *pairs[i].b);
        m_next[index] = m_hashTable[pairs[i].bucket];
        m_hashTable[pairs[i].bucket] = index;
    }
}

void qcPairCache::FetchBuckets(Upcoming* pairs, int count) const
{
    for (int i = 0; i < count; i++)
    {
        pairs[i].bucket = BucketOf(pairs[i].a, pairs[i].b);
        __builtin_prefetch(&m_hashTable[pairs[i].bucket], 1);
    }
}

void qcPairCache::Fetch(Upcoming* pairs, int count) const
{
    const btBroadphasePairArray& known = getOverlappingPairArray();
    FetchBuckets(pairs, count);
    for (int i = 0; i < count; i++)
    {
        pairs[i].known = m_hashTable[pairs[i].bucket];
        if (pairs[i].known != BT_NULL_PAIR)
            __builtin_prefetch(&known[pairs[i].known]);
    }
    for (int i = 0; i < count; i++)
    {
        if (pairs[i].known == BT_NULL_PAIR)
            continue;
        __builtin_prefetch(&known[pairs[i].known].m_pProxy0->m_uniqueId);
        __builtin_prefetch(&known[pairs[i].known].m_pProxy1->m_uniqueId);
    }
}
