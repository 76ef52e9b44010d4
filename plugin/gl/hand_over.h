// The hand-over of jobs and results between callers and a device's thread. Both sleep; where that takes long beside a
// job, on a GPU, they spin for a while first: the thread while a step is prepared, its caller while the job runs.
#ifndef QC_GL_HAND_OVER_H
#define QC_GL_HAND_OVER_H

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

typedef enum qcTurn
{
    qc_turnIdle,
    qc_turnPosted, ///< the thread has a job to do
    qc_turnDone,   ///< the caller has a result to fetch
    qc_turnReopen, ///< the thread opens a new context in place of the lost one; nobody waits
    qc_turnQuit
} qcTurn;

typedef struct qcHandOver
{
    pthread_mutex_t mutex; ///< guards the turn, and what its owner lets it guard
    pthread_cond_t changed;
    bool spins;        ///< false at the beginning
    atomic_int turn;   ///< qcTurn; read without the mutex by those who spin
    atomic_bool alert; ///< the thread spins for a job
} qcHandOver;

void qcHandOver_Init(qcHandOver* handOver);
/// Before a thread starts.
void qcHandOver_Begin(qcHandOver* handOver);
void qcHandOver_Destroy(qcHandOver* handOver);

/// Locks the mutex. Others hold it for an instant only: spins before it sleeps.
void qcHandOver_Lock(qcHandOver* handOver);
void qcHandOver_Unlock(qcHandOver* handOver);

//  The mutex is held.

static inline qcTurn qcHandOver_Turn(const qcHandOver* handOver)
{
    return (qcTurn)atomic_load(&handOver->turn);
}

/// Sets the turn, and wakes those who sleep.
void qcHandOver_Set(qcHandOver* handOver, qcTurn turn);
/// A job follows soon: the thread wakes and spins for it, for a millisecond at most. Nothing where `spins` is false.
void qcHandOver_Alert(qcHandOver* handOver);
/// No job follows: the thread sleeps.
void qcHandOver_Calm(qcHandOver* handOver);

//  The mutex is held, but not meanwhile.

/// On the thread: waits for a job, a reopening or the end, and returns which.
qcTurn qcHandOver_WaitForWork(qcHandOver* handOver);
/// On the caller: waits for the result; the turn becomes idle. Spins first if `spins`.
void qcHandOver_WaitForResult(qcHandOver* handOver);

#endif
