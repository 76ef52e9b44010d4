// How deep Bullet's contact has let objects sink into each other.
#include "mesh_contact/contact_depths.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <algorithm>

namespace
{
// Smaller depths are those of bodies at rest: parts of the contact breaking threshold.
constexpr btScalar s_smallDepth = btScalar(0.1);

btScalar DeepestOf(const btPersistentManifold& manifold)
{
    btScalar depth = 0;
    for (int i = 0; i < manifold.getNumContacts(); i++)
        depth = std::max(depth, -manifold.getContactPoint(i).getDistance());
    return depth;
}
} // namespace

void qcContactDepths::Add(const btCollisionObject* object, btScalar depth)
{
    btScalar& deepest = m_depths[object];
    deepest = std::max(deepest, depth);
}

void qcContactDepths::Read(btDispatcher* dispatcher)
{
    m_depths.clear();
    for (int i = 0; i < dispatcher->getNumManifolds(); i++)
    {
        const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(i);
        const btCollisionObject *a = manifold.getBody0(), *b = manifold.getBody1();
        const btScalar depth = a->isActive() || b->isActive() ? DeepestOf(manifold) : 0;
        if (depth <= s_smallDepth * gContactBreakingThreshold || !dispatcher->needsResponse(a, b))
            continue;
        Add(a, depth);
        Add(b, depth);
    }
}

btScalar qcContactDepths::DepthOf(const btCollisionObject* object) const
{
    auto found = m_depths.find(object);
    return found != m_depths.end() ? found->second : 0;
}
