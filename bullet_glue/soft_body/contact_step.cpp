// The stages of contact in a step: continuous collision of nodes and links, untangling, contacts in rounds, then
// separating planes and rigid zones for pairs that still penetrate.
#include "soft_body/contact_step.h"

#include "common/stopwatch.h"
#include "soft_body/response/node_ccd.h"
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

void qcSoftBodyContact::Implementation::BeginStep(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    manifolds.Release();
    for (int i = 0; i < bodies.size(); i++)
        algorithmOverride.Register(bodies[i]->getWorldInfo()->m_dispatcher);
}

void qcSoftBodyContact::Implementation::ReadStart(const btAlignedObjectArray<btSoftBody*>& bodies,
                                                  btVector3 btSoftBody::Node::*start)
{
    BT_PROFILE("qcSoftBodyContact gather");
    double begin = qcNowMs();
    m_candidates.Clear();
    statistics = qcSoftBodyStatistics();
    statistics.status = scene.Sync(bodies, start);
    statistics.gatherMs = qcNowMs() - begin;
}

//  ---- detection and projection ------------------------------------------------------------------------------------

/// Adds the times of the last detection to the statistics, and records which method ran.
void qcSoftBodyContact::Implementation::AddProfile()
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

/// Fills m_result for the present positions, and sorts its penetrating pairs into unproven and exempt ones.
qcStatus qcSoftBodyContact::Implementation::Detect(btScalar contactMargin, bool segments)
{
    BT_PROFILE("qcSoftBodyContact detect");
    double begin = qcNowMs();
    qcStatus status = scene.SyncPositions();
    double gathered = qcNowMs();
    statistics.gatherMs += gathered - begin;
    if (status == qc_statusOk)
        status = scene.Detect(contactMargin, segments, &m_result);
    statistics.detectMs += qcNowMs() - gathered;
    if (status != qc_statusOk)
        return status;
    AddProfile();
    m_unproven.clear();
    for (size_t i = 0; i < m_result->pairCount; i++)
        if (qcHasResponse(scene, m_result->pairs[i].bodyA, m_result->pairs[i].bodyB))
            m_unproven.push_back(i);
    statistics.remaining = int(m_unproven.size());
    m_tangles.MoveExempt(scene, *m_result, &m_unproven, &m_exempt);
    return qc_statusOk;
}

/// Projects positions and meshes onto m_constraints.
void qcSoftBodyContact::Implementation::SolveConstraints()
{
    if (m_constraints.empty())
        return;
    BT_PROFILE("qcSoftBodyContact respond");
    double begin = qcNowMs();
    if (solvesLinks)
        qcCollectLinks(scene, &m_links);
    qcSolveSoftConstraints(&m_constraints, m_links, &m_rigidNodeContacts, s_iterations);
    scene.meshes.Commit();
    statistics.respondMs += qcNowMs() - begin;
}

//  ---- stages, in their order --------------------------------------------------------------------------------------

/// Finds the tangles: pairs that penetrate at the start of the step. If the step starts where the previous one ended,
/// its last result has them already.
qcStatus qcSoftBodyContact::Implementation::FindTangles()
{
    bool areFound = m_tanglesAreOfEnd && scene.StartsWhereStepEnded();
    m_tanglesAreOfEnd = false;
    if (areFound)
        return qc_statusOk;
    double begin = qcNowMs();
    qcStatus status = scene.SyncStartPositions();
    if (status == qc_statusOk)
        status = scene.Detect(0, false, &m_result);
    if (status == qc_statusOk)
        m_tangles.Read(scene, *m_result);
    statistics.detectMs += qcNowMs() - begin;
    return status;
}

/// Brings back nodes and rope links that went through a mesh.
void qcSoftBodyContact::Implementation::SolveCcd()
{
    qcMakeNodeCcdConstraints(scene, &m_constraints);
    qcAddLinkCcdConstraints(scene, &m_constraints);
    statistics.sweptNodes = int(m_constraints.size());
    SolveConstraints();
}

/// Moves tangled surfaces towards separation.
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

/// True if a rope link is on the other side of a mesh's edge than at the start of the step. A link that has passed a
/// thin mesh completely penetrates nothing.
bool qcSoftBodyContact::Implementation::HaveLinksCrossed()
{
    m_constraints.clear();
    qcAddLinkCcdConstraints(scene, &m_constraints);
    return !m_constraints.empty();
}

/// Alternates detection and projection until nothing penetrates, for a limited number of rounds.
qcStatus qcSoftBodyContact::Implementation::SolveContacts()
{
    btScalar margin = scene.ContactDistance();
    for (int round = 0; round < s_contactRounds; round++)
    {
        BT_PROFILE("qcSoftBodyContact round");
        qcStatus status = Detect(margin);
        if (status != qc_statusOk)
            return status;
        qcMakeSoftConstraints(scene, m_tangles, *m_result, &m_constraints, &m_contactOfConstraint);
        if (round == 0)
        {
            statistics.contacts = int(m_constraints.size());
            statistics.penetrating = statistics.remaining;
            m_candidates.Record(*m_result);
            manifolds.Publish(scene, *m_result, m_contactOfConstraint);
        }
        qcAddLinkCcdConstraints(scene, &m_constraints);
        if (m_constraints.empty())
            return qc_statusOk;
        SolveConstraints();
        statistics.rounds++;
        status = Detect(0);
        if (status != qc_statusOk || (m_unproven.empty() && !HaveLinksCrossed()))
            return status;
    }
    return qc_statusOk;
}

/// Pushes unproven pairs apart along the directions in which they were separated at the start of the step.
qcStatus qcSoftBodyContact::Implementation::SolvePlanes()
{
    if (m_unproven.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact push apart");
    m_planes.Clear();
    for (int round = 0; round < s_planeRounds && !m_unproven.empty(); round++)
    {
        double begin = qcNowMs();
        for (size_t i : m_unproven)
            m_planes.Add(scene, m_result->pairs[i]);
        m_planes.Solve(s_planeSweeps);
        scene.meshes.Commit();
        statistics.respondMs += qcNowMs() - begin;
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
    statistics.planes = int(m_planes.Count());
    return qc_statusOk;
}

/// Moves nodes and meshes that planes could not separate in zones, as one rigid body each, from the start of the step.
/// Each round unites zones or returns one to its start, so the loop ends.
qcStatus qcSoftBodyContact::Implementation::MoveZones()
{
    if (m_unproven.empty())
        return qc_statusOk;
    BT_PROFILE("qcSoftBodyContact move zones");
    m_zones.Clear();
    for (bool changed = true; changed && !m_unproven.empty();)
    {
        changed = false;
        for (size_t i : m_unproven)
            changed = m_zones.Add(m_result->pairs[i]) || changed;
        m_zones.Move();
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
    statistics.zoneNodes = statistics.frozenNodes = m_zones.NodeCount();
    return qc_statusOk;
}

qcStatus qcSoftBodyContact::Implementation::RunStages(btScalar timeStep)
{
    double begin = qcNowMs();
    qcStatus status = scene.ReadSolved(timeStep);
    statistics.meshes = int(scene.meshes.Rigids().size());
    if (status == qc_statusOk)
        qcCollectRigidNodeContacts(scene, &m_rigidNodeContacts);
    statistics.gatherMs += qcNowMs() - begin;
    if (status == qc_statusOk)
        status = FindTangles();
    if (status == qc_statusOk)
    {
        SolveCcd();
        status = Untangle();
    }
    if (status == qc_statusOk)
        status = SolveContacts();
    if (status == qc_statusOk)
        status = SolvePlanes();
    if (status == qc_statusOk)
        status = MoveZones();
    if (status != qc_statusOk)
        return status;
    statistics.unproven = int(m_unproven.size());
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
    statistics.status = RunStages(timeStep);
    if (statistics.status != qc_statusOk)
    {
        scene.meshes.Restore();
        return false;
    }
    scene.meshes.UpdateVelocities(timeStep);
    qcApplyRigidNodeImpulses(m_rigidNodeContacts, timeStep);
    return true;
}

void qcSoftBodyContact::Implementation::DispatchCallbacks()
{
    BT_PROFILE("qcSoftBodyContact callbacks");
    manifolds.DispatchCallbacks();
}

//  ---- public functions --------------------------------------------------------------------------------------------

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
