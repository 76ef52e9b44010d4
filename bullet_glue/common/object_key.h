// Identity of Bullet's objects, equality of its vectors.
#ifndef QC_GLUE_COMMON_OBJECT_KEY_H
#define QC_GLUE_COMMON_OBJECT_KEY_H

#include "common/hash_table.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseProxy.h>
#include <BulletCollision/CollisionDispatch/btCollisionObject.h>

/// The id of the object's proxy: a new one each time it is added to a world, so that a new object at an old address has
/// another id. Some of Bullet's broadphases use ids again: see qcMeshContact. -1 for an object in no world.
inline int qcUniqueIdOf(const btCollisionObject* object)
{
    const btBroadphaseProxy* proxy = object->getBroadphaseHandle();
    return proxy != nullptr ? proxy->m_uniqueId : -1;
}

/// An object from its addition to a world to its removal.
struct qcObjectKey
{
    const btCollisionObject* object;
    int uniqueId; ///< see qcUniqueIdOf

    explicit qcObjectKey(const btCollisionObject* added) : qcObjectKey(added, qcUniqueIdOf(added))
    {
    }
    qcObjectKey(const btCollisionObject* added, int id) : object(added), uniqueId(id)
    {
    }
    bool operator==(const qcObjectKey& other) const
    {
        return object == other.object && uniqueId == other.uniqueId;
    }
};

/// For the standard library's hash tables.
struct qcObjectKeyHash
{
    size_t operator()(const qcObjectKey& key) const
    {
        return size_t(qcMixHash(uint64_t(key.uniqueId), reinterpret_cast<uintptr_t>(key.object)));
    }
};

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
