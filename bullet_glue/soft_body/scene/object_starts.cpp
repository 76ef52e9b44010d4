// Where the objects of a world were at the start of a step.
#include "soft_body/scene/object_starts.h"

#include "common/finite.h"
#include "common/object_motion.h"
#include "soft_body/scene/objects_in_box.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>

namespace
{
/// True for a link of a multibody.
bool IsLink(const btCollisionObject* object)
{
    return object->getInternalType() == btCollisionObject::CO_FEATHERSTONE_LINK;
}

/// True if Bullet moves the object. The application may move it, too: links of robots often.
bool IsDynamic(const btCollisionObject* object)
{
    return (btRigidBody::upcast(object) != nullptr || IsLink(object)) && !object->isStaticOrKinematicObject();
}
} // namespace

/// The object, with the box of its motion from a transform to its present one.
qcObjectStarts::Moved qcObjectStarts::MakeMoved(btCollisionObject* object, const btTransform& from)
{
    Moved moved{object, {}, {}};
    btVector3 lower, upper;
    object->getCollisionShape()->getAabb(from, moved.lower, moved.upper);
    object->getCollisionShape()->getAabb(object->getWorldTransform(), lower, upper);
    moved.lower.setMin(lower);
    moved.upper.setMax(upper);
    return moved;
}

/// The state of an object, and whether it is new. Broadphases mostly name the objects in the same order.
std::pair<qcObjectStarts::State*, bool> qcObjectStarts::FindOrAdd(const qcObjectKey& key)
{
    const size_t place = m_present.size() - 1;
    if (place < m_order.size() && m_order[place].first == key)
        return {m_order[place].second, false};
    auto [found, isNew] = m_states.emplace(key, State());
    // Each place is visited in its turn.
    if (place == m_order.size())
        m_order.emplace_back(key, &found->second);
    else
        m_order[place] = {key, &found->second};
    return {&found->second, isNew};
}

bool qcObjectStarts::AreShiftedBy(const qcTranslation& translation, const qcBroadphases& broadphases) const
{
    bool areShifted = true;
    auto check = [&](btCollisionObject* object, btBroadphaseInterface*)
    {
        auto found = areShifted ? m_states.find(qcObjectKey(object)) : m_states.end();
        if (found == m_states.end() || found->second.step != m_step || object->isKinematicObject())
            return;
        const State& state = found->second;
        areShifted = translation.IsOf(state.end, IsDynamic(object) ? state.begin : object->getWorldTransform());
    };
    qcForEachObject(broadphases, check);
    return areShifted;
}

void qcObjectStarts::ReadObject(btCollisionObject* object, btScalar timeStep, const qcRigidLimits* limits)
{
    auto [found, isNew] = FindOrAdd(qcObjectKey(object));
    State& state = *found;
    if (state.step == m_step)
        return;
    state.step = m_step;
    m_count++;
    const btTransform& now = object->getWorldTransform();
    const bool isDynamic = IsDynamic(object);
    if (!isNew && !isDynamic && qcAreSame(state.end, now))
    {
        state.start = now;
        state.motion.setZero();
        return;
    }
    const bool isShifted = m_shift.IsOf(state.end, isDynamic ? state.begin : now);
    if (isNew)
        state.start = now;
    else if (isShifted)
        state.start = isDynamic ? state.begin : now;
    else if (isDynamic)
    {
        const btCollisionShape* shape = object->getCollisionShape();
        bool isNear = qcMaxDisplacement(shape, state.end, state.begin) <= qcHalfSize(shape) ||
                      (IsLink(object) && qcIsMotion(object, state.end, state.begin, state.motion, timeStep));
        state.start = isNear ? state.end : state.begin;
        const btRigidBody* body = btRigidBody::upcast(object);
        const bool isCertified = limits != nullptr && limits->HasCertified(object);
        if (body != nullptr && !isCertified && !qcIsIntegrated(*body, state.begin, now, timeStep))
            state.start = now;
    }
    else
    {
        btTransform last = state.end;
        last.getOrigin() += m_shift.by;
        state.start = qcIsMotion(object, last, now, state.motion, timeStep) ? last : now;
    }
    // The application has given it finite values within the step.
    if (!qcIsFinite(state.start))
        state.start = now;
    // A jump is remembered, too: the next one like it is a motion.
    state.motion = isNew || isShifted ? btVector3(0, 0, 0) : now.getOrigin() - state.end.getOrigin();
    state.end = now;
    if (qcAreSame(state.start, now))
        return;
    m_moved.push_back(MakeMoved(object, state.start));
}

void qcObjectStarts::Begin(const qcBroadphases& broadphases, const ObjectFunction& function)
{
    qcForEachObject(broadphases,
                    [this, &function](btCollisionObject* object, btBroadphaseInterface*)
                    {
                        function(object);
                        if (!IsDynamic(object))
                            return;
                        auto [found, isNew] = m_states.emplace(qcObjectKey(object), State());
                        found->second.begin = object->getWorldTransform();
                        if (isNew)
                            found->second.end = found->second.begin;
                    });
}

void qcObjectStarts::ReadBegin(const qcBroadphases& broadphases)
{
    Begin(broadphases, [](const btCollisionObject*) {});
}

void qcObjectStarts::Read(const qcBroadphases& broadphases, btScalar timeStep, const qcRigidLimits* limits)
{
    m_step++;
    m_count = 0;
    m_present.clear();
    m_moved.clear();
    m_notFinite = nullptr;
    qcForEachObject(broadphases,
                    [this, timeStep, limits](btCollisionObject* object, btBroadphaseInterface* broadphase)
                    {
                        if (!qcIsFinite(*object))
                        {
                            m_notFinite = object;
                            return;
                        }
                        m_present.push_back({object, broadphase});
                        ReadObject(object, timeStep, limits);
                    });
    if (m_count == m_states.size())
        return;
    m_order.clear();
    for (auto state = m_states.begin(); state != m_states.end();)
        state = state->second.step != m_step ? m_states.erase(state) : std::next(state);
}

void qcObjectStarts::ForEachPlaced(const qcBroadphases& broadphases, const BoxFunction& function) const
{
    qcForEachObject(broadphases,
                    [&](btCollisionObject* object, btBroadphaseInterface*)
                    {
                        auto found = m_states.find(qcObjectKey(object));
                        if ((IsDynamic(object) && !IsLink(object)) || !object->hasContactResponse() ||
                            found == m_states.end() || !qcIsFinite(*object) ||
                            qcAreSame(found->second.end, object->getWorldTransform()))
                            return;
                        const Moved moved = MakeMoved(object, found->second.end);
                        function(moved.lower, moved.upper);
                    });
}

const btTransform& qcObjectStarts::StartOf(const btCollisionObject* object) const
{
    auto found = m_states.find(qcObjectKey(object));
    return found != m_states.end() ? found->second.start : object->getWorldTransform();
}

bool qcObjectStarts::StartsAtBegin(const btCollisionObject* object) const
{
    auto found = m_states.find(qcObjectKey(object));
    if (found == m_states.end())
        return false;
    const State& state = found->second;
    return qcAreSame(state.start, IsDynamic(object) ? state.begin : object->getWorldTransform());
}

void qcObjectStarts::RecordEnd(const btCollisionObject* object)
{
    auto found = m_states.find(qcObjectKey(object));
    if (found == m_states.end())
        return;
    found->second.end = object->getWorldTransform();
}
