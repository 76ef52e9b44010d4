// Contact of soft bodies: nodes that went through meshes, contacts in rounds, then planes and zones for what still
// penetrates.
#include "soft_body/contact_step.h"

#include "common/stopwatch.h"
#include "soft_body/response/untangle.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Sweeps over all contacts in a round. On the falling cloth of the main demo, 4 leave penetrating pairs for the next
// round in most steps with deep folds, 8 seldom.
constexpr int s_iterations = 8;
constexpr int s_contactRounds = 4;
// Rounds of planes, and sweeps over all planes in each.
constexpr int s_planeRounds = 6, s_planeSweeps = 6;
} // namespace

void qcSoftBodyContact::Implementation::Begin(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    manifolds.Release();
    for (int i = 0; i < bodies.size(); i++)
        takeOver.Register(bodies[i]->getWorldInfo()->m_dispatcher);
}

void qcSoftBodyContact::Implementation::Start(const btAlignedObjectArray<btSoftBody*>& bodies,
                                              btVector3 btSoftBody::Node::*start)
{
    BT_PROFILE("qcSoftBodyContact gather");
    double before = qcNowMs();
    m_candidates.Clear();
    statistics = qcSoftBodyStatistics();
    statistics.status = scene.Synchronize(bodies, start);
    statistics.gatherMs = qcNowMs() - before;
}

/// What the last detection ran, and what its stages took.
void qcSoftBodyContact::Implementation::NoteProfile()
{
    const qcProfile& profile = m_result->profile;
    statistics.method = profile.method;
    statistics.device = profile.device;
    if (profile.fallback != nullptr)
        statistics.fallback = profile.fallback;
    statistics.cullMs += profile.cullObjectsMs + profile.cullTrianglesMs;
    statistics.sweepMs += profile.sweepObjectsMs + profile.sweepTrianglesMs;
    statistics.exactMs += profile.exactMs;
    statistics.contactMs += profile.contactMs;
}

/// Fills m_result, and the statistics with what it cost and what penetrates.
qcStatus qcSoftBodyContact::Implementation::Detect(btScalar contactMargin, bool segments)
{
    BT_PROFILE("qcSoftBodyContact detect");
    double start = qcNowMs();
    qcStatus status = scene.UpdatePlaces();
    double gathered = qcNowMs();
    statistics.gatherMs += gathered - start;
    if (status == qc_statusOk)
        status = scene.Detect(contactMargin, segments, &m_result);
    statistics.detectMs += qcNowMs() - gathered;
    if (status != qc_statusOk)
        return status;
    NoteProfile();
    m_held.clear();
    for (size_t i = 0; i < m_result->pairCount; i++)
        if (qcMayPush(scene, m_result->pairs[i].bodyA, m_result->pairs[i].bodyB))
            m_held.push_back(i);
    statistics.remaining = int(m_held.size());
    m_tangles.Split(scene, *m_result, &m_held, &m_exempt);
    return qc_statusOk;
}

void qcSoftBodyContact::Implementation::Solve()
{
    if (m_constraints.empty())
        return;
    BT_PROFILE("qcSoftBodyContact respond");
    double start = qcNowMs();
    if (solvesLinks)
        qcCollectLinks(scene, &m_links);
    qcSolveSoftConstraints(&m_constraints, m_links, &m_supports, s_iterations);
    scene.meshes.Commit();
    statistics.respondMs += qcNowMs() - start;
}

/// Rounds of detection and projection until nothing penetrates, or rounds are up.
qcStatus qcSoftBodyContact::Implementation::SolveContacts()
{
    btScalar margin = scene.Reach();
    for (int round = 0; round < s_contactRounds; round++)
    {
        BT_PROFILE("qcSoftBodyContact round");
        qcStatus status = Detect(margin);
        if (status != qc_statusOk)
            return status;
        qcMakeSoftConstraints(scene, m_tangles, *m_result, &m_constraints, &m_contactOf);
        if (round == 0)
        {
            statistics.contacts = int(m_constraints.size());
            statistics.penetrating = statistics.remaining;
            m_candidates.Note(*m_result);
            manifolds.Publish(scene, *m_result, m_contactOf);
        }
        qcAddSweptLinks(scene, &m_constraints);
        if (m_constraints.empty())
            return qc_statusOk;
        Solve();
        statistics.rounds++;
        status = Detect(0);
        if (status != qc_statusOk || (m_held.empty() && !AreLinksThrough()))
            return status;
    }
    return qc_statusOk;
}

/// Is some rope link on the other side of a mesh's edge than at the start of the step? Where it has passed a thin mesh
/// altogether no pair penetrates.
bool qcSoftBodyContact::Implementation::AreLinksThrough()
{
    m_constraints.clear();
    qcAddSweptLinks(scene, &m_constraints);
    return !m_constraints.empty();
}

/// Finds the triangles that penetrate at the start of the step. Where that is the end of the step before, its last
/// result holds them already.
qcStatus qcSoftBodyContact::Implementation::FindTangles()
{
    bool known = m_tanglesAreOfEnd && scene.StartsWhereItEnded();
    m_tanglesAreOfEnd = false;
    if (known)
        return qc_statusOk;
    double start = qcNowMs();
    qcStatus status = scene.PlaceAtStart();
    if (status == qc_statusOk)
        status = scene.Detect(0, false, &m_result);
    if (status == qc_statusOk)
        m_tangles.Read(scene, *m_result);
    statistics.detectMs += qcNowMs() - start;
    return status;
}

/// Moves tangled surfaces towards where they come apart.
qcStatus qcSoftBodyContact::Implementation::Untangle()
{
    if (m_tangles.IsEmpty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact untangle");
    qcStatus status = Detect(0, true);
    if (status == qc_statusOk)
        qcUntangle(scene, *m_result, m_exempt);
    return status;
}

/// Pushes pairs apart along the directions in which they were apart at the start of the step.
qcStatus qcSoftBodyContact::Implementation::PushApart()
{
    if (m_held.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact push apart");
    m_planes.Clear();
    for (int round = 0; round < s_planeRounds && !m_held.empty(); round++)
    {
        double start = qcNowMs();
        for (size_t i : m_held)
            m_planes.Add(scene, m_result->pairs[i]);
        m_planes.Solve(s_planeSweeps);
        scene.meshes.Commit();
        statistics.respondMs += qcNowMs() - start;
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
    statistics.planes = int(m_planes.Count());
    return qc_statusOk;
}

/// Moves what planes could not part as one, from the start of the step. Zones only grow, or go back to the start, so
/// this ends.
qcStatus qcSoftBodyContact::Implementation::MoveZones()
{
    if (m_held.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact move zones");
    m_zones.Clear();
    for (bool changed = true; changed && !m_held.empty();)
    {
        changed = false;
        for (size_t i : m_held)
            changed = m_zones.Add(m_result->pairs[i]) || changed;
        m_zones.Move();
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
    statistics.zoneNodes = statistics.frozenNodes = m_zones.NodeCount();
    return qc_statusOk;
}

qcStatus qcSoftBodyContact::Implementation::TryResolve(btScalar timeStep)
{
    double start = qcNowMs();
    qcStatus status = scene.TakeSolved(timeStep);
    statistics.meshes = int(scene.meshes.Rigids().size());
    if (status == qc_statusOk)
        qcCollectSupports(scene, &m_supports);
    statistics.gatherMs += qcNowMs() - start;
    if (status == qc_statusOk)
        status = FindTangles();
    if (status != qc_statusOk)
        return status;
    qcMakeSweptConstraints(scene, &m_constraints);
    qcAddSweptLinks(scene, &m_constraints);
    statistics.sweptNodes = int(m_constraints.size());
    Solve();
    status = Untangle();
    if (status == qc_statusOk)
        status = SolveContacts();
    if (status == qc_statusOk)
        status = PushApart();
    if (status == qc_statusOk)
        status = MoveZones();
    if (status != qc_statusOk)
        return status;
    statistics.unproven = int(m_held.size());
    statistics.exempt = statistics.remaining - statistics.unproven;
    m_tangles.Read(scene, *m_result);
    m_tanglesAreOfEnd = true;
    return qc_statusOk;
}

bool qcSoftBodyContact::Implementation::Resolve(btScalar timeStep)
{
    if (statistics.status != qc_statusOk)
        return false;
    BT_PROFILE("qcSoftBodyContact resolve");
    statistics.status = TryResolve(timeStep);
    if (statistics.status != qc_statusOk)
    {
        scene.meshes.Restore();
        return false;
    }
    scene.meshes.UpdateVelocities(timeStep);
    qcApplySupports(m_supports, timeStep);
    return true;
}

void qcSoftBodyContact::Implementation::Tell()
{
    BT_PROFILE("qcSoftBodyContact callbacks");
    manifolds.Tell();
}

qcSoftBodyContact::qcSoftBodyContact(qcDevice* device) : m_implementation(new Implementation(device))
{
}

qcSoftBodyContact::~qcSoftBodyContact() = default;

void qcSoftBodyContact::setSettings(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    m_implementation->scene.SetSettings(body, settings);
}

qcSoftBodySettings qcSoftBodyContact::getSettings(const btSoftBody* body) const
{
    return m_implementation->scene.GetSettings(body);
}

const qcSoftBodyStatistics& qcSoftBodyContact::getStatistics() const
{
    return m_implementation->statistics;
}

void qcSoftBodyContact::debugDraw(btIDebugDraw* drawer) const
{
    m_implementation->Draw(drawer);
}

void qcSoftBodyContact::setThreadCount(unsigned threads)
{
    m_implementation->scene.threads = threads;
}

void qcSoftBodyContact::setMethod(qcMethod method)
{
    m_implementation->scene.method = method;
}
