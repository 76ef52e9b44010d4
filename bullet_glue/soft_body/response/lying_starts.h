// Soft bodies that are put exactly on a rigid surface.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_LYING_STARTS_H
#define QC_GLUE_SOFT_BODY_RESPONSE_LYING_STARTS_H

#include "soft_body/scene/soft_scene.h"

/// The distance up to which rounding may decide on which side of a surface a soft body was put; 0: none was.
btScalar qcLyingDistance(qcSoftBodyScene& scene);
/// Lifts the starts of soft bodies that were put in the plane of a rigid triangle, up to rounding, off it: to the side
/// from which its corners run counter-clockwise. `result`: pairs of the starts within qcLyingDistance. False: there was
/// none.
bool qcLiftStarts(qcSoftBodyScene& scene, const qcResult& result);

#endif
