// Soft bodies as bodies of a qcScene.
#include "soft_body_scene.h"

#include <algorithm>

namespace
{
constexpr qcPositionType s_positionType = sizeof(btScalar) == sizeof(double) ? qc_positionF64 : qc_positionF32;

btScalar DefaultThickness(const btSoftBody* body)
{
    btScalar sum = 0;
    int count = 0;
    for (int i = 0; i < body->m_faces.size(); i++)
        for (int c = 0; c < 3; c++, count++)
            sum += (body->m_faces[i].m_n[c]->m_x - body->m_faces[i].m_n[(c + 1) % 3]->m_x).length();
    btScalar half = count > 0 ? sum / count / 2 : btScalar(0);
    return std::min(half, body->getCollisionShape()->getMargin());
}
} // namespace

qcSoftBodyScene::qcSoftBodyScene()
{
    qcSceneDef def = qcDefaultSceneDef();
    // Out of memory leaves m_scene null; every call on it then fails with a status.
    qcScene_Create(&def, &m_scene);
}

qcSoftBodyScene::~qcSoftBodyScene()
{
    qcScene_Destroy(m_scene);
}

qcStatus qcSoftBodyScene::Add(btSoftBody* body)
{
    std::vector<uint32_t> indices;
    indices.reserve(3 * size_t(body->m_faces.size()));
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
            indices.push_back(uint32_t(node - &body->m_nodes[0]));

    qcBodyDef def = qcDefaultBodyDef();
    def.positions = body->m_nodes.size() > 0 ? &body->m_nodes[0].m_x : nullptr;
    def.positionType = s_positionType;
    def.positionStride = sizeof(btSoftBody::Node);
    def.vertexCount = uint32_t(body->m_nodes.size());
    def.indices = indices.data();
    def.triangleCount = uint32_t(body->m_faces.size());
    def.deforming = true;
    qcSceneSoftBody added;
    added.body = body;
    added.nodeCount = body->m_nodes.size();
    added.faceCount = body->m_faces.size();
    qcStatus status = qcScene_AddBody(m_scene, &def, &added.id);
    if (status == qc_statusOk)
        m_bodies.push_back(std::move(added));
    return status;
}

qcStatus qcSoftBodyScene::Synchronize(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    auto isGone = [&](const qcSceneSoftBody& known)
    {
        bool present = bodies.findLinearSearch(known.body) < bodies.size();
        if (present && known.nodeCount == known.body->m_nodes.size() && known.faceCount == known.body->m_faces.size())
            return false;
        qcScene_RemoveBody(m_scene, known.id);
        if (!present)
            m_settings.erase(known.body);
        return true;
    };
    m_bodies.erase(std::remove_if(m_bodies.begin(), m_bodies.end(), isGone), m_bodies.end());
    for (int i = 0; i < bodies.size(); i++)
    {
        if (Find(bodies[i]) != nullptr)
            continue;
        qcStatus status = Add(bodies[i]);
        if (status != qc_statusOk)
            return status;
    }
    m_bodyOfSlot.clear();
    for (size_t i = 0; i < m_bodies.size(); i++)
    {
        qcSceneSoftBody& known = m_bodies[i];
        if (known.id.slot >= m_bodyOfSlot.size())
            m_bodyOfSlot.resize(known.id.slot + 1, SIZE_MAX);
        m_bodyOfSlot[known.id.slot] = i;
        const qcSoftBodySettings& settings = m_settings[known.body];
        if (known.thickness == 0 || settings.thickness != known.settings.thickness)
            known.thickness = settings.thickness > 0 ? settings.thickness : DefaultThickness(known.body);
        known.settings = settings;
        qcScene_SetSelfCollision(m_scene, known.id, settings.selfCollision);
    }
    return qc_statusOk;
}

qcStatus qcSoftBodyScene::UpdateVertices()
{
    for (const qcSceneSoftBody& known : m_bodies)
    {
        if (known.nodeCount == 0)
            continue;
        qcStatus status = qcScene_SetVertices(m_scene, known.id, &known.body->m_nodes[0].m_x, s_positionType,
                                              sizeof(btSoftBody::Node));
        if (status != qc_statusOk)
            return status;
    }
    return qc_statusOk;
}

qcStatus qcSoftBodyScene::Detect(btScalar contactMargin, const qcResult** result)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.contactMargin = double(contactMargin);
    def.threads = threads;
    return qcScene_Detect(m_scene, &def, result);
}

qcSceneSoftBody* qcSoftBodyScene::Find(uint32_t slot)
{
    return slot < m_bodyOfSlot.size() && m_bodyOfSlot[slot] != SIZE_MAX ? &m_bodies[m_bodyOfSlot[slot]] : nullptr;
}

qcSceneSoftBody* qcSoftBodyScene::Find(const btSoftBody* body)
{
    auto found =
        std::find_if(m_bodies.begin(), m_bodies.end(), [&](const qcSceneSoftBody& b) { return b.body == body; });
    return found != m_bodies.end() ? &*found : nullptr;
}

btScalar qcSoftBodyScene::Thickness() const
{
    btScalar largest = 0;
    for (const qcSceneSoftBody& known : m_bodies)
        largest = std::max(largest, known.thickness);
    return largest;
}
