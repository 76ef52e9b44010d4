// Values by key, by open addressing. Memory is reused: cuts fill thousands of small tables.
#ifndef QC_GLUE_COMMON_HASH_TABLE_H
#define QC_GLUE_COMMON_HASH_TABLE_H

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

inline uint64_t qcMixHash(uint64_t hash, uint64_t bits)
{
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 32;
}

inline uint64_t qcHashOf(uint64_t key)
{
    return qcMixHash(0, key);
}

/// Positions that compare equal have the same hash.
inline uint64_t qcHashOf(const std::array<double, 3>& point)
{
    uint64_t hash = 0;
    for (double x : point)
    {
        x += 0.0; // -0 becomes +0, which compares equal
        uint64_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        hash = qcMixHash(hash, bits);
    }
    return hash;
}

template <typename Key, typename Value> class qcHashTable
{
  public:
    struct Entry
    {
        Key key;
        Value value;
    };

    /// Empties the table and makes room for a number of keys. Further keys make it grow.
    void Clear(size_t expected)
    {
        m_entries.clear();
        size_t size = 16;
        while (size <= 2 * expected)
            size *= 2;
        Rehash(size);
    }

    /// The value of a key. A key without one is added with the value given here. Valid until the next call.
    Value& FindOrAdd(const Key& key, Value value)
    {
        if (2 * m_entries.size() >= m_size)
            Rehash(std::max<size_t>(16, 4 * m_size));
        uint32_t& slot = SlotOf(key);
        if (slot == 0)
        {
            m_entries.push_back({key, value});
            slot = uint32_t(m_entries.size());
        }
        return m_entries[slot - 1].value;
    }

    /// The value of a key; null: it has none. Valid until the next call of FindOrAdd or Clear.
    const Value* Find(const Key& key) const
    {
        uint32_t slot = m_size > 0 ? m_slots[FindSlot(key)] : 0;
        return slot != 0 ? &m_entries[slot - 1].value : nullptr;
    }

    Value* Find(const Key& key)
    {
        return const_cast<Value*>(static_cast<const qcHashTable*>(this)->Find(key));
    }

    /// In the order in which they were added.
    const std::vector<Entry>& Entries() const
    {
        return m_entries;
    }

  private:
    size_t FindSlot(const Key& key) const
    {
        size_t mask = m_size - 1, slot = qcHashOf(key) & mask;
        while (m_slots[slot] != 0 && m_entries[m_slots[slot] - 1].key != key)
            slot = (slot + 1) & mask;
        return slot;
    }

    uint32_t& SlotOf(const Key& key)
    {
        return m_slots[FindSlot(key)];
    }

    void Rehash(size_t size)
    {
        m_size = size;
        m_slots.resize(std::max(m_slots.size(), m_size));
        std::fill_n(m_slots.begin(), m_size, 0u);
        for (size_t i = 0; i < m_entries.size(); i++)
            SlotOf(m_entries[i].key) = uint32_t(i + 1);
    }

    std::vector<Entry> m_entries;
    std::vector<uint32_t> m_slots; ///< 0, or one more than the index of an entry
    size_t m_size = 0;             ///< slots in use: a power of two, at least twice the entries
};

#endif
