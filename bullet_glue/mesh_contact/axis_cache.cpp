// What is kept from step to step to separate pairs of small meshes.
#include "mesh_contact/axis_cache.h"

#include <algorithm>

namespace
{
constexpr uint64_t s_keptSteps = 64;

/// The number of triangles if that is quickly known, else 1: they have to be counted.
size_t CountOf(const btCollisionShape* shape)
{
    const qcMeshShape* ours = qcAsMeshShape(shape);
    return ours != nullptr ? ours->getTriangleCount() : 1;
}
} // namespace

void qcAxisCache::BeginStep()
{
    m_step++;
    if (m_step % s_keptSteps != 0)
        return;
    for (auto entry = m_meshes.begin(); entry != m_meshes.end();)
        entry = m_step - entry->second.step > s_keptSteps ? m_meshes.erase(entry) : std::next(entry);
    qcHashTable<uint64_t, Axis> kept;
    for (const auto& entry : m_axes.Entries())
        if (m_step - entry.value.step <= s_keptSteps)
            kept.FindOrAdd(entry.key, entry.value);
    m_axes = std::move(kept);
}

const qcSupportMesh* qcAxisCache::FindMesh(const btCollisionObject* object)
{
    const btCollisionShape* shape = object->getCollisionShape();
    if (!qcIsMesh(shape))
        return nullptr;
    Mesh& entry = m_meshes[shape];
    entry.step = m_step;
    uint64_t revision = qcMeshRevision(shape);
    if (entry.revision == revision)
        return entry.mesh.get();
    entry.revision = revision;
    entry.mesh.reset();
    if (qcSupportMesh::IsSmall(CountOf(shape)))
        entry.mesh.reset(new qcSupportMesh(shape));
    if (entry.mesh != nullptr && !qcSupportMesh::IsSmall(entry.mesh->Triangles().count))
        entry.mesh.reset();
    return entry.mesh.get();
}

qcAxisCache::Axis& qcAxisCache::AxisOf(const btCollisionObject* a, const btCollisionObject* b)
{
    auto [low, high] = std::minmax({uint32_t(qcUniqueIdOf(a)), uint32_t(qcUniqueIdOf(b))});
    Axis& entry = m_axes.FindOrAdd(uint64_t(low) << 32 | high, {btVector3(0, 0, 0), m_step});
    entry.step = m_step;
    return entry;
}

btVector3 qcAxisCache::GetAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                               const btTransform& atB)
{
    const btVector3& axis = AxisOf(a, b).axis;
    return qcUniqueIdOf(a) < qcUniqueIdOf(b) ? atA.getBasis() * axis : -(atB.getBasis() * axis);
}

void qcAxisCache::KeepAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                           const btTransform& atB, const btVector3& axis)
{
    AxisOf(a, b).axis = qcUniqueIdOf(a) < qcUniqueIdOf(b) ? axis * atA.getBasis() : -axis * atB.getBasis();
}

void qcAxisCache::InvalidateShape(const btCollisionShape* shape)
{
    m_meshes.erase(shape);
}
