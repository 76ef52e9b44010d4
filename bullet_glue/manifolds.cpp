// Contacts of soft bodies as Bullet manifolds.
//
// They live from the end of one step to the beginning of the next: before the next collision detection they are gone,
// so the rigid-body solver never sees a body that was removed in between.
#include "manifolds.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

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
btPersistentManifold* qcManifolds::Next(btDispatcher* dispatcher, const btCollisionObject* a,
                                        const btCollisionObject* b)
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
        qcSoftTouch touch;
        qcReadTouch(scene, result.contacts[index], &touch);
        btSoftBody* a = touch.a->body;
        const btCollisionObject* b = touch.b != nullptr ? touch.b->body : touch.rigid->object;
        btDispatcher* dispatcher = a->getWorldInfo()->m_dispatcher;
        btPersistentManifold* manifold = dispatcher != nullptr ? Next(dispatcher, a, b) : nullptr;
        if (manifold == nullptr)
            continue;
        btManifoldPoint point(a->getWorldTransform().invXform(touch.onA), b->getWorldTransform().invXform(touch.onB),
                              touch.normal, touch.distance - touch.thickness);
        point.m_positionWorldOnA = touch.onA;
        point.m_positionWorldOnB = touch.onB;
        point.m_combinedFriction = touch.friction;
        manifold->addManifoldPoint(point);
    }
}
