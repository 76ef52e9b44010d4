// Lower bound of the distance of two boxes in general position.
// Gottschalk, Lin, Manocha: OBBTree: A hierarchical structure for rapid interference detection, SIGGRAPH 1996.
#ifndef QC_GLUE_MESH_CONTACT_SCENE_BOX_GAP_H
#define QC_GLUE_MESH_CONTACT_SCENE_BOX_GAP_H

#include <LinearMath/btTransform.h>

/// A box in the frame of an object.
struct qcPlacedBox
{
    btVector3 lower, upper;
    btTransform transform; ///< of the object
};

/// Lower bound of the distance of two boxes: the largest gap along the normals of their faces and the cross products of
/// their edges; 0 or less if they may overlap. Proof: plugin/docs/proofs/pair_reuse.md.
btScalar qcBoxGap(const qcPlacedBox& a, const qcPlacedBox& b);

#endif
