// Reads the shapes of rigid objects near soft bodies: qcMeshShapes, and the surfaces of Bullet's own shapes.
#ifndef QC_GLUE_SOFT_BODY_SCENE_RIGID_SHAPES_H
#define QC_GLUE_SOFT_BODY_SCENE_RIGID_SHAPES_H

#include "soft_body/scene/object_starts.h"
#include "soft_body/scene/rigid_overlaps.h"
#include "soft_body/scene/scene_rigid.h"

#include <memory>
#include <vector>

class qcRigidShapes
{
  public:
    explicit qcRigidShapes(const qcObjectStarts& starts) : m_starts(starts)
    {
    }

    /// The simple shapes of an object that have triangles, without their surfaces.
    static std::vector<qcSceneShape> ShapesOf(const btCollisionObject* object, bool withSurfaces);
    /// An object with its shapes that have triangles, and without meshes yet.
    static std::unique_ptr<qcSceneRigid> MakeRigid(const qcRigidOverlap& overlap);
    /// Finds the surfaces of an object's shapes near the soft bodies, and its meshes.
    void FindMeshes(qcSceneRigid* rigid, const qcRigidOverlap& overlap);
    /// True if the object's surfaces, where they were read by region, have what lies near the soft bodies.
    bool Cover(const qcSceneRigid& rigid, const qcRigidOverlap& overlap) const;
    /// See qcSurfaceCache.
    void Forget(const btCollisionShape* shape)
    {
        m_surfaces.Forget(shape);
    }
    void EndStep()
    {
        m_surfaces.EndStep();
    }

  private:
    void FindBox(const qcRigidOverlap& overlap, const btTransform& local, btVector3 box[2]) const;

    const qcObjectStarts& m_starts;
    qcSurfaceCache m_surfaces;
};

#endif
