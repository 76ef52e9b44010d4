// Static meshes that nothing has been near and that have not changed.
#include "mesh_contact/limits/resting_meshes.h"

#include "common/object_motion.h"
#include "common/shape_triangles.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <cmath>

namespace
{
constexpr uint32_t s_none = UINT32_MAX;
// Meshes that are not indexed yet are looked through one by one: so many, and a share of all.
constexpr size_t s_maxLoose = 64, s_looseShare = 8;
// Extents are sorted by powers of two between these.
constexpr int s_minExponent = -20, s_maxExponent = 20;

/// Meshes of about one extent: those that may reach a place along x are next to each other.
size_t WidthClassOf(const btVector3& lower, const btVector3& upper)
{
    int exponent;
    std::frexp(double(upper.x() - lower.x()), &exponent);
    return size_t(std::min(std::max(exponent, s_minExponent), s_maxExponent) - s_minExponent);
}
} // namespace

bool qcRestingMeshes::CanRest(const qcSweptObject& swept)
{
    return qcIsStatic(swept.object) && swept.owner == nullptr && swept.cores == nullptr &&
           qcIsMesh(swept.object->getCollisionShape()) && qcAreSame(swept.start, swept.target) &&
           qcAreSame(swept.target, swept.object->getWorldTransform()) && !swept.Deforms();
}

bool qcRestingMeshes::IsUnchanged(const Mesh& mesh, const btCollisionObject* object)
{
    const btCollisionShape* shape = object->getCollisionShape();
    if (shape != mesh.shape || !qcIsStatic(object) || !qcAreSame(object->getWorldTransform(), mesh.place))
        return false;
    const qcMeshShape* ours = qcAsMeshShape(shape);
    if (ours != nullptr ? ours->getRevision() != mesh.revision
                        : mesh.revision != 0 || !qcAreSame(shape->getLocalScaling(), mesh.scaling))
        return false;
    btVector3 lower, upper;
    shape->getAabb(mesh.place, lower, upper);
    return qcAreSame(lower, mesh.lower) && qcAreSame(upper, mesh.upper);
}

uint32_t qcRestingMeshes::IndexOf(const qcObjectKey& key) const
{
    const auto found = m_indices.find(key);
    return found != m_indices.end() ? found->second : s_none;
}

void qcRestingMeshes::BeginObjects()
{
    m_step++;
    m_foundCount = 0;
}

bool qcRestingMeshes::Rests(const btCollisionObject* object, size_t index, Objects* awake)
{
    const qcObjectKey key(object);
    if (index >= m_byObject.size())
        m_byObject.resize(index + 1, s_none);
    uint32_t& at = m_byObject[index];
    if (at >= m_meshes.size() || m_meshes[at].swept == nullptr || !(m_meshes[at].key == key))
        at = IndexOf(key);
    if (at == s_none)
        return false;
    Mesh& mesh = m_meshes[at];
    mesh.step = m_step;
    if (IsUnchanged(mesh, object))
    {
        m_foundCount += mesh.isAsleep;
        return mesh.isAsleep;
    }
    Wake(&mesh, awake);
    Forget(&mesh);
    return false;
}

void qcRestingMeshes::Add(qcSweptObject* swept)
{
    const qcObjectKey key(swept->object);
    uint32_t at = IndexOf(key);
    if (at != s_none && !IsUnchanged(m_meshes[at], swept->object))
    {
        Forget(&m_meshes[at]);
        at = s_none;
    }
    if (at == s_none)
    {
        at = uint32_t(m_meshes.size());
        m_indices[key] = at;
        const btCollisionShape* shape = swept->object->getCollisionShape();
        const qcMeshShape* ours = qcAsMeshShape(shape);
        Mesh mesh{key, swept, false, swept->object->getWorldTransform(), shape, 0, shape->getLocalScaling(), {}, {}, 0};
        mesh.revision = ours != nullptr ? ours->getRevision() : 0;
        shape->getAabb(mesh.place, mesh.lower, mesh.upper);
        m_meshes.push_back(mesh);
    }
    m_meshes[at].isAsleep = swept->rests = true;
    m_asleepCount++;
    m_oursCount += swept->isOurs;
}

/// Does nothing to one that is awake.
void qcRestingMeshes::Wake(Mesh* mesh, Objects* awake)
{
    if (!mesh->isAsleep)
        return;
    mesh->isAsleep = mesh->swept->rests = false;
    m_asleepCount--;
    m_oursCount -= mesh->swept->isOurs;
    awake->push_back(mesh->swept);
}

void qcRestingMeshes::Forget(Mesh* mesh)
{
    m_indices.erase(mesh->key);
    mesh->swept = nullptr;
    m_forgottenCount++;
}

void qcRestingMeshes::Forget(const qcObjectKey& key)
{
    const uint32_t at = IndexOf(key);
    if (at != s_none)
        Forget(&m_meshes[at]);
}

void qcRestingMeshes::WakeGone(Objects* awake)
{
    if (m_foundCount == m_asleepCount)
        return;
    for (Mesh& mesh : m_meshes)
        if (mesh.isAsleep && mesh.step != m_step)
        {
            Wake(&mesh, awake);
            Forget(&mesh);
        }
}

void qcRestingMeshes::WakeAll(Objects* awake)
{
    for (Mesh& mesh : m_meshes)
        if (mesh.swept != nullptr)
            Wake(&mesh, awake);
    m_meshes.clear();
    m_indices.clear();
    m_byWidth.clear();
    m_indexedCount = m_forgottenCount = 0;
}

void qcRestingMeshes::RemoveForgotten()
{
    auto isForgotten = [](const Mesh& mesh) { return mesh.swept == nullptr; };
    m_meshes.erase(std::remove_if(m_meshes.begin(), m_meshes.end(), isForgotten), m_meshes.end());
    for (size_t i = 0; i < m_meshes.size(); i++)
        m_indices[m_meshes[i].key] = uint32_t(i);
    m_byWidth.clear();
    m_indexedCount = m_forgottenCount = 0;
}

/// Indexes meshes that have come since the last call, once they are many.
void qcRestingMeshes::IndexLoose()
{
    if (m_forgottenCount > s_maxLoose && m_forgottenCount > m_meshes.size() / 2)
        RemoveForgotten();
    if (m_meshes.size() - m_indexedCount <= std::max(s_maxLoose, m_indexedCount / s_looseShare))
        return;
    m_byWidth.resize(size_t(s_maxExponent - s_minExponent) + 1);
    for (; m_indexedCount < m_meshes.size(); m_indexedCount++)
    {
        const Mesh& mesh = m_meshes[m_indexedCount];
        m_byWidth[WidthClassOf(mesh.lower, mesh.upper)].push_back({mesh.lower.x(), uint32_t(m_indexedCount)});
    }
    for (std::vector<Entry>& entries : m_byWidth)
        std::sort(entries.begin(), entries.end(),
                  [](const Entry& a, const Entry& b)
                  { return std::make_pair(a.lower, a.mesh) < std::make_pair(b.lower, b.mesh); });
}

void qcRestingMeshes::WakeNear(const btVector3& lower, const btVector3& upper, Objects* awake)
{
    if (m_asleepCount == 0)
        return;
    IndexLoose();
    auto wakeIfNear = [&](Mesh* mesh)
    {
        if (mesh->isAsleep && TestAabbAgainstAabb2(lower, upper, mesh->lower, mesh->upper))
            Wake(mesh, awake);
    };
    for (size_t i = 0; i < m_byWidth.size(); i++)
    {
        const std::vector<Entry>& entries = m_byWidth[i];
        const bool isUnbounded = i + 1 == m_byWidth.size();
        const double widest = isUnbounded ? HUGE_VAL : std::ldexp(1, int(i) + s_minExponent);
        auto isBefore = [](const Entry& entry, double x) { return double(entry.lower) < x; };
        auto next = std::lower_bound(entries.begin(), entries.end(), double(lower.x()) - widest, isBefore);
        for (; next != entries.end() && next->lower <= upper.x(); ++next)
            wakeIfNear(&m_meshes[next->mesh]);
    }
    for (size_t i = m_indexedCount; i < m_meshes.size(); i++)
        wakeIfNear(&m_meshes[i]);
}
