// A translation of all objects of a world by the application.
#include "mesh_contact/limits/common_shift.h"

#include <algorithm>

namespace
{
// Rounding of places, by their size; Bullet computes those of links along their chain.
constexpr btScalar s_roundingOfPlace = 8 * SIMD_EPSILON, s_roundingOfLinkPlace = 64 * SIMD_EPSILON;

const btRigidBody* MovedByBullet(const btCollisionObject* object)
{
    const btRigidBody* body = btRigidBody::upcast(object);
    return body != nullptr && !body->isStaticOrKinematicObject() ? body : nullptr;
}
} // namespace

void qcBodyOrigins::MarkStarts(const btCollisionWorld& world)
{
    for (Origin& origin : m_origins)
        if (IsThere(world, origin))
            origin.start = origin.body->getWorldTransform().getOrigin();
    m_isMarked = true;
}

void qcBodyOrigins::RecordEnds(const btCollisionWorld& world)
{
    const btCollisionObjectArray& objects = world.getCollisionObjectArray();
    m_origins.clear();
    for (int i = 0; i < objects.size(); i++)
        if (const btRigidBody* body = MovedByBullet(objects[i]))
        {
            const btVector3& origin = body->getWorldTransform().getOrigin();
            m_origins.push_back({body, i, origin, origin});
        }
    m_isMarked = false;
}

btVector3 qcBodyOrigins::StartOf(const Origin& origin, btScalar timeStep) const
{
    if (m_isMarked)
        return origin.start;
    const btVector3& now = origin.body->getWorldTransform().getOrigin();
    return origin.body->isActive() ? now - origin.body->getLinearVelocity() * timeStep : now;
}

/// Takes the displacement of a body. False: another one has another displacement.
bool qcCommonShift::Add(const btVector3& from, const btVector3& to, btScalar rounding)
{
    error = std::max(error, rounding * (from.length() + to.length()));
    if (by.isZero())
        by = to - from;
    return by.length() > error && (to - from - by).length() <= error;
}

qcCommonShift qcCommonShift::Find(const std::vector<qcSweptObject*>& objects, const qcBodyOrigins& others,
                                  const btCollisionWorld& world, btScalar timeStep)
{
    qcCommonShift shift;
    for (const qcSweptObject* swept : objects)
        if (swept->isDynamic && !swept->isNew &&
            !shift.Add(swept->last.getOrigin(), swept->start.getOrigin(),
                       swept->body == nullptr ? s_roundingOfLinkPlace : s_roundingOfPlace))
            return qcCommonShift();
    auto add = [&shift](const btVector3& from, const btVector3& to) { return shift.Add(from, to, s_roundingOfPlace); };
    return others.ForEach(world, timeStep, add) ? shift : qcCommonShift();
}

bool qcCommonShift::IsOf(const btTransform& from, const btTransform& to) const
{
    const btVector3 moved = to.getOrigin() - from.getOrigin();
    const btScalar rounding =
        std::max(error, s_roundingOfPlace * (from.getOrigin().length() + to.getOrigin().length()));
    auto isTurned = [&](int row)
    { return (from.getBasis()[row] - to.getBasis()[row]).length2() > s_roundingOfPlace * s_roundingOfPlace; };
    return by.length() > error && (moved - by).length() <= rounding && !isTurned(0) && !isTurned(1) && !isTurned(2);
}
