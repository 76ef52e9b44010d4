// Caches of small meshes from step to step.
#include "mesh_contact/planes/axis_cache.h"

#include <algorithm>

namespace
{
constexpr uint64_t s_keptSteps = 64;

/// A mesh of Bullet's own shapes; null if it is not small.
std::shared_ptr<const qcSupportMesh> ReadMesh(const btCollisionShape* shape)
{
    return qcSupportMesh::IsSmall(qcCountTriangles(shape)) ? std::make_shared<const qcSupportMesh>(shape) : nullptr;
}
} // namespace

void qcAxisCache::BeginStep()
{
    m_step++;
    BeginObjects();
    m_touches.Clear(0);
    if (m_step % s_keptSteps != 0)
        return;
    for (auto entry = m_meshes.begin(); entry != m_meshes.end();)
    {
        entry->second.owners.ForgetBefore(m_step - s_keptSteps);
        entry = m_step - entry->second.step > s_keptSteps ? m_meshes.erase(entry) : std::next(entry);
    }
    qcHashTable<uint64_t, Axis> kept;
    for (const auto& entry : m_axes.Entries())
        if (m_step - entry.value.step <= s_keptSteps)
            kept.FindOrAdd(entry.key, entry.value);
    m_axes = std::move(kept);
}

/// False if the object's shape, one of Bullet's own, may not be the one that was read.
bool qcAxisCache::IsKnown(const btCollisionObject* object, qcShapeOwners* owners)
{
    auto isLive = [this](const qcObjectKey& key)
    {
        if (m_live == nullptr)
            m_live = std::make_unique<qcLiveObjects>(m_settings.world->getBroadphase());
        return m_live->Contains(key.object, key.uniqueId);
    };
    return owners->Add(object, object->getCollisionShape(), m_step, isLive);
}

const qcSupportMesh* qcAxisCache::FindMesh(const btCollisionObject* object)
{
    const btCollisionShape* shape = object->getCollisionShape();
    if (!qcIsMesh(shape))
        return nullptr;
    Mesh& entry = m_meshes[shape];
    entry.step = m_step;
    uint64_t revision = qcMeshRevision(shape);
    const qcMeshShape* ours = qcAsMeshShape(shape);
    const bool isKnown = ours != nullptr || IsKnown(object, &entry.owners);
    if (isKnown && entry.revision == revision)
        return entry.mesh.get();
    if (entry.revision != 0)
        m_touches.Clear(0);
    entry.revision = revision;
    entry.mesh = ours != nullptr ? ours->GetSupport() : ReadMesh(shape);
    return entry.mesh.get();
}

uint64_t qcAxisCache::KeyOf(const btCollisionObject* a, const btCollisionObject* b)
{
    auto [low, high] = std::minmax({uint32_t(qcUniqueIdOf(a)), uint32_t(qcUniqueIdOf(b))});
    return uint64_t(low) << 32 | high;
}

void qcAxisCache::AddPair(const btCollisionObject* a, const btCollisionObject* b)
{
    m_axes.FindOrAdd(KeyOf(a, b), {btVector3(0, 0, 0), m_step}).step = m_step;
}

btVector3 qcAxisCache::GetAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                               const btTransform& atB)
{
    Axis* kept = m_axes.Find(KeyOf(a, b));
    if (kept == nullptr)
        return btVector3(0, 0, 0);
    kept->step = m_step;
    return qcUniqueIdOf(a) < qcUniqueIdOf(b) ? atA.getBasis() * kept->axis : -(atB.getBasis() * kept->axis);
}

void qcAxisCache::KeepAxis(const btCollisionObject* a, const btTransform& atA, const btCollisionObject* b,
                           const btTransform& atB, const btVector3& axis)
{
    m_axes.Find(KeyOf(a, b))->axis = qcUniqueIdOf(a) < qcUniqueIdOf(b) ? axis * atA.getBasis() : -axis * atB.getBasis();
}

void qcAxisCache::KeepTouching(const btCollisionObject* a, const qcPlacedSupport& atA, const btCollisionObject* b,
                               const qcPlacedSupport& atB)
{
    bool isOrdered = qcUniqueIdOf(a) < qcUniqueIdOf(b);
    Touch touch{isOrdered ? atA : atB, isOrdered ? atB : atA};
    m_touches.FindOrAdd(KeyOf(a, b), touch) = touch;
}

bool qcAxisCache::AreTouching(const btCollisionObject* a, const qcPlacedSupport& atA, const btCollisionObject* b,
                              const qcPlacedSupport& atB) const
{
    const Touch* touch = m_touches.Find(KeyOf(a, b));
    if (touch == nullptr)
        return false;
    bool isOrdered = qcUniqueIdOf(a) < qcUniqueIdOf(b);
    auto isSame = [](const qcPlacedSupport& x, const qcPlacedSupport& y)
    { return x.mesh == y.mesh && qcAreSame(x.transform, y.transform); };
    return isSame(isOrdered ? atA : atB, touch->first) && isSame(isOrdered ? atB : atA, touch->second);
}

void qcAxisCache::InvalidateShape(const btCollisionShape* shape)
{
    m_touches.Clear(0);
    m_meshes.erase(shape);
}
