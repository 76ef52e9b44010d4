// A mesh of an object in the scene of motions.
#include "mesh_contact/swept_mesh.h"

#include "common/moved_vertices.h"
#include "quickcullide/hash.h"

qcSweptMesh::qcSweptMesh(const btCollisionShape* read, const btTransform& place, bool keeps)
    : shape(read), local(place), revision(qcMeshRevision(read)), triangles(new qcMeshTriangles(read, nullptr))
{
    if (!keeps || triangles->pointCount == 0)
        return;
    if (qcAsMeshShape(read) == nullptr)
    {
        const std::vector<qcTriangleSource>& sources = triangles->sources;
        trianglesHash = qcXxh64(sources.data(), sources.size() * sizeof(qcTriangleSource), 0);
        return;
    }
    kept.assign(triangles->points, triangles->points + triangles->pointCount);
    trianglesHash = qcXxh64(triangles->indices, 3 * size_t(triangles->count) * sizeof(uint32_t), 0);
}

void qcSweptMesh::DeformFrom(qcSweptMesh* last)
{
    const size_t count = triangles->pointCount;
    if (trianglesHash == 0 || last->trianglesHash != trianglesHash || last->triangles->pointCount != count ||
        !(last->local == local))
        return;
    const btVector3* points = last->kept.empty() ? last->triangles->points : last->kept.data();
    btVector3 box[2];
    qcFindBox(points, count, box);
    if (!qcHaveMoved(points, triangles->points, count, box))
        return;
    startPoints.assign(points, points + count);
    startBox[0] = box[0];
    startBox[1] = box[1];
    if (last->isDeforming)
    {
        std::swap(id, last->id);
        isDeforming = true;
    }
}

qcStatus qcSweptMesh::AddTo(qcScene* scene, const btTransform& object, uint32_t owner)
{
    qcBodyDef def = qcMeshBodyDef(triangles->points, triangles->pointCount, triangles->indices, triangles->count,
                                  object * local, qc_activityMoving);
    def.owner = owner;
    isDeforming = Deforms();
    return isDeforming ? qcAddDeforming(scene, def, object * local, &id) : qcScene_AddBody(scene, &def, &id);
}

void qcSweptMesh::RemoveFrom(qcScene* scene)
{
    if (id.generation != 0)
        qcScene_RemoveBody(scene, id);
    id = qcBodyId{};
}

qcStatus qcSweptMesh::Place(qcScene* scene, const btTransform& object, bool atStart) const
{
    const btTransform place = object * local;
    if (isDeforming)
    {
        const btVector3* points = atStart && Deforms() ? startPoints.data() : triangles->points;
        return qcSetDeforming(scene, id, place, points, triangles->pointCount);
    }
    const qcTransform transform = qcTransformOf(place);
    return qcScene_SetTransform(scene, id, &transform);
}

std::vector<qcBatchMesh> qcCollectSwept(const btCollisionShape* shape, qcConvexCores* cores)
{
    std::vector<qcBatchMesh> swept;
    qcCollectMeshes(shape, btTransform::getIdentity(), &swept);
    auto addCore = [&swept](const qcConvexCore& core, const btTransform& place)
    { qcCollectMeshes(core.mesh.get(), place, &swept); };
    if (cores != nullptr)
        cores->ForEachCore(shape, addCore);
    return swept;
}

std::vector<qcSweptMesh> qcReadSweptMeshes(const std::vector<qcBatchMesh>& present, bool keeps)
{
    std::vector<qcSweptMesh> meshes;
    for (const qcBatchMesh& mesh : present)
        meshes.emplace_back(mesh.shape, mesh.transform, keeps);
    return meshes;
}
