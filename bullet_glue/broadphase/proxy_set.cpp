// The proxies of a broadphase.
#include "broadphase/proxy_set.h"

#include <LinearMath/btAlignedAllocator.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

namespace
{
/// Returns false if the bounds are NaN or inverted somewhere.
bool Order(const btVector3& aabbMin, const btVector3& aabbMax, double lower[3], double upper[3])
{
    bool ordered = true;
    for (int k = 0; k < 3; k++)
    {
        lower[k] = double(aabbMin[k]);
        upper[k] = double(aabbMax[k]);
        ordered = ordered && lower[k] <= upper[k];
    }
    for (int k = 0; k < 3 && !ordered; k++)
    {
        if (std::isnan(lower[k]))
            lower[k] = -std::numeric_limits<double>::infinity();
        if (std::isnan(upper[k]))
            upper[k] = std::numeric_limits<double>::infinity();
        if (lower[k] > upper[k])
            std::swap(lower[k], upper[k]);
    }
    return ordered;
}
} // namespace

qcProxySet::~qcProxySet()
{
    btAlignedFree(m_entries);
    while (m_blocks != nullptr)
    {
        qcProxyBlock* block = m_blocks;
        m_blocks = block->next;
        btAlignedFree(block);
    }
    qcBoxes_Destroy(m_boxes);
}

//  ---- memory ----------------------------------------------------------------------------------------

/// Grows by half as many slots. Returns false if there is no memory.
bool qcProxySet::Grow()
{
    const int perBlock = int(qcProxyBlock::c_slotCount), blockCount = 1 + m_slotCount / perBlock / 2;
    const int slotCount = m_slotCount + blockCount * perBlock;
    qcProxyBlock* blocks =
        static_cast<qcProxyBlock*>(btAlignedAlloc(sizeof(qcProxyBlock) * size_t(blockCount), alignof(qcProxyBlock)));
    Entry* entries = static_cast<Entry*>(btAlignedAlloc(sizeof(Entry) * size_t(slotCount), alignof(Entry)));
    if (blocks == nullptr || entries == nullptr)
    {
        btAlignedFree(blocks);
        btAlignedFree(entries);
        return false;
    }
    std::copy(m_entries, m_entries + m_count, entries);
    btAlignedFree(m_entries);
    m_entries = entries;
    blocks->next = m_blocks;
    m_blocks = blocks;
    m_slotCount = slotCount;
    // The first slot on top, so that proxies created one after another are adjacent in memory.
    for (int i = blockCount * perBlock; i-- > 0;)
    {
        qcProxySlot* slot = new (blocks[i / perBlock].slots + sizeof(qcProxySlot) * size_t(i % perBlock)) qcProxySlot;
        slot->nextFree = m_freeSlots;
        m_freeSlots = slot;
    }
    return true;
}

/// An id that no proxy has: Bullet's pair caches compare proxies by their ids. 0: there is no memory.
int qcProxySet::TakeUniqueId()
{
    auto visitIds = [this](auto add)
    {
        for (int i = 0; i < m_count; i++)
            add(uint32_t(m_entries[i].proxy->m_uniqueId));
        // Those that are not listed yet.
        for (const qcProxy* proxy = m_pending; proxy != nullptr; proxy = proxy->state().nextPending)
            if (proxy->state().index < 0)
                add(uint32_t(proxy->m_uniqueId));
    };
    try
    {
        return int(m_uniqueIds.Take(visitIds));
    }
    catch (const std::bad_alloc&)
    {
        return 0;
    }
}

qcProxy* qcProxySet::Create(const btVector3& aabbMin, const btVector3& aabbMax, void* userPtr, int group, int mask)
{
    const int id = m_freeSlots != nullptr || Grow() ? TakeUniqueId() : 0;
    if (id == 0)
    {
        m_status = qcFail(qc_statusOutOfMemory, "qcBroadphase::createProxy: out of memory");
        return nullptr;
    }
    qcProxySlot* slot = m_freeSlots;
    m_freeSlots = slot->nextFree;
    qcProxy* proxy = new (slot) qcProxy(aabbMin, aabbMax, userPtr, group, mask);
    new (&proxy->state()) qcProxyState;
    proxy->m_uniqueId = id;
    return proxy;
}

void qcProxySet::Free(qcProxy* proxy)
{
    if (proxy->state().index >= 0)
    {
        m_comparedCount = std::min(m_comparedCount, proxy->state().index);
        m_entries[proxy->state().index] = m_entries[--m_count];
        m_entries[proxy->state().index].proxy->state().index = proxy->state().index;
        SetInvalid(proxy, false);
        if (proxy->state().box == qc_noBox)
            m_outsideCount--;
        else
            qcBoxes_Remove(m_boxes, proxy->state().box);
    }
    qcProxySlot* slot = new (proxy) qcProxySlot;
    slot->nextFree = m_freeSlots;
    m_freeSlots = slot;
}

void qcProxySet::Reset()
{
    // Ids go on: those of proxies that are gone may still be keys of what is known of their objects.
    qcBoxes_Clear(m_boxes);
}

//  ---- boxes -----------------------------------------------------------------------------------------

void qcProxySet::List(qcProxy* proxy)
{
    proxy->state().index = m_count;
    m_entries[m_count++] = {proxy, qcFilterOf(proxy)};
    m_outsideCount++;
    m_changed = true;
    AddBox(proxy);
}

void qcProxySet::AddBox(qcProxy* proxy)
{
    double lower[3], upper[3];
    SetInvalid(proxy, !Order(proxy->m_aabbMin, proxy->m_aabbMax, lower, upper));
    qcStatus status = m_boxes != nullptr ? qc_statusOk : qcBoxes_Create(&m_boxes);
    if (status == qc_statusOk)
        status = qcBoxes_Add(m_boxes, lower, upper, proxy, &proxy->state().box);
    if (status == qc_statusOk)
        m_outsideCount--;
    else
        m_status = status;
}

void qcProxySet::AddMissingBoxes()
{
    VisitOutside(
        [&](qcProxy* proxy)
        {
            AddBox(proxy);
            // The set has no record of what the box overlapped before.
            Requery(proxy);
        });
}

void qcProxySet::SetInvalid(qcProxy* proxy, bool invalid)
{
    m_invalidCount += int(invalid) - int(proxy->state().invalidAabb);
    proxy->state().invalidAabb = invalid;
}

void qcProxySet::Move(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax)
{
    m_changed = true;
    double lower[3], upper[3];
    proxy->m_aabbMin = aabbMin;
    proxy->m_aabbMax = aabbMax;
    bool invalid = !Order(aabbMin, aabbMax, lower, upper);
    // The box in the set may stay the same although the overlaps change.
    if (invalid || proxy->state().invalidAabb)
    {
        Requery(proxy);
        SetInvalid(proxy, invalid);
    }
    if (proxy->state().box != qc_noBox)
        qcBoxes_Move(m_boxes, proxy->state().box, lower, upper);
}

void qcProxySet::GetBounds(double lower[3], double upper[3]) const
{
    qcBoxes_GetTotalBounds(m_boxes, lower, upper);
    bool any = qcBoxes_GetCount(m_boxes) > 0;
    VisitOutside(
        [&](const qcProxy* proxy)
        {
            double proxyLower[3], proxyUpper[3];
            Order(proxy->m_aabbMin, proxy->m_aabbMax, proxyLower, proxyUpper);
            for (int k = 0; k < 3; k++)
            {
                lower[k] = any ? std::min(lower[k], proxyLower[k]) : proxyLower[k];
                upper[k] = any ? std::max(upper[k], proxyUpper[k]) : proxyUpper[k];
            }
            any = true;
        });
}

//  ---- changes ---------------------------------------------------------------------------------------

void qcProxySet::Pend(qcProxy* proxy)
{
    if (proxy->state().pending)
        return;
    proxy->state().pending = true;
    proxy->state().nextPending = m_pending;
    m_pending = proxy;
}

qcProxy* qcProxySet::TakePending()
{
    qcProxy* proxy = m_pending;
    if (proxy == nullptr)
        return nullptr;
    m_pending = proxy->state().nextPending;
    proxy->state().pending = false;
    return proxy;
}

void qcProxySet::Requery(qcProxy* proxy)
{
    m_changed = m_requeried = true;
    proxy->state().queryInterval = m_interval;
}

// Not inlined: its registers would be spilled in the loop that finds nothing, which took a quarter longer.
[[gnu::noinline]] void qcProxySet::CompareFilterRange(int first, int end)
{
    for (int i = first; i < end; i++)
        CompareFilter(m_entries[i]);
}

/// Looks at several entries together: nearly all are unchanged.
void qcProxySet::CompareFiltersFrom(int first, int end)
{
    constexpr int atOnce = 8;
    int i = first;
    for (; i + atOnce <= end; i += atOnce)
    {
        const Entry* entries = &m_entries[i];
        uint64_t differ = 0;
        for (int j = 0; j < atOnce; j++)
            differ |= entries[j].filter ^ qcFilterOf(entries[j].proxy);
        if (differ != 0)
            CompareFilterRange(i, i + atOnce);
    }
    CompareFilterRange(i, end);
}

void qcProxySet::CompareAllFilters()
{
    CompareFiltersFrom(m_comparedCount, m_count);
    m_comparedCount = m_count;
}

void qcProxySet::CompareFilters()
{
    if (m_count - m_comparedCount <= c_comparedAtOnce)
    {
        CompareAllFilters();
        return;
    }
    if (m_nextCompared < m_comparedCount || m_nextCompared >= m_count)
        m_nextCompared = m_comparedCount;
    const int end = std::min(m_nextCompared + c_comparedAtOnce, m_count);
    CompareFiltersFrom(m_nextCompared, end);
    m_nextCompared = end;
}

qcBoxChanges qcProxySet::FindChanges()
{
    BT_PROFILE("qcBroadphase search");
    qcBoxChanges changes = {};
    qcStatus status = m_boxes != nullptr ? qcBoxes_FindChangedPairs(m_boxes, &changes) : qc_statusOk;
    if (status == qc_statusOk)
        return changes;
    m_status = status;
    changes = {};
    changes.all = true;
    return changes;
}

void qcProxySet::EndInterval()
{
    m_interval++;
    m_comparedCount = 0;
    m_changed = m_requeried = false;
}
