// Rigid objects with meshes near soft bodies.
#include "soft_body/scene/rigid_overlaps.h"

#include "common/multibody_joints.h"
#include "common/object_motion.h"
#include "common/shape_triangles.h"
#include "soft_body/scene/objects_in_box.h"
#include "soft_body/scene/shape_surface.h"

#include <BulletCollision/BroadphaseCollision/btBroadphaseInterface.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <LinearMath/btAabbUtil2.h>

#include <algorithm>
#include <unordered_set>

namespace
{
// Up to so many objects are compared with a soft body's box one by one. A query of the broadphase, which has the other
// soft bodies too, takes as long as some 200 comparisons (qc-bench soft --demos, 256 sticks).
constexpr size_t s_maxCompared = 64;

/// True if the object may have meshes.
bool MayHaveMeshes(const btCollisionObject* object, bool withSurfaces)
{
    const btCollisionShape* shape = object->getCollisionShape();
    return shape->isCompound() || qcAsMeshShape(shape) != nullptr || (withSurfaces && qcHasSurface(shape));
}
} // namespace

void qcRigidOverlaps::Begin(const qcObjectStarts& starts)
{
    m_candidates.clear();
    for (const qcObjectStarts::Present& present : starts.Objects())
        if (MayHaveMeshes(present.object, true))
            m_candidates.push_back(present);
    m_boxes.clear();
}

void qcRigidOverlaps::Collect(const qcObjectStarts& starts, btBroadphaseInterface* broadphase, const btVector3& lower,
                              const btVector3& upper, bool withSurfaces)
{
    m_boxes.push_back({lower, upper});
    auto add = [&](btCollisionObject* object)
    {
        if (MayHaveMeshes(object, withSurfaces) && qcIsFinite(*object))
            m_overlaps.push_back({object, withSurfaces, {lower, upper}});
    };
    if (m_candidates.size() > s_maxCompared)
        qcForEachObjectIn(broadphase, lower, upper, add);
    else
        for (const qcObjectStarts::Present& present : m_candidates)
        {
            const btBroadphaseProxy* proxy = present.object->getBroadphaseHandle();
            if (present.broadphase == broadphase &&
                TestAabbAgainstAabb2(proxy->m_aabbMin, proxy->m_aabbMax, lower, upper))
                add(present.object);
        }
    starts.ForEachMoved(lower, upper, add);
}

void qcRigidOverlaps::Merge()
{
    auto isBefore = [](const qcRigidOverlap& a, const qcRigidOverlap& b)
    { return qcUniqueIdOf(a.object) < qcUniqueIdOf(b.object); };
    std::stable_sort(m_overlaps.begin(), m_overlaps.end(), isBefore);
    size_t count = 0;
    for (const qcRigidOverlap& overlap : m_overlaps)
    {
        // Objects of two broadphases may have one id.
        size_t same = count;
        while (same > 0 && !isBefore(m_overlaps[same - 1], overlap) && m_overlaps[same - 1].object != overlap.object)
            same--;
        if (same == 0 || m_overlaps[same - 1].object != overlap.object)
        {
            m_overlaps[count++] = overlap;
            continue;
        }
        qcRigidOverlap& merged = m_overlaps[same - 1];
        merged.withSurfaces = merged.withSurfaces || overlap.withSurfaces;
        merged.box[0].setMin(overlap.box[0]);
        merged.box[1].setMax(overlap.box[1]);
    }
    m_overlaps.resize(count);
}

bool qcRigidOverlaps::IsNear(const btVector3 box[2]) const
{
    return std::any_of(m_boxes.begin(), m_boxes.end(),
                       [box](const std::array<btVector3, 2>& other)
                       { return TestAabbAgainstAabb2(box[0], box[1], other[0], other[1]); });
}

bool qcRigidOverlaps::Has(const btCollisionObject* object) const
{
    const int id = qcUniqueIdOf(object);
    auto isBefore = [](const qcRigidOverlap& overlap, int other) { return qcUniqueIdOf(overlap.object) < other; };
    auto overlap = std::lower_bound(m_overlaps.begin(), m_overlaps.end(), id, isBefore);
    while (overlap != m_overlaps.end() && overlap->object != object && qcUniqueIdOf(overlap->object) == id)
        ++overlap;
    return overlap != m_overlaps.end() && overlap->object == object;
}

void qcRigidOverlaps::Add(const std::vector<qcRigidOverlap>& overlaps)
{
    if (overlaps.empty())
        return;
    m_overlaps.insert(m_overlaps.end(), overlaps.begin(), overlaps.end());
    Merge();
}

void qcRigidOverlaps::AddLinks()
{
    std::vector<qcRigidOverlap> added;
    std::unordered_set<const btCollisionObject*> others;
    for (const qcRigidOverlap& overlap : m_overlaps)
    {
        const btMultiBodyLinkCollider* link = qcAsLink(overlap.object);
        for (int k = -1; link != nullptr && k < link->m_multiBody->getNumLinks(); k++)
        {
            btMultiBody& multibody = *link->m_multiBody;
            btMultiBodyLinkCollider* other = k < 0 ? multibody.getBaseCollider() : multibody.getLinkCollider(k);
            if (other != nullptr && other->getBroadphaseHandle() != nullptr &&
                MayHaveMeshes(other, overlap.withSurfaces) && qcIsFinite(*other) && !Has(other) &&
                others.insert(other).second)
            {
                added.push_back(overlap);
                added.back().object = other;
            }
        }
    }
    Add(added);
}
