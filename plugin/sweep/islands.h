// The parts of a scene: bodies that can meet each other, directly or by way of others. What is found in one part is
// independent of all others, so that each may be answered by another method.
#ifndef QC_SWEEP_ISLANDS_H
#define QC_SWEEP_ISLANDS_H

#include "sweep/body_pairs.h"
#include "plan/plan.h"

typedef struct qcParts
{
    qcArray parts;  ///< of qcPlanPart
    qcArray partOf; ///< uint32_t, by body of the step: its part, or QC_NO_PART
    qcArray parents;
} qcParts;

/// The body meets nothing.
#define QC_NO_PART UINT32_MAX

qcStatus qcParts_Find(qcParts* parts, const qcTriangles* triangles, const qcObjects* objects);
/// Clears the flags (by body) of parts that have a body whose flag is not set, and of bodies that meet nothing. After
/// qcParts_Find.
void qcParts_Unite(qcParts* parts, uint8_t* flags);
void qcParts_Free(qcParts* parts);

#endif
