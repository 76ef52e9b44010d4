// The cloth of one moment in a scene of its own.
#include "cloth_measure.h"

qcClothMeasure::qcClothMeasure(qcDevice* device, const qcDetectDef& request) : m_request(request)
{
    qcSceneDef def = qcDefaultSceneDef();
    def.device = device;
    Check(qcScene_Create(&def, &m_scene));
}

qcClothMeasure::~qcClothMeasure()
{
    qcScene_Destroy(m_scene);
}

bool qcClothMeasure::Check(qcStatus status)
{
    if (status != qc_statusOk)
        m_message = qcLastMessage();
    return status == qc_statusOk;
}

bool qcClothMeasure::Update(const std::vector<float>& positions, const std::vector<uint32_t>& indices)
{
    if (qcScene_IsValid(m_scene, m_cloth))
        return Check(qcScene_SetVertices(m_scene, m_cloth, positions.data(), qc_positionF32, 0));
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = positions.data();
    def.vertexCount = uint32_t(positions.size() / 3);
    def.indices = indices.data();
    def.triangleCount = uint32_t(indices.size() / 3);
    def.deforming = true;
    m_triangleCount = def.triangleCount;
    return Check(qcScene_AddBody(m_scene, &def, &m_cloth));
}

bool qcClothMeasure::CountPenetrating(size_t* pairs)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.threads = m_request.threads;
    const qcResult* result;
    if (!Check(qcScene_Detect(m_scene, &def, &result)))
        return false;
    *pairs = result->pairCount;
    return true;
}

bool qcClothMeasure::Ask(qcMethod method, qcClothAnswer* answer)
{
    qcDetectDef def = m_request;
    def.method = method;
    const qcResult* result;
    if (!Check(qcScene_Detect(m_scene, &def, &result)))
        return false;
    answer->pcs = uint32_t(result->pcsCount);
    answer->pairs = result->pairCount;
    answer->ms = result->profile.totalMs;
    answer->resolution = result->profile.resolution;
    answer->marked.assign(m_triangleCount, 0);
    for (size_t i = 0; i < result->pcsCount; i++)
        answer->marked[result->pcs[i].triangle] = 1;
    return true;
}
