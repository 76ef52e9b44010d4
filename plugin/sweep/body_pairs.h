// Bodies against bodies: which pairs may meet, which triangles of theirs take part.
#ifndef QC_SWEEP_BODY_PAIRS_H
#define QC_SWEEP_BODY_PAIRS_H

#include "sweep/sweep_and_prune.h"
#include "scene/step_triangles.h"

/// Two bodies of a step (numbers, not slots) whose boxes overlap and that may meet; a < b.
typedef struct qcBodyPair
{
    uint32_t a, b;
} qcBodyPair;

typedef enum qcPairVerdict
{
    qc_verdictYes,
    qc_verdictAtRest,   ///< neither moves
    qc_verdictFiltered, ///< group and mask, one owner, or the filter of the step
    qc_verdictSameSet   ///< inside one collision-free set (lemma 2)
} qcPairVerdict;

/// May two different bodies meet, as far as their definitions and sets tell?
qcPairVerdict qcBodyPair_Classify(const qcStepTriangles* triangles, uint32_t a, uint32_t b);

/// Memory that the stage keeps between steps.
typedef struct qcBodyPairs
{
    qcSweep sweep;
    qcArray boxes;
    qcArray pairs;    ///< of qcBodyPair
    qcArray partners; ///< of uint32_t: how many pairs a body is in
} qcBodyPairs;

/// Finds the pairs of bodies, and counts what was skipped into the profile.
qcStatus qcBodyPairs_FindPairs(qcBodyPairs* objects, const qcStepTriangles* triangles, double margin,
                               qcProfile* profile);
/// The same pairs by comparing every box with every other, as given: O(bodies^2), and nothing of the sweep.
qcStatus qcBodyPairs_FindPairsBrute(qcBodyPairs* objects, const qcStepTriangles* triangles, double margin,
                                    qcProfile* profile);

/// Puts into NFV the triangles that take part: of a body that is tested with itself all; of a body with one to a few
/// partners those whose boxes come within the margin of a partner's; of one with many, or with `wholeBodies`, all.
/// `elsewhere`: a flag a body; those set, and so all whom they meet, are answered elsewhere and left out. May be null.
qcStatus qcBodyPairs_MarkTriangles(qcBodyPairs* objects, qcStepTriangles* triangles, double margin, bool wholeBodies,
                                   const uint8_t* elsewhere, qcProfile* profile);
void qcBodyPairs_Free(qcBodyPairs* objects);

#endif
