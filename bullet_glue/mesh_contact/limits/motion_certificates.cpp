// Pairs of objects whose motions in a step are proven apart as a whole, without a look at their triangles' motions.
#include "mesh_contact/limits/motion_certificates.h"

#include "common/parallel_loop.h"
#include "mesh_contact/limits/clear_path.h"
#include "mesh_contact/planes/touching_faces.h"

namespace
{
// Pairs that a thread takes at a time, each of some tenths of a microsecond, and of some microseconds.
constexpr size_t s_gapBlock = 256, s_hullBlock = 32;
} // namespace

bool qcHaveHulls(const qcSweptObject& a, const qcSweptObject& b, const std::set<qcPairNumbers>& inner)
{
    return a.hull != nullptr && b.hull != nullptr && inner.count(std::minmax(a.number, b.number)) == 0;
}

/// Finds the object in the scene of contact, once a step.
void qcMotionCertificates::LookUp(qcSweptObject* swept)
{
    if (swept->isLookedUp)
        return;
    swept->isLookedUp = true;
    swept->known = swept->Deforms() ? nullptr : m_gaps.FindCurrent(swept->object);
}

/// Removes the pairs of which a function of their index is true. Calls for different pairs may run at once, on threads
/// that take `block` pairs at a time.
void qcMotionCertificates::Remove(size_t block, const std::function<bool(size_t)>& isProven,
                                  std::vector<qcSweptPair>* pairs)
{
    m_isProven.resize(pairs->size());
    qcForEach(qcWorkersOf(m_settings.threads), pairs->size(), block,
              [&](size_t i, uint32_t) { m_isProven[i] = isProven(i); });
    size_t kept = 0;
    for (size_t i = 0; i < pairs->size(); i++)
        if (!m_isProven[i])
            (*pairs)[kept++] = (*pairs)[i];
    pairs->resize(kept);
}

void qcMotionCertificates::RemoveApart(const std::set<qcPairNumbers>& inner, std::vector<qcSweptPair>* pairs)
{
    for (const qcSweptPair& pair : *pairs)
        for (qcSweptObject* swept : {pair.first, pair.second})
            LookUp(swept);
    auto staysApart = [this, pairs](size_t i)
    {
        const qcSweptObject &a = *(*pairs)[i].first, &b = *(*pairs)[i].second;
        return a.known != nullptr && b.known != nullptr &&
               m_gaps.StayApart({*a.known, a.start, a.end}, {*b.known, b.start, b.end});
    };
    Remove(s_gapBlock, staysApart, pairs);
    for (const qcSweptPair& pair : *pairs)
    {
        if (!pair.first->hulls.empty())
            pair.second->ReadChildren();
        if (!pair.second->hulls.empty())
            pair.first->ReadChildren();
    }
    auto isClear = [&inner, pairs](size_t i)
    {
        const qcSweptObject &a = *(*pairs)[i].first, &b = *(*pairs)[i].second;
        return inner.count(qcNumbersOf((*pairs)[i])) == 0 && (qcHasClearPath(a, b) || qcHasClearPath(b, a));
    };
    Remove(s_hullBlock, isClear, pairs);
}

/// True if one direction separates the hulls of two objects at the start and at the end of the step, or if they are
/// new and touch at the start. `touch`: where they do.
bool qcMotionCertificates::IsSeparated(const qcSweptPair& pair, const qcTouchingPairs& touching, Touch* touch) const
{
    const qcSweptObject &a = *pair.first, &b = *pair.second;
    const qcMovedHulls hulls{{a.hull, a.start}, {b.hull, b.start}, {a.hull, a.end}, {b.hull, b.end}};
    const qcPlacedSupport &startA = hulls.startA, &startB = hulls.startB;
    const btScalar error = hulls.error;
    bool isNew = a.isNew || b.isNew || touching.Include(pair);
    btScalar depth = isNew ? std::max(error, qcCornerRounding(a, b) / 2) : error;
    bool areTouching = isNew && m_axes.AreTouching(a.object, startA, b.object, startB);
    btVector3 kept = m_axes.GetAxis(a.object, a.end, b.object, b.end);
    if (!areTouching && hulls.AreSeparatedAlong(kept))
        return true;
    btVector3 keptAtStart = m_axes.GetAxis(a.object, a.start, b.object, b.start);
    if (areTouching || (isNew && !keptAtStart.fuzzyZero() && qcTouchAlong(startA, startB, keptAtStart)))
    {
        *touch = {true, keptAtStart, depth};
        return true;
    }
    // Only hulls that overlap by rounding need more than the search for the largest gap.
    qcSeparation atStart = isNew ? qcFindSeparation(startA, startB, kept, BT_LARGE_FLOAT, 0)
                                 : qcSeparateHulls(startA, startB, kept, BT_LARGE_FLOAT);
    // Those that have been kept touching are as close as they were, but the bound of rounding is not the same.
    const btScalar factor = touching.Include(pair) ? btScalar(2) : btScalar(1);
    if (isNew && atStart.gap <= factor * error && atStart.gap >= -factor * depth)
    {
        *touch = {true, atStart.axis, depth};
        return true;
    }
    return hulls.AreSeparated(atStart);
}

void qcMotionCertificates::RemoveSeparated(const std::set<qcPairNumbers>& inner, qcTouchingPairs* touching,
                                           qcMotionPlanes* planes, std::vector<qcSweptPair>* pairs)
{
    const std::vector<qcSweptPair> all = *pairs;
    m_touches.resize(all.size());
    auto isSeparated = [&](size_t i)
    {
        m_touches[i].touches = false;
        return qcHaveHulls(*all[i].first, *all[i].second, inner) && IsSeparated(all[i], *touching, &m_touches[i]);
    };
    Remove(s_hullBlock, isSeparated, pairs);
    touching->BeginRound();
    for (size_t i = 0; i < all.size(); i++)
        if (m_touches[i].touches)
            touching->Keep(all[i], m_touches[i].axis, m_touches[i].depth, planes);
}
