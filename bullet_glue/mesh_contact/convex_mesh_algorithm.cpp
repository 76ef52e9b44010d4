// The collision algorithm of a convex shape and a qcMeshShape: Bullet's own, without slanted points at inner edges, and
// where a kinematic body goes away with it at the start of the step.
#include "mesh_contact/convex_mesh_algorithm.h"

#include "common/rigid_motion.h"
#include "common/shape_triangles.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>

qcConvexMeshAlgorithm::qcConvexMeshAlgorithm(const btCollisionAlgorithmConstructionInfo& info, qcContactBatch* batch,
                                             btCollisionAlgorithm* contact)
    : btCollisionAlgorithm(info), m_batch(batch), m_contact(contact)
{
}

qcConvexMeshAlgorithm::~qcConvexMeshAlgorithm()
{
    m_contact->~btCollisionAlgorithm();
    m_dispatcher->freeCollisionAlgorithm(m_contact);
}

void qcConvexMeshAlgorithm::FindPoints(const btCollisionObjectWrapper& body0, const btCollisionObjectWrapper& body1,
                                       const btDispatcherInfo& dispatchInfo, qcInnerEdgeFilter::Points points,
                                       btManifoldResult* result)
{
    const bool isFirst = qcAsMeshShape(body0.getCollisionShape()) != nullptr;
    const btCollisionObjectWrapper &mesh = isFirst ? body0 : body1, &convex = isFirst ? body1 : body0;
    qcInnerEdgeFilter filtered(mesh, convex, points, result);
    m_contact->processCollision(&body0, &body1, dispatchInfo, &filtered);
}

/// Moves the points of the step before on a kinematic body: those where it went away have been found at the start of
/// that step, and those where it goes away now count at the start of this one.
void qcConvexMeshAlgorithm::MovePoints(const btCollisionObject* kinematic, btScalar timeStep)
{
    const qcRigidMotion motion(kinematic);
    const btMatrix3x3& basis = kinematic->getWorldTransform().getBasis();
    const btVector3 linear = motion.linear * basis * -timeStep, angular = motion.angular * basis * -timeStep;
    btManifoldArray manifolds;
    m_contact->getAllContactManifolds(manifolds);
    for (int i = 0; i < manifolds.size(); i++)
        for (int k = 0; k < manifolds[i]->getNumContacts(); k++)
        {
            btManifoldPoint& point = manifolds[i]->getContactPoint(k);
            const bool isA = manifolds[i]->getBody0() == kinematic;
            btVector3& local = isA ? point.m_localPointA : point.m_localPointB;
            const btVector3 outward = (isA ? -point.m_normalWorldOnB : point.m_normalWorldOnB) * basis;
            const btVector3 before = m_leadLinear + m_leadAngular.cross(local), now = linear + angular.cross(local);
            if (before.dot(outward) > 0)
                local -= before;
            if (now.dot(outward) > 0)
                local += now;
        }
    m_leadLinear = linear;
    m_leadAngular = angular;
}

void qcConvexMeshAlgorithm::processCollision(const btCollisionObjectWrapper* body0,
                                             const btCollisionObjectWrapper* body1,
                                             const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    m_batch->MarkStarts(body0->getCollisionObject(), body1->getCollisionObject(), &m_mark);
    if (qcAsMeshShape(body0->getCollisionShape()) == nullptr && qcAsMeshShape(body1->getCollisionShape()) == nullptr)
    {
        // The program's own shape of the same kind.
        m_contact->processCollision(body0, body1, dispatchInfo, result);
        return;
    }
    const bool isLed0 = body0->getCollisionObject()->isKinematicObject();
    if (!isLed0 && !body1->getCollisionObject()->isKinematicObject())
    {
        FindPoints(*body0, *body1, dispatchInfo, qcInnerEdgeFilter::Points::all, result);
        return;
    }
    const btCollisionObjectWrapper& led = isLed0 ? *body0 : *body1;
    const btCollisionObject* kinematic = led.getCollisionObject();
    MovePoints(kinematic, dispatchInfo.m_timeStep);
    FindPoints(*body0, *body1, dispatchInfo, qcInnerEdgeFilter::Points::notReceding, result);
    if (m_leadLinear.isZero() && m_leadAngular.isZero())
        return;
    // The wrapper refers to the transform.
    const btTransform start = qcKinematicStart(*kinematic, led.getWorldTransform(), dispatchInfo.m_timeStep);
    const btCollisionObjectWrapper placed(led.m_parent, led.getCollisionShape(), kinematic, start, led.m_partId,
                                          led.m_index);
    FindPoints(isLed0 ? placed : *body0, isLed0 ? *body1 : placed, dispatchInfo, qcInnerEdgeFilter::Points::receding,
               result);
}

btScalar qcConvexMeshAlgorithm::calculateTimeOfImpact(btCollisionObject* body0, btCollisionObject* body1,
                                                      const btDispatcherInfo& dispatchInfo, btManifoldResult* result)
{
    return m_contact->calculateTimeOfImpact(body0, body1, dispatchInfo, result);
}

void qcConvexMeshAlgorithm::getAllContactManifolds(btManifoldArray& manifolds)
{
    m_contact->getAllContactManifolds(manifolds);
}

btCollisionAlgorithm* qcConvexMeshCreate::CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                                   const btCollisionObjectWrapper* body0,
                                                                   const btCollisionObjectWrapper* body1)
{
    btCollisionAlgorithm* made = contact->CreateCollisionAlgorithm(info, body0, body1);
    void* place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(qcConvexMeshAlgorithm));
    return new (place) qcConvexMeshAlgorithm(info, batch, made);
}
