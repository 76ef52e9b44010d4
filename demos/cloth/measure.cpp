// The cloth of one moment in scenes of its own. What was found by any method is there, for the exact test confirms each
// pair: so the union of all answers is what each is held against.
#include "cloth/measure.h"

#include <algorithm>
#include <iterator>

const std::array<qcClothQuestionDef, qc_clothQuestionCount> qcClothQuestions = {{
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
    for (Asked& asked : m_asked)
        qcScene_Destroy(asked.scene);
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
    for (Asked& asked : m_asked)
    {
        qcScene_Destroy(asked.scene);
        asked.scene = nullptr;
        if (!Check(qcScene_Create(&sceneDef, &asked.scene)) ||
            !Check(qcScene_AddBody(asked.scene, &bodyDef, &asked.cloth)))
            return false;
    }
    qcClothAnswer answer;
    return Ask(qc_clothSweep, &answer) && Ask(qc_clothAuto, &answer) && Ask(qc_clothLayers, &answer);
}

bool qcClothMeasure::Update(const std::vector<float>& positions)
{
    for (Asked& asked : m_asked)
        if (!Check(qcScene_SetVertices(asked.scene, asked.cloth, positions.data(), qc_positionF32, 0)))
            return false;
    return true;
}

bool qcClothMeasure::Ask(qcClothQuestion question, qcClothAnswer* answer)
{
    const qcClothQuestionDef& what = qcClothQuestions[question];
    Asked& asked = m_asked[question];
    qcDetectDef def = m_request;
    def.method = what.method;
    def.backToFront = what.backToFront;
    def.secondPassFromBack = what.secondPassFromBack;
    const qcResult* result;
    if (!Check(qcScene_Detect(asked.scene, &def, &result)))
        return false;
    answer->pcs = uint32_t(result->pcsCount);
    answer->ms = result->profile.totalMs;
    answer->resolution = result->profile.resolution;
    answer->byDevice = result->profile.method != qc_methodSweep;
    answer->found = result->pairCount;
    asked.pairs.clear();
    for (size_t i = 0; i < result->pairCount; i++)
        asked.pairs.emplace_back(result->pairs[i].triangleA, result->pairs[i].triangleB);
    std::fill(m_marked.begin(), m_marked.end(), uint8_t(0));
    for (size_t i = 0; i < result->pcsCount; i++)
        m_marked[result->pcs[i].triangle] = 1;
    return true;
}

void qcClothMeasure::Judge(qcClothAnswers* answers) const
{
    Pairs all, merged;
    for (const Asked& asked : m_asked)
    {
        merged.clear();
        std::set_union(all.begin(), all.end(), asked.pairs.begin(), asked.pairs.end(), std::back_inserter(merged));
        all.swap(merged);
    }
    for (size_t i = 0; i < m_asked.size(); i++)
        (*answers)[i].missed = all.size() - m_asked[i].pairs.size();
}
