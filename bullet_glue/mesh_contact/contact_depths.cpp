// How deep Bullet's contact has let objects sink into each other.
#include "mesh_contact/contact_depths.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>

#include <algorithm>

namespace
{
// Smaller depths are those of bodies at rest: parts of the contact breaking threshold, and of the smaller object's
// size.
constexpr btScalar s_smallDepth = btScalar(0.1), s_smallPart = btScalar(0.05);

btScalar DeepestOf(const btPersistentManifold& manifold)
{
    btScalar depth = 0;
    for (int i = 0; i < manifold.getNumContacts(); i++)
        depth = std::max(depth, -manifold.getContactPoint(i).getDistance());
    return depth;
}

/// The size of the smaller object (getAngularMotionDisc): Bullet makes its manifolds' thresholds of it.
btScalar SmallerSizeOf(const btPersistentManifold& manifold)
{
    return manifold.getContactBreakingThreshold() / gContactBreakingThreshold;
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
        const btScalar small =
            std::min(s_smallDepth * gContactBreakingThreshold, s_smallPart * SmallerSizeOf(manifold));
        if (depth <= small || !dispatcher->needsResponse(a, b))
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
