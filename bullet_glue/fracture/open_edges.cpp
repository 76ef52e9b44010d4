// Chains half-edges into loops: each begins where another ends. The array by point is never cleared; entries are
// checked instead, as in a sparse set (Briggs, Torczon: An efficient representation for sparse sets, 1993).
#include "fracture/open_edges.h"

#include <cstdlib>

namespace
{
uint32_t FromOf(uint64_t halfEdge)
{
    return uint32_t(halfEdge >> 32);
}
} // namespace

void qcEdgeCounts::FindLoops(bool reversed, qcClipLoops* loops)
{
    loops->points.clear();
    loops->ends.clear();
    m_halfEdges.clear();
    for (const auto& edge : m_counts.Entries())
    {
        uint64_t upward = edge.key, downward = upward << 32 | upward >> 32;
        uint64_t halfEdge = (edge.value > 0) == reversed ? downward : upward;
        for (int i = std::abs(edge.value); i > 0; i--)
            m_halfEdges.push_back(halfEdge);
    }
    if (m_halfEdges.empty())
        return;
    std::sort(m_halfEdges.begin(), m_halfEdges.end());
    uint32_t maxPoint = 0;
    for (uint64_t halfEdge : m_halfEdges)
        maxPoint = std::max({maxPoint, FromOf(halfEdge), uint32_t(halfEdge)});
    m_next.resize(std::max(m_next.size(), size_t(maxPoint) + 1));
    for (size_t i = m_halfEdges.size(); i-- > 0;)
        m_next[FromOf(m_halfEdges[i])] = uint32_t(i);
    for (size_t first = 0; first < m_halfEdges.size(); first++)
    {
        if (m_next[FromOf(m_halfEdges[first])] > first)
            continue;
        for (size_t i = first; i < m_halfEdges.size();)
        {
            uint32_t from = FromOf(m_halfEdges[i]), to = uint32_t(m_halfEdges[i]);
            loops->points.push_back(from);
            m_next[from] = uint32_t(i + 1);
            i = m_next[to];
            // `i` is past the last half-edge from this point, or an entry of an earlier call.
            if (i < m_halfEdges.size() && FromOf(m_halfEdges[i]) != to)
                break;
        }
        loops->ends.push_back(loops->points.size());
    }
}
