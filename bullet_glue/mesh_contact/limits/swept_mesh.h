// A mesh of an object in the scene of motions. Where the application has moved its triangles, it deforms in the step.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MESH_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_MESH_H

#include "common/compound_children.h"
#include "common/mesh_body.h"
#include "common/shape_triangles.h"
#include "mesh_contact/limits/convex_cores.h"
#include "mesh_contact/scene/batch_scene.h"

#include <memory>

/// Which triangles of an object a mesh has.
enum class qcSweptPart : uint8_t
{
    mesh,
    core,
    innerCore ///< takes the core's place in pairs whose other object the core is in
};

/// A mesh that is to be read.
struct qcSweptSource
{
    qcBatchMesh mesh;
    qcSweptPart part;
};

struct qcSweptMesh : qcMeshBody
{
    qcSweptPart part;
    const btCollisionShape* shape;
    uint64_t revision; ///< of the shape when the mesh was read; see qcMeshRevision
    /// In the scene it is a deforming body, and stays one after its triangles have been moved.
    bool isDeforming = false;
    std::unique_ptr<qcMeshTriangles> triangles;
    std::vector<btVector3> kept; ///< the points of a qcMeshShape, which may be gone in the next step
    btVector3 coreBox[2];        ///< of a core, around its points

    /// `keeps`: it may deform in a later step.
    qcSweptMesh(const qcSweptSource& source, bool keeps);

    /// A corner of a triangle in the mesh's frame, at the start or at the end of the step.
    const btVector3& PointOf(uint32_t triangle, size_t corner, bool atStart) const
    {
        const uint32_t index = triangles->indices[3 * size_t(triangle) + corner];
        return atStart && Deforms() ? startVertices[index] : triangles->points[index];
    }
    /// True if a point in its frame is inside of a core.
    bool Encloses(const btVector3& point) const;
    /// See qcMeshBody. Takes over the body of `last` if that is a deforming one.
    void DeformFrom(qcSweptMesh* last);

    /// `object`: the transform of its object; `owner`: see qcBodyDef.
    qcStatus AddTo(qcScene* scene, const btTransform& object, uint32_t owner);
    void RemoveFrom(qcScene* scene);
    qcStatus Place(qcScene* scene, const btTransform& object, bool atStart);
};

/// Calls function(shape, transform, part) for the meshes of a shape and, unless these are null, the cores and inner
/// cores of its convex shapes. `transform`: from the frame of the mesh to that of the shape.
template <typename Function>
void qcForEachSwept(const btCollisionShape* shape, qcConvexCores* cores, qcConvexCores* innerCores,
                    const Function& function)
{
    auto addMesh = [&function](const btCollisionShape* mesh, const btTransform& place)
    {
        if (qcIsMesh(mesh))
            function(mesh, place, qcSweptPart::mesh);
    };
    qcForEachSimpleShape(shape, btTransform::getIdentity(), addMesh);
    for (auto [from, part] :
         {std::make_pair(cores, qcSweptPart::core), std::make_pair(innerCores, qcSweptPart::innerCore)})
        if (from != nullptr)
            from->ForEachCore(shape, [&function, part = part](const qcConvexCore& core, const btTransform& place)
                              { function(core.mesh.get(), place, part); });
}
qcSweptSource qcMakeSweptSource(const btCollisionShape* mesh, const btTransform& place, qcSweptPart part);
/// Reads the meshes of a shape, which may deform in a later step.
std::vector<qcSweptMesh> qcReadSweptMeshes(const btCollisionShape* shape);

#endif
