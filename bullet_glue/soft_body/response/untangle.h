// Works tangled surfaces apart: the part of a surface that an intersection curve cuts off is moved back through the
// other surface.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H
#define QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H

#include "soft_body/response/intersection_curves.h"

/// Chooses a direction for each curve that has one.
std::vector<qcUntanglement> qcFindUntanglements(const qcIntersectionCurves& curves);

/// Moves nodes by a share of the thickness, and takes away motion that tangles them further. Momentum is kept. The
/// first motion is recorded in qcSceneSoftBody::shifts and gives no velocity.
void qcUntangle(qcSoftBodyScene& scene, const std::vector<qcUntanglement>& untanglements);

#endif
