// Each query has a scene of its own. The exact test confirms each pair, so the union of all results is the reference
// for each result.
#include "cloth/measure.h"

#include <algorithm>
#include <iterator>

const std::array<qcClothQueryDef, qc_clothQueryCount> qcClothQueries = {{
    {"cullide", "cullide", qc_methodCullide, false, false, false},
    {"quick", "quick", qc_methodQuick, false, false, false},
    {"quick, back to front", "quick_sorted", qc_methodQuick, true, false, false},
    {"  and second pass from the back", "quick_sorted_back", qc_methodQuick, true, true, false},
    {"sweep", "sweep", qc_methodSweep, false, false, true},
    {"auto", "auto", qc_methodAuto, false, false, true},
    {"layers", "layers", qc_methodLayers, false, false, true},
}};

qcClothMeasure::qcClothMeasure(qcDevice* device, const qcDetectDef& request) : m_device(device), m_request(request)
{
}

qcClothMeasure::~qcClothMeasure()
{
    for (Queried& queried : m_queried)
        qcScene_Destroy(queried.scene);
}

bool qcClothMeasure::Check(qcStatus status)
{
    if (status != qc_statusOk)
        m_message = qcLastMessage();
    return status == qc_statusOk;
}

bool qcClothMeasure::Begin(const std::vector<float>& positions, const std::vector<uint32_t>& indices)
{
    qcSceneDef sceneDef = qcDefaultSceneDef();
    sceneDef.device = m_device;
    qcBodyDef bodyDef = qcDefaultBodyDef();
    bodyDef.positions = positions.data();
    bodyDef.vertexCount = uint32_t(positions.size() / 3);
    bodyDef.indices = indices.data();
    bodyDef.triangleCount = uint32_t(indices.size() / 3);
    bodyDef.deforming = true;
    m_marked.resize(bodyDef.triangleCount);
    for (Queried& queried : m_queried)
    {
        qcScene_Destroy(queried.scene);
        queried.scene = nullptr;
        if (!Check(qcScene_Create(&sceneDef, &queried.scene)) ||
            !Check(qcScene_AddBody(queried.scene, &bodyDef, &queried.cloth)))
            return false;
    }
    qcClothResult result;
    return Run(qc_clothSweep, &result) && Run(qc_clothAuto, &result) && Run(qc_clothLayers, &result);
}

bool qcClothMeasure::Update(const std::vector<float>& positions)
{
    for (Queried& queried : m_queried)
        if (!Check(qcScene_SetVertices(queried.scene, queried.cloth, positions.data(), qc_positionF32, 0)))
            return false;
    return true;
}

bool qcClothMeasure::Run(qcClothQuery query, qcClothResult* result)
{
    const qcClothQueryDef& settings = qcClothQueries[query];
    Queried& queried = m_queried[query];
    qcDetectDef def = m_request;
    def.method = settings.method;
    def.backToFront = settings.backToFront;
    def.secondPassFromBack = settings.secondPassFromBack;
    const qcResult* found;
    if (!Check(qcScene_Detect(queried.scene, &def, &found)))
        return false;
    result->pcs = uint32_t(found->pcsCount);
    result->ms = found->profile.totalMs;
    result->resolution = found->profile.resolution;
    result->byDevice = found->profile.method != qc_methodSweep;
    result->found = found->pairCount;
    queried.pairs.clear();
    for (size_t i = 0; i < found->pairCount; i++)
        queried.pairs.emplace_back(found->pairs[i].triangleA, found->pairs[i].triangleB);
    std::fill(m_marked.begin(), m_marked.end(), uint8_t(0));
    for (size_t i = 0; i < found->pcsCount; i++)
        m_marked[found->pcs[i].triangle] = 1;
    return true;
}

void qcClothMeasure::CountMissed(qcClothResults* results) const
{
    Pairs all, merged;
    for (const Queried& queried : m_queried)
    {
        merged.clear();
        std::set_union(all.begin(), all.end(), queried.pairs.begin(), queried.pairs.end(), std::back_inserter(merged));
        all.swap(merged);
    }
    for (size_t i = 0; i < m_queried.size(); i++)
        (*results)[i].missed = all.size() - m_queried[i].pairs.size();
}
