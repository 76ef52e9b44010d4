// Bodies are added to and removed from all scenes at once, so that a body has the same slot in each; a scene takes over
// new geometry when its query runs. The exact test confirms each pair, so the union of all results is the reference
// for each result.
#include "common/bullet/query_comparison.h"

#include <algorithm>
#include <iterator>
#include <tuple>

const std::array<qcComparedQueryDef, qc_queryCount> qcComparedQueries = {{
    {"cullide", "cullide", qc_methodCullide, false, false, false},
    {"quick", "quick", qc_methodQuick, false, false, false},
    {"quick, back to front", "quick_sorted", qc_methodQuick, true, false, false},
    {"  and second pass from the back", "quick_sorted_back", qc_methodQuick, true, true, false},
    {"sweep", "sweep", qc_methodSweep, false, false, true},
    {"auto", "auto", qc_methodAuto, false, false, true},
    {"layers", "layers", qc_methodLayers, false, false, true},
}};

static bool IsLess(const qcPair& a, const qcPair& b)
{
    return std::tie(a.bodyA, a.triangleA, a.bodyB, a.triangleB) < std::tie(b.bodyA, b.triangleA, b.bodyB, b.triangleB);
}

qcQueryComparison::qcQueryComparison(qcDevice* device, const qcDetectDef& request)
    : m_device(device), m_request(request)
{
}

qcQueryComparison::~qcQueryComparison()
{
    Clear();
}

bool qcQueryComparison::Fail(const std::string& message)
{
    m_message = message;
    return false;
}

bool qcQueryComparison::Check(qcStatus status)
{
    return status == qc_statusOk || Fail(qcLastMessage());
}

bool qcQueryComparison::CreateScenes()
{
    qcSceneDef def = qcDefaultSceneDef();
    def.device = m_device;
    for (Queried& queried : m_queried)
        if (queried.scene == nullptr && !Check(qcScene_Create(&def, &queried.scene)))
            return false;
    return true;
}

qcQueryComparison::Body* qcQueryComparison::Find(qcBodyId id)
{
    bool found = id.slot < m_bodies.size() && m_bodies[id.slot].id.generation == id.generation && id.generation != 0;
    if (!found)
        Fail("body " + std::to_string(id.slot) + " was removed");
    return found ? &m_bodies[id.slot] : nullptr;
}

bool qcQueryComparison::Add(const qcBodyDef& def, qcBodyId* id)
{
    if (!CreateScenes())
        return false;
    for (Queried& queried : m_queried)
        if (!Check(qcScene_AddBody(queried.scene, &def, id)))
            return false;
    m_bodies.resize(std::max(m_bodies.size(), size_t(id->slot) + 1));
    Body& body = m_bodies[id->slot];
    body = Body();
    body.id = *id;
    body.triangleCount = def.triangleCount;
    body.vertexCount = def.vertexCount;
    body.deforming = def.deforming;
    m_changes++;
    return true;
}

bool qcQueryComparison::Remove(qcBodyId id)
{
    Body* body = Find(id);
    if (body == nullptr)
        return false;
    *body = Body();
    m_changes++;
    for (Queried& queried : m_queried)
        if (!Check(qcScene_RemoveBody(queried.scene, id)))
            return false;
    return true;
}

bool qcQueryComparison::SetTransform(qcBodyId id, const qcTransform& transform)
{
    Body* body = Find(id);
    if (body == nullptr || (body->deforming && !Fail("a deforming body has no transform")))
        return false;
    body->transform = transform;
    body->changed = ++m_changes;
    return true;
}

bool qcQueryComparison::SetVertices(qcBodyId id, const std::vector<float>& positions)
{
    Body* body = Find(id);
    if (body == nullptr)
        return false;
    if (!body->deforming || positions.size() != 3 * size_t(body->vertexCount))
        return Fail("body " + std::to_string(id.slot) + " is rigid or has another number of vertices");
    body->positions = positions;
    body->changed = ++m_changes;
    return true;
}

bool qcQueryComparison::SetActivity(qcBodyId id, qcActivity activity)
{
    if (Find(id) == nullptr)
        return false;
    m_changes++;
    for (Queried& queried : m_queried)
        if (!Check(qcScene_SetActivity(queried.scene, id, activity)))
            return false;
    return true;
}

void qcQueryComparison::Clear()
{
    for (Queried& queried : m_queried)
    {
        qcScene_Destroy(queried.scene);
        queried = Queried();
    }
    m_bodies.clear();
    m_changes = 0;
}

bool qcQueryComparison::UpdateScene(Queried* queried)
{
    for (const Body& body : m_bodies)
    {
        if (body.changed <= queried->updated)
            continue;
        qcStatus status = body.deforming
                              ? qcScene_SetVertices(queried->scene, body.id, body.positions.data(), qc_positionF32, 0)
                              : qcScene_SetTransform(queried->scene, body.id, &body.transform);
        if (!Check(status))
            return false;
    }
    queried->updated = m_changes;
    return true;
}

bool qcQueryComparison::Run(qcComparedQuery query, qcQueryResult* result)
{
    const qcComparedQueryDef& settings = qcComparedQueries[query];
    Queried& queried = m_queried[query];
    if (!CreateScenes() || !UpdateScene(&queried))
        return false;
    qcDetectDef def = m_request;
    def.method = settings.method;
    def.backToFront = settings.backToFront;
    def.secondPassFromBack = settings.secondPassFromBack;
    const qcResult* found;
    if (!Check(qcScene_Detect(queried.scene, &def, &found)))
        return false;
    result->ran = true;
    result->pcs = uint32_t(found->pcsCount);
    result->ms = found->profile.totalMs;
    result->resolution = found->profile.resolution;
    result->byDevice = found->profile.method != qc_methodSweep;
    result->found = found->pairCount;
    queried.pairs.assign(found->pairs, found->pairs + found->pairCount);
    queried.pcs.assign(found->pcs, found->pcs + found->pcsCount);
    return true;
}

bool qcQueryComparison::RunAll(std::initializer_list<qcComparedQuery> queries, qcQueryResults* results)
{
    for (qcComparedQuery query : queries)
        if (!Run(query, &(*results)[query]))
            return false;
    return true;
}

bool qcQueryComparison::RunEachStep(qcQueryResults* results)
{
    return RunAll({qc_querySweep, qc_queryAuto, qc_queryLayers}, results);
}

bool qcQueryComparison::RunSampled(qcQueryResults* results)
{
    return RunAll({qc_queryQuick, qc_queryCullide, qc_queryQuickSorted, qc_queryQuickSortedBack}, results);
}

bool qcQueryComparison::Warm()
{
    qcQueryResults results;
    return RunEachStep(&results);
}

bool qcQueryComparison::Record(const std::string& path)
{
    return CreateScenes() && Check(qcScene_Record(m_queried[qc_querySweep].scene, path.c_str()));
}

bool qcQueryComparison::CountMissed(qcQueryResults* results)
{
    std::vector<qcPair> all, merged;
    for (const Queried& queried : m_queried)
    {
        if (queried.updated != m_changes)
            continue;
        merged.clear();
        std::set_union(all.begin(), all.end(), queried.pairs.begin(), queried.pairs.end(), std::back_inserter(merged),
                       IsLess);
        all.swap(merged);
    }
    for (size_t i = 0; i < m_queried.size(); i++)
    {
        qcQueryResult& result = (*results)[i];
        result.counted = result.ran && m_queried[i].updated == m_changes;
        result.missed = result.counted ? all.size() - m_queried[i].pairs.size() : 0;
        if (qcComparedQueries[i].neverMisses && result.missed != 0)
            return Fail(std::string(qcComparedQueries[i].label) + " missed " + std::to_string(result.missed) + " of " +
                        std::to_string(all.size()) + " pairs");
    }
    return true;
}

std::vector<uint8_t> qcQueryComparison::Marked(qcComparedQuery query, qcBodyId id) const
{
    if (id.slot >= m_bodies.size() || m_bodies[id.slot].id.generation != id.generation)
        return {};
    std::vector<uint8_t> marked(m_bodies[id.slot].triangleCount);
    const std::vector<qcTriangleRef>& pcs = m_queried[query].pcs;
    auto first = std::lower_bound(pcs.begin(), pcs.end(), id.slot,
                                  [](const qcTriangleRef& triangle, uint32_t slot) { return triangle.body < slot; });
    for (auto triangle = first; triangle != pcs.end() && triangle->body == id.slot; ++triangle)
        // The slot may have held a larger body when the query ran.
        if (triangle->triangle < marked.size())
            marked[triangle->triangle] = 1;
    return marked;
}
