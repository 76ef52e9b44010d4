// Results of workers.
#include "base/worker_results.h"

#include "base/status.h"

#include <stdio.h>

static qcWorkerResult* ResultAt(const qcArray* workers, size_t workerSize, size_t worker)
{
    return (qcWorkerResult*)((char*)workers->data + worker * workerSize);
}

qcStatus qcWorkerResults_Begin(qcArray* workers, uint32_t threads, size_t workerSize, const char* purpose)
{
    QC_TRY(qcArray_GrowZeroed(workers, threads, workerSize, purpose));
    for (size_t i = 0; i < workers->count; i++)
        ResultAt(workers, workerSize, i)->status = qc_statusOk;
    return qc_statusOk;
}

qcStatus qcWorkerResults_End(const qcArray* workers, size_t workerSize)
{
    for (size_t i = 0; i < workers->count; i++)
        QC_TRY(qcWorkerResult_Check(ResultAt(workers, workerSize, i)));
    return qc_statusOk;
}

void qcWorkerResult_Fail(qcWorkerResult* result, qcStatus status)
{
    if (result->status != qc_statusOk)
        return;
    result->status = status;
    snprintf(result->message, sizeof result->message, "%s", qcLastMessage());
}

qcStatus qcWorkerResult_Check(const qcWorkerResult* result)
{
    return result->status == qc_statusOk ? qc_statusOk : qcFail(result->status, "%s", result->message);
}
