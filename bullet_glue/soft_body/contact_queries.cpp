// The queries of a step of soft bodies: what penetrates or has contact, and what is not proven apart over the step.
#include "soft_body/contact_step.h"

#include "common/stopwatch.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cstddef>
#include <cstring>

/// Adds the times of the last detection to the statistics.
void qcSoftBodyContact::Implementation::AddProfile()
{
    const qcProfile& profile = m_result->profile;
    statistics.cullMs += profile.cullObjectsMs + profile.cullTrianglesMs;
    statistics.sweepMs += profile.sweepObjectsMs + profile.sweepTrianglesMs;
    statistics.exactMs += profile.exactMs;
    statistics.contactMs += profile.contactMs;
}

/// Fills m_result for the present positions by a query, detect().
template <typename Function> qcStatus qcSoftBodyContact::Implementation::Query(const Function& detect)
{
    BT_PROFILE("qcSoftBodyContact detect");
    double begin = qcNowMs();
    qcStatus status = scene.SyncPositions();
    double gathered = qcNowMs();
    statistics.gatherMs += gathered - begin;
    if (status == qc_statusOk)
        status = detect();
    statistics.detectMs += qcNowMs() - gathered;
    if (status != qc_statusOk)
        return status;
    AddProfile();
    statistics.method = m_result->profile.method;
    statistics.device = m_result->profile.device;
    if (m_result->profile.fallback != nullptr)
        statistics.fallback = m_result->profile.fallback;
    auto hasResponse = [this](const qcPair& pair) { return qcHasResponse(scene, pair); };
    statistics.remaining = int(std::count_if(m_result->pairs, m_result->pairs + m_result->pairCount, hasResponse));
    m_isDetected = true;
    return qc_statusOk;
}

/// Finds pairs that penetrate and, with a margin, contacts.
qcStatus qcSoftBodyContact::Implementation::Detect(btScalar contactMargin)
{
    return Query([&] { return scene.Detect(contactMargin, &m_result); });
}

/// Finds the pairs that penetrate, but for those that the last query for contacts and the motion since prove apart.
qcStatus qcSoftBodyContact::Implementation::DetectEnd()
{
    for (const qcSceneSoftBody& soft : scene.Bodies())
        m_clearance.MeasureEnd(soft.id.slot, soft.positions);
    auto isApart = [this](uint32_t slotA, uint32_t slotB) { return m_clearance.AreApartAtEnd(slotA, slotB); };
    return Query([&] { return scene.DetectPenetrating(isApart, &m_result); });
}

/// Sets the positions of the start of the step in the scene, as the start of the motion.
qcStatus qcSoftBodyContact::Implementation::MarkStart()
{
    double begin = qcNowMs();
    m_isCertified = m_isDetected = false;
    qcStatus status = scene.MarkStart();
    statistics.gatherMs += qcNowMs() - begin;
    return status;
}

/// True if the motion of one of the bodies is certified against all others.
bool qcSoftBodyContact::Implementation::IsContinuous(const qcPair& pair)
{
    const qcSceneSoftBody *a = scene.Find(pair.bodyA), *b = scene.Find(pair.bodyB);
    return (a != nullptr && a->settings.continuous) || (b != nullptr && b->settings.continuous);
}

/// Fills m_unproven and m_keptTangles from the result.
void qcSoftBodyContact::Implementation::SortMotionPairs()
{
    m_unproven.clear();
    m_keptTangles.clear();
    m_exemptMotions = 0;
    for (size_t i = 0; i < m_result->pairCount; i++)
    {
        const qcPair& pair = m_result->pairs[i];
        const qcProximity& start = m_result->proximities[i];
        if (!IsContinuous(pair) || !qcHasResponse(scene, pair))
            continue;
        const qcUnprovenPair unproven = qcMakeUnproven(scene, pair, start);
        qcTouchingMotion touching = unproven.distance == 0 && pair.relation != qc_relationPenetrating
                                        ? qcClassifyTouching(scene, unproven, m_movesZones)
                                        : qcTouchingMotion::Unproven;
        bool isProven = touching == qcTouchingMotion::Proven ||
                        (touching == qcTouchingMotion::Unproven && m_zones.KeepsApart(pair, btScalar(start.distance)));
        if (pair.relation == qc_relationPenetrating || touching == qcTouchingMotion::Entangled ||
            (!isProven && m_tangles.MayLeave(scene, pair)))
            m_exemptMotions++;
        else if (!isProven)
            (m_tangles.IsKept(scene, pair) ? m_keptTangles : m_unproven).push_back(unproven);
    }
}

/// Moves pairs near a kept tangle that has grown to m_unproven; exempts the others.
qcStatus qcSoftBodyContact::Implementation::ExemptKeptTangles()
{
    if (m_keptTangles.empty())
        return qc_statusOk;
    qcStatus status = Detect(0);
    if (status != qc_statusOk)
        return status;
    for (const qcUnprovenPair& kept : m_keptTangles)
        if (m_tangles.HasGrown(*m_result, kept.pair.bodyA, kept.pair.bodyB))
            m_unproven.push_back(kept);
        else
            m_exemptMotions++;
    return qc_statusOk;
}

/// Finds the pairs that are not proven apart from the start of the step to the present positions.
qcStatus qcSoftBodyContact::Implementation::Certify()
{
    BT_PROFILE("qcSoftBodyContact certify");
    m_isCertified = true;
    m_unproven.clear();
    m_exemptMotions = 0;
    if (scene.IsDiscrete())
        return qc_statusOk;
    m_isDetected = false;
    double begin = qcNowMs();
    qcStatus status = scene.SyncPositions();
    double gathered = qcNowMs();
    statistics.gatherMs += gathered - begin;
    for (const qcSceneSoftBody& soft : scene.Bodies())
        m_clearance.MeasureEnd(soft.id.slot, soft.positions);
    if (status == qc_statusOk)
        status = scene.DetectMotion(
            [this](uint32_t slotA, uint32_t slotB) { return m_clearance.KeepsApart(slotA, slotB); }, &m_result);
    statistics.detectMs += qcNowMs() - gathered;
    if (status != qc_statusOk)
        return status;
    AddProfile();
    SortMotionPairs();
    return ExemptKeptTangles();
}

/// Finds the tangles of the end of the step, which are among the pairs that were exempt or are unproven.
qcStatus qcSoftBodyContact::Implementation::ReadEnd()
{
    statistics.unproven = int(m_unproven.size());
    statistics.exempt = 0;
    m_tangles.Clear();
    m_curves.Clear();
    m_tanglesAreOfEnd = true;
    if (m_exemptMotions == 0 && m_unproven.empty() && scene.IsContinuous())
    {
        statistics.remaining = 0;
        return qc_statusOk;
    }
    qcStatus status = m_isDetected ? qc_statusOk : DetectEnd();
    if (status != qc_statusOk)
        return status;
    m_tangles.Read(scene, *m_result);
    auto isUnproven = [this](const qcPair& pair)
    {
        return std::any_of(m_unproven.begin(), m_unproven.end(),
                           [&pair](const qcUnprovenPair& unproven)
                           { return std::memcmp(&unproven.pair, &pair, offsetof(qcPair, relation)) == 0; });
    };
    auto count = std::count_if(m_result->pairs, m_result->pairs + m_result->pairCount, isUnproven);
    statistics.exempt = statistics.remaining - int(count);
    return qc_statusOk;
}
