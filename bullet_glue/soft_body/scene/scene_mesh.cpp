// A mesh of a rigid object near soft bodies, in a scene.
#include "soft_body/scene/scene_mesh.h"

#include "common/object_key.h"
#include "common/shape_triangles.h"
#include "common/vertex_box.h"
#include "common/weld_vertices.h"
#include "quickcullide/hash.h"

namespace
{
// Steps for which a mesh stays a deforming body after its vertices have moved: applications may move them in every
// second or third step.
constexpr int s_restingSteps = 30;
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
    std::vector<uint32_t> indices(shape->getIndices(), shape->getIndices() + 3 * size_t(shape->getTriangleCount()));
    for (uint32_t& corner : indices)
        corner = firstVertices[corner];
    return indices;
}

/// Finds the vertices that are made one.
void qcSceneMesh::Weld()
{
    firstVertices = qcFirstAtPosition(vertices.data(), uint32_t(vertices.size()));
    if (!Deforms())
        return;
    const std::vector<uint32_t> atStart = qcFirstAtPosition(startVertices.data(), uint32_t(startVertices.size()));
    for (uint32_t i = 0; i < firstVertices.size(); i++)
        if (atStart[i] != firstVertices[i])
            firstVertices[i] = i;
}

void qcSceneMesh::ReadShape(const qcShapeSurface* surface)
{
    vertices.assign(shape->getVertices(), shape->getVertices() + shape->getVertexCount());
    qcFindBox(vertices.data(), vertices.size(), box);
    if (surface == nullptr || surface->sourcesHash != 0)
        trianglesHash = qcXxh64(shape->getIndices(), 3 * size_t(shape->getTriangleCount()) * sizeof(uint32_t),
                                surface != nullptr ? surface->sourcesHash : 0);
}

void qcSceneMesh::DeformFrom(const qcSceneMesh& last)
{
    if (last.index == index && last.vertices.size() == vertices.size())
        qcMeshBody::DeformFrom(last, last.vertices.data(), vertices.data(), vertices.size());
}

void qcSceneMesh::TakeBody(qcSceneMesh* last)
{
    bool isSame = Deforms() && last->Deforms() && !last->isAtStart && last->index == index &&
                  last->firstVertices.size() == vertices.size();
    for (uint32_t i = 0; isSame && i < vertices.size(); i++)
        isSame = qcAreSame(vertices[i], vertices[last->firstVertices[i]]);
    if (!isSame)
        return;
    std::swap(id, last->id);
    firstVertices.swap(last->firstVertices);
    sceneTransform = last->sceneTransform;
    isAtStart = true;
}

bool qcSceneMesh::Rest()
{
    if (restingSteps == 0)
    {
        startVertices = vertices;
        startBox[0] = box[0];
        startBox[1] = box[1];
    }
    return ++restingSteps <= s_restingSteps;
}

qcStatus qcSceneMesh::AddTo(qcScene* scene, const btTransform& transform, qcActivity activity)
{
    Weld();
    const std::vector<uint32_t> indices = WeldedIndices();
    qcBodyDef def = qcMeshBodyDef(vertices.data(), uint32_t(vertices.size()), indices.data(),
                                  uint32_t(indices.size() / 3), transform, activity);
    def.group = isSurface ? qcSurfaceGroup : qcMeshGroup;
    def.mask = qcSoftGroup;
    return AddBody(scene, def, transform, Deforms());
}

qcStatus qcSceneMesh::Place(qcScene* scene, const btTransform& transform, bool atStart)
{
    if (!Deforms())
        return MoveBody(scene, transform);
    atStart = atStart && restingSteps == 0;
    if (qcAreSame(sceneTransform, transform) && isAtStart == atStart)
        return qc_statusOk;
    const qcStatus status = SetVertices(scene, transform, (atStart ? startVertices : vertices).data(), vertices.size());
    if (status == qc_statusOk)
        isAtStart = atStart;
    return status;
}
