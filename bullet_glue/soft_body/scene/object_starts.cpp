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

/// The place of an object that is visited as the index-th one, or null. Broadphases mostly name the objects in the same
/// order.
qcObjectStarts::Place* qcObjectStarts::FindPlace(const btCollisionObject* object, size_t index)
{
    return index < m_places.size() && m_places[index].key == qcObjectKey(object) ? &m_places[index] : nullptr;
}

/// The place of the last object of m_present, and whether its state is new.
std::pair<qcObjectStarts::Place*, bool> qcObjectStarts::FindOrAdd(const btCollisionObject* object)
{
    const size_t index = m_present.size() - 1;
    if (Place* place = FindPlace(object, index))
        return {place, false};
    const qcObjectKey key(object);
    auto [found, isNew] = m_states.try_emplace(key);
    State& state = found->second;
    state.place = index;
    const Place place{key, &state, false, btTransform::getIdentity()};
    // Each place is visited in its turn.
    if (index == m_places.size())
        m_places.push_back(place);
    else
        m_places[index] = place;
    return {&m_places[index], isNew};
}

/// Its next step reads the whole state.
void qcObjectStarts::Wake(const State& state)
{
    if (state.place < m_places.size() && m_places[state.place].state == &state)
        m_places[state.place].rests = false;
}

bool qcObjectStarts::AreShiftedBy(const qcTranslation& translation, const qcBroadphases& broadphases) const
{
    bool areShifted = true;
    auto check = [&](btCollisionObject* object, btBroadphaseInterface*)
    {
        auto found = areShifted ? m_states.find(qcObjectKey(object)) : m_states.end();
        if (found == m_states.end() || found->second.step == 0 || object->isKinematicObject())
            return;
        const State& state = found->second;
        areShifted = translation.IsOf(state.end, IsDynamic(object) ? state.begin : object->getWorldTransform());
    };
    qcForEachObject(broadphases, check);
    return areShifted;
}

/// Reads an object that does not rest.
void qcObjectStarts::ReadObject(btCollisionObject* object, btScalar timeStep, const qcRigidLimits* limits)
{
    auto [place, isNew] = FindOrAdd(object);
    State& state = *place->state;
    if (state.step == m_step)
        return;
    state.step = m_step;
    m_count++;
    const btTransform& now = object->getWorldTransform();
    ReadState(object, &state, isNew, timeStep, limits);
    place->rests =
        qcAreSame(state.start, now) && state.motion.isZero() && (!IsDynamic(object) || qcAreSame(state.begin, now));
    // The beginning isn't read while it rests, even if the application makes it dynamic meanwhile.
    if (place->rests)
        place->at = state.begin = now;
}

void qcObjectStarts::ReadState(btCollisionObject* object, State* read, bool isNew, btScalar timeStep,
                               const qcRigidLimits* limits)
{
    State& state = *read;
    const btTransform& now = object->getWorldTransform();
    const bool isDynamic = IsDynamic(object);
    if (!isNew && !isDynamic && qcAreSame(state.end, now))
    {
        state.start = now;
        state.motion.setZero();
        return;
    }
    const bool isShifted = m_isRestored || m_shift.IsOf(state.end, isDynamic ? state.begin : now);
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

void qcObjectStarts::BeginObject(const btCollisionObject* object, size_t index)
{
    const btTransform& now = object->getWorldTransform();
    Place* place = FindPlace(object, index);
    if (place != nullptr && place->RestsAt(now))
        return;
    bool isNew = false;
    State* state = place != nullptr ? place->state : nullptr;
    if (state == nullptr)
    {
        auto [found, isAdded] = m_states.try_emplace(qcObjectKey(object));
        state = &found->second;
        isNew = isAdded;
    }
    Wake(*state);
    state->begin = now;
    if (isNew)
        state->end = now;
}

void qcObjectStarts::Begin(const qcBroadphases& broadphases, const ObjectFunction& function)
{
    size_t index = 0;
    qcForEachObject(broadphases,
                    [this, &function, &index](btCollisionObject* object, btBroadphaseInterface*)
                    {
                        function(object);
                        if (IsDynamic(object))
                            BeginObject(object, index);
                        index++;
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
                        const Place* place = FindPlace(object, m_present.size());
                        m_present.push_back({object, broadphase});
                        if (place != nullptr && place->RestsAt(object->getWorldTransform()))
                            m_count++;
                        else
                            ReadObject(object, timeStep, limits);
                    });
    if (m_count != m_states.size())
        ForgetAbsent();
}

/// Forgets the objects that the step has not read.
void qcObjectStarts::ForgetAbsent()
{
    m_places.erase(m_places.begin() + std::ptrdiff_t(m_present.size()), m_places.end());
    for (const Place& place : m_places)
        place.state->step = m_step;
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
    Wake(found->second);
    found->second.end = object->getWorldTransform();
}
