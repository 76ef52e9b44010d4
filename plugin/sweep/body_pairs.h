// Body pairs: which bodies are tested with each other, and which of their triangles take part.
#ifndef QC_SWEEP_BODY_PAIRS_H
#define QC_SWEEP_BODY_PAIRS_H

#include "scene/pcs.h"
#include "scene/step_triangles.h"
#include "sweep/sweep_and_prune.h"

/// Two bodies of a step (numbers, not slots), a < b, whose boxes come within the query distance and that are tested.
typedef struct qcBodyPair
{
    uint32_t a, b;
} qcBodyPair;

typedef enum qcPairVerdict
{
    qc_pairTest,
    qc_pairAtRest,   ///< neither body moves
    qc_pairFiltered, ///< by group and mask, by a common owner, or by the filter of the step
    qc_pairSameSet   ///< both bodies in one collision-free set (lemma 2)
} qcPairVerdict;

/// Whether two different bodies are tested, by their definitions and sets.
qcPairVerdict qcBodyPair_Classify(const qcStepTriangles* triangles, const qcPcs* pcs, uint32_t a, uint32_t b);

typedef struct qcBodyPairs
{
    qcArray pairs;         ///< of qcBodyPair
    qcArray partnerCounts; ///< uint32_t, by body: the number of pairs with it
    //  Scratch, retained between steps.
    qcSweep sweep;
    qcArray boxes;
} qcBodyPairs;

/// Finds the pairs of bodies by sweep and prune; skipped pairs are counted in the profile.
qcStatus qcBodyPairs_Find(const qcStepTriangles* triangles, const qcPcs* pcs, double queryDistance, qcBodyPairs* pairs,
                          qcProfile* profile);
/// The reference: the same pairs by comparing each box with every other, unrounded. O(bodies^2).
qcStatus qcBodyPairs_FindBrute(const qcStepTriangles* triangles, const qcPcs* pcs, double queryDistance,
                               qcBodyPairs* pairs, qcProfile* profile);

/// Puts the triangles that take part into NFV.
/// - A body with self-collision: all triangles, against their own body.
/// - A body with one to a few partners: triangles whose boxes come within the query distance of a partner's box.
/// - A body with many partners, or with `wholeBodies`: all triangles.
/// `handledElsewhere`: a flag for each body, equal for both bodies of a pair; triangles of flagged bodies are left out.
/// It is set for bodies without pairs: later stages need not visit their triangles.
void qcBodyPairs_MarkTriangles(const qcBodyPairs* pairs, const qcStepTriangles* triangles, double queryDistance,
                               bool wholeBodies, uint8_t* handledElsewhere, qcPcs* pcs, qcProfile* profile);
void qcBodyPairs_Free(qcBodyPairs* pairs);

#endif
