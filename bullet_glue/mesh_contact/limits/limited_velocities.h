// The velocities of bodies whose motion in a step was limited.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_LIMITED_VELOCITIES_H
#define QC_GLUE_MESH_CONTACT_LIMITS_LIMITED_VELOCITIES_H

#include "mesh_contact/limits/swept_object.h"

/// Moves a body to its end. One that makes a part of its motion keeps that part of what the step's gravity has done to
/// its velocity, so that it gains no energy from a fall that it doesn't make; one that is carried (`carrier`, or null)
/// has the carrier's velocity.
void qcMoveLimited(qcSweptObject* swept, const qcSweptObject* carrier, btScalar timeStep);

#endif
