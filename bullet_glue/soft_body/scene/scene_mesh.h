// A mesh of a rigid object near soft bodies. Where the application has moved its vertices, it deforms in the step.
#ifndef QC_GLUE_SOFT_BODY_SCENE_SCENE_MESH_H
#define QC_GLUE_SOFT_BODY_SCENE_SCENE_MESH_H

#include "common/mesh_body.h"
#include "soft_body/scene/shape_surface.h"

#include "quickcullide/scene.h"

#include <LinearMath/btTransform.h>

#include <algorithm>
#include <memory>
#include <vector>

/// Filter groups of the scene: soft bodies collide with each other, with qcMeshShapes and, if their settings say so,
/// with the surfaces of Bullet's own shapes; rigid ones with soft bodies only.
constexpr uint32_t qcSoftGroup = 1, qcMeshGroup = 2, qcSurfaceGroup = 4;

/// A simple shape of an object. A compound may have several.
struct qcSceneShape
{
    const btCollisionShape* shape = nullptr;
    btTransform local = btTransform::getIdentity(); ///< from the shape's frame to the object's
    uint64_t revision = 0;                          ///< of the shape, when it was added to the scene
    std::shared_ptr<const qcShapeSurface> surface;  ///< null for a qcMeshShape
};

/// The triangles of a simple shape.
struct qcSceneMesh : qcMeshBody
{
    const qcMeshShape* shape = nullptr; ///< of the object, or the surface of one of its shapes
    bool isSurface = false;
    size_t index = 0;          ///< of the shape among those of the object
    bool isConvex = false;     ///< a closed convex surface
    btVector3 inside{0, 0, 0}; ///< a point inside of it, in the object's frame

    //  In the shape's frame, as read from it; the shape itself may be gone in the next step.
    std::vector<btVector3> vertices;
    btVector3 box[2]; ///< around them: lower and upper corner

    //  A mesh whose vertices the application has moved is a deforming body of the scene, until they have rested for a
    //  while.
    std::vector<uint32_t> firstVertices; ///< for each vertex the one that takes its place in the scene
    int restingSteps = 0;                ///< since its vertices have moved
    bool isAtStart = false;              ///< in the scene: it has its vertices of the start

    /// A vertex at the start of the step, in the shape's frame.
    const btVector3& StartVertex(uint32_t vertex) const
    {
        return Deforms() ? startVertices[vertex] : shape->getVertices()[vertex];
    }
    /// How far the point of a triangle with these weights has moved in the step, in the object's frame, by deformation.
    btVector3 DeformationAt(const uint32_t corners[3], const double weights[3]) const;
    /// Its indices with vertices at the same position, at the start and at the end of the step, made one: contacts at
    /// corners and edges that triangles share are found once.
    std::vector<uint32_t> WeldedIndices() const;
    /// Reads what the mesh keeps of `shape`; `surface`: null for a qcMeshShape.
    void ReadShape(const qcShapeSurface* surface);
    /// See qcMeshBody.
    void DeformFrom(const qcSceneMesh& last);
    /// Takes over the body in the scene of a mesh from which this one deforms, if that is a deforming one with the same
    /// vertices made one.
    void TakeBody(qcSceneMesh* last);
    /// A mesh that deforms begins a step in which its vertices rest. False: it has rested for so long that it should be
    /// a rigid body again.
    bool Rest();
    qcStatus AddTo(qcScene* scene, const btTransform& transform, qcActivity activity);
    /// Sets its transform, and its vertices if it deforms.
    qcStatus Place(qcScene* scene, const btTransform& transform, bool atStart);

    /// Distance from the triangles at which a soft body of this thickness is kept. The margin of a surface is bounded:
    /// all queries for contacts look as far as the largest distance, also those of the body with itself. With half the
    /// thickness links pull ten times as many nodes through the surface in a step.
    btScalar ContactDistance(btScalar thickness) const
    {
        btScalar margin = shape->getMargin();
        return thickness / 2 + (isSurface ? std::min(margin, thickness) : margin);
    }

  private:
    void Weld();
};

#endif
