// One job, one mutex, one state. A list of all threads serves fork() and the end of the process.
#define _POSIX_C_SOURCE 200809L
#include "base/background.h"

#include "base/float_mode.h"
#include "base/memory.h"
#include "base/status.h"

#include <pthread.h>
#include <signal.h>

enum
{
    // A device's driver may run on this thread; some C libraries give threads only 128 KiB.
    qc_stackSize = 8 << 20
};

typedef enum JobState
{
    job_none,   ///< awaited, or there was none
    job_posted, ///< nobody has begun it
    job_running,
    job_done
} JobState;

struct qcBackground
{
    qcBackground *next, *previous; ///< in the list of all
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    pthread_t thread;
    bool hasThread, quits;
    JobState state;
    pthread_t runner; ///< of a running job
    qcBackgroundJob* job;
    void* context;
};

static pthread_mutex_t s_listMutex = PTHREAD_MUTEX_INITIALIZER;
static qcBackground* s_list;
static bool s_watchesForks;

/// Runs the posted job. The mutex is held, but not while the job runs.
static void RunJob(qcBackground* b)
{
    b->state = job_running;
    b->runner = pthread_self();
    pthread_mutex_unlock(&b->mutex);
    qcFloatMode mode = qcFloatMode_Begin();
    b->job(b->context);
    qcFloatMode_End(mode);
    pthread_mutex_lock(&b->mutex);
    b->state = job_done;
    pthread_cond_broadcast(&b->changed);
}

static void* Serve(void* argument)
{
    qcBackground* b = argument;
    pthread_mutex_lock(&b->mutex);
    while (!b->quits)
        if (b->state == job_posted)
            RunJob(b);
        else
            pthread_cond_wait(&b->changed, &b->mutex);
    pthread_mutex_unlock(&b->mutex);
    return NULL;
}

//  ---- fork() and the end of the process -----------------------------------------------------------------------------

/// No job runs from here to the end of fork(), but one that calls fork() itself.
static void HoldJobs(void)
{
    pthread_mutex_lock(&s_listMutex);
    for (qcBackground* b = s_list; b != NULL; b = b->next)
    {
        pthread_mutex_lock(&b->mutex);
        while (b->state == job_running && !pthread_equal(b->runner, pthread_self()))
            pthread_cond_wait(&b->changed, &b->mutex);
    }
}

static void ReleaseJobs(void)
{
    for (qcBackground* b = s_list; b != NULL; b = b->next)
        pthread_mutex_unlock(&b->mutex);
    pthread_mutex_unlock(&s_listMutex);
}

/// The threads are not in the child process; nor are those that waited for the condition.
static void ReleaseJobsInChild(void)
{
    for (qcBackground* b = s_list; b != NULL; b = b->next)
    {
        b->hasThread = false;
        pthread_cond_init(&b->changed, NULL);
    }
    ReleaseJobs();
}

/// Ends the thread after its job, unless it is the calling one.
static void EndThread(qcBackground* b)
{
    pthread_mutex_lock(&b->mutex);
    bool joins = b->hasThread && !pthread_equal(b->thread, pthread_self());
    b->hasThread = b->hasThread && !joins;
    b->quits = true;
    pthread_cond_broadcast(&b->changed);
    pthread_mutex_unlock(&b->mutex);
    if (joins)
        pthread_join(b->thread, NULL);
}

/// When the library is unloaded no thread may run its code.
__attribute__((destructor)) static void EndThreads(void)
{
    pthread_mutex_lock(&s_listMutex);
    for (qcBackground* b = s_list; b != NULL; b = b->next)
        EndThread(b);
    pthread_mutex_unlock(&s_listMutex);
}

//  ---- the owner
//  -------------------------------------------------------------------------------------------------------

static void Link(qcBackground* b)
{
    pthread_mutex_lock(&s_listMutex);
    if (!s_watchesForks)
        s_watchesForks = pthread_atfork(HoldJobs, ReleaseJobs, ReleaseJobsInChild) == 0;
    b->next = s_list;
    if (s_list != NULL)
        s_list->previous = b;
    s_list = b;
    pthread_mutex_unlock(&s_listMutex);
}

static void Unlink(qcBackground* b)
{
    pthread_mutex_lock(&s_listMutex);
    *(b->previous != NULL ? &b->previous->next : &s_list) = b->next;
    if (b->next != NULL)
        b->next->previous = b->previous;
    pthread_mutex_unlock(&s_listMutex);
}

/// Without the handlers of fork() there is no thread. The mutex is held.
static void StartThread(qcBackground* b)
{
    pthread_attr_t attributes;
    if (!s_watchesForks || pthread_attr_init(&attributes) != 0)
        return;
    pthread_attr_setstacksize(&attributes, qc_stackSize);
    // The host's signal handlers run on the host's threads.
    sigset_t all, previous;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &previous);
    b->hasThread = pthread_create(&b->thread, &attributes, Serve, b) == 0;
    pthread_sigmask(SIG_SETMASK, &previous, NULL);
    pthread_attr_destroy(&attributes);
}

qcStatus qcBackground_Create(qcBackground** background)
{
    qcBackground* b = qcAllocateZeroed(sizeof *b);
    if (b == NULL)
        return qcFailMemory(sizeof *b, "a background thread");
    pthread_mutex_init(&b->mutex, NULL);
    pthread_cond_init(&b->changed, NULL);
    Link(b);
    *background = b;
    return qc_statusOk;
}

void qcBackground_Post(qcBackground* b, qcBackgroundJob* job, void* context)
{
    pthread_mutex_lock(&b->mutex);
    b->job = job;
    b->context = context;
    b->state = job_posted;
    if (!b->hasThread && !b->quits)
        StartThread(b);
    pthread_cond_broadcast(&b->changed);
    pthread_mutex_unlock(&b->mutex);
}

void qcBackground_Wait(qcBackground* b)
{
    pthread_mutex_lock(&b->mutex);
    if (b->state == job_posted)
        RunJob(b);
    while (b->state == job_running)
        pthread_cond_wait(&b->changed, &b->mutex);
    b->state = job_none;
    pthread_mutex_unlock(&b->mutex);
}

void qcBackground_Destroy(qcBackground* b)
{
    if (b == NULL)
        return;
    EndThread(b);
    Unlink(b);
    pthread_cond_destroy(&b->changed);
    pthread_mutex_destroy(&b->mutex);
    qcFree(b, sizeof *b);
}
