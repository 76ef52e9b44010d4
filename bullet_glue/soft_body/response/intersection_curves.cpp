// Intersection curves: crossings of edges with triangles, chained by common crossings, and floods of the surfaces
// between them.
#include "soft_body/response/intersection_curves.h"

#include "common/hash_table.h"

#include <algorithm>

namespace
{
struct Point
{
    double at[3];
};

/// A vertex, displaced along each axis by at most the perturbation: always the same way.
Point Perturbed(const qcSurfaceGraph& graph, uint32_t slot, uint32_t vertex, double perturbation)
{
    btVector3 position = graph.Position(vertex);
    Point point;
    uint64_t bits = qcHashOf(uint64_t(slot) << 32 | vertex);
    for (int axis = 0; axis < 3; axis++)
    {
        bits = qcHashOf(bits + 1);
        point.at[axis] = double(position[axis]) + perturbation * (double(bits >> 11) / double(1ull << 52) - 1);
    }
    return point;
}

/// Exact, and so the same for both triangles that have the edge.
bool Crosses(const Point& from, const Point& to, const Point face[3])
{
    double edge[9], corners[9];
    for (int i = 0; i < 9; i++)
    {
        edge[i] = (i < 3 ? from : to).at[i % 3];
        corners[i] = face[i / 3].at[i % 3];
    }
    return qcRelateTriangles(edge, corners) == qc_relationPenetrating;
}

btVector3 CrossingPoint(const qcSurfaceGraph& edges, uint32_t from, uint32_t to, const qcSurfaceGraph& faces,
                        uint32_t triangle)
{
    const uint32_t* corners = faces.Corners(triangle);
    btVector3 a = edges.Position(from), b = edges.Position(to), origin = faces.Position(corners[0]);
    btVector3 normal = (faces.Position(corners[1]) - origin).cross(faces.Position(corners[2]) - origin);
    btScalar heightA = normal.dot(a - origin), heightB = normal.dot(b - origin),
             sum = btFabs(heightA) + btFabs(heightB);
    return sum > 0 ? a + (b - a) * (btFabs(heightA) / sum) : (a + b) / 2;
}
} // namespace

const qcSurfaceGraph* qcIntersectionCurves::GraphOf(qcSoftBodyScene& scene, uint32_t slot)
{
    std::unique_ptr<qcSurfaceGraph>& graph = m_graphs[slot];
    if (graph == nullptr)
        graph.reset(new qcSurfaceGraph(scene, slot));
    return graph.get();
}

/// Finds the edges of each pair that pass through the other triangle.
void qcIntersectionCurves::FindCrossings(const std::vector<qcPair>& pairs, btScalar perturbation)
{
    m_pairEdges.clear();
    for (size_t i = 0; i < pairs.size(); i++)
    {
        const uint32_t slots[2] = {pairs[i].bodyA, pairs[i].bodyB};
        const uint32_t triangles[2] = {pairs[i].triangleA, pairs[i].triangleB};
        Point points[2][3];
        const uint32_t* corners[2];
        for (int side = 0; side < 2; side++)
        {
            const qcSurfaceGraph& graph = *m_graphs[slots[side]];
            corners[side] = graph.Corners(triangles[side]);
            for (int c = 0; c < 3; c++)
                points[side][c] = Perturbed(graph, slots[side], corners[side][c], double(perturbation));
        }
        for (int side = 0; side < 2; side++)
            for (int c = 0; c < 3; c++)
            {
                int to = (c + 1) % 3;
                uint32_t u = corners[side][c], v = corners[side][to];
                if (u != v && Crosses(points[side][c], points[side][to], points[1 - side]))
                    m_pairEdges.push_back({slots[side], std::min(u, v), std::max(u, v), slots[1 - side],
                                           triangles[1 - side], i, side, 0});
            }
    }
    GroupCrossings();
}

void qcIntersectionCurves::GroupCrossings()
{
    // A rope link has its edge twice.
    std::sort(m_pairEdges.begin(), m_pairEdges.end());
    auto isSame = [](const PairEdge& a, const PairEdge& b) { return !(a < b) && !(b < a); };
    m_pairEdges.erase(std::unique(m_pairEdges.begin(), m_pairEdges.end(), isSame), m_pairEdges.end());
    m_crossings.clear();
    for (size_t e = 0; e < m_pairEdges.size(); e++)
    {
        if (e == 0 || !m_pairEdges[e].IsSameCrossing(m_pairEdges[e - 1]))
            m_crossings.push_back({e, e, 0, SIZE_MAX});
        m_crossings.back().end = e + 1;
        m_pairEdges[e].crossing = m_crossings.size() - 1;
    }
}

/// Adds a pair, with the crossings of its edges, to a curve. `firstSide`: the curve's side of its first triangle.
void qcIntersectionCurves::AddPair(const qcPair& pair, const std::vector<size_t>& edges, int firstSide,
                                   qcIntersectionCurve* curve)
{
    curve->pairs.push_back(pair);
    if (firstSide == 1)
        std::swap(curve->pairs.back().triangleA, curve->pairs.back().triangleB);
    for (size_t e : edges)
    {
        const PairEdge& edge = m_pairEdges[e];
        Crossing& crossing = m_crossings[edge.crossing];
        if (crossing.index != SIZE_MAX)
            continue;
        crossing.side = edge.side ^ firstSide;
        qcCurveSide& side = curve->sides[crossing.side];
        crossing.index = side.crossings.size();
        btVector3 point =
            CrossingPoint(*side.graph, edge.from, edge.to, *curve->sides[1 - crossing.side].graph, edge.triangle);
        side.crossings.push_back(
            {edge.from, edge.to, edge.triangle, point, btVector3(0, 0, 0), crossing.end == crossing.first + 1, false});
    }
    if (edges.size() != 2)
        return;
    const Crossing &start = m_crossings[m_pairEdges[edges[0]].crossing],
                   &end = m_crossings[m_pairEdges[edges[1]].crossing];
    qcEdgeCrossing& p = curve->sides[start.side].crossings[start.index];
    qcEdgeCrossing& q = curve->sides[end.side].crossings[end.index];
    btVector3 along = q.point - p.point;
    if (along.fuzzyZero())
        return;
    along.normalize();
    p.along += along;
    q.along -= along;
}

/// Chains pairs that have a crossing in common.
void qcIntersectionCurves::Trace(const std::vector<qcPair>& pairs)
{
    std::vector<std::vector<size_t>> edgesOfPair(pairs.size());
    for (size_t e = 0; e < m_pairEdges.size(); e++)
        edgesOfPair[m_pairEdges[e].pair].push_back(e);
    std::vector<int> sideOf(pairs.size(), -1); // the curve's side of the pair's first triangle
    std::vector<size_t> chain;
    for (size_t first = 0; first < pairs.size(); first++)
    {
        // A pair without a crossing touches only, or its triangles lie in one plane.
        if (sideOf[first] >= 0 || edgesOfPair[first].empty())
            continue;
        m_curves.emplace_back();
        qcIntersectionCurve& curve = m_curves.back();
        const uint32_t slots[2] = {pairs[first].bodyA, pairs[first].bodyB};
        for (int side = 0; side < 2; side++)
        {
            curve.sides[side].slot = slots[side];
            curve.sides[side].graph = m_graphs[slots[side]].get();
        }
        sideOf[first] = 0;
        chain.assign(1, first);
        for (size_t next = 0; next < chain.size(); next++)
        {
            size_t pair = chain[next];
            AddPair(pairs[pair], edgesOfPair[pair], sideOf[pair], &curve);
            for (size_t e : edgesOfPair[pair])
            {
                const Crossing& crossing = m_crossings[m_pairEdges[e].crossing];
                for (size_t same = crossing.first; same < crossing.end; same++)
                    if (sideOf[m_pairEdges[same].pair] < 0)
                    {
                        sideOf[m_pairEdges[same].pair] = crossing.side ^ m_pairEdges[same].side;
                        chain.push_back(m_pairEdges[same].pair);
                    }
            }
        }
    }
}

/// Finds the edges that floods must not cross: those that pass through the other surface an odd number of times. Where
/// a curve ends inside of a triangle at the boundary of its surface, since the other surface ends there, it is
/// continued to the boundary: cloths of equal width that intersect from side to side divide each other.
void qcIntersectionCurves::FindCuts()
{
    std::map<CutEdge, size_t> counts;
    std::set<CutEdge> continued;
    for (const Crossing& crossing : m_crossings)
    {
        const PairEdge& edge = m_pairEdges[crossing.first];
        counts[{edge.slot, edge.otherSlot, edge.from, edge.to}]++;
        const qcSurfaceGraph& other = *m_graphs[edge.otherSlot];
        const uint32_t* corners = other.Corners(edge.triangle);
        for (int c = 0; c < 3 && crossing.end == crossing.first + 1; c++)
        {
            uint32_t u = corners[c], v = corners[(c + 1) % 3];
            if (u != v && other.IsOnBoundary(u, v))
                continued.insert({edge.otherSlot, edge.slot, std::min(u, v), std::max(u, v)});
        }
    }
    m_cuts.swap(continued);
    for (const auto& count : counts)
        if (count.second % 2 == 1)
            m_cuts.insert(count.first);
}

/// Floods the surface from both ends of a cut edge, in turns, so that the smaller part ends first.
void qcIntersectionCurves::Divide(qcCurveSide* side, uint32_t otherSlot)
{
    const qcSurfaceGraph& graph = *side->graph;
    auto isCut = [&](uint32_t u, uint32_t v) {
        return m_cuts.count({side->slot, otherSlot, std::min(u, v), std::max(u, v)}) != 0;
    };
    auto first = std::find_if(side->crossings.begin(), side->crossings.end(),
                              [&](const qcEdgeCrossing& crossing) { return isCut(crossing.from, crossing.to); });
    if (first == side->crossings.end())
        return;
    std::vector<uint8_t>& floodOf = m_floodOf;
    floodOf.resize(std::max(floodOf.size(), size_t(graph.VertexCount())), 0);
    std::vector<uint32_t> floods[2] = {{first->from}, {first->to}};
    floodOf[first->from] = 1;
    floodOf[first->to] = 2;
    bool isConnected = false;
    size_t next = 0;
    for (; !isConnected && next < floods[0].size() && next < floods[1].size(); next++)
        for (uint8_t f = 0; f < 2; f++)
        {
            uint32_t vertex = floods[f][next];
            graph.ForEachNeighbour(vertex,
                                   [&](uint32_t neighbour)
                                   {
                                       if (floodOf[neighbour] == f + 1 || isCut(vertex, neighbour))
                                           return;
                                       isConnected = isConnected || floodOf[neighbour] != 0;
                                       if (floodOf[neighbour] == 0)
                                           floods[f].push_back(neighbour);
                                       floodOf[neighbour] = uint8_t(f + 1);
                                   });
        }
    if (!isConnected)
    {
        uint8_t smaller = next >= floods[0].size() ? 0 : 1;
        for (qcEdgeCrossing& crossing : side->crossings)
        {
            if (floodOf[crossing.to] == smaller + 1)
                std::swap(crossing.from, crossing.to);
            crossing.bordersPart = floodOf[crossing.from] == smaller + 1 && floodOf[crossing.to] != smaller + 1;
        }
        side->part = floods[smaller];
    }
    for (const std::vector<uint32_t>& flood : floods)
        for (uint32_t vertex : flood)
            floodOf[vertex] = 0;
}

void qcIntersectionCurves::Clear()
{
    m_graphs.clear();
    m_curves.clear();
    m_cuts.clear();
}

void qcIntersectionCurves::Find(qcSoftBodyScene& scene, const std::vector<qcPair>& pairs, btScalar perturbation)
{
    Clear();
    for (const qcPair& pair : pairs)
    {
        GraphOf(scene, pair.bodyA);
        GraphOf(scene, pair.bodyB);
    }
    FindCrossings(pairs, perturbation);
    Trace(pairs);
    FindCuts();
    for (qcIntersectionCurve& curve : m_curves)
        for (int side = 0; side < 2; side++)
            Divide(&curve.sides[side], curve.sides[1 - side].slot);
}
