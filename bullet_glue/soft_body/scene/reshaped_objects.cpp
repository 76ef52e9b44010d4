// Which objects have their triangles moved by the application.
#include "soft_body/scene/reshaped_objects.h"

#include "common/compound_children.h"
#include "common/shape_triangles.h"

namespace
{
/// A number that changes with the triangles of an object's meshes; 0: it has none.
uint64_t RevisionOf(const btCollisionObject* object, const qcSurfaceCache& surfaces)
{
    uint64_t revision = 0;
    qcForEachSimpleShape(object->getCollisionShape(), btTransform::getIdentity(),
                         [&](const btCollisionShape* simple, const btTransform&)
                         {
                             if (qcIsMesh(simple))
                                 revision = qcMixHash(revision, surfaces.RevisionOf(simple));
                         });
    return revision;
}
} // namespace

void qcReshapedObjects::ReadObject(btCollisionObject* object, const qcSurfaceCache& surfaces)
{
    const uint64_t revision = RevisionOf(object, surfaces);
    if (revision == 0)
        return;
    auto [found, isNew] = m_states.emplace(qcObjectKey(object), State{revision, m_step});
    State& state = found->second;
    state.isReshaped = state.isReshaped || state.revision != revision;
    state.revision = revision;
    state.step = m_step;
    if (state.isReshaped)
        m_reshaped.push_back(object);
}

void qcReshapedObjects::Read(const std::vector<qcObjectStarts::Present>& objects, const qcSurfaceCache& surfaces)
{
    m_step++;
    m_reshaped.clear();
    for (const qcObjectStarts::Present& present : objects)
        if (present.object->isStaticOrKinematicObject() && qcMayHoldMeshes(present.object->getCollisionShape()))
            ReadObject(present.object, surfaces);
    for (auto state = m_states.begin(); state != m_states.end();)
        state = state->second.step != m_step ? m_states.erase(state) : std::next(state);
}
