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

bool qcSoftTangles::Contains(const std::vector<Key>& keys, uint32_t body, uint32_t index, uint32_t other)
{
    return std::binary_search(keys.begin(), keys.end(), Key{body, index, other});
}

bool qcSoftTangles::IsNearTangle(qcSoftBodyScene& scene, uint32_t body, uint32_t triangle, uint32_t other) const
{
    const qcSceneSoftBody* soft = scene.Find(body);
    if (soft == nullptr)
        return Contains(m_triangles, body, triangle, other);
    const uint32_t* corners = &soft->topology.indices[3 * size_t(triangle)];
    return std::any_of(corners, corners + 3,
                       [&](uint32_t corner) { return Contains(m_vertices, body, corner, other); });
}

void qcSoftTangles::MoveExempt(qcSoftBodyScene& scene, const qcResult& result, std::vector<size_t>* pairs,
                               std::vector<size_t>* exempt) const
{
    exempt->clear();
    if (IsEmpty())
        return;
    std::map<Slots, size_t> counts;
    for (size_t i : *pairs)
        counts[{result.pairs[i].bodyA, result.pairs[i].bodyB}]++;
    auto isNotExempt = [&](size_t i)
    {
        const qcPair& pair = result.pairs[i];
        uint32_t a = pair.bodyA, b = pair.bodyB;
        if (Contains(m_triangles, a, pair.triangleA, b) && Contains(m_triangles, b, pair.triangleB, a))
            return false;
        auto atStart = m_counts.find({a, b});
        return atStart == m_counts.end() || counts[{a, b}] > atStart->second ||
               !IsNearTangle(scene, a, pair.triangleA, b) || !IsNearTangle(scene, b, pair.triangleB, a);
    };
    auto middle = std::stable_partition(pairs->begin(), pairs->end(), isNotExempt);
    exempt->assign(middle, pairs->end());
    pairs->erase(middle, pairs->end());
}

void qcSoftTangles::Clear()
{
    m_triangles.clear();
    m_vertices.clear();
    m_counts.clear();
}

bool qcSoftTangles::IsNear(qcSoftBodyScene& scene, const qcPair& pair) const
{
    return !IsEmpty() && IsNearTangle(scene, pair.bodyA, pair.triangleA, pair.bodyB) &&
           IsNearTangle(scene, pair.bodyB, pair.triangleB, pair.bodyA);
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
}

bool qcSoftTangles::IsExempt(const qcContact& contact) const
{
    if (IsEmpty())
        return false;
    bool tangledA = true, tangledB = true;
    for (size_t i = 0; i < 3; i++)
    {
        tangledA = tangledA && (contact.weightsA[i] == 0 ||
                                Contains(m_vertices, contact.bodyA, contact.verticesA[i], contact.bodyB));
        tangledB = tangledB && (contact.weightsB[i] == 0 ||
                                Contains(m_vertices, contact.bodyB, contact.verticesB[i], contact.bodyA));
    }
    return tangledA || tangledB;
}
