// Status and message of each worker of a parallel loop. Messages belong to a thread (qcLastMessage): a worker that
// fails stores its message here, and the thread that started the loop copies it.
//
// A worker's own struct begins with a qcWorkerResult; an array of these structs, one a worker, goes through
// qcWorkerResults_Begin before the loop and qcWorkerResults_End after it.
#ifndef QC_BASE_WORKER_RESULTS_H
#define QC_BASE_WORKER_RESULTS_H

#include "base/memory.h"

#include <stdbool.h>

/// All zero: no failure. It fills two cache lines: the fields after it share none with the previous worker's counters.
typedef struct qcWorkerResult
{
    _Alignas(64) qcStatus status; ///< of the first call that failed
    char message[124];            ///< of that call; a longer one is cut off
} qcWorkerResult;

/// Makes one worker struct of `workerSize` bytes for each thread, new ones all zero, and clears the results of all.
qcStatus qcWorkerResults_Begin(qcArray* workers, uint32_t threads, size_t workerSize, const char* purpose);
/// The first failure among the workers, with its message on the calling thread.
qcStatus qcWorkerResults_End(const qcArray* workers, size_t workerSize);

/// Keeps a failure and the calling thread's message, unless there is one already.
void qcWorkerResult_Fail(qcWorkerResult* result, qcStatus status);
/// The result's status, with its message on the calling thread.
qcStatus qcWorkerResult_Check(const qcWorkerResult* result);

static inline bool qcWorkerResult_IsOk(const qcWorkerResult* result)
{
    return result->status == qc_statusOk;
}

/// Adds the status of a call. True if that call succeeded.
static inline bool qcWorkerResult_Add(qcWorkerResult* result, qcStatus status)
{
    if (status != qc_statusOk)
        qcWorkerResult_Fail(result, status);
    return status == qc_statusOk;
}

#endif
