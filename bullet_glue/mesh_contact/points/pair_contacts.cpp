// Results of the last query of each pair of objects in a world.
#include "mesh_contact/points/pair_contacts.h"

#include <algorithm>

namespace
{
// Pairs whose boxes have been apart for this many checks are forgotten.
constexpr uint64_t s_keptChecks = 64;

btScalar SizeOf(const btTransform& transform)
{
    return transform.getOrigin().length();
}
} // namespace

qcMeshPoint qcKnownPoint::At(const btTransform& a, const btTransform& b) const
{
    qcMeshPoint moved = point;
    moved.onA = a * point.onA;
    moved.onB = b * point.onB;
    moved.normal = b.getBasis() * point.normal;
    // Points move with their bodies, as those of a btPersistentManifold do.
    moved.distance = (moved.onA - moved.onB).dot(moved.normal);
    if (isAhead)
        moved.AlignEnds();
    return moved;
}

btScalar qcRelativeDisplacementBound(const qcObjectMotion& a, const qcObjectMotion& b)
{
    // The motion of the larger one is common to both.
    const qcObjectMotion &small = a.radius < b.radius ? a : b, &large = a.radius < b.radius ? b : a;
    return qcDisplacementBound(large.to * large.from.inverse() * small.from, small.to, small.radius);
}

btScalar qcGapAfter(const qcPairContact& pair, const qcObjectMotion& a, const qcObjectMotion& b)
{
    if (!pair.isKnown || !(pair.gap > 0))
        return 0;
    btScalar size = SizeOf(a.from) + SizeOf(a.to) + SizeOf(b.from) + SizeOf(b.to) + a.radius + b.radius;
    return btScalar(pair.gap) - qcRelativeDisplacementBound(a, b) - 64 * SIMD_EPSILON * size;
}

qcPairContact& qcPairContacts::FindOrAdd(uint32_t a, uint32_t b)
{
    uint64_t key = KeyOf(a, b);
    uint32_t index = m_indices.FindOrAdd(key, uint32_t(m_pairs.size()));
    if (index == m_pairs.size())
        m_pairs.emplace_back(key);
    return m_pairs[index].contact;
}

const qcPairContact* qcPairContacts::Find(uint32_t a, uint32_t b) const
{
    const uint32_t* index = m_indices.Find(KeyOf(a, b));
    return index != nullptr ? &m_pairs[*index].contact : nullptr;
}

qcPairContact* qcPairContacts::Find(uint32_t a, uint32_t b)
{
    const uint32_t* index = m_indices.Find(KeyOf(a, b));
    return index != nullptr ? &m_pairs[*index].contact : nullptr;
}

void qcPairContacts::Count(uint64_t check, int* regions, int* points) const
{
    *regions = *points = 0;
    for (const Pair& pair : m_pairs)
        if (pair.contact.checked == check)
        {
            *regions += pair.contact.regions;
            *points += int(pair.contact.points.size());
        }
}

void qcPairContacts::RemoveOld(uint64_t check)
{
    if (check - m_removed < s_keptChecks)
        return;
    m_removed = check;
    auto isOld = [check](const Pair& pair) { return check - pair.contact.checked > s_keptChecks; };
    m_pairs.erase(std::remove_if(m_pairs.begin(), m_pairs.end(), isOld), m_pairs.end());
    m_indices.Clear(m_pairs.size());
    for (const Pair& pair : m_pairs)
        m_indices.FindOrAdd(pair.key, uint32_t(&pair - m_pairs.data()));
}

bool qcPairContacts::StayApart(const qcPairContact& pair, const qcObjectMotion& a, const qcObjectMotion& b)
{
    if (!pair.isKnown || !(pair.gap > 0))
        return false;
    bool isSmallA = a.radius < b.radius;
    const qcObjectMotion &small = isSmallA ? a : b, &large = isSmallA ? b : a;
    const btTransform &knownSmall = isSmallA ? pair.a : pair.b, &knownLarge = isSmallA ? pair.b : pair.a;
    // The pair as known, moved as one to where the larger object starts, and along with its origin.
    btTransform expected = large.from * knownLarge.inverse() * knownSmall, carried = large.from;
    btScalar start = qcDisplacementBound(expected, small.from, small.radius);
    btVector3 shift = large.to.getOrigin() - large.from.getOrigin();
    expected.getOrigin() += shift;
    carried.getOrigin() += shift;
    btScalar end =
        qcDisplacementBound(expected, small.to, small.radius) + qcDisplacementBound(carried, large.to, large.radius);
    btScalar size = SizeOf(small.from) + SizeOf(small.to) + SizeOf(large.from) + SizeOf(large.to) + SizeOf(pair.a) +
                    SizeOf(pair.b) + small.radius + large.radius;
    return 2 * double(std::max(start, end)) + double(64 * SIMD_EPSILON * size) < pair.gap;
}
