// Continuous collision of nodes and rope links of soft bodies with meshes. Soft bodies have none among themselves.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_NODE_CCD_H
#define QC_GLUE_SOFT_BODY_RESPONSE_NODE_CCD_H

#include "soft_body/response/position_constraints.h"

/// Makes a constraint for each node that went through a mesh in the step, by more than the contact distance: it keeps
/// the node on its starting side of the first triangle that the node went through.
void qcMakeNodeCcdConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints);

/// Appends a constraint for each rope link that crossed an edge of a mesh between the start of the step and its present
/// position: it keeps the link on its starting side of the first such edge.
void qcAddLinkCcdConstraints(qcSoftBodyScene& scene, std::vector<qcSoftConstraint>* constraints);

#endif
