// Small meshes that touch along faces, such as the pieces of a cut: their contact needs no search.
#ifndef QC_GLUE_MESH_CONTACT_PLANES_TOUCHING_FACES_H
#define QC_GLUE_MESH_CONTACT_PLANES_TOUCHING_FACES_H

#include "mesh_contact/planes/separating_axis.h"

/// Finds a face of each mesh that lie on each other, with three common vertices or more, so that their normal separates
/// the meshes, all up to qcGapError: no direction has a larger gap. The corners of the separation are three common
/// vertices that span a large area. O(faces of A * faces of B + vertices), and the square of what is next to the plane.
bool qcFindTouchingFaces(const qcPlacedSupport& a, const qcPlacedSupport& b, qcSeparation* separation);
/// True if the direction, of length 1, separates two meshes that have a vertex in common, both up to qcGapError.
bool qcTouchAlong(const qcPlacedSupport& a, const qcPlacedSupport& b, const btVector3& axis);

#endif
