// Contact of soft bodies: nodes that went through meshes, contacts in rounds, then the exact check.
#include "soft_body_contact.h"

#include "clock.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Sweeps over all contacts in a round. On the falling cloth of the main demo, 4 leave penetrating pairs for the next
// round in most steps with deep folds, 8 seldom.
constexpr int s_iterations = 8;
// Rounds before nodes are frozen, and rounds of that before whole bodies are.
constexpr int s_contactRounds = 4;
constexpr size_t s_freezeRounds = 16;

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
qcStatus qcSoftBodyContact::Implementation::Detect(btScalar contactMargin)
{
    BT_PROFILE("qcSoftBodyContact detect");
    double start = qcNowMs();
    qcStatus status = scene.UpdatePlaces();
    double gathered = qcNowMs();
    statistics.gatherMs += gathered - start;
    if (status == qc_statusOk)
        status = scene.Detect(contactMargin, &m_result);
    statistics.detectMs += qcNowMs() - gathered;
    if (status != qc_statusOk)
        return status;
    NoteProfile();
    auto isWanted = [this](const qcPair& pair) { return qcMayPush(scene, pair.bodyA, pair.bodyB); };
    statistics.remaining = int(std::count_if(m_result->pairs, m_result->pairs + m_result->pairCount, isWanted));
    return qc_statusOk;
}

void qcSoftBodyContact::Implementation::Solve()
{
    if (m_constraints.empty())
        return;
    BT_PROFILE("qcSoftBodyContact respond");
    double start = qcNowMs();
    qcSolveSoftConstraints(m_constraints, &m_supports, s_iterations);
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
        qcMakeSoftConstraints(scene, *m_result, &m_constraints, &m_contactOf);
        if (round == 0)
        {
            statistics.contacts = int(m_constraints.size());
            statistics.penetrating = statistics.remaining;
            m_candidates.Note(*m_result);
            manifolds.Publish(scene, *m_result, m_contactOf);
        }
        if (m_constraints.empty())
            return qc_statusOk;
        Solve();
        statistics.rounds++;
        status = Detect(0);
        if (status != qc_statusOk || statistics.remaining == 0)
            return status;
    }
    return qc_statusOk;
}

/// Whatever still penetrates and did not at the start goes back there: first the nodes of the triangles alone; when
/// that does not end it, whole bodies, of which each round takes one more at least.
qcStatus qcSoftBodyContact::Implementation::FreezeRest()
{
    BT_PROFILE("qcSoftBodyContact freeze");
    size_t bodies = scene.Bodies().size() + scene.meshes.Rigids().size();
    for (size_t round = 0; round < s_freezeRounds + bodies + 1; round++)
    {
        int moved = qcFreezePenetrating(scene, *m_result, round >= s_freezeRounds);
        statistics.frozenNodes += moved;
        if (moved == 0)
            return qc_statusOk;
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
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
    if (status != qc_statusOk)
        return status;
    qcMakeSweptConstraints(scene, &m_constraints);
    statistics.sweptNodes = int(m_constraints.size());
    Solve();
    status = SolveContacts();
    return status == qc_statusOk && statistics.remaining > 0 ? FreezeRest() : status;
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
