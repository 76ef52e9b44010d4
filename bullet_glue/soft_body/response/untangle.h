// Works tangled surfaces apart: shortens the curve in which they meet. Volino, Magnenat-Thalmann: Resolving Surface
// Collisions through Intersection Contour Minimization, 2006.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H
#define QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H

#include "soft_body/scene/soft_scene.h"

/// Moves places of nodes of some of the result's pairs, which have segments. Momentum is kept, and no velocity comes of
/// it (qcSceneSoftBody::shifts). No node moves by more than a quarter of its body's thickness.
void qcUntangle(qcSoftBodyScene& scene, const qcResult& result, const std::vector<size_t>& pairs);

#endif
