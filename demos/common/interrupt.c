// Ctrl-C as a flag: a handler that keeps the first signal.
#define _POSIX_C_SOURCE 200809L
#define _XOPEN_SOURCE 700
#include "common/interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t s_signal;

static void Keep(int signalNumber)
{
    s_signal = signalNumber;
}

void qcInterrupt_Watch(void)
{
    static const int signals[] = {SIGINT, SIGTERM};
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; ++i)
    {
        struct sigaction old;
        if (sigaction(signals[i], NULL, &old) != 0 || old.sa_handler != SIG_DFL)
            continue;
        // SA_RESETHAND: the second signal ends the program at once.
        struct sigaction action = {.sa_handler = Keep, .sa_flags = (int)(SA_RESETHAND | SA_RESTART)};
        sigemptyset(&action.sa_mask);
        sigaction(signals[i], &action, NULL);
    }
}

int qcInterrupt_Signal(void)
{
    return s_signal;
}

qcExitStatus qcInterrupt_ExitStatus(void)
{
    return s_signal == 0 ? qc_exitDone : (qcExitStatus)((int)qc_exitSignal + s_signal);
}
