// Progress of work on standard error: a thread prints until the work ends.
#define _POSIX_C_SOURCE 200809L
#include "common/progress.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

enum
{
    qc_firstMs = 1000,   // quicker work needs no showing
    qc_terminalMs = 100, // smooth enough for the eye
    qc_plainMs = 10000   // a log should stay short
};

static char s_label[128];
static uint64_t s_total;
static _Atomic uint64_t s_done;
static bool s_terminal;
static bool s_running;
static bool s_ended;
static bool s_shown;
static struct timespec s_start;
static pthread_t s_thread;
static pthread_mutex_t s_mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t s_change;

static struct timespec AddMs(struct timespec time, long ms)
{
    time.tv_sec += ms / 1000;
    time.tv_nsec += ms % 1000 * 1000000;
    if (time.tv_nsec >= 1000000000)
    {
        ++time.tv_sec;
        time.tv_nsec -= 1000000000;
    }
    return time;
}

static double GetElapsedSeconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - s_start.tv_sec) + 1e-9 * (double)(now.tv_nsec - s_start.tv_nsec);
}

static void Show(unsigned turn)
{
    char share[32] = "";
    uint64_t done = atomic_load(&s_done);
    if (s_total != 0)
        snprintf(share, sizeof share, " %3.0f %%", 100.0 * (double)(done < s_total ? done : s_total) / (double)s_total);
    // \033[K: erases what a longer line before has left.
    if (s_terminal)
        fprintf(stderr, "\r%c %s%s, %.0f s\033[K", "|/-\\"[turn % 4], s_label, share, GetElapsedSeconds());
    else
        fprintf(stderr, "%s%s, %.0f s\n", s_label, share, GetElapsedSeconds());
    fflush(stderr);
    s_shown = true;
}

static void* ShowUntilEnd(void* unused)
{
    (void)unused;
    struct timespec next = AddMs(s_start, qc_firstMs);
    pthread_mutex_lock(&s_mutex);
    for (unsigned turn = 0; !s_ended; ++turn)
    {
        while (!s_ended && pthread_cond_timedwait(&s_change, &s_mutex, &next) == 0)
            continue;
        if (s_ended)
            break;
        Show(turn);
        next = AddMs(next, s_terminal ? qc_terminalMs : qc_plainMs);
    }
    pthread_mutex_unlock(&s_mutex);
    return NULL;
}

void qcProgress_Begin(uint64_t total, const char* label)
{
    qcProgress_End();
    snprintf(s_label, sizeof s_label, "%s", label);
    s_total = total;
    atomic_store(&s_done, 0);
    const char* terminal = getenv("TERM");
    s_terminal = isatty(STDERR_FILENO) && terminal != NULL && strcmp(terminal, "dumb") != 0;
    s_ended = false;
    s_shown = false;
    clock_gettime(CLOCK_MONOTONIC, &s_start);
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_cond_init(&s_change, &attributes);
    pthread_condattr_destroy(&attributes);
    // Without a thread the work goes on, unseen.
    s_running = pthread_create(&s_thread, NULL, ShowUntilEnd, NULL) == 0;
    if (!s_running)
        pthread_cond_destroy(&s_change);
}

void qcProgress_Update(uint64_t done)
{
    atomic_store(&s_done, done);
}

void qcProgress_End(void)
{
    if (!s_running)
        return;
    pthread_mutex_lock(&s_mutex);
    s_ended = true;
    pthread_cond_signal(&s_change);
    pthread_mutex_unlock(&s_mutex);
    pthread_join(s_thread, NULL);
    pthread_cond_destroy(&s_change);
    s_running = false;
    if (!s_shown)
        return;
    if (s_terminal)
        fprintf(stderr, "\r\033[K");
    else
        fprintf(stderr, "%s: done, %.1f s\n", s_label, GetElapsedSeconds());
}
