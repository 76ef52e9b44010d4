// The narrowphase: tests candidates exactly, in parallel. Results are pairs, segments, proximities and contacts,
// sorted.
#ifndef QC_NARROWPHASE_NARROWPHASE_H
#define QC_NARROWPHASE_NARROWPHASE_H

#include "base/worker_results.h"
#include "sweep/candidates.h"

/// What one worker found.
typedef struct qcNarrowphaseWorker
{
    qcWorkerResult result;
    qcArray found;       ///< uint64_t, as qcRelatedPair_Make
    qcArray contacts;    ///< of qcContact
    qcArray contactKeys; ///< of qcSortItem: candidate key, index in `contacts`
    uint64_t tests, fallbacks;
    double contactMs;
} qcNarrowphaseWorker;

typedef struct qcNarrowphase
{
    //  Results.
    qcArray pairs, segments, contacts;
    qcArray proximities;     ///< of qcProximity, one a pair; empty without qcDetectDef::proximities
    qcArray closestFeatures; ///< of qcClosestFeatures, of the proximities
    //  Retained between steps.
    qcArray localMinima; ///< of qcLocalMinima, by slot
    qcArray workers;     ///< of qcNarrowphaseWorker
    qcArray related;     ///< uint64_t, as qcRelatedPair_Make: of the pairs, in their order
    qcArray scratch, contactOrder, contactScratch;
} qcNarrowphase;

/// `def` selects what is reported. Adds to the profile's counters, sets exactMs and contactMs.
/// O(candidates + results log results).
qcStatus qcNarrowphase_Run(const qcStepTriangles* triangles, const qcCandidates* candidates, const qcDetectDef* def,
                           uint32_t threads, qcNarrowphase* narrowphase, qcProfile* profile);
void qcNarrowphase_Free(qcNarrowphase* narrowphase);

#endif
