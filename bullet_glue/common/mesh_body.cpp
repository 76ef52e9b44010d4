// A mesh of an object as a body of a scene, rigid or deforming.
#include "common/mesh_body.h"

#include "common/object_key.h"
#include "common/shape_triangles.h"
#include "common/vertex_box.h"
#include "quickcullide/bullet_positions.h"

#include <algorithm>

namespace
{
std::vector<btVector3> Transformed(const btTransform& transform, const btVector3* vertices, size_t count)
{
    std::vector<btVector3> transformed(vertices, vertices + count);
    for (btVector3& vertex : transformed)
        vertex = transform * vertex;
    return transformed;
}

/// True if no vertex is further from where it was than half the diagonal of the box.
bool AreNear(const btVector3* from, const btVector3* to, size_t count, const btVector3 box[2])
{
    const btScalar maxSquared = (box[1] - box[0]).length2() / 4;
    return std::equal(to, to + count, from,
                      [maxSquared](const btVector3& now, const btVector3& last)
                      { return now.distance2(last) <= maxSquared; });
}
} // namespace

void qcMeshBody::DeformFrom(const qcMeshBody& last, const btVector3* from, const btVector3* to, size_t count)
{
    if (trianglesHash == 0 || last.trianglesHash != trianglesHash || !qcAreSame(last.local, local))
        return;
    btVector3 box[2];
    qcFindBox(from, count, box);
    if (!AreNear(from, to, count, box))
        return;
    startVertices.assign(from, from + count);
    startBox[0] = box[0];
    startBox[1] = box[1];
}

qcStatus qcMeshBody::AddBody(qcScene* scene, qcBodyDef def, const btTransform& transform, bool isDeforming)
{
    sceneTransform = transform;
    if (!isDeforming)
        return qcScene_AddBody(scene, &def, &id);
    const std::vector<btVector3> world =
        Transformed(transform, static_cast<const btVector3*>(def.positions), def.vertexCount);
    def.positions = world.data();
    def.transform = qcTransformOf(btTransform::getIdentity());
    def.deforming = true;
    return qcScene_AddBody(scene, &def, &id);
}

qcStatus qcMeshBody::MoveBody(qcScene* scene, const btTransform& transform)
{
    // Large compounds have thousands of cores, most of which stay.
    if (qcAreSame(sceneTransform, transform))
        return qc_statusOk;
    const qcTransform converted = qcTransformOf(transform);
    const qcStatus status = qcScene_SetTransform(scene, id, &converted);
    if (status == qc_statusOk)
        sceneTransform = transform;
    return status;
}

qcStatus qcMeshBody::SetVertices(qcScene* scene, const btTransform& transform, const btVector3* vertices, size_t count)
{
    const std::vector<btVector3> world = Transformed(transform, vertices, count);
    const qcStatus status = qcScene_SetVertices(scene, id, world.data(), qcBulletPositions, sizeof(btVector3));
    if (status == qc_statusOk)
        sceneTransform = transform;
    return status;
}
