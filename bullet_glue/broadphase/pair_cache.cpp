// Bullet's pair cache, with room for many new pairs at once.
#include "broadphase/pair_cache.h"

#include <algorithm>

namespace
{
// Where so many times more pairs are added than there are.
constexpr int qc_fewKnown = 4;
constexpr int qc_maxCapacity = 1 << 28;
} // namespace

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

/// Whether each pair is in its bucket. If it is not, this version of Bullet uses another hash.
bool qcPairCache::KnowsBuckets() const
{
    const btBroadphasePairArray& known = getOverlappingPairArray();
    for (int i = 0; i < known.size(); i++)
    {
        int at = m_hashTable[BucketOf(known[i].m_pProxy0, known[i].m_pProxy1)];
        while (at != i && at != BT_NULL_PAIR)
            at = m_next[at];
        if (at != i)
            return false;
    }
    return true;
}

void qcPairCache::ReserveMore(int count)
{
    btBroadphasePairArray& known = getOverlappingPairArray();
    if (count > qc_maxCapacity / 2 || known.size() > count / qc_fewKnown)
        return;
    // Bullet's tables have a power of two of entries.
    int capacity = m_hashTable.size();
    while (capacity < known.size() + count)
        capacity *= 2;
    if (capacity == m_hashTable.size() || !KnowsBuckets())
        return;
    known.reserve(capacity);
    m_hashTable.resizeNoInitialize(capacity);
    std::fill_n(&m_hashTable[0], capacity, BT_NULL_PAIR);
    m_next.resize(capacity, BT_NULL_PAIR);
    for (int i = 0; i < known.size(); i++)
    {
        int& first = m_hashTable[BucketOf(known[i].m_pProxy0, known[i].m_pProxy1)];
        m_next[i] = first;
        first = i;
    }
}

void qcPairCache::Fetch(Upcoming* pairs, int count) const
{
    const btBroadphasePairArray& known = getOverlappingPairArray();
    for (int i = 0; i < count; i++)
        __builtin_prefetch(&m_hashTable[BucketOf(pairs[i].a, pairs[i].b)]);
    for (int i = 0; i < count; i++)
    {
        pairs[i].known = m_hashTable[BucketOf(pairs[i].a, pairs[i].b)];
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
