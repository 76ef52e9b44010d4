// What a contestant's steps measured.
#include "bench/piles/measure.h"

#include "common/bullet/body_transform.h"

#include <algorithm>

namespace
{
constexpr uint32_t s_depthInterval = 8;
constexpr double s_restSpeed = 0.1;

enum Group : uint32_t
{
    s_fixed = 1,
    s_moving = 2
};

/// How far the lowest vertex is below the ground.
double DepthInGround(const qcTriangles& model, const btTransform& place)
{
    double depth = 0;
    for (size_t i = 0; i < model.positions.size(); i += 3)
    {
        btVector3 p(model.positions[i], model.positions[i + 1], model.positions[i + 2]);
        depth = std::max(depth, -double((place * p).y()));
    }
    return depth;
}
} // namespace

void qcPilesFigures::Add(const qcPilesFigures& other)
{
    for (int i = 0; i < qc_pilesPhaseCount; i++)
        phases[i].Add(other.phases[i]);
    longestMs = std::max(longestMs, other.longestMs);
    deepest = std::max(deepest, other.deepest);
    underGround = std::max(underGround, other.underGround);
    penetrating += other.penetrating;
    ends.insert(ends.end(), other.ends.begin(), other.ends.end());
}

size_t qcPilesFigures::RestlessStarts() const
{
    return size_t(std::count_if(ends.begin(), ends.end(), [](const qcPilesEnd& end) { return end.restSeconds < 0; }));
}

double qcPilesFigures::RestSeconds() const
{
    double latest = -1;
    for (const qcPilesEnd& end : ends)
        latest = std::max(latest, end.restSeconds);
    return latest;
}

double qcPilesFigures::Drift() const
{
    double sum = 0;
    for (const qcPilesEnd& end : ends)
        sum += end.drift;
    return sum / double(ends.size());
}

qcPilesDepth::qcPilesDepth(const qcPilesSetup& setup) : m_setup(setup)
{
    qcSceneDef def = qcDefaultSceneDef();
    m_status = qcScene_Create(&def, &m_scene);
    for (const qcPilesBody& body : setup.bodies)
    {
        m_ids.emplace_back();
        if (m_status == qc_statusOk)
            m_status = AddMesh(setup.models[body.model], false, &m_ids.back());
    }
    qcBodyId bin;
    if (setup.binHalf > 0 && m_status == qc_statusOk)
        m_status = AddMesh(qcMakeBin(setup.binHalf, 3, 4), true, &bin);
}

qcPilesDepth::~qcPilesDepth()
{
    qcScene_Destroy(m_scene);
}

qcStatus qcPilesDepth::AddMesh(const qcTriangles& mesh, bool isFixed, qcBodyId* id)
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = mesh.positions.data();
    def.positionType = qcBulletPositions;
    def.vertexCount = uint32_t(mesh.positions.size() / 3);
    def.indices = mesh.indices.data();
    def.triangleCount = uint32_t(mesh.indices.size() / 3);
    def.selfCollision = false;
    def.group = isFixed ? s_fixed : s_moving;
    def.mask = isFixed ? s_moving : s_moving | s_fixed;
    return qcScene_AddBody(m_scene, &def, id);
}

bool qcPilesDepth::Measure(const qcPilesWorld& world, qcPilesFigures* figures)
{
    for (size_t i = 0; i < m_ids.size() && m_status == qc_statusOk; i++)
    {
        const btTransform& place = world.Bodies()[i]->getWorldTransform();
        qcTransform transform = qcBodyTransformOf(place);
        m_status = qcScene_SetTransform(m_scene, m_ids[i], &transform);
        figures->underGround =
            std::max(figures->underGround, DepthInGround(m_setup.models[m_setup.bodies[i].model], place));
    }
    qcDetectDef def = qcDefaultDetectDef();
    def.method = qc_methodSweep;
    def.manifolds = true;
    const qcResult* result = nullptr;
    if (m_status == qc_statusOk)
        m_status = qcScene_Detect(m_scene, &def, &result);
    if (m_status != qc_statusOk)
        return false;
    figures->penetrating = result->pairCount;
    for (size_t i = 0; i < result->manifoldPointCount; i++)
        figures->deepest = std::max(figures->deepest, -result->manifoldPoints[i].distance);
    return true;
}

qcPilesRun::qcPilesRun(const qcPilesSceneDef& def, const qcPilesSetup& setup, qcPilesContestant contestant,
                       uint32_t steps, unsigned threads)
    : m_steps(steps), m_world(setup, contestant, threads), m_depth(setup)
{
    m_figures.scene = &def;
    m_figures.contestant = contestant;
    m_figures.bodies = setup.bodies.size();
    for (const qcPilesBody& body : setup.bodies)
        m_figures.triangles += setup.models[body.model].indices.size() / 3;
}

qcPilesPhaseName qcPilesRun::PhaseOf(uint32_t step) const
{
    if (step > m_steps)
        return qc_pilesAsleep;
    return step > m_steps - m_steps / 3 ? qc_pilesRest : step > m_steps / 3 ? qc_pilesSettling : qc_pilesFalling;
}

/// Finds how far the bodies drift at rest.
void qcPilesRun::TakePlaces(uint32_t step)
{
    if (PhaseOf(step) == qc_pilesRest && m_places.empty())
        for (const auto& body : m_world.Bodies())
            m_places.push_back(body->getWorldTransform().getOrigin());
    double& drift = m_figures.ends[0].drift;
    for (size_t i = 0; step == m_steps && i < m_places.size(); i++)
        drift = std::max(drift, double(m_world.Bodies()[i]->getWorldTransform().getOrigin().distance(m_places[i])));
}

bool qcPilesRun::Step(std::string* message)
{
    if (m_taken == m_steps)
        m_world.Sleep();
    uint32_t step = ++m_taken;
    double detectionMs, ms = m_world.Step(&detectionMs);
    qcPilesPhase& phase = m_figures.phases[PhaseOf(step)];
    qcPilesState state = m_world.State();
    phase.steps++;
    phase.ms += ms;
    phase.detectionMs += detectionMs;
    phase.points += state.points;
    m_figures.longestMs = std::max(m_figures.longestMs, ms);
    if (m_world.Status() != qc_statusOk)
    {
        *message = qcStatus_Name(m_world.Status());
        return false;
    }
    if (step > m_steps)
        return true;
    double& restSeconds = m_figures.ends[0].restSeconds;
    if (!(state.speed <= s_restSpeed))
        restSeconds = -1;
    else if (restSeconds < 0)
        restSeconds = double(btScalar(step) * qcPilesWorld::stepSeconds);
    TakePlaces(step);
    if (step % s_depthInterval != 0 && step != m_steps)
        return true;
    if (!m_depth.Measure(m_world, &m_figures))
    {
        *message = qcLastMessage();
        return false;
    }
    return true;
}
