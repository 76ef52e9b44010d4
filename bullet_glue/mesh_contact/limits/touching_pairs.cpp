// Pairs of small meshes that touch at the start of a step up to rounding.
#include "mesh_contact/limits/touching_pairs.h"

#include "mesh_contact/planes/separating_axis.h"

#include <algorithm>

btScalar qcClosingPair::FindPart(btScalar limit) const
{
    auto isApart = [this](btScalar part)
    {
        return qcGapAlong({pair.first->hull, pair.first->EndAt(part)}, {pair.second->hull, pair.second->EndAt(part)},
                          axis) >= minGap;
    };
    return qcFindLargestPart(limit, isApart);
}

void qcTouchingPairs::BeginStep()
{
    for (auto entry = m_touching.begin(); entry != m_touching.end();)
        entry = entry->second ? std::next(entry) : m_touching.erase(entry);
    for (auto& [numbers, touches] : m_touching)
        touches = false;
}

void qcTouchingPairs::BeginRound()
{
    m_closing.clear();
    m_anyTouches = false;
}

bool qcTouchingPairs::Include(const qcSweptPair& pair) const
{
    return m_touching.count(qcNumbersOf(pair)) > 0;
}

namespace
{
/// True if two objects that touch along an axis at the start end apart, and not on the other side of each other:
/// neither is the direction that parts them at the end turned around, nor do they overlap along it at the start.
bool EndApart(const qcSweptPair& pair, const btVector3& axis, btScalar error, btScalar minGap)
{
    const qcSweptObject &a = *pair.first, &b = *pair.second;
    const qcSeparation atEnd = qcSeparateHulls({a.hull, a.end}, {b.hull, b.end}, axis, error);
    const btVector3 turned = a.end.getBasis() * (a.start.getBasis().transpose() * axis);
    return atEnd.gap > error &&
           (atEnd.axis.dot(turned) >= 0 || qcGapAlong({a.hull, a.start}, {b.hull, b.start}, atEnd.axis) >= minGap);
}
} // namespace

void qcTouchingPairs::Keep(const qcSweptPair& pair, const btVector3& axis, btScalar error, qcMotionPlanes* planes)
{
    const qcSweptObject &a = *pair.first, &b = *pair.second;
    qcPlacedSupport endA{a.hull, a.end}, endB{b.hull, b.end};
    btScalar gap = qcGapAlong(endA, endB, axis);
    btScalar minGap = std::min(-error, qcGapAlong({a.hull, a.start}, {b.hull, b.start}, axis));
    bool touches = gap <= error && !EndApart(pair, axis, error, minGap);
    m_touching[qcNumbersOf(pair)] = touches;
    if (!touches)
        return;
    planes->AddHulls(pair.first, pair.second, axis, 2 * error);
    m_anyTouches = true;
    if (gap < minGap)
        m_closing.push_back({pair, axis, minGap});
}
