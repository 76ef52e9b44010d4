// Does the last query hold for the pairs of this step? The first pair that a step asks for has all of them looked at,
// so that what a pair reads does not depend on which comes first.
#include "mesh_contact/contact_batch.h"

#include "common/object_key.h"

#include <BulletCollision/BroadphaseCollision/btDispatcher.h>
#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

/// Did the last query look at it, and as far as it may come?
bool qcMeshBatch::IsSeen(const btCollisionObject* object, const Object& known) const
{
    if (known.seen != m_gathering || known.uniqueId != qcUniqueIdOf(object))
        return false;
    // Pushed since then, it may come further than the query looked.
    btScalar approach = qcApproach(object, known.radius, m_timeStep, known.limit, m_drift);
    return approach <= known.approach + s_rest * known.threshold / 2;
}

qcMeshBatch::State qcMeshBatch::StateOf(const btCollisionObject* object)
{
    const btRigidBody* body = btRigidBody::upcast(object);
    const btVector3 zero(0, 0, 0);
    return {object->getWorldTransform(), body != nullptr ? body->getLinearVelocity() : zero,
            body != nullptr ? body->getAngularVelocity() : zero, object->isActive()};
}

bool qcMeshBatch::IsInState(const btCollisionObject* object, const State& state)
{
    State now = StateOf(object);
    return qcAreSame(state.transform, now.transform) && qcAreSame(state.linear, now.linear) &&
           qcAreSame(state.angular, now.angular) && state.active == now.active;
}

/// Did the last query see all its meshes where they are?
bool qcMeshBatch::IsHeld(const btCollisionObject* object, const Object& known)
{
    if (!IsSeen(object, known))
        return false;
    // Of what is fast it looked further ahead, in the direction that it had.
    if (2 * qcMeshMotion(object).Fastest(known.radius) * m_timeStep > known.threshold &&
        !IsInState(object, known.state))
        return false;
    m_collected.clear();
    CollectMeshes(object->getCollisionShape(), object->getWorldTransform(), &m_collected);
    auto isSame = [](const Mesh& held, const Mesh& now) { return IsAs(held, now.shape, now.transform); };
    return std::equal(known.meshes.begin(), known.meshes.end(), m_collected.begin(), m_collected.end(), isSame);
}

/// What this check finds of an object; null: nothing is known of it yet.
qcMeshBatch::Object* qcMeshBatch::Check(const btCollisionObject* object)
{
    auto found = m_objects.find(object);
    if (found == m_objects.end())
        return nullptr;
    Object& known = found->second;
    if (known.checked != m_check)
    {
        known.checked = m_check;
        known.held = IsHeld(object, known);
        known.state = StateOf(object);
    }
    return &known;
}

/// Does the last query hold for all pairs that the step will ask for?
bool qcMeshBatch::CheckAll()
{
    m_check++;
    bool all = m_result != nullptr;
    ForEachPair(
        [&](const btCollisionObject* object0, const btCollisionObject* object1)
        {
            const Object *known0 = Check(object0), *known1 = Check(object1);
            bool known = known0 != nullptr && known1 != nullptr;
            bool ours =
                !known || (!known0->meshes.empty() && !known1->meshes.empty() && (known0->ours || known1->ours));
            if (!ours || !world->getDispatcher()->needsCollision(object0, object1))
                return;
            all = all && known && known0->held && known1->held &&
                  (known0->activity == qc_activityMoving || known1->activity == qc_activityMoving);
        });
    return all;
}

/// Is it in the state in which the last check found it?
bool qcMeshBatch::IsAsChecked(const btCollisionObject* object) const
{
    auto found = m_objects.find(object);
    return found != m_objects.end() && found->second.checked == m_check &&
           found->second.uniqueId == qcUniqueIdOf(object) && IsInState(object, found->second.state);
}
