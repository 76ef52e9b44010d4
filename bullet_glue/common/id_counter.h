// Numbers for objects that come and go: no two objects have the same one at a time, however many there have been.
#ifndef QC_GLUE_COMMON_ID_COUNTER_H
#define QC_GLUE_COMMON_ID_COUNTER_H

#include <algorithm>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

class qcIdCounter
{
  public:
    /// Numbers from 1 to `max`.
    explicit qcIdCounter(uint32_t max = UINT32_MAX) : m_max(std::min(max, s_max))
    {
    }
    /// The next number. After the largest one they start again from 1, without those in use: `visit(add)` then calls
    /// add(number) for each of these, and 0 for objects that have none yet. O(1), but for that. std::bad_alloc leaves
    /// the counter as it was.
    template <class Visit> uint32_t Take(Visit visit)
    {
        for (;;)
        {
            if (m_last == m_max)
                Restart(visit);
            m_last++;
            while (!m_inUse.empty() && m_inUse.back() < m_last)
                m_inUse.pop_back();
            if (m_inUse.empty() || m_inUse.back() != m_last)
                return m_last;
        }
    }

    /// The largest number of all new counters. The tests lower it.
    static inline uint32_t s_max = UINT32_MAX;

  private:
    template <class Visit> void Restart(Visit visit)
    {
        std::vector<uint32_t> inUse;
        visit([&inUse](uint32_t number) { inUse.push_back(number); });
        std::sort(inUse.begin(), inUse.end(), std::greater<uint32_t>());
        m_inUse = std::move(inUse);
        m_last = 0;
    }

    uint32_t m_max, m_last = 0;
    std::vector<uint32_t> m_inUse; ///< when the numbers started again, those not yet passed; the lowest last
};

#endif
