// Rigid objects near soft bodies by their keys: there may be thousands.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RIGID_INDEX_H
#define QC_GLUE_SOFT_BODY_SCENE_RIGID_INDEX_H

#include "common/object_key.h"
#include "soft_body/scene/scene_rigid.h"

#include <algorithm>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

class qcRigidIndex
{
  public:
    using Rigids = std::vector<std::unique_ptr<qcSceneRigid>>;

    /// Indexes a list without nulls. O(n log n).
    void Build(const Rigids& rigids)
    {
        m_entries.clear();
        for (size_t i = 0; i < rigids.size(); i++)
            m_entries.push_back({qcObjectKey(rigids[i]->object, rigids[i]->uniqueId), i});
        std::sort(m_entries.begin(), m_entries.end(),
                  [](const Entry& a, const Entry& b)
                  { return IsBefore(a.key, b.key) || (a.key == b.key && a.index < b.index); });
    }
    /// The first object with a key, in the order of the list, for which a function is true; null: there is none. Others
    /// may have been appended to the list since it was indexed, and some may have become null. O(log n).
    template <class List, class Test>
    auto Find(List& rigids, const qcObjectKey& key, const Test& test) const -> decltype(rigids.data())
    {
        auto entry = std::lower_bound(m_entries.begin(), m_entries.end(), key,
                                      [](const Entry& a, const qcObjectKey& b) { return IsBefore(a.key, b); });
        for (; entry != m_entries.end() && entry->key == key; ++entry)
            if (rigids[entry->index] != nullptr && test(*rigids[entry->index]))
                return &rigids[entry->index];
        return nullptr;
    }

  private:
    struct Entry
    {
        qcObjectKey key;
        size_t index; ///< in the list
    };

    static bool IsBefore(const qcObjectKey& a, const qcObjectKey& b)
    {
        return a.uniqueId != b.uniqueId ? a.uniqueId < b.uniqueId
                                        : std::less<const btCollisionObject*>()(a.object, b.object);
    }

    std::vector<Entry> m_entries; ///< by key, then by index
};

#endif
