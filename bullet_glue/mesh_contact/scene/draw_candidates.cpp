// Debug drawing of a batch's candidates.
#include "mesh_contact/scene/draw_candidates.h"

#include "common/debug_draw.h"
#include "quickcullide/bullet_debug_draw.h"

#include <map>
#include <memory>

namespace
{
/// The present triangles of the meshes in a result, by slot.
class PresentMeshes
{
  public:
    explicit PresentMeshes(const qcBatchScene& scene)
    {
        const btCollisionObjectArray& objects = scene.GetSettings().world->getCollisionObjectArray();
        for (int i = 0; i < objects.size(); i++)
            if (qcMayHoldMeshes(objects[i]->getCollisionShape()))
                if (const qcBatchObject* gathered = scene.Find(objects[i]))
                    Add(*objects[i], *gathered);
    }

    /// Fills the corners of a triangle. False: its mesh has left or has changed.
    bool Find(uint32_t slot, uint32_t triangle, btVector3 corners[3])
    {
        auto found = m_meshes.find(slot);
        if (found == m_meshes.end())
            return false;
        Mesh& mesh = found->second;
        if (mesh.triangles == nullptr)
            mesh.triangles = std::make_unique<qcMeshTriangles>(mesh.shape, nullptr);
        if (triangle >= mesh.triangles->count)
            return false;
        for (size_t c = 0; c < 3; c++)
            corners[c] = mesh.transform * mesh.triangles->points[mesh.triangles->indices[3 * size_t(triangle) + c]];
        return true;
    }

  private:
    struct Mesh
    {
        const btCollisionShape* shape;
        btTransform transform;
        std::unique_ptr<qcMeshTriangles> triangles;
    };

    void Add(const btCollisionObject& object, const qcBatchObject& gathered)
    {
        std::vector<qcBatchMesh> present;
        qcCollectMeshes(object.getCollisionShape(), object.getWorldTransform(), &present);
        for (size_t i = 0; i < std::min(gathered.meshes.size(), present.size()); i++)
        {
            const qcBatchMesh& mesh = gathered.meshes[i];
            if (mesh.inScene && mesh.shape == present[i].shape && mesh.revision == qcMeshRevision(mesh.shape))
                m_meshes[mesh.id.slot] = {mesh.shape, present[i].transform, nullptr};
        }
    }

    std::map<uint32_t, Mesh> m_meshes;
};
} // namespace

void qcDrawCandidates(const qcBatchScene& scene, const qcResult& result, int modes, btIDebugDraw* drawer)
{
    PresentMeshes meshes(scene);
    btVector3 a[3], b[3];
    for (size_t i = 0; (modes & qc_drawPcs) != 0 && i < result.pcsCount; i++)
        if (meshes.Find(result.pcs[i].body, result.pcs[i].triangle, a))
            qcDrawCandidate(drawer, a[0], a[1], a[2]);
    for (size_t i = 0; (modes & qc_drawCandidates) != 0 && i < result.candidateCount; i++)
    {
        const qcCandidate& pair = result.candidates[i];
        if (meshes.Find(pair.bodyA, pair.triangleA, a) && meshes.Find(pair.bodyB, pair.triangleB, b))
            qcDrawCandidatePair(drawer, a, b);
    }
    drawer->flushLines();
}
