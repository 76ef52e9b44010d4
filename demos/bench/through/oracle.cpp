// Penetrating pairs of triangles at exact times of a step.
#include "bench/through/oracle.h"

#include <algorithm>

namespace
{
constexpr int s_ticks = 32; ///< in a step

// Groups of the scene: fixed bodies are not tested with each other.
constexpr uint32_t s_moving = 1, s_fixed = 2;

//  Version 0.2.0, which is measured with these sources too, has no motion query. Each function has a variant for it,
//  chosen where the first one does not compile.

template <class Scene> auto MarkStart(Scene* scene, int) -> decltype(qcScene_MarkStart(scene))
{
    return qcScene_MarkStart(scene);
}

template <class Scene> qcStatus MarkStart(Scene*, long)
{
    return qc_statusOk;
}

template <class Def> auto RequestMotion(Def* def, int) -> decltype(def->motion)
{
    return def->motion = true;
}

template <class Def> bool RequestMotion(Def*, long)
{
    return false;
}
} // namespace

qcThroughOracle::qcThroughOracle(const qcThroughWorld& world, bool brute) : m_def(qcDefaultDetectDef())
{
    m_def.method = brute ? qc_methodBrute : qc_methodSweep;
    qcSceneDef sceneDef = qcDefaultSceneDef();
    m_isOk = qcScene_Create(&sceneDef, &m_scene) == qc_statusOk;
    for (const qcThroughBody& body : world.Bodies())
    {
        m_bodies.emplace_back();
        Body& added = m_bodies.back();
        added.body = &body;
        Read(body, &added.end);
        bool isFixed = body.rigid != nullptr && body.rigid->isStaticOrKinematicObject();
        qcBodyDef def = qcDefaultBodyDef();
        def.positions = added.end.data();
        def.positionType = qc_positionF64;
        def.vertexCount = uint32_t(added.end.size() / 3);
        def.indices = body.triangles.indices.data();
        def.triangleCount = uint32_t(body.triangles.indices.size() / 3);
        def.deforming = true;
        def.selfCollision = body.soft != nullptr;
        def.group = isFixed ? s_fixed : s_moving;
        def.mask = isFixed ? s_moving : s_moving | s_fixed;
        m_isOk = m_isOk && qcScene_AddBody(m_scene, &def, &added.id) == qc_statusOk;
    }
    m_isOk = m_isOk && Detect(&m_tangled);
}

qcThroughOracle::~qcThroughOracle()
{
    qcScene_Destroy(m_scene);
}

void qcThroughOracle::Read(const qcThroughBody& body, std::vector<double>* positions) const
{
    positions->clear();
    for (int i = 0; body.soft != nullptr && i < body.soft->m_nodes.size(); i++)
        for (int axis = 0; axis < 3; axis++)
            positions->push_back(double(body.soft->m_nodes[i].m_x[axis]));
    if (body.rigid == nullptr)
        return;
    // In the order of qcTransform: the rounded result is that of the library.
    const btTransform& place = body.rigid->getWorldTransform();
    const std::vector<btScalar>& p = body.triangles.positions;
    for (size_t i = 0; i < p.size(); i += 3)
        for (int axis = 0; axis < 3; axis++)
        {
            const btVector3& row = place.getBasis()[axis];
            positions->push_back(double(row[0]) * double(p[i]) + double(row[1]) * double(p[i + 1]) +
                                 double(row[2]) * double(p[i + 2]) + double(place.getOrigin()[axis]));
        }
}

/// Moves the scene to a time of the step, in ticks.
bool qcThroughOracle::Move(int time)
{
    for (Body& body : m_bodies)
    {
        body.now.resize(body.end.size());
        for (size_t i = 0; i < body.end.size(); i++)
            body.now[i] = ((s_ticks - time) * body.start[i] + time * body.end[i]) / s_ticks;
        if (qcScene_SetVertices(m_scene, body.id, body.now.data(), qc_positionF64, 0) != qc_statusOk)
            return false;
    }
    return true;
}

bool qcThroughOracle::Detect(std::vector<Pair>* pairs)
{
    const qcResult* result = nullptr;
    if (qcScene_Detect(m_scene, &m_def, &result) != qc_statusOk)
        return false;
    pairs->clear();
    for (size_t i = 0; i < result->pairCount; i++)
        pairs->push_back(
            {result->pairs[i].bodyA, result->pairs[i].triangleA, result->pairs[i].bodyB, result->pairs[i].triangleB});
    return true;
}

/// The scene is at the end of the step.
bool qcThroughOracle::CountUncertified(qcThroughPairs* pairs)
{
    qcDetectDef motion = m_def;
    const qcResult* result = nullptr;
    if (!RequestMotion(&motion, 0))
        return true;
    if (qcScene_Detect(m_scene, &motion, &result) != qc_statusOk)
        return false;
    // Relations are those of the start.
    for (size_t i = 0; i < result->pairCount; i++)
        pairs->uncertified += result->pairs[i].relation == qc_relationDisjoint;
    return true;
}

bool qcThroughOracle::Step(qcThroughPairs* pairs)
{
    *pairs = qcThroughPairs();
    pairs->tangled = m_tangled.size();
    for (Body& body : m_bodies)
    {
        body.start.swap(body.end);
        Read(*body.body, &body.end);
    }
    auto countNew = [this, pairs](const std::vector<Pair>& found)
    {
        size_t count = 0;
        for (const Pair& pair : found)
        {
            bool isNew = !std::binary_search(m_tangled.begin(), m_tangled.end(), pair);
            count += isNew;
            pairs->example = isNew ? pair : pairs->example;
        }
        return count;
    };
    std::vector<Pair> found;
    // The scene is where the last step ended.
    m_isOk = m_isOk && MarkStart(m_scene, 0) == qc_statusOk;
    for (int sample = 0; sample < samples; sample++)
    {
        m_isOk = m_isOk && Move(2 * sample + 1) && Detect(&found);
        pairs->inside += countNew(found);
    }
    m_isOk = m_isOk && Move(s_ticks) && Detect(&found);
    pairs->ends = countNew(found);
    pairs->atEnd = found.size();
    m_isOk = m_isOk && CountUncertified(pairs);
    m_tangled.swap(found);
    return m_isOk;
}
