// Bounds of the motion, and which bodies are near each other.
#include "soft_body/response/clearance.h"

#include <algorithm>

qcSoftClearance::Motion qcSoftClearance::Measure(const std::vector<btVector3>& from, const std::vector<btVector3>& to)
{
    Motion motion;
    for (size_t i = 0; i < from.size(); i++)
        motion.mean += to[i] - from[i];
    if (!from.empty())
        motion.mean /= btScalar(from.size());
    btScalar largest = 0;
    for (size_t i = 0; i < from.size(); i++)
        largest = std::max(largest, (to[i] - from[i] - motion.mean).length2());
    motion.radius = btSqrt(largest);
    return motion;
}

bool qcSoftClearance::IsWithin(const Motion& a, const Motion& b, btScalar distance)
{
    // A hundredth of the distance and the last term cover all rounding. A motion that is not finite is not within.
    btScalar rounding = btScalar(1e-5) * (a.mean.length() + b.mean.length());
    return a.radius + b.radius + (a.mean - b.mean).length() + rounding < btScalar(0.99) * distance;
}

void qcSoftClearance::Clear()
{
    for (Body& body : m_bodies)
        body.thickness = 0;
}

void qcSoftClearance::Record(uint32_t slot, btScalar thickness, const std::vector<btVector3>& start,
                             const std::vector<btVector3>& positions)
{
    if (slot >= m_bodies.size())
        m_bodies.resize(slot + 1);
    Body& body = m_bodies[slot];
    body.thickness = thickness;
    body.recorded = positions;
    body.toStart = Measure(positions, start);
    body.toEnd = Motion();
}

void qcSoftClearance::RecordNear(const qcResult& result)
{
    m_near.clear();
    auto add = [this](uint32_t slotA, uint32_t slotB)
    {
        const SlotPair pair = std::minmax(slotA, slotB);
        if (m_near.empty() || m_near.back() != pair)
            m_near.push_back(pair);
    };
    for (size_t i = 0; i < result.pairCount; i++)
        add(result.pairs[i].bodyA, result.pairs[i].bodyB);
    for (size_t i = 0; i < result.contactCount; i++)
        add(result.contacts[i].bodyA, result.contacts[i].bodyB);
    std::sort(m_near.begin(), m_near.end());
}

void qcSoftClearance::MeasureEnd(uint32_t slot, const std::vector<btVector3>& positions)
{
    if (slot < m_bodies.size() && m_bodies[slot].thickness > 0)
        m_bodies[slot].toEnd = Measure(m_bodies[slot].recorded, positions);
}

bool qcSoftClearance::KeepsApart(uint32_t slotA, uint32_t slotB) const
{
    if (!AreApartAtEnd(slotA, slotB))
        return false;
    const Body &a = m_bodies[slotA], &b = m_bodies[slotB];
    return IsWithin(a.toStart, b.toStart, (a.thickness + b.thickness) / 2);
}

bool qcSoftClearance::AreApartAtEnd(uint32_t slotA, uint32_t slotB) const
{
    if (std::max(slotA, slotB) >= m_bodies.size())
        return false;
    const Body &a = m_bodies[slotA], &b = m_bodies[slotB];
    return a.thickness > 0 && b.thickness > 0 && IsWithin(a.toEnd, b.toEnd, (a.thickness + b.thickness) / 2) &&
           !std::binary_search(m_near.begin(), m_near.end(), SlotPair(std::minmax(slotA, slotB)));
}
