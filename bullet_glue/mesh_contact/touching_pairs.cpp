// Pairs of small meshes that touch at the start of a step up to rounding.
#include "mesh_contact/touching_pairs.h"

#include "mesh_contact/separating_axis.h"

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

void qcTouchingPairs::Keep(const qcSweptPair& pair, const btVector3& axis, btScalar error, qcMotionPlanes* planes)
{
    const qcSweptObject &a = *pair.first, &b = *pair.second;
    qcPlacedSupport endA{a.hull, a.end}, endB{b.hull, b.end};
    btScalar gap = qcGapAlong(endA, endB, axis);
    bool touches = gap <= error && qcSeparateHulls(endA, endB, axis, error).gap <= error;
    m_touching[qcNumbersOf(pair)] = touches;
    if (!touches)
        return;
    planes->AddHulls(pair.first, pair.second, axis, 2 * error);
    m_anyTouches = true;
    btScalar minGap = std::min(-error, qcGapAlong({a.hull, a.start}, {b.hull, b.start}, axis));
    if (gap < minGap)
        m_closing.push_back({pair, axis, minGap});
}
