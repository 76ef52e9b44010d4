// Soft bodies, and the meshes near them, as bodies of a qcScene.
#include "soft_body/scene/soft_scene.h"

#include "common/object_key.h"
#include "quickcullide/bullet_positions.h"

#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <cmath>

namespace
{
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
    added.topology = qcTopologyOf(body);
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = body->m_nodes.size() > 0 ? &body->m_nodes[0].m_x : nullptr;
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btSoftBody::Node);
    def.vertexCount = uint32_t(body->m_nodes.size());
    def.indices = added.topology.indices.data();
    def.triangleCount = uint32_t(added.topology.indices.size() / 3);
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
        if (same && known.start.size() == size_t(known.NodeCount()) && qcIsTopologyOf(known.topology, known.body))
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
    qcSoftBodySettings settings = GetSettings(known.body);
    // Pairs that slept, or were left out, were not in the last result.
    known.startsAtEnd = known.moves == known.body->isActive() && known.settings.selfCollision == settings.selfCollision;
    known.settings = settings;
    known.thickness = known.settings.thickness > 0
                          ? known.settings.thickness
                          : std::min(known.topology.defaultThickness, known.body->getCollisionShape()->getMargin());
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
        known.startsAtEnd = known.startsAtEnd && known.start == known.places;
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
        known.shifts.clear();
        known.inContact = false;
        const btSoftBodyWorldInfo* info = known.body->getWorldInfo();
        btVector3 box[2];
        if (known.MeetsRigidBodies() && info->m_broadphase != nullptr && BoxOf(known, box))
            meshes.Seek(info->m_broadphase, box[0], box[1]);
    }
    return meshes.Synchronize(m_scene, timeStep);
}

qcStatus qcSoftBodyScene::SetVertices(std::vector<btVector3> qcSceneSoftBody::*positions)
{
    for (const qcSceneSoftBody& known : m_bodies)
    {
        if (known.places.empty())
            continue;
        const std::vector<btVector3>& from = known.*positions;
        qcStatus status = qcScene_SetVertices(m_scene, known.id, from.data(), qcBulletPositions, sizeof(btVector3));
        if (status != qc_statusOk)
            return status;
    }
    return qc_statusOk;
}

qcStatus qcSoftBodyScene::UpdatePlaces()
{
    qcStatus status = SetVertices(&qcSceneSoftBody::places);
    return status == qc_statusOk ? meshes.Place(m_scene) : status;
}

qcStatus qcSoftBodyScene::PlaceAtStart()
{
    qcStatus status = SetVertices(&qcSceneSoftBody::start);
    return status == qc_statusOk ? meshes.Place(m_scene, true) : status;
}

bool qcSoftBodyScene::StartsWhereItEnded() const
{
    auto isThere = [](const qcSceneSoftBody& known) { return known.startsAtEnd; };
    return std::all_of(m_bodies.begin(), m_bodies.end(), isThere) && meshes.StartWhereTheyEnded();
}

void qcSoftBodyScene::StartOf(uint32_t slot, uint32_t triangle, double corners[9])
{
    const qcSceneSoftBody* soft = Find(slot);
    qcSceneRigid* rigid = nullptr;
    const qcSceneMesh* mesh = soft == nullptr ? meshes.Find(slot, &rigid) : nullptr;
    for (size_t c = 0; c < 3; c++)
    {
        size_t corner = 3 * size_t(triangle) + c;
        if (mesh != nullptr)
        {
            uint32_t vertex = mesh->shape->getIndices()[corner];
            qcPlaceVertex(*mesh, rigid->start * mesh->local, vertex, &corners[3 * c]);
            continue;
        }
        const btVector3& point = soft->start[soft->topology.indices[corner]];
        for (size_t axis = 0; axis < 3; axis++)
            corners[3 * c + axis] = double(point[int(axis)]);
    }
}

qcStatus qcSoftBodyScene::Detect(btScalar contactMargin, bool segments, const qcResult** result)
{
    qcDetectDef def = qcDefaultDetectDef();
    def.method = method;
    def.contactMargin = double(contactMargin);
    def.nearestContacts = true;
    def.segments = segments;
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
