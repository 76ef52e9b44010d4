// Soft bodies, and the meshes near them, as bodies of a qcScene.
#include "soft_body_scene.h"

#include "collision_object.h"
#include "position_type.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>

namespace
{
btScalar HalfMeanEdge(const btSoftBody* body)
{
    btScalar sum = 0;
    int count = 0;
    for (int i = 0; i < body->m_faces.size(); i++)
        for (int c = 0; c < 3; c++, count++)
            sum += (body->m_faces[i].m_n[c]->m_x - body->m_faces[i].m_n[(c + 1) % 3]->m_x).length();
    return count > 0 ? sum / btScalar(count) / 2 : btScalar(0);
}

/// Three a face, then three times the same for each node that no face has: a rope's, those of tetrahedra without faces,
/// what was cut off. But nodes inside of a skin of faces meet nothing before it does.
std::vector<uint32_t> IndicesOf(const btSoftBody* body)
{
    std::vector<uint32_t> indices;
    std::vector<bool> loose(size_t(body->m_nodes.size()), body->m_tetras.size() == 0 || body->m_faces.size() == 0);
    indices.reserve(3 * size_t(body->m_faces.size()));
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
        {
            indices.push_back(uint32_t(node - &body->m_nodes[0]));
            loose[indices.back()] = false;
        }
    for (size_t i = 0; i < loose.size(); i++)
        if (loose[i])
            indices.insert(indices.end(), 3, uint32_t(i));
    return indices;
}

/// Are these what IndicesOf would give? Of a body with as many faces and nodes as it had.
bool AreIndicesOf(const std::vector<uint32_t>& indices, const btSoftBody* body)
{
    const uint32_t* index = indices.data();
    for (int i = 0; i < body->m_faces.size(); i++)
        for (const btSoftBody::Node* node : body->m_faces[i].m_n)
            if (node != &body->m_nodes[0] + *index++)
                return false;
    return true;
}

/// Nodes that Bullet puts to their anchors at the end of each step, or where the reduced model has them.
void NoteHeld(qcSceneSoftBody& known)
{
    known.held.clear();
    if (known.body->m_reducedModel)
        known.held.resize(size_t(known.NodeCount()), true);
    for (int i = 0; i < known.body->m_deformableAnchors.size(); i++)
    {
        known.held.resize(size_t(known.NodeCount()), false);
        known.held[known.NumberOf(known.body->m_deformableAnchors[i].m_node)] = true;
    }
}

/// The box of a soft body from the start of the step to where Bullet left it; false if it has none.
bool BoxOf(const qcSceneSoftBody& known, btVector3 box[2])
{
    if (known.NodeCount() == 0)
        return false;
    box[0] = box[1] = known.start[0];
    btVector3 sum(0, 0, 0);
    for (size_t i = 0; i < known.solved.size(); i++)
    {
        const btVector3 &start = known.start[i], &x = known.solved[i];
        box[0].setMin(start);
        box[0].setMin(x);
        box[1].setMax(start);
        box[1].setMax(x);
        sum += start + x;
    }
    btVector3 reach(known.thickness, known.thickness, known.thickness);
    box[0] -= reach;
    box[1] += reach;
    // A node that is not finite is the query's to name; a broadphase should not see it.
    return std::isfinite(sum.x() + sum.y() + sum.z());
}
} // namespace

qcSoftBodyScene::~qcSoftBodyScene()
{
    qcScene_Destroy(m_scene);
}

qcStatus qcSoftBodyScene::Add(btSoftBody* body)
{
    qcSceneSoftBody added;
    added.body = body;
    added.addition = qcAdditionOf(body);
    added.indices = IndicesOf(body);
    added.faceCount = body->m_faces.size();
    added.halfEdge = HalfMeanEdge(body);
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = body->m_nodes.size() > 0 ? &body->m_nodes[0].m_x : nullptr;
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btSoftBody::Node);
    def.vertexCount = uint32_t(body->m_nodes.size());
    def.indices = added.indices.data();
    def.triangleCount = uint32_t(added.indices.size() / 3);
    def.deforming = true;
    def.group = qcSoftGroup;
    def.mask = qcSoftGroup | qcMeshGroup;
    qcStatus status = qcScene_AddBody(m_scene, &def, &added.id);
    if (status == qc_statusOk)
        m_bodies.push_back(std::move(added));
    return status;
}

void qcSoftBodyScene::DropGone(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    auto isGone = [&](const qcSceneSoftBody& known)
    {
        bool same = bodies.findLinearSearch(known.body) < bodies.size() && known.addition == qcAdditionOf(known.body);
        if (same && known.start.size() == size_t(known.NodeCount()) && known.faceCount == known.body->m_faces.size() &&
            AreIndicesOf(known.indices, known.body))
            return false;
        qcScene_RemoveBody(m_scene, known.id);
        auto setting = m_settings.find(known.body);
        if (!same && setting != m_settings.end() && setting->second.addition == known.addition)
            m_settings.erase(setting);
        return true;
    };
    m_bodies.erase(std::remove_if(m_bodies.begin(), m_bodies.end(), isGone), m_bodies.end());
}

void qcSoftBodyScene::TakeSettings(qcSceneSoftBody& known)
{
    auto found = m_settings.find(known.body);
    if (found != m_settings.end() && found->second.addition == -1)
        found->second.addition = known.addition;
    known.settings = GetSettings(known.body);
    known.thickness = known.settings.thickness > 0
                          ? known.settings.thickness
                          : std::min(known.halfEdge, known.body->getCollisionShape()->getMargin());
    known.moves = known.body->isActive();
    qcScene_SetMargin(m_scene, known.id, double(known.thickness) / 2);
    qcScene_SetSelfCollision(m_scene, known.id, known.settings.selfCollision);
    qcScene_SetActivity(m_scene, known.id, known.moves ? qc_activityMoving : qc_activitySleeping);
}

qcStatus qcSoftBodyScene::Synchronize(const btAlignedObjectArray<btSoftBody*>& bodies,
                                      btVector3 btSoftBody::Node::*start)
{
    if (m_scene == nullptr)
    {
        qcSceneDef def = qcDefaultSceneDef();
        def.device = m_device;
        qcStatus status = qcScene_Create(&def, &m_scene);
        if (status != qc_statusOk)
            return status;
    }
    DropGone(bodies);
    for (int i = 0; i < bodies.size(); i++)
    {
        auto isIt = [&](const qcSceneSoftBody& known) { return known.body == bodies[i]; };
        if (std::any_of(m_bodies.begin(), m_bodies.end(), isIt))
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
        TakeSettings(known);
        known.start.resize(size_t(known.NodeCount()));
        // A body that Bullet does not simulate stays where it is.
        for (int n = 0; n < known.NodeCount(); n++)
            known.start[size_t(n)] = known.moves ? known.body->m_nodes[n].*start : known.body->m_nodes[n].m_x;
        NoteHeld(known);
    }
    return qc_statusOk;
}

qcStatus qcSoftBodyScene::TakeSolved(btScalar timeStep)
{
    BT_PROFILE("qcSoftBodyContact gather");
    for (qcSceneSoftBody& known : m_bodies)
    {
        known.solved.resize(size_t(known.NodeCount()));
        for (int i = 0; i < known.NodeCount(); i++)
            known.solved[size_t(i)] = known.body->m_nodes[i].m_x;
        known.places = known.solved;
        const btSoftBodyWorldInfo* info = known.body->getWorldInfo();
        btVector3 box[2];
        if (known.MeetsRigidBodies() && info->m_broadphase != nullptr && BoxOf(known, box))
            meshes.Seek(info->m_broadphase, box[0], box[1]);
    }
    return meshes.Synchronize(m_scene, timeStep);
}

qcStatus qcSoftBodyScene::UpdatePlaces()
{
    for (const qcSceneSoftBody& known : m_bodies)
    {
        if (known.places.empty())
            continue;
        qcStatus status =
            qcScene_SetVertices(m_scene, known.id, known.places.data(), qcBulletPositions, sizeof(btVector3));
        if (status != qc_statusOk)
            return status;
    }
    return meshes.Place(m_scene);
}

qcStatus qcSoftBodyScene::Detect(btScalar contactMargin, const qcResult** result)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.contactMargin = double(contactMargin);
    def.nearestContacts = true;
    def.threads = threads;
    return qcScene_Detect(m_scene, &def, result);
}

qcSceneSoftBody* qcSoftBodyScene::Find(uint32_t slot)
{
    return slot < m_bodyOfSlot.size() && m_bodyOfSlot[slot] != SIZE_MAX ? &m_bodies[m_bodyOfSlot[slot]] : nullptr;
}

void qcSoftBodyScene::SetSettings(const btSoftBody* body, const qcSoftBodySettings& settings)
{
    m_settings[body] = {qcAdditionOf(body), settings};
}

qcSoftBodySettings qcSoftBodyScene::GetSettings(const btSoftBody* body) const
{
    auto found = m_settings.find(body);
    bool isIts = found != m_settings.end() && found->second.addition == qcAdditionOf(body);
    return isIts ? found->second.settings : qcSoftBodySettings();
}

btScalar qcSoftBodyScene::Reach() const
{
    btScalar soft = 0, rigid = 0;
    for (const qcSceneSoftBody& known : m_bodies)
        soft = std::max(soft, known.thickness);
    for (const std::unique_ptr<qcSceneRigid>& known : meshes.Rigids())
        for (const qcSceneMesh& mesh : known->meshes)
            rigid = std::max(rigid, mesh.shape->getMargin());
    return std::max(soft, soft / 2 + rigid);
}
