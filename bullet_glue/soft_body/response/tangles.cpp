// Tangles from the result of a query, and the pairs and contacts that they exempt.
#include "soft_body/response/tangles.h"

#include <algorithm>

namespace
{
template <typename Key> void SortUnique(std::vector<Key>* keys)
{
    std::sort(keys->begin(), keys->end());
    keys->erase(std::unique(keys->begin(), keys->end()), keys->end());
}
} // namespace

/// True if the curve is a crossing of a rope link.
static bool IsRope(const qcIntersectionCurve& curve)
{
    auto isLink = [](const qcCurveSide& side, uint32_t triangle)
    {
        const uint32_t* corners = side.graph->Corners(triangle);
        return corners[1] == corners[2] || corners[0] == corners[1] || corners[0] == corners[2];
    };
    return std::any_of(curve.pairs.begin(), curve.pairs.end(),
                       [&](const qcPair& pair)
                       { return isLink(curve.sides[0], pair.triangleA) || isLink(curve.sides[1], pair.triangleB); });
}

bool qcSoftTangles::Contains(const std::vector<Key>& keys, uint32_t body, uint32_t index, uint32_t other)
{
    return std::binary_search(keys.begin(), keys.end(), Key{body, index, other});
}

bool qcSoftTangles::HasVertexIn(const std::vector<Key>& keys, qcSoftBodyScene& scene, uint32_t body, uint32_t triangle,
                                uint32_t other) const
{
    const qcSceneSoftBody* soft = scene.Find(body);
    auto graph = m_graphs.find(body);
    if (soft == nullptr && graph == m_graphs.end())
        return false;
    const uint32_t* corners =
        soft != nullptr ? &soft->topology.indices[3 * size_t(triangle)] : graph->second->Corners(triangle);
    return std::any_of(corners, corners + 3, [&](uint32_t corner) { return Contains(keys, body, corner, other); });
}

bool qcSoftTangles::MayLeave(qcSoftBodyScene& scene, const qcPair& pair) const
{
    uint32_t a = pair.bodyA, b = pair.bodyB;
    return !m_leaving.empty() && HasVertexIn(m_vertices, scene, a, pair.triangleA, b) &&
           HasVertexIn(m_vertices, scene, b, pair.triangleB, a) &&
           (HasVertexIn(m_leaving, scene, a, pair.triangleA, b) || HasVertexIn(m_leaving, scene, b, pair.triangleB, a));
}

bool qcSoftTangles::AreTangled(const qcSceneSoftBody& soft, const qcSceneRigid& rigid) const
{
    return std::any_of(rigid.meshes.begin(), rigid.meshes.end(),
                       [&](const qcSceneMesh& mesh) { return AreTangled(soft.id.slot, mesh.id.slot); });
}

void qcSoftTangles::MarkParts(const std::vector<qcUntanglement>& untanglements)
{
    m_leaving.clear();
    m_leavingRopes.clear();
    std::vector<Key> known;
    for (const qcUntanglement& tangle : untanglements)
        for (int side = 0; side < 2; side++)
        {
            const qcCurveSide& mine = tangle.curve->sides[side];
            uint32_t other = tangle.curve->sides[1 - side].slot;
            m_graphs[mine.slot] = mine.graph;
            bool divides = tangle.hasPart[0] || tangle.hasPart[1], isRope = IsRope(*tangle.curve);
            std::vector<uint32_t> part;
            if (tangle.hasPart[side])
                part = mine.part;
            std::sort(part.begin(), part.end());
            for (const qcPair& pair : tangle.curve->pairs)
                for (int c = 0; c < 3; c++)
                {
                    uint32_t vertex = mine.graph->Corners(side == 0 ? pair.triangleA : pair.triangleB)[c];
                    if (mine.graph->soft == nullptr)
                        m_vertices.push_back({mine.slot, vertex, other});
                    bool leaves = !divides || std::binary_search(part.begin(), part.end(), vertex);
                    if (leaves)
                        (isRope ? m_leavingRopes : m_leaving).push_back({mine.slot, vertex, other});
                    if (!isRope)
                        known.push_back({mine.slot, vertex, other});
                }
        }
    SortUnique(&m_vertices);
    SortUnique(&m_leaving);
    SortUnique(&m_leavingRopes);
    SortUnique(&known);
    m_kept.clear();
    std::set_difference(m_vertices.begin(), m_vertices.end(), known.begin(), known.end(), std::back_inserter(m_kept));
}

void qcSoftTangles::Clear()
{
    m_triangles.clear();
    m_vertices.clear();
    m_counts.clear();
    m_leaving.clear();
    m_leavingRopes.clear();
    m_kept.clear();
    m_graphs.clear();
}

bool qcSoftTangles::IsKept(qcSoftBodyScene& scene, const qcPair& pair) const
{
    auto isNear = [&](uint32_t body, uint32_t triangle, uint32_t other)
    {
        return scene.Find(body) != nullptr ? HasVertexIn(m_kept, scene, body, triangle, other)
                                           : Contains(m_triangles, body, triangle, other);
    };
    return !m_kept.empty() && isNear(pair.bodyA, pair.triangleA, pair.bodyB) &&
           isNear(pair.bodyB, pair.triangleB, pair.bodyA);
}

bool qcSoftTangles::HasGrown(const qcResult& result, uint32_t bodyA, uint32_t bodyB) const
{
    auto isTheirs = [=](const qcPair& pair) { return pair.bodyA == bodyA && pair.bodyB == bodyB; };
    auto atStart = m_counts.find({bodyA, bodyB});
    return size_t(std::count_if(result.pairs, result.pairs + result.pairCount, isTheirs)) >
           (atStart == m_counts.end() ? 0 : atStart->second);
}

void qcSoftTangles::Read(qcSoftBodyScene& scene, const qcResult& result)
{
    Clear();
    for (size_t i = 0; i < result.pairCount; i++)
    {
        const qcPair& pair = result.pairs[i];
        m_counts[{pair.bodyA, pair.bodyB}]++;
        m_triangles.push_back({pair.bodyA, pair.triangleA, pair.bodyB});
        m_triangles.push_back({pair.bodyB, pair.triangleB, pair.bodyA});
    }
    SortUnique(&m_triangles);
    for (const Key& key : m_triangles)
        if (const qcSceneSoftBody* soft = scene.Find(key[0]))
            for (size_t corner = 0; corner < 3; corner++)
                m_vertices.push_back({key[0], soft->topology.indices[3 * size_t(key[1]) + corner], key[2]});
    SortUnique(&m_vertices);
    m_kept = m_vertices;
}

bool qcSoftTangles::IsExempt(const qcContact& contact) const
{
    if (IsEmpty())
        return false;
    bool keptA = true, keptB = true, isLeaving = false;
    for (size_t i = 0; i < 3; i++)
    {
        const Key a = {contact.bodyA, contact.verticesA[i], contact.bodyB};
        const Key b = {contact.bodyB, contact.verticesB[i], contact.bodyA};
        keptA = keptA && (contact.weightsA[i] == 0 || Contains(m_kept, a[0], a[1], a[2]));
        keptB = keptB && (contact.weightsB[i] == 0 || Contains(m_kept, b[0], b[1], b[2]));
        for (const std::vector<Key>* keys : {&m_leaving, &m_leavingRopes})
            isLeaving = isLeaving || (contact.weightsA[i] != 0 && Contains(*keys, a[0], a[1], a[2])) ||
                        (contact.weightsB[i] != 0 && Contains(*keys, b[0], b[1], b[2]));
    }
    return keptA || keptB || isLeaving;
}
