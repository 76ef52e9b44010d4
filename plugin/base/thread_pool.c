// Threads that wait on a condition; one slot for a loop. The loops of a step follow each other closely: before a thread
// goes to sleep it looks out for the next one, as waking it takes up to 100 microseconds (two cores, a virtual
// machine).
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
    qc_mostThreads = 255,
    qc_looksBetweenTimes = 64
};

// Milliseconds that a thread looks out for the next loop, and the caller for the end of one.
static const double s_lookout = 0.1;

typedef struct Pool
{
    pthread_mutex_t mutex;
    pthread_cond_t begun;    ///< there is a loop, or the end
    pthread_cond_t finished; ///< no thread is in the loop
    pthread_t threads[qc_mostThreads];
    uint32_t threadCount;
    bool busy, ending, watchesForks;
    //  the loop
    qcTask* task;
    void* taskContext;
    uint32_t next, count; ///< indices that no thread has; none: next >= count
    atomic_uint inside;   ///< threads in the loop
    atomic_uint begins;   ///< loops so far, and the end
} Pool;

static Pool s_pool = {
    .mutex = PTHREAD_MUTEX_INITIALIZER, .begun = PTHREAD_COND_INITIALIZER, .finished = PTHREAD_COND_INITIALIZER};

static void Pause(void)
{
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#endif
}

/// Until the number is another than it was; not for long.
static void LookOut(atomic_uint* number, unsigned last)
{
    double start = qcClock_Now();
    do
        for (int i = 0; i < qc_looksBetweenTimes; i++)
        {
            if (atomic_load_explicit(number, memory_order_acquire) != last)
                return;
            Pause();
        }
    while (qcClock_Now() - start < s_lookout);
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
            LookOut(&pool->begins, begins);
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

/// A child process has none of the threads, and nobody is in a loop there.
static void ForgetThreads(void)
{
    s_pool = (Pool){.mutex = PTHREAD_MUTEX_INITIALIZER,
                    .begun = PTHREAD_COND_INITIALIZER,
                    .finished = PTHREAD_COND_INITIALIZER,
                    .watchesForks = true};
}

/// As many as can be started; none if a child process would not learn that it has none.
static void StartThreads(Pool* pool, uint32_t wanted)
{
    if (!pool->watchesForks)
        pool->watchesForks = pthread_atfork(NULL, NULL, ForgetThreads) == 0;
    while (pool->watchesForks && pool->threadCount < wanted && pool->threadCount < qc_mostThreads)
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
        LookOut(&pool->inside, inside);
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

/// The library may be unloaded: its code must not be in use by then.
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
