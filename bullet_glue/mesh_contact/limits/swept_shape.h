// The triangles of an object that are swept: its meshes, and cores of its convex shapes.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_SHAPE_H
#define QC_GLUE_MESH_CONTACT_LIMITS_SWEPT_SHAPE_H

#include "mesh_contact/limits/convex_cores.h"
#include "mesh_contact/limits/swept_children.h"
#include "mesh_contact/limits/swept_floor.h"
#include "mesh_contact/limits/swept_mesh.h"

#include <algorithm>
#include <vector>

/// A part of an object that is tested as a hull.
struct qcSweptHull
{
    const qcSupportMesh* mesh;
    btTransform local; ///< from its frame to the object's
};

struct qcSweptShape
{
    btScalar radius = 0;  ///< of a sphere around the shape, about the object's origin
    bool hasMesh = false; ///< one of the shapes consists of triangles; planes do not
    bool isOurs = false;  ///< contact of one of the meshes with any other mesh is computed here
    /// Empty until the object is near another one, has contact, or its triangles are moved by the application.
    std::vector<qcSweptMesh> meshes;
    uint64_t revision = 0; ///< of the triangles of an object that Bullet does not move, in the last step; 0: none

    qcConvexCores* cores = nullptr;      ///< convex shapes are swept as these; null: they are not
    qcConvexCores* innerCores = nullptr; ///< likewise, for pairs that need them; null: none does
    int coreSteps = 0;                   ///< number of further steps in which they are swept
    btScalar halfWidth = BT_LARGE_FLOAT; ///< the smallest of the cores

    const qcSupportMesh* hull = nullptr; ///< the mesh or core, if there is one small one and nothing else
    std::vector<qcSweptHull> hulls;      ///< all that is tested; empty: hulls are not all
    qcSweptChildren children;            ///< of a compound at rest that others come near; read once a step
    std::vector<uint32_t> nearChildren;  ///< numbers of those that others may meet, as found in the step
    std::vector<qcSweptFloor> floors;    ///< of a dynamic body that consists of one small mesh

    /// True if a mesh deforms in the step.
    bool Deforms() const
    {
        return std::any_of(meshes.begin(), meshes.end(), [](const qcSweptMesh& mesh) { return mesh.Deforms(); });
    }
    /// Adds what `cores` has of the object's shape: sets `hasMesh`, `halfWidth`, `hulls` and, for a convex shape,
    /// `hull`.
    void ReadCores(const btCollisionShape* shape);
};

#endif
