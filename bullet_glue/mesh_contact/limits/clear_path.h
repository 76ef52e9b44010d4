// A hull that moves past the triangles of meshes that stay.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_CLEAR_PATH_H
#define QC_GLUE_MESH_CONTACT_LIMITS_CLEAR_PATH_H

#include "mesh_contact/limits/swept_object.h"

/// True if the hulls of `moving`, and with them all that of it is tested, pass no triangle of `still` in the step: a
/// plane separates each hull from each triangle of a mesh, and from each core as a whole, at the start and at the end.
/// False proves nothing. `still` is at rest, and its meshes are qcMeshShapes; its cores are looked at if its children
/// have been read. O(triangles and cores whose boxes meet that of the path). Thread-safe.
bool qcHasClearPath(const qcSweptObject& moving, const qcSweptObject& still);

#endif
