// The multibodies of a world, with their motion in a step.
#include "mesh_contact/limits/swept_multibodies.h"

#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>

qcSweptMultiBody* qcSweptMultiBodies::Find(const btCollisionObject* link) const
{
    const btMultiBodyLinkCollider* collider = m_multibodies.empty() ? nullptr : qcAsLink(link);
    auto found = collider != nullptr ? m_multibodies.find(collider->m_multiBody) : m_multibodies.end();
    return found != m_multibodies.end() && found->second->IsDynamic(*collider) ? found->second.get() : nullptr;
}

/// Forgets those that the world steps no more, without a look at them. `adds`: new ones are added.
void qcSweptMultiBodies::Collect(bool adds)
{
    auto* world = dynamic_cast<btMultiBodyDynamicsWorld*>(m_settings.world);
    const int count = world != nullptr ? world->getNumMultibodies() : 0;
    std::unordered_map<const btMultiBody*, std::unique_ptr<qcSweptMultiBody>> present;
    for (int i = 0; i < count; i++)
    {
        btMultiBody* body = world->getMultiBody(i);
        auto known = m_multibodies.find(body);
        if (known != m_multibodies.end())
            present[body] = std::move(known->second);
        else if (adds)
            present[body] = std::make_unique<qcSweptMultiBody>(*body);
    }
    m_multibodies.swap(present);
}

/// Only a world that steps multibodies has some.
btVector3 qcSweptMultiBodies::Gravity() const
{
    return static_cast<btMultiBodyDynamicsWorld*>(m_settings.world)->getGravity();
}

void qcSweptMultiBodies::ReadMotions(btScalar timeStep, bool adds)
{
    Collect(adds);
    for (auto& [body, multibody] : m_multibodies)
        multibody->ReadMotion(timeStep);
}

void qcSweptMultiBodies::ReturnToStart(const btCollisionObject* link, std::vector<const btCollisionObject*>* moved)
{
    qcSweptMultiBody* multibody = Find(link);
    if (multibody != nullptr && multibody->ReturnToStart(Gravity()))
        multibody->ForEachCollider([moved](const btCollisionObject* collider) { moved->push_back(collider); });
}

void qcSweptMultiBodies::UpdateVelocities()
{
    for (auto& [body, multibody] : m_multibodies)
        multibody->UpdateVelocities(Gravity());
}
