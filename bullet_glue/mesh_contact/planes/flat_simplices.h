// Triangles or edges as seen along a plane's normal, in vectors. Many are sorted along one axis of the plane.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_FLAT_SIMPLICES_H
#define QC_GLUE_MESH_CONTACT_PLANES_FLAT_SIMPLICES_H

#include "common/lanes.h"

#include <algorithm>
#include <utility>
#include <vector>

/// A point in the frame of a plane: two coordinates along it, and its height.
struct qcFlat
{
    btScalar u, v, height;
};

/// Simplices of 2 or 3 corners. Keeps its memory.
template <size_t cornerCount> class qcFlatSimplices
{
  public:
    /// Corners of some simplices, one a lane. All corners of a lane without a simplex are the same.
    struct Block
    {
        qcLanes u[cornerCount], v[cornerCount], height[cornerCount];
    };

    void Clear()
    {
        m_count = 0;
        m_blocks.clear();
        m_triangles.clear();
        m_numbers.clear();
        m_lows.clear();
    }

    /// `triangle`: of the mesh, that or next to the simplex.
    void Add(const qcFlat (&corners)[cornerCount], uint32_t triangle)
    {
        if (m_count % qcLaneCount == 0)
            m_blocks.emplace_back();
        Block& block = m_blocks.back();
        for (size_t c = 0; c < cornerCount; c++)
        {
            block.u[c][m_count % qcLaneCount] = corners[c].u;
            block.v[c][m_count % qcLaneCount] = corners[c].v;
            block.height[c][m_count % qcLaneCount] = corners[c].height;
        }
        m_triangles.push_back(triangle);
        m_count++;
    }

    /// Call it after the last Add, and before FindBlocks. O(n log n).
    void Sort();

    /// Numbers of the blocks, from the first up to before the second, that hold all simplices of which the coordinate
    /// along the first axis is between two bounds somewhere. O(log n).
    std::pair<size_t, size_t> FindBlocks(btScalar low, btScalar high) const
    {
        if (m_lows.empty())
            return {0, m_blocks.size()};
        auto first = std::lower_bound(m_lows.begin(), m_lows.end(), low - m_widest);
        auto last = std::upper_bound(first, m_lows.end(), high);
        return {size_t(first - m_lows.begin()) / qcLaneCount,
                (size_t(last - m_lows.begin()) + qcLaneCount - 1) / qcLaneCount};
    }

    size_t Count() const
    {
        return m_count;
    }
    const Block& At(size_t block) const
    {
        return m_blocks[block];
    }
    /// A corner of a simplex, by its number in the order of Add. Only before Sort.
    qcFlat CornerAt(uint32_t number, size_t corner) const
    {
        const Block& block = m_blocks[number / qcLaneCount];
        const size_t lane = number % qcLaneCount;
        return {block.u[corner][lane], block.v[corner][lane], block.height[corner][lane]};
    }
    /// The number, in the order of Add, of the simplex in a lane.
    uint32_t NumberAt(size_t block, size_t lane) const
    {
        size_t place = block * qcLaneCount + lane;
        return m_numbers.empty() ? uint32_t(place) : m_numbers[place];
    }
    uint32_t TriangleOf(uint32_t number) const
    {
        return m_triangles[number];
    }

  private:
    // So few are compared all.
    static constexpr size_t s_few = 64;

    size_t m_count = 0;
    std::vector<Block> m_blocks, m_unsorted;
    std::vector<uint32_t> m_triangles; ///< in the order of Add
    std::vector<uint32_t> m_numbers;   ///< of what the blocks hold; none: in the order of Add
    std::vector<btScalar> m_lows;      ///< the lowest first coordinates, sorted; none: likewise
    btScalar m_widest = 0;             ///< along the first axis
};

template <size_t cornerCount> void qcFlatSimplices<cornerCount>::Sort()
{
    if (m_count <= s_few)
        return;
    m_unsorted.swap(m_blocks);
    m_widest = 0;
    std::vector<std::pair<btScalar, uint32_t>> order;
    order.reserve(m_count);
    for (uint32_t i = 0; i < m_count; i++)
    {
        const Block& block = m_unsorted[i / qcLaneCount];
        btScalar low = block.u[0][i % qcLaneCount], high = low;
        for (size_t c = 1; c < cornerCount; c++)
        {
            low = std::min(low, btScalar(block.u[c][i % qcLaneCount]));
            high = std::max(high, btScalar(block.u[c][i % qcLaneCount]));
        }
        m_widest = std::max(m_widest, high - low);
        order.emplace_back(low, i);
    }
    std::sort(order.begin(), order.end());
    m_blocks.assign(m_unsorted.size(), Block());
    for (size_t i = 0; i < m_count; i++)
    {
        const size_t from = order[i].second % qcLaneCount, to = i % qcLaneCount;
        const Block& unsorted = m_unsorted[order[i].second / qcLaneCount];
        Block& block = m_blocks[i / qcLaneCount];
        for (size_t c = 0; c < cornerCount; c++)
        {
            block.u[c][to] = unsorted.u[c][from];
            block.v[c][to] = unsorted.v[c][from];
            block.height[c][to] = unsorted.height[c][from];
        }
        m_lows.push_back(order[i].first);
        m_numbers.push_back(order[i].second);
    }
}

#endif
