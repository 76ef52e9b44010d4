// From contact points to Bullet's manifolds.
//
// Points are found anew in each step; only impulses are kept. A point of a manifold without a successor is removed. The
// others are replaced by addContactPoint, which passes on the impulses of the nearest point.
#include "mesh_contact/collision_algorithm.h"

#include "common/object_motion.h"
#include "mesh_contact/points/turned_points.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Factor of a distance to accept: Bullet computes it again, from two rounded ends.
constexpr btScalar s_acceptedFactor = btScalar(1.001);
// Radians a second. What rests turns by less, what rolls by more.
constexpr btScalar s_restingTurn = btScalar(0.2);

/// The manifold's point whose impulses addContactPoint would pass on to this one; -1: none.
int FindPredecessor(const btPersistentManifold& manifold, const qcMeshPoint& point, const btTransform& bodyA)
{
    btManifoldPoint probe;
    probe.m_localPointA = bodyA.invXform(point.onB + point.normal * point.distance);
    return manifold.getCacheEntry(probe);
}

/// The number of points in the group with a predecessor.
int CountSuccessors(const btPersistentManifold& manifold, const qcPointGroup& group, const btTransform& bodyA)
{
    int count = 0;
    for (int i = 0; i < group.count; i++)
        count += FindPredecessor(manifold, *group.points[i], bodyA) >= 0;
    return count;
}

void RemoveWithoutSuccessor(btPersistentManifold* manifold, const qcPointGroup& group, const btTransform& bodyA)
{
    bool kept[MANIFOLD_CACHE_SIZE] = {};
    for (int i = 0; i < group.count; i++)
    {
        int entry = FindPredecessor(*manifold, *group.points[i], bodyA);
        if (entry >= 0)
            kept[entry] = true;
    }
    for (int i = manifold->getNumContacts() - 1; i >= 0; i--)
        if (!kept[i])
            manifold->removeContactPoint(i);
}

/// The threshold of a new manifold, by the rule of btCollisionDispatcher::getNewManifold.
btScalar BreakingThreshold(const btDispatcher* dispatcher, const btCollisionObjectWrapper& body0,
                           const btCollisionObjectWrapper& body1)
{
    int flags = static_cast<const btCollisionDispatcher*>(dispatcher)->getDispatcherFlags();
    if ((flags & btCollisionDispatcher::CD_USE_RELATIVE_CONTACT_BREAKING_THRESHOLD) == 0)
        return gContactBreakingThreshold;
    const btCollisionShape* shape0 = body0.getCollisionObject()->getCollisionShape();
    const btCollisionShape* shape1 = body1.getCollisionObject()->getCollisionShape();
    return std::min(shape0->getContactBreakingThreshold(gContactBreakingThreshold),
                    shape1->getContactBreakingThreshold(gContactBreakingThreshold));
}

void Report(const qcMeshPoint& point, const btCollisionObjectWrapper& body0, btManifoldResult* result)
{
    // The result may have the bodies in the other order.
    bool swapped = result->getBody0Internal() != body0.getCollisionObject();
    const qcTriangleSource &first = swapped ? point.sourceB : point.sourceA,
                           &second = swapped ? point.sourceA : point.sourceB;
    result->setShapeIdentifiersA(first.part, first.index);
    result->setShapeIdentifiersB(second.part, second.index);
    result->addContactPoint(point.normal, point.onB, point.distance);
}

/// Moves the ends of points from the triangles to the surfaces of the margins.
void ApplyMargins(btScalar marginA, btScalar marginB, std::vector<qcMeshPoint>* points)
{
    for (qcMeshPoint& point : *points)
    {
        point.onA -= point.normal * marginA;
        point.onB += point.normal * marginB;
        point.distance -= marginA + marginB;
    }
}

/// Returns points on receding kinematic bodies to where they are at the start of the step.
void ReturnReceding(const btCollisionObject* object0, const btCollisionObject* object1, btScalar timeStep,
                    std::vector<qcMeshPoint>* points)
{
    const btScalar limit = qcMaxLead * gContactBreakingThreshold;
    for (qcMeshPoint& point : *points)
    {
        const btScalar travel0 = qcRecession(object0, point.onA, point.normal, timeStep, limit);
        const btScalar travel1 = qcRecession(object1, point.onB, -point.normal, timeStep, limit);
        point.onA -= point.normal * travel0;
        point.onB += point.normal * travel1;
        point.distance -= travel0 + travel1;
    }
}

/// Removes points that are further apart than the contact distance and stay so in the step. The others become
/// speculative contacts: without them the bodies would touch only after they have penetrated. A time step of 0 keeps no
/// speculative contacts.
void RemoveDistant(const btCollisionObject* object0, const btCollisionObject* object1, btScalar contactDistance,
                   btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    qcRigidMotion motion0(object0), motion1(object1);
    for (qcMeshPoint& point : *points)
    {
        btVector3 closing = motion1.VelocityAt(point.onB) - motion0.VelocityAt(point.onA);
        btScalar endDistance = point.distance - closing.dot(point.normal) * timeStep;
        // Impact sampling may have found a smaller distance, for bodies that stop within the step.
        point.endDistance = timeStep > 0 ? std::min(point.endDistance, endDistance) : point.distance;
    }
    auto isDistant = [&](const qcMeshPoint& point)
    { return std::min(point.distance, point.endDistance) > contactDistance; };
    points->erase(std::remove_if(points->begin(), points->end(), isDistant), points->end());
}

/// Replaces the points of a manifold by those of a group.
void WriteGroup(const qcPointGroup& group, btScalar threshold, const btCollisionObjectWrapper& body0,
                btPersistentManifold* manifold, btManifoldResult* result)
{
    manifold->setContactBreakingThreshold(threshold);
    RemoveWithoutSuccessor(manifold, group, body0.getCollisionObject()->getWorldTransform());
    result->setPersistentManifold(manifold);
    for (int i = 0; i < group.count; i++)
    {
        const qcMeshPoint& point = *group.points[i];
        manifold->setContactBreakingThreshold(std::max(threshold, point.distance * s_acceptedFactor));
        Report(point, body0, result);
    }
    // Three corners resist rolling themselves, and half of the solver's rows would be for it. From the next step on
    // each point has it, since some may carry no load (qc-bench fracture: 13 to 9 ms of the solver in the break).
    if (group.points[0]->isFaceCorner && !group.points[0]->isKnown)
        for (int i = 0; i < manifold->getNumContacts(); i++)
            manifold->getContactPoint(i).m_combinedRollingFriction = 0;
    result->refreshContactPoints();
}

/// Motion of a mesh against a direction in a step.
struct TravelAgainst
{
    btScalar max = 0;      ///< upper bound of that of its points, along straight lines
    btScalar ofCentre = 0; ///< that of its centre
};

TravelAgainst FindTravelAgainst(const btCollisionObject& object, const btVector3& normal, btScalar timeStep)
{
    const btRigidBody* body = btRigidBody::upcast(&object);
    if (body == nullptr || qcIsStatic(body))
        return {};
    const btScalar centre = -body->getLinearVelocity().dot(normal) * timeStep;
    const btScalar turn =
        body->getAngularVelocity().length() * body->getCollisionShape()->getAngularMotionDisc() * timeStep;
    return {std::max(centre + turn, btScalar(0)), std::max(centre, btScalar(0))};
}

/// Makes contact points of a plane with the vertices of a mesh.
class PlanePoints : public btTriangleCallback
{
  public:
    /// `swapped`: the plane is the first body.
    PlanePoints(const qcMeshShape& mesh, const btTransform& meshPlace, const btTransform& planePlace,
                const btStaticPlaneShape& plane, bool swapped, std::vector<qcMeshPoint>* points)
        : m_mesh(mesh), m_place(meshPlace), m_normal(planePlace.getBasis() * plane.getPlaneNormal()),
          m_offset(plane.getPlaneConstant() + m_normal.dot(planePlace.getOrigin())), m_swapped(swapped),
          m_points(points)
    {
    }

    /// Collects vertices at most `nearDistance` above the plane, and those that may get there in the step, each once,
    /// with the first of its triangles.
    void Collect(btScalar nearDistance, const btCollisionObject& object, btScalar timeStep)
    {
        const TravelAgainst travel = FindTravelAgainst(object, m_normal, timeStep);
        m_nearDistance = nearDistance;
        m_centre = object.getWorldTransform().getOrigin();
        // Twice the distance: the solver may add to the motion.
        m_maxRadius = m_normal.dot(m_centre) - m_offset - travel.ofCentre - 2 * nearDistance;
        const btScalar maxDistance = m_maxDistance = nearDistance + travel.max;
        m_isTaken.assign(m_mesh.getVertexCount(), false);
        btVector3 localNormal = m_place.getBasis().transpose() * m_normal;
        btScalar localOffset = m_offset - m_normal.dot(m_place.getOrigin());
        m_mesh.processTrianglesBelow(this, localNormal, localOffset + maxDistance);
    }

    void processTriangle(btVector3* triangle, int part, int index) override
    {
        for (int c = 0; c < 3; c++)
        {
            uint32_t vertex = m_mesh.getIndices()[3 * size_t(index) + size_t(c)];
            if (m_isTaken[vertex])
                continue;
            m_isTaken[vertex] = true;
            btVector3 corner = m_place * triangle[c];
            btScalar distance = m_normal.dot(corner) - m_offset;
            if (distance > m_maxDistance || (distance > m_nearDistance && corner.distance(m_centre) < m_maxRadius))
                continue;
            btVector3 foot = corner - m_normal * distance;
            if (m_swapped)
                m_points->push_back({foot, corner, -m_normal, distance, {-1, -1}, {part, index}});
            else
                m_points->push_back({corner, foot, m_normal, distance, {part, index}, {-1, -1}});
        }
    }

  private:
    const qcMeshShape& m_mesh;
    btTransform m_place;
    btVector3 m_normal;
    btScalar m_offset, m_nearDistance = 0, m_maxDistance = 0;
    btVector3 m_centre{0, 0, 0}; ///< of the object
    btScalar m_maxRadius = 0;    ///< vertices that are nearer to the centre don't get to the plane, however it turns
    bool m_swapped;
    std::vector<bool> m_isTaken; ///< by vertex
    std::vector<qcMeshPoint>* m_points;
};

qcPlacedMesh PlacedMesh(const btCollisionObjectWrapper& body)
{
    return {body.getCollisionObject(), body.getCollisionShape(), body.getWorldTransform()};
}
} // namespace

qcPointsAlgorithm::qcPointsAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch,
                                     bool query)
    : btCollisionAlgorithm(info), m_batch(batch), m_query(query), m_isShared(info.m_manifold != nullptr)
{
    m_manifolds[0] = info.m_manifold;
}

qcPointsAlgorithm::~qcPointsAlgorithm()
{
    for (int i = 0; i < s_maxGroups && !m_isShared; i++)
        if (m_manifolds[i] != nullptr)
            m_dispatcher->releaseManifold(m_manifolds[i]);
}

btPersistentManifold* qcPointsAlgorithm::GetManifold(int i, const btCollisionObjectWrapper& body0,
                                                     const btCollisionObjectWrapper& body1)
{
    if (m_manifolds[i] == nullptr)
        m_manifolds[i] = m_dispatcher->getNewManifold(body0.getCollisionObject(), body1.getCollisionObject());
    return m_manifolds[i];
}

/// The unused manifold with the most points near those of the group; an empty one if there is none.
int qcPointsAlgorithm::ChooseManifold(const qcPointGroup& group, const btTransform& bodyA,
                                      const bool used[s_maxGroups]) const
{
    int best = -1, maxCount = -1;
    for (int i = 0; i < s_maxGroups; i++)
    {
        int count = used[i] ? -1 : m_manifolds[i] != nullptr ? CountSuccessors(*m_manifolds[i], group, bodyA) : 0;
        if (count > maxCount)
        {
            maxCount = count;
            best = i;
        }
    }
    return best;
}

/// Empties the unused manifolds, and releases those that were empty: a manifold made in this dispatch has points, so
/// none is made and released in the same dispatch.
void qcPointsAlgorithm::ClearUnused(const bool used[s_maxGroups])
{
    for (int i = 0; i < s_maxGroups; i++)
    {
        btPersistentManifold* manifold = m_manifolds[i];
        if (used[i] || manifold == nullptr)
            continue;
        if (manifold->getNumContacts() == 0 && !m_isShared)
        {
            m_dispatcher->releaseManifold(manifold);
            m_manifolds[i] = nullptr;
            continue;
        }
        for (int k = manifold->getNumContacts() - 1; k >= 0; k--)
            manifold->removeContactPoint(k);
    }
}

void qcPointsAlgorithm::MarkKnown(const btTransform& bodyA, std::vector<qcMeshPoint>* points) const
{
    for (qcMeshPoint& point : *points)
        for (int i = 0; i < s_maxGroups && !point.isKnown; i++)
            point.isKnown = m_manifolds[i] != nullptr && FindPredecessor(*m_manifolds[i], point, bodyA) >= 0;
}

void qcPointsAlgorithm::ReportAll(const std::vector<qcMeshPoint>& points, btScalar contactDistance,
                                  const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                  btManifoldResult* result)
{
    btPersistentManifold* manifold = points.empty() ? nullptr : GetManifold(0, body0, body1);
    if (manifold == nullptr)
        return;
    result->setPersistentManifold(manifold);
    for (const qcMeshPoint& point : points)
        if (point.distance <= contactDistance)
            Report(point, body0, result);
}

/// Reduces the points, and replaces those of the manifolds by them.
void qcPointsAlgorithm::UpdateManifolds(std::vector<qcMeshPoint>* points, btScalar contactDistance,
                                        const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                        btManifoldResult* result)
{
    btScalar threshold = BreakingThreshold(m_dispatcher, body0, body1);
    const btTransform& bodyA = body0.getCollisionObject()->getWorldTransform();
    MarkKnown(bodyA, points);
    const btVector3 turn =
        qcRigidMotion(body0.getCollisionObject()).angular - qcRigidMotion(body1.getCollisionObject()).angular;
    const qcReductionDef def{contactDistance, threshold, m_isShared ? 1 : s_maxGroups, KeepsReached(),
                             turn.length2() > s_restingTurn * s_restingTurn};
    qcPointGroup groups[s_maxGroups];
    int groupCount = qcGroupPoints(*points, def, groups);
    bool used[s_maxGroups] = {};
    for (int g = 0; g < groupCount; g++)
    {
        int i = ChooseManifold(groups[g], bodyA, used);
        used[i] = true;
        if (btPersistentManifold* manifold = GetManifold(i, body0, body1))
            WriteGroup(groups[g], threshold, body0, manifold, result);
    }
    ClearUnused(used);
}

void qcPointsAlgorithm::processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                                         const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    std::vector<qcMeshPoint> points;
    const btCollisionShape *shape0 = body0->getCollisionShape(), *shape1 = body1->getCollisionShape();
    btScalar farther = result->m_closestPointDistanceThreshold;
    FindPoints(*body0, *body1, farther, dispatchInfo.m_timeStep, &points);
    const btCollisionObject *object0 = body0->getCollisionObject(), *object1 = body1->getCollisionObject();
    // Without a step no solver follows, which would push.
    const bool overlaps =
        m_overlap.IsOpen() && !m_query && dispatchInfo.m_timeStep > 0 && m_dispatcher->needsResponse(object0, object1);
    // Most pairs of boxes are no contact.
    if (points.empty() && (m_query || std::count(m_manifolds, m_manifolds + s_maxGroups, nullptr) == s_maxGroups))
    {
        if (overlaps)
            m_overlap.Apply(object0, object1, 0, dispatchInfo.m_timeStep, &points);
        return;
    }
    btScalar contactDistance = qcContactDistance(shape0, shape1) + farther;
    btScalar margin0 = MarginOf(shape0), margin1 = MarginOf(shape1);
    ApplyMargins(margin0, margin1, &points);
    if (overlaps)
        m_overlap.Apply(object0, object1, margin0 + margin1, dispatchInfo.m_timeStep, &points);
    if (m_query)
    {
        ReportAll(points, contactDistance, *body0, *body1, result);
        return;
    }
    BT_PROFILE("qcMeshContact manifolds");
    contactDistance = std::min(contactDistance, BreakingThreshold(m_dispatcher, *body0, *body1));
    // A parent's algorithm leaves out children whose boxes are that far apart.
    if (!m_isShared)
    {
        ReturnReceding(object0, object1, dispatchInfo.m_timeStep, &points);
        qcTurnPoints(*body0, margin0, *body1, margin1, dispatchInfo.m_timeStep, &points);
    }
    // The threshold of a parent's manifold can't be raised to that of speculative contacts.
    RemoveDistant(object0, object1, contactDistance, m_isShared ? 0 : dispatchInfo.m_timeStep, &points);
    UpdateManifolds(&points, contactDistance, *body0, *body1, result);
    if (m_isShared || !(dispatchInfo.m_timeStep > 0) || !m_dispatcher->needsResponse(object0, object1))
        return;
    for (btPersistentManifold* manifold : m_manifolds)
        if (manifold != nullptr)
            m_batch->bounces.Mark(manifold);
}

btScalar qcPointsAlgorithm::calculateTimeOfImpact(btCollisionObject*, btCollisionObject*, const btDispatcherInfo&,
                                                  btManifoldResult*)
{
    return 1;
}

void qcPointsAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
    for (btPersistentManifold* manifold : m_manifolds)
        if (manifold != nullptr)
            manifolds.push_back(manifold);
}

void qcMeshMeshAlgorithm::FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                     btScalar farther, btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    qcPlacedMesh a = PlacedMesh(body0), b = PlacedMesh(body1);
    // An object may have another shape than at the creation of the algorithm, without notice from Bullet's pair.
    if (!qcIsMesh(a.shape) || !qcIsMesh(b.shape))
        return;
    if (m_query)
        m_batch->QueryPair(a, b, qcContactDistance(a.shape, b.shape) + farther + MarginOf(a.shape) + MarginOf(b.shape),
                           points);
    else
        m_batch->FindPoints(a, b, timeStep, &m_check, points);
}

btScalar qcMeshMeshAlgorithm::MarginOf(const btCollisionShape* shape) const
{
    return shape->getMargin();
}

void qcMeshPlaneAlgorithm::FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                      btScalar farther, btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    if (!m_query)
        m_batch->MarkStarts(body0.getCollisionObject(), body1.getCollisionObject(), &m_mark);
    bool swapped = body0.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
    const btCollisionObjectWrapper &meshBody = swapped ? body1 : body0, &planeBody = swapped ? body0 : body1;
    const qcMeshShape* mesh = qcAsMeshShape(meshBody.getCollisionShape());
    if (mesh == nullptr || planeBody.getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE)
        return;
    const auto* plane = static_cast<const btStaticPlaneShape*>(planeBody.getCollisionShape());
    PlanePoints collector(*mesh, meshBody.getWorldTransform(), planeBody.getWorldTransform(), *plane, swapped, points);
    collector.Collect(qcContactDistance(mesh, plane) + farther + mesh->getMargin(), *meshBody.getCollisionObject(),
                      timeStep);
}

btScalar qcMeshPlaneAlgorithm::MarginOf(const btCollisionShape* shape) const
{
    // Bullet's planes have no margin for convex shapes either.
    return shape->getShapeType() == STATIC_PLANE_PROXYTYPE ? btScalar(0) : shape->getMargin();
}
