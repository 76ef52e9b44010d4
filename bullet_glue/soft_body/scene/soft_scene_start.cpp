// The start of a step: which soft bodies the scene has, and where they start.
#include "soft_body/scene/soft_scene.h"

#include "common/finite.h"
#include "common/object_key.h"
#include "common/object_motion.h"
#include "common/shape_triangles.h"
#include "quickcullide/bullet_positions.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

namespace
{
/// True if the nodes' present positions are finite, and those at the start of the step.
bool IsFinite(const btSoftBody* body, btVector3 btSoftBody::Node::*start)
{
    for (int n = 0; n < body->m_nodes.size(); n++)
        if (!qcIsFinite(body->m_nodes[n].m_x) || !qcIsFinite(body->m_nodes[n].*start))
            return false;
    return true;
}

qcBroadphases BroadphasesOf(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    qcBroadphases broadphases;
    for (int i = 0; i < bodies.size(); i++)
        qcAddBroadphase(bodies[i]->getWorldInfo()->m_broadphase, &broadphases);
    return broadphases;
}
} // namespace

/// The nodes of a body, without triangles.
qcBodyDef qcSoftBodyScene::DefOf(const btSoftBody* body) const
{
    qcBodyDef def = qcDefaultBodyDef();
    def.positions = body->m_nodes.size() > 0 ? &body->m_nodes[0].m_x : nullptr;
    def.positionType = qcBulletPositions;
    def.positionStride = sizeof(btSoftBody::Node);
    def.vertexCount = uint32_t(body->m_nodes.size());
    return def;
}

qcStatus qcSoftBodyScene::Track(btSoftBody* body)
{
    qcSceneSoftBody added;
    added.body = body;
    added.uniqueId = qcUniqueIdOf(body);
    added.topology = qcTopologyOf(body);
    qcBodyDef def = DefOf(body);
    def.indices = added.topology.indices.data();
    def.triangleCount = uint32_t(added.topology.indices.size() / 3);
    def.deforming = true;
    def.group = qcSoftGroup;
    def.mask = qcSoftGroup | qcMeshGroup | qcSurfaceGroup;
    qcStatus status = qcScene_AddBody(m_scene, &def, &added.id);
    if (status == qc_statusOk)
        m_bodies.push_back(std::move(added));
    return status;
}

/// True if a body is still in the array, by its address and its id: it may have been deleted. `next`: where it is, if
/// those before it were found; both have the same order, but for bodies that are tracked anew.
bool qcSoftBodyScene::IsThere(const btAlignedObjectArray<btSoftBody*>& bodies, const qcSceneSoftBody& tracked,
                              int* next)
{
    const bool isNext = *next < bodies.size() && bodies[*next] == tracked.body;
    *next += isNext;
    return (isNext || bodies.findLinearSearch(tracked.body) < bodies.size()) &&
           tracked.uniqueId == qcUniqueIdOf(tracked.body);
}

/// Removes the bodies that are not in the array, or no longer the same or finite. Returns those of them that are there,
/// but have another topology.
std::vector<const btSoftBody*> qcSoftBodyScene::UntrackRemoved(const btAlignedObjectArray<btSoftBody*>& bodies,
                                                               btVector3 btSoftBody::Node::*start)
{
    std::vector<const btSoftBody*> cut;
    int next = 0;
    auto isRemoved = [&](const qcSceneSoftBody& tracked)
    {
        const bool same = IsThere(bodies, tracked, &next);
        const bool isWhole = same && qcIsTopologyOf(tracked.topology, tracked.body);
        if (isWhole && tracked.start.size() == size_t(tracked.NodeCount()) &&
            !qcIsScaled(tracked.topology, tracked.body) && IsFinite(tracked.body, start))
            return false;
        qcScene_RemoveBody(m_scene, tracked.id);
        if (same && !isWhole)
            cut.push_back(tracked.body);
        auto setting = m_settings.find(tracked.body);
        if (!same && setting != m_settings.end() && setting->second.uniqueId == tracked.uniqueId)
            m_settings.erase(setting);
        return true;
    };
    m_bodies.erase(std::remove_if(m_bodies.begin(), m_bodies.end(), isRemoved), m_bodies.end());
    return cut;
}

/// Records a soft body that is not finite.
void qcSoftBodyScene::LeaveOut(const btSoftBody* body)
{
    notFinite = body;
    qcExplainNotFinite(DefOf(body));
}

qcStatus qcSoftBodyScene::CreateScene()
{
    qcSceneDef def = qcDefaultSceneDef();
    def.device = m_device;
    return qcScene_Create(&def, &m_scene);
}

/// The translation by which the application has moved all objects since the previous step, as for a new origin of the
/// world.
qcTranslation qcSoftBodyScene::FindShift(const qcBroadphases& broadphases, btVector3 btSoftBody::Node::*start) const
{
    qcTranslation shift;
    for (const qcSceneSoftBody& tracked : m_bodies)
    {
        if (!tracked.hasEnd || tracked.positions.size() != size_t(tracked.NodeCount()))
            continue;
        auto member = tracked.body->isActive() ? start : &btSoftBody::Node::m_x;
        for (size_t n = 0; n < tracked.positions.size(); n++)
            if (!shift.Add(tracked.positions[n], tracked.body->m_nodes[int(n)].*member))
                return qcTranslation();
    }
    return !shift.by.isZero() && meshes.Starts().AreShiftedBy(shift, broadphases) ? shift : qcTranslation();
}

/// `isShifted`: the application has moved the origin of the world.
void qcSoftBodyScene::ReadStart(qcSceneSoftBody& tracked, btVector3 btSoftBody::Node::*start, bool isShifted)
{
    ApplySettings(tracked);
    // A body that Bullet does not simulate stays where it is.
    auto member = tracked.moves ? start : &btSoftBody::Node::m_x;
    const bool isPut = isShifted || tracked.isRestored;
    bool isNearEnd = tracked.ReadApplied(member) && !isPut;
    if (isPut)
        tracked.applied.clear();
    tracked.start.resize(size_t(tracked.NodeCount()));
    for (int n = 0; n < tracked.NodeCount() && !isNearEnd; n++)
        tracked.start[size_t(n)] = tracked.body->m_nodes[n].*member;
    if (isNearEnd)
        tracked.start = tracked.positions;
    tracked.startsElsewhere = !isNearEnd;
    tracked.startsWhereItEnded = tracked.startsWhereItEnded && isNearEnd;
    tracked.ReadAnchors();
}

void qcSoftBodyScene::LimitThickness(const std::function<bool(uint32_t)>& isTangled)
{
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        if (tracked.isNew && !isTangled(tracked.id.slot))
        {
            btScalar& thickness = tracked.topology.defaultThickness;
            thickness = std::min(thickness, qcClearHeightOf(tracked.body, tracked.topology));
            ApplyThickness(tracked);
        }
        tracked.isNew = false;
    }
}

void qcSoftBodyScene::BeginStep(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    const qcBroadphases broadphases = BroadphasesOf(bodies);
    meshes.BeginStep(broadphases);
    FindRestored(bodies);
    WakeSwept(bodies, broadphases);
}

void qcSoftBodyScene::ReadBegin(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    meshes.ReadBegin(BroadphasesOf(bodies));
}

/// Where the application has restored all soft bodies that Bullet moves, it has restored the world: no object moves
/// from the end of the previous step to its start.
void qcSoftBodyScene::FindRestored(const btAlignedObjectArray<btSoftBody*>& bodies)
{
    bool isAny = false, areAll = true;
    int next = 0;
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        tracked.isRestored = false;
        if (!IsThere(bodies, tracked, &next))
            continue;
        tracked.FindRestored();
        isAny = isAny || tracked.isRestored;
        areAll = areAll && (tracked.isRestored || !tracked.body->isActive());
    }
    meshes.Starts().SetRestored(isAny && areAll);
}

void qcSoftBodyScene::ReadVelocities()
{
    for (qcSceneSoftBody& tracked : m_bodies)
    {
        tracked.velocities.resize(size_t(tracked.NodeCount()));
        for (size_t n = 0; n < tracked.velocities.size(); n++)
            tracked.velocities[n] = tracked.body->m_nodes[int(n)].m_v;
    }
}

/// Wakes soft bodies near objects that the application moves. Bullet lets such objects run through those that sleep.
void qcSoftBodyScene::WakeSwept(const btAlignedObjectArray<btSoftBody*>& bodies, const qcBroadphases& broadphases)
{
    std::vector<btSoftBody*> asleep;
    for (int i = 0; i < bodies.size(); i++)
        if (bodies[i]->getActivationState() == ISLAND_SLEEPING)
            asleep.push_back(bodies[i]);
    if (asleep.empty())
        return;
    meshes.ForEachPlaced(broadphases,
                         [&asleep](const btVector3& lower, const btVector3& upper)
                         {
                             for (btSoftBody* body : asleep)
                             {
                                 btVector3 box[2];
                                 body->getAabb(box[0], box[1]);
                                 if (TestAabbAgainstAabb2(box[0], box[1], lower, upper))
                                     body->activate();
                             }
                         });
}

qcStatus qcSoftBodyScene::Sync(const btAlignedObjectArray<btSoftBody*>& bodies, btVector3 btSoftBody::Node::*start)
{
    qcStatus status = m_scene == nullptr ? CreateScene() : qc_statusOk;
    if (status != qc_statusOk)
        return status;
    notFinite = nullptr;
    const std::vector<const btSoftBody*> cut = UntrackRemoved(bodies, start);
    for (int i = 0; i < bodies.size() && status == qc_statusOk; i++)
    {
        auto isIt = [&](const qcSceneSoftBody& tracked) { return tracked.body == bodies[i]; };
        if ((size_t(i) < m_bodies.size() && isIt(m_bodies[size_t(i)])) ||
            std::any_of(m_bodies.begin(), m_bodies.end(), isIt))
            continue;
        if (!IsFinite(bodies[i], start))
        {
            LeaveOut(bodies[i]);
            continue;
        }
        status = Track(bodies[i]);
        if (status == qc_statusOk && std::find(cut.begin(), cut.end(), bodies[i]) != cut.end())
            m_bodies.back().ReadCut(start);
    }
    const qcTranslation shift = FindShift(BroadphasesOf(bodies), start);
    meshes.Starts().SetShift(shift);
    // Each tracked body is complete, also where another one could not be added.
    m_bodyOfSlot.clear();
    for (size_t i = 0; i < m_bodies.size(); i++)
    {
        uint32_t slot = m_bodies[i].id.slot;
        if (slot >= m_bodyOfSlot.size())
            m_bodyOfSlot.resize(slot + 1, SIZE_MAX);
        m_bodyOfSlot[slot] = i;
        ReadStart(m_bodies[i], start, !shift.by.isZero());
    }
    return status;
}
