// Debug drawing of a batch's candidates.
#ifndef QC_GLUE_MESH_CONTACT_SCENE_DRAW_CANDIDATES_H
#define QC_GLUE_MESH_CONTACT_SCENE_DRAW_CANDIDATES_H

#include "mesh_contact/scene/batch_scene.h"

class btIDebugDraw;

/// Draws the candidate triangles and pairs of a result of the scene, at the present transforms of their objects.
/// Objects that have left the world since, or whose shape has changed, are left out. `modes`: bits of qcDebugDrawMode.
void qcDrawCandidates(const qcBatchScene& scene, const qcResult& result, int modes, btIDebugDraw* drawer);

#endif
