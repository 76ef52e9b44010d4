// Triangle pairs that reach the exact test: collected by worker, filtered by the same rules whoever finds them.
#ifndef QC_SWEEP_CANDIDATES_H
#define QC_SWEEP_CANDIDATES_H

#include "sweep/body_pairs.h"
#include "kernels/pair_buffer.h"
#include "base/parallel_for.h"
#include "base/radix_sort.h"
#include "base/worker_results.h"
#include "sweep/sweep_and_prune.h"

/// What one worker found.
typedef struct qcCandidateBuffer
{
    qcWorkerResult result;
    qcArray keys; ///< uint64_t: lower rank << 32 | higher rank
    qcArray neighbourKeys;
    uint64_t neighbours, setPairs;
} qcCandidateBuffer;

typedef struct qcCandidates
{
    qcSweep sweep;
    qcArray boxes;         ///< of qcSweepBox: sweep
    qcArray rows, ranks;   ///< of double, of uint32_t: brute
    qcArray sinks;         ///< of qcCandidateBuffer
    qcArray keys;          ///< uint64_t: the result, in no order
    qcArray neighbourKeys; ///< as keys: what only contacts ask for, neighbours and pairs whose relation is known
    qcArray sure;          ///< of qcSortItem: key and relation, of pairs that need no other test; not among the keys
} qcCandidates;

typedef struct qcCandidateRules
{
    const qcStepTriangles* triangles;
    const uint8_t* elsewhere; ///< by body: whose triangles another part of the line answers for
    double margin;            ///< boxes this far apart still count as overlapping
    bool testNeighbours;      ///< triangles of one body that share a vertex are candidates too
    bool listNeighbours;      ///< and otherwise a list of their own
    uint32_t threads;
} qcCandidateRules;

/// By sweep and prune over the triangles of the PCS.
qcStatus qcCandidates_Sweep(qcCandidates* candidates, const qcCandidateRules* rules, qcProfile* profile);

/// By comparing every box with every other: O(n^2).
qcStatus qcCandidates_Brute(qcCandidates* candidates, const qcCandidateRules* rules, qcProfile* profile);

/// Adds pairs that were found elsewhere: on a device, which cannot ask the step's filter.
qcStatus qcCandidates_Add(qcCandidates* candidates, const qcStepTriangles* triangles, const qcPairKeys* keys);

void qcCandidates_Free(qcCandidates* candidates);

//  ---- for the two ways of finding -----------------------------------------------------------------------

/// Empties the sinks of as many workers.
qcStatus qcCandidates_Begin(qcCandidates* candidates, uint32_t threads);
/// Keeps the pair if the rules let it; `bodyA`, `bodyB` as in qcStepTriangles.
void qcCandidates_Offer(const qcCandidateRules* rules, qcCandidateBuffer* sink, uint32_t bodyA, uint32_t rankA,
                        uint32_t bodyB, uint32_t rankB);
/// Puts the sinks together.
qcStatus qcCandidates_End(qcCandidates* candidates, qcProfile* profile);

#endif
