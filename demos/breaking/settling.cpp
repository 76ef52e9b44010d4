// Rest spreads upwards, from what stands; motion spreads from what moves fast, and from what has left.
#include "breaking/settling.h"

#include <algorithm>

namespace
{
constexpr btScalar s_slow = btScalar(0.3), s_slowTurn = btScalar(1); // m/s, 1/s
constexpr btScalar s_seconds = btScalar(0.2);                        // slow for so long: at rest
constexpr btScalar s_fast = btScalar(0.6);                           // m/s: wakes what is near
constexpr btScalar s_ahead = btScalar(0.06);                         // s: what it will reach in this time
constexpr btScalar s_left = btScalar(0.01);                          // m: what stood on it may fall
constexpr btScalar s_touching = btScalar(0.005);                     // m
} // namespace

void qcFreezeBody(btRigidBody* body)
{
    body->setLinearVelocity(btVector3(0, 0, 0));
    body->setAngularVelocity(btVector3(0, 0, 0));
    body->clearForces();
    body->setMassProps(0, btVector3(0, 0, 0));
    body->updateInertiaTensor();
    body->setInterpolationWorldTransform(body->getWorldTransform());
    body->forceActivationState(ISLAND_SLEEPING);
    body->getBroadphaseHandle()->m_collisionFilterGroup = btBroadphaseProxy::StaticFilter;
    body->getBroadphaseHandle()->m_collisionFilterMask = btBroadphaseProxy::AllFilter ^ btBroadphaseProxy::StaticFilter;
}

void qcThawBody(btRigidBody* body, btScalar mass, const btVector3& inertia, const btVector3& gravity)
{
    body->setMassProps(mass, inertia);
    body->updateInertiaTensor();
    body->setGravity(gravity);
    body->getBroadphaseHandle()->m_collisionFilterGroup = btBroadphaseProxy::DefaultFilter;
    body->getBroadphaseHandle()->m_collisionFilterMask = btBroadphaseProxy::AllFilter;
    body->forceActivationState(ACTIVE_TAG);
}

void qcSettling::Add(btRigidBody* body, btScalar mass, const btVector3& inertia)
{
    Entry entry;
    entry.body = body;
    entry.mass = mass;
    entry.inertia = inertia;
    m_entries.push_back(entry);
}

void qcSettling::WakeIn(const btVector3& lower, const btVector3& upper)
{
    for (Entry& entry : m_entries)
        if (entry.isResting && TestAabbAgainstAabb2(lower, upper, entry.lower, entry.upper))
        {
            qcThawBody(entry.body, entry.mass, entry.inertia, m_world->getGravity());
            entry.isResting = entry.hasLeft = false;
            entry.slowSeconds = 0;
        }
}

void qcSettling::Wake()
{
    const btCollisionObjectArray& objects = m_world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        const btRigidBody* body = btRigidBody::upcast(objects[i]);
        btScalar speed = body->getLinearVelocity().length();
        if (body->isStaticObject() || speed < s_fast)
            continue;
        btVector3 lower, upper, reach(speed * s_ahead, speed * s_ahead, speed * s_ahead);
        body->getAabb(lower, upper);
        WakeIn(lower - reach, upper + reach);
    }
    const btVector3 touching(s_touching, s_touching, s_touching);
    for (Entry& entry : m_entries)
        if (!entry.isResting && !entry.hasLeft &&
            entry.body->getWorldTransform().getOrigin().distance(entry.place) > s_left)
        {
            entry.hasLeft = true;
            WakeIn(entry.lower - touching, entry.upper + touching);
        }
}

/// The bodies that touch one that stands, sorted.
std::vector<const btCollisionObject*> qcSettling::FindSupported() const
{
    std::vector<const btCollisionObject*> supported;
    btDispatcher* dispatcher = m_world->getDispatcher();
    for (int m = 0; m < dispatcher->getNumManifolds(); m++)
    {
        const btPersistentManifold& manifold = *dispatcher->getManifoldByIndexInternal(m);
        bool touches = false;
        for (int i = 0; i < manifold.getNumContacts(); i++)
            touches = touches || manifold.getContactPoint(i).getDistance() < s_touching;
        if (touches && manifold.getBody1()->isStaticObject())
            supported.push_back(manifold.getBody0());
        if (touches && manifold.getBody0()->isStaticObject())
            supported.push_back(manifold.getBody1());
    }
    std::sort(supported.begin(), supported.end());
    return supported;
}

void qcSettling::Rest(Entry* entry)
{
    qcFreezeBody(entry->body);
    entry->isResting = true;
    entry->place = entry->body->getWorldTransform().getOrigin();
    entry->body->getAabb(entry->lower, entry->upper);
}

void qcSettling::Settle(btScalar seconds)
{
    std::vector<const btCollisionObject*> supported = FindSupported();
    for (Entry& entry : m_entries)
    {
        bool isSlow =
            entry.body->getLinearVelocity().length() < s_slow && entry.body->getAngularVelocity().length() < s_slowTurn;
        entry.slowSeconds = isSlow ? entry.slowSeconds + seconds : 0;
        if (!entry.isResting && entry.slowSeconds > s_seconds &&
            std::binary_search(supported.begin(), supported.end(), entry.body))
            Rest(&entry);
    }
}

size_t qcSettling::RestingCount() const
{
    return size_t(
        std::count_if(m_entries.begin(), m_entries.end(), [](const Entry& entry) { return entry.isResting; }));
}
