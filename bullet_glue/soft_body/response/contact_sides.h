// On which side of each other the surfaces of a contact were at the start of the step.
#ifndef QC_GLUE_SOFT_BODY_RESPONSE_CONTACT_SIDES_H
#define QC_GLUE_SOFT_BODY_RESPONSE_CONTACT_SIDES_H

#include "soft_body/response/position_constraints.h"

/// Orients a contact of surfaces that slide on each other by more than their distance: then its points were beside each
/// other at the start, and the side on which they were is that of the face or of the edges. False: one has
/// passed the plane of the other beside it, and there is no contact.
bool qcOrientByFeatures(const qcSoftContactView& view, qcSoftConstraint* constraint);

#endif
