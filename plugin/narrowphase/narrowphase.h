// Candidates through the exact test, in parallel; pairs, segments, proximities and contacts out, sorted.
#ifndef QC_NARROWPHASE_NARROWPHASE_H
#define QC_NARROWPHASE_NARROWPHASE_H

#include "base/worker_results.h"
#include "sweep/candidates.h"

/// What one worker found.
typedef struct qcNarrowphaseWorker
{
    qcWorkerResult result;
    qcArray found;       ///< of qcSortItem: candidate key, relation
    qcArray contacts;    ///< of qcContact
    qcArray contactKeys; ///< of qcSortItem: candidate key, place in `contacts`
    uint64_t tests, fallbacks;
    double contactMs;
} qcNarrowphaseWorker;

typedef struct qcNarrowphase
{
    qcArray sinks; ///< of qcNarrowphaseWorker
    qcArray order, scratch;
    qcArray surroundings; ///< of qcLocalMinima, by slot
    //  results
    qcArray pairs, segments, contacts;
    qcArray proximities; ///< of qcProximity, one a pair; if they were asked for
    qcArray feet;        ///< of qcClosestFeatures, of the proximities
} qcNarrowphase;

/// `def` says what is reported. Adds to the profile's counters and to exactMs and contactMs.
qcStatus qcNarrowphase_Run(qcNarrowphase* narrow, const qcStepTriangles* triangles, const qcCandidates* candidates,
                           const qcDetectDef* def, uint32_t threads, qcProfile* profile);
void qcNarrowphase_Free(qcNarrowphase* narrow);

#endif
