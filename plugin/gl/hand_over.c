// A turn that changes under a mutex and is read without it by those who spin.
#include "gl/hand_over.h"

#include "base/spin.h"

enum
{
    // The mutex is held for 0.1 microseconds; a test takes 0.05.
    qc_lockSpins = 100
};

// Milliseconds. On a GPU (H200) a step of 4 M triangles is prepared in 0.8 ms, and the device takes 0.2 ms for one of
// 92 K (bench gpu, cloth). A waking thread comes 0.02 to 0.1 ms late, little beside a longer wait.
static const double s_maxSpin = 1.0;

void qcHandOver_Init(qcHandOver* h)
{
    pthread_mutex_init(&h->mutex, NULL);
    pthread_cond_init(&h->changed, NULL);
    qcHandOver_Begin(h);
}

void qcHandOver_Begin(qcHandOver* h)
{
    h->spins = false;
    atomic_store(&h->turn, qc_turnIdle);
    atomic_store(&h->alert, false);
}

void qcHandOver_Destroy(qcHandOver* h)
{
    pthread_cond_destroy(&h->changed);
    pthread_mutex_destroy(&h->mutex);
}

void qcHandOver_Lock(qcHandOver* h)
{
    for (int i = 0; i < qc_lockSpins; i++)
    {
        if (pthread_mutex_trylock(&h->mutex) == 0)
            return;
        qcSpin_Pause();
    }
    pthread_mutex_lock(&h->mutex);
}

void qcHandOver_Unlock(qcHandOver* h)
{
    pthread_mutex_unlock(&h->mutex);
}

void qcHandOver_Set(qcHandOver* h, qcTurn turn)
{
    atomic_store(&h->turn, turn);
    // In glibc no system call unless somebody sleeps.
    pthread_cond_broadcast(&h->changed);
}

void qcHandOver_Alert(qcHandOver* h)
{
    if (!h->spins || atomic_exchange(&h->alert, true))
        return;
    pthread_cond_broadcast(&h->changed);
}

void qcHandOver_Calm(qcHandOver* h)
{
    atomic_store(&h->alert, false);
}

static bool HasWork(const qcHandOver* h)
{
    qcTurn turn = qcHandOver_Turn(h);
    return turn == qc_turnPosted || turn == qc_turnReopen || turn == qc_turnQuit;
}

static bool HasWorkOrCalm(const void* context)
{
    const qcHandOver* h = context;
    return HasWork(h) || !atomic_load(&h->alert);
}

static bool IsDone(const void* context)
{
    return qcHandOver_Turn(context) == qc_turnDone;
}

/// Spins without the mutex. False: in vain.
static bool Spin(qcHandOver* h, qcSpinTest* isOver)
{
    qcHandOver_Unlock(h);
    bool over = qcSpin_AndYieldUntil(isOver, h, s_maxSpin);
    qcHandOver_Lock(h);
    return over;
}

qcTurn qcHandOver_WaitForWork(qcHandOver* h)
{
    while (!HasWork(h))
        if (!atomic_load(&h->alert))
            pthread_cond_wait(&h->changed, &h->mutex);
        else if (!Spin(h, HasWorkOrCalm))
            atomic_store(&h->alert, false);
    return qcHandOver_Turn(h);
}

void qcHandOver_WaitForResult(qcHandOver* h)
{
    if (h->spins)
        Spin(h, IsDone);
    while (!IsDone(h))
        pthread_cond_wait(&h->changed, &h->mutex);
    atomic_store(&h->turn, qc_turnIdle);
}
