// Works tangled surfaces apart by shortening their curve of intersection. Volino, Magnenat-Thalmann: Resolving Surface
// Collisions through Intersection Contour Minimization, 2006.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H
#define QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H

#include "soft_body/scene/soft_scene.h"

/// Moves nodes of these pairs of the result, which has segments: by up to a quarter of the body's thickness each.
/// Momentum is kept. The motion is recorded in qcSceneSoftBody::shifts and gives no velocity.
void qcUntangle(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& pairs);

#endif
