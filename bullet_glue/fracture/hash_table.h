// Numbers by key, by open addressing. Cuts fill thousands of small tables: memory is kept from one to the next.
#ifndef QC_GLUE_FRACTURE_HASH_TABLE_H
#define QC_GLUE_FRACTURE_HASH_TABLE_H

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

template <typename Key, typename Number> class qcClipTable
{
  public:
    struct Entry
    {
        Key key;
        Number number;
    };

    /// Makes room for a number of keys. More may come, which takes longer.
    void Clear(size_t expected)
    {
        m_entries.clear();
        size_t used = 16;
        while (used <= 2 * expected)
            used *= 2;
        Spread(used);
    }

    /// The number of a key; the one given here if it has none yet. Valid until the next call.
    Number& FindOrAdd(const Key& key, Number number)
    {
        if (2 * m_entries.size() >= m_used)
            Spread(std::max<size_t>(16, 4 * m_used));
        uint32_t& slot = SlotOf(key);
        if (slot == 0)
        {
            m_entries.push_back({key, number});
            slot = uint32_t(m_entries.size());
        }
        return m_entries[slot - 1].number;
    }

    /// As they were added.
    const std::vector<Entry>& Entries() const
    {
        return m_entries;
    }

  private:
    uint32_t& SlotOf(const Key& key)
    {
        size_t mask = m_used - 1, place = qcHashOf(key) & mask;
        while (m_slots[place] != 0 && m_entries[m_slots[place] - 1].key != key)
            place = (place + 1) & mask;
        return m_slots[place];
    }

    void Spread(size_t used)
    {
        m_used = used;
        m_slots.resize(std::max(m_slots.size(), m_used));
        std::fill_n(m_slots.begin(), m_used, 0u);
        for (size_t i = 0; i < m_entries.size(); i++)
            SlotOf(m_entries[i].key) = uint32_t(i + 1);
    }

    std::vector<Entry> m_entries;
    std::vector<uint32_t> m_slots; ///< 0, or one more than an entry
    size_t m_used = 0;             ///< of the slots, a power of two of them, half empty at least
};

#endif
