// Works tangled surfaces apart: the part of a surface that an intersection curve cuts off is moved back through the
// other surface.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H
#define QC_GLUE_SOFT_BODY_RESPONSE_UNTANGLE_H

#include "soft_body/response/intersection_curves.h"

/// Chooses a direction for each curve that has one.
std::vector<qcUntanglement> qcFindUntanglements(const qcIntersectionCurves& curves);

/// Displacements of the nodes of soft bodies.
using qcNodeShifts = std::map<qcSceneSoftBody*, std::vector<btVector3>>;

/// Takes away motion that tangles surfaces further, and returns by how much to move nodes, without velocity: by a share
/// of the thickness. Momentum is kept.
qcNodeShifts qcUntangle(const std::vector<qcUntanglement>& untanglements);

#endif
