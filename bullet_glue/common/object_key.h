// What several parts of the glue ask of Bullet's objects and vectors.
#ifndef QC_GLUE_COMMON_OBJECT_KEY_H
#define QC_GLUE_COMMON_OBJECT_KEY_H

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

/// Numbered anew whenever an object is added to a world: the same address may be another object later. -1 for one that
/// is in no world.
inline int qcAdditionOf(const btCollisionObject* object)
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
