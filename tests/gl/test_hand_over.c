// The hand-over between callers and a device's thread, with a thread that has no GL: both ways to wait, sleep and spin.
#define _DEFAULT_SOURCE // usleep, clocks of threads
#include "gl/hand_over.h"
#include "support/suite.h"

#include <stdint.h>
#include <time.h>
#include <unistd.h>

enum
{
    qc_rounds = 2000,
    qc_callers = 4,
    qc_long = 20000 // microseconds: far longer than anything spins
};

typedef struct Server
{
    qcHandOver handOver;
    pthread_t thread;
    pthread_mutex_t callers; ///< held by the caller whose job runs
    int job, result;         ///< guarded by the turns
    useconds_t jobTime;
    int reopened;
} Server;

static void* Serve(void* argument)
{
    Server* server = argument;
    qcHandOver* handOver = &server->handOver;
    qcHandOver_Lock(handOver);
    for (qcTurn turn; (turn = qcHandOver_WaitForWork(handOver)) != qc_turnQuit;)
    {
        qcHandOver_Unlock(handOver);
        if (server->jobTime != 0)
            usleep(server->jobTime);
        server->result = server->job + 1;
        qcHandOver_Lock(handOver);
        server->reopened += turn == qc_turnReopen;
        qcHandOver_Set(handOver, turn == qc_turnReopen ? qc_turnIdle : qc_turnDone);
    }
    qcHandOver_Unlock(handOver);
    return NULL;
}

static void Start(Server* server, bool spins)
{
    *server = (Server){.job = 0};
    pthread_mutex_init(&server->callers, NULL);
    qcHandOver_Init(&server->handOver);
    ck_assert(!server->handOver.spins);
    server->handOver.spins = spins;
    ck_assert_int_eq(pthread_create(&server->thread, NULL, Serve, server), 0);
}

static void Quit(Server* server)
{
    qcHandOver_Lock(&server->handOver);
    qcHandOver_Set(&server->handOver, qc_turnQuit);
    qcHandOver_Unlock(&server->handOver);
    ck_assert_int_eq(pthread_join(server->thread, NULL), 0);
    qcHandOver_Destroy(&server->handOver);
    pthread_mutex_destroy(&server->callers);
}

static void Alert(Server* server)
{
    qcHandOver_Lock(&server->handOver);
    qcHandOver_Alert(&server->handOver);
    qcHandOver_Unlock(&server->handOver);
}

static void Calm(Server* server)
{
    qcHandOver_Lock(&server->handOver);
    qcHandOver_Calm(&server->handOver);
    qcHandOver_Unlock(&server->handOver);
}

static int Run(Server* server, int job)
{
    pthread_mutex_lock(&server->callers);
    qcHandOver_Lock(&server->handOver);
    server->job = job;
    qcHandOver_Set(&server->handOver, qc_turnPosted);
    qcHandOver_WaitForResult(&server->handOver);
    int result = server->result;
    qcHandOver_Unlock(&server->handOver);
    pthread_mutex_unlock(&server->callers);
    return result;
}

/// Processor time of the thread, in milliseconds.
static double ThreadMs(const Server* server)
{
    clockid_t clock;
    struct timespec time;
    ck_assert_int_eq(pthread_getcpuclockid(server->thread, &clock), 0);
    ck_assert_int_eq(clock_gettime(clock, &time), 0);
    return 1e3 * (double)time.tv_sec + 1e-6 * (double)time.tv_nsec;
}

START_TEST(every_job_has_its_result)
{
    for (int spins = 0; spins < 2; spins++)
    {
        Server server;
        Start(&server, spins != 0);
        for (int i = 0; i < qc_rounds; i++)
        {
            if (i % 3 != 0)
                Alert(&server);
            ck_assert_int_eq(Run(&server, i), i + 1);
            if (i % 4 != 0)
                Calm(&server);
        }
        Quit(&server);
    }
}
END_TEST

START_TEST(a_job_that_takes_longer_than_the_caller_spins_has_its_result)
{
    Server server;
    Start(&server, true);
    server.jobTime = qc_long;
    for (int i = 0; i < 3; i++)
        ck_assert_int_eq(Run(&server, i), i + 1);
    Quit(&server);
}
END_TEST

START_TEST(a_job_long_after_the_alert_is_served)
{
    Server server;
    Start(&server, true);
    for (int i = 0; i < 3; i++)
    {
        Alert(&server);
        usleep(qc_long);
        ck_assert_int_eq(Run(&server, i), i + 1);
    }
    Quit(&server);
}
END_TEST

START_TEST(an_alert_without_a_job_ends_by_itself)
{
    Server server;
    Start(&server, true);
    ck_assert_int_eq(Run(&server, 1), 2);
    double before = ThreadMs(&server);
    Alert(&server);
    for (int i = 0; i < 100 && atomic_load(&server.handOver.alert); i++)
        usleep(qc_long);
    ck_assert(!atomic_load(&server.handOver.alert));
    usleep(10 * qc_long);
    // It spins for a millisecond, of two hundred and more.
    ck_assert_double_lt(ThreadMs(&server) - before, 20.0);
    ck_assert_int_eq(Run(&server, 2), 3);
    Quit(&server);
}
END_TEST

START_TEST(nothing_spins_where_it_must_not)
{
    Server server;
    Start(&server, false);
    Alert(&server);
    ck_assert(!atomic_load(&server.handOver.alert));
    ck_assert_int_eq(Run(&server, 1), 2);
    Quit(&server);
}
END_TEST

START_TEST(a_thread_that_spins_is_calmed_quits_and_reopens)
{
    for (int i = 0; i < 200; i++)
    {
        Server server;
        Start(&server, true);
        Alert(&server);
        if (i % 2 != 0)
            usleep((useconds_t)(i % 7) * 50);
        if (i % 3 == 0)
            Calm(&server);
        if (i % 5 == 0)
        {
            qcHandOver_Lock(&server.handOver);
            qcHandOver_Set(&server.handOver, qc_turnReopen);
            qcHandOver_Unlock(&server.handOver);
            bool idle = false;
            while (!idle)
            {
                usleep(10);
                qcHandOver_Lock(&server.handOver);
                idle = qcHandOver_Turn(&server.handOver) == qc_turnIdle;
                ck_assert(!idle || server.reopened == 1);
                qcHandOver_Unlock(&server.handOver);
            }
        }
        Quit(&server);
    }
}
END_TEST

typedef struct Caller
{
    Server* server;
    pthread_t thread;
    int number, wrong;
} Caller;

static void* CallOften(void* argument)
{
    Caller* caller = argument;
    for (int i = 0; i < qc_rounds; i++)
    {
        int job = caller->number * qc_rounds + i;
        if (i % 2 != 0)
            Alert(caller->server);
        caller->wrong += Run(caller->server, job) != job + 1;
        if (i % 3 == 0)
            Calm(caller->server);
    }
    return NULL;
}

START_TEST(many_callers_have_their_own_results)
{
    for (int spins = 0; spins < 2; spins++)
    {
        Server server;
        Start(&server, spins != 0);
        Caller callers[qc_callers];
        for (int i = 0; i < qc_callers; i++)
        {
            callers[i] = (Caller){.server = &server, .number = i};
            ck_assert_int_eq(pthread_create(&callers[i].thread, NULL, CallOften, &callers[i]), 0);
        }
        for (int i = 0; i < qc_callers; i++)
        {
            ck_assert_int_eq(pthread_join(callers[i].thread, NULL), 0);
            ck_assert_int_eq(callers[i].wrong, 0);
        }
        Quit(&server);
    }
}
END_TEST

QC_RUN_TESTS("hand_over", every_job_has_its_result, a_job_that_takes_longer_than_the_caller_spins_has_its_result,
             a_job_long_after_the_alert_is_served, an_alert_without_a_job_ends_by_itself,
             nothing_spins_where_it_must_not, a_thread_that_spins_is_calmed_quits_and_reopens,
             many_callers_have_their_own_results)
