// Static planes under small meshes.
#include "mesh_contact/limits/swept_floor.h"

#include "common/finite.h"
#include "common/object_motion.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletCollision/BroadphaseCollision/btOverlappingPairCache.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>

#include <algorithm>

btScalar qcSweptFloor::HeightOf(const qcSupportMesh& mesh, const btTransform& place) const
{
    const qcPlacedSupport placed{&mesh, place};
    return normal.dot(place.getOrigin()) - mesh.Max(placed.ToLocal(-normal)) - level;
}

void qcStaticPlanes::Read(const btCollisionWorld& world)
{
    m_planes.clear();
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        if (objects[i]->getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE && qcIsStatic(objects[i]) &&
            qcIsFinite(*objects[i]))
            m_planes.push_back(objects[i]);
}

void qcStaticPlanes::FindFloors(btCollisionWorld* world, btCollisionObject* body, const qcSupportMesh& mesh,
                                const btTransform& target, std::vector<qcSweptFloor>* floors) const
{
    for (btCollisionObject* object : m_planes)
    {
        const auto* plane = static_cast<const btStaticPlaneShape*>(object->getCollisionShape());
        const btTransform& place = object->getWorldTransform();
        qcSweptFloor floor{place.getBasis() * plane->getPlaneNormal(), plane->getPlaneConstant()};
        floor.level += floor.normal.dot(place.getOrigin());
        if (floor.normal.dot(target.getOrigin()) - floor.level > 2 * mesh.Radius())
            continue;
        const btBroadphasePair* pair =
            world->getPairCache()->findPair(body->getBroadphaseHandle(), object->getBroadphaseHandle());
        if (pair == nullptr || pair->m_algorithm == nullptr || !world->getDispatcher()->needsResponse(body, object))
            continue;
        floor.level += std::min(floor.HeightOf(mesh, target), btScalar(0));
        floors->push_back(floor);
    }
}
