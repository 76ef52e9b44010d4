// The objects of a world that hold meshes, and its convex shapes that may pass one, with their motion in a step, and
// the pairs whose motions overlap.
#include "mesh_contact/limits/swept_objects.h"

#include "common/changed_shapes.h"
#include "common/compound_children.h"
#include "common/object_motion.h"
#include "common/rigid_motion.h"
#include "mesh_contact/limits/swept_pairs.h"

#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <functional>

namespace
{
// Bullet's contact pushes a convex shape back to the side of a mesh from which it comes, unless it moves by more than
// this part of its core's half width in a step.
constexpr btScalar s_slowPart = btScalar(0.5);
// The core of one that moves by less than this part of the contact breaking threshold, and than this part of its size,
// is not looked up: so bodies at rest cost next to nothing.
constexpr btScalar s_restMotion = btScalar(0.1), s_restPart = btScalar(1) / 4096;
// Meshes that move by less than this part of the threshold count as at rest.
constexpr btScalar s_restMeshMotion = btScalar(0.005);
// One that is deeper in another object than this part may be pressed through a mesh slowly, or pushed by split
// impulses, which move bodies without a velocity.
constexpr btScalar s_deepPart = btScalar(0.1);
// Steps for which a convex shape that was fast or deep takes part: its starts are exact, and its core stays in the
// scene.
constexpr int s_coreSteps = 30;

/// Finds what of an object's shape consists of triangles.
void ReadShape(qcSweptObject* swept, bool gimpact)
{
    swept->radius = swept->object->getCollisionShape()->getAngularMotionDisc();
    swept->hasMesh = swept->isOurs = false;
    auto read = [swept, gimpact](const btCollisionShape* simple, const btTransform&)
    {
        swept->hasMesh = swept->hasMesh || qcIsMesh(simple);
        swept->isOurs = swept->isOurs || qcAsMeshShape(simple) != nullptr || (gimpact && qcIsGImpactMesh(simple));
    };
    qcForEachSimpleShape(swept->object->getCollisionShape(), btTransform::getIdentity(), read);
}

/// True for a mesh whose contact is computed here, if it is not at rest.
bool IsMovingMesh(const qcSweptObject& swept)
{
    return swept.isOurs && swept.travel > s_restMeshMotion * gContactBreakingThreshold;
}
} // namespace

/// The entry of an object, which is added if it is new: it has not moved yet.
qcSweptObject* qcSweptObjects::Add(const btCollisionObject* object)
{
    std::unique_ptr<qcSweptObject>& entry = m_objects[qcObjectKey(object)];
    if (entry == nullptr)
    {
        entry.reset(new qcSweptObject);
        entry->object = const_cast<btCollisionObject*>(object);
        entry->number = m_numbers.Take(
            [this](auto add)
            {
                for (const auto& [key, swept] : m_objects)
                    add(swept->number);
            });
        entry->start = entry->next = entry->last = object->getWorldTransform();
        m_sorted.push_back(entry.get());
    }
    return entry.get();
}

void qcSweptObjects::MarkStarts()
{
    m_starts.BeginMarks();
    m_origins.MarkStarts(*m_settings.world);
    btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btRigidBody* body = qcDynamicBody(objects[i]);
        if (body == nullptr)
            continue;
        if (qcMayHoldMeshes(objects[i]->getCollisionShape()) || (m_coreCount > 0 && Find(objects[i]) != nullptr))
        {
            qcSweptObject* swept = Add(objects[i]);
            swept->next = objects[i]->getWorldTransform();
            swept->wasActive = objects[i]->isActive();
            swept->wasFinite = qcIsFinite(*objects[i]);
            swept->before = body->getLinearVelocity();
        }
        else if (objects[i]->getCcdSquareMotionThreshold() > 0)
            m_starts.MarkContinuous(*objects[i]);
    }
}

void qcSweptObjects::KeepTriangles(const btCollisionObject* object)
{
    qcSweptObject* swept = Add(object);
    if (swept->meshes.empty())
        swept->meshes = qcReadSweptMeshes(object->getCollisionShape());
}

void qcSweptObjects::InvalidateShape(const btCollisionShape* shape)
{
    m_resting.WakeAll(&m_sorted);
    for (qcSweptObject* swept : m_sorted)
        for (qcSweptMesh& mesh : swept->meshes)
            if (mesh.shape == shape)
                mesh.revision = qcStaleRevision;
    // Where no motion is read, none is certified.
    if (m_step > 0)
        m_changedShapes.Add(shape);
}

/// Notices that the application has moved the triangles of an object that Bullet does not move: its meshes then deform
/// in this step, if the previous one had read them.
void qcSweptObjects::ReadTriangles(qcSweptObject* swept, qcScene* scene) const
{
    if (swept->body != nullptr)
        swept->revision = qcStaleRevision;
    if (swept->body != nullptr || !swept->hasMesh)
        return;
    uint64_t revision = 0;
    bool hasChanged = false;
    auto add = [&](const btCollisionShape* simple, const btTransform&)
    {
        if (!qcIsMesh(simple))
            return;
        revision = qcMixHash(revision, qcMeshRevision(simple));
        hasChanged = hasChanged || m_changedShapes.Has(simple);
    };
    qcForEachSimpleShape(swept->object->getCollisionShape(), btTransform::getIdentity(), add);
    std::swap(swept->revision, revision);
    if (revision == 0 || (revision == swept->revision && !hasChanged))
        return;
    std::vector<qcSweptMesh> last = qcReadSweptMeshes(swept->object->getCollisionShape());
    last.swap(swept->meshes);
    for (size_t i = 0; i < std::min(last.size(), swept->meshes.size()); i++)
        swept->meshes[i].DeformFrom(&last[i]);
    for (qcSweptMesh& mesh : last)
        mesh.RemoveFrom(scene);
}

/// The meshes that have deformed in the previous step are where they are.
void qcSweptObjects::EndDeformations() const
{
    for (qcSweptObject* swept : m_sorted)
        for (qcSweptMesh& mesh : swept->meshes)
            mesh.startVertices.clear();
}

void qcSweptObjects::RemoveGone(qcScene* scene)
{
    auto isGone = [this](const qcSweptObject* swept) { return !swept->rests && swept->step != m_step; };
    for (qcSweptObject* swept : m_sorted)
        if (isGone(swept))
            for (qcSweptMesh& mesh : swept->meshes)
                mesh.RemoveFrom(scene);
    m_sorted.erase(std::remove_if(m_sorted.begin(), m_sorted.end(), isGone), m_sorted.end());
    for (auto entry = m_objects.begin(); entry != m_objects.end();)
    {
        const bool isErased = isGone(entry->second.get());
        if (isErased)
            m_resting.Forget(entry->first);
        entry = isErased ? m_objects.erase(entry) : std::next(entry);
    }
}

/// Upper bound of the motion of a dynamic body or a link against the meshes near it, in a step.
btScalar qcSweptObjects::TravelNear(const btCollisionObject* object) const
{
    // A sphere that turns is where it was.
    const btCollisionShape* shape = object->getCollisionShape();
    const btScalar radius = shape->getShapeType() == SPHERE_SHAPE_PROXYTYPE ? 0 : shape->getAngularMotionDisc();
    const qcSweptMultiBody* multibody = m_multibodies.Find(object);
    const btScalar own = multibody != nullptr
                             ? qcDisplacementBound(multibody->StartOf(object), object->getWorldTransform(), radius)
                             : qcRigidMotion(object).MaxSpeed(radius) * m_timeStep;
    if (m_movingMeshes.IsEmpty())
        return own;
    btVector3 lower, upper;
    shape->getAabb(object->getWorldTransform(), lower, upper);
    const btVector3 around(own, own, own);
    return own + m_movingMeshes.LargestTravelIn(lower - around, upper + around);
}

/// True if convex shapes whose cores have this half width may pass a mesh in the step: they are fast, or deep in one.
bool qcSweptObjects::MayPass(const btCollisionObject* object, btScalar halfWidth) const
{
    const btScalar rest = std::min(s_restMotion * gContactBreakingThreshold,
                                   s_restPart * object->getCollisionShape()->getAngularMotionDisc());
    return TravelNear(object) > std::max(s_slowPart * halfWidth, rest) ||
           m_depths.DepthOf(object) > s_deepPart * halfWidth || m_depths.HeldOffOf(object) > s_slowPart * halfWidth;
}

/// True if the convex shapes of a dynamic body, a link or a static object may pass a mesh in the step, or might have
/// lately: they are fast, or deep in another object. Those of kinematic bodies take part in every step while a mesh is
/// free: their starts must be known.
bool qcSweptObjects::TakesCores(const btCollisionObject* object)
{
    const btCollisionShape* shape = object->getCollisionShape();
    if (!(shape->isConvex() || shape->isCompound()) || !object->hasContactResponse())
        return false;
    if (object->isKinematicObject())
        return m_anyFreeMesh;
    if (!qcIsStatic(object) && qcDynamicBody(const_cast<btCollisionObject*>(object)) == nullptr &&
        qcAsLink(object) == nullptr)
        return false;
    const qcSweptObject* known = m_coreCount > 0 ? Find(object) : nullptr;
    if (known != nullptr && known->coreSteps > 0)
        return true;
    if (!MayPass(object, 0))
        return false;
    btScalar halfWidth = BT_LARGE_FLOAT;
    m_cores.ForEachCore(shape, [&halfWidth](const qcConvexCore& core, const btTransform&)
                        { halfWidth = std::min(halfWidth, core.halfWidth); });
    return MayPass(object, halfWidth);
}

bool qcSweptObjects::MissesCores()
{
    m_movingMeshes.Clear();
    for (qcSweptObject* swept : m_sorted)
    {
        if (!swept->isOurs || !swept->isLimited)
            continue;
        swept->target = swept->object->getWorldTransform();
        swept->FindTravel();
        if (IsMovingMesh(*swept))
            m_movingMeshes.Add(swept);
    }
    m_movingMeshes.Sort();
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    auto isMissed = [this](const btCollisionObject* object)
    {
        // Meshes have none.
        if (object->getCollisionShape()->isConcave())
            return false;
        const qcSweptObject* swept = Find(object);
        return (swept == nullptr || swept->cores == nullptr) && qcIsFinite(*object) && TakesCores(object);
    };
    return !m_movingMeshes.IsEmpty() && std::any_of(&objects[0], &objects[0] + objects.size(), isMissed);
}

/// Reads the present transform of an object as its target.
qcSweptObject& qcSweptObjects::ReadTarget(btCollisionObject* object, bool takesCores, qcScene* scene)
{
    qcSweptObject& swept = *Add(object);
    const bool isRead = swept.step == m_step;
    swept.step = m_step;
    swept.isHeld = swept.isPaired = false;
    swept.body = qcDynamicBody(object);
    const btMultiBodyLinkCollider* asLink = qcAsLink(object);
    swept.owner = asLink != nullptr ? asLink->m_multiBody : nullptr;
    swept.multibody = m_multibodies.Find(object);
    swept.isDynamic = swept.body != nullptr || (swept.multibody != nullptr && swept.multibody->HasFreeBase());
    if (swept.multibody != nullptr)
    {
        swept.start = swept.multibody->StartOf(object);
        swept.multibody->Add(&swept);
        if (!swept.multibody->CanMove(object))
            swept.multibody = nullptr;
    }
    ReadShape(&swept, m_settings.gimpact);
    if (!isRead)
        ReadTriangles(&swept, scene);
    swept.hull = swept.Deforms() ? nullptr : m_axes.FindMesh(object);
    swept.cores = takesCores ? &m_cores : nullptr;
    if (takesCores && swept.isNew)
        swept.wasActive = object->isActive();
    swept.ReadCores(object->getCollisionShape());
    swept.target = swept.end = object->getWorldTransform();
    swept.floors.clear();
    if (swept.body != nullptr && swept.hull != nullptr)
        m_planes.FindFloors(m_settings.world, object, *swept.hull, swept.target, &swept.floors);
    // How far new meshes move decides which convex shapes take part.
    if (m_findsStarts && swept.isNew && swept.body != nullptr && swept.cores == nullptr)
        qcSweptStarts::FindByVelocities(m_timeStep, &swept);
    swept.carried = swept.start;
    swept.isLookedUp = false;
    swept.children.Clear();
    swept.nearChildren.clear();
    swept.pushes = 0;
    swept.fraction = 1;
    swept.FindTravel();
    return swept;
}

void qcSweptObjects::Hold(const btCollisionObject* object)
{
    const btMultiBodyLinkCollider* link = qcAsLink(object);
    for (qcSweptObject* swept : m_sorted)
        if (swept->object == object || (link != nullptr && swept->owner == link->m_multiBody))
        {
            swept->isHeld = swept->isHeld || swept->IsFree();
            swept->body = nullptr;
            swept->multibody = nullptr;
        }
}

bool qcSweptObjects::ReadTargets(const qcStartFunction& startOf, qcScene* scene)
{
    m_multibodies.ForAll(&qcSweptMultiBody::ReadTarget);
    const bool anyMoved = ReadObjects(false, scene);
    // Convex shapes that soft bodies have made fast have not been read before in this step.
    for (qcSweptObject* swept : m_sorted)
        if (swept->isNew && swept->cores != nullptr && swept->body != nullptr)
        {
            const btTransform* start = startOf(swept->object);
            swept->start = swept->carried = start != nullptr ? *start : swept->target;
            swept->FindTravel();
        }
    return anyMoved;
}

/// `readsDepths`: otherwise those of the step's motions count.
bool qcSweptObjects::ReadObjects(bool readsDepths, qcScene* scene)
{
    m_step++;
    m_axes.BeginObjects();
    m_resting.BeginObjects();
    m_planes.Read(*m_settings.world);
    bool anyMoved = false;
    size_t present = 0;
    btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    // Meshes first: how far they move decides which convex shapes may pass one.
    m_anyOurs = m_anyFreeMesh = false;
    m_movingMeshes.Clear();
    m_notFinite = nullptr;
    for (int i = 0; i < objects.size(); i++)
        if (qcMayHoldMeshes(objects[i]->getCollisionShape()) && !m_resting.Rests(objects[i], size_t(i), &m_sorted))
        {
            if (!qcIsFinite(*objects[i]))
            {
                m_notFinite = objects[i];
                continue;
            }
            present++;
            qcSweptObject& swept = ReadTarget(objects[i], false, scene);
            anyMoved = anyMoved || !qcAreSame(swept.start, swept.target);
            m_anyOurs = m_anyOurs || swept.isOurs;
            m_anyFreeMesh = m_anyFreeMesh || (swept.isOurs && (swept.body != nullptr || swept.owner != nullptr));
            if (!IsMovingMesh(swept))
                continue;
            swept.FindBox();
            m_movingMeshes.Add(&swept);
        }
    m_resting.WakeGone(&m_sorted);
    m_anyOurs = m_anyOurs || m_resting.AnyOurs();
    m_movingMeshes.Sort();
    if (m_anyOurs && readsDepths)
        m_depths.Read(m_settings.world->getDispatcher(), m_timeStep);
    for (int i = 0; m_anyOurs && i < objects.size(); i++)
        if (qcIsFinite(*objects[i]) && TakesCores(objects[i]))
        {
            present += !qcMayHoldMeshes(objects[i]->getCollisionShape());
            ReadTarget(objects[i], true, scene);
            anyMoved = true;
        }
    if (present != m_sorted.size())
        RemoveGone(scene);
    m_changedShapes.Clear();
    return anyMoved;
}

/// Where the application has moved all objects, it has not moved the bases of multibodies against others.
void qcSweptObjects::StartWherePut()
{
    m_multibodies.ForAll(&qcSweptMultiBody::StartWherePut);
    for (qcSweptObject* swept : m_sorted)
        if (const qcSweptMultiBody* multibody = m_multibodies.Find(swept->object))
            swept->start = multibody->StartOf(swept->object);
}

bool qcSweptObjects::ReadMotions(btScalar timeStep, qcScene* scene)
{
    for (qcSweptObject* swept : m_sorted)
    {
        swept->start = swept->next;
        swept->lost = 0;
        swept->isLimited = false;
        if (!m_starts.AreMarked())
            swept->before.reset();
    }
    EndDeformations();
    m_timeStep = timeStep;
    m_cores.BeginStep();
    m_innerCores.BeginStep();
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    bool anyMesh = false;
    for (int i = 0; i < objects.size() && !anyMesh; i++)
        anyMesh = qcMayHoldMeshes(objects[i]->getCollisionShape());
    m_multibodies.ReadMotions(timeStep, anyMesh);
    m_findsStarts = !m_starts.AreMarked();
    m_depths.Clear();
    ReadObjects(true, scene);
    m_findsStarts = false;
    for (qcSweptObject* swept : m_sorted)
        m_starts.Find(timeStep, swept);
    const qcTranslation shift = qcFindCommonShift(m_sorted, m_origins, *m_settings.world, timeStep);
    if (!shift.by.isZero())
        StartWherePut();
    bool anyMoved = false;
    m_coreCount = 0;
    for (qcSweptObject* swept : m_sorted)
    {
        qcSweptStarts::StartWherePut(shift, timeStep, swept);
        swept->carried = swept->start;
        swept->FindTravel();
        const bool isTaken = swept->cores != nullptr && MayPass(swept->object, swept->halfWidth);
        swept->coreSteps = isTaken ? s_coreSteps : std::max(swept->coreSteps - 1, 0);
        m_coreCount += swept->cores != nullptr;
        anyMoved = anyMoved || !qcAreSame(swept->start, swept->target) || swept->Deforms();
    }
    m_starts.EndStep();
    return anyMoved;
}

/// Has static meshes take part that something moves near.
void qcSweptObjects::WakeNearMoving(qcScene* scene)
{
    std::vector<qcSweptObject*> awake;
    for (const qcSweptObject* swept : m_sorted)
        if (swept->moves)
            m_resting.WakeNear(swept->lower, swept->upper, &awake);
    for (qcSweptObject* swept : awake)
    {
        ReadTarget(swept->object, false, scene);
        swept->isUnmoved = false;
        swept->FindBox();
        m_sorted.push_back(swept);
    }
}

/// Leaves out static meshes without a pair in this step.
void qcSweptObjects::LetRest()
{
    auto canRest = [](const qcSweptObject* swept) { return !swept->isPaired && qcRestingMeshes::CanRest(*swept); };
    const auto rested = std::stable_partition(m_sorted.begin(), m_sorted.end(), std::not_fn(canRest));
    for (auto swept = rested; swept != m_sorted.end(); ++swept)
        m_resting.Add(*swept);
    m_sorted.erase(rested, m_sorted.end());
}

void qcSweptObjects::FindPairs(qcScene* scene, std::vector<qcSweptPair>* pairs)
{
    for (qcSweptObject* swept : m_sorted)
        swept->FindBox();
    WakeNearMoving(scene);
    qcFindSweptPairs(m_settings.world, m_sorted, pairs);
}

void qcSweptObjects::RecordEnds()
{
    m_multibodies.ForAll(&qcSweptMultiBody::RecordEnd);
    for (qcSweptObject* swept : m_sorted)
    {
        swept->next = swept->last = swept->object->getWorldTransform();
        swept->wasActive = swept->object->isActive();
        swept->wasFinite = true;
        swept->isNew = false;
    }
    m_origins.RecordEnds(*m_settings.world);
    LetRest();
}

void qcSweptObjects::AddInnerCores(qcSweptObject* swept)
{
    swept->innerCores = swept->cores != nullptr ? &m_innerCores : nullptr;
}

qcSweptObject* qcSweptObjects::Find(const btCollisionObject* object) const
{
    auto found = m_objects.find(qcObjectKey(object));
    return found != m_objects.end() ? found->second.get() : nullptr;
}

bool qcSweptObjects::AreAtEnds()
{
    const btCollisionObjectArray& objects = m_settings.world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const qcSweptObject* swept = Find(objects[i]);
        if (!qcIsFinite(*objects[i]) || !(swept != nullptr || qcMayHoldMeshes(objects[i]->getCollisionShape()) ||
                                          (m_anyOurs && TakesCores(objects[i]))))
            continue;
        if (swept == nullptr || !qcAreSame(swept->next, objects[i]->getWorldTransform()))
            return false;
    }
    return true;
}
