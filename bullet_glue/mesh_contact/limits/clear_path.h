// A hull that moves past the triangles of meshes that stay.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_CLEAR_PATH_H
#define QC_GLUE_MESH_CONTACT_LIMITS_CLEAR_PATH_H

#include "mesh_contact/limits/swept_object.h"

/// True if the hulls of `moving`, and with them all that of it is tested, pass no triangle of `still` in the step: a
/// plane separates each hull from each triangle at the start and at the end. False proves nothing. `still` is at rest
/// and consists of qcMeshShapes. O(triangles whose boxes meet that of the path). Thread-safe.
bool qcHasClearPath(const qcSweptObject& moving, const qcSweptObject& still);

#endif
