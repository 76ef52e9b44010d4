// Candidates through the exact test, in parallel; pairs, segments, proximities and contacts out, sorted.
#ifndef QC_NARROWPHASE_NARROWPHASE_H
#define QC_NARROWPHASE_NARROWPHASE_H

#include "sweep/candidates.h"

/// What one worker found.
typedef struct qcNarrowSink
{
    qcArray found;       ///< of qcSortItem: candidate key, relation
    qcArray contacts;    ///< of qcContact
    qcArray contactKeys; ///< of qcSortItem: candidate key, place in `contacts`
    uint64_t tests, fallbacks;
    double contactMs;
    qcStatus status;
    char apart[64]; ///< keeps the counters of two workers off one cache line
} qcNarrowSink;

typedef struct qcNarrow
{
    qcArray sinks; ///< of qcNarrowSink
    qcArray order, scratch;
    qcArray surroundings; ///< of qcSurroundings, by slot
    //  results
    qcArray pairs, segments, contacts;
    qcArray proximities; ///< of qcProximity, one a pair; if they were asked for
    qcArray feet;        ///< of qcFeet, of the proximities
} qcNarrow;

/// `def` says what is reported. Adds to the profile's counters and to exactMs and contactMs.
qcStatus qcNarrow_Run(qcNarrow* narrow, const qcTriangles* triangles, const qcCandidates* candidates,
                      const qcDetectDef* def, uint32_t threads, qcProfile* profile);
void qcNarrow_Free(qcNarrow* narrow);

#endif
