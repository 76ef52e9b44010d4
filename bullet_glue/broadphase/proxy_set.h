// The proxies of a broadphase: their memory, their list, their boxes in a qcBoxes, and which of them need a new query.
#ifndef QC_GLUE_BROADPHASE_PROXY_SET_H
#define QC_GLUE_BROADPHASE_PROXY_SET_H

#include "broadphase/proxy.h"
#include "common/id_counter.h"

/// A proxy's box in the set has NaN bounds opened to infinity and inverted ones put in order. It then overlaps every
/// box that TestAabbAgainstAabb2 lets the proxy overlap: a comparison with NaN is never true there, and an inverted box
/// overlaps another one there only if the other one contains it. Results of the set are therefore filtered by
/// TestAabbAgainstAabb2.
class qcProxySet
{
  public:
    /// A proxy, and its filter when it was last compared.
    struct Entry
    {
        qcProxy* proxy;
        uint64_t filter; ///< group and mask
    };

    qcProxySet() = default;
    qcProxySet(const qcProxySet&) = delete;
    qcProxySet& operator=(const qcProxySet&) = delete;
    ~qcProxySet();

    /// Creates a proxy that is not listed yet. Null if there is no memory; getStatus then reports it.
    qcProxy* Create(const btVector3& aabbMin, const btVector3& aabbMax, void* userPtr, int group, int mask);
    /// Adds a proxy to the list and, if there is memory, its box to the set.
    void List(qcProxy* proxy);
    void Free(qcProxy* proxy);
    void Move(qcProxy* proxy, const btVector3& aabbMin, const btVector3& aabbMax);
    /// Adds the proxy to those with pending changes.
    void Pend(qcProxy* proxy);
    /// Removes a proxy from those with pending changes and returns it. Null: none is left.
    qcProxy* TakePending();
    /// Clears the set of boxes. Call it only without proxies.
    void Reset();

    /// Marks the proxy: the next search queries all its pairs again.
    void Requery(qcProxy* proxy);
    /// True if the proxy's pairs must be queried: the changes between boxes don't determine them.
    bool NeedsQuery(const qcProxy* proxy) const;
    /// Compares the filter of a proxy whose box is set. A world sets boxes in the order in which its objects were
    /// added, which is the order of the list: the proxy's entry is then found without its state.
    void CompareFilterOf(const qcProxy* proxy);
    /// Compares the filters of proxies whose boxes were not set: of all, or of the next c_comparedAtOnce in turn.
    void CompareFilters();
    void CompareAllFilters();
    /// Adds to the set the boxes for which there was no memory.
    void AddMissingBoxes();
    /// The changes of overlaps since the last search. On failure everything counts as changed.
    qcBoxChanges FindChanges();
    /// Ends the interval between two searches.
    void EndInterval();

    /// Calls visit(qcProxy*) for each proxy whose box overlaps the given one. A box that reaches to Bullet's largest
    /// number on all sides gets them in the order of the list, without the tree.
    template <class Visit> void VisitBox(const btVector3& aabbMin, const btVector3& aabbMax, Visit visit) const;
    /// Calls visit(qcProxy*) for each proxy that is not in the set of boxes.
    template <class Visit> void VisitOutside(Visit visit) const;
    /// The smallest box around all proxies; zeros when there are none.
    void GetBounds(double lower[3], double upper[3]) const;

    qcProxy* At(int index) const
    {
        return m_entries[index].proxy;
    }
    /// Group and mask (qcFilterOf) when they were last compared.
    uint64_t FilterAt(int index) const
    {
        return m_entries[index].filter;
    }
    int GetCount() const
    {
        return m_count;
    }
    qcProxy* OfBox(uint32_t box) const
    {
        return static_cast<qcProxy*>(qcBoxes_GetUserData(m_boxes, box));
    }
    qcBoxes* GetBoxes() const
    {
        return m_boxes;
    }
    /// Proxies without a box in the set.
    int GetOutsideCount() const
    {
        return m_outsideCount;
    }
    /// True if some proxies' overlaps differ from those of their boxes in the set.
    bool HasExceptions() const
    {
        return m_invalidCount > 0 || m_outsideCount > 0;
    }
    bool HasRequeries() const
    {
        return m_requeried;
    }
    bool HasChanges() const
    {
        return m_changed;
    }
    qcStatus GetStatus() const
    {
        return m_status;
    }
    void ClearStatus()
    {
        m_status = qc_statusOk;
    }

  private:
    /// Reading the filter of a resting object takes 3 to 7 ns, since it is not in the processor's cache: 30 us at most.
    static constexpr int c_comparedAtOnce = 4096;

    void CompareFilter(Entry& entry);
    void CompareFilterRange(int first, int end);
    void CompareFiltersFrom(int first, int end);
    bool Grow();
    int TakeUniqueId();
    void AddBox(qcProxy* proxy);
    void SetInvalid(qcProxy* proxy, bool invalid);

    qcBoxes* m_boxes = nullptr;
    qcStatus m_status = qc_statusOk;
    qcProxyBlock* m_blocks = nullptr; ///< allocations
    qcProxySlot* m_freeSlots = nullptr;
    int m_slotCount = 0;
    Entry* m_entries = nullptr; ///< with room for m_slotCount
    int m_count = 0;
    int m_comparedCount = 0; ///< leading entries whose filters were compared since the last search
    int m_nextCompared = 0;  ///< the entry whose turn it is in the next search
    int m_outsideCount = 0;
    int m_invalidCount = 0; ///< proxies whose bounds are NaN or inverted
    qcIdCounter m_uniqueIds{INT32_MAX};
    qcProxy* m_pending = nullptr;
    long long m_interval = 1; ///< number of the current interval between two searches
    bool m_changed = false, m_requeried = false;
};

/// Queries all pairs of the proxy again if its filter has changed.
inline void qcProxySet::CompareFilter(Entry& entry)
{
    if (entry.filter == qcFilterOf(entry.proxy))
        return;
    entry.filter = qcFilterOf(entry.proxy);
    Requery(entry.proxy);
}

inline void qcProxySet::CompareFilterOf(const qcProxy* proxy)
{
    if (m_comparedCount < m_count && m_entries[m_comparedCount].proxy == proxy)
    {
        CompareFilter(m_entries[m_comparedCount++]);
        return;
    }
    const int index = proxy->state().index;
    CompareFilter(m_entries[index]);
    // Boxes are set a second time: filters may have changed in between.
    if (index < m_comparedCount)
        m_comparedCount = index == 0 ? 1 : 0;
}

inline bool qcProxySet::NeedsQuery(const qcProxy* proxy) const
{
    const qcProxyState& state = proxy->state();
    return state.queryInterval == m_interval || state.invalidAabb || state.box == qc_noBox;
}

template <class Visit> void qcProxySet::VisitOutside(Visit visit) const
{
    for (int i = 0; m_outsideCount > 0 && i < m_count; i++)
        if (m_entries[i].proxy->state().box == qc_noBox)
            visit(m_entries[i].proxy);
}

template <class Visit> void qcProxySet::VisitBox(const btVector3& aabbMin, const btVector3& aabbMax, Visit visit) const
{
    auto test = [&](qcProxy* proxy)
    {
        if (!proxy->state().destroyed && TestAabbAgainstAabb2(proxy->m_aabbMin, proxy->m_aabbMax, aabbMin, aabbMax))
            visit(proxy);
    };
    if (qcHoldsWorld(aabbMin, aabbMax))
    {
        for (int i = 0, count = m_count; i < count; i++)
            test(m_entries[i].proxy);
        return;
    }
    auto function = [](uint32_t, void* proxy, void* context)
    {
        (*static_cast<decltype(test)*>(context))(static_cast<qcProxy*>(proxy));
        return true;
    };
    const double lower[3] = {double(aabbMin[0]), double(aabbMin[1]), double(aabbMin[2])};
    const double upper[3] = {double(aabbMax[0]), double(aabbMax[1]), double(aabbMax[2])};
    qcBoxes_QueryBox(m_boxes, lower, upper, function, &test);
    VisitOutside(test);
}

#endif
