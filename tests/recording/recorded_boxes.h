// A recording of a broadphase with every kind of call.
#ifndef QC_TESTS_RECORDING_RECORDED_BOXES_H
#define QC_TESTS_RECORDING_RECORDED_BOXES_H

#include "quickcullide/recording.h"
#include "support/check_ok.h"

/// The calls behind Open and before Close.
static inline void MakeBoxCalls(qcBoxRecorder* recorder)
{
    double bounds[6] = {0, 1, 2, 3, 4, 5};
    const uint32_t ids[] = {1, 3};
    const double lambdas[] = {0.5, 0.25};
    const qcBoxPair pairs[] = {{1, 2}, {1, 3}};
    const qcBoxCast cast = {{1, 2, 3}, {4, 5, 6}, {0, 0, 0, 1, 1, 1}, {1, 2, 3}, 7};
    for (uint32_t id = 1; id < 5; id++)
        qcBoxRecorder_Add(recorder, id, bounds, id, 3);
    for (uint32_t id = 1; id < 4; id++)
        qcBoxRecorder_Move(recorder, id, bounds);
    qcBoxRecorder_SetFilter(recorder, 2, 5, 6);
    qcBoxRecorder_Begin(recorder);
    // Behind the search.
    qcBoxRecorder_Move(recorder, 1, bounds);
    qcBoxRecorder_Remove(recorder, 3);
    qcBoxRecorder_EndPairs(recorder, pairs, 2, true, pairs, 1);
    qcBoxRecorder_Begin(recorder);
    qcBoxRecorder_EndQuery(recorder, bounds, ids, 2);
    qcBoxRecorder_Begin(recorder);
    qcBoxRecorder_EndCast(recorder, &cast, ids, lambdas, 2);
    qcBoxRecorder_Reset(recorder);
}

/// `scalarSize`: 4 or 8.
static inline void RecordBoxes(const char* path, uint32_t scalarSize)
{
    qcBoxRecorder* recorder = NULL;
    CHECK_OK(qcBoxRecorder_Open(path, scalarSize, &recorder));
    MakeBoxCalls(recorder);
    CHECK_OK(qcBoxRecorder_Close(recorder));
}

#endif
