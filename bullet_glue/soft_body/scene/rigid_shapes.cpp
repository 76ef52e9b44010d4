// The shapes of rigid objects near soft bodies, as meshes.
#include "soft_body/scene/rigid_shapes.h"

#include "common/compound_children.h"
#include "common/object_key.h"
#include "common/shape_triangles.h"

namespace
{
/// The box around a box of world space in a frame.
void ToFrame(const btTransform& frame, const btVector3 box[2], btVector3 local[2])
{
    const btTransform inverse = frame.inverse();
    const btVector3 center = inverse * ((box[0] + box[1]) / 2), half = (box[1] - box[0]) / 2;
    const btVector3 extent =
        half.dot3(inverse.getBasis()[0].absolute(), inverse.getBasis()[1].absolute(), inverse.getBasis()[2].absolute());
    local[0] = center - extent;
    local[1] = center + extent;
}
} // namespace

std::vector<qcSceneShape> qcRigidShapes::ShapesOf(const btCollisionObject* object, bool withSurfaces)
{
    std::vector<qcSceneShape> shapes;
    withSurfaces = withSurfaces && object->hasContactResponse();
    auto add = [&](const btCollisionShape* simple, const btTransform& local)
    {
        const qcMeshShape* mesh = qcAsMeshShape(simple);
        bool isUsed = mesh != nullptr ? mesh->getTriangleCount() > 0 : withSurfaces && qcHasSurface(simple);
        if (!isUsed)
            return;
        shapes.emplace_back();
        shapes.back().shape = simple;
        shapes.back().local = local;
        shapes.back().revision = qcSurfaceCache::RevisionOf(simple);
    };
    qcForEachSimpleShape(object->getCollisionShape(), btTransform::getIdentity(), add);
    return shapes;
}

/// The box around the soft bodies near an object over the step, in the frame of a shape of the object.
void qcRigidShapes::FindBox(const qcRigidOverlap& overlap, const btTransform& local, btVector3 box[2]) const
{
    btVector3 start[2];
    ToFrame(overlap.object->getWorldTransform() * local, overlap.box, box);
    ToFrame(m_starts.StartOf(overlap.object) * local, overlap.box, start);
    box[0].setMin(start[0]);
    box[1].setMax(start[1]);
}

bool qcRigidShapes::Cover(const qcSceneRigid& rigid, const qcRigidOverlap& overlap) const
{
    for (const qcSceneShape& shape : rigid.shapes)
    {
        btVector3 box[2];
        if (shape.surface == nullptr || shape.surface->isWhole)
            continue;
        FindBox(overlap, shape.local, box);
        if (!shape.surface->Covers(box))
            return false;
    }
    return true;
}

void qcRigidShapes::FindMeshes(qcSceneRigid* rigid, const qcRigidOverlap& overlap)
{
    for (size_t i = 0; i < rigid->shapes.size(); i++)
    {
        qcSceneShape& shape = rigid->shapes[i];
        qcSceneMesh mesh;
        mesh.shape = qcAsMeshShape(shape.shape);
        mesh.isSurface = mesh.shape == nullptr;
        if (mesh.isSurface)
        {
            btVector3 box[2];
            FindBox(overlap, shape.local, box);
            shape.surface = m_surfaces.Find(shape.shape, shape.revision, rigid->object, box,
                                            [this](const qcObjectKey& key) { return m_starts.Has(key); });
            mesh.shape = shape.surface->mesh.get();
            mesh.isConvex = shape.surface->isConvex;
            mesh.inside = shape.local * shape.surface->inside;
        }
        mesh.local = shape.local;
        mesh.index = i;
        if (mesh.shape == nullptr)
            continue;
        mesh.ReadShape(shape.surface.get());
        rigid->meshes.push_back(std::move(mesh));
    }
}

std::unique_ptr<qcSceneRigid> qcRigidShapes::MakeRigid(const qcRigidOverlap& overlap)
{
    std::unique_ptr<qcSceneRigid> rigid(new qcSceneRigid);
    rigid->object = overlap.object;
    rigid->uniqueId = qcUniqueIdOf(overlap.object);
    rigid->withSurfaces = overlap.withSurfaces;
    rigid->shapes = ShapesOf(overlap.object, overlap.withSurfaces);
    return rigid;
}
