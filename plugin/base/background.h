// A thread of its own that runs one job at a time while its owner does something else.
#ifndef QC_BASE_BACKGROUND_H
#define QC_BASE_BACKGROUND_H

#include "quickcullide/base.h"

typedef void qcBackgroundJob(void* context);

/// Started at the first job, asleep between jobs. One thread at a time may use it. A fork() in any thread waits for
/// jobs that run: the child process has the results, and a thread of its own from its next job on.
typedef struct qcBackground qcBackground;

/// qc_statusOutOfMemory.
qcStatus qcBackground_Create(qcBackground** background);
/// Begins job(context), in the default floating-point modes. The previous job must have been awaited.
void qcBackground_Post(qcBackground* background, qcBackgroundJob* job, void* context);
/// Returns once the job has ended. One that the thread has not begun yet, or for which no thread could be started, runs
/// on the calling thread: two calls in a row cost no switch of threads.
void qcBackground_Wait(qcBackground* background);
/// Its job has been awaited. Null is allowed.
void qcBackground_Destroy(qcBackground* background);

#endif
