// Triangulation of faces that are bounded by loops of a mesh's points.
#ifndef QC_GLUE_FRACTURE_TRIANGULATE_FACE_H
#define QC_GLUE_FRACTURE_TRIANGULATE_FACE_H

#include "fracture/scratch.h"

/// Adds triangles over the area that the half-edges of a face bound, counterclockwise as seen from outside. Where
/// rounding made edges cross, points may be added and triangles may face the other way. Each half-edge that has no
/// opposite among the given ones belongs to one triangle, as often as it is given; all other edges of triangles belong
/// to two.
void qcClipFace_Add(qcFacetedMesh* mesh, uint32_t face, const qcHalfEdge* halfEdges, size_t count,
                    qcClipScratch* scratch);

#endif
