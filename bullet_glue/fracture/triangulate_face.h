// Faces bounded by loops of points of a mesh.
#ifndef QC_GLUE_FRACTURE_TRIANGULATE_FACE_H
#define QC_GLUE_FRACTURE_TRIANGULATE_FACE_H

#include "fracture/scratch.h"

/// Adds triangles over what the edges of a face go round, all of them counterclockwise as it is seen from outside but
/// where rounding made edges cross; there, points may be added. Each edge has its triangle, as often as it is there and
/// not there backwards too, and all others have two.
void qcClipFace_Add(qcClipMesh* mesh, uint32_t face, const qcClipArrow* arrows, size_t count, qcClipScratch* scratch);

#endif
