// Faces bounded by loops of points of a mesh.
#ifndef QC_BULLET_GLUE_FRACTURE_FACE_H
#define QC_BULLET_GLUE_FRACTURE_FACE_H

#include "fracture_scratch.h"

/// Adds triangles over what the loops go round counterclockwise, as the normal sees it, all of one face. Where loops
/// cross or touch, points may be added. Some edges of the loops may be left without a triangle.
void qcClipFace_Add(qcClipMesh* mesh, const qcClipPoint& normal, uint32_t face, const qcClipLoops& loops,
                    qcClipScratch* scratch);

/// Adds triangles over which all edges of the loops are closed, whatever they look like, with the right signed volume.
void qcClipFace_AddFans(qcClipMesh* mesh, uint32_t face, const qcClipLoops& loops);

#endif
