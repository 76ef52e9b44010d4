// Candidates: triangle pairs for the narrow phase. Workers collect them; the same rules filter them, whichever stage
// finds them.
#ifndef QC_SWEEP_CANDIDATES_H
#define QC_SWEEP_CANDIDATES_H

#include "base/radix_sort.h"
#include "base/worker_results.h"
#include "kernels/pair_buffer.h"
#include "sweep/body_pairs.h"
#include "sweep/sweep_and_prune.h"

/// The pairs that one worker found.
typedef struct qcCandidateBuffer
{
    qcWorkerResult result;
    qcArray keys;                      ///< uint64_t, see qcStepTriangles_Key
    qcArray contactKeys;               ///< likewise
    uint64_t neighbourPairs, setPairs; ///< skipped
} qcCandidateBuffer;

typedef struct qcCandidates
{
    qcArray keys;        ///< uint64_t: candidates, in no order
    qcArray contactKeys; ///< uint64_t: pairs for contacts only: neighbours, and pairs that are classified
    qcArray classified;  ///< uint64_t, as qcRelatedPair_Make: pairs that need no exact test; not among the keys
    //  Scratch, retained between steps.
    qcSweep sweep;
    qcArray boxes;          ///< of qcSweepBox: sweep
    qcArray rows, rowOwner; ///< of double, of uint32_t: brute
    qcArray buffers;        ///< of qcCandidateBuffer
} qcCandidates;

typedef struct qcCandidateRules
{
    const qcStepTriangles* triangles;
    const qcPcs* pcs;
    const uint8_t* handledElsewhere; ///< by body: its triangle pairs come from another stage
    double queryDistance;            ///< boxes this far apart still overlap
    bool testNeighbours;             ///< triangles of one body that share a vertex are candidates too
    bool listNeighbours;             ///< without testNeighbours: they are listed in contactKeys
    uint32_t threads;
} qcCandidateRules;

/// By sweep and prune over the triangles of the PCS. Replaces the candidates.
qcStatus qcCandidates_Sweep(const qcCandidateRules* rules, qcCandidates* candidates, qcProfile* profile);

/// By comparing every box with every other: O(n^2). Replaces the candidates.
qcStatus qcCandidates_Brute(const qcCandidateRules* rules, qcCandidates* candidates, qcProfile* profile);

/// Adds pairs from a device, which can't call the step's filter. What the lists of `keys` have then is of no use.
qcStatus qcCandidates_Take(const qcStepTriangles* triangles, const qcPcs* pcs, const qcPairKeys* keys,
                           qcCandidates* candidates);

void qcCandidates_Free(qcCandidates* candidates);

//  ---- for sweep and brute force -------------------------------------------------------------------------

/// Empties the buffers of this many workers.
qcStatus qcCandidates_Begin(qcCandidates* candidates, uint32_t threads);
/// Adds the pair if the rules allow it; triangles by global index, `bodyA`, `bodyB` as in qcStepTriangles.
void qcCandidates_Offer(const qcCandidateRules* rules, uint32_t bodyA, uint32_t triangleA, uint32_t bodyB,
                        uint32_t triangleB, qcCandidateBuffer* buffer);
/// Joins the buffers.
qcStatus qcCandidates_End(qcCandidates* candidates, qcProfile* profile);

#endif
