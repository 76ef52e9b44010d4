// A translation of all objects of a world by the application.
#include "mesh_contact/limits/common_shift.h"

namespace
{
// Rounding of the places of links, which Bullet computes along their chain.
constexpr btScalar s_linkRounding = 64 * SIMD_EPSILON;
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
        if (const btRigidBody* body = qcDynamicBody(objects[i]))
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

qcTranslation qcFindCommonShift(const std::vector<qcSweptObject*>& objects, const qcBodyOrigins& others,
                                const btCollisionWorld& world, btScalar timeStep)
{
    qcTranslation shift;
    for (const qcSweptObject* swept : objects)
        if (swept->isDynamic && !swept->isNew &&
            !shift.Add(swept->last.getOrigin(), swept->start.getOrigin(),
                       swept->body == nullptr ? s_linkRounding : qcPlaceRounding))
            return qcTranslation();
    auto add = [&shift](const btVector3& from, const btVector3& to) { return shift.Add(from, to); };
    return others.ForEach(world, timeStep, add) ? shift : qcTranslation();
}
