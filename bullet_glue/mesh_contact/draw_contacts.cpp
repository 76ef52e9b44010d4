// The candidate triangles of the batch's last query, as lines.
#include "mesh_contact/contact_batch.h"

#include "common/object_key.h"
#include "common/debug_draw.h"

#include <algorithm>

/// An object may have left the world, moved, or have another shape since the query: what is no longer as it was is left
/// out.
void qcMeshBatch::DrawObject(const btCollisionObject* object, btIDebugDraw* drawer) const
{
    auto found = m_objects.find(object);
    if (found == m_objects.end() || found->second.uniqueId != qcUniqueIdOf(object))
        return;
    std::vector<Mesh> present;
    CollectMeshes(object->getCollisionShape(), object->getWorldTransform(), &present);
    const std::vector<Mesh>& meshes = found->second.meshes;
    for (size_t i = 0; i < std::min(meshes.size(), present.size()); i++)
    {
        const Mesh& mesh = meshes[i];
        if (!mesh.inScene || mesh.shape != present[i].shape || mesh.revision != qcMeshRevision(present[i].shape))
            continue;
        auto [first, last] =
            std::equal_range(m_result->pcs, m_result->pcs + m_result->pcsCount, qcTriangleRef{mesh.id.slot, 0},
                             [](const qcTriangleRef& a, const qcTriangleRef& b) { return a.body < b.body; });
        if (first == last)
            continue;
        qcMeshTriangles triangles(mesh.shape, nullptr);
        for (; first != last && first->triangle < triangles.count; ++first)
        {
            const uint32_t* corners = &triangles.indices[3 * size_t(first->triangle)];
            const btTransform& place = present[i].transform;
            qcDrawCandidate(drawer, place * triangles.points[corners[0]], place * triangles.points[corners[1]],
                            place * triangles.points[corners[2]]);
        }
    }
}

void qcMeshBatch::Draw(btIDebugDraw* drawer)
{
    std::lock_guard<std::mutex> lock(m_mutex);
    if (m_result == nullptr)
        return;
    const btCollisionObjectArray& objects = world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
        if (qcMayHoldMeshes(objects[i]->getCollisionShape()))
            DrawObject(objects[i], drawer);
    drawer->flushLines();
}
