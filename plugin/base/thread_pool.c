// Threads that spin for the next loop, then sleep on a condition variable; one loop at a time. The loops of a step
// follow each other closely: a thread that spins begins within a microsecond, waking one takes 20 to 100 (two cores, a
// virtual machine). One atomic word holds which loop runs and how many threads are in it: no lock while nobody sleeps.
//
// Before a thread is woken, the caller's core is taken out of its affinity: Linux often wakes it there, although
// another core is idle, and the two take turns (folded cloth of 4050 triangles, two cores of a virtual machine: 0.25 ms
// a step, 0.09 apart).
#define _GNU_SOURCE // sched_getaffinity, sched_getcpu, pthread_setaffinity_np

#include "base/thread_pool.h"

#include "base/spin.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <unistd.h>

enum
{
    qc_maxThreads = 255,
    // Threads that one thread wakes, which wake others in turn: waking takes 2 to 3 microseconds each (16 cores: 0.04
    // ms for all), and one that is woken begins 20 or more later.
    qc_wokenByOne = 4
};

// Milliseconds that a thread spins for the next loop, and the caller for the end of one.
static const double s_maxSpin = 0.1;

typedef struct Thread
{
    _Alignas(64) pthread_t handle;
    uint32_t index; ///< its index in each loop: what it has in its caches is that index's share of the data
    pthread_cond_t woken;
    atomic_bool sleeps;   ///< cleared by whoever wakes it
    atomic_uint lastCall; ///< the call that woke it last
    cpu_set_t allowed;    ///< the cores that the host allows it
    int excludedCore;     ///< of these, from its affinity; negative: none
} Thread;

typedef struct Pool
{
    pthread_mutex_t mutex;   ///< of starting threads, and of going to sleep
    pthread_cond_t finished; ///< the last thread has left the loop
    Thread threads[qc_maxThreads];
    atomic_uint threadCount;
    bool ending, watchesForks;
    //  the loop
    qcTask* task;
    void* taskContext;
    /// The number of the loop, from bit 32; its count of indices, from bit 16, 0 once it is closed to threads; the
    /// number of threads in it.
    _Alignas(64) _Atomic uint64_t word;
    /// Indices whose threads are to be awake; 0 once their loop is closed.
    atomic_uint wakeCount;
    /// The number of times that threads were called. A call wakes each thread once at most: with more threads than
    /// cores, those that are woken late would wake others that have given up spinning, and so on for ever.
    atomic_uint calls;
    atomic_int callerCore; ///< of the last loop; negative: not known
    atomic_bool rests;     ///< threads don't spin until the next loop
    _Alignas(64) atomic_bool busy;
    atomic_bool callerSleeps;
} Pool;

static Pool s_pool = {.mutex = PTHREAD_MUTEX_INITIALIZER, .finished = PTHREAD_COND_INITIALIZER, .callerCore = -1};

static uint32_t NumberOf(uint64_t word)
{
    return (uint32_t)(word >> 32);
}

static uint32_t CountOf(uint64_t word)
{
    return (uint32_t)word >> 16;
}

static uint32_t InsideOf(uint64_t word)
{
    return (uint32_t)word & 0xffff;
}

//  ---- threads -----------------------------------------------------------------------------------------

/// Whether an open loop has the index. `last`: the number of the thread's last loop, which may still be open.
static bool HasBegun(const Pool* pool, uint32_t index, uint32_t last)
{
    uint64_t word = atomic_load(&pool->word);
    return NumberOf(word) != last && index < CountOf(word);
}

/// A thread that waits for a loop.
typedef struct Wait
{
    const Pool* pool;
    uint32_t index, last; ///< see HasBegun
} Wait;

static bool IsSpinOver(const void* context)
{
    const Wait* wait = context;
    return HasBegun(wait->pool, wait->index, wait->last) || atomic_load(&wait->pool->rests);
}

/// Spins for a loop, for s_maxSpin at most. True: one has begun.
static bool Spin(const Pool* pool, uint32_t index, uint32_t last)
{
    const Wait wait = {pool, index, last};
    return qcSpin_Until(IsSpinOver, &wait, s_maxSpin) && HasBegun(pool, index, last);
}

/// Takes the core out of the thread's affinity, if it has another one, and puts back the one taken out before.
static void ExcludeCore(Thread* thread, int core)
{
    cpu_set_t present, expected = thread->allowed;
    if (core < 0 || pthread_getaffinity_np(thread->handle, sizeof present, &present) != 0 ||
        !CPU_ISSET((size_t)core, &present))
        return;
    if (thread->excludedCore >= 0)
        CPU_CLR((size_t)thread->excludedCore, &expected);
    // The host has chosen other cores, as taskset does.
    if (!CPU_EQUAL(&present, &expected))
        thread->allowed = present;
    cpu_set_t wanted = thread->allowed;
    CPU_CLR((size_t)core, &wanted);
    if (CPU_COUNT(&wanted) != 0 && pthread_setaffinity_np(thread->handle, sizeof wanted, &wanted) == 0)
        thread->excludedCore = core;
}

/// False: it did not sleep, or this call has woken it already.
static bool Wake(Pool* pool, Thread* thread, unsigned call)
{
    if (!atomic_load(&thread->sleeps) || atomic_load(&thread->lastCall) == call)
        return false;
    pthread_mutex_lock(&pool->mutex);
    bool slept = atomic_exchange(&thread->sleeps, false);
    if (slept)
    {
        atomic_store(&thread->lastCall, call);
        ExcludeCore(thread, atomic_load(&pool->callerCore));
        pthread_cond_signal(&thread->woken);
    }
    pthread_mutex_unlock(&pool->mutex);
    return slept;
}

/// Wakes some of the threads that sleep and should not.
static void WakeSome(Pool* pool)
{
    uint32_t threads = atomic_load(&pool->threadCount), count = atomic_load(&pool->wakeCount);
    unsigned call = atomic_load(&pool->calls);
    int woken = 0;
    for (uint32_t i = 0; i + 1 < count && i < threads && woken < qc_wokenByOne; i++)
        woken += Wake(pool, &pool->threads[i], call);
}

/// Sleeps until a loop has begun, threads are woken, or the process ends. False: it ends.
static bool Sleep(Pool* pool, Thread* thread, uint32_t last)
{
    pthread_mutex_lock(&pool->mutex);
    // A caller reads `sleeps` after it has changed the word: either it wakes this thread, or the thread sees the
    // loop here.
    atomic_store(&thread->sleeps, true);
    while (!pool->ending && atomic_load(&thread->sleeps) && !HasBegun(pool, thread->index, last))
        pthread_cond_wait(&thread->woken, &pool->mutex);
    atomic_store(&thread->sleeps, false);
    bool ending = pool->ending;
    pthread_mutex_unlock(&pool->mutex);
    if (!ending)
        WakeSome(pool);
    return !ending;
}

/// Waits for a loop. False: the process ends.
static bool WaitForLoop(Pool* pool, Thread* thread, uint32_t last)
{
    while (!Spin(pool, thread->index, last))
        if (!Sleep(pool, thread, last))
            return false;
    return true;
}

/// False: the loop has been closed. Otherwise *last becomes its number.
static bool Enter(Pool* pool, uint32_t index, uint32_t* last)
{
    uint64_t word = atomic_load(&pool->word);
    do
        if (index >= CountOf(word))
            return false;
    while (!atomic_compare_exchange_weak(&pool->word, &word, word + 1));
    *last = NumberOf(word);
    return true;
}

static void Leave(Pool* pool)
{
    uint64_t word = atomic_fetch_sub(&pool->word, 1);
    if (InsideOf(word) != 1 || CountOf(word) != 0 || !atomic_load(&pool->callerSleeps))
        return;
    pthread_mutex_lock(&pool->mutex);
    pthread_cond_signal(&pool->finished);
    pthread_mutex_unlock(&pool->mutex);
}

static void* Serve(void* argument)
{
    Pool* pool = &s_pool;
    Thread* thread = argument;
    uint32_t last = 0;
    while (WaitForLoop(pool, thread, last))
        if (Enter(pool, thread->index, &last))
        {
            pool->task(thread->index, pool->taskContext);
            Leave(pool);
        }
    return NULL;
}

/// After a fork: the child process has none of the threads, and no loop runs there.
static void ResetInChild(void)
{
    s_pool = (Pool){.mutex = PTHREAD_MUTEX_INITIALIZER,
                    .finished = PTHREAD_COND_INITIALIZER,
                    .watchesForks = true,
                    .callerCore = -1};
}

/// Starts up to `requested` threads; none if the fork handler can't be installed. False: the process ends.
static bool StartThreads(Pool* pool, uint32_t requested)
{
    requested = requested < qc_maxThreads ? requested : qc_maxThreads;
    if (atomic_load(&pool->threadCount) >= requested)
        return true;
    pthread_mutex_lock(&pool->mutex);
    if (!pool->watchesForks)
        pool->watchesForks = pthread_atfork(NULL, NULL, ResetInChild) == 0;
    bool starts = pool->watchesForks && !pool->ending;
    for (uint32_t i = atomic_load(&pool->threadCount); starts && i < requested; i++)
    {
        pool->threads[i] = (Thread){.index = i + 1, .woken = PTHREAD_COND_INITIALIZER, .excludedCore = -1};
        starts = pthread_create(&pool->threads[i].handle, NULL, Serve, &pool->threads[i]) == 0;
        if (starts)
            atomic_store(&pool->threadCount, i + 1);
    }
    bool ending = pool->ending;
    pthread_mutex_unlock(&pool->mutex);
    return !ending;
}

//  ---- the caller ----------------------------------------------------------------------------------------

static bool IsEmpty(const void* context)
{
    const Pool* pool = context;
    return InsideOf(atomic_load(&pool->word)) == 0;
}

/// The threads of a loop of `count` indices are to be awake.
static void ExpectThreads(Pool* pool, uint32_t count)
{
    atomic_store(&pool->callerCore, sched_getcpu());
    atomic_fetch_add(&pool->calls, 1);
    atomic_store(&pool->wakeCount, count);
}

static void Begin(Pool* pool, uint32_t count, qcTask* task, void* taskContext)
{
    pool->task = task;
    pool->taskContext = taskContext;
    atomic_store(&pool->rests, false);
    // A thread that finds the loop open wakes others.
    ExpectThreads(pool, count);
    uint64_t next = (uint64_t)(NumberOf(atomic_load(&pool->word)) + 1) << 32;
    atomic_store(&pool->word, next | (uint64_t)count << 16);
    WakeSome(pool);
}

static void End(Pool* pool, uint32_t count)
{
    atomic_store(&pool->wakeCount, 0);
    atomic_fetch_sub(&pool->word, (uint64_t)count << 16);
    if (qcSpin_Until(IsEmpty, pool, s_maxSpin))
        return;
    pthread_mutex_lock(&pool->mutex);
    atomic_store(&pool->callerSleeps, true);
    while (!IsEmpty(pool))
        pthread_cond_wait(&pool->finished, &pool->mutex);
    atomic_store(&pool->callerSleeps, false);
    pthread_mutex_unlock(&pool->mutex);
}

void qcPool_Run(uint32_t count, qcTask* task, void* taskContext)
{
    Pool* pool = &s_pool;
    count = count <= qc_maxThreads ? count : qc_maxThreads + 1;
    if (count < 2 || atomic_exchange(&pool->busy, true))
    {
        task(0, taskContext);
        return;
    }
    bool own = StartThreads(pool, count - 1);
    if (own)
        Begin(pool, count, task, taskContext);
    task(0, taskContext);
    if (own)
        End(pool, count);
    atomic_store(&pool->busy, false);
}

void qcPool_Wake(uint32_t count)
{
    atomic_store(&s_pool.rests, false);
    ExpectThreads(&s_pool, count);
    WakeSome(&s_pool);
}

void qcPool_Rest(void)
{
    atomic_store(&s_pool.rests, true);
}

bool qcPool_IsAwake(void)
{
    return atomic_load(&s_pool.threadCount) != 0 && !atomic_load(&s_pool.threads[0].sleeps);
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
    uint32_t count = atomic_load(&pool->threadCount);
    for (uint32_t i = 0; i < count; i++)
        pthread_cond_signal(&pool->threads[i].woken);
    atomic_store(&pool->threadCount, 0);
    pthread_mutex_unlock(&pool->mutex);
    for (uint32_t i = 0; i < count; i++)
        pthread_join(pool->threads[i].handle, NULL);
}
