// The parts of a scene: bodies that can meet each other, directly or by way of others. What is found in one part is
// independent of all others, so that each may be answered by another method.
#ifndef QC_SWEEP_ISLANDS_H
#define QC_SWEEP_ISLANDS_H

#include "sweep/body_pairs.h"
#include "plan/plan.h"

typedef struct qcIslands
{
    qcArray parts;  ///< of qcPlanItem
    qcArray partOf; ///< uint32_t, by body of the step: its part, or QC_NO_ISLAND
    qcArray parents;
} qcIslands;

/// The body meets nothing.
#define QC_NO_ISLAND UINT32_MAX

qcStatus qcIslands_Find(qcIslands* parts, const qcStepTriangles* triangles, const qcBodyPairs* objects);
/// Clears the flags (by body) of parts that have a body whose flag is not set, and of bodies that meet nothing. After
/// qcIslands_Find.
void qcIslands_Unite(qcIslands* parts, uint8_t* flags);
void qcIslands_Free(qcIslands* parts);

#endif
