// A hull that moves past the triangles of meshes that stay.
#ifndef QC_GLUE_MESH_CONTACT_CLEAR_PATH_H
#define QC_GLUE_MESH_CONTACT_CLEAR_PATH_H

#include "mesh_contact/swept_object.h"

/// A triangle that a hull may pass in the step, and a plane between both at the start.
struct qcPathBlock
{
    uint32_t hull, mesh, triangle; ///< numbers of the moving object's hull, and of the triangle's mesh in the other one
    btVector3 corners[3];          ///< of the triangle, in the frame of its object
    btVector3 normal;              ///< of the plane: unit, from the triangle to the hull
    btScalar gap;                  ///< at the start, along the normal; above 0
    btScalar error;                ///< a plane with twice this gap at both ends is proven to be between them
};

enum class qcPath
{
    clear,   ///< a plane separates each hull from each triangle at the start and at the end
    blocked, ///< or at the start only: those are the blocks
    unknown
};

/// The path of the hulls of `moving`, and with them of all that of it is tested, past the triangles of `still`, which
/// is at rest and consists of qcMeshShapes. `blocks`: or null. O(triangles whose boxes meet that of
/// the path). Thread-safe.
qcPath qcFindPath(const qcSweptObject& moving, const qcSweptObject& still, std::vector<qcPathBlock>* blocks);

#endif
