// From contact points to Bullet's manifolds.
//
// Points are found anew in each step, so nothing old is kept but impulses: a point of the manifold that has no
// successor is removed, the others are replaced by addContactPoint, which hands the impulses of the nearest one on.
#include "mesh_contact/collision_algorithm.h"

#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>

namespace
{
// Of a distance, so that Bullet, which computes it anew from two rounded ends, accepts it.
constexpr btScalar s_accepted = btScalar(1.001);

/// The manifold's point that would hand its impulses on to this one, or -1.
int Predecessor(const btPersistentManifold& manifold, const qcMeshPoint& point, const btTransform& bodyA)
{
    btManifoldPoint probe;
    probe.m_localPointA = bodyA.invXform(point.onB + point.normal * point.distance);
    return manifold.getCacheEntry(probe);
}

/// How many points of a group have one.
int CountSuccessors(const btPersistentManifold& manifold, const qcPointGroup& group, const btTransform& bodyA)
{
    int count = 0;
    for (int i = 0; i < group.count; i++)
        count += Predecessor(manifold, *group.points[i], bodyA) >= 0;
    return count;
}

void RemoveWithoutSuccessor(btPersistentManifold* manifold, const qcPointGroup& group, const btTransform& bodyA)
{
    bool kept[MANIFOLD_CACHE_SIZE] = {};
    for (int i = 0; i < group.count; i++)
    {
        int entry = Predecessor(*manifold, *group.points[i], bodyA);
        if (entry >= 0)
            kept[entry] = true;
    }
    for (int i = manifold->getNumContacts() - 1; i >= 0; i--)
        if (!kept[i])
            manifold->removeContactPoint(i);
}

/// As getNewManifold finds it.
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
    // The result may have its bodies the other way around, and wants to know the triangles of its own.
    bool swapped = result->getBody0Internal() != body0.getCollisionObject();
    const qcTriangleSource &first = swapped ? point.sourceB : point.sourceA,
                           &second = swapped ? point.sourceA : point.sourceB;
    result->setShapeIdentifiersA(first.part, first.index);
    result->setShapeIdentifiersB(second.part, second.index);
    result->addContactPoint(point.normal, point.onB, point.distance);
}

/// Drops points further apart than `reach` unless the motion of this step brings them within: then the solver has to
/// know of them now, or they are met deep inside. (Bullet's contacts ahead of time, with what a step needs of them.)
void DropFar(const btCollisionObject* object0, const btCollisionObject* object1, btScalar reach, btScalar timeStep,
             std::vector<qcMeshPoint>* points)
{
    qcMeshMotion motion0(object0), motion1(object1);
    for (qcMeshPoint& point : *points)
    {
        btVector3 closing = motion1.At(point.onB) - motion0.At(point.onA);
        btScalar ahead = point.distance - closing.dot(point.normal) * timeStep;
        // Known to come nearer, where it is known who will be stopped.
        point.ahead = timeStep > 0 ? std::min(point.ahead, ahead) : point.distance;
    }
    auto isFar = [&](const qcMeshPoint& point) { return std::min(point.distance, point.ahead) > reach; };
    points->erase(std::remove_if(points->begin(), points->end(), isFar), points->end());
}

/// How far a point of a mesh comes against a direction in a step at most.
btScalar TravelOf(const btCollisionObjectWrapper& mesh, const btVector3& normal, btScalar timeStep)
{
    const btRigidBody* body = btRigidBody::upcast(mesh.getCollisionObject());
    if (body == nullptr || body->isStaticObject())
        return 0;
    btScalar speed = body->getAngularVelocity().length() * body->getCollisionShape()->getAngularMotionDisc() -
                     body->getLinearVelocity().dot(normal);
    return std::max(speed * timeStep, btScalar(0));
}

qcPlacedMesh PlacedMesh(const btCollisionObjectWrapper& body)
{
    return {body.getCollisionObject(), body.getCollisionShape(), body.getWorldTransform()};
}
} // namespace

qcPointsAlgorithm::qcPointsAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcMeshBatch* batch, bool query)
    : btCollisionAlgorithm(info), m_batch(batch), m_query(query), m_shared(info.m_manifold != nullptr)
{
    m_manifolds[0] = info.m_manifold;
}

qcPointsAlgorithm::~qcPointsAlgorithm()
{
    for (int i = 0; i < s_groups && !m_shared; i++)
        if (m_manifolds[i] != nullptr)
            m_dispatcher->releaseManifold(m_manifolds[i]);
}

btPersistentManifold* qcPointsAlgorithm::Manifold(int i, const btCollisionObjectWrapper& body0,
                                                  const btCollisionObjectWrapper& body1)
{
    if (m_manifolds[i] == nullptr)
        m_manifolds[i] = m_dispatcher->getNewManifold(body0.getCollisionObject(), body1.getCollisionObject());
    return m_manifolds[i];
}

/// The manifold for a group: one that has points near those of the group, or else an empty one.
int qcPointsAlgorithm::Successor(const qcPointGroup& group, const btTransform& bodyA, const bool used[s_groups]) const
{
    int best = -1, most = -1;
    for (int i = 0; i < s_groups; i++)
    {
        int count = used[i] ? -1 : m_manifolds[i] != nullptr ? CountSuccessors(*m_manifolds[i], group, bodyA) : 0;
        if (count > most)
        {
            most = count;
            best = i;
        }
    }
    return best;
}

/// Empties the manifolds that no group has, and gives back those that were empty before: one that was made in this
/// dispatch has points, so none is made and released in the same one.
void qcPointsAlgorithm::Clear(const bool used[s_groups])
{
    for (int i = 0; i < s_groups; i++)
    {
        btPersistentManifold* manifold = m_manifolds[i];
        if (used[i] || manifold == nullptr)
            continue;
        if (manifold->getNumContacts() == 0 && !m_shared)
        {
            m_dispatcher->releaseManifold(manifold);
            m_manifolds[i] = nullptr;
        }
        for (int k = manifold->getNumContacts() - 1; m_manifolds[i] != nullptr && k >= 0; k--)
            manifold->removeContactPoint(k);
    }
}

void qcPointsAlgorithm::ReportAll(const std::vector<qcMeshPoint>& points, btScalar reach,
                                  const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                  btManifoldResult* result)
{
    btPersistentManifold* manifold = points.empty() ? nullptr : Manifold(0, body0, body1);
    if (manifold == nullptr)
        return;
    result->setPersistentManifold(manifold);
    for (const qcMeshPoint& point : points)
        if (point.distance <= reach)
            Report(point, body0, result);
}

void qcPointsAlgorithm::processCollision(const btCollisionObjectWrapper* body0, const btCollisionObjectWrapper* body1,
                                         const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    std::vector<qcMeshPoint> points;
    btScalar marginA = MarginOf(body0->getCollisionShape()), marginB = MarginOf(body1->getCollisionShape());
    btScalar reach = m_batch->Reach(body0->getCollisionShape(), body1->getCollisionShape()) +
                     result->m_closestPointDistanceThreshold;
    FindPoints(*body0, *body1, reach, dispatchInfo.m_timeStep, &points);
    for (qcMeshPoint& point : points)
    {
        point.onA -= point.normal * marginA;
        point.onB += point.normal * marginB;
        point.distance -= marginA + marginB;
    }
    if (m_query)
    {
        ReportAll(points, reach, *body0, *body1, result);
        return;
    }
    BT_PROFILE("qcMeshContact manifolds");
    btScalar threshold = BreakingThreshold(m_dispatcher, *body0, *body1);
    reach = std::min(reach, threshold);
    // The threshold of a manifold of others is not ours to raise.
    DropFar(body0->getCollisionObject(), body1->getCollisionObject(), reach, m_shared ? 0 : dispatchInfo.m_timeStep,
            &points);
    const btTransform& bodyA = body0->getCollisionObject()->getWorldTransform();
    for (qcMeshPoint& point : points)
        for (int i = 0; i < s_groups && !point.kept; i++)
            point.kept = m_manifolds[i] != nullptr && Predecessor(*m_manifolds[i], point, bodyA) >= 0;
    qcPointGroup groups[s_groups];
    int groupCount = qcGroupPoints(&points, reach, threshold, m_shared ? 1 : s_groups, groups);
    bool used[s_groups] = {};
    for (int g = 0; g < groupCount; g++)
    {
        int i = Successor(groups[g], bodyA, used);
        used[i] = true;
        btPersistentManifold* manifold = Manifold(i, *body0, *body1);
        if (manifold == nullptr)
            continue;
        manifold->setContactBreakingThreshold(threshold);
        RemoveWithoutSuccessor(manifold, groups[g], bodyA);
        result->setPersistentManifold(manifold);
        for (int k = 0; k < groups[g].count; k++)
        {
            const qcMeshPoint& point = *groups[g].points[k];
            manifold->setContactBreakingThreshold(std::max(threshold, point.distance * s_accepted));
            Report(point, *body0, result);
        }
        result->refreshContactPoints();
    }
    Clear(used);
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
                                     btScalar reach, btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    qcPlacedMesh a = PlacedMesh(body0), b = PlacedMesh(body1);
    // An object may have been given another shape meanwhile, which Bullet's pairs don't notice.
    if (!qcIsMesh(a.shape) || !qcIsMesh(b.shape))
        return;
    if (m_query)
        m_batch->Query(a, b, reach + MarginOf(a.shape) + MarginOf(b.shape), points);
    else
        m_batch->Find(a, b, timeStep, &m_check, points);
}

btScalar qcMeshMeshAlgorithm::MarginOf(const btCollisionShape* shape) const
{
    return shape->getMargin();
}

void qcMeshPlaneAlgorithm::FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                      btScalar reach, btScalar timeStep, std::vector<qcMeshPoint>* points)
{
    bool swapped = body0.getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE;
    const btCollisionObjectWrapper &meshBody = swapped ? body1 : body0, &planeBody = swapped ? body0 : body1;
    const qcMeshShape* mesh = qcAsMeshShape(meshBody.getCollisionShape());
    if (mesh == nullptr || planeBody.getCollisionShape()->getShapeType() != STATIC_PLANE_PROXYTYPE)
        return;
    const auto* plane = static_cast<const btStaticPlaneShape*>(planeBody.getCollisionShape());

    struct Collector : btTriangleCallback
    {
        btTransform transform;
        btVector3 normal;
        btScalar offset, limit;
        bool swapped;
        std::vector<qcMeshPoint>* points;

        void processTriangle(btVector3* triangle, int part, int index) override
        {
            for (int c = 0; c < 3; c++)
            {
                btVector3 corner = transform * triangle[c];
                btScalar distance = normal.dot(corner) - offset;
                if (distance > limit)
                    continue;
                btVector3 foot = corner - normal * distance;
                if (swapped)
                    points->push_back({foot, corner, -normal, distance, {-1, -1}, {part, index}});
                else
                    points->push_back({corner, foot, normal, distance, {part, index}, {-1, -1}});
            }
        }
    } collector;
    collector.transform = meshBody.getWorldTransform();
    collector.normal = planeBody.getWorldTransform().getBasis() * plane->getPlaneNormal();
    collector.offset = plane->getPlaneConstant() + collector.normal.dot(planeBody.getWorldTransform().getOrigin());
    collector.limit = reach + mesh->getMargin() + TravelOf(meshBody, collector.normal, timeStep);
    collector.swapped = swapped;
    collector.points = points;
    btVector3 localNormal = collector.transform.getBasis().transpose() * collector.normal;
    btScalar localOffset = collector.offset - collector.normal.dot(collector.transform.getOrigin());
    mesh->processTrianglesBelow(&collector, localNormal, localOffset + collector.limit);
}

btScalar qcMeshPlaneAlgorithm::MarginOf(const btCollisionShape* shape) const
{
    // Bullet's planes have no shell for convex shapes either.
    return shape->getShapeType() == STATIC_PLANE_PROXYTYPE ? btScalar(0) : shape->getMargin();
}
