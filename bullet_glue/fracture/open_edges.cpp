// Loops of open edges: each begins where another ends. Points are looked up in arrays that are never cleared, as in a
// sparse set (Briggs, Torczon: An efficient representation for sparse sets, 1993).
#include "fracture/open_edges.h"

#include <cstdlib>

namespace
{
uint32_t FromOf(uint64_t arrow)
{
    return uint32_t(arrow >> 32);
}
} // namespace

void qcClipEdges::FindLoops(bool turned, qcClipLoops* loops)
{
    loops->points.clear();
    loops->ends.clear();
    m_arrows.clear();
    for (const auto& edge : m_counts.Entries())
    {
        uint64_t upward = edge.key, downward = upward << 32 | upward >> 32;
        uint64_t arrow = (edge.value > 0) == turned ? downward : upward;
        for (int i = std::abs(edge.value); i > 0; i--)
            m_arrows.push_back(arrow);
    }
    if (m_arrows.empty())
        return;
    std::sort(m_arrows.begin(), m_arrows.end());
    uint32_t last = 0;
    for (uint64_t arrow : m_arrows)
        last = std::max({last, FromOf(arrow), uint32_t(arrow)});
    m_next.resize(std::max(m_next.size(), size_t(last) + 1));
    for (size_t i = m_arrows.size(); i-- > 0;)
        m_next[FromOf(m_arrows[i])] = uint32_t(i);
    for (size_t first = 0; first < m_arrows.size(); first++)
    {
        if (m_next[FromOf(m_arrows[first])] > first)
            continue;
        for (size_t i = first; i < m_arrows.size();)
        {
            uint32_t from = FromOf(m_arrows[i]), to = uint32_t(m_arrows[i]);
            loops->points.push_back(from);
            m_next[from] = uint32_t(i + 1);
            i = m_next[to];
            // Past the last arrow from there, or left from other loops.
            if (i < m_arrows.size() && FromOf(m_arrows[i]) != to)
                break;
        }
        loops->ends.push_back(loops->points.size());
    }
}
