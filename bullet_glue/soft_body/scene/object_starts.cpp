// Where the objects of a world were at the start of a step.
#include "soft_body/scene/object_starts.h"

#include "common/object_motion.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>
#include <LinearMath/btTransformUtil.h>

namespace
{
/// The start of a body that Bullet integrates. The previous end is exact, also where the body has not made the motion
/// of its velocity: triangles that were disjoint there must not seem to penetrate.
btTransform StartOfBody(const btRigidBody& body, const btTransform* end, btScalar timeStep)
{
    btTransform start;
    btTransformUtil::integrateTransform(body.getWorldTransform(), body.getLinearVelocity(), body.getAngularVelocity(),
                                        -timeStep, start);
    const btCollisionShape* shape = body.getCollisionShape();
    return end != nullptr && qcMaxDisplacement(shape, *end, start) <= qcHalfSize(shape) ? *end : start;
}
} // namespace

struct qcObjectStarts::ReadCallback : btBroadphaseAabbCallback
{
    ReadCallback(qcObjectStarts* starts, btScalar timeStep) : starts(starts), timeStep(timeStep)
    {
    }

    bool process(const btBroadphaseProxy* proxy) override
    {
        auto* object = static_cast<btCollisionObject*>(proxy->m_clientObject);
        if (object->getInternalType() != btCollisionObject::CO_SOFT_BODY)
            starts->ReadObject(object, timeStep);
        return true;
    }

    qcObjectStarts* starts;
    btScalar timeStep;
};

void qcObjectStarts::ReadObject(btCollisionObject* object, btScalar timeStep)
{
    auto [found, isNew] = m_states.emplace(qcObjectKey(object), State());
    State& state = found->second;
    if (state.step == m_step)
        return;
    state.step = m_step;
    m_count++;
    const btTransform& now = object->getWorldTransform();
    const btRigidBody* body = btRigidBody::upcast(object);
    bool isDynamic = body != nullptr && !body->isStaticOrKinematicObject();
    if (!isNew && qcAreSame(state.end, now))
        state.start = now;
    else if (isDynamic && body->isActive())
        state.start = StartOfBody(*body, isNew ? nullptr : &state.end, timeStep);
    else
        state.start = !isNew && qcIsMotion(object, state.end, now, state.motion, timeStep) ? state.end : now;
    // A jump is remembered, too: the next one like it is a motion.
    state.motion = isNew ? btVector3(0, 0, 0) : now.getOrigin() - state.end.getOrigin();
    state.end = now;
    if (qcAreSame(state.start, now))
        return;
    Moved moved{object, {}, {}};
    btVector3 lower, upper;
    object->getCollisionShape()->getAabb(state.start, moved.lower, moved.upper);
    object->getCollisionShape()->getAabb(now, lower, upper);
    moved.lower.setMin(lower);
    moved.upper.setMax(upper);
    m_moved.push_back(moved);
}

void qcObjectStarts::Read(const std::set<btBroadphaseInterface*>& broadphases, btScalar timeStep)
{
    m_step++;
    m_count = 0;
    m_moved.clear();
    ReadCallback callback(this, timeStep);
    const btVector3 far(BT_LARGE_FLOAT, BT_LARGE_FLOAT, BT_LARGE_FLOAT);
    for (btBroadphaseInterface* broadphase : broadphases)
        broadphase->aabbTest(-far, far, callback);
    for (auto state = m_states.begin(); m_count < m_states.size() && state != m_states.end();)
        state = state->second.step != m_step ? m_states.erase(state) : std::next(state);
}

const btTransform& qcObjectStarts::StartOf(const btCollisionObject* object) const
{
    auto found = m_states.find(qcObjectKey(object));
    return found != m_states.end() ? found->second.start : object->getWorldTransform();
}

void qcObjectStarts::RecordEnd(const btCollisionObject* object)
{
    auto found = m_states.find(qcObjectKey(object));
    if (found == m_states.end())
        return;
    found->second.end = object->getWorldTransform();
}
