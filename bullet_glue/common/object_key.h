// Identity of Bullet's objects, equality of its vectors.
#ifndef QC_GLUE_COMMON_OBJECT_KEY_H
#define QC_GLUE_COMMON_OBJECT_KEY_H

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

/// The id of the object's proxy: a new one each time it is added to a world, so that a new object at an old address has
/// another id. -1 for an object in no world.
inline int qcUniqueIdOf(const btCollisionObject* object)
{
    const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
    return proxy != nullptr ? proxy->m_uniqueId : -1;
}

/// The fourth component means nothing, but Bullet's own operator compares it.
inline bool qcAreSame(const btVector3& a, const btVector3& b)
{
    return a.x() == b.x() && a.y() == b.y() && a.z() == b.z();
}

inline bool qcAreSame(const btTransform& a, const btTransform& b)
{
    const btMatrix3x3 &p = a.getBasis(), &q = b.getBasis();
    return qcAreSame(a.getOrigin(), b.getOrigin()) && qcAreSame(p[0], q[0]) && qcAreSame(p[1], q[1]) &&
           qcAreSame(p[2], q[2]);
}

#endif
