// A mesh of an object in the scene of motions.
#include "mesh_contact/limits/swept_mesh.h"

#include "common/vertex_box.h"
#include "quickcullide/hash.h"

#include <LinearMath/btAabbUtil2.h>

#include <algorithm>

qcSweptMesh::qcSweptMesh(const qcSweptSource& source, bool keeps)
    : part(source.part), shape(source.mesh.shape), revision(qcMeshRevision(shape)),
      triangles(new qcMeshTriangles(shape, nullptr))
{
    local = source.mesh.transform;
    if (part != qcSweptPart::mesh)
        qcFindBox(triangles->points, triangles->pointCount, coreBox);
    if (!keeps || triangles->pointCount == 0)
        return;
    if (qcAsMeshShape(shape) == nullptr)
    {
        const std::vector<qcTriangleSource>& sources = triangles->sources;
        trianglesHash = qcXxh64(sources.data(), sources.size() * sizeof(qcTriangleSource), 0);
        return;
    }
    kept.assign(triangles->points, triangles->points + triangles->pointCount);
    trianglesHash = qcXxh64(triangles->indices, 3 * size_t(triangles->count) * sizeof(uint32_t), 0);
}

bool qcSweptMesh::Encloses(const btVector3& point) const
{
    if (!TestPointAgainstAabb2(coreBox[0], coreBox[1], point))
        return false;
    const btVector3* points = triangles->points;
    btVector3 centre(0, 0, 0);
    btScalar radius = 0;
    for (uint32_t i = 0; i < triangles->pointCount; i++)
    {
        centre += points[i] / btScalar(triangles->pointCount);
        radius = std::max(radius, points[i].length());
    }
    for (uint32_t t = 0; t < triangles->count; t++)
    {
        const uint32_t* index = triangles->indices + 3 * size_t(t);
        const btVector3& corner = points[index[0]];
        const btVector3 ab = points[index[1]] - corner, ac = points[index[2]] - corner, normal = ab.cross(ac);
        // The normal of a sliver is made of the rounding of its corners.
        const btScalar rounding = 4 * SIMD_EPSILON * radius * (ab.length() + ac.length());
        const btScalar height = normal.dot(point - corner);
        const bool isInside = normal.dot(centre - corner) > 0 ? height > 0 : height < 0;
        if (!isInside && normal.length() > rounding)
            return false;
    }
    return true;
}

void qcSweptMesh::DeformFrom(qcSweptMesh* last)
{
    if (last->triangles->pointCount != triangles->pointCount)
        return;
    const btVector3* from = last->kept.empty() ? last->triangles->points : last->kept.data();
    qcMeshBody::DeformFrom(*last, from, triangles->points, triangles->pointCount);
    if (Deforms() && last->isDeforming)
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
    return AddBody(scene, def, object * local, isDeforming);
}

void qcSweptMesh::RemoveFrom(qcScene* scene)
{
    if (id.generation != 0)
        qcScene_RemoveBody(scene, id);
    id = qcBodyId{};
}

qcStatus qcSweptMesh::Place(qcScene* scene, const btTransform& object, bool atStart)
{
    const btTransform place = object * local;
    if (!isDeforming)
        return MoveBody(scene, place);
    const btVector3* points = atStart && Deforms() ? startVertices.data() : triangles->points;
    return SetVertices(scene, place, points, triangles->pointCount);
}

qcSweptSource qcMakeSweptSource(const btCollisionShape* mesh, const btTransform& place, qcSweptPart part)
{
    qcSweptSource source;
    source.mesh.shape = mesh;
    source.mesh.transform = place;
    source.part = part;
    return source;
}

std::vector<qcSweptMesh> qcReadSweptMeshes(const btCollisionShape* shape)
{
    std::vector<qcSweptMesh> meshes;
    qcForEachSwept(shape, nullptr, nullptr,
                   [&meshes](const btCollisionShape* mesh, const btTransform& place, qcSweptPart part)
                   { meshes.emplace_back(qcMakeSweptSource(mesh, place, part), true); });
    return meshes;
}
