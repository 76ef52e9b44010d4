// The collision algorithm of a compound and another shape, with children that overlap it at the start of the step, and
// queries of such.
#include "mesh_contact/compound_mesh_algorithm.h"

#include "common/rigid_motion.h"
#include "common/shape_triangles.h"

#include <BulletCollision/BroadphaseCollision/btDbvt.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btCompoundCompoundCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCompoundShape.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cstdint>
#include <limits>

namespace
{
// Pairs of children of two compounds.
constexpr int64_t s_maxChildPairs = 4096;

bool HoldsMesh(const btCollisionShape* shape)
{
    if (!shape->isCompound())
        return qcAsMeshShape(shape) != nullptr;
    const auto& compound = *static_cast<const btCompoundShape*>(shape);
    for (int i = 0; i < compound.getNumChildShapes(); i++)
        if (HoldsMesh(compound.getChildShape(i)))
            return true;
    return false;
}

bool HoldMeshes(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1)
{
    return HoldsMesh(body0.getCollisionShape()) || HoldsMesh(body1.getCollisionShape());
}

struct Box
{
    btVector3 lower, upper;

    Box(const btCollisionShape& shape, const btTransform& place)
    {
        shape.getAabb(place, lower, upper);
    }

    void Add(const Box& other)
    {
        lower.setMin(other.lower);
        upper.setMax(other.upper);
    }
};

/// Where an object, or a part of it, starts and ends the step.
struct Travel
{
    btTransform start, end;
    bool isLed; ///< of a kinematic body: otherwise the start is the end

    Travel(const btCollisionObjectWrapper& body, btScalar timeStep)
        : start(qcKinematicStart(*body.getCollisionObject(), body.getWorldTransform(), timeStep)),
          end(body.getWorldTransform()), isLed(body.getCollisionObject()->isKinematicObject())
    {
    }
};

btVector3 Slack()
{
    return btVector3(gContactBreakingThreshold, gContactBreakingThreshold, gContactBreakingThreshold);
}

/// The box of a shape at the start and at the end of the step. Boxes of what rests on a body touch those of the body,
/// up to the distance of contact points. `local`: of the shape, in the frame of what travels.
Box SweptBox(const btCollisionShape& shape, const Travel& travel, const btTransform& local)
{
    Box box(shape, travel.end * local);
    if (!travel.isLed)
        return box;
    Box start(shape, travel.start * local);
    start.lower -= Slack();
    start.upper += Slack();
    box.Add(start);
    return box;
}

const btCompoundShape& ShapeOf(const btCollisionObjectWrapper& compound)
{
    return *static_cast<const btCompoundShape*>(compound.getCollisionShape());
}

/// True if a child of the compound overlaps a box in the step.
bool Overlaps(const btCompoundShape& compound, int child, const Travel& travel, const Box& other)
{
    const Box box = SweptBox(*compound.getChildShape(child), travel, compound.getChildTransform(child));
    return TestAabbAgainstAabb2(box.lower, box.upper, other.lower, other.upper);
}

/// Each child of a compound that another one overlaps has a list of all the other's children.
bool IsFew(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1)
{
    if (!body0.getCollisionShape()->isCompound() || !body1.getCollisionShape()->isCompound())
        return true;
    const int64_t count0 = ShapeOf(body0).getNumChildShapes(), count1 = ShapeOf(body1).getNumChildShapes();
    return count0 * count1 <= s_maxChildPairs && gCompoundCompoundChildShapePairCallback == nullptr;
}

/// Bullet's algorithm at a distance above 0.
template <class Compound> struct Query : Compound
{
    using Compound::Compound;

    void processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                          const btDispatcherInfo& dispatchInfo, btManifoldResult* result) override
    {
        const btScalar distance = result->m_closestPointDistanceThreshold;
        result->m_closestPointDistanceThreshold = std::max(distance, std::numeric_limits<btScalar>::min());
        Compound::processCollision(body0, body1, dispatchInfo, result);
        result->m_closestPointDistanceThreshold = distance;
    }
};

template <class Compound>
btCollisionAlgorithm* MakeQuery(btCollisionAlgorithmConstructionInfo& info, const btCollisionObjectWrapper* body0,
                                const btCollisionObjectWrapper* body1, bool swapped)
{
    static_assert(sizeof(Query<Compound>) == sizeof(Compound), "fits into Bullet's pool");
    return new (info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(Query<Compound>)))
        Query<Compound>(info, body0, body1, swapped);
}

/// Collects the children whose leaves are met.
struct ChildCollector : btDbvt::ICollide
{
    btAlignedObjectArray<int> children;

    void Process(const btDbvtNode* leaf) override
    {
        children.push_back(leaf->dataAsInt);
    }
};

/// The children that may overlap the other shape in the step.
void FindChildren(const btCompoundShape& compound, const Travel& travel, const btCollisionShape& other,
                  const Travel& otherTravel, ChildCollector* collector)
{
    const btDbvt* tree = compound.getDynamicAabbTree();
    if (tree == nullptr)
    {
        for (int i = 0; i < compound.getNumChildShapes(); i++)
            collector->children.push_back(i);
        return;
    }
    Box box(other, travel.end.inverse() * otherTravel.end);
    box.Add(Box(other, travel.start.inverse() * otherTravel.start));
    btDbvtVolume volume = btDbvtVolume::FromMM(box.lower - Slack(), box.upper + Slack());
    tree->collideTV(tree->m_root, volume, *collector);
}
} // namespace

/// As Bullet's algorithm does, before it finds points.
void qcCompoundMeshAlgorithm::RefreshManifolds(btManifoldResult* result)
{
    btManifoldArray manifolds;
    getAllContactManifolds(manifolds);
    for (int i = 0; i < manifolds.size(); i++)
        if (manifolds[i]->getNumContacts() > 0)
        {
            result->setPersistentManifold(manifolds[i]);
            result->refreshContactPoints();
        }
    result->setPersistentManifold(nullptr);
}

void qcCompoundMeshAlgorithm::RemoveChild(int child)
{
    btCollisionAlgorithm*& algorithm = m_childCollisionAlgorithms[child];
    algorithm->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(algorithm);
    algorithm = nullptr;
}

void qcCompoundMeshAlgorithm::ProcessChild(const btCollisionObjectWrapper& compound,
                                           const btCollisionObjectWrapper& other, int child,
                                           const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    const btCompoundShape& shape = ShapeOf(compound);
    const btCollisionShape* childShape = shape.getChildShape(child);
    if (gCompoundChildShapePairCallback != nullptr &&
        !gCompoundChildShapePairCallback(other.getCollisionShape(), childShape))
        return;
    // The wrapper refers to the transforms.
    const btTransform place = compound.getWorldTransform() * shape.getChildTransform(child);
    btTransform local = shape.getChildTransform(child);
    if (compound.m_preTransform != nullptr)
        local = local * *compound.m_preTransform;
    const btCollisionObjectWrapper part(&compound, childShape, compound.getCollisionObject(), place, local, -1, child);
    btCollisionAlgorithm*& algorithm = m_childCollisionAlgorithms[child];
    if (algorithm == nullptr)
        algorithm = m_dispatcher->findAlgorithm(&part, &other, m_sharedManifold, BT_CONTACT_POINT_ALGORITHMS);
    if (result->getBody0Internal() == compound.getCollisionObject())
    {
        const btCollisionObjectWrapper* whole = result->getBody0Wrap();
        result->setBody0Wrap(&part);
        result->setShapeIdentifiersA(-1, child);
        algorithm->processCollision(&part, &other, dispatchInfo, result);
        result->setBody0Wrap(whole);
    }
    else
    {
        const btCollisionObjectWrapper* whole = result->getBody1Wrap();
        result->setBody1Wrap(&part);
        result->setShapeIdentifiersB(-1, child);
        algorithm->processCollision(&part, &other, dispatchInfo, result);
        result->setBody1Wrap(whole);
    }
}

void qcCompoundMeshAlgorithm::processCollision(const btCollisionObjectWrapper* body0,
                                               const btCollisionObjectWrapper* body1,
                                               const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    const btCollisionObjectWrapper &compound = m_isSwapped ? *body1 : *body0, &other = m_isSwapped ? *body0 : *body1;
    if (!compound.getCollisionObject()->isKinematicObject() && !other.getCollisionObject()->isKinematicObject())
    {
        btCompoundCollisionAlgorithm::processCollision(body0, body1, dispatchInfo, result);
        return;
    }
    if (ShapeOf(compound).getUpdateRevision() != m_compoundShapeRevision)
    {
        removeChildAlgorithms();
        preallocateChildAlgorithms(body0, body1);
        m_compoundShapeRevision = ShapeOf(compound).getUpdateRevision();
    }
    RefreshManifolds(result);
    const btCompoundShape& shape = ShapeOf(compound);
    const Travel travel(compound, dispatchInfo.m_timeStep), otherTravel(other, dispatchInfo.m_timeStep);
    const Box box = SweptBox(*other.getCollisionShape(), otherTravel, btTransform::getIdentity());
    ChildCollector found;
    FindChildren(shape, travel, *other.getCollisionShape(), otherTravel, &found);
    for (int i = 0; i < found.children.size(); i++)
        if (Overlaps(shape, found.children[i], travel, box))
            ProcessChild(compound, other, found.children[i], dispatchInfo, result);
    for (int child = 0; child < m_childCollisionAlgorithms.size(); child++)
        if (m_childCollisionAlgorithms[child] != nullptr && !Overlaps(shape, child, travel, box))
            RemoveChild(child);
}

btCollisionAlgorithm* qcCompoundMeshCreate::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                     const btCollisionObjectWrapper* body0,
                                                                     const btCollisionObjectWrapper* body1)
{
    const bool isLed =
        body0->getCollisionObject()->isKinematicObject() || body1->getCollisionObject()->isKinematicObject();
    if (!isLed || !IsFew(*body0, *body1) || !HoldMeshes(*body0, *body1))
        return contact->CreateCollisionAlgorithm(info, body0, body1);
    void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(qcCompoundMeshAlgorithm));
    return new (place) qcCompoundMeshAlgorithm(info, body0, body1, !body0->getCollisionShape()->isCompound());
}

btCollisionAlgorithm* qcCompoundQueryCreate::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                      const btCollisionObjectWrapper* body0,
                                                                      const btCollisionObjectWrapper* body1)
{
    if (!HoldMeshes(*body0, *body1))
        return query->CreateCollisionAlgorithm(info, body0, body1);
    const bool isCompound0 = body0->getCollisionShape()->isCompound();
    if (isCompound0 && body1->getCollisionShape()->isCompound())
        return MakeQuery<btCompoundCompoundCollisionAlgorithm>(info, body0, body1, false);
    return MakeQuery<btCompoundCollisionAlgorithm>(info, body0, body1, !isCompound0);
}
