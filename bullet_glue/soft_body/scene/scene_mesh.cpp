// A mesh of a rigid object near soft bodies, in a scene.
#include "soft_body/scene/scene_mesh.h"

#include "common/shape_triangles.h"
#include "common/weld_vertices.h"
#include "quickcullide/bullet_positions.h"
#include "quickcullide/hash.h"

namespace
{
std::vector<btVector3> Transformed(const btTransform& transform, const std::vector<btVector3>& vertices)
{
    std::vector<btVector3> transformed(vertices);
    for (btVector3& vertex : transformed)
        vertex = transform * vertex;
    return transformed;
}
} // namespace

btVector3 qcSceneMesh::DeformationAt(const uint32_t corners[3], const double weights[3]) const
{
    btVector3 motion(0, 0, 0);
    for (int i = 0; Deforms() && i < 3; i++)
        motion += btScalar(weights[i]) * (vertices[corners[i]] - startVertices[corners[i]]);
    return local.getBasis() * motion;
}

std::vector<uint32_t> qcSceneMesh::WeldedIndices() const
{
    std::vector<uint32_t> first = qcFirstAtPosition(vertices.data(), uint32_t(vertices.size()));
    if (Deforms())
    {
        const std::vector<uint32_t> atStart = qcFirstAtPosition(startVertices.data(), uint32_t(startVertices.size()));
        for (uint32_t i = 0; i < first.size(); i++)
            if (atStart[i] != first[i])
                first[i] = i;
    }
    std::vector<uint32_t> indices(shape->getIndices(), shape->getIndices() + 3 * size_t(shape->getTriangleCount()));
    for (uint32_t& corner : indices)
        corner = first[corner];
    return indices;
}

void qcSceneMesh::ReadShape(const qcShapeSurface* surface)
{
    vertices.assign(shape->getVertices(), shape->getVertices() + shape->getVertexCount());
    box[0] = box[1] = vertices.front();
    for (const btVector3& vertex : vertices)
    {
        box[0].setMin(vertex);
        box[1].setMax(vertex);
    }
    if (surface == nullptr || surface->sourcesHash != 0)
        trianglesHash = qcXxh64(shape->getIndices(), 3 * size_t(shape->getTriangleCount()) * sizeof(uint32_t),
                                surface != nullptr ? surface->sourcesHash : 0);
}

void qcSceneMesh::DeformFrom(const qcSceneMesh& last)
{
    if (trianglesHash == 0 || last.index != index || !(last.local == local) || last.trianglesHash != trianglesHash ||
        last.vertices.size() != vertices.size())
        return;
    const btScalar most = (last.box[1] - last.box[0]).length2() / 4;
    for (size_t i = 0; i < vertices.size(); i++)
        if (vertices[i].distance2(last.vertices[i]) > most)
            return;
    startVertices = last.vertices;
    startBox[0] = last.box[0];
    startBox[1] = last.box[1];
}

qcStatus qcSceneMesh::AddTo(qcScene* scene, qcActivity activity)
{
    const std::vector<uint32_t> indices = WeldedIndices();
    std::vector<btVector3> deformed;
    qcBodyDef def = qcMeshBodyDef(vertices.data(), uint32_t(vertices.size()), indices.data(),
                                  uint32_t(indices.size() / 3), sceneTransform, activity);
    if (Deforms())
    {
        deformed = Transformed(sceneTransform, vertices);
        def.positions = deformed.data();
        def.transform = qcTransformOf(btTransform::getIdentity());
        def.deforming = true;
    }
    def.group = isSurface ? qcSurfaceGroup : qcMeshGroup;
    def.mask = qcSoftGroup;
    return qcScene_AddBody(scene, &def, &id);
}

qcStatus qcSceneMesh::Place(qcScene* scene, const btTransform& transform, bool atStart)
{
    atStart = atStart && Deforms();
    if (sceneTransform == transform && isAtStart == atStart)
        return qc_statusOk;
    qcStatus status;
    if (Deforms())
    {
        const std::vector<btVector3> deformed = Transformed(transform, atStart ? startVertices : vertices);
        status = qcScene_SetVertices(scene, id, deformed.data(), qcBulletPositions, sizeof(btVector3));
    }
    else
    {
        const qcTransform converted = qcTransformOf(transform);
        status = qcScene_SetTransform(scene, id, &converted);
    }
    if (status != qc_statusOk)
        return status;
    sceneTransform = transform;
    isAtStart = atStart;
    return qc_statusOk;
}
