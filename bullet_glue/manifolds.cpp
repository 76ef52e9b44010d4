// Contacts of soft bodies as Bullet manifolds.
//
// They live from the end of one step to the beginning of the next: before the next collision detection they are gone,
// so the rigid-body solver never sees a body that was removed in between.
#include "manifolds.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

namespace
{
btVector3 PointOf(const btSoftBody* body, const uint32_t vertices[3], const double weights[3])
{
    btVector3 point(0, 0, 0);
    for (int i = 0; i < 3; i++)
        point += btScalar(weights[i]) * body->m_nodes[int(vertices[i])].m_x;
    return point;
}
} // namespace

qcManifolds::~qcManifolds()
{
    // The world is gone, and its bodies may be.
    Release(btAlignedObjectArray<btSoftBody*>());
}

void qcManifolds::Release(const btAlignedObjectArray<btSoftBody*>& alive)
{
    auto isAlive = [&](const btCollisionObject* body)
    {
        for (int i = 0; i < alive.size(); i++)
            if (alive[i] == body)
                return true;
        return false;
    };
    for (auto& [dispatcher, manifold] : m_manifolds)
    {
        // Bullet tells gContactEndedCallback of a manifold with points, which would look at its bodies.
        if (!isAlive(manifold->getBody0()) || !isAlive(manifold->getBody1()))
            manifold->setNumContacts(0);
        dispatcher->releaseManifold(manifold);
    }
    m_manifolds.clear();
}

/// The last manifold if it is of these bodies and has room, else a new one.
btPersistentManifold* qcManifolds::Next(btDispatcher* dispatcher, btSoftBody* a, btSoftBody* b)
{
    if (!m_manifolds.empty())
    {
        btPersistentManifold* last = m_manifolds.back().second;
        if (last->getBody0() == a && last->getBody1() == b && last->getNumContacts() < MANIFOLD_CACHE_SIZE)
            return last;
    }
    btPersistentManifold* manifold = dispatcher->getNewManifold(a, b);
    if (manifold != nullptr)
        m_manifolds.emplace_back(dispatcher, manifold);
    return manifold;
}

void qcManifolds::Publish(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& contacts)
{
    for (size_t index : contacts)
    {
        const qcContact& contact = result.contacts[index];
        const qcSceneSoftBody &a = *scene.Find(contact.bodyA), &b = *scene.Find(contact.bodyB);
        btDispatcher* dispatcher = a.body->getWorldInfo()->m_dispatcher;
        btPersistentManifold* manifold = dispatcher != nullptr ? Next(dispatcher, a.body, b.body) : nullptr;
        if (manifold == nullptr)
            continue;
        btVector3 pointA = PointOf(a.body, contact.verticesA, contact.weightsA);
        btVector3 pointB = PointOf(b.body, contact.verticesB, contact.weightsB);
        btVector3 normal(btScalar(contact.normal[0]), btScalar(contact.normal[1]), btScalar(contact.normal[2]));
        btScalar depth = btScalar(contact.distance) - (a.thickness + b.thickness) / 2;
        btManifoldPoint point(a.body->getWorldTransform().invXform(pointA),
                              b.body->getWorldTransform().invXform(pointB), normal, depth);
        point.m_positionWorldOnA = pointA;
        point.m_positionWorldOnB = pointB;
        point.m_combinedFriction = (a.settings.friction + b.settings.friction) / 2;
        manifold->addManifoldPoint(point);
    }
}
