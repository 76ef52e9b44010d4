// Which objects have their triangles moved by the application.
#include "soft_body/scene/reshaped_objects.h"

#include "common/compound_children.h"
#include "common/shape_triangles.h"

void qcReshapedObjects::ReadObject(btCollisionObject* object)
{
    uint64_t revision = 0;
    bool hasChanged = false;
    auto add = [&](const btCollisionShape* simple, const btTransform&)
    {
        if (!qcIsMesh(simple))
            return;
        revision = qcMixHash(revision, qcSurfaceCache::RevisionOf(simple));
        hasChanged = hasChanged || (m_changedShapes.Has(simple) && qcAsMeshShape(simple) == nullptr);
    };
    qcForEachSimpleShape(object->getCollisionShape(), btTransform::getIdentity(), add);
    if (revision == 0)
        return;
    auto [found, isNew] = m_states.emplace(qcObjectKey(object), State{revision, m_step});
    State& state = found->second;
    state.isReshaped = state.isReshaped || state.revision != revision || (hasChanged && !isNew);
    state.revision = revision;
    state.step = m_step;
    if (state.isReshaped)
        m_reshaped.push_back(object);
}

void qcReshapedObjects::InvalidateShape(const btCollisionShape* shape)
{
    if (!m_states.empty())
        m_changedShapes.Add(shape);
}

void qcReshapedObjects::Read(const std::vector<qcObjectStarts::Present>& objects)
{
    m_step++;
    m_reshaped.clear();
    for (const qcObjectStarts::Present& present : objects)
        if (present.object->isStaticOrKinematicObject() && qcMayHoldMeshes(present.object->getCollisionShape()))
            ReadObject(present.object);
    for (auto state = m_states.begin(); state != m_states.end();)
        state = state->second.step != m_step ? m_states.erase(state) : std::next(state);
    m_changedShapes.Clear();
}
