// The rigid objects near soft bodies, as meshes of the soft bodies' scene.
#include "soft_body/scene/rigid_meshes.h"

#include "common/first_error.h"
#include "common/object_key.h"
#include "common/object_motion.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

namespace
{
// Bullet gives a kinematic body the velocity of its motion in all substeps, though it moves in the first alone, and in
// its first step one as if it came from the origin. One that is in place for more steps than that has its velocity from
// the application.
constexpr int s_minStepsOfBelt = 16;

bool AreSame(const std::vector<qcSceneShape>& a, const std::vector<qcSceneShape>& b)
{
    auto isSame = [](const qcSceneShape& m, const qcSceneShape& n)
    { return m.shape == n.shape && m.revision == n.revision && qcAreSame(m.local, n.local); };
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), isSame);
}

/// True if these are the same shapes, some with other triangles.
bool AreReshaped(const std::vector<qcSceneShape>& a, const std::vector<qcSceneShape>& b)
{
    auto isSame = [](const qcSceneShape& m, const qcSceneShape& n) { return m.shape == n.shape; };
    auto isUnchanged = [](const qcSceneShape& m, const qcSceneShape& n) { return m.revision == n.revision; };
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), isSame) &&
           !std::equal(a.begin(), a.end(), b.begin(), isUnchanged);
}

bool Sleeps(const btMultiBodyLinkCollider* collider)
{
    return collider != nullptr && collider->getActivationState() == ISLAND_SLEEPING;
}

/// True if Bullet moves the multibody in the step: it may also where isAwake() is false already.
bool IsStepped(const btMultiBody& multibody)
{
    bool sleeps = Sleeps(multibody.getBaseCollider());
    for (int i = 0; i < multibody.getNumLinks(); i++)
        sleeps = sleeps || Sleeps(multibody.getLinkCollider(i));
    return !sleeps;
}

qcStatus AddMesh(qcScene* scene, const qcSceneRigid& rigid, qcSceneMesh* mesh)
{
    return mesh->AddTo(scene, rigid.object->getWorldTransform() * mesh->local, rigid.activity);
}

void RemoveMeshes(qcScene* scene, const qcSceneRigid& rigid)
{
    for (const qcSceneMesh& mesh : rigid.meshes)
        if (qcScene_IsValid(scene, mesh.id))
            qcScene_RemoveBody(scene, mesh.id);
}

/// The motion of the surface of what stays in place, by its velocities.
qcRigidDisplacement ConveyedBy(const qcSceneRigid& rigid, btScalar timeStep)
{
    const btRigidBody* body = btRigidBody::upcast(rigid.object);
    if (body == nullptr || !body->isStaticOrKinematicObject() || !qcAreSame(rigid.start, rigid.solved) ||
        (body->isKinematicObject() && rigid.stepsInPlace < s_minStepsOfBelt))
        return {};
    return {body->getAngularVelocity() * timeStep, body->getLinearVelocity() * timeStep};
}

/// Reads what may differ in each step.
void ReadState(qcSceneRigid* rigid, const btTransform& start, btScalar timeStep)
{
    btRigidBody* body = btRigidBody::upcast(rigid->object);
    bool isPushed = body != nullptr && body->isActive() && !body->isStaticOrKinematicObject();
    rigid->body = isPushed ? body : nullptr;
    bool moves = (rigid->object->isActive() && !qcIsStatic(rigid->object)) || rigid->Deforms();
    qcActivity activity = moves || !qcAreSame(start, rigid->object->getWorldTransform()) ? qc_activityMoving
                          : qcIsStatic(rigid->object)                                    ? qc_activityStatic
                                                                                         : qc_activitySleeping;
    // The previous result has no pairs of two sleeping bodies.
    rigid->hasEnd = rigid->hasEnd && activity == rigid->activity;
    rigid->activity = activity;
    rigid->solved = rigid->object->getWorldTransform();
    rigid->start = start;
    const bool isInPlace = rigid->hasEnd && qcAreSame(rigid->end, rigid->solved) && qcAreSame(start, rigid->solved);
    rigid->stepsInPlace = isInPlace ? std::min(rigid->stepsInPlace + 1, s_minStepsOfBelt) : 0;
    rigid->moved = rigid->recovered = qcRigidDisplacement();
    rigid->fromStart = rigid->isFixed = false;
    rigid->tied.clear();
    rigid->massShare = 1;
    rigid->conveyed = ConveyedBy(*rigid, timeStep);
}
} // namespace

void qcRigidMeshes::BeginStep(const qcBroadphases& broadphases)
{
    m_beginnings.clear();
    m_starts.Begin(broadphases,
                   [this](const btCollisionObject* object)
                   {
                       if (const btMultiBodyLinkCollider* link = qcAsLink(object))
                           m_beginnings.try_emplace(link->m_multiBody, *link->m_multiBody);
                   });
}

void qcRigidMeshes::ReadMotions(const qcBroadphases& broadphases, btScalar timeStep, const qcRigidLimits* limits)
{
    m_timeStep = timeStep;
    m_starts.Read(broadphases, timeStep, limits);
    m_overlaps.Begin(m_starts);
    m_reshaped.Read(m_overlaps.Candidates());
}

void qcRigidMeshes::InvalidateShape(const btCollisionShape* shape)
{
    m_shapes.Forget(shape);
    m_reshaped.InvalidateShape(shape);
    for (auto* known : {&m_rigids, &m_away})
        for (const std::unique_ptr<qcSceneRigid>& rigid : *known)
            if (rigid)
                rigid->Invalidate(shape);
}

/// The object as it was in the previous step; null: not known.
qcSceneRigid* qcRigidMeshes::FindLast(const btCollisionObject* object) const
{
    const qcObjectKey key(object);
    auto isAny = [](const qcSceneRigid&) { return true; };
    const std::unique_ptr<qcSceneRigid>* last = m_rigidIndex.Find(m_rigids, key, isAny);
    if (last == nullptr)
        last = m_awayIndex.Find(m_away, key, isAny);
    return last != nullptr ? last->get() : nullptr;
}

/// True if the object is known with other triangles. `box` receives the lower and upper corner of the box around their
/// motion.
bool qcRigidMeshes::IsReshaped(const btCollisionObject* object, btVector3 box[2]) const
{
    const qcSceneRigid* last = FindLast(object);
    if (last == nullptr || AreSame(last->shapes, qcRigidShapes::ShapesOf(object, last->withSurfaces)))
        return false;
    object->getCollisionShape()->getAabb(object->getWorldTransform(), box[0], box[1]);
    for (const qcSceneMesh& mesh : last->meshes)
    {
        btVector3 lastBox[2];
        btTransformAabb(mesh.box[0], mesh.box[1], 0, m_starts.StartOf(object) * mesh.local, lastBox[0], lastBox[1]);
        box[0].setMin(lastBox[0]);
        box[1].setMax(lastBox[1]);
    }
    return true;
}

void qcRigidMeshes::ForEachPlaced(const qcBroadphases& broadphases, const qcObjectStarts::BoxFunction& function) const
{
    m_starts.ForEachPlaced(broadphases, function);
    qcForEachObject(broadphases,
                    [&](btCollisionObject* object, btBroadphaseInterface*)
                    {
                        btVector3 box[2];
                        if (object->hasContactResponse() && qcIsFinite(*object) && IsReshaped(object, box))
                            function(box[0], box[1]);
                    });
}

/// Adds overlaps of objects whose triangles have passed boxes of soft bodies since the previous step.
void qcRigidMeshes::AddReshaped()
{
    std::vector<qcRigidOverlap> added;
    for (btCollisionObject* object : m_reshaped.Objects())
    {
        btVector3 motion[2];
        if (!m_overlaps.Has(object) && IsReshaped(object, motion) && m_overlaps.IsNear(motion))
            added.push_back({object, true, {motion[0], motion[1]}});
    }
    m_overlaps.ForgetBoxes();
    m_overlaps.Add(added);
}

/// Keeps the meshes of objects whose triangles the application moves and that are near no soft body. Contacts may move
/// one there: see Extend.
void qcRigidMeshes::KeepReshaped()
{
    std::vector<std::unique_ptr<qcSceneRigid>> away;
    for (btCollisionObject* object : m_reshaped.Objects())
    {
        if (m_overlaps.Has(object))
            continue;
        const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
        const qcRigidOverlap overlap{object, true, {proxy->m_aabbMin, proxy->m_aabbMax}};
        std::unique_ptr<qcSceneRigid> rigid = qcRigidShapes::MakeRigid(overlap);
        auto isSame = [&](const qcSceneRigid& last) { return AreSame(last.shapes, rigid->shapes); };
        if (auto* last = m_awayIndex.Find(m_away, qcObjectKey(object), isSame))
        {
            rigid = std::move(*last);
            for (qcSceneMesh& mesh : rigid->meshes)
                mesh.startVertices.clear();
        }
        else
        {
            m_shapes.FindMeshes(rigid.get(), overlap);
            if (const qcSceneRigid* known = FindLast(object))
                rigid->DeformFrom(*known);
        }
        away.push_back(std::move(rigid));
    }
    m_away.swap(away);
    m_awayIndex.Build(m_away);
}

bool qcRigidMeshes::FindTransform(const qcSceneRigid& rigid, const qcSceneMesh& mesh, btTransform* transform) const
{
    const std::vector<qcSceneShape> present = qcRigidShapes::ShapesOf(rigid.object, rigid.withSurfaces);
    const qcSceneShape& shape = rigid.shapes[mesh.index];
    if (mesh.index >= present.size() || present[mesh.index].shape != shape.shape ||
        present[mesh.index].revision != shape.revision)
        return false;
    *transform = rigid.object->getWorldTransform() * present[mesh.index].local;
    return true;
}

/// The collected objects that have meshes. Those that are tracked already, unchanged, are moved out of m_rigids.
std::vector<std::unique_ptr<qcSceneRigid>> qcRigidMeshes::TakeTracked()
{
    m_overlaps.Merge();
    m_overlaps.AddLinks();
    AddReshaped();
    std::vector<std::unique_ptr<qcSceneRigid>> rigids;
    for (const qcRigidOverlap& overlap : m_overlaps.All())
    {
        std::unique_ptr<qcSceneRigid> rigid = qcRigidShapes::MakeRigid(overlap);
        if (rigid->shapes.empty())
            continue;
        auto isSame = [&](const qcSceneRigid& other)
        { return AreSame(other.shapes, rigid->shapes) && m_shapes.Cover(other, overlap); };
        auto* found = m_rigidIndex.Find(m_rigids, qcObjectKey(overlap.object), isSame);
        bool isReshaped = false;
        if (found != nullptr && (*found)->Rest())
            rigid = std::move(*found);
        else
        {
            m_shapes.FindMeshes(rigid.get(), overlap);
            qcSceneRigid* last = FindLast(rigid->object);
            if (last != nullptr && !AreSame(last->shapes, rigid->shapes))
            {
                rigid->DeformFrom(*last);
                rigid->TakeBodies(last);
                isReshaped = !rigid->Deforms() && AreReshaped(last->shapes, rigid->shapes);
            }
        }
        rigid->isReshaped = isReshaped;
        if (!rigid->meshes.empty())
            rigids.push_back(std::move(rigid));
    }
    KeepReshaped();
    m_overlaps.Clear();
    return rigids;
}

/// Finds the multibody of a link that Bullet moves.
void qcRigidMeshes::FindMultiBody(qcSceneRigid* rigid)
{
    const btMultiBodyLinkCollider* collider = qcAsLink(rigid->object);
    rigid->multibody = nullptr;
    if (collider == nullptr || !IsStepped(*collider->m_multiBody))
        return;
    auto isIt = [collider](const std::unique_ptr<qcMultiBodyMotion>& known)
    { return &known->Body() == collider->m_multiBody; };
    auto found = std::find_if(m_multibodies.begin(), m_multibodies.end(), isIt);
    if (found == m_multibodies.end())
    {
        auto beginning = m_beginnings.find(collider->m_multiBody);
        const qcJointPositions* start = beginning != m_beginnings.end() ? &beginning->second : nullptr;
        found = m_multibodies.emplace(found, new qcMultiBodyMotion(*collider->m_multiBody, start));
    }
    if (!m_starts.StartsAtBegin(collider))
        (*found)->ForgetStart();
    const size_t link = (*found)->AddLink(collider->m_link);
    rigid->multibody = (*found)->CanMove(link) ? found->get() : nullptr;
    rigid->link = link;
    rigid->isFixed = (*found)->HasReturned();
}

/// Appends the object, with its meshes in the scene. After a failure it is not tracked, and none of them is there.
qcStatus qcRigidMeshes::Track(qcScene* scene, std::unique_ptr<qcSceneRigid> rigid)
{
    qcActivity previous = rigid->activity;
    ReadState(rigid.get(), m_starts.StartOf(rigid->object), m_timeStep);
    FindMultiBody(rigid.get());
    rigid->isGuided = rigid->CanMove() && !rigid->IsFree();
    qcStatus status = qc_statusOk;
    for (qcSceneMesh& mesh : rigid->meshes)
        if (status == qc_statusOk && mesh.id.generation == 0)
            status = AddMesh(scene, *rigid, &mesh);
        else if (status == qc_statusOk && rigid->activity != previous)
            status = qcScene_SetActivity(scene, mesh.id, rigid->activity);
    if (status == qc_statusOk)
        m_rigids.push_back(std::move(rigid));
    else
        RemoveMeshes(scene, *rigid);
    return status;
}

void qcRigidMeshes::Index()
{
    m_rigidIndex.Build(m_rigids);
    m_meshOfSlot.clear();
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (size_t i = 0; i < rigid->meshes.size(); i++)
        {
            uint32_t slot = rigid->meshes[i].id.slot;
            if (slot >= m_meshOfSlot.size())
                m_meshOfSlot.resize(slot + 1, {nullptr, 0});
            m_meshOfSlot[slot] = {rigid.get(), i};
        }
}

qcStatus qcRigidMeshes::Sync(qcScene* scene)
{
    std::vector<std::unique_ptr<qcSceneRigid>> rigids = TakeTracked();
    for (const std::unique_ptr<qcSceneRigid>& gone : m_rigids)
        if (gone)
            RemoveMeshes(scene, *gone);
    m_rigids.clear();
    m_multibodies.clear();
    m_shapes.EndStep();
    qcStatus status = qc_statusOk;
    for (std::unique_ptr<qcSceneRigid>& rigid : rigids)
        status = qcFirstError(status, Track(scene, std::move(rigid)));
    Index();
    return status;
}

bool qcRigidMeshes::MayMiss() const
{
    auto isInPart = [](const qcSceneShape& shape) { return shape.surface != nullptr && !shape.surface->isWhole; };
    auto hasParts = [&](const std::unique_ptr<qcSceneRigid>& rigid)
    { return std::any_of(rigid->shapes.begin(), rigid->shapes.end(), isInPart); };
    return m_overlaps.Candidates().size() > m_rigids.size() || std::any_of(m_rigids.begin(), m_rigids.end(), hasParts);
}

qcStatus qcRigidMeshes::Extend(qcScene* scene, bool* added)
{
    qcStatus status = qc_statusOk;
    m_overlaps.Merge();
    m_overlaps.AddLinks();
    for (const qcRigidOverlap& overlap : m_overlaps.All())
    {
        const qcObjectKey key(overlap.object);
        // An object that contacts move is in the scene once.
        auto isThere = [&](const qcSceneRigid& rigid)
        {
            bool hasAll = rigid.withSurfaces >= overlap.withSurfaces && m_shapes.Cover(rigid, overlap);
            return hasAll || rigid.CanMove();
        };
        if (m_rigidIndex.Find(m_rigids, key, isThere) != nullptr)
            continue;
        auto isAway = [&](const qcSceneRigid& away) { return away.withSurfaces == overlap.withSurfaces; };
        auto* away = m_awayIndex.Find(m_away, key, isAway);
        std::unique_ptr<qcSceneRigid> rigid = away != nullptr ? std::move(*away) : qcRigidShapes::MakeRigid(overlap);
        if (rigid->meshes.empty())
            m_shapes.FindMeshes(rigid.get(), overlap);
        if (rigid->meshes.empty() || status != qc_statusOk)
            continue;
        status = Track(scene, std::move(rigid));
        *added = true;
    }
    m_overlaps.Clear();
    if (*added)
        Index();
    return status;
}

bool qcRigidMeshes::StartWhereTheyEnded() const
{
    auto startsThere = [](const std::unique_ptr<qcSceneRigid>& rigid)
    { return rigid->hasEnd && qcAreSame(rigid->start, rigid->end); };
    return std::all_of(m_rigids.begin(), m_rigids.end(), startsThere);
}

qcStatus qcRigidMeshes::SyncTransforms(qcScene* scene, bool atStart)
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (qcSceneMesh& mesh : rigid->meshes)
        {
            qcScene_SetMargin(scene, mesh.id, double(mesh.shape->getMargin()));
            const btTransform& object = atStart ? rigid->start : rigid->object->getWorldTransform();
            qcStatus status = mesh.Place(scene, object * mesh.local, atStart);
            if (status != qc_statusOk)
                return status;
        }
    return qc_statusOk;
}

void qcRigidMeshes::AddMotionBoxes(btScalar reach, qcMotionBoxes* boxes) const
{
    for (const std::unique_ptr<qcSceneRigid>& rigid : m_rigids)
        for (const qcSceneMesh& mesh : rigid->meshes)
        {
            btVector3 box[2];
            rigid->FindMotionBox(mesh, box);
            qcEnlarge(reach, box);
            boxes->Add(box[0], box[1], true);
        }
}

int qcRigidMeshes::CountWith(bool surface) const
{
    auto isIt = [surface](const qcSceneMesh& mesh) { return mesh.isSurface == surface; };
    auto has = [&](const std::unique_ptr<qcSceneRigid>& rigid)
    { return std::any_of(rigid->meshes.begin(), rigid->meshes.end(), isIt); };
    return int(std::count_if(m_rigids.begin(), m_rigids.end(), has));
}

const qcSceneMesh* qcRigidMeshes::Find(uint32_t slot, qcSceneRigid** rigid)
{
    if (slot >= m_meshOfSlot.size() || m_meshOfSlot[slot].first == nullptr)
        return nullptr;
    *rigid = m_meshOfSlot[slot].first;
    return &(*rigid)->meshes[m_meshOfSlot[slot].second];
}
