// Disjoint sets of the numbers below a count. Tarjan: Efficiency of a good but not linear set union algorithm, 1975.
#ifndef QC_GLUE_COMMON_UNION_FIND_H
#define QC_GLUE_COMMON_UNION_FIND_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

class qcUnionFind
{
  public:
    /// Each number is a set of its own.
    void Reset(size_t count)
    {
        m_parents.resize(count);
        std::iota(m_parents.begin(), m_parents.end(), 0u);
    }

    /// Adds numbers up to a count, each a set of its own.
    void Grow(size_t count)
    {
        while (m_parents.size() < count)
            m_parents.push_back(uint32_t(m_parents.size()));
    }

    /// The representative of a number's set: its smallest number.
    uint32_t Find(uint32_t number)
    {
        while (m_parents[number] != number)
            number = m_parents[number] = m_parents[m_parents[number]];
        return number;
    }

    /// Unites the sets of two numbers. Returns the representative.
    uint32_t Unite(uint32_t a, uint32_t b)
    {
        a = Find(a);
        b = Find(b);
        return m_parents[std::max(a, b)] = std::min(a, b);
    }

  private:
    std::vector<uint32_t> m_parents;
};

#endif
