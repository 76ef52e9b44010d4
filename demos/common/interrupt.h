// Ctrl-C as a flag: the program polls it, finishes its step and reports what was done.
//
// Thread-safety: any thread.
#ifndef QC_DEMOS_COMMON_INTERRUPT_H
#define QC_DEMOS_COMMON_INTERRUPT_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/// From here on the first SIGINT or SIGTERM sets the flag; a second one ends the program. A signal that is ignored
/// (nohup) stays ignored.
void qcInterrupt_Watch(void);

/// The first signal received, or 0.
int qcInterrupt_Signal(void);

#ifdef __cplusplus
}
#endif

#endif
