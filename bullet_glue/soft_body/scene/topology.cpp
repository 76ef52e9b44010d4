// Faces, ropes and single nodes of a soft body.
#include "soft_body/scene/topology.h"

#include <algorithm>

namespace
{
// Thickness of a rope by the length of its links. A rope is thinner than its links are long: with half the length, the
// share that cloth has, a rope of 20 links of 10 cm would lie 3 cm above a mesh.
constexpr btScalar s_ropeThickness = btScalar(0.125);

// Share of a small height that is free of contact even where the faces are compressed a little.
constexpr btScalar s_shareOfHeight = btScalar(0.9);

struct Neighbour
{
    uint32_t node;
    btScalar length; ///< of the link to it, at rest
};

uint32_t IndexOf(const btSoftBody* body, const btSoftBody::Node* node)
{
    return uint32_t(node - &body->m_nodes[0]);
}

std::pair<uint32_t, uint32_t> EndsOf(const btSoftBody* body, int link)
{
    const btSoftBody::Link& l = body->m_links[link];
    return {IndexOf(body, l.m_n[0]), IndexOf(body, l.m_n[1])};
}

/// Neighbours of each node along links, without those that only resist bending.
std::vector<std::vector<Neighbour>> NeighboursOf(const btSoftBody* body)
{
    std::vector<std::vector<Neighbour>> neighbours(size_t(body->m_nodes.size()));
    for (int i = 0; i < body->m_links.size(); i++)
    {
        auto ends = EndsOf(body, i);
        if (body->m_links[i].m_bbending)
            continue;
        neighbours[ends.first].push_back({ends.second, body->m_links[i].m_rl});
        neighbours[ends.second].push_back({ends.first, body->m_links[i].m_rl});
    }
    return neighbours;
}

/// True for a brace: a link whose ends two shorter links connect (the diagonal of a net, a link over two others of a
/// rope). A brace crosses the links that it braces: as a segment it would be pushed off them.
bool IsBrace(const std::vector<std::vector<Neighbour>>& neighbours, std::pair<uint32_t, uint32_t> ends, btScalar length)
{
    for (const Neighbour& first : neighbours[ends.first])
        for (const Neighbour& second : neighbours[ends.second])
            if (first.node == second.node && first.length < length && second.length < length)
                return true;
    return false;
}

/// Appends each rope link once, and clears the marks of its nodes.
void AddRopes(const btSoftBody* body, qcSoftTopology* topology, std::vector<bool>* loose)
{
    const std::vector<std::vector<Neighbour>> neighbours = NeighboursOf(body);
    std::vector<std::pair<uint32_t, uint32_t>> ropes;
    topology->linkCount = body->m_links.size();
    for (int i = 0; i < body->m_links.size(); i++)
    {
        const btSoftBody::Link& link = body->m_links[i];
        std::pair<uint32_t, uint32_t> ends = EndsOf(body, i);
        if (!(*loose)[ends.first] && !(*loose)[ends.second])
            continue;
        topology->looseLinks.push_back({i, ends});
        if (ends.first != ends.second && !link.m_bbending && !IsBrace(neighbours, ends, link.m_rl))
            ropes.push_back(std::minmax(ends.first, ends.second));
    }
    std::sort(ropes.begin(), ropes.end());
    ropes.erase(std::unique(ropes.begin(), ropes.end()), ropes.end());
    topology->ropeCount = ropes.size();
    for (const auto& ends : ropes)
    {
        topology->indices.insert(topology->indices.end(), {ends.first, ends.second, ends.second});
        (*loose)[ends.first] = (*loose)[ends.second] = false;
    }
}

std::vector<uint32_t> NodesOf(const btSoftBody* body, const std::vector<uint32_t>& indices)
{
    std::vector<bool> isUsed(size_t(body->m_nodes.size()));
    for (uint32_t node : indices)
        isUsed[node] = true;
    std::vector<uint32_t> nodes;
    for (uint32_t node = 0; node < isUsed.size(); node++)
        if (isUsed[node])
            nodes.push_back(node);
    return nodes;
}

btScalar LengthOf(const btSoftBody* body, uint32_t a, uint32_t b)
{
    return (body->m_nodes[int(a)].m_x - body->m_nodes[int(b)].m_x).length();
}

/// The rest length of the link between two nodes, or their distance where there is none.
btScalar RestLengthOf(const btSoftBody* body, const std::vector<std::vector<Neighbour>>& neighbours, uint32_t a,
                      uint32_t b)
{
    for (const Neighbour& neighbour : neighbours[a])
        if (neighbour.node == b)
            return neighbour.length;
    return LengthOf(body, a, b);
}

btScalar DefaultThicknessOf(const btSoftBody* body, const qcSoftTopology& topology)
{
    btScalar sum = 0;
    for (size_t i = 0; i < 3 * topology.faceCount; i++)
        sum += LengthOf(body, topology.indices[i], topology.indices[i % 3 == 2 ? i - 2 : i + 1]);
    if (topology.faceCount > 0)
        return sum / btScalar(3 * topology.faceCount) / 2;
    for (size_t i = 0; i < topology.ropeCount; i++)
        sum += LengthOf(body, topology.indices[3 * i], topology.indices[3 * i + 1]);
    return topology.ropeCount > 0 ? sum / btScalar(topology.ropeCount) * s_ropeThickness : btScalar(0);
}

/// The rest length of the first link, the one in the middle or the last.
btScalar RestLengthAt(const btSoftBody* body, int which)
{
    const int count = body->m_links.size();
    return count > 0 ? body->m_links[which * (count - 1) / 2].m_rl : btScalar(0);
}

bool IsChain(const btSoftBody* body, const qcSoftTopology& topology)
{
    bool isChain = topology.faceCount == 0 && topology.ropeCount + 1 == size_t(body->m_nodes.size()) &&
                   topology.indices.size() == 3 * topology.ropeCount;
    for (size_t i = 0; isChain && i < topology.ropeCount; i++)
        isChain = topology.indices[3 * i] == i && topology.indices[3 * i + 1] == i + 1;
    return isChain;
}
} // namespace

qcSoftTopology qcTopologyOf(const btSoftBody* body)
{
    qcSoftTopology topology;
    topology.faceCount = size_t(body->m_faces.size());
    topology.indices.reserve(3 * topology.faceCount);
    // Nodes inside a skin of faces don't collide: the skin is hit first.
    std::vector<bool> loose(size_t(body->m_nodes.size()), body->m_tetras.size() == 0 || topology.faceCount == 0);
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
        {
            topology.indices.push_back(IndexOf(body, node));
            loose[topology.indices.back()] = false;
        }
    if (body->m_tetras.size() == 0 && std::find(loose.begin(), loose.end(), true) != loose.end())
        AddRopes(body, &topology, &loose);
    for (size_t i = 0; i < loose.size(); i++)
        if (loose[i])
            topology.indices.insert(topology.indices.end(), 3, uint32_t(i));
    topology.nodes = NodesOf(body, topology.indices);
    topology.defaultThickness = DefaultThicknessOf(body, topology);
    topology.isChain = IsChain(body, topology);
    for (int i = 0; i < 3; i++)
        topology.restLengths[i] = RestLengthAt(body, i);
    return topology;
}

btScalar qcClearHeightOf(const btSoftBody* body, const qcSoftTopology& topology)
{
    const std::vector<std::vector<Neighbour>> neighbours = NeighboursOf(body);
    std::vector<btScalar> heights;
    for (size_t i = 0; i < topology.faceCount; i++)
    {
        const uint32_t* node = &topology.indices[3 * i];
        btScalar edges[3];
        for (int e = 0; e < 3; e++)
            edges[e] = RestLengthOf(body, neighbours, node[e], node[(e + 1) % 3]);
        std::sort(edges, edges + 3);
        // Heron's formula; rest lengths need not make a triangle.
        const btScalar half = (edges[0] + edges[1] + edges[2]) / 2;
        const btScalar square = half * (half - edges[0]) * (half - edges[1]) * (half - edges[2]);
        if (square > 0)
            heights.push_back(2 * btSqrt(square) / edges[2]);
    }
    if (heights.empty())
        return BT_LARGE_FLOAT;
    auto small = heights.begin() + std::ptrdiff_t(heights.size() / 100);
    std::nth_element(heights.begin(), small, heights.end());
    return s_shareOfHeight * *small;
}

bool qcIsTopologyOf(const qcSoftTopology& topology, const btSoftBody* body)
{
    if (topology.faceCount != size_t(body->m_faces.size()))
        return false;
    const uint32_t* index = topology.indices.data();
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
            if (node != &body->m_nodes[0] + *index++)
                return false;
    auto isUnchanged = [&](const std::pair<int, std::pair<uint32_t, uint32_t>>& link)
    { return EndsOf(body, link.first) == link.second; };
    return topology.linkCount == -1 ||
           (topology.linkCount == body->m_links.size() &&
            std::all_of(topology.looseLinks.begin(), topology.looseLinks.end(), isUnchanged));
}

bool qcIsScaled(const qcSoftTopology& topology, const btSoftBody* body)
{
    for (int i = 0; i < 3; i++)
    {
        const btScalar before = topology.restLengths[i], now = RestLengthAt(body, i);
        if (!(btFabs(now - before) > btScalar(0.1) * before))
            return false;
    }
    return true;
}
