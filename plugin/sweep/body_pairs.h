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

typedef enum qcMeeting
{
    qc_meetingYes,
    qc_meetingAtRest,   ///< neither moves
    qc_meetingFiltered, ///< group and mask, one owner, or the filter of the step
    qc_meetingSameSet   ///< inside one collision-free set (lemma 2)
} qcMeeting;

/// May two different bodies meet, as far as their definitions and sets tell?
qcMeeting qcObjects_Meet(const qcTriangles* triangles, uint32_t a, uint32_t b);

/// Memory that the stage keeps between steps.
typedef struct qcObjects
{
    qcSweep sweep;
    qcArray boxes;
    qcArray pairs;    ///< of qcBodyPair
    qcArray partners; ///< of uint32_t: how many pairs a body is in
} qcObjects;

/// Finds the pairs of bodies, and counts what was skipped into the profile.
qcStatus qcObjects_FindPairs(qcObjects* objects, const qcTriangles* triangles, double margin, qcProfile* profile);
/// The same pairs by comparing every box with every other, as given: O(bodies^2), and nothing of the sweep.
qcStatus qcObjects_FindPairsBrute(qcObjects* objects, const qcTriangles* triangles, double margin, qcProfile* profile);

/// Puts into NFV the triangles that take part: of a body that is tested with itself all; of a body with one to a few
/// partners those whose boxes come within the margin of a partner's; of one with many, or with `wholeBodies`, all.
/// `elsewhere`: a flag a body; those set, and so all whom they meet, are answered elsewhere and left out. May be null.
qcStatus qcObjects_MarkTriangles(qcObjects* objects, qcTriangles* triangles, double margin, bool wholeBodies,
                                 const uint8_t* elsewhere, qcProfile* profile);
void qcObjects_Free(qcObjects* objects);

#endif
