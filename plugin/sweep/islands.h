// Islands: the connected components of the graph of body pairs. No triangle pair has triangles of two islands, so each
// island may use a different method.
#ifndef QC_SWEEP_ISLANDS_H
#define QC_SWEEP_ISLANDS_H

#include "plan/plan.h"
#include "sweep/body_pairs.h"

typedef struct qcIslands
{
    qcArray items;    ///< of qcPlanItem, an island each
    qcArray islandOf; ///< uint32_t, by body of the step: index of its island, or QC_NO_ISLAND
    qcArray scratch;  ///< uint32_t, by body
} qcIslands;

/// A body without partners and without self-collision.
#define QC_NO_ISLAND UINT32_MAX

/// O(bodies + pairs), almost.
qcStatus qcIslands_Find(const qcStepTriangles* triangles, const qcBodyPairs* pairs, qcIslands* islands);
/// Estimates qcPlanItem::finest of all islands, by a few triangles of each body. Its input is the last qcIslands_Find.
/// O(bodies).
void qcIslands_FindFinest(qcIslands* islands, const qcStepTriangles* triangles);
/// Clears the flags (by body) of islands in which not all bodies are flagged, and of bodies without an island. Its
/// input is the last qcIslands_Find.
void qcIslands_KeepWhole(qcIslands* islands, uint8_t* flags);
/// Clears the flags (by body) of islands in which no body has more than `maxSize` triangles. Its input is the last
/// qcIslands_Find. O(bodies).
void qcIslands_LeaveSmall(qcIslands* islands, const qcStepTriangles* triangles, uint32_t maxSize, uint8_t* flags);
void qcIslands_Free(qcIslands* islands);

#endif
