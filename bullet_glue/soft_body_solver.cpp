// The soft-body solver: Bullet's constraints, then contacts in rounds, then the exact check.
#include "quickcullide/bullet_soft_body.h"

#include "manifolds.h"
#include "soft_body_response.h"
#include "soft_body_scene.h"

#include <algorithm>
#include <chrono>

namespace
{
// Sweeps over all contacts in a round. On the falling cloth of the main demo, 4 leave penetrating pairs for the next
// round in most steps with deep folds, 8 seldom.
constexpr int s_iterations = 8;
// Rounds before nodes are frozen, and rounds of that before whole bodies are.
constexpr int s_contactRounds = 4;
constexpr size_t s_freezeRounds = 16;

double Now()
{
    using namespace std::chrono;
    return duration<double, std::milli>(steady_clock::now().time_since_epoch()).count();
}
} // namespace

struct qcSoftBodySolver::Implementation
{
    explicit Implementation(qcDevice* device) : scene(device)
    {
    }

    qcSoftBodyScene scene;
    qcManifolds manifolds;
    qcSoftBodyStatistics statistics;
    std::vector<qcSoftConstraint> constraints;
    std::vector<size_t> contactOf;
    std::vector<std::vector<btVector3>> solved; ///< positions after Bullet's own constraints
    const qcResult* result = nullptr;           ///< of the last detection

    void KeepPositions();
    void NoteProfile();
    qcStatus Detect(btScalar contactMargin);
    qcStatus SolveContacts();
    qcStatus FreezeRest();
    qcStatus Resolve();
    void Restore();
};

void qcSoftBodySolver::Implementation::KeepPositions()
{
    solved.resize(scene.Bodies().size());
    for (size_t b = 0; b < scene.Bodies().size(); b++)
    {
        const qcSceneSoftBody& known = scene.Bodies()[b];
        solved[b].resize(size_t(known.NodeCount()));
        for (int i = 0; i < known.NodeCount(); i++)
            solved[b][size_t(i)] = known.body->m_nodes[i].m_x;
    }
}

/// What the last detection ran, and what its stages took.
void qcSoftBodySolver::Implementation::NoteProfile()
{
    const qcProfile& profile = result->profile;
    statistics.method = profile.method;
    statistics.device = profile.device;
    if (profile.fallback != nullptr)
        statistics.fallback = profile.fallback;
    statistics.cullMs += profile.cullObjectsMs + profile.cullTrianglesMs;
    statistics.sweepMs += profile.sweepObjectsMs + profile.sweepTrianglesMs;
    statistics.exactMs += profile.exactMs;
    statistics.contactMs += profile.contactMs;
}

/// Fills result, and the statistics with what it cost and what penetrates.
qcStatus qcSoftBodySolver::Implementation::Detect(btScalar contactMargin)
{
    double start = Now();
    qcStatus status = scene.UpdateVertices();
    if (status == qc_statusOk)
        status = scene.Detect(contactMargin, &result);
    statistics.detectMs += Now() - start;
    if (status != qc_statusOk)
        return status;
    NoteProfile();
    auto isWanted = [this](const qcPair& pair) { return qcMayPush(*scene.Find(pair.bodyA), *scene.Find(pair.bodyB)); };
    statistics.remaining = int(std::count_if(result->pairs, result->pairs + result->pairCount, isWanted));
    return qc_statusOk;
}

/// Rounds of detection and projection until nothing penetrates, or rounds are up.
qcStatus qcSoftBodySolver::Implementation::SolveContacts()
{
    btScalar margin = scene.Thickness();
    for (int round = 0; round < s_contactRounds; round++)
    {
        qcStatus status = Detect(margin);
        if (status != qc_statusOk)
            return status;
        qcMakeSoftConstraints(scene, *result, &constraints, &contactOf);
        if (round == 0)
        {
            statistics.contacts = int(constraints.size());
            statistics.penetrating = statistics.remaining;
            manifolds.Publish(scene, *result, contactOf);
        }
        if (constraints.empty())
            return qc_statusOk;
        double start = Now();
        qcSolveSoftConstraints(constraints, s_iterations);
        statistics.respondMs += Now() - start;
        statistics.rounds++;
        status = Detect(0);
        if (status != qc_statusOk || statistics.remaining == 0)
            return status;
    }
    return qc_statusOk;
}

/// Whatever still penetrates and did not at the start goes back there: first the nodes of the triangles alone; when
/// that does not end it, whole bodies, of which each round takes one more at least.
qcStatus qcSoftBodySolver::Implementation::FreezeRest()
{
    for (size_t round = 0; round < s_freezeRounds + scene.Bodies().size() + 1; round++)
    {
        int moved = qcFreezePenetrating(scene, *result, round >= s_freezeRounds);
        statistics.frozenNodes += moved;
        if (moved == 0)
            return qc_statusOk;
        qcStatus status = Detect(0);
        if (status != qc_statusOk)
            return status;
    }
    return qc_statusOk;
}

qcStatus qcSoftBodySolver::Implementation::Resolve()
{
    qcStatus status = SolveContacts();
    return status == qc_statusOk && statistics.remaining > 0 ? FreezeRest() : status;
}

/// Bullet's own positions again, after a query failed.
void qcSoftBodySolver::Implementation::Restore()
{
    for (size_t b = 0; b < scene.Bodies().size(); b++)
        for (int i = 0; i < scene.Bodies()[b].NodeCount(); i++)
            scene.Bodies()[b].body->m_nodes[i].m_x = solved[b][size_t(i)];
}

qcSoftBodySolver::qcSoftBodySolver(qcDevice* device) : m_implementation(new Implementation(device))
{
}

qcSoftBodySolver::~qcSoftBodySolver() = default;

void qcSoftBodySolver::setSettings(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    m_implementation->scene.SetSettings(body, settings);
}

qcSoftBodySettings qcSoftBodySolver::getSettings(const btSoftBody* body) const
{
    return m_implementation->scene.GetSettings(body);
}

const qcSoftBodyStatistics& qcSoftBodySolver::getStatistics() const
{
    return m_implementation->statistics;
}

void qcSoftBodySolver::setThreadCount(unsigned threads)
{
    m_implementation->scene.threads = threads;
}

void qcSoftBodySolver::setMethod(qcMethod method)
{
    m_implementation->scene.method = method;
}

void qcSoftBodySolver::optimize(btAlignedObjectArray<btSoftBody*>& softBodies, bool forceUpdate)
{
    // The first call of a step, before collision detection: nothing of the last step may be seen there.
    m_implementation->manifolds.Release(softBodies);
    btDefaultSoftBodySolver::optimize(softBodies, forceUpdate);
}

void qcSoftBodySolver::processCollision(btSoftBody*, btSoftBody*)
{
    // Solved with all others after Bullet's own constraints, when positions are known.
}

void qcSoftBodySolver::solveConstraints(btScalar timeStep)
{
    Implementation& my = *m_implementation;
    my.statistics = qcSoftBodyStatistics();
    my.statistics.status = my.scene.Synchronize(m_softBodySet);
    btDefaultSoftBodySolver::solveConstraints(timeStep);
    if (my.statistics.status != qc_statusOk)
        return;
    my.KeepPositions();
    my.statistics.status = my.Resolve();
    if (my.statistics.status != qc_statusOk)
    {
        my.Restore();
        return;
    }
    qcUpdateVelocities(my.scene, my.solved);
}
