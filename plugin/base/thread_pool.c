// Threads that wait on a condition variable; one loop at a time. The loops of a step follow each other closely, and
// waking a thread takes up to 100 microseconds (two cores, a virtual machine): a thread spins for the next loop before
// it goes to sleep.
#define _GNU_SOURCE // sched_getaffinity

#include "base/thread_pool.h"

#include "base/clock.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <unistd.h>

enum
{
    qc_maxThreads = 255,
    qc_spinsPerClockRead = 64
};

// Milliseconds that a thread spins for the next loop, and the caller for the end of one.
static const double s_maxSpin = 0.1;

typedef struct Pool
{
    pthread_mutex_t mutex;
    pthread_cond_t begun;    ///< a loop has begun, or the process ends
    pthread_cond_t finished; ///< no thread is in the loop
    pthread_t threads[qc_maxThreads];
    uint32_t threadCount;
    bool busy, ending, watchesForks;
    //  the loop
    qcTask* task;
    void* taskContext;
    uint32_t next, count; ///< the next free index, and all; none is free if next >= count
    atomic_uint inside;   ///< threads in the loop
    atomic_uint begins;   ///< loops begun so far; the end of the process counts as one
} Pool;

static Pool s_pool = {
    .mutex = PTHREAD_MUTEX_INITIALIZER, .begun = PTHREAD_COND_INITIALIZER, .finished = PTHREAD_COND_INITIALIZER};

static void Pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// Spins until the number changes, for s_maxSpin at most.
static void SpinWait(atomic_uint* number, unsigned last)
{
    double start = qcClock_Now();
    do
        for (int i = 0; i < qc_spinsPerClockRead; i++)
        {
            if (atomic_load_explicit(number, memory_order_acquire) != last)
                return;
            Pause();
        }
    while (qcClock_Now() - start < s_maxSpin);
}

static void* Serve(void* argument)
{
    Pool* pool = argument;
    pthread_mutex_lock(&pool->mutex);
    for (;;)
    {
        if (!pool->ending && pool->next >= pool->count)
        {
            unsigned begins = atomic_load(&pool->begins);
            pthread_mutex_unlock(&pool->mutex);
            SpinWait(&pool->begins, begins);
            pthread_mutex_lock(&pool->mutex);
        }
        while (!pool->ending && pool->next >= pool->count)
            pthread_cond_wait(&pool->begun, &pool->mutex);
        if (pool->ending)
            break;
        uint32_t index = pool->next++;
        atomic_fetch_add(&pool->inside, 1);
        qcTask* task = pool->task;
        void* taskContext = pool->taskContext;
        pthread_mutex_unlock(&pool->mutex);
        task(index, taskContext);
        pthread_mutex_lock(&pool->mutex);
        if (atomic_fetch_sub(&pool->inside, 1) == 1)
            pthread_cond_signal(&pool->finished);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

/// After a fork: the child process has none of the threads, and no loop runs there.
static void ResetInChild(void)
{
    s_pool = (Pool){.mutex = PTHREAD_MUTEX_INITIALIZER,
                    .begun = PTHREAD_COND_INITIALIZER,
                    .finished = PTHREAD_COND_INITIALIZER,
                    .watchesForks = true};
}

/// Starts up to `requested` threads; none if the fork handler can't be installed.
static void StartThreads(Pool* pool, uint32_t requested)
{
    if (!pool->watchesForks)
        pool->watchesForks = pthread_atfork(NULL, NULL, ResetInChild) == 0;
    while (pool->watchesForks && pool->threadCount < requested && pool->threadCount < qc_maxThreads)
    {
        if (pthread_create(&pool->threads[pool->threadCount], NULL, Serve, pool) != 0)
            return;
        pool->threadCount++;
    }
}

void qcPool_Run(uint32_t count, qcTask* task, void* taskContext)
{
    Pool* pool = &s_pool;
    pthread_mutex_lock(&pool->mutex);
    bool own = !pool->busy && !pool->ending && count > 1;
    if (own)
    {
        pool->busy = true;
        StartThreads(pool, count - 1);
        pool->task = task;
        pool->taskContext = taskContext;
        pool->next = 1;
        pool->count = count;
        atomic_fetch_add(&pool->begins, 1);
        pthread_cond_broadcast(&pool->begun);
    }
    pthread_mutex_unlock(&pool->mutex);
    task(0, taskContext);
    if (!own)
        return;
    pthread_mutex_lock(&pool->mutex);
    pool->next = pool->count = 0;
    unsigned inside = atomic_load(&pool->inside);
    if (inside != 0)
    {
        pthread_mutex_unlock(&pool->mutex);
        SpinWait(&pool->inside, inside);
        pthread_mutex_lock(&pool->mutex);
    }
    while (atomic_load(&pool->inside) != 0)
        pthread_cond_wait(&pool->finished, &pool->mutex);
    pool->busy = false;
    pthread_mutex_unlock(&pool->mutex);
}

uint32_t qcPool_CoreCount(void)
{
    cpu_set_t cores;
    if (sched_getaffinity(0, sizeof cores, &cores) == 0)
        return (uint32_t)CPU_COUNT(&cores);
    long online = sysconf(_SC_NPROCESSORS_ONLN);
    return online > 0 ? (uint32_t)online : 1;
}

/// When the library is unloaded no thread may run its code.
__attribute__((destructor)) static void EndThreads(void)
{
    Pool* pool = &s_pool;
    pthread_mutex_lock(&pool->mutex);
    pool->ending = true;
    atomic_fetch_add(&pool->begins, 1);
    pthread_cond_broadcast(&pool->begun);
    uint32_t count = pool->threadCount;
    pool->threadCount = 0;
    pthread_mutex_unlock(&pool->mutex);
    for (uint32_t i = 0; i < count; i++)
        pthread_join(pool->threads[i], NULL);
}
