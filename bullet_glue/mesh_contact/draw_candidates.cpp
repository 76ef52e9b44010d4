// Debug drawing of a batch's candidate triangles.
#include "mesh_contact/draw_candidates.h"

#include "common/debug_draw.h"

#include <algorithm>

namespace
{
void DrawMesh(const qcBatchMesh& mesh, const btTransform& transform, const qcResult& result, btIDebugDraw* drawer)
{
    auto [first, last] =
        std::equal_range(result.pcs, result.pcs + result.pcsCount, qcTriangleRef{mesh.id.slot, 0},
                         [](const qcTriangleRef& a, const qcTriangleRef& b) { return a.body < b.body; });
    if (first == last)
        return;
    qcMeshTriangles triangles(mesh.shape, nullptr);
    for (; first != last && first->triangle < triangles.count; ++first)
    {
        const uint32_t* corners = &triangles.indices[3 * size_t(first->triangle)];
        qcDrawCandidate(drawer, transform * triangles.points[corners[0]], transform * triangles.points[corners[1]],
                        transform * triangles.points[corners[2]]);
    }
}

void DrawObject(const btCollisionObject* object, const qcBatchObject& gathered, const qcResult& result,
                btIDebugDraw* drawer)
{
    std::vector<qcBatchMesh> present;
    qcCollectMeshes(object->getCollisionShape(), object->getWorldTransform(), &present);
    for (size_t i = 0; i < std::min(gathered.meshes.size(), present.size()); i++)
    {
        const qcBatchMesh& mesh = gathered.meshes[i];
        if (mesh.inScene && mesh.shape == present[i].shape && mesh.revision == qcMeshRevision(mesh.shape))
            DrawMesh(mesh, present[i].transform, result, drawer);
    }
}
} // namespace

void qcDrawCandidates(const qcBatchScene& scene, const qcResult& result, btIDebugDraw* drawer)
{
    const btCollisionObjectArray& objects = scene.GetSettings().world->getCollisionObjectArray();
    for (int i = 0; i < objects.size(); i++)
    {
        if (!qcMayHoldMeshes(objects[i]->getCollisionShape()))
            continue;
        if (const qcBatchObject* gathered = scene.Find(objects[i]))
            DrawObject(objects[i], *gathered, result, drawer);
    }
    drawer->flushLines();
}
