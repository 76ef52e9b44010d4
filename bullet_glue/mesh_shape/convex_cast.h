// Convex casts through a mesh.
#ifndef QC_GLUE_MESH_SHAPE_CONVEX_CAST_H
#define QC_GLUE_MESH_SHAPE_CONVEX_CAST_H

#include "mesh_shape/triangle_tree.h"

class btTriangleConvexcastCallback;

/// Gives `cast` the triangles that its shape may hit before m_hitFraction of its way. In btCollisionWorld's own casts a
/// hit whose fraction the world's callback returns, as closest-hit callbacks do, shortens the rest of the cast.
void qcCastThroughMesh(const qcTriangleTree& tree, const btVector3* points, const uint32_t* indices,
                       btTriangleConvexcastCallback* cast);

#endif
