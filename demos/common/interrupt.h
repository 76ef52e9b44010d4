// Ctrl-C as a flag: the program polls it, finishes its step and reports what was done.
//
// Thread-safety: any thread.
#ifndef QC_DEMOS_COMMON_INTERRUPT_H
#define QC_DEMOS_COMMON_INTERRUPT_H

#include "common/exit_status.h"

#ifdef __cplusplus
extern "C" {
#endif

/// From here on the first SIGINT or SIGTERM sets the flag; a second one ends the program. A signal that is ignored
/// (nohup) stays ignored.
void qcInterrupt_Watch(void);

/// The first signal received, or 0.
int qcInterrupt_Signal(void);

/// The exit status of a program that has finished: qc_exitDone, or qc_exitSignal plus the number of the signal.
qcExitStatus qcInterrupt_ExitStatus(void);

#ifdef __cplusplus
}
#endif

#endif
